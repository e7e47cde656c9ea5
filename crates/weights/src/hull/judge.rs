//! Counts the pixels outside of a hull.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

use super::nearness::Nearness;
use super::screen::{BLOCK, Bounds, Groups, Pixels, TOGETHER, failing_pixels};
use super::vector::{Point, along, length, sub};
use super::{EVALUATION, Facet, Hull};
use trochoid_memory::Scratch;

/// Number of undecided pixels in a block from which on they are judged in f64 at once rather than collected.
const MANY_LEFT: u32 = 24;

/// Number of projections that are tried before the exact distance is computed.
const PROJECTIONS: usize = 8;

impl Hull {
    /// Returns the distance of a pixel from the hull if it exceeds the margin (≥ 0), else `None`.
    ///
    /// A pixel that is not finite is an exit at distance +∞, and so is every pixel if the hull is empty.
    #[must_use]
    pub fn exit(&self, pixel: &[f32; 3], margin: f64) -> Option<f64> {
        let point = pixel.map(f64::from);
        let Some((_, excess, projection)) = self.project(point) else {
            return Some(f64::INFINITY);
        };
        if excess <= 0.0 {
            return None;
        }
        // The excess is the distance if the projection onto the worst plane is in the hull, else a lower bound of it.
        if excess <= margin && self.reachable(point, projection, margin) {
            return None;
        }
        let distance = if self.holds(projection) { excess } else { length(sub(point, self.nearest_on_edges(point))) };
        (distance > margin).then_some(distance)
    }

    /// Whether repeated projection onto the worst plane ends in the hull within the margin.
    ///
    /// Any point of the hull within the margin proves that the distance is no larger, so this only avoids the search
    /// for the nearest point. It rarely takes more steps than there are planes at an edge.
    fn reachable(&self, point: Point, projection: Point, margin: f64) -> bool {
        let slack = EVALUATION * self.largest;
        let mut reached = projection;
        for _ in 0..PROJECTIONS {
            let Some((facet, excess)) = self.worst_facet(reached) else {
                return false;
            };
            if excess <= slack {
                return length(sub(point, reached)) <= margin;
            }
            reached = along(reached, -excess, facet.normal);
        }
        false
    }

    /// Counts the pixels of a row that are outside by more than the margin (≥ 0), and returns the count and the
    /// largest distance (0 if the count is 0). The verdicts are those of [`exit`](Hull::exit), in a nanosecond or
    /// less for most pixels.
    ///
    /// # Panics
    ///
    /// If the three channels differ in length.
    #[must_use]
    pub fn exits(&self, r: &[f32], g: &[f32], b: &[f32], margin: f64) -> (u64, f64) {
        assert!(r.len() == g.len() && g.len() == b.len(), "channels of equal length");
        if self.planes.is_empty() {
            return if r.is_empty() { (0, 0.0) } else { (r.len() as u64, f64::INFINITY) };
        }
        let mut sieve = Sieve::new(self, margin);
        let level = Level::new();
        dispatch!(level, simd => sieve.row(simd, [r, g, b]));
        (sieve.count, sieve.worst)
    }
}

/// Judges pixels in blocks: screens pass most of them, the rest is tested in f64, and pixels that remain are judged
/// one by one.
struct Sieve<'h> {
    hull: &'h Hull,
    margin: f64,
    /// For each plane, an excess up to which the distance is certainly within the margin. Made on first use, like the
    /// planes of each screen.
    allowed_excess: Scratch<f64>,
    groups: Scratch<Groups>,
    /// Pixels that wait for each stage: the screens, and f64 last.
    waiting: Scratch<([[f32; BLOCK]; 3], usize)>,
    planes: Scratch<[f32; 4]>,
    count: u64,
    worst: f64,
}

impl<'h> Sieve<'h> {
    fn new(hull: &'h Hull, margin: f64) -> Self {
        let waiting = Scratch::of(([[0.0; BLOCK]; 3], 0), hull.screens.len() + 1);
        let groups = Scratch::of(Groups::new(), hull.screens.len());
        let (allowed_excess, planes) = (Scratch::new(), Scratch::new());
        Self { hull, margin, allowed_excess, groups, waiting, planes, count: 0, worst: 0.0 }
    }

    /// Makes the planes or bounds of a stage.
    fn prepare(&mut self, stage: usize) {
        let Some(screen) = self.hull.screens.get(stage) else {
            if self.allowed_excess.is_empty() {
                // Without screens, the bounds on rounding do not hold either.
                let known = !self.hull.screens.is_empty();
                let near =
                    |nearness: &Nearness| if known { nearness.excess(self.margin, self.hull.largest) } else { 0.0 };
                self.allowed_excess = self.hull.nearness.iter().map(near).collect();
            }
            return;
        };
        if self.groups[stage].is_empty() {
            // No plane of the hull is farther from a pixel than the inner polytope is.
            let whole = self.hull.screens.last().filter(|_| stage + 1 < self.hull.screens.len());
            self.groups[stage] = screen.groups(whole.map_or(self.margin, |whole| whole.safe_excess(self.margin)));
        }
    }

    fn row<S: Simd>(&mut self, simd: S, channels: [&[f32]; 3]) {
        let length = channels[0].len();
        for start in (0..length).step_by(BLOCK) {
            let count = BLOCK.min(length - start);
            let channels = channels.map(|channel| &channel[start..start + count]);
            let [r, g, b] = channels;
            if let (Ok(r), Ok(g), Ok(b)) = (r.try_into(), g.try_into(), b.try_into()) {
                self.block(simd, 0, [r, g, b], count);
                continue;
            }
            let mut block = [[0.0; BLOCK]; 3];
            for (block, channel) in block.iter_mut().zip(channels) {
                block[..count].copy_from_slice(channel);
            }
            self.block(simd, 0, filled(&mut block, count), count);
        }
        for stage in 0..self.waiting.len() {
            self.flush(simd, stage);
        }
    }

    /// Judges the first `count` pixels of a block, which is padded with one of them.
    fn block<S: Simd>(&mut self, simd: S, stage: usize, block: Pixels<'_>, count: usize) {
        let hull = self.hull;
        self.prepare(stage);
        let all = if count < BLOCK { (1 << count) - 1 } else { u128::MAX };
        let Some(screen) = hull.screens.get(stage) else {
            return self.exactly(simd, block, all);
        };
        let bounds = Bounds::of(simd, block);
        if !screen.covers_box(&bounds) {
            // Pixels that the screen does not cover are judged here, and replaced by a vertex, which passes.
            let mut covered = block.map(|channel| *channel);
            for x in 0..count {
                let pixel = block.map(|channel| channel[x]);
                if !screen.covers(&pixel) {
                    if pixel.iter().all(|v| v.is_finite()) {
                        self.judge(&pixel);
                    } else {
                        self.count += 1;
                        self.worst = f64::INFINITY;
                    }
                    for (channel, v) in covered.iter_mut().zip(hull.vertices[0]) {
                        channel[x] = v;
                    }
                }
            }
            return self.block(simd, stage, filled(&mut covered, count), count);
        }
        let beyond = failing_pixels(simd, &self.groups[stage], block, &bounds, &mut self.planes);
        let mut left = beyond & all;
        if left == 0 {
            return;
        }
        if stage + 1 == hull.screens.len() && left.count_ones() >= MANY_LEFT {
            self.prepare(stage + 1);
            return self.exactly(simd, block, left);
        }
        if self.waiting[stage + 1].1 + left.count_ones() as usize > BLOCK {
            self.flush(simd, stage + 1);
        }
        let (waiting, filled) = &mut self.waiting[stage + 1];
        while left != 0 {
            let x = left.trailing_zeros() as usize;
            for (to, from) in waiting.iter_mut().zip(block) {
                to[*filled] = from[x];
            }
            *filled += 1;
            left &= left - 1;
        }
    }

    /// Judges some pixels of a block, given as bits, in f64.
    fn exactly<S: Simd>(&mut self, simd: S, block: Pixels<'_>, pixels: u128) {
        let mut left = pixels & !passing_pixels(simd, &self.hull.planes, &self.allowed_excess, block);
        while left != 0 {
            let x = left.trailing_zeros() as usize;
            self.judge(&block.map(|channel| channel[x]));
            left &= left - 1;
        }
    }

    /// Judges the pixels that wait for a stage.
    fn flush<S: Simd>(&mut self, simd: S, stage: usize) {
        let (waiting, filled) = &mut self.waiting[stage];
        let count = std::mem::take(filled);
        if count > 0 {
            let mut block = *waiting;
            self.block(simd, stage, self::filled(&mut block, count), count);
        }
    }

    fn judge(&mut self, pixel: &[f32; 3]) {
        if let Some(distance) = self.hull.exit(pixel, self.margin) {
            self.count += 1;
            self.worst = self.worst.max(distance);
        }
    }
}

/// Pads a block with its first pixel, which does not enlarge its bounding box.
fn filled(block: &mut [[f32; BLOCK]; 3], count: usize) -> Pixels<'_> {
    for channel in &mut *block {
        let first = channel[0];
        channel[count..].fill(first);
    }
    block.each_ref()
}

/// Returns the pixels of a block, as bits, that exceed no plane by more than `allowed_excess`. Never includes pixels
/// that are not finite.
///
/// The excess is computed like in [`Hull::exit`], so that an allowed excess of 0 is exact.
fn passing_pixels<S: Simd>(simd: S, planes: &[Facet], allowed_excess: &[f64], block: Pixels<'_>) -> u128 {
    simd.vectorize(
        #[inline(always)]
        || {
            let mut wide = [[0.0; BLOCK]; 3];
            for c in 0..3 {
                for x in 0..BLOCK {
                    wide[c][x] = f64::from(block[c][x]);
                }
            }
            let mut found = 0_u128;
            for start in (0..BLOCK).step_by(TOGETHER * S::f64s::LEN) {
                let zero = S::f64s::splat(simd, 0.0);
                let (mut red, mut green, mut blue) = ([zero; TOGETHER], [zero; TOGETHER], [zero; TOGETHER]);
                for i in 0..TOGETHER {
                    let from = start + i * S::f64s::LEN;
                    let lanes = from..from + S::f64s::LEN;
                    red[i] = S::f64s::from_slice(simd, &wide[0][lanes.clone()]);
                    green[i] = S::f64s::from_slice(simd, &wide[1][lanes.clone()]);
                    blue[i] = S::f64s::from_slice(simd, &wide[2][lanes]);
                }
                let mut largest = [S::f64s::splat(simd, f64::NEG_INFINITY); TOGETHER];
                for (&Facet { normal: [x, y, z], offset }, &allowed) in planes.iter().zip(allowed_excess) {
                    for i in 0..TOGETHER {
                        // If it is 0, the same operations as in `Facet::excess`, in the same order.
                        let excess = red[i] * x + green[i] * y + blue[i] * z - (offset + allowed);
                        largest[i] = largest[i].max(excess);
                    }
                }
                for i in 0..TOGETHER {
                    // 0 for finite coordinates, else NaN.
                    let finite = red[i] * 0.0 + green[i] * 0.0 + blue[i] * 0.0;
                    let within = (largest[i] + finite).simd_le(0.0).to_bitmask();
                    found |= u128::from(within) << (start + i * S::f64s::LEN);
                }
            }
            found
        },
    )
}
