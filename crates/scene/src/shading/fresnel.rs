//! Fresnel reflectance after Schlick, *An Inexpensive BRDF Model for Physically-based Rendering*, 1994; thesis
//! §3.2.3.3.
//!
//! F = F₀ + (1 − F₀)(1 − cos θ)⁵ with F₀ = ((η − 1)/(η + 1))², η the ratio of refractive indices.

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;

use super::{Vectors, cut, pick, unit_or_up, unit_or_up_f32};

/// Which cosine is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Cosine {
    /// N·V: the reflection of the surface toward the eye.
    #[default]
    View,
    /// H·V, as printed in the thesis: the reflection of one light.
    Half,
}

/// Returns F₀ for a ratio of refractive indices η > 0; 1.333 is air to water.
pub fn normal_reflectance(eta: f64) -> f64 {
    let ratio = (eta - 1.0) / (eta + 1.0);
    ratio * ratio
}

/// Returns the reflectance at a cosine, which is clamped to [0, 1]; the result is in [F₀, 1].
pub fn schlick(cosine: f64, eta: f64) -> f64 {
    let f0 = normal_reflectance(eta);
    let away = 1.0 - cosine.clamp(0.0, 1.0);
    f0 + (1.0 - f0) * (away * away * away * away * away)
}

/// Returns the reflectance for unit V, and for [`Cosine::Half`] unit L, which is ignored otherwise. Where L + V = 0
/// the cosine is 0.
///
/// A degenerate normal counts as (0, 1, 0).
pub fn reference(normal: DVec3, light: DVec3, view: DVec3, eta: f64, cosine: Cosine) -> f64 {
    let v = unit_or_up(view);
    let cosine = match cosine {
        Cosine::View => unit_or_up(normal).dot(v),
        Cosine::Half => (unit_or_up(light) + v).try_normalize().map_or(0.0, |half| half.dot(v)),
    };
    schlick(cosine, eta)
}

/// Evaluates [`reference()`] at many points; `lights` is read only for [`Cosine::Half`] and may be empty otherwise.
///
/// # Panics
/// The slices that are read differ in length.
pub fn fill(normals: Vectors<'_>, lights: Vectors<'_>, views: Vectors<'_>, eta: f64, cosine: Cosine, out: &mut [f32]) {
    let f0 = normal_reflectance(eta) as f32;
    dispatch!(Level::new(), simd => simd.vectorize(
        #[inline(always)]
        || {
            let (count, views) = (out.len(), cut(views, 0, out.len()));
            match cosine {
                Cosine::View => {
                    let normals = cut(normals, 0, count);
                    for (index, out) in out.iter_mut().enumerate() {
                        let v = unit_or_up_f32(pick(views, index));
                        *out = mirrored(unit_or_up_f32(pick(normals, index)).dot(v), f0);
                    }
                }
                Cosine::Half => {
                    let lights = cut(lights, 0, count);
                    for (index, out) in out.iter_mut().enumerate() {
                        let v = unit_or_up_f32(pick(views, index));
                        let half = unit_or_up_f32(pick(lights, index)) + v;
                        *out = mirrored(half.try_normalize().map_or(0.0, |half| half.dot(v)), f0);
                    }
                }
            }
        }
    ));
}

/// Computes [`schlick`] in f32.
#[inline(always)]
fn mirrored(cosine: f32, f0: f32) -> f32 {
    let away = 1.0 - cosine.clamp(0.0, 1.0);
    let power = away * away * away * away * away;
    // Mix(F₀, 1, power) in the form that never leaves [F₀, 1] and is exact at both ends.
    let range = 1.0 - f0;
    if power < 0.5 { f0 + power * range } else { 1.0 + (power - 1.0) * range }
}
