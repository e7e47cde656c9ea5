//! A stroke: its position and shape, the source of its color, and its coverage.

use super::{Layer, MARGIN, Seed};
use std::f64::consts::TAU;
use trochoid_field::random::draw;

/// Surroundings of a stroke, by pixel. Beyond the picture, the values are those of the nearest pixel.
pub(crate) trait StrokeSurroundings {
    /// Returns whether a pixel lies in the picture.
    fn inside(&self, x: i64, y: i64) -> bool;
    /// Returns the index of the surface; −1 where none is seen.
    fn part(&self, x: i64, y: i64) -> f64;
    /// Returns the depth; +∞ where no surface is seen.
    fn depth(&self, x: i64, y: i64) -> f64;
    /// Returns the direction of the strokes, of any length.
    fn flow(&self, x: i64, y: i64) -> [f64; 2];
    /// Returns the inputs size, density and detail.
    fn shares(&self, x: i64, y: i64) -> [f64; 3];
}

/// Settings shared by the strokes of all layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StrokeSettings {
    /// Largest ratio of two depths that is not an edge.
    pub(crate) step: f64,
    /// Fraction of strokes that ignore edges.
    ignore_edges: f64,
    /// Unit vectors in all directions, in which a stroke looks for surfaces that hide it.
    looks: [[f64; 2]; LOOKS],
}

impl StrokeSettings {
    /// Creates the settings from the smallest jump in depth that is an edge, as a fraction of the depth, and the
    /// fraction of strokes that ignore edges.
    pub(crate) fn new(edge: f64, ignore_edges: f64) -> Self {
        let look = |index: usize| {
            let (sin, cos) = libm::sincos(TAU * index as f64 / LOOKS as f64);
            [cos, sin]
        };
        Self { step: 1.0 + edge, ignore_edges, looks: std::array::from_fn(look) }
    }
}

/// A stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stroke {
    /// Center of the stroke, in pixels from the center of pixel (0, 0).
    pub(crate) at: [f64; 2],
    /// Unit vector along the stroke.
    pub(crate) along: [f64; 2],
    /// Half its length and half its width, in pixels.
    pub(crate) half: [f64; 2],
    /// Sideways displacement of its ends by the bend, in half widths.
    pub(crate) bend: f64,
    pub(crate) opacity: f64,
    pub(crate) bristle: f64,
    /// Phases of its two patterns of bristles.
    pub(crate) hairs: [f64; 2],
    /// Surface it lies on and its depth, if edges cut the stroke.
    pub(crate) edge: Option<(f64, f64)>,
    pub(crate) step: f64,
    /// Pixel whose color it takes.
    pub(crate) source: [i64; 2],
    /// Sort key of the painting order within its layer.
    pub(crate) order: u64,
}

/// Smallest scale, and smallest half width in pixels. A thinner stroke is drawn with this width and less opacity.
const LEAST_SIZE: f64 = 1.0 / 16.0;
const LEAST_HALF_WIDTH: f64 = 0.5;
/// Range of random thresholds over which strokes fade in and out.
const SOFT: f64 = 0.25;
/// Largest bend from the middle of a stroke to its end, in radians.
const MOST_BEND: f64 = 0.6;
/// Number of directions in which a stroke looks for surfaces that hide it.
const LOOKS: usize = 16;
/// Frequencies of the two patterns of bristles: bristles across half a width.
pub(crate) const HAIRS: [f64; 2] = [2.3, 3.9];

/// Returns the area in the picture per stroke, in pixels², where the input `size` has the given value.
#[inline(always)]
pub(crate) fn pixels(layer: &Layer, size: f64) -> f64 {
    let side = (layer.spacing * size.clamp(LEAST_SIZE, 1.0)).max(1.5);
    side * side
}

/// Returns the nearest integer.
#[inline(always)]
fn rounded(x: f64) -> i64 {
    let up = x + 0.5;
    let toward_zero = up as i64;
    toward_zero - i64::from(toward_zero as f64 > up)
}

/// Returns the largest integer that is ≤ `x`.
#[inline(always)]
pub(crate) fn floor(x: f64) -> i64 {
    let toward_zero = x as i64;
    toward_zero - i64::from(toward_zero as f64 > x)
}

/// Returns the smallest integer that is ≥ `x`.
#[inline(always)]
pub(crate) fn ceiling(x: f64) -> i64 {
    -floor(-x)
}

/// Returns a triangle wave with values in [0, 1].
#[inline(always)]
fn hair(x: f64) -> f64 {
    2.0 * (x - libm::floor(x + 0.5)).abs()
}

fn unit([x, y]: [f64; 2]) -> [f64; 2] {
    let length = (x * x + y * y).sqrt();
    if length > 0.0 && length.is_finite() { [x / length, y / length] } else { [1.0, 0.0] }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

impl Stroke {
    /// Creates the stroke of a seed in the patch whose upper left pixel is `pixel`; `None` if it is invisible.
    pub(crate) fn new(
        layer: &Layer,
        settings: &StrokeSettings,
        seed: &Seed,
        pixel: [i64; 2],
        around: &impl StrokeSurroundings,
    ) -> Option<Self> {
        let random = |which: u64| draw(seed.key, which);
        let at = [0, 1].map(|axis| pixel[axis] as f64 + seed.at[axis]);
        let nearest = at.map(rounded);
        let [x, y] = nearest;
        let [size, density, detail] = around.shares(x, y);
        let kept = seed.share * density * layer.density * if layer.is_last { 1.0 } else { 1.0 - detail };
        let there = ((kept * (1.0 + SOFT) - random(2)) / SOFT).clamp(0.0, 1.0);
        if there <= 0.0 {
            return None;
        }
        let size = size.clamp(LEAST_SIZE, 1.0) * (0.6 + 0.4 * there);
        let mut half = [layer.half[0] * (0.5 + 0.5 * random(3)), layer.half[1] * (0.5 + 0.5 * random(4))];
        half = half.map(|half| half * size);
        let thin = (half[1] / LEAST_HALF_WIDTH).min(1.0);
        half[1] = half[1].max(LEAST_HALF_WIDTH);
        let look = half[0].clamp(1.0, MARGIN as f64);
        let (part, depth) = (around.part(x, y), around.depth(x, y));
        // A thin surface may be visible between the corners of the patch.
        if part != seed.part {
            return None;
        }
        let open = Self::open(settings, [x, y], depth, look, around);
        let opacity = layer.opacity * there * thin * open;
        if opacity <= 0.0 {
            return None;
        }
        let flow = unit(around.flow(x, y));
        let beside = |ahead: f64| {
            let there = [0, 1].map(|axis| rounded(at[axis] + ahead * flow[axis]));
            // The flow is that of lines: opposite directions are the same.
            let other = unit(around.flow(there[0], there[1]));
            let turned = flow[0] * other[0] + flow[1] * other[1] < 0.0;
            if turned { -cross(flow, other) } else { cross(flow, other) }
        };
        let turning = 0.5 * (beside(look) - beside(-look)) * half[0] / look;
        let (sin, cos) = libm::sincos(layer.turn * (2.0 * random(5) - 1.0));
        let sign = if random(6) < 0.5 { -1.0 } else { 1.0 };
        let along = [sign * (flow[0] * cos - flow[1] * sin), sign * (flow[0] * sin + flow[1] * cos)];
        let (sin, cos) = libm::sincos(TAU * random(7));
        let far = layer.stray.min(MARGIN as f64) * random(8);
        let mut source = [at[0] + far * cos, at[1] + far * sin].map(rounded);
        let same = |[x, y]: [i64; 2]| {
            around.inside(x, y) && around.part(x, y) == part && near(around.depth(x, y), depth, settings.step)
        };
        let keeps_to_edges = random(9) >= settings.ignore_edges;
        if keeps_to_edges && !same(source) {
            source = nearest;
        }
        Some(Self {
            at,
            along,
            half,
            bend: turning.clamp(-MOST_BEND, MOST_BEND) * half[0] / (2.0 * half[1]) * sign,
            opacity,
            bristle: layer.bristle,
            hairs: [random(10), random(11)],
            edge: keeps_to_edges.then_some((part, depth)),
            step: settings.step,
            source,
            order: seed.key,
        })
    }

    /// Returns the stroke relative to samples that are shifted against those it was found for.
    pub(crate) fn seen_from(&self, shift: [f64; 2]) -> Self {
        Self { at: [self.at[0] - shift[0], self.at[1] - shift[1]], ..*self }
    }

    /// Returns the visibility of a stroke next to nearer surfaces and the picture's border, so that strokes fade
    /// instead of popping.
    fn open(
        settings: &StrokeSettings,
        [x, y]: [i64; 2],
        depth: f64,
        look: f64,
        around: &impl StrokeSurroundings,
    ) -> f64 {
        let hides = |[right, down]: [f64; 2]| {
            let there = [x + rounded(look * right), y + rounded(look * down)];
            let depth_there = around.depth(there[0], there[1]);
            !around.inside(there[0], there[1]) || (depth_there < depth && !near(depth_there, depth, settings.step))
        };
        let hidden = settings.looks.into_iter().filter(|look| hides(*look)).count();
        (1.0 - 2.0 * hidden as f64 / LOOKS as f64).max(0.0)
    }

    /// Returns the coverage of a pixel, given its offset from the stroke's center, its surface and its depth, in f64
    /// and straight from the formula.
    pub(crate) fn covers(&self, [dx, dy]: [f64; 2], part: f64, depth: f64) -> f64 {
        let [cos, sin] = self.along;
        let a = (dx * cos + dy * sin) / self.half[0];
        let b = (dy * cos - dx * sin) / self.half[1] - self.bend * a * a;
        let cut = self.edge.is_some_and(|(own, far)| part != own || !near(depth, far, self.step));
        if a.abs() > 1.0 || b.abs() > 1.0 || cut {
            return 0.0;
        }
        let body = (2.2 * (1.0 - a * a) * (1.0 - b * b)).min(1.0);
        let hair = 0.5 * (hair(HAIRS[0] * b + self.hairs[0]) + hair(HAIRS[1] * b + self.hairs[1]));
        let dry = 1.0 - 0.55 * self.bristle * (1.0 - hair);
        let end = 1.0 - 0.8 * self.bristle * a.max(0.0) * hair;
        self.opacity * body * dry * end
    }
}

/// Returns whether two depths are too close to be an edge.
#[inline(always)]
fn near(a: f64, b: f64, step: f64) -> bool {
    a <= b * step && b <= a * step
}
