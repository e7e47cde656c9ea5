//! Search for the least accurate settings that are certified to meet a tolerance.
//!
//! Convex operations do not amplify errors, so the error bounds of a picture follow from those of its passes. The
//! search starts with the coarsest methods, and raises the accuracy of the passes that limit the picture at its worst
//! pixel. The result depends only on the document, not on the machine.

mod error;
#[cfg(feature = "io")]
mod file;
mod knobs;
mod ladder;
mod pilot;

pub use error::{MissedTolerance, TargetError, Uncertain};
#[cfg(feature = "io")]
pub use file::{NoPlan, PlanFile, PlanFileError};
pub use knobs::AccuracyKnob;
pub use ladder::{
    Attempt, BrokenBound, CertifyTime, EIGHT_BIT, Effort, ErrorAt, ErrorFigures, ErrorSample, ErrorSize, Estimate,
    Ladder, LadderRequest, Limit, LookedAt, PassError, Rung, Saving, Scaling, Shortfall, Times, Unseen, climb,
};
pub use pilot::predict;

use crate::{LoadError, Loaded};
use trochoid_engine::{AccuracyLimit, Buffers, Cache, Certified, Certifier, Monitor, PlanError, Settings};
use trochoid_graph::{CheckedGraph, Kind, NodeId, Tolerance};
use trochoid_image::{Window, WorkingSpace, srgb_encode, srgb_fall};

/// Request for settings.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Outputs that must meet the tolerance.
    pub outputs: &'a [&'a str],
    /// Frame at which settings are sought.
    pub frame: i64,
    /// Tolerance to meet.
    pub tolerance: Tolerance,
    /// Settings of the certification.
    pub settings: &'a Settings,
}

/// Settings that meet a tolerance.
#[derive(Clone, Debug)]
pub struct PlannedSettings {
    /// Assignments `NODE.KNOB=VALUE` for [`load`](crate::load()), as for `--set`.
    pub set: Vec<String>,
    /// Certified errors of the outputs with these settings; empty if nothing was certified, as for
    /// [`Tolerance::Exact`].
    pub certified: Vec<Certified>,
    /// Predicted seconds for rendering the frame, extrapolated from an eighth of it.
    pub predicted: f64,
}

/// Searches for settings; `load` loads the document with additional assignments.
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
///     Request { outputs: &["beauty"], frame: 1, tolerance: Tolerance::Error(0.03), settings: &Settings::default() };
/// let planned = plan(&load, &request, &Silent)?;
/// assert_eq!(planned.set, ["view.points=surface"]);
/// assert!(planned.certified[0].clear.max() <= 0.03 / 12.92);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn plan(
    load: &dyn Fn(&[String]) -> Result<Loaded, LoadError>,
    request: &Request<'_>,
    monitor: &dyn Monitor,
) -> Result<PlannedSettings, TargetError> {
    let graph = load(&[])?.graph;
    let knobs = knobs::find(&graph, request.outputs, request.frame);
    let exact: Vec<usize> = knobs.iter().map(|knob| knob.words.len() - 1).collect();
    let set = |levels: &[usize]| -> Vec<String> {
        knobs.iter().zip(levels).map(|(knob, level)| knob.assignment(*level)).collect()
    };
    let Tolerance::Error(tolerance) = request.tolerance else {
        let set = set(&exact);
        let predicted = predict(&load(&set)?.graph, request.outputs, request.frame, request.settings, monitor)?;
        return Ok(PlannedSettings { set, certified: Vec::new(), predicted });
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
                return Ok(PlannedSettings { set, certified, predicted });
            }
            Outcome::Misses(missed, stage) => {
                if !knobs::raise(&knobs, &mut levels, &graph, stage, request.frame) {
                    // Only the whole picture tells by how much the tolerance is missed.
                    if whole {
                        return Err(TargetError::Missed(missed));
                    }
                    whole = true;
                }
            }
        }
    }
}

/// Returns the largest error in a working space that a display-encoded tolerance allows for all values.
///
/// The sRGB encoding is concave and 0 at 0, so values that differ by e have encodings that differ by at most the
/// encoding of e. A conversion between linear spaces multiplies the error by at most the sum of the absolute factors of
/// a channel.
pub fn allowed(tolerance: f64, space: WorkingSpace) -> f64 {
    let decoded = WorkingSpace::Srgb.to_linear_srgb([tolerance; 3])[0];
    match space {
        WorkingSpace::Srgb => tolerance,
        WorkingSpace::LinearSrgb | WorkingSpace::AcesCg => decoded / growth(space),
    }
}

/// Returns a bound on the errors of displayed values, from 0 to 1, for an error in a working space: the inverse of
/// [`allowed`]. At one value, the sRGB encoding falls by a few 10⁻⁸; so much is added.
pub fn displayed(error: f64, space: WorkingSpace) -> f64 {
    let shown = match space {
        _ if error == 0.0 => 0.0,
        WorkingSpace::Srgb => error,
        WorkingSpace::LinearSrgb | WorkingSpace::AcesCg => {
            srgb_encode((error * growth(space)).min(1.0)) + srgb_fall(0.0, 1.0)
        }
    };
    shown.min(1.0)
}

/// Returns a limit of how much larger an error becomes in linear sRGB.
fn growth(space: WorkingSpace) -> f64 {
    let units = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|unit| space.to_linear_srgb(unit));
    let growth = |channel: usize| units.iter().map(|unit: &[f64; 3]| unit[channel].abs()).sum::<f64>();
    (0..3).map(growth).fold(0.0, f64::max)
}

/// Returns a bound on the errors of an output's displayed values; `None` for kinds that are not displayed.
pub fn displayed_of(kind: Kind, error: f64, space: WorkingSpace) -> Option<f64> {
    match kind {
        Kind::Color => Some(displayed(error, space)),
        Kind::Weights(_) => Some(error.min(1.0)),
        _ => None,
    }
}

/// Returns the largest error in the working space that is allowed for an output; `None` for kinds that are not
/// displayed.
fn allowed_of(kind: Kind, tolerance: f64, space: WorkingSpace) -> Option<f64> {
    match kind {
        Kind::Color => Some(allowed(tolerance, space)),
        Kind::Weights(_) => Some(tolerance),
        _ => None,
    }
}

/// Returns the pass without an error bound, and the reason; of several passes, the most telling one, nearest to the
/// output.
fn unbounded(
    graph: &CheckedGraph,
    all: impl Iterator<Item = (NodeId, &'static str)>,
) -> Option<(NodeId, &'static str)> {
    let made = |id: NodeId| graph.order().iter().position(|other| *other == id);
    all.max_by_key(|(id, _)| made(*id))
}

/// Result of trying settings.
enum Outcome {
    Holds(Vec<Certified>),
    /// The tolerance is missed; also names the pass that limits the worst pixel.
    Misses(Box<MissedTolerance>, Option<NodeId>),
}

struct Trial<'a> {
    graph: &'a CheckedGraph,
    request: &'a Request<'a>,
    tolerance: f64,
    cache: Cache,
    monitor: &'a dyn Monitor,
}

impl Trial<'_> {
    /// Certifies strips of the picture, which reject settings that are too coarse, then the whole picture; only the
    /// latter if `whole` is set.
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

    /// Returns the displayed output with the largest ratio of certified to allowed error, and that ratio.
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
        let unbounded = unbounded(self.graph, certified.unbounded.iter().copied());
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
        let AccuracyLimit { stage, .. } = limiting?;
        let pass = stage.map(|id| {
            let node = self.graph.node(id);
            (node.name.clone(), node.ty.declaration().name)
        });
        let missed = MissedTolerance {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_displayed_is_the_inverse_of_what_is_allowed() {
        for space in [WorkingSpace::Srgb, WorkingSpace::LinearSrgb, WorkingSpace::AcesCg] {
            for tolerance in [1e-4, 1.0 / 255.0, 1.0 / 64.0, 0.3, 1.0] {
                let shown = displayed(allowed(tolerance, space), space);
                assert!((tolerance - shown).abs() < 1e-7, "{space}: {tolerance}, {shown}");
            }
            assert_eq!((displayed(0.0, space), displayed(f64::INFINITY, space)), (0.0, 1.0));
        }
        assert_eq!(displayed_of(Kind::MASK, 0.25, WorkingSpace::LinearSrgb), Some(0.25));
        assert_eq!(displayed_of(Kind::Field(1), 0.25, WorkingSpace::LinearSrgb), None);
    }
}
