//! Weighted means along several rows or columns, of several neighboring places at once.

use super::Kernel;
use super::runs::{Known, LANES, Values, is_any};
use fearless_simd::{Simd, prelude::*};
use std::ops::Range;
use trochoid_memory::Scratch;

/// Number of neighboring places whose means are computed together: each value is loaded once for all of them, and their sums
/// fit into registers.
pub(super) const TOGETHER: usize = LANES;

/// Means of some places, by place and lane.
pub(super) type Means = [[f32; LANES]; TOGETHER];

/// A kernel from its center outward: both sides are equal.
pub(super) struct Half {
    weights: Scratch<f64>,
    /// Most by which the sums of pairs differ from ordered ones, as a multiple of the sum of all magnitudes times their
    /// weights.
    ///
    /// A product of two f32 is exact in f64, so that an ordered sum of 2r + 1 products rounds 2r times. A sum of pairs
    /// rounds r times, and its summands twice. Each time errs by ε/2 at most, and both bounds of a sum by ε: together less
    /// than half of this.
    error: f64,
}

impl Half {
    pub(super) fn new(kernel: &Kernel) -> Self {
        let weights: Scratch<f64> = kernel.weights[kernel.radius()..].iter().map(|weight| f64::from(*weight)).collect();
        Self { error: (3 * weights.len() + 3) as f64 * f64::EPSILON, weights }
    }

    /// Returns the distance of the farthest place that has a weight.
    pub(super) fn radius(&self) -> usize {
        self.weights.len() - 1
    }

    /// Returns the means around the places from `center` on: sums in f64 in the order of the kernel, rounded to f32.
    ///
    /// The two values at each distance from the center have the same weight. Therefore sums of such pairs take half of the
    /// products, but are rounded otherwise. Where all numbers so near to them round to the same f32, that is the mean;
    /// elsewhere, a few times in a million, the sums are computed in order.
    #[inline(always)]
    pub(super) fn means<S: Simd>(&self, simd: S, run: &[Values], known: &Known, center: usize) -> Means {
        let mut means = [[0.0; LANES]; TOGETHER];
        let Some(steps) = self.steps(&known.used, center) else { return means };
        let mut sums = [[0.0; LANES]; TOGETHER];
        for part in (0..LANES).step_by(S::f64s::LEN) {
            let found = self.pairs(simd, run, center, steps.clone(), part);
            for (sums, found) in sums.iter_mut().zip(&found) {
                found.store_slice(&mut sums[part..part + S::f64s::LEN]);
            }
        }
        let most = known.most();
        // Without signs, a sum is that of all magnitudes.
        let (share, slack) = if known.has_signs() { (0.0, f64::from(most) * self.error) } else { (self.error, 0.0) };
        let mut differences = [0; LANES];
        for (means, sums) in means.iter_mut().zip(&sums) {
            let mut high = [0.0; LANES];
            for (mean, sum) in means.iter_mut().zip(sums) {
                *mean = (sum * (1.0 - share) - slack) as f32;
            }
            for (high, sum) in high.iter_mut().zip(sums) {
                *high = (sum * (1.0 + share) + slack) as f32;
            }
            for ((difference, low), high) in differences.iter_mut().zip(means.iter()).zip(&high) {
                *difference |= low.to_bits() ^ high.to_bits();
            }
        }
        if is_any(&differences) || !most.is_finite() {
            self.ordered(simd, run, center, &mut means);
        }
        means
    }

    /// Returns the steps outward in which any value that is not 0 has a weight; `None` if there is none. A value of 0
    /// changes no sum.
    #[inline(always)]
    fn steps(&self, used: &Range<usize>, center: usize) -> Option<Range<usize>> {
        let last = center + TOGETHER - 1;
        let nearest = used.start.saturating_sub(last).max((center + 1).saturating_sub(used.end));
        let farthest = used.end.saturating_sub(center + 1).max(last.saturating_sub(used.start)).min(self.radius());
        (!used.is_empty() && nearest <= farthest).then_some(nearest..farthest + 1)
    }

    /// Returns the sums of pairs, for the lanes from `part` on.
    #[inline(always)]
    fn pairs<S: Simd>(
        &self,
        simd: S,
        run: &[Values],
        center: usize,
        steps: Range<usize>,
        part: usize,
    ) -> [S::f64s; TOGETHER] {
        let load = |values: &Values| S::f64s::from_slice(simd, &values.0[part..part + S::f64s::LEN]);
        let mut sums = [S::f64s::splat(simd, 0.0); TOGETHER];
        if steps.start == 0 {
            let weight = S::f64s::splat(simd, self.weights[0]);
            for (sum, values) in sums.iter_mut().zip(&run[center..]) {
                *sum = weight * load(values);
            }
        }
        let (first, end) = (steps.start.max(1), steps.end);
        if first >= end {
            return sums;
        }
        // The values to the left and to the right of each center move on by one center with each step.
        let last = center + TOGETHER - 1;
        let (mut lefts, mut rights) = (sums, sums);
        for index in 1..TOGETHER {
            lefts[index - 1] = load(&run[center + index - first]);
            rights[index] = load(&run[center + index - 1 + first]);
        }
        let next = run[center + 1 - end..=center - first].iter().rev().zip(&run[last + first..last + end]);
        for (weight, (left, right)) in self.weights[first..end].iter().zip(next) {
            let weight = S::f64s::splat(simd, *weight);
            for index in 1..TOGETHER {
                lefts[TOGETHER - index] = lefts[TOGETHER - index - 1];
                rights[index - 1] = rights[index];
            }
            lefts[0] = load(left);
            rights[TOGETHER - 1] = load(right);
            for index in 0..TOGETHER {
                sums[index] = weight.mul_add(lefts[index] + rights[index], sums[index]);
            }
        }
        sums
    }

    /// Computes the same means as the definition says.
    #[cold]
    #[inline(never)]
    fn ordered<S: Simd>(&self, simd: S, run: &[Values], center: usize, means: &mut Means) {
        let radius = self.radius();
        let run = &run[center - radius..][..2 * radius + TOGETHER];
        simd.vectorize(
            #[inline(always)]
            || {
                for part in (0..LANES).step_by(S::f64s::LEN) {
                    let mut sums = [S::f64s::splat(simd, 0.0); TOGETHER];
                    for (values, index) in run.array_windows::<TOGETHER>().zip(0usize..) {
                        let weight = self.weights[index.abs_diff(radius)];
                        // 0 times infinity would have no value.
                        if weight == 0.0 {
                            continue;
                        }
                        let weight = S::f64s::splat(simd, weight);
                        for (sum, values) in sums.iter_mut().zip(values) {
                            *sum += weight * S::f64s::from_slice(simd, &values.0[part..part + S::f64s::LEN]);
                        }
                    }
                    for ((means, sums), centers) in means.iter_mut().zip(&sums).zip(&run[radius..]) {
                        let lanes = means[part..].iter_mut().zip(sums.as_slice()).zip(&centers.0[part..]);
                        for ((mean, sum), center) in lanes {
                            // +∞ and −∞ have no mean: keep the center.
                            *mean = if sum.is_nan() { *center as f32 } else { *sum as f32 };
                        }
                    }
                }
            },
        );
    }
}
