//! Non-specular illumination: Lambert's cosine, mapped to [0, 1].
//!
//! Source: thesis §3.2.3.2. cos θ = N·L, C = (cos θ + 1)/2, raised to a power for contrast.

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;

use super::{Vectors, cut, pick, unit_or_up, unit_or_up_f32};

/// Returns ((N·L + 1)/2)^power for unit L, in [0, 1]. `power` > 0; 1 is the plain remap, the thesis also uses 2.
///
/// A degenerate normal counts as (0, 1, 0).
pub fn reference(normal: DVec3, light: DVec3, power: f64) -> f64 {
    let cosine = unit_or_up(normal).dot(unit_or_up(light)).clamp(-1.0, 1.0);
    libm::pow((cosine + 1.0) / 2.0, power)
}

/// Evaluates [`reference()`] at many points.
///
/// # Panics
/// The slices differ in length.
pub fn fill(normals: Vectors<'_>, lights: Vectors<'_>, power: f32, out: &mut [f32]) {
    dispatch!(Level::new(), simd => simd.vectorize(
        #[inline(always)]
        || {
            let (normals, lights) = (cut(normals, 0, out.len()), cut(lights, 0, out.len()));
            for (index, out) in out.iter_mut().enumerate() {
                let cosine = unit_or_up_f32(pick(normals, index)).dot(unit_or_up_f32(pick(lights, index)));
                *out = (cosine.clamp(-1.0, 1.0) + 1.0) * 0.5;
            }
        }
    ));
    if power == 2.0 {
        out.iter_mut().for_each(|share| *share *= *share);
    } else if power != 1.0 {
        out.iter_mut().for_each(|share| *share = libm::powf(*share, power));
    }
}
