//! A rung of a ladder: settings that are certified, measured and timed.

use super::request::LadderRequest;
use super::truth::{Truth, chosen};
use crate::accuracy::predict;
use crate::accuracy::{Request, TargetError};
use std::time::Instant;
use trochoid_engine::{Buffers, Cache, Certified, Certifier, Frame, Monitor, Picture, Plan};
use trochoid_graph::CheckedGraph;
use trochoid_image::Window;

/// Maximum number of runs, and seconds after which no further run starts.
const RUNS: usize = 5;
const PATIENCE: f64 = 8.0;
/// Number of pixels at which the shares of passes in the error are determined.
const PROBES: usize = 24;

/// Statistics of the errors of pixels or samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Largest error.
    pub max: f64,
    /// 99.9th percentile.
    pub p999: f64,
    /// Median.
    pub median: f64,
    /// Root mean square; `NaN` for certified errors, of which only the distribution is known.
    pub rms: f64,
}

/// Settings with their certified and measured errors and their cost.
#[derive(Clone, Debug)]
pub struct Rung {
    /// Assignments `NODE.KNOB=VALUE` of the settings.
    pub set: Vec<String>,
    /// Whether `plan` may choose these settings.
    pub is_method: bool,
    /// Certified errors of samples that are not ambiguous, in units of the working space; `NaN` if all are ambiguous.
    pub certified: Errors,
    /// Share of ambiguous samples.
    pub ambiguous: f64,
    /// Share of ambiguous samples whose error may exceed 1/255.
    pub ambiguous_beyond_8_bit: f64,
    /// Measured errors of pixels without ambiguous samples.
    pub measured: Errors,
    /// Number of pixels with measured errors.
    pub measured_pixels: usize,
    /// Median ratio of certified to measured errors of these pixels, except where one is 0.
    pub ratio: f64,
    /// Number of pixels outside the hull.
    pub hull_exits: u64,
    /// Number of pixels that are NaN.
    pub nan: u64,
    /// Median seconds for the frame.
    pub seconds: f64,
    /// Seconds between the fastest and the slowest run.
    pub spread: f64,
    /// Predicted seconds for the frame.
    pub predicted: f64,
    /// Bytes held by stages and planes.
    pub bytes: usize,
    /// Whether no other settings are both faster and certified to a smaller error.
    pub is_best: bool,
    /// Shares of the passes in the certified error, at chosen pixels without ambiguous samples.
    pub passes: Vec<PassError>,
    /// Largest certified error of the channels of each pixel, row by row; empty unless the whole picture is certified.
    pub map: Vec<f32>,
    /// Picture rendered with the settings.
    pub picture: Picture,
}

/// Share of a pass in the certified error.
#[derive(Clone, Debug, PartialEq)]
pub struct PassError {
    /// Name of the node.
    pub node: String,
    /// Type of the node.
    pub ty: &'static str,
    /// Drop of the bound if the pass has no errors of its own, averaged over pixels.
    pub drop: f64,
}

/// Inputs for measuring a rung.
pub(super) struct RungMeasurement<'a> {
    pub(super) graph: &'a CheckedGraph,
    pub(super) asked: &'a LadderRequest<'a>,
    pub(super) regions: &'a [Window],
    pub(super) truth: &'a Truth,
    pub(super) monitor: &'a dyn Monitor,
}

impl RungMeasurement<'_> {
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
        // If all are ambiguous, 0 would mean that they are exact.
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

    /// Returns the errors of pixels without ambiguous samples, and the median ratio of certified to measured errors.
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

    /// Returns the share of each pass in the bounds.
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

/// Returns the part that contains a pixel, and the index of the pixel in it.
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

/// Evaluates a frame several times without a cache; returns the frame, the median of the seconds, and their spread.
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
