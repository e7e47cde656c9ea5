//! A toon sea at a frame, and the simulations shared by frames.

use crate::view::SurfaceHandle;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use trochoid_graph::{Handle, NodeError, Prepare, Prepared, Reference, References};
use trochoid_scene::GridSurface;
use trochoid_sea::toon::{DriftPhases, Simulation, ToonFrame, ToonSea, TrailFields, reference};

const RIFT: TrailFields = TrailFields { rift: true, drift: false };
const DRIFT: TrailFields = TrailFields { rift: false, drift: true };
/// Everything a view can request from the sea.
const ALL: TrailFields = TrailFields { rift: true, drift: true };

/// Trails at a given time, computed on request.
struct Trails {
    sea: ToonSea,
    wanted: TrailFields,
    time: f64,
    /// The simulation shared by all frames, once any frame has requested it.
    shared: Arc<Mutex<Option<Simulation>>>,
}

impl Trails {
    fn at<T>(self, take: impl FnOnce(&ToonFrame<'_>) -> T) -> T {
        let begin = || self.sea.simulate_trails(self.wanted);
        match self.shared.lock() {
            Ok(mut simulation) => take(&simulation.get_or_insert_with(begin).at(self.time)),
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

/// Position of the grid.
pub(crate) struct GridLayout {
    pub(crate) columns: usize,
    pub(crate) spacing: f64,
    pub(crate) origin: [f64; 2],
    pub(crate) level: f64,
}

impl GridLayout {
    fn exact(&self, frame: reference::Reference, scale: f64) -> SurfaceHandle {
        let single = |values: Vec<f64>, scale: f64| values.into_iter().map(|value| (value * scale) as f32).collect();
        let rift = single(frame.rift, 1.0);
        let drift = frame.drift.map(|values| single(values, scale));
        Arc::new(self.grid(single(frame.height, 1.0)).with_trails(|| rift, || drift))
    }

    fn grid(&self, heights: Vec<f32>) -> GridSurface {
        GridSurface::new(heights, self.columns, self.spacing, self.origin, self.level)
    }
}

/// The simulations shared by all frames, kept for the next frame.
struct Simulations {
    heights: Arc<Mutex<Simulation>>,
    /// Simulations of the rift and of the drift, begun when first requested.
    trails: [Arc<Mutex<Option<Simulation>>>; 2],
}

impl Simulations {
    /// Counts an equal share of each simulation for each of its holders, plus the fields taken from it.
    fn bytes(&self) -> usize {
        fn share<T>(held: &Arc<Mutex<T>>, bytes: impl FnOnce(&T) -> usize) -> usize {
            bytes(&held.lock().unwrap_or_else(PoisonError::into_inner)).div_ceil(Arc::strong_count(held))
        }
        let trail = |(held, fields): (_, usize)| {
            share(held, |trail: &Option<Simulation>| {
                trail
                    .as_ref()
                    .map_or(0, |trail| trail.bytes() + fields * trail.sea().basin().cells() * size_of::<f32>())
            })
        };
        share(&self.heights, Simulation::bytes) + self.trails.iter().zip([1, 5]).map(trail).sum::<usize>()
    }
}

pub(crate) struct PreparedToonSea {
    surface: SurfaceHandle,
    sea: ToonSea,
    time: f64,
    layout: GridLayout,
    simulations: Simulations,
    /// The same surface from the f64 simulation, computed when a reference is first requested.
    reference: OnceLock<SurfaceHandle>,
}

impl PreparedToonSea {
    /// Prepares the sea at the frame's time.
    ///
    /// # Errors
    /// The user cancelled.
    pub(crate) fn new(sea: ToonSea, layout: GridLayout, prepare: &Prepare<'_>) -> Result<Self, NodeError> {
        // Frames of one sea share its simulations, so that each takes only the steps since the previous frame. Trails
        // have separate simulations, which begin only when a view requests them.
        let simulation = prepare.shared(&sea, || Ok(Mutex::new(sea.simulate(TrailFields::default()))))?;
        let time = prepare.frame.time;
        let trails = |wanted: TrailFields| {
            let shared = prepare.shared(&(wanted, &sea), || Ok(Mutex::new(None)))?;
            Ok::<_, NodeError>(Trails { sea: sea.clone(), wanted, time, shared })
        };
        let (rift, drift) = (trails(RIFT)?, trails(DRIFT)?);
        let heights = match simulation.lock() {
            Ok(mut simulation) => {
                if !simulation.reach(time, prepare.cancellation()) {
                    return Err(NodeError::Cancelled);
                }
                simulation.at(time).height.to_vec()
            }
            // A panic may have interrupted a step: start again.
            Err(_) => sea.simulate(TrailFields::default()).at(time).height.to_vec(),
        };
        let simulations = Simulations { heights: simulation, trails: [rift.shared.clone(), drift.shared.clone()] };
        let surface: SurfaceHandle =
            Arc::new(layout.grid(heights).with_trails(move || rift.rift(), move || drift.drift()));
        Ok(Self { surface, sea, time, layout, simulations, reference: OnceLock::new() })
    }
}

impl Prepared for PreparedToonSea {
    fn handle(&self) -> Option<Handle> {
        Some(Arc::new(self.surface.clone()))
    }

    fn reference(&self, _inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let surface = self.reference.get_or_init(|| {
            self.layout.exact(reference::frame(&self.sea, self.time, ALL), self.sea.behavior().drift.scale())
        });
        Ok(vec![Reference::Handle(Arc::new(surface.clone()))])
    }

    fn bytes(&self) -> usize {
        self.sea.basin().cells() * size_of::<f32>() + self.simulations.bytes()
    }
}
