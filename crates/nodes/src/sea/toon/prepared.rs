//! A toon sea at a frame, and the simulations shared by frames.

use super::exact::ExactSea;
use super::kept::KeptRun;
use crate::sea::toon_sea;
use crate::view::SurfaceHandle;
use std::sync::{Arc, Mutex, PoisonError};
use trochoid_graph::{ContentKey, Declare, Handle, Key, NodeError, Prepare, Prepared, Reference, References, Store};
use trochoid_scene::{GridSurface, Number};
use trochoid_sea::toon::{DriftPhases, ToonFrame, ToonSea, TrailFields};

pub(super) const RIFT: TrailFields = TrailFields { rift: true, drift: false };
pub(super) const DRIFT: TrailFields = TrailFields { rift: false, drift: true };

/// Trails at a given time, computed on request.
struct Trails {
    sea: ToonSea,
    wanted: TrailFields,
    time: f64,
    /// The simulation shared by all frames, once any frame has requested it.
    shared: Arc<Mutex<Option<KeptRun>>>,
    store: Option<Arc<dyn Store>>,
}

impl Trails {
    fn at<T>(self, take: impl FnOnce(&ToonFrame<'_>) -> T) -> T {
        let begin = || self.sea.simulate_trails(self.wanted);
        let run = || KeptRun::new(begin(), series(Some(self.wanted), &self.sea), self.store.clone());
        match self.shared.lock() {
            Ok(mut simulation) => {
                let run = simulation.get_or_insert_with(run);
                match run.at(self.time, &|| false) {
                    Some(frame) => take(&frame),
                    None => take(&begin().at(self.time)),
                }
            }
            // A panic may have interrupted a step: start again.
            Err(_) => take(&begin().at(self.time)),
        }
    }

    fn rift(self) -> Vec<f32> {
        self.at(|frame| frame.rift.to_vec())
    }

    fn drift(self) -> [Vec<f32>; 5] {
        let scale = self.sea.behavior().drift.scale() as f32;
        self.at(|frame| {
            let DriftPhases { weight, along, across } = frame.drift;
            [weight, along[0], along[1], across[0], across[1]]
                .map(|values| values.iter().map(|value| value * scale).collect())
        })
    }
}

/// Returns the key of the states of a simulation: of these trails, or of the heights.
fn series(trails: Option<TrailFields>, sea: &ToonSea) -> Key {
    let made_by = (env!("CARGO_PKG_VERSION"), toon_sea::ToonSea::DECLARATION.revision);
    (toon_sea::ToonSea::DECLARATION.name, made_by, (trails.is_some(), trails.unwrap_or_default()), sea).key()
}

/// Position of the grid.
#[derive(Clone, Copy)]
pub(crate) struct GridLayout {
    pub(crate) columns: usize,
    pub(crate) spacing: f64,
    pub(crate) origin: [f64; 2],
    pub(crate) level: f64,
}

impl GridLayout {
    pub(super) fn grid<T: Number>(&self, heights: Vec<T>) -> GridSurface<T> {
        GridSurface::new(heights, self.columns, self.spacing, self.origin, self.level)
    }
}

/// The simulations shared by all frames, kept for the next frame.
struct Simulations {
    heights: Arc<Mutex<KeptRun>>,
    /// Simulations of the rift and of the drift, begun when first requested.
    trails: [Arc<Mutex<Option<KeptRun>>>; 2],
}

impl Simulations {
    /// Counts an equal share of each simulation for each of its holders, plus the fields taken from it.
    fn bytes(&self) -> usize {
        fn share<T>(held: &Arc<Mutex<T>>, bytes: impl FnOnce(&T) -> usize) -> usize {
            bytes(&held.lock().unwrap_or_else(PoisonError::into_inner)).div_ceil(Arc::strong_count(held))
        }
        let trail = |(held, fields): (_, usize)| {
            share(held, |trail: &Option<KeptRun>| {
                let trail = trail.as_ref().map(KeptRun::simulation);
                trail.map_or(0, |trail| trail.bytes() + fields * trail.sea().basin().cells() * size_of::<f32>())
            })
        };
        share(&self.heights, |heights| heights.simulation().bytes())
            + self.trails.iter().zip([1, 5]).map(trail).sum::<usize>()
    }
}

pub(crate) struct PreparedToonSea {
    surface: SurfaceHandle,
    cells: usize,
    simulations: Simulations,
    /// The f64 runs from which references take their surface.
    exact: Arc<ExactSea>,
}

impl PreparedToonSea {
    /// Prepares the sea at the frame's time.
    ///
    /// # Errors
    /// The user cancelled.
    pub(crate) fn new(sea: ToonSea, layout: GridLayout, prepare: &Prepare<'_>) -> Result<Self, NodeError> {
        // Frames of one sea share its simulations, so that each takes only the steps since the previous frame. Trails
        // have separate simulations, which begin only when a view requests them.
        let begin = || KeptRun::new(sea.simulate(TrailFields::default()), series(None, &sea), prepare.store());
        let simulation = prepare.shared(&sea, || Ok(Mutex::new(begin())))?;
        let time = prepare.frame.time;
        let trails = |wanted: TrailFields| {
            let shared = prepare.shared(&(wanted, &sea), || Ok(Mutex::new(None)))?;
            Ok::<_, NodeError>(Trails { sea: sea.clone(), wanted, time, shared, store: prepare.store() })
        };
        let (rift, drift) = (trails(RIFT)?, trails(DRIFT)?);
        let heights = match simulation.lock() {
            Ok(mut simulation) => {
                let frame = simulation.at(time, prepare.cancellation()).ok_or(NodeError::Cancelled)?;
                frame.height.to_vec()
            }
            // A panic may have interrupted a step: start again.
            Err(_) => sea.simulate(TrailFields::default()).at(time).height.to_vec(),
        };
        let simulations = Simulations { heights: simulation, trails: [rift.shared.clone(), drift.shared.clone()] };
        let exact = Arc::new(ExactSea::new(&sea, layout, prepare)?);
        let make = exact.clone();
        let surface = layout.grid(heights).with_trails(move || rift.rift(), move || drift.drift());
        let surface = surface.with_exact(move |wanted, stop| make.surface(wanted, stop));
        Ok(Self { surface: Arc::new(surface), cells: sea.basin().cells(), simulations, exact })
    }
}

impl Prepared for PreparedToonSea {
    fn handle(&self) -> Option<Handle> {
        Some(Arc::new(self.surface.clone()))
    }

    fn reference(&self, _inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Handle(Arc::new(self.surface.clone()))])
    }

    fn bytes(&self) -> usize {
        self.cells * size_of::<f32>() + self.simulations.bytes() + self.exact.bytes()
    }
}
