//! DriftLines: lines that trail behind bursts.

use super::check_trails;
use crate::view::{Neighborhood, grown, is_covered, nothing};
use trochoid_graph::*;
use trochoid_image::{Format, Window};
use trochoid_memory::Scratch;
use trochoid_sea::toon::lines::{LinePoint, Lines, density};
use trochoid_sea::toon::{LineMasks, LinePlaces, NearPhase, NearPlace, density_span};

/// A mask of lines along the motion of a toon sea's bursts, tapering with height.
///
/// # Formula
/// Each line covers `thickness` of the line spacing, times four factors: √ of how far the line's end lies above, the
/// freshness of the trail, the agreement of the bursts, and the number of pixels per line spacing. Each factor falls
/// to 0 continuously, so lines appear and vanish only by tapering.
///
/// # Edge cases
/// 0 where nothing is seen and on other surfaces. Every second line ends halfway up, so fewer lines remain where they
/// are thin. Where a burst overtakes another burst's wake, lines taper away until the new burst has renewed them. With
/// `low` above `high`, lines taper downward. Edges are softened over one pixel.
///
/// # Source
/// The drift lines that Dadfar and Welling, 5.1, could not keep whole in turns. Each burst measures the points that it
/// passes along and across its path; lines run where these coordinates do, and bursts agree where theirs are equal.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, output(mask: Kind::MASK = "The lines."))]
pub(crate) struct DriftLines {
    /// View of a toon sea.
    view: One<port::View>,
    /// Direction of the lines: "across" draws lines side by side along the paths; "along" draws them one behind
    /// another, swept back across the paths.
    coordinate: Coordinate,
    /// Height up to which lines have their full thickness.
    #[knob(default = 0.0, range = -1e5..=1e5, unit = "m")]
    low: f64,
    /// Height at which the longest lines end.
    #[knob(default = 2.0, range = -1e5..=1e5, unit = "m")]
    high: f64,
    /// Share of the line spacing that a line covers.
    #[knob(default = 0.6, range = 0.0..=1.0)]
    thickness: f64,
    /// Shift of all lines, in line spacings.
    #[knob(default = 0.0, range = -1e3..=1e3)]
    shift: f64,
    /// Trail weight at which lines reach full thickness; 1 is the middle of a burst.
    #[knob(default = 0.3, range = 1e-3..=10.0)]
    fresh: f64,
    /// Disagreement between bursts, in line spacings, up to which lines keep their thickness; they vanish at twice
    /// this value.
    #[knob(default = 0.5, range = 1e-3..=10.0)]
    spread: f64,
    /// Line spacing at which lines vanish; they have full thickness from twice this value up.
    #[knob(default = 3.0, range = 0.0..=1e3, in_pixels)]
    finest: f64,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Coordinate {
    Across,
    Along,
}

impl Coordinate {
    /// Returns the channels that hold the cosine and sine of the coordinate's phase.
    fn phase(self) -> [Channel; 2] {
        match self {
            Self::Across => [Channel::AcrossCos, Channel::AcrossSin],
            Self::Along => [Channel::AlongCos, Channel::AlongSin],
        }
    }
}

impl Node for DriftLines {
    fn check(&self, check: &mut Check<'_>) {
        check_trails(&self.view, check);
    }
}

impl Stage for DriftLines {
    fn is_costly(&self) -> bool {
        true
    }

    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        let always = [Channel::Coverage, Channel::Height, Channel::DriftWeight];
        ChannelSet::of(&self.coordinate.phase()).union(ChannelSet::of(&always))
    }

    fn regions_of_interest(&self, _port: PortId, window: Window, _format: Format) -> Window {
        grown(window, 1)
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let Self { thickness, low, high, shift, fresh, spread, finest, .. } = *self;
        let lines = Lines { thickness, low, high, shift, fresh, spread, finest, seed: self.seed as u32 };
        let (view, phase) = (self.view.clone(), self.coordinate.phase());
        Ok(Box::new(PreparedDriftLines { view, phase, lines: LineMasks::new(lines) }))
    }
}

struct PreparedDriftLines {
    view: One<port::View>,
    phase: [Channel; 2],
    lines: LineMasks,
}

/// Most places that are collected before their masks are computed.
const TOGETHER: usize = 256;

/// Returns the phase of a sample within the spans of its components, and whether these are clear.
fn near_phase(cos: Span, sin: Span) -> (NearPhase, bool) {
    // The last term is more than what small squares lose.
    let (a, b) = (cos.half(), sin.half());
    let within = if a == 0.0 && b == 0.0 { 0.0 } else { (a * a + b * b).sqrt() * (1.0 + 1e-15) + 1e-150 };
    (NearPhase::new([cos.middle(), sin.middle()], within), cos.clear && sin.clear)
}

/// Planes around a window.
struct Planes<'a> {
    weights: &'a [f32],
    heights: &'a [f32],
    phase: [&'a [f32]; 2],
}

impl PreparedDriftLines {
    /// Fills whole rows, whose neighbors are in the same planes.
    fn fill_rows(&self, window: Window, around: &Neighborhood<'_>, planes: &Planes<'_>, mask: &mut [f32]) {
        let Window { x0, x1, y0, .. } = window;
        let width = window.width();
        let mut spare: [Scratch<f32>; 8] = Default::default();
        for (y, out) in (y0..).zip(mask.chunks_exact_mut(width.max(1))) {
            let [a, b, c, d, e, f, g, h] = &mut spare;
            let [cos, sin] = planes.phase;
            let own = [around.row(cos, y, x0 - 1..x1 + 1, c), around.row(sin, y, x0 - 1..x1 + 1, d)];
            let from = |column: usize| [&own[0][column..column + width], &own[1][column..column + width]];
            let above = [around.row(cos, y - 1, x0..x1, e), around.row(sin, y - 1, x0..x1, f)];
            let below = [around.row(cos, y + 1, x0..x1, g), around.row(sin, y + 1, x0..x1, h)];
            let places = LinePlaces {
                weight: around.row(planes.weights, y, x0..x1, a),
                height: around.row(planes.heights, y, x0..x1, b),
                phase: from(1),
                beside: [[from(0), from(2)], [above, below]],
            };
            self.lines.fill(&places, out);
        }
    }

    /// Fills the pixels that count and at which something may be drawn.
    fn fill_places(
        &self,
        window: Window,
        only: &[bool],
        around: &Neighborhood<'_>,
        planes: &Planes<'_>,
        mask: &mut [f32],
    ) {
        mask.fill(0.0);
        let mut collected = Collected::default();
        for (row, y) in (window.y0..window.y1).enumerate() {
            let start = row * window.width();
            for (index, x) in (start..start + window.width()).zip(window.x0..) {
                if only[index] && !self.lines.hides(planes.weights[around.index(x, y)]) {
                    collected.add(index, [x, y], around, planes);
                    if collected.places.len() == TOGETHER {
                        collected.draw(&self.lines, mask);
                    }
                }
            }
        }
        collected.draw(&self.lines, mask);
    }
}

/// Values at places that are not adjacent.
#[derive(Default)]
struct Collected {
    /// Indices of the places in the mask.
    places: Scratch<usize>,
    weights: Scratch<f32>,
    heights: Scratch<f32>,
    /// Phases of the places, and of those to the left, right, above and below.
    phases: [[Scratch<f32>; 2]; 5],
    masks: Scratch<f32>,
}

impl Collected {
    fn add(&mut self, index: usize, [x, y]: [i64; 2], around: &Neighborhood<'_>, planes: &Planes<'_>) {
        let here = around.index(x, y);
        self.places.push(index);
        self.weights.push(planes.weights[here]);
        self.heights.push(planes.heights[here]);
        let beside = [[x - 1, y], [x + 1, y], [x, y - 1], [x, y + 1]].map(|[x, y]| around.index(x, y));
        for (phases, at) in self.phases.iter_mut().zip([here].into_iter().chain(beside)) {
            for (phase, plane) in phases.iter_mut().zip(planes.phase) {
                phase.push(plane[at]);
            }
        }
    }

    /// Computes the masks of the places, and forgets these.
    fn draw(&mut self, lines: &LineMasks, mask: &mut [f32]) {
        let Self { places, weights, heights, phases, masks } = self;
        masks.resize(places.len(), 0.0);
        let [phase, left, right, above, below] = phases.each_ref().map(|[cos, sin]| [&cos[..], &sin[..]]);
        let beside = [[left, right], [above, below]];
        lines.fill(&LinePlaces { weight: weights, height: heights, phase, beside }, masks);
        for (place, value) in places.iter().zip(masks.iter()) {
            mask[*place] = *value;
        }
        places.clear();
        [weights, heights].into_iter().chain(phases.as_flattened_mut()).for_each(|values| values.clear());
    }
}

impl Prepared for PreparedDriftLines {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        let around = Neighborhood::of(inputs, &self.view);
        let weights = around.whole(Channel::DriftWeight);
        // Without trails there are no lines.
        if weights.iter().all(|weight| *weight == 0.0) {
            mask.fill(0.0);
            return Ok(());
        }
        let planes =
            Planes { weights, heights: around.whole(Channel::Height), phase: self.phase.map(|c| around.whole(c)) };
        match block.only {
            None => self.fill_rows(block.window, &around, &planes, mask),
            Some(only) => self.fill_places(block.window, only, &around, &planes, mask),
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let lines = self.lines.lines();
        let (around, mut pixels) = (Neighborhood::of(bounding.inputs, &self.view), bounding.block.pixels());
        // Each phase, and whether it is clear, once it has been needed: for its own pixel, and for the four beside it.
        let mut phases: Vec<Option<(NearPhase, bool)>> = vec![None; around.area()];
        let coordinates = self.phase.map(|channel| bounding.channel(&self.view, channel));
        let [coverage, weights, heights] = [Channel::Coverage, Channel::DriftWeight, Channel::Height]
            .map(|channel| bounding.channel(&self.view, channel));
        bounding.bound_by(outputs, SoleOutput, 0, |_| {
            let [x, y] = pixels.next().unwrap_or_default();
            let here = around.index(x, y);
            coverage.covered(here, || {
                let (weight, height) = (weights.at(here), heights.at(here));
                if lines.hides(weight.high) || lines.end_before([height.low, height.high]) {
                    return Span::exactly(0.0);
                }
                let mut clear = true;
                let mut phase = |x: i64, y: i64| {
                    let at = around.index(x, y);
                    let near = || near_phase(coordinates[0].at(at), coordinates[1].at(at));
                    let (phase, is_clear) = *phases[at].get_or_insert_with(near);
                    clear &= is_clear;
                    phase
                };
                let own = phase(x, y);
                let beside = [[phase(x - 1, y), phase(x + 1, y)], [phase(x, y - 1), phase(x, y + 1)]];
                let (density, told) = density_span(own, beside);
                let [weights, heights] = [weight, height].map(|span| [span.low, span.high]);
                let ([low, high], smooth) =
                    lines.mask_span(&NearPlace { weight: weights, phase: own, height: heights, density });
                let clear = clear && told && smooth && weight.clear && height.clear;
                Span { low, high, clear: clear || low == high }.within(0.0, 1.0)
            })
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        if !is_covered(inputs, &self.view) {
            return Ok(nothing());
        }
        let phase = |inputs: &References<'_>| self.phase.map(|channel| inputs.view(&self.view, channel));
        let moved = |dx: f64, dy: f64| phase(&inputs.moved(dx, dy));
        let beside = [[moved(-1.0, 0.0), moved(1.0, 0.0)], [moved(0.0, -1.0), moved(0.0, 1.0)]];
        let [weight, height] = [Channel::DriftWeight, Channel::Height].map(|channel| inputs.view(&self.view, channel));
        let here = phase(inputs);
        let place = LinePoint { weight, phase: here, height, density: density(here, beside) };
        Ok(vec![Reference::Mask(self.lines.lines().mask(&place))])
    }
}
