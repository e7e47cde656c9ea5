//! Non-specular illumination: Lambert's cosine, mapped to [0, 1].
//!
//! Source: thesis §3.2.3.2. cos θ = N·L, C = (cos θ + 1)/2, raised to a power for contrast.

use glam::DVec3;

use super::{Vectors, pick, unit_or_up, unit_or_up_f32};

/// ((N·L + 1)/2)^power for unit L, in [0, 1]. `power` > 0; 1 is the plain remap, the thesis also uses 2.
///
/// A degenerate normal counts as (0, 1, 0).
pub fn reference(normal: DVec3, light: DVec3, power: f64) -> f64 {
    let cosine = unit_or_up(normal).dot(unit_or_up(light)).clamp(-1.0, 1.0);
    libm::pow((cosine + 1.0) / 2.0, power)
}

/// [`reference()`] at many points.
///
/// # Panics
/// The slices differ in length.
pub fn fill(normals: Vectors<'_>, lights: Vectors<'_>, power: f32, out: &mut [f32]) {
    for (index, out) in out.iter_mut().enumerate() {
        let cosine = unit_or_up_f32(pick(normals, index)).dot(unit_or_up_f32(pick(lights, index)));
        let share = (cosine.clamp(-1.0, 1.0) + 1.0) * 0.5;
        *out = if power == 1.0 {
            share
        } else if power == 2.0 {
            share * share
        } else {
            libm::powf(share, power)
        };
    }
}
