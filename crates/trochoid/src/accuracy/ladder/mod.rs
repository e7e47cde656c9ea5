//! Error against run time: settings from the coarsest to the most accurate, each certified, measured and timed.
//!
//! All settings are looked at at the same pixels: some drawn in equal parts of the picture, from which shares and
//! quantiles of all pixels are estimated; some drawn where settings differ, in equal parts of these pixels sorted by the
//! difference, so that errors that few pixels have are seen; and the pixel at which each of the settings differs most from
//! the most accurate ones. Renders take turns, so that all settings share what else the machine does.

mod apart;
mod budget;
mod errors;
mod limit;
mod looked;
mod passes;
mod request;
mod rung;
mod statistics;
mod strata;
mod turns;
mod work;

pub use errors::{ErrorAt, ErrorFigures, ErrorSample, ErrorSize};
pub use limit::Limit;
pub use passes::PassError;
pub use request::{Effort, LadderRequest};
pub use rung::{BrokenBound, CertifyTime, EIGHT_BIT, Rung};
pub use statistics::Estimate;
pub use turns::Times;
pub use work::{Saving, Scaling};

use super::{Request, TargetError, allowed_of, knobs, pilot};
use crate::{LoadError, Loaded};
use apart::{Apart, place};
use budget::{Budget, Phase};
use limit::limit;
use looked::{Looked, Looking, in_time};
use passes::passes;
use rung::Judgement;
use std::time::Instant;
use trochoid_engine::{Buffers, Cache, Certified, Certifier, Monitor, NodeReport, Picture};
use trochoid_graph::CheckedGraph;
use trochoid_image::{Format, Window};
use turns::{render, unbeaten};
use work::{costly, savings, scalings};

/// Measured settings of an output, with the tolerances that they meet.
#[derive(Clone, Debug)]
pub struct Ladder {
    /// Name of the output.
    pub output: String,
    /// Number of the frame.
    pub frame: i64,
    /// Format of the measured pictures.
    pub format: Format,
    /// Number of threads.
    pub threads: usize,
    /// Seed of the pixels that were drawn.
    pub seed: u64,
    /// Whether bounds of all pixels are known, not only of those that were looked at.
    pub is_whole: bool,
    /// Pixels that were looked at.
    pub looked_at: LookedAt,
    /// Rungs in order of decreasing error, as far as that is known: coarse and fine meshes first, then the more
    /// accurate methods.
    pub rungs: Vec<Rung>,
    /// Result of each tolerance.
    pub attempts: Vec<Attempt>,
    /// Nodes that the output does not need, or parts of their work.
    pub savings: Vec<Saving>,
    /// Run time by the values of knobs that increase work; only of the whole picture.
    pub scalings: Vec<Scaling>,
    /// Number of knobs that increase work.
    pub costly: usize,
    /// Views that see nothing of a surface that they list.
    pub unseen: Vec<Unseen>,
    /// What did not fit into the time.
    pub shortfall: Shortfall,
}

/// Numbers of pixels that were looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LookedAt {
    /// Pixels drawn in the whole picture, one in each of as many equal parts.
    pub picture: usize,
    /// Pixels drawn where settings differ.
    pub apart: usize,
    /// All pixels that were looked at, each once: also those where settings differ most.
    pub all: usize,
    /// Pixels of the picture.
    pub total: usize,
    /// Pixels of the picture where settings differ.
    pub differing: usize,
    /// Pixels that were looked at whose references are given up, because they take more effort than is reasonable: their
    /// errors are not measured.
    pub given_up: usize,
}

/// A view, and nodes of which it shows nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unseen {
    /// Name of the view.
    pub view: String,
    /// Names of the nodes.
    pub nodes: Vec<String>,
}

/// What did not fit into the time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Shortfall {
    /// Settings that were not rendered, and so are no rungs.
    pub settings: Vec<Vec<String>>,
    /// Number of rungs without bounds.
    pub bounds: usize,
    /// Whether no references were evaluated.
    pub references: bool,
    /// Number of rungs without the time of certifying them.
    pub certify: usize,
    /// Whether the errors of passes are unknown.
    pub passes: bool,
}

/// Tolerance, and the settings that meet it.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// Tolerance of displayed values.
    pub tolerance: f64,
    /// Error that the tolerance allows in the working space.
    pub allowed: f64,
    /// Index of the fastest settings that are certified to meet the tolerance, out of those that [`plan`](super::plan)
    /// chooses from; `None` if none do. If only some pixels are certified, the tolerance is met at these.
    pub rung: Option<usize>,
    /// Reason that no settings meet the tolerance.
    pub limit: Option<Limit>,
}

/// Factors for accuracy knobs that are numbers.
const FINENESS: [f64; 4] = [0.25, 0.5, 2.0, 4.0];

/// Number of pixels at which the shares of passes in the error are determined: within a time, and without a limit.
const PROBES: [usize; 2] = [4, 24];

/// Measures an output of a document; `load` loads the document with additional assignments.
///
/// Figures that are no times depend only on the document and on the number of pixels that were looked at
/// ([`LookedAt::picture`]); [`Effort::Pixels`] repeats them.
///
/// # Errors
/// As [`plan`](super::plan), except that a missed tolerance is not an error; or the reference fails.
pub fn climb(
    load: &dyn Fn(&[String]) -> Result<Loaded, LoadError>,
    asked: &LadderRequest<'_>,
    monitor: &dyn Monitor,
) -> Result<Ladder, TargetError> {
    let started = Instant::now();
    climb_by(load, asked, &|| started.elapsed().as_secs_f64(), monitor)
}

/// Does the same by a clock, which returns the seconds that have passed.
fn climb_by(
    load: &dyn Fn(&[String]) -> Result<Loaded, LoadError>,
    asked: &LadderRequest<'_>,
    clock: &(dyn Fn() -> f64 + Sync),
    monitor: &dyn Monitor,
) -> Result<Ladder, TargetError> {
    let sized = |set: &[String]| -> Result<CheckedGraph, LoadError> {
        let graph = load(set)?.graph;
        Ok(match asked.format {
            Some(format) => graph.with_format(format),
            None => graph,
        })
    };
    let document = sized(&[])?;
    let request = &asked.request;
    let named = document.outputs().iter().find(|output| output.name == request.outputs[0]);
    let allows = |tolerance: f64| named.and_then(|output| allowed_of(output.kind, tolerance, document.space()));
    if named.is_some() && allows(1.0).is_none() {
        return Err(TargetError::NothingDisplayed);
    }
    let is_whole = matches!(asked.effort, Effort::Whole(_));
    let mut shortfall = Shortfall::default();
    let (mut settings, mut graphs, mut pictures) = (Vec::new(), Vec::new(), Vec::new());
    let all = self::settings(&document, request);
    let steps = turns::steps(all.len()) + 4 * all.len() + 4;
    let budget = Budget::new(asked.effort, clock, monitor, steps);
    let sets: Result<Vec<CheckedGraph>, LoadError> = all.iter().map(|(set, _)| sized(set)).collect();
    let sets = sets?;
    for ((setting, graph), rendered) in all.into_iter().zip(sets.iter().cloned()).zip(render(&sets, request, &budget)?)
    {
        match rendered {
            Some(rendered) => {
                settings.push(setting);
                graphs.push(graph);
                pictures.push(rendered);
            }
            None => shortfall.settings.push(setting.0),
        }
    }
    let (window, space) = (document.format().window(), document.space());
    let shown: Vec<&Picture> = pictures.iter().filter_map(|rendered| rendered.frame.pictures.first()).collect();
    let apart = Apart::new(&shown, space);
    let nodes = pictures.first().map_or_else(Vec::new, |rendered| rendered.frame.nodes.clone());
    let mut cache = Cache::new();
    let looking = Looking { asked, document: &document, graphs: &graphs, apart: &apart, budget: &budget };
    let looked = looking.look(&mut cache)?;
    let measuring = Measuring { request, graphs: &graphs, looked: &looked, budget: &budget, is_whole };
    let judgement = Judgement { looked: &looked, window, space, apart: &apart.pixels };
    let mut rungs: Vec<Rung> = Vec::new();
    let mut worst = None;
    for (index, (setting, rendered)) in settings.into_iter().zip(pictures).enumerate() {
        let (whole, certify) = measuring.certify(index, &mut cache)?;
        worst = whole.as_ref().and_then(|whole| whole.worst);
        let rung = judgement.rung(index, setting, rendered, whole.as_ref()).ok_or(TargetError::NothingDisplayed)?;
        rungs.push(Rung { certify, ..rung });
        budget.step();
    }
    let errors = |rung: &Rung| rung.certified.as_ref().and_then(|certified| Some(certified.clear_max?.size.display));
    let best = unbeaten(&rungs.iter().map(|rung| (&rung.times, errors(rung))).collect::<Vec<_>>());
    rungs.iter_mut().zip(best).for_each(|(rung, is_best)| rung.is_best = is_best);
    shortfall.bounds = rungs.iter().filter(|rung| rung.certified.is_none()).count();
    shortfall.references = looked.references.is_none();
    shortfall.certify = rungs.iter().filter(|rung| rung.certify.is_none()).count();
    shortfall.passes = !measuring.passes(&mut rungs, window, &mut cache)?;
    let limit = match (graphs.last(), looked.bounds.last(), rungs.last()) {
        (Some(graph), Some(Some(bounds)), Some(rung)) => {
            let clear = rung.certified.as_ref().and_then(|certified| certified.clear_max);
            let worst = worst.or(clear.map(|at| at.pixel));
            Some(limit(graph, request, worst, &bounds.unbounded, &mut cache, &budget.unlimited())?)
        }
        _ => None,
    };
    let attempts = asked.tolerances.iter().map(|tolerance| {
        let allowed = allows(*tolerance)?;
        let rung = fastest(&rungs, allowed);
        let limit = if rung.is_none() { limit.clone() } else { None };
        Some(Attempt { tolerance: *tolerance, allowed, rung, limit })
    });
    let attempts = attempts.collect::<Option<_>>().ok_or(TargetError::NothingDisplayed)?;
    let savings = savings(&document, request, &nodes, is_whole, &budget.unlimited())?;
    budget.step();
    let scalings = if is_whole { scalings(&document, request, &sized, &budget.unlimited())? } else { Vec::new() };
    Ok(Ladder {
        output: request.outputs[0].to_owned(),
        frame: request.frame,
        format: document.format(),
        threads: threads(request.settings.threads),
        seed: asked.seed,
        is_whole,
        looked_at: LookedAt {
            picture: looked.picture.0.len(),
            apart: looked.apart.0.len(),
            all: looked.pixels.len(),
            total: window.area(),
            differing: apart.pixels.len(),
            given_up: looked.given_up(),
        },
        attempts,
        savings,
        scalings,
        costly: costly(&document, request),
        unseen: unseen(&nodes),
        shortfall,
        rungs,
    })
}

/// Work on each of the settings beside looking at pixels.
struct Measuring<'a> {
    request: &'a Request<'a>,
    graphs: &'a [CheckedGraph],
    looked: &'a Looked,
    budget: &'a Budget<'a>,
    is_whole: bool,
}

impl Measuring<'_> {
    /// Certifies the whole picture, if that is wanted, or one strip of it to predict the time.
    fn certify(
        &self,
        index: usize,
        cache: &mut Cache,
    ) -> Result<(Option<Certified>, Option<CertifyTime>), TargetError> {
        let graph = &self.graphs[index];
        let Some(preparing) = self.looked.preparing.filter(|_| self.looked.bounds[index].is_some()) else {
            return Ok((None, None));
        };
        let whole = graph.format().window();
        let strip = pilot::strips(whole)[1];
        let mut settings = self.request.settings.clone();
        settings.region = (!self.is_whole).then_some(strip);
        let deadline = self.budget.until(Phase::Certify);
        let certifier = Certifier::new(graph, self.request.outputs, self.request.frame, &[], &settings)?;
        let started = self.budget.now();
        let found = certifier.certify(&Buffers::new(), cache, &deadline);
        let Some(mut found) = in_time(found, &deadline)? else { return Ok((None, None)) };
        let seconds = self.budget.now() - started;
        let parts = if self.is_whole { 1.0 } else { whole.area() as f64 / strip.area() as f64 };
        let time = CertifyTime { seconds: preparing + parts * seconds, is_predicted: !self.is_whole };
        Ok((self.is_whole.then(|| found.swap_remove(0)), Some(time)))
    }

    /// Determines the passes that errors come from, of rungs that are methods; returns whether there was time for all.
    fn passes(&self, rungs: &mut [Rung], window: Window, cache: &mut Cache) -> Result<bool, TargetError> {
        let deadline = self.budget.until(Phase::Passes);
        let is_limited = self.budget.left(Phase::Passes).is_some();
        let probes = PROBES[usize::from(!is_limited)];
        for (index, rung) in rungs.iter_mut().enumerate() {
            let Some(Some(bounds)) = self.looked.bounds.get(index) else { continue };
            if is_limited && !rung.is_method {
                continue;
            }
            let clear = self.looked.picture.0.iter().filter(|at| bounds.pixels[**at].is_clear);
            let clear: Vec<[i64; 2]> = clear.map(|at| place(window, self.looked.pixels[*at])).take(probes).collect();
            match passes(&self.graphs[index], self.request, &clear, cache, &deadline)? {
                Some(found) => rung.passes = found,
                None => return Ok(false),
            }
            self.budget.step();
        }
        Ok(true)
    }
}

/// Returns the views that see nothing of a surface that they list.
fn unseen(nodes: &[NodeReport]) -> Vec<Unseen> {
    let unseen = nodes.iter().filter(|node| !node.unseen.is_empty());
    unseen.map(|node| Unseen { view: node.name.clone(), nodes: node.unseen.clone() }).collect()
}

/// Returns the fastest settings for a plan whose certified error is allowed.
fn fastest(rungs: &[Rung], allowed: f64) -> Option<usize> {
    let meets = |rung: &Rung| rung.is_method && rung.judged.is_some_and(|judged| judged <= allowed);
    let meets = rungs.iter().enumerate().filter(|(_, rung)| meets(rung));
    meets.min_by(|a, b| a.1.times.median().total_cmp(&b.1.times.median())).map(|(index, _)| index)
}

fn threads(asked: usize) -> usize {
    if asked > 0 { asked } else { std::thread::available_parallelism().map_or(1, usize::from) }
}

/// Returns all settings, coarsest first, and whether a plan may choose them. Finer and coarser meshes may not be
/// chosen, because they change which samples are ambiguous.
fn settings(graph: &CheckedGraph, request: &Request<'_>) -> Vec<(Vec<String>, bool)> {
    let methods = knobs::find(graph, request.outputs, request.frame);
    let at = |level: usize| -> Vec<String> {
        methods.iter().map(|knob| knob.assignment(level.min(knob.words.len() - 1))).collect()
    };
    let numbers = knobs::numbers(graph, request.outputs, request.frame, |knob| knob.accuracy);
    let most = methods.iter().map(|knob| knob.words.len()).max().unwrap_or(1);
    let mut all = Vec::new();
    let scaled = |factor: f64| -> Vec<String> {
        at(0).into_iter().chain(numbers.iter().map(|number| number.assignment(factor))).collect()
    };
    let (coarser, finer): (Vec<f64>, Vec<f64>) = FINENESS.into_iter().partition(|factor| *factor < 1.0);
    all.extend(coarser.into_iter().filter(|_| !numbers.is_empty()).map(|factor| (scaled(factor), false)));
    all.push((at(0), true));
    all.extend(finer.into_iter().filter(|_| !numbers.is_empty()).map(|factor| (scaled(factor), false)));
    all.extend((1..most).map(|level| (at(level), true)));
    all
}

#[cfg(all(test, feature = "sea"))]
mod tests;
