//! The surface of a toon sea that references see: that of a run in f64.

use super::GridLayout;
use super::prepared::{DRIFT, RIFT};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use trochoid_graph::{Channel, ChannelSet, NodeError, Prepare};
use trochoid_scene::{GridDoubt, GridSurface};
use trochoid_sea::toon::reference::{Reference, Run};
use trochoid_sea::toon::{ToonSea, TrailFields};

/// Runs of a sea in f64, which frames share, and the surface at one frame. Nothing runs before it is requested.
pub(super) struct ExactSea {
    sea: ToonSea,
    layout: GridLayout,
    time: f64,
    /// Runs of the heights, of the rift, and of the coordinates of drift lines.
    runs: [Arc<Mutex<Option<Run>>>; 3],
    made: Mutex<Option<Made>>,
}

/// A surface, which trails it has, and the doubt of its heights.
struct Made {
    trails: TrailFields,
    heights: f64,
    surface: Arc<GridSurface<f64>>,
}

fn locked<T>(held: &Mutex<Option<T>>) -> MutexGuard<'_, Option<T>> {
    held.lock().unwrap_or_else(|poisoned| {
        // A panic may have interrupted a step: start again.
        let mut held = PoisonError::into_inner(poisoned);
        *held = None;
        held
    })
}

impl ExactSea {
    /// Makes the runs of a sea, at the frame's time.
    ///
    /// # Errors
    /// Never; the pool passes on errors of what it makes.
    pub(super) fn new(sea: &ToonSea, layout: GridLayout, prepare: &Prepare<'_>) -> Result<Self, NodeError> {
        let shared = |part: u8| prepare.shared(&("exact", part, sea), || Ok(Mutex::new(None)));
        let runs = [shared(0)?, shared(1)?, shared(2)?];
        Ok(Self { sea: sea.clone(), layout, time: prepare.frame.time, runs, made: Mutex::default() })
    }

    /// Returns the surface with at least the trails among some channels; `None` soon after `stop` says that it is no
    /// longer needed.
    pub(super) fn surface(
        &self,
        wanted: ChannelSet,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Arc<GridSurface<f64>>> {
        let mut made = locked(&self.made);
        let [rift, drift @ ..] = Channel::TRAILS;
        let had = made.as_ref().map_or(TrailFields::default(), |made| made.trails);
        let trails = TrailFields {
            rift: had.rift || wanted.contains(rift),
            drift: had.drift || drift.iter().any(|channel| wanted.contains(*channel)),
        };
        if let Some(made) = made.as_ref().filter(|made| made.trails == trails) {
            return Some(made.surface.clone());
        }
        let run = |part: usize, heights: bool, fields: TrailFields| {
            let mut run = locked(&self.runs[part]);
            let run = run.get_or_insert_with(|| Run::new(&self.sea, heights, fields));
            run.reach(self.time, stop).then(|| run.at(self.time))
        };
        let (bare, heights) = match &*made {
            // Other trails do not change the heights.
            Some(made) => (GridSurface::clone(&made.surface), made.heights),
            None => {
                let Reference { height, doubt, .. } = run(0, true, TrailFields::default())?;
                (self.layout.grid(height), doubt.height)
            }
        };
        let scale = self.sea.behavior().drift.scale();
        let mut doubt = GridDoubt { height: heights, ..GridDoubt::default() };
        let mut rifts = Vec::new();
        if trails.rift {
            let Reference { rift, doubt: of, .. } = run(1, false, RIFT)?;
            (rifts, doubt.trails) = (rift, of.rift);
        }
        let mut drifts: [Vec<f64>; 5] = Default::default();
        if trails.drift {
            let Reference { drift, doubt: of, .. } = run(2, false, DRIFT)?;
            drifts = drift.map(|values| values.into_iter().map(|value| value * scale).collect());
            doubt.trails = doubt.trails.max(of.drift * scale);
        }
        let all = drifts.iter().chain([&rifts]).flatten();
        doubt.largest_trail = all.fold(0.0, |most, value| most.max(value.abs()));
        let surface = Arc::new(bare.with_doubt(doubt).with_trails(move || rifts, move || drifts));
        *made = Some(Made { trails, heights, surface: surface.clone() });
        Some(surface)
    }

    /// Returns the bytes held: an equal share of each run for each of its holders, and the surface.
    pub(super) fn bytes(&self) -> usize {
        let run = |held: &Arc<Mutex<Option<Run>>>| {
            locked(held).as_ref().map_or(0, Run::bytes).div_ceil(Arc::strong_count(held))
        };
        let fields = locked(&self.made)
            .as_ref()
            .map_or(0, |Made { trails, .. }| 1 + usize::from(trails.rift) + 5 * usize::from(trails.drift));
        self.runs.iter().map(run).sum::<usize>() + fields * self.sea.basin().cells() * size_of::<f64>()
    }
}
