//! How quickly the slowest wave dies away in f32: predicted from the coefficients as they are stored, and measured.

use rayon::prelude::*;

use super::propagator::transfer;
use super::stability::half_life;
use super::trial::{Stepper, noisy, stepped};
use super::{Basin, Motion};

/// Growth of the slowest wave, per step of a motion in f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// Logarithm of the factor by which a step multiplies it; below 0 it dies away.
    pub growth: f64,
    /// Number of steps after which half of it is left; infinite if it stays or grows.
    pub half_life: f64,
    /// Number of steps that were run; 0 for a prediction.
    pub steps: u64,
}

/// Most steps of a run, and the first number of steps of which the second half is looked at.
const STEPS: u64 = 1 << 20;
const FIRST_STEPS: u64 = 1 << 9;
/// Fall of the logarithm over the second half of a run at which it ends: a double root, whose fall is less by the
/// logarithm of 2, is then known to a thirtieth.
const FALL: f64 = 24.0;
/// Share of a run over which its largest size counts, since waves swing.
const WINDOW: u64 = 16;

impl Decay {
    fn new(growth: f64, steps: u64) -> Self {
        Self { growth, half_life: half_life(growth), steps }
    }

    /// Predicts it from the f32 coefficients of the code that makes pictures: of the recurrence, whose slowest wave is at
    /// an end of the spectrum, or of every mode. What the rounding of heights does is not included.
    pub fn predicted(motion: &Motion, basin: &Basin) -> Self {
        let growth = match stepped(motion) {
            Motion::Literal(mixing) => {
                let [c1, loss] = [mixing.c1, mixing.loss()].map(|factor| f64::from(factor as f32));
                let of = |gap: f64| growth([1.0 + c1, c1], loss + 2.0 * c1 * gap);
                basin.gaps().map(of).into_iter().fold(f64::NEG_INFINITY, f64::max)
            }
            motion => {
                let (x, z) = (basin.axis_gaps(basin.columns), basin.axis_gaps(basin.rows));
                let seconds = 1.0 / motion.rate();
                let of = |x: f64, z: f64| {
                    let m = transfer(&motion, basin.spacing, (x + z) / 2.0, seconds).map(|m| f64::from(m as f32));
                    let product = m[0] * m[3] - m[1] * m[2];
                    // 1 − trace + product, (1 − g₁)(1 − g₂).
                    growth([1.0 + product, product], (1.0 - m[0]) * (1.0 - m[3]) - m[1] * m[2])
                };
                let row = |z: &f64| x.iter().map(|x| of(*x, *z)).fold(f64::NEG_INFINITY, f64::max);
                z.par_iter().map(row).reduce(|| f64::NEG_INFINITY, f64::max)
            }
        };
        Self::new(growth, 0)
    }

    /// Measures it on a small grid, best that of a [`Probe`](super::Probe), by powers of the f32 step: a run from noise,
    /// scaled by powers of 2 so that it neither ends nor overflows.
    pub fn measured(motion: &Motion, basin: &Basin) -> Self {
        let start: Vec<f32> = (0..basin.cells()).map(|cell| noisy(basin, cell)).collect();
        let mut stepper = Stepper::new(&stepped(motion), basin, start);
        let mut sizes: Vec<f64> = Vec::new();
        let mut scale = 0.0;
        let mut end = FIRST_STEPS;
        rayon::scope(|_| {
            loop {
                while (sizes.len() as u64) < end {
                    stepper.step(basin, None);
                    let size = stepper.size();
                    sizes.push(libm::log(size) + scale);
                    if !(1e-6..1e6).contains(&size) && size > 0.0 && size.is_finite() {
                        let by = libm::exp2(-libm::round(libm::log2(size)));
                        stepper.scale(by as f32);
                        scale -= libm::log(by);
                    }
                }
                let window = (end / WINDOW) as usize;
                let largest =
                    |from: usize| sizes[from..from + window].iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let (middle, last) = (sizes.len() / 2, sizes.len() - window);
                let fall = largest(last) - largest(middle);
                if fall.abs() > FALL || end >= STEPS || !fall.is_finite() {
                    // Everything has ended at once: each step multiplied by 0.
                    let growth = if fall.is_nan() { f64::NEG_INFINITY } else { fall / (last - middle) as f64 };
                    return Self::new(growth, end);
                }
                end *= 2;
            }
        })
    }
}

/// Returns the logarithm of the larger root's modulus of g² − (`sum` − d)·g + `product`, [sum, product] given, with
/// 1 − b + product = d, so that a root near ±1 is known as well as its distance from there.
fn growth([sum, product]: [f64; 2], d: f64) -> f64 {
    // Of the roots of the mirrored polynomial, the larger one is positive.
    let b = sum - d;
    let d = if b < 0.0 { 1.0 + product + b } else { d };
    let discriminant = (1.0 - product) * (1.0 - product) - d * (2.0 * (1.0 + product) - d);
    if discriminant < 0.0 {
        return libm::log(product) / 2.0;
    }
    let large = (b.abs() + libm::sqrt(discriminant)) / 2.0;
    let small = if large > 0.0 { product / large } else { 0.0 };
    if small < 0.9 { libm::log1p(-d / (1.0 - small)) } else { libm::log(large) }
}
