//! Specular illumination: how close the mirror direction of a light is to the eye.
//!
//! - *half*: (N·H)^s, with the half vector H (Blinn, *Models of Light Reflection for Computer Synthesized Pictures*,
//!   1977).
//! - *reflection*: (R·V)^s, R = 2N(N·L) − L, the mirror form of the thesis (§3.2.3.1; Phong 1975).
//!
//! # Precision
//! For unit n and h, n·h = 1 − ½|n − h|². The power is therefore exp(s·log1p(−½|n − h|²)): the small difference is
//! computed before anything is rounded against 1. Its error stays near 1e-7 for s up to 1e6, where a power of a
//! rounded cosine is off by 16 %.
//!
//! # Roughness
//! A lobe (N·H)^s is close to exp(−s·θ²/2): a Gaussian of slope variance 1/s for each axis. Slopes that a pixel
//! cannot resolve, with a variance of v over both directions together, widen it to 1/s + v/2 (Olano and Baker, *LEAN
//! Mapping*, 2010), hence s' = s/(1 + s·v/2).

use fearless_simd::{Level, Simd, dispatch};
use glam::{DVec3, Vec3};

use super::power::{exp, log1p};
use super::{Vectors, cut, pick, unit_or_up, unit_or_up_f32};

/// Which two directions are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Model {
    /// Surface normal and half vector.
    #[default]
    Half,
    /// Mirrored light and view direction.
    Reflection,
}

/// Returns the exponent that is left of `exponent` after widening by a lost slope variance.
///
/// The half lobe follows the module's formula; mirrored directions turn twice as far as normals, so that the variance
/// counts four times for them.
#[inline]
pub fn widened(exponent: f64, slope_variance: f64, model: Model) -> f64 {
    let factor = match model {
        Model::Half => 0.5,
        Model::Reflection => 2.0,
    };
    exponent / (1.0 + exponent * slope_variance.max(0.0) * factor)
}

/// Returns the lobe in [0, 1] for unit L and V; `exponent` s ≥ 0, and `slope_variance` ≥ 0 widens it.
///
/// It is 0 where the two directions are at a right angle or more, where L + V = 0, and where the light is behind the
/// surface (N·L ≤ 0). A degenerate normal counts as (0, 1, 0).
pub fn reference(normal: DVec3, light: DVec3, view: DVec3, exponent: f64, slope_variance: f64, model: Model) -> f64 {
    let (n, l, v) = (unit_or_up(normal), unit_or_up(light), unit_or_up(view));
    if n.dot(l) <= 0.0 {
        return 0.0;
    }
    let (a, b) = match model {
        Model::Half => match (l + v).try_normalize() {
            Some(half) => (n, half),
            None => return 0.0,
        },
        Model::Reflection => (2.0 * n * n.dot(l) - l, v),
    };
    if a.dot(b) <= 0.0 {
        return 0.0;
    }
    let away = -0.5 * (a - b).length_squared();
    libm::exp(widened(exponent, slope_variance, model) * libm::log1p(away.max(-1.0)))
}

/// Evaluates [`reference()`] at many points; `slope_variances` may be empty if there is none.
///
/// # Panics
/// The slices differ in length.
pub fn fill(
    normals: Vectors<'_>,
    lights: Vectors<'_>,
    views: Vectors<'_>,
    exponent: f32,
    slope_variances: &[f32],
    model: Model,
    out: &mut [f32],
) {
    let mut exponents = [0.0; BLOCK];
    for (block, out) in out.chunks_mut(BLOCK).enumerate() {
        let (start, count) = (block * BLOCK, out.len());
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || {
                let (n, l, v) = (cut(normals, start, count), cut(lights, start, count), cut(views, start, count));
                for (index, out) in out.iter_mut().enumerate() {
                    *out = away(pick(n, index), pick(l, index), pick(v, index), model);
                }
                match slope_variances.get(start..start + count) {
                    Some(variances) => {
                        for (to, variance) in exponents.iter_mut().zip(variances) {
                            *to = widened(f64::from(exponent), f64::from(*variance), model) as f32;
                        }
                    }
                    None => exponents.fill(exponent),
                }
                for (out, exponent) in out.iter_mut().zip(&exponents) {
                    let power = exp(exponent * log1p(*out));
                    *out = if *out >= -1.0 { power } else { 0.0 };
                }
            }
        ));
    }
}

/// Number of points that are processed together.
const BLOCK: usize = 128;

/// Returns −½|a − b|² of the two directions, which is −1 at right angles; −2 where nothing is mirrored.
#[inline(always)]
fn away(normal: Vec3, light: Vec3, view: Vec3, model: Model) -> f32 {
    const NOTHING: f32 = -2.0;
    let (n, l, v) = (unit_or_up_f32(normal), unit_or_up_f32(light), unit_or_up_f32(view));
    let cosine = n.dot(l);
    let (a, b) = match model {
        Model::Half => match (l + v).try_normalize() {
            Some(half) => (n, half),
            None => return NOTHING,
        },
        Model::Reflection => (2.0 * cosine * n - l, v),
    };
    let away = -0.5 * (a - b).length_squared();
    if cosine <= 0.0 || a.dot(b) <= 0.0 { NOTHING } else { away.max(-1.0) }
}
