//! Settings from a tolerance: the least accurate methods that are certified to meet it.
//!
//! A back end of convex operations does not let errors of passes grow, so what a picture's errors can be is known from
//! those of its passes. The search goes from the coarsest methods to more accurate ones, and makes those passes more
//! accurate that limit the picture where it is worst. What it finds depends on the document alone, not on the machine.

mod error;
#[cfg(feature = "io")]
mod file;
mod knobs;
mod ladder;
mod pilot;

pub use error::{Missed, TargetError, Uncertain};
#[cfg(feature = "io")]
pub use file::{NoPlan, PlanFile, PlanFileError};
pub use knobs::AccuracyKnob;
pub use ladder::{Attempt, Errors, Ladder, LadderRequest, Limit, PassError, Rung, Saving, Scaling, climb};
pub use pilot::predict;

use crate::{LoadError, Loaded};
use trochoid_engine::{Buffers, Cache, Certified, Certifier, Limiting, Monitor, PlanError, Settings};
use trochoid_graph::{CheckedGraph, Kind, NodeId, Tolerance};
use trochoid_image::{Window, WorkingSpace};

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// The outputs that are to meet it.
    pub outputs: &'a [&'a str],
    /// The frame.
    pub frame: i64,
    /// How accurate they are to be.
    pub tolerance: Tolerance,
    /// How certification runs.
    pub settings: &'a Settings,
}

/// Settings that meet a tolerance.
#[derive(Clone, Debug)]
pub struct Planned {
    /// Assignments `NODE.KNOB=VALUE` for [`load`](crate::load()), as for `--set`.
    pub set: Vec<String>,
    /// What is certain of the outputs with them; empty where nothing was certified, as for [`Tolerance::Exact`].
    pub certified: Vec<Certified>,
    /// Seconds that rendering the frame will take: measured on an eighth of it.
    pub predicted: f64,
}

/// Finds the settings, given how to load the document with assignments beyond its own.
///
/// # Errors
/// See [`TargetError`].
///
#[cfg_attr(feature = "sea", doc = "```")]
#[cfg_attr(not(feature = "sea"), doc = "```ignore")]
/// use trochoid::accuracy::{Request, plan};
/// use trochoid::{Settings, Silent, Tolerance, parse};
///
/// let document = r##"{
///   "trochoid": 1,
///   "format": { "width": 64, "height": 36 },
///   "nodes": {
///     "camera": { "type": "Camera", "position": [0, 6, 30], "target": [0, 2, 0] },
///     "sea": { "type": "GerstnerSea", "count": 20 },
///     "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
///     "fresnel": { "type": "Fresnel", "view": "view" },
///     "water": { "type": "Mix", "a": "#1a2438", "b": "#93b4a6", "weight": "fresnel" }
///   },
///   "outputs": { "beauty": { "color": "water" } }
/// }"##;
/// let load = |set: &[String]| parse("sea.json", document, std::path::Path::new("."), set);
/// let request =
///     Request { outputs: &["beauty"], frame: 1, tolerance: Tolerance::Error(0.01), settings: &Settings::default() };
/// let planned = plan(&load, &request, &Silent)?;
/// assert_eq!(planned.set, ["view.points=surface"]);
/// assert!(planned.certified[0].clear.max() <= 0.01 / 12.92);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn plan(
    load: &dyn Fn(&[String]) -> Result<Loaded, LoadError>,
    request: &Request<'_>,
    monitor: &dyn Monitor,
) -> Result<Planned, TargetError> {
    let graph = load(&[])?.graph;
    let knobs = knobs::find(&graph, request.outputs, request.frame);
    let exact: Vec<usize> = knobs.iter().map(|knob| knob.words.len() - 1).collect();
    let set = |levels: &[usize]| -> Vec<String> {
        knobs.iter().zip(levels).map(|(knob, level)| knob.assignment(*level)).collect()
    };
    let Tolerance::Error(tolerance) = request.tolerance else {
        let set = set(&exact);
        let predicted = predict(&load(&set)?.graph, request.outputs, request.frame, request.settings, monitor)?;
        return Ok(Planned { set, certified: Vec::new(), predicted });
    };
    let mut levels = vec![0; knobs.len()];
    let mut whole = false;
    loop {
        let set = set(&levels);
        let graph = load(&set)?.graph;
        let mut trial = Trial { graph: &graph, request, tolerance, cache: Cache::new(), monitor };
        match trial.run(whole)? {
            Outcome::Holds(certified) => {
                let predicted = predict(&graph, request.outputs, request.frame, request.settings, monitor)?;
                return Ok(Planned { set, certified, predicted });
            }
            Outcome::Misses(missed, stage) => {
                if !knobs::raise(&knobs, &mut levels, &graph, stage, request.frame) {
                    // By how much is known of all of the picture alone.
                    if whole {
                        return Err(TargetError::Missed(missed));
                    }
                    whole = true;
                }
            }
        }
    }
}

/// The largest error that a display-encoded tolerance allows for values of a working space, whatever the values.
///
/// sRGB's encoding is concave and 0 at 0, so what differs by e is encoded to values that differ by no more than encoded e.
/// Between linear spaces a channel's error is at most the sum of the others' by the size of their factors.
pub fn allowed(tolerance: f64, space: WorkingSpace) -> f64 {
    let decoded = WorkingSpace::Srgb.to_linear_srgb([tolerance; 3])[0];
    match space {
        WorkingSpace::Srgb => tolerance,
        WorkingSpace::LinearSrgb => decoded,
        WorkingSpace::AcesCg => {
            let units = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|unit| space.to_linear_srgb(unit));
            let growth = |channel: usize| units.iter().map(|unit: &[f64; 3]| unit[channel].abs()).sum::<f64>();
            decoded / (0..3).map(growth).fold(0.0, f64::max)
        }
    }
}

/// The largest error of an output in the working space; `None` for what is not displayed.
fn allowed_of(kind: Kind, tolerance: f64, space: WorkingSpace) -> Option<f64> {
    match kind {
        Kind::Color => Some(allowed(tolerance, space)),
        Kind::Weights(_) => Some(tolerance),
        _ => None,
    }
}

/// The pass that knows no bound, and why: of several the one nearest to the output, which says most.
fn unbounded(graph: &CheckedGraph, certified: &[Certified]) -> Option<(NodeId, &'static str)> {
    let made = |id: NodeId| graph.order().iter().position(|other| *other == id);
    let all = certified.iter().flat_map(|certified| certified.unbounded.iter().copied());
    all.max_by_key(|(id, _)| made(*id))
}

/// Whether an output meets a tolerance with some settings.
enum Outcome {
    Holds(Vec<Certified>),
    /// It does not, and which pass limits it where it is worst.
    Misses(Box<Missed>, Option<NodeId>),
}

struct Trial<'a> {
    graph: &'a CheckedGraph,
    request: &'a Request<'a>,
    tolerance: f64,
    cache: Cache,
    monitor: &'a dyn Monitor,
}

impl Trial<'_> {
    /// Certifies parts of the picture, which settings that are too coarse do not survive, then all of it; or `whole` at once.
    fn run(&mut self, whole: bool) -> Result<Outcome, TargetError> {
        let parts = pilot::strips(self.graph.format().window()).map(Some);
        for region in parts.into_iter().filter(|_| !whole).chain([None]) {
            let certified = self.certify(region)?;
            if let Some((worst, excess)) = self.worst(&certified)?
                && excess > 1.0
            {
                return self.missed(&certified[worst]);
            }
            if region.is_none() {
                return Ok(Outcome::Holds(certified));
            }
        }
        unreachable!("the last region is the whole picture")
    }

    fn certifier(&self, region: Option<Window>) -> Result<Certifier<'_>, PlanError> {
        let mut settings = self.request.settings.clone();
        settings.region = region;
        Certifier::new(self.graph, self.request.outputs, self.request.frame, &[], &settings)
    }

    fn certify(&mut self, region: Option<Window>) -> Result<Vec<Certified>, TargetError> {
        let mut cache = std::mem::take(&mut self.cache);
        let certified = self.certifier(region)?.certify(&Buffers::new(), &mut cache, self.monitor);
        self.cache = cache;
        Ok(certified?)
    }

    /// The displayed output that is worst, and its largest error over what is allowed.
    fn worst(&self, certified: &[Certified]) -> Result<Option<(usize, f64)>, TargetError> {
        let mut worst: Option<(usize, f64)> = None;
        for (index, certified) in certified.iter().enumerate() {
            let Some(allowed) = self.allowed(certified.kind) else { continue };
            if certified.clear.total() == 0 && certified.window == self.graph.format().window() {
                return Err(self.unknown(certified));
            }
            let excess = certified.clear.max() / allowed;
            if worst.is_none_or(|(_, most)| excess > most) {
                worst = Some((index, excess));
            }
        }
        if worst.is_none() { Err(TargetError::NothingDisplayed) } else { Ok(worst) }
    }

    fn allowed(&self, kind: Kind) -> Option<f64> {
        allowed_of(kind, self.tolerance, self.graph.space())
    }

    fn unknown(&self, certified: &Certified) -> TargetError {
        let output = self.graph.outputs()[certified.output].name.clone();
        let unbounded = unbounded(self.graph, std::slice::from_ref(certified));
        let why = unbounded.map_or(Uncertain::Unseen, |(id, why)| {
            let node = self.graph.node(id);
            Uncertain::NoBound { node: node.name.clone(), ty: node.ty.declaration().name, why }
        });
        TargetError::Unknown { output, why }
    }

    fn missed(&mut self, certified: &Certified) -> Result<Outcome, TargetError> {
        let pixel = certified.worst.unwrap_or([certified.window.x0, certified.window.y0]);
        let mut cache = std::mem::take(&mut self.cache);
        let limiting =
            self.certifier(None)?.limiting(certified.output, pixel, &Buffers::new(), &mut cache, self.monitor);
        self.cache = cache;
        let Limiting { stage, .. } = limiting?;
        let pass = stage.map(|id| {
            let node = self.graph.node(id);
            (node.name.clone(), node.ty.declaration().name)
        });
        let missed = Missed {
            tolerance: self.tolerance,
            allowed: self.allowed(certified.kind).unwrap_or(self.tolerance),
            output: self.graph.outputs()[certified.output].name.clone(),
            certified: certified.clear.max(),
            pixel,
            pass,
        };
        Ok(Outcome::Misses(Box::new(missed), stage))
    }
}
