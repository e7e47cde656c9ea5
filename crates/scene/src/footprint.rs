use crate::Projector;
use fearless_simd::{Level, Simd, dispatch, f32x16, f64x8, prelude::*};
use glam::DVec3;

/// Height over planar depth below which a pixel's patch on the sea is not stretched any further.
///
/// At grazing angles the rest plane does not measure what a pixel sees: the pixel sees the faces of waves, which are
/// steeper than this.
pub const GRAZING: f64 = 0.02;

/// Least planar depth relative to the distance ahead and down: points further aside or behind are hardly visible.
pub(crate) const LEAST_DEPTH: f64 = 0.25;

/// Returns the footprint in meters of a pixel that sees a rest point: the side of the square with the area of the
/// pixel's patch on the rest plane, d·s / √max(h/d, [`GRAZING`]) for planar depth d, height h of the camera over the
/// plane, and the size s of a pixel at depth 1.
///
/// This is exact: a patch of solid angle s²·cos³ψ at distance d/cos ψ, seen under a sine of h·cos ψ/d, has the area
/// s²·d³/h. It is constant along any line across the view.
pub fn footprint(projector: &Projector, rest: DVec3) -> f64 {
    Footprints::of(projector).at(rest)
}

/// Returns a lower bound of every [`footprint`], in meters, of the rest points at world y `level` in a range of
/// distances ahead of the camera, in meters.
pub(crate) fn least_footprint(projector: &Projector, level: f64, [from, to]: [f64; 2]) -> f64 {
    let (offset, forward) = (level - projector.position.y, projector.forward);
    if projector.orthographic {
        return projector.pixel_size(1.0) / libm::sqrt(forward.y.abs().max(GRAZING));
    }
    // Of the two depths in `patch`, one changes linearly ahead, and one grows to both sides of the camera. Footprints
    // grow with both.
    let [x, z] = projector.heading();
    let slope = forward.x * x + forward.z * z;
    let even = (from * slope).min(to * slope) + offset * forward.y;
    let depth = even.max(LEAST_DEPTH * libm::hypot(0.0_f64.clamp(from, to), offset));
    if depth == 0.0 { 0.0 } else { projector.pixel_size(depth) / libm::sqrt((offset.abs() / depth).max(GRAZING)) }
}

/// The footprints of the pixels of one view, with what they share computed once.
#[derive(Clone, Copy, Debug)]
pub struct Footprints {
    projector: Projector,
    heading: [f64; 2],
    /// Planar depth gained by a step of 1 m along the heading, in meters.
    slope: f64,
}

impl Footprints {
    /// Returns the footprints seen by a projector.
    #[inline]
    pub fn of(projector: &Projector) -> Self {
        let [x, z] = projector.heading();
        let slope = projector.forward.x * x + projector.forward.z * z;
        Self { projector: *projector, heading: [x, z], slope }
    }

    /// Returns the [`footprint`] of a pixel that sees a rest point, in meters.
    #[inline]
    pub fn at(&self, rest: DVec3) -> f64 {
        let (width, slant) = self.patch(rest);
        width / libm::sqrt(slant)
    }

    /// Returns the patch itself: vectors x, z in meters to the points that the next pixel across the view sees, and
    /// the next one upward. The footprint is the square root of its area.
    #[inline]
    pub fn axes(&self, rest: DVec3) -> [[f64; 2]; 2] {
        let (width, slant) = self.patch(rest);
        let [x, z] = self.heading;
        [[-z * width, x * width], [x * width / slant, z * width / slant]]
    }

    /// Returns the width of the patch in meters, and the sine of the angle under which it is seen.
    #[inline]
    fn patch(&self, rest: DVec3) -> (f64, f64) {
        let Self { projector, heading: [x, z], slope } = self;
        let offset = rest - projector.position;
        let (height, forward) = (offset.y.abs(), projector.forward);
        if projector.orthographic {
            return (projector.pixel_size(1.0), forward.y.abs().max(GRAZING));
        }
        let along = offset.x * x + offset.z * z;
        let depth = along * slope + offset.y * forward.y;
        let depth = depth.max(LEAST_DEPTH * libm::sqrt(along * along + height * height));
        if depth == 0.0 {
            return (0.0, 1.0);
        }
        (projector.pixel_size(depth), (height / depth).max(GRAZING))
    }
}

/// Number of pixels whose footprints are computed at once.
const LANES: usize = 16;

/// Fills `out` with the footprints at the points that samples of the picture see, given their positions in pixels and
/// the distances of these points ahead of the camera; 0 where a distance is not finite.
///
/// These have the bits of [`footprint`] at the point on the [ray](Projector::ray).
pub fn footprints_seen(projector: &Projector, places: &[[f64; 2]], depths: &[f32], out: &mut [f32]) {
    if projector.orthographic {
        let size = footprint(projector, projector.position) as f32;
        out.iter_mut().zip(depths).for_each(|(out, depth)| *out = if depth.is_finite() { size } else { 0.0 });
        return;
    }
    let heading = projector.heading();
    dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
        for ((places, depths), out) in places.chunks(LANES).zip(depths.chunks(LANES)).zip(out.chunks_mut(LANES)) {
            let (mut across, mut down, mut ahead) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            for (lane, [x, y]) in places.iter().enumerate() {
                (across[lane], down[lane]) = (*x, *y);
            }
            ahead[..depths.len()].copy_from_slice(depths);
            let (low, high) = f32x16::from_slice(simd, &ahead).widen();
            let (x, y) = (across.split_at(LANES / 2), down.split_at(LANES / 2));
            let low = seen(simd, projector, heading, [x.0, y.0], low);
            let high = seen(simd, projector, heading, [x.1, y.1], high);
            let prints: f32x16<_> = low.narrow(high);
            out.copy_from_slice(&prints.as_slice()[..out.len()]);
        }
    }));
}

/// Returns the footprints of a perspective projector, in the order of operations of [`Projector::ray`] and [`patch`].
#[inline(always)]
fn seen<S: Simd>(simd: S, projector: &Projector, [hx, hz]: [f64; 2], [x, y]: [&[f64]; 2], ahead: f64x8<S>) -> f64x8<S> {
    let (x, y) = (f64x8::from_slice(simd, x), f64x8::from_slice(simd, y));
    let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
    let across = (x - projector.size[0] / 2.0) / projector.scale;
    let upward = (f64x8::splat(simd, projector.size[1] / 2.0) - y) / projector.scale;
    let (right, up, forward) = (projector.right, projector.up, projector.forward);
    let dx = across * right.x + forward.x + upward * up.x;
    let dy = across * right.y + forward.y + upward * up.y;
    let dz = across * right.z + forward.z + upward * up.z;
    let shorter = one / (dx * dx + dy * dy + dz * dz).sqrt();
    let (dx, dy, dz) = (dx * shorter, dy * shorter, dz * shorter);
    let distance = ahead / (dx * forward.x + dy * forward.y + dz * forward.z);
    let eye = projector.position;
    let (x, y, z) = (dx * distance + eye.x - eye.x, dy * distance + eye.y - eye.y, dz * distance + eye.z - eye.z);
    let height = y.abs();
    let along = x * hx + z * hz;
    let depth = along * (forward.x * hx + forward.z * hz) + y * forward.y;
    let depth = greater(depth, (along * along + height * height).sqrt() * LEAST_DEPTH);
    let slant = greater(height / depth, f64x8::splat(simd, GRAZING));
    let print = depth / projector.scale / slant.sqrt();
    (depth.simd_eq(0.0) | ahead.abs().simd_eq(f64::INFINITY) | ahead.simd_ne(ahead)).select(zero, print)
}

/// Returns the greater of two numbers, or the number if one is none.
#[inline(always)]
fn greater<S: Simd>(a: f64x8<S>, b: f64x8<S>) -> f64x8<S> {
    (a.simd_gt(b) | b.simd_ne(b)).select(a, b)
}
