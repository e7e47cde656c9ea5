//! A drop as a stamp in the picture.

use super::stamp::{Form, Print, Stamp};
use crate::Projector;
use glam::DVec3;
use trochoid_sea::spray::Droplet;

/// Distances in radii below which a perspective camera begins to fade a drop out, and below which it does not see it
/// at all: a drop that flies past the lens must not fill the picture.
const NEAR: [f64; 2] = [12.0, 4.0];

/// Number of samples that are computed side by side.
pub(super) const LANES: usize = 8;

/// How drops are painted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// Kind of stamps.
    pub stamp: Stamp,
    /// Alpha at the middle of a stamp at birth, 0 to 1.
    pub opacity: f64,
    /// Seconds of motion by which a stamp is stretched.
    pub stretch: f64,
    /// Least radius, in pixels: thinner drops become fainter instead.
    pub least: f64,
    /// Depth in meters over which a drop fades into a surface; 0 gives a hard edge.
    pub soft: f64,
}

impl Default for Brush {
    fn default() -> Self {
        Self { stamp: Stamp::Mixed, opacity: 0.9, stretch: 0.04, least: 0.7, soft: 0.3 }
    }
}

/// The spray that is visible at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpraySample {
    /// Combined coverage of all stamps, 1 − Π(1 − αᵢ).
    pub alpha: f64,
    /// Planar depth of the nearest drop, in meters; +∞ if there is none.
    pub depth: f64,
    /// Mean age of the drops, weighted by their alphas, 0 to 1; 0 if there are none.
    pub age: f64,
    /// Total weight of the drops in that mean, Σ αᵢ.
    pub weight: f64,
}

impl SpraySample {
    /// No drop. Until [`done`](Self::done), `alpha` holds the share left uncovered, and `age` holds Σ αᵢ·ageᵢ.
    pub(super) const NONE: Self = Self { alpha: 1.0, depth: f64::INFINITY, age: 0.0, weight: 0.0 };

    #[inline(always)]
    pub(super) fn add(&mut self, dab: &Dab, alpha: f64) {
        if alpha > 0.0 {
            self.alpha *= 1.0 - alpha;
            self.depth = self.depth.min(dab.depth);
            self.age += alpha * dab.age;
            self.weight += alpha;
        }
    }

    #[inline(always)]
    pub(super) fn done(self) -> Self {
        let age = if self.weight > 0.0 { (self.age / self.weight).min(1.0) } else { 0.0 };
        Self { alpha: 1.0 - self.alpha, age, ..self }
    }
}

/// What [`SpraySample`] holds, at samples side by side.
#[derive(Clone, Copy, Debug)]
pub(super) struct SprayLanes {
    pub(super) alpha: [f64; LANES],
    pub(super) depth: [f64; LANES],
    pub(super) age: [f64; LANES],
    pub(super) weight: [f64; LANES],
}

impl SprayLanes {
    pub(super) const NONE: Self = {
        let SpraySample { alpha, depth, age, weight } = SpraySample::NONE;
        Self { alpha: [alpha; LANES], depth: [depth; LANES], age: [age; LANES], weight: [weight; LANES] }
    };

    /// Adds a stamp where its coverage is more than 0.
    #[inline(always)]
    pub(super) fn add(&mut self, dab: &Dab, alphas: [f64; LANES]) {
        let mut sum = *self;
        for (lane, alpha) in alphas.into_iter().enumerate() {
            let is_added = alpha > 0.0;
            let or = |new: f64, old: f64| if is_added { new } else { old };
            sum.alpha[lane] = or(sum.alpha[lane] * (1.0 - alpha), sum.alpha[lane]);
            sum.depth[lane] = or(sum.depth[lane].min(dab.depth), sum.depth[lane]);
            sum.age[lane] = or(sum.age[lane] + alpha * dab.age, sum.age[lane]);
            sum.weight[lane] = or(sum.weight[lane] + alpha, sum.weight[lane]);
        }
        *self = sum;
    }

    /// Returns the sum at one of the samples.
    pub(super) fn at(&self, lane: usize) -> SpraySample {
        let Self { alpha, depth, age, weight } = self;
        SpraySample { alpha: alpha[lane], depth: depth[lane], age: age[lane], weight: weight[lane] }
    }
}

/// A stamp on the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dab {
    center: [f64; 2],
    /// Bounds of the stamp: left, top, right, bottom.
    pub(super) bounds: [f64; 4],
    /// Vectors along the stamp and across it, per pixel, in halves of its length and width.
    along: [f64; 2],
    across: [f64; 2],
    print: Print,
    /// Alpha at its middle.
    strength: f64,
    depth: f64,
    age: f64,
}

impl Dab {
    /// Makes the stamp of a drop; `None` if the camera cannot see it, even in a larger picture.
    pub(super) fn new(projector: &Projector, drop: &Droplet, brush: &Brush) -> Option<Self> {
        let position = DVec3::from(drop.position);
        let (center, depth) = projector.project(position)?;
        let mut strength = drop.strength * brush.opacity * (1.0 - drop.age);
        let size = if projector.orthographic {
            if depth <= 0.0 {
                return None;
            }
            drop.radius * projector.scale
        } else {
            strength *= ((depth - NEAR[1] * drop.radius) / ((NEAR[0] - NEAR[1]) * drop.radius)).min(1.0);
            drop.radius * projector.scale / depth
        };
        if !(strength > 0.0 && size > 0.0) {
            return None;
        }
        let form = brush.stamp.form(drop);
        let (axis, drawn_out) = match form {
            Form::Disc => ([1.0, 0.0], 0.0),
            Form::Streak | Form::Ragged => motion(projector, position, drop, brush.stretch),
        };
        let width = size.max(brush.least);
        let length = width + drawn_out;
        // Paint that is spread over more pixels than the drop has covers each of them less.
        strength *= size * (size + drawn_out) / (width * length);
        let print = Print::new(form, drop, [length, width]);
        let [dx, dy] = axis;
        let (along, across) = ([dx / length, dy / length], [-dy / width, dx / width]);
        let bounds = bounds(center, axis, [length, width]);
        Some(Self { center, bounds, along, across, print, strength, depth, age: drop.age })
    }

    /// Returns whether a column lies within the stamp's bounds; elsewhere its alpha is 0.
    #[inline(always)]
    pub(super) fn may_meet_column(&self, x: f64) -> bool {
        self.bounds[0] <= x && x <= self.bounds[2]
    }

    /// Returns whether a row does.
    #[inline(always)]
    pub(super) fn may_meet_row(&self, y: f64) -> bool {
        self.bounds[1] <= y && y <= self.bounds[3]
    }

    /// Returns its coverage at a position in front of a surface at a planar depth.
    #[inline(always)]
    pub(super) fn alpha(&self, place: [f64; 2], surface: f64, brush: &Brush) -> f64 {
        let [along, across, inside] = self.within(place);
        if inside <= 0.0 {
            return 0.0;
        }
        let seen = self.seen(surface, brush);
        if seen <= 0.0 {
            return 0.0;
        }
        self.strength * seen * self.print.cover(along, across, inside)
    }

    /// Does the same, with the same bits, at positions side by side; 0 or less where it does not cover.
    #[inline(always)]
    pub(super) fn alphas(&self, x: [f64; LANES], y: f64, surfaces: [f64; LANES], brush: &Brush) -> [f64; LANES] {
        let [mut along, mut across, mut inside] = [[0.0; LANES]; 3];
        for (lane, x) in x.into_iter().enumerate() {
            [along[lane], across[lane], inside[lane]] = self.within([x, y]);
        }
        let seen = surfaces.map(|surface| self.seen(surface, brush));
        let is_bare = |lane: usize| (inside[lane] <= 0.0) | (seen[lane] <= 0.0);
        if (0..LANES).fold(true, |none, lane| none & is_bare(lane)) {
            return [0.0; LANES];
        }
        let cover = self.print.covers(along, across, inside);
        let mut alphas = [0.0; LANES];
        for (lane, to) in alphas.iter_mut().enumerate() {
            let alpha = self.strength * seen[lane] * cover[lane];
            *to = if is_bare(lane) { 0.0 } else { alpha };
        }
        alphas
    }

    /// Returns a position along the stamp and across it, and 1 less the square of its distance from the middle.
    #[inline(always)]
    fn within(&self, place: [f64; 2]) -> [f64; 3] {
        let [x, y] = [place[0] - self.center[0], place[1] - self.center[1]];
        let along = x * self.along[0] + y * self.along[1];
        let across = x * self.across[0] + y * self.across[1];
        [along, across, 1.0 - along * along - across * across]
    }

    /// Returns the share of the drop that is seen in front of a surface.
    #[inline(always)]
    fn seen(&self, surface: f64, brush: &Brush) -> f64 {
        let before = surface - self.depth;
        if brush.soft > 0.0 { (before / brush.soft + 0.5).clamp(0.0, 1.0) } else { f64::from(u8::from(before > 0.0)) }
    }
}

/// Returns the bounds of a stamp of this half length and width along an axis: left, top, right, bottom.
fn bounds([x, y]: [f64; 2], [dx, dy]: [f64; 2], half: [f64; 2]) -> [f64; 4] {
    let reach = |a: f64, b: f64| {
        let (a, b) = (a * half[0], b * half[1]);
        (a * a + b * b).sqrt()
    };
    let (across, down) = (reach(dx, dy), reach(dy, dx));
    [x - across, y - down, x + across, y + down]
}

/// Returns the direction in which a drop crosses the picture, and half the number of pixels that it crosses in
/// `time`.
fn motion(projector: &Projector, position: DVec3, drop: &Droplet, time: f64) -> ([f64; 2], f64) {
    let way = DVec3::from(drop.velocity) * (time / 2.0);
    let (Some((from, _)), Some((to, _))) = (projector.project(position - way), projector.project(position + way))
    else {
        return ([1.0, 0.0], 0.0);
    };
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    let length = (x * x + y * y).sqrt();
    // For shorter motion, the difference of two positions has no reliable direction.
    if length > 1e-6 && length < 1e9 { ([x / length, y / length], length / 2.0) } else { ([1.0, 0.0], 0.0) }
}
