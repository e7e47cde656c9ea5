//! Error against run time: settings side by side, from the coarsest to the most accurate, each certified, measured and timed.

use super::{Request, TargetError, allowed, knobs, pilot, predict};
use crate::{LoadError, Loaded};
use std::collections::BTreeSet;
use std::time::Instant;
use trochoid_engine::{
    Buffers, Cache, Certified, Certifier, EvalError, Frame, Limiting, Monitor, Picture, Plan, ReferenceError,
    ReferenceFrame, State,
};
use trochoid_graph::{CheckedGraph, Item, Knob, Takes};
use trochoid_image::{Format, Window};

/// What is to be measured.
#[derive(Clone, Copy, Debug)]
pub struct LadderRequest<'a> {
    /// Output, frame and how plans run; the tolerance does not count.
    pub request: Request<'a>,
    /// The size at which all is measured, if not the document's.
    pub format: Option<Format>,
    /// How many pixels are held against the f64 reference.
    pub pixels: usize,
    /// Whether all of the picture is certified, or an eighth of it.
    pub whole: bool,
    /// Tolerances to ask for, of displayed values.
    pub tolerances: &'a [f64],
}

/// All that was found.
#[derive(Clone, Debug)]
pub struct Ladder {
    /// The output.
    pub output: String,
    /// The frame.
    pub frame: i64,
    /// The format.
    pub format: Format,
    /// Threads.
    pub threads: usize,
    /// By falling error, as far as that is known: first those of coarse and fine meshes, then the more accurate methods.
    pub rungs: Vec<Rung>,
    /// What became of each tolerance.
    pub attempts: Vec<Attempt>,
    /// Nodes that the output does not need, or parts of their work.
    pub savings: Vec<Saving>,
    /// How run time grows with the work that knobs ask of nodes.
    pub scalings: Vec<Scaling>,
}

/// Errors of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// The largest.
    pub max: f64,
    /// What 99.9 % of them do not pass.
    pub p999: f64,
    /// What half of them do not pass.
    pub median: f64,
    /// Root mean square; of certified errors, which are known by their distribution, `NaN`.
    pub rms: f64,
}

/// Settings, and what they give.
#[derive(Clone, Debug)]
pub struct Rung {
    /// Assignments that make them, `NODE.KNOB=VALUE`.
    pub set: Vec<String>,
    /// Whether `plan` may choose them.
    pub is_method: bool,
    /// Certified errors of samples in no doubt, in units of the working space.
    pub certified: Errors,
    /// The share of samples in doubt, and of those whose error may pass half a step of eight bits.
    pub ambiguous: f64,
    /// The same of those that may be off by more than 1/255.
    pub ambiguous_beyond_8_bit: f64,
    /// Measured errors of pixels in no doubt, and of how many.
    pub measured: Errors,
    /// How many those are.
    pub measured_pixels: usize,
    /// The median of certified over measured errors of these pixels, where neither is 0.
    pub ratio: f64,
    /// Pixels outside the hull.
    pub hull_exits: u64,
    /// Pixels that are not a number.
    pub nan: u64,
    /// Median seconds of the frame.
    pub seconds: f64,
    /// By how many seconds the slowest run differs from the fastest.
    pub spread: f64,
    /// Seconds that were predicted.
    pub predicted: f64,
    /// Bytes that stages and planes held.
    pub bytes: usize,
    /// Whether no other settings are both faster and certified to less.
    pub is_best: bool,
    /// Where the certified error comes from, at chosen pixels in no doubt.
    pub passes: Vec<PassError>,
    /// By pixel, row by row, the largest certified error of its channels; empty unless all is certified.
    pub map: Vec<f32>,
    /// The picture.
    pub picture: Picture,
}

/// What a pass makes of the certified error.
#[derive(Clone, Debug, PartialEq)]
pub struct PassError {
    /// The node.
    pub node: String,
    /// Its type.
    pub ty: &'static str,
    /// By how much the bound falls if it has no errors of its own, on average over pixels.
    pub drop: f64,
}

/// A tolerance, and what it gets.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// Of displayed values.
    pub tolerance: f64,
    /// What it allows in the working space.
    pub allowed: f64,
    /// Index of the settings that meet it; `None` where none do.
    pub rung: Option<usize>,
    /// Where none do, the pass that limits the most accurate settings, with its type; `None` for rounding.
    pub limiting: Option<(String, &'static str)>,
}

/// What is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Saving {
    /// The node.
    pub node: String,
    /// Its type.
    pub ty: &'static str,
    /// Why, or which part of its work.
    pub why: String,
    /// Seconds that it would take; `None` where that was not measured.
    pub seconds: Option<f64>,
}

/// Run time by the value of a knob.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaling {
    /// `NODE.KNOB`.
    pub knob: String,
    /// Value, and median seconds of the frame.
    pub points: Vec<(f64, f64)>,
}

/// Runs of each kind, and seconds after which there is no further one.
const RUNS: usize = 5;
const PATIENCE: f64 = 8.0;
/// What accuracy knobs that are numbers are multiplied by, and knobs with which work grows.
const FINENESS: [f64; 4] = [0.25, 0.5, 2.0, 4.0];
const WORK: [f64; 4] = [0.25, 0.5, 1.0, 2.0];
/// Pixels at which is found out what makes the errors.
const PROBES: usize = 24;

/// Measures an output of a document, given how to load it with assignments beyond its own.
///
/// # Errors
/// As [`plan`](super::plan), except that missing a tolerance is none; or the reference fails.
pub fn climb(
    load: &dyn Fn(&[String]) -> Result<Loaded, LoadError>,
    asked: &LadderRequest<'_>,
    monitor: &dyn Monitor,
) -> Result<Ladder, TargetError> {
    let sized = |set: &[String]| -> Result<CheckedGraph, LoadError> {
        let graph = load(set)?.graph;
        Ok(match asked.format {
            Some(format) => graph.with_format(format),
            None => graph,
        })
    };
    let graph = sized(&[])?;
    let request = &asked.request;
    let window = graph.format().window();
    let regions: Vec<Window> = if asked.whole { vec![window] } else { pilot::strips(window).to_vec() };
    let truth = Truth::new(&graph, asked, &regions, monitor)?;
    let mut rungs = Vec::new();
    for (set, is_method) in settings(&graph, request) {
        let graph = sized(&set)?;
        rungs.push(Measuring { graph: &graph, asked, regions: &regions, truth: &truth, monitor }.rung(set, is_method)?);
    }
    for index in 0..rungs.len() {
        let own = (rungs[index].seconds, rungs[index].certified.max);
        let beats = |other: &Rung| {
            other.seconds <= own.0 && other.certified.max <= own.1 && (other.seconds, other.certified.max) != own
        };
        rungs[index].is_best = !rungs.iter().any(beats);
    }
    let limiting = rungs.last().map(|rung| limiting(&sized(&rung.set)?, request, &regions, monitor)).transpose()?;
    let attempts = asked.tolerances.iter().map(|tolerance| {
        let allowed = allowed(*tolerance, graph.space());
        let rung = rungs.iter().position(|rung| rung.is_method && rung.certified.max <= allowed);
        let limiting = if rung.is_none() { limiting.clone().flatten() } else { None };
        Attempt { tolerance: *tolerance, allowed, rung, limiting }
    });
    let attempts = attempts.collect();
    Ok(Ladder {
        output: request.outputs[0].to_owned(),
        frame: request.frame,
        format: graph.format(),
        threads: threads(request.settings.threads),
        attempts,
        savings: savings(&graph, request, monitor)?,
        scalings: scalings(&graph, request, &sized, monitor)?,
        rungs,
    })
}

fn threads(asked: usize) -> usize {
    if asked > 0 { asked } else { std::thread::available_parallelism().map_or(1, usize::from) }
}

/// All settings, from the coarsest on, and whether they are methods to choose: finer and coarser meshes are not, because they
/// change what is ambiguous.
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

/// Pixels and their true values.
struct Truth {
    pixels: Vec<[i64; 2]>,
    values: Vec<Vec<f64>>,
}

impl Truth {
    fn new(
        graph: &CheckedGraph,
        asked: &LadderRequest<'_>,
        regions: &[Window],
        monitor: &dyn Monitor,
    ) -> Result<Self, TargetError> {
        let request = &asked.request;
        let pixels = chosen(regions, asked.pixels);
        let name = request.outputs[0];
        let mut cache = Cache::new();
        let reference =
            ReferenceFrame::prepared(graph, name, request.frame, &mut cache, monitor).map_err(of_reference)?;
        let mut values = Vec::with_capacity(pixels.len());
        for (index, [x, y]) in pixels.iter().enumerate() {
            if monitor.cancelled() {
                return Err(EvalError::Cancelled.into());
            }
            values.push(reference.pixel(*x, *y)?);
            monitor.progress(index + 1, pixels.len());
        }
        Ok(Self { pixels, values })
    }
}

fn of_reference(error: ReferenceError) -> TargetError {
    match error {
        ReferenceError::Plan(error) => error.into(),
        ReferenceError::Eval(error) => error.into(),
    }
}

/// So many pixels of some windows, each once, spread by the golden section of their number.
fn chosen(regions: &[Window], count: usize) -> Vec<[i64; 2]> {
    let total: usize = regions.iter().map(|region| region.area()).sum();
    let mut places: BTreeSet<usize> = BTreeSet::new();
    let mut step = 0_u64;
    while places.len() < count.min(total) {
        step += 1;
        // Weyl's sequence: fractions of multiples of the golden section.
        let part = (step.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as f64 / 4_294_967_296.0;
        places.insert(((part * total as f64) as usize).min(total - 1));
    }
    let pixel = |mut place: usize| {
        for region in regions {
            if place < region.area() {
                let (x, y) = (place % region.width(), place / region.width());
                return [region.x0 + x as i64, region.y0 + y as i64];
            }
            place -= region.area();
        }
        unreachable!("places lie within the windows")
    };
    places.into_iter().map(pixel).collect()
}

/// One rung in the making.
struct Measuring<'a> {
    graph: &'a CheckedGraph,
    asked: &'a LadderRequest<'a>,
    regions: &'a [Window],
    truth: &'a Truth,
    monitor: &'a dyn Monitor,
}

impl Measuring<'_> {
    fn rung(&self, set: Vec<String>, is_method: bool) -> Result<Rung, TargetError> {
        let (graph, request) = (self.graph, &self.asked.request);
        let predicted = predict(graph, request.outputs, request.frame, request.settings, self.monitor)?;
        let (frame, seconds, spread) = timed(graph, request, self.monitor)?;
        let mut cache = Cache::new();
        let mut certified = Vec::new();
        for region in self.regions {
            let mut settings = request.settings.clone();
            settings.region = Some(*region);
            let certifier = Certifier::new(graph, request.outputs, request.frame, &[], &settings)?;
            certified.extend(certifier.certify(&Buffers::new(), &mut cache, self.monitor)?);
        }
        let passes = self.passes(&certified, &mut cache)?;
        let bytes = frame.nodes.iter().map(|node| node.bytes).sum::<usize>();
        let planes = |picture: &Picture| picture.planes.len() * frame.window.area() * 4;
        let bytes = bytes + frame.pictures.iter().map(planes).sum::<usize>();
        let Some(picture) = frame.pictures.into_iter().next() else { return Err(TargetError::NothingDisplayed) };
        let (measured, ratio) = self.measured(&picture, &certified);
        let measured_pixels = measured.len();
        let sum = |of: &dyn Fn(&Certified) -> u64| certified.iter().map(of).sum::<u64>() as f64;
        let all = sum(&|c| c.clear.total() + c.unclear.total()).max(1.0);
        let most = |of: &dyn Fn(&Certified) -> f64| certified.iter().map(of).fold(0.0, f64::max);
        Ok(Rung {
            set,
            is_method,
            certified: Errors {
                max: most(&|c| c.clear.max()),
                p999: most(&|c| c.clear.quantile(0.999)),
                median: most(&|c| c.clear.quantile(0.5)),
                rms: f64::NAN,
            },
            ambiguous: sum(&|c| c.unclear.total()) / all,
            ambiguous_beyond_8_bit: sum(&|c| c.unclear.above(1.0 / 255.0)) / all,
            measured: errors(measured),
            measured_pixels,
            ratio,
            hull_exits: picture.audit.hull_exits,
            nan: picture.audit.nan_count,
            seconds,
            spread,
            predicted,
            bytes,
            is_best: false,
            passes,
            map: if self.asked.whole { map(&certified[0]) } else { Vec::new() },
            picture,
        })
    }

    /// Errors of pixels in no doubt, and how many times as large they are certified.
    fn measured(&self, picture: &Picture, certified: &[Certified]) -> (Vec<f64>, f64) {
        let (mut errors, mut ratios) = (Vec::new(), Vec::new());
        for ([x, y], truth) in self.truth.pixels.iter().zip(&self.truth.values) {
            let Some((part, index)) = place(certified, [*x, *y]) else { continue };
            if part.doubt[index] > 0.0 {
                continue;
            }
            let (mut error, mut bound) = (0.0_f64, 0.0_f64);
            for (channel, truth) in truth.iter().enumerate() {
                let plane = &picture.planes[channel];
                let at = (y - plane.window().y0) as usize * plane.window().width() + (x - plane.window().x0) as usize;
                error = error.max((f64::from(plane.samples()[at]) - truth).abs());
                bound = bound.max(f64::from(part.errors[channel][index]));
            }
            errors.push(error);
            if error > 0.0 && bound > 0.0 {
                ratios.push(bound / error);
            }
        }
        ratios.sort_by(f64::total_cmp);
        let ratio = ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN);
        (errors, ratio)
    }

    /// What each pass makes of the bounds.
    fn passes(&self, certified: &[Certified], cache: &mut Cache) -> Result<Vec<PassError>, TargetError> {
        let (graph, request) = (self.graph, &self.asked.request);
        let certifier = Certifier::new(graph, request.outputs, request.frame, &[], request.settings)?;
        let clear = |pixel: &[i64; 2]| place(certified, *pixel).is_some_and(|(part, index)| part.doubt[index] == 0.0);
        let probes: Vec<[i64; 2]> = chosen(self.regions, 8 * PROBES).into_iter().filter(clear).collect();
        let step = probes.len().div_ceil(PROBES).max(1);
        let probes: Vec<&[i64; 2]> = probes.iter().step_by(step).collect();
        let mut drops = vec![0.0; graph.nodes().len()];
        for pixel in &probes {
            let (whole, by_stage) =
                certifier.by_stage(certified[0].output, **pixel, &Buffers::new(), cache, self.monitor)?;
            for (stage, without) in by_stage {
                drops[stage.0] += (whole - without).max(0.0) / probes.len() as f64;
            }
        }
        let passes = graph.nodes().iter().zip(drops).filter(|(_, drop)| *drop > 0.0);
        let mut passes: Vec<PassError> = passes
            .map(|(node, drop)| PassError { node: node.name.clone(), ty: node.ty.declaration().name, drop })
            .collect();
        passes.sort_by(|a, b| b.drop.total_cmp(&a.drop));
        Ok(passes)
    }
}

/// Which part has a pixel, and where.
fn place(certified: &[Certified], [x, y]: [i64; 2]) -> Option<(&Certified, usize)> {
    let holds = |window: Window| (window.x0..window.x1).contains(&x) && (window.y0..window.y1).contains(&y);
    let part = certified.iter().find(|part| holds(part.window))?;
    Some((part, (y - part.window.y0) as usize * part.window.width() + (x - part.window.x0) as usize))
}

fn map(certified: &Certified) -> Vec<f32> {
    let most = |index: usize| certified.errors.iter().map(|channel| channel[index]).fold(0.0, f32::max);
    (0..certified.window.area()).map(most).collect()
}

fn errors(mut values: Vec<f64>) -> Errors {
    values.sort_by(f64::total_cmp);
    let count = values.len();
    if count == 0 {
        return Errors { max: f64::NAN, p999: f64::NAN, median: f64::NAN, rms: f64::NAN };
    }
    let at = |share: f64| values[((share * count as f64).ceil() as usize).clamp(1, count) - 1];
    let squares: f64 = values.iter().map(|value| value * value).sum();
    Errors { max: at(1.0), p999: at(0.999), median: at(0.5), rms: (squares / count as f64).sqrt() }
}

/// A frame, the median of its seconds over some runs with nothing kept between them, and how far they differ.
fn timed(graph: &CheckedGraph, request: &Request<'_>, monitor: &dyn Monitor) -> Result<(Frame, f64, f64), TargetError> {
    let plan = Plan::new(graph, request.outputs, request.frame, &[], request.settings)?;
    let (mut seconds, mut found) = (Vec::new(), Frame::default());
    let started = Instant::now();
    while seconds.is_empty() || (seconds.len() < RUNS && started.elapsed().as_secs_f64() < PATIENCE) {
        found = plan.evaluate(&Buffers::new(), &mut Cache::new(), monitor)?;
        seconds.push(found.seconds.prepare + found.seconds.hull + found.seconds.tiles);
    }
    seconds.sort_by(f64::total_cmp);
    let spread = seconds[seconds.len() - 1] - seconds[0];
    Ok((found, seconds[seconds.len() / 2], spread))
}

/// The pass that limits the settings of a graph where they are worst.
fn limiting(
    graph: &CheckedGraph,
    request: &Request<'_>,
    regions: &[Window],
    monitor: &dyn Monitor,
) -> Result<Option<(String, &'static str)>, TargetError> {
    let mut cache = Cache::new();
    let mut worst: Option<(f64, usize, [i64; 2])> = None;
    for region in regions {
        let mut settings = request.settings.clone();
        settings.region = Some(*region);
        let certifier = Certifier::new(graph, request.outputs, request.frame, &[], &settings)?;
        for certified in certifier.certify(&Buffers::new(), &mut cache, monitor)? {
            let max = certified.clear.max();
            if let Some(pixel) = certified.worst.filter(|_| worst.is_none_or(|(most, ..)| max > most)) {
                worst = Some((max, certified.output, pixel));
            }
        }
    }
    let Some((_, output, pixel)) = worst else { return Ok(None) };
    let certifier = Certifier::new(graph, request.outputs, request.frame, &[], request.settings)?;
    let Limiting { stage, .. } = certifier.limiting(output, pixel, &Buffers::new(), &mut cache, monitor)?;
    Ok(stage.map(|id| (graph.node(id).name.clone(), graph.node(id).ty.declaration().name)))
}

/// What is left out of a document as it stands.
fn savings(graph: &CheckedGraph, request: &Request<'_>, monitor: &dyn Monitor) -> Result<Vec<Saving>, TargetError> {
    let costs =
        crate::measure(graph, request.outputs[0], request.frame, u32::MAX, monitor).map_err(|error| match error {
            crate::MeasureError::Plan(error) => TargetError::from(error),
            crate::MeasureError::Evaluate(error) => error.into(),
        })?;
    let plan = Plan::new(graph, request.outputs, request.frame, &[], request.settings)?;
    let mut cache = Cache::new();
    let frame = plan.evaluate(&Buffers::new(), &mut cache, monitor)?;
    let mut savings: Vec<Saving> = Vec::new();
    for (report, cost) in frame.nodes.iter().zip(&costs.nodes) {
        if let State::LeftOut(why) = &report.state {
            let (node, ty, why) = (report.name.clone(), report.ty, why.to_string());
            savings.push(Saving { node, ty, why, seconds: cost.saved() });
        }
    }
    for (id, omissions) in plan.omissions(&mut cache, monitor)? {
        for omission in omissions {
            let node = graph.node(id);
            let why = format!("{:.0} of {:.0} {}: {}", omission.count, omission.of, omission.what, omission.why);
            savings.push(Saving { node: node.name.clone(), ty: node.ty.declaration().name, why, seconds: None });
        }
    }
    Ok(savings)
}

/// Run times by the knobs with which work grows.
fn scalings(
    graph: &CheckedGraph,
    request: &Request<'_>,
    sized: &dyn Fn(&[String]) -> Result<CheckedGraph, LoadError>,
    monitor: &dyn Monitor,
) -> Result<Vec<Scaling>, TargetError> {
    let mut scalings = Vec::new();
    for number in knobs::numbers(graph, request.outputs, request.frame, |knob| knob.scales || knob.accuracy) {
        let mut points: Vec<(f64, f64)> = Vec::new();
        for factor in WORK {
            let value = number.value(factor);
            if points.iter().any(|(known, _)| *known == value) {
                continue;
            }
            // Not every value goes with the document's others.
            let Ok(graph) = sized(&[number.assignment(factor)]) else { continue };
            points.push((value, timed(&graph, request, monitor)?.1));
        }
        scalings.push(Scaling { knob: number.path(), points });
    }
    Ok(scalings)
}

/// A number knob of a node.
pub(super) struct Number {
    node: String,
    knob: &'static str,
    /// Its value in the document.
    at: f64,
    takes: Takes,
}

impl Number {
    pub(super) fn of(
        node: &str,
        item: &Item,
        at: impl Fn(&str) -> f64,
        wanted: &dyn Fn(&Knob) -> bool,
    ) -> Option<Self> {
        match item {
            Item::Knob(knob @ Knob { takes: Takes::Number { .. } | Takes::Integer { .. }, .. }) if wanted(knob) => {
                Some(Self { node: node.to_owned(), knob: knob.name, at: at(knob.name), takes: knob.takes })
            }
            _ => None,
        }
    }

    fn path(&self) -> String {
        format!("{}.{}", self.node, self.knob)
    }

    /// So many times its value, as far as it goes.
    fn value(&self, factor: f64) -> f64 {
        match self.takes {
            Takes::Number { min, max } => (self.at * factor).clamp(min, max),
            Takes::Integer { min, max } => (self.at * factor).round().clamp(min as f64, max as f64),
            _ => self.at,
        }
    }

    fn assignment(&self, factor: f64) -> String {
        format!("{}={}", self.path(), self.value(factor))
    }
}
