//! One rung: settings certified, measured and timed.

use super::request::LadderRequest;
use super::truth::{Truth, chosen};
use crate::accuracy::predict;
use crate::accuracy::{Request, TargetError};
use std::time::Instant;
use trochoid_engine::{Buffers, Cache, Certified, Certifier, Frame, Monitor, Picture, Plan};
use trochoid_graph::CheckedGraph;
use trochoid_image::Window;

/// Runs of each kind, and seconds after which there is no further one.
const RUNS: usize = 5;
const PATIENCE: f64 = 8.0;
/// Pixels at which is found out what makes the errors.
const PROBES: usize = 24;

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
    /// Certified errors of samples in no doubt, in units of the working space; `NaN` where all are in doubt.
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

/// One rung in the making.
pub(super) struct Measuring<'a> {
    pub(super) graph: &'a CheckedGraph,
    pub(super) asked: &'a LadderRequest<'a>,
    pub(super) regions: &'a [Window],
    pub(super) truth: &'a Truth,
    pub(super) monitor: &'a dyn Monitor,
}

impl Measuring<'_> {
    pub(super) fn rung(&self, set: Vec<String>, is_method: bool) -> Result<Rung, TargetError> {
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
        // Where all are in doubt, 0 would say that they are exact.
        let clear = certified.iter().filter(|c| c.clear.total() > 0);
        let most = |of: &dyn Fn(&Certified) -> f64| clear.clone().map(of).fold(f64::NAN, f64::max);
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
pub(super) fn timed(
    graph: &CheckedGraph,
    request: &Request<'_>,
    monitor: &dyn Monitor,
) -> Result<(Frame, f64, f64), TargetError> {
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
