//! Quantities from lights and view directions at a shading point; colors are up to the back end.
//!
//! Each has a `reference` in f64 for one point, straight from the formula, and a `fill` in f32 over slices. Vectors
//! for `fill` are three slices, one per axis, and all slices of a call have the same length.

pub mod blinn;
pub mod fresnel;
pub mod lambert;
pub(crate) mod power;

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;

/// Three slices of equal length: the x, y and z of many vectors.
pub type Vectors<'a> = [&'a [f32]; 3];

/// Returns the unit vector along `vector`; (0, 1, 0) if it is zero or not finite.
#[inline]
pub fn unit_or_up(vector: DVec3) -> DVec3 {
    vector.try_normalize().unwrap_or(DVec3::Y)
}

/// Returns one of many vectors in f32, unchanged.
#[inline]
pub(crate) fn pick(vectors: Vectors<'_>, index: usize) -> glam::Vec3 {
    glam::Vec3::new(vectors[0][index], vectors[1][index], vectors[2][index])
}

/// Does [`unit_or_up`] in f32.
#[inline]
pub(crate) fn unit_or_up_f32(vector: glam::Vec3) -> glam::Vec3 {
    vector.try_normalize().unwrap_or(glam::Vec3::Y)
}

/// Writes to `out` the unit vectors from points to the camera at `eye`, or against `forward` if rays are parallel.
#[allow(clippy::needless_range_loop, reason = "a loop over several slices")]
pub fn view_directions(positions: Vectors<'_>, projector: &crate::Projector, out: [&mut [f32]; 3]) {
    let [x, y, z] = out;
    if projector.orthographic {
        let view = -projector.forward;
        x.fill(view.x as f32);
        y.fill(view.y as f32);
        z.fill(view.z as f32);
        return;
    }
    let eye = projector.position;
    dispatch!(Level::new(), simd => simd.vectorize(
        #[inline(always)]
        || {
            let count = x.len();
            let (positions, y, z) = (cut(positions, 0, count), &mut y[..count], &mut z[..count]);
            for index in 0..count {
                let view = unit_or_up(eye - pick(positions, index).as_dvec3());
                (x[index], y[index], z[index]) = (view.x as f32, view.y as f32, view.z as f32);
            }
        }
    ));
}

/// Writes to `out` max(0, N·V) in f64 for vectors of any length; degenerate ones count as (0, 1, 0).
///
/// # Panics
/// The slices differ in length.
pub fn facings(normals: Vectors<'_>, views: Vectors<'_>, out: &mut [f64]) {
    dispatch!(Level::new(), simd => simd.vectorize(
        #[inline(always)]
        || {
            let (normals, views) = (cut(normals, 0, out.len()), cut(views, 0, out.len()));
            for (index, out) in out.iter_mut().enumerate() {
                *out = facing(pick(normals, index).as_dvec3(), pick(views, index).as_dvec3());
            }
        }
    ));
}

/// Returns max(0, N·V) for vectors of any length; degenerate ones count as (0, 1, 0).
#[inline(always)]
pub fn facing(normal: DVec3, view: DVec3) -> f64 {
    unit_or_up(normal).dot(unit_or_up(view)).clamp(0.0, 1.0)
}

/// Returns `count` vectors from `start` on: loops with a known count are vectorized.
#[inline(always)]
fn cut([x, y, z]: Vectors<'_>, start: usize, count: usize) -> Vectors<'_> {
    [&x[start..][..count], &y[start..][..count], &z[start..][..count]]
}
