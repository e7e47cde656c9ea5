//! Directions of a FlowField for several pixels at once: the operations of those for one pixel, in the same order, with
//! choices by masks.

use super::flow_field::{PreparedFlowField, SHORTEST, SHORTEST_DOUBLED};
use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use trochoid_field::sines_and_cosines;
use trochoid_scene::{DVec3, Projector};

/// Number of pixels whose directions are computed together.
pub(super) const LANES: usize = 8;

/// A component of some pixels' directions to the right, and one down.
pub(super) type Line<S> = [f64x8<S>; 2];
/// Vectors of some pixels, by axis.
type Vector<S> = [f64x8<S>; 3];

/// Returns some values in f64.
#[inline(always)]
fn load<S: Simd>(simd: S, values: &[f32; LANES]) -> f64x8<S> {
    let mut wide = [0.0; LANES];
    for (wide, value) in wide.iter_mut().zip(values) {
        *wide = f64::from(*value);
    }
    f64x8::simd_from(simd, wide)
}

/// Writes values in f32, as many as there is room for.
#[inline(always)]
pub(super) fn store<S: Simd>(values: f64x8<S>, out: &mut [f32]) {
    let mut narrow = [0.0; LANES];
    for (narrow, value) in narrow.iter_mut().zip(values.as_slice()) {
        *narrow = *value as f32;
    }
    if let Some(out) = out.first_chunk_mut() {
        *out = narrow;
    } else {
        out.copy_from_slice(&narrow[..out.len()]);
    }
}

/// Returns the components of one vector or of others.
#[inline(always)]
fn choose<S: Simd>(choice: mask64x8<S>, [x, y]: Line<S>, [u, v]: Line<S>) -> Line<S> {
    [choice.select(x, u), choice.select(y, v)]
}

#[inline(always)]
fn dot<S: Simd>([x, y, z]: Vector<S>, other: DVec3) -> f64x8<S> {
    x * other.x + y * other.y + z * other.z
}

/// Returns unit vectors, and where there are any.
#[inline(always)]
fn units<S: Simd>([x, y]: Line<S>) -> (Line<S>, mask64x8<S>) {
    let length = (x * x + y * y).sqrt();
    ([x / length, y / length], length.simd_gt(SHORTEST) & length.simd_lt(f64::INFINITY))
}

#[inline(always)]
fn turned<S: Simd>([x, y]: Line<S>, (sin, cos): (f64, f64)) -> Line<S> {
    [x * cos - y * sin, x * sin + y * cos]
}

#[inline(always)]
fn doubled<S: Simd>([x, y]: Line<S>) -> Line<S> {
    [x * x - y * y, x * 2.0 * y]
}

/// Inverts [`doubled`]: returns the directions along lines, and the length of the components.
#[inline(always)]
pub(super) fn halves<S: Simd>(simd: S, line: [&[f32; LANES]; 2]) -> [f64x8<S>; 3] {
    let [c, s] = line.map(|along| load(simd, along));
    let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
    let length = (c * c + s * s).sqrt().min(one);
    let cos = (c / length).max(-one).min(one);
    let (x, y) = (((one + cos) / 2.0).sqrt() * length, ((one - cos) / 2.0).sqrt() * length);
    let is_short = length.simd_lt(SHORTEST_DOUBLED);
    let y = s.simd_lt(0.0).select(-y, y);
    [is_short.select(zero, x), is_short.select(zero, y), is_short.select(zero, length)]
}

/// Returns the directions in the picture of world-space directions at some points, and where there are any.
#[inline(always)]
fn projected<S: Simd>(eye: &Projector, offset: Vector<S>, direction: Vector<S>) -> (Line<S>, mask64x8<S>) {
    let along = [dot(direction, eye.right), -dot(direction, eye.up)];
    if eye.orthographic {
        return units(along);
    }
    let (depth, deeper) = (dot(offset, eye.forward), dot(direction, eye.forward));
    let at = [dot(offset, eye.right), -dot(offset, eye.up)];
    units([along[0] * depth - at[0] * deeper, along[1] * depth - at[1] * deeper])
}

impl PreparedFlowField {
    /// Returns doubled directions on surfaces, from what pixels see in each of the channels of `SEEN`; `still` where that is
    /// nothing.
    #[inline(always)]
    pub(super) fn on_surfaces<S: Simd>(
        &self,
        simd: S,
        eye: &Projector,
        seen: [&[f32; LANES]; 7],
        still: Line<S>,
    ) -> Line<S> {
        let [px, py, pz, nx, ny, nz, coverage] = seen.map(|channel| load(simd, channel));
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let offset = [px - eye.position.x, py - eye.position.y, pz - eye.position.z];
        let own_still = [self.still.1, self.still.0].map(|along| f64x8::splat(simd, along));
        let (way, has_way) = if self.node.along.is_crosswise() {
            projected(eye, offset, [nz - ny * 0.0, nx * 0.0 - nz * 0.0, ny * 0.0 - nx])
        } else {
            projected(eye, offset, [zero - nx * ny, one - ny * ny, zero - nz * ny])
        };
        let across = dot([nx, ny, nz], self.calm);
        let [x, y, z] = self.calm.to_array().map(|along| f64x8::splat(simd, along));
        let calm = [x - nx * across, y - ny * across, z - nz * across];
        let (calm, has_calm) = projected(eye, offset, calm);
        let calm = doubled(choose(has_calm, calm, own_still));
        let own = doubled(turned(choose(has_way, way, own_still), self.turn));
        let steep = self.steep(simd, one - ny);
        let share = steep * steep * (f64x8::splat(simd, 3.0) - steep * 2.0);
        let rest = one - share;
        let mixed = [share * own[0] + rest * calm[0], share * own[1] + rest * calm[1]];
        choose(coverage.simd_gt(0.0), choose(has_way, mixed, calm), still)
    }

    /// Returns a ramp from `flat` to `steep`.
    #[inline(always)]
    fn steep<S: Simd>(&self, simd: S, slope: f64x8<S>) -> f64x8<S> {
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let (from, width) = (self.node.flat, self.node.steep - self.node.flat);
        if width > 0.0 { ((slope - from) / width).max(zero).min(one) } else { slope.simd_ge(from).select(one, zero) }
    }

    /// Returns doubled directions for a field to the left, to the right, above and below.
    #[inline(always)]
    pub(super) fn of_changes<S: Simd>(&self, simd: S, around: [&[f32; LANES]; 4]) -> Line<S> {
        let [left, right, above, below] = around.map(|values| load(simd, values));
        let change = [right - left, below - above];
        let (way, has_way) = units(change);
        let [x, y] = choose(has_way, way, change);
        let line = doubled(turned(if self.node.along.is_crosswise() { [-y, x] } else { [x, y] }, self.turn));
        let still = doubled([self.still.1, self.still.0].map(|along| f64x8::splat(simd, along)));
        choose(has_way, line, still)
    }

    /// Rotates doubled directions by noise.
    #[inline(always)]
    pub(super) fn all_wavering<S: Simd>(&self, simd: S, [x, y]: Line<S>, noise: &[f32; LANES]) -> Line<S> {
        let mut angles = [0.0; LANES];
        for (angle, noise) in angles.iter_mut().zip(noise) {
            *angle = 2.0 * self.waver * f64::from(*noise);
        }
        let [sin, cos] = sines_and_cosines(angles).map(|values| f64x8::simd_from(simd, values));
        [x * cos - y * sin, x * sin + y * cos]
    }
}
