//! Figures of many pixels from some of them, with intervals.
//!
//! n pixels are drawn, one in each of n equal parts of the picture, independently and evenly. The number of those whose
//! error exceeds a size is a sum of n independent trials, which may differ in their chances; its tails are no heavier than
//! those of the binomial distribution with the same mean (Hoeffding, *On the Distribution of the Number of Successes in
//! Independent Trials*, Annals of Mathematical Statistics 27, 1956, theorem 4: for any ends on both sides of the mean).
//! So intervals for n draws from the whole picture hold for strata as well; they are a little too wide.

use libm::{exp, lgamma, log, log1p};

/// A figure of all pixels, estimated from those that were drawn.
///
/// The interval contains the true figure with a confidence of at least 95 %. If all pixels are known, it has no width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The figure of the pixels that were drawn.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval; +∞ if the pixels are too few to tell one.
    pub high: f64,
}

/// Probability that the truth lies beyond an end of an interval.
const TAIL: f64 = 0.025;

impl Estimate {
    /// Returns the figure of pixels of which none is left out.
    pub(super) fn exact(value: f64) -> Self {
        Self { value, low: value, high: value }
    }

    /// Returns the share of pixels that have a property, as `count` of `drawn` pixels have it.
    ///
    /// The ends are the shares with which `count` or more, or `count` or fewer, have a probability of 2.5 % (Clopper and
    /// Pearson, *The Use of Confidence or Fiducial Limits*, Biometrika 26, 1934).
    pub(super) fn share(count: usize, drawn: usize) -> Self {
        let low = solve(|share| at_least(count, drawn, share) >= TAIL);
        let high = solve(|share| 1.0 - at_least(count + 1, drawn, share) < TAIL);
        Self {
            value: count as f64 / drawn.max(1) as f64,
            low: if count == 0 { 0.0 } else { low },
            high: if count == drawn { 1.0 } else { high },
        }
    }

    /// Returns the size that a share of the pixels does not exceed, given the sizes of those drawn, in ascending order.
    ///
    /// The ends are sizes of drawn pixels: the l-th smallest lies above the quantile only if fewer than l draws do not
    /// exceed it, the u-th lies below it only if at least u draws do (David and Nagaraja, *Order Statistics*, 3rd
    /// edition, section 7.1).
    pub(super) fn quantile(sorted: &[f64], share: f64) -> Option<Self> {
        let drawn = sorted.len();
        let at = |rank: usize| sorted[rank.clamp(1, drawn) - 1];
        let [low, high] = ranks(drawn, share);
        (drawn > 0).then(|| Self {
            value: at((share * drawn as f64).ceil() as usize),
            low: if low == 0 { 0.0 } else { at(low) },
            high: if high > drawn { f64::INFINITY } else { at(high) },
        })
    }
}

/// Returns the ranks, from 1, between which a quantile of the population lies: 0 if no rank is low enough, and one more
/// than the number of draws if none is high enough.
fn ranks(drawn: usize, share: f64) -> [usize; 2] {
    // The chance of fewer than `rank` draws at or below the quantile, and that of at least as many.
    let enough = |rank: usize| at_least(rank, drawn, share);
    let low = first(drawn, |rank| 1.0 - enough(rank) > TAIL) - 1;
    [low, first(drawn, |rank| enough(rank) <= TAIL)]
}

/// Returns the first rank that has a property that all higher ranks have, too; one more than all if none has it.
fn first(all: usize, has: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (1, all + 1);
    while low < high {
        let middle = low + (high - low) / 2;
        if has(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

/// Returns where in [0, 1] a property begins that holds from there on.
fn solve(holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // Halving 64 times leaves no f64 between the ends, except for shares below 2⁻⁶⁴.
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if holds(middle) { high = middle } else { low = middle }
    }
    high
}

/// Returns the probability of at least `count` successes in `trials` independent trials with the same chance.
fn at_least(count: usize, trials: usize, chance: f64) -> f64 {
    match count {
        0 => 1.0,
        count if count > trials => 0.0,
        count => beta(chance, count as f64, (trials - count + 1) as f64),
    }
}

/// Returns the regularized incomplete beta function I_x(a, b) for a, b ≥ 1.
///
/// The continued fraction (NIST Digital Library of Mathematical Functions, 8.17.22) converges fast for
/// x < (a + 1)/(a + b + 2), in about √max(a, b) steps; elsewhere I_x(a, b) = 1 − I_{1−x}(b, a). It is evaluated by the
/// modified method of Lentz.
fn beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta(1.0 - x, b, a);
    }
    const TINY: f64 = 1e-300;
    let nonzero = |value: f64| if value.abs() < TINY { TINY } else { value };
    let (mut fraction, mut c, mut d) = (1.0, 1.0, 0.0);
    for step in 0..100_000 {
        let m = f64::from(step / 2);
        let numerator = match step {
            0 => 1.0,
            step if step % 2 == 0 => m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)),
            _ => -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)),
        };
        d = 1.0 / nonzero(1.0 + numerator * d);
        c = nonzero(1.0 + numerator / c);
        fraction *= c * d;
        if (c * d - 1.0).abs() < 1e-15 {
            break;
        }
    }
    let front = a * log(x) + b * log1p(-x) + lgamma(a + b) - lgamma(a) - lgamma(b);
    (exp(front) / a * (fraction - 1.0)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::{Rng, SeedableRng};

    /// The sum of the probabilities, term by term from 0 successes, or from 0 failures, whose chance is no smaller.
    fn summed(count: usize, trials: usize, chance: f64) -> f64 {
        if count > trials {
            return 0.0;
        }
        if chance > 0.5 {
            return 1.0 - summed(trials - count + 1, trials, 1.0 - chance);
        }
        let mut term = (1.0 - chance).powi(trials as i32);
        let mut below = 0.0;
        for successes in 0..count {
            below += term;
            term *= (trials - successes) as f64 / (successes + 1) as f64 * chance / (1.0 - chance);
        }
        1.0 - below
    }

    #[test]
    fn tails_are_sums_of_their_terms() {
        for trials in [1, 2, 7, 64, 500] {
            for chance in [0.001, 0.1, 0.5, 0.7, 0.99] {
                for count in [0, 1, 2, trials / 3, trials / 2, trials - 1, trials, trials + 1] {
                    let (found, expected) = (at_least(count, trials, chance), summed(count, trials, chance));
                    assert!((found - expected).abs() < 1e-11, "{count} of {trials} at {chance}: {found}, {expected}");
                }
            }
        }
    }

    #[test]
    fn known_intervals_are_found() {
        // The tables of Clopper and Pearson: 0 of 10, and 3 of 10, at 95 %.
        let none = Estimate::share(0, 10);
        assert!(none.low == 0.0 && (none.high - 0.308_50).abs() < 1e-5, "{none:?}");
        let some = Estimate::share(3, 10);
        assert!((some.low - 0.066_74).abs() < 1e-5 && (some.high - 0.652_45).abs() < 1e-5, "{some:?}");
        assert_eq!(Estimate::share(10, 10).high, 1.0);
        // The median of 10 lies between the 2nd and the 9th with 97.9 %; the 3rd and 8th have 89 % only.
        assert_eq!((ranks(10, 0.5), ranks(10, 0.999)), ([2, 9], [10, 11]));
        // The largest of 3688 pixels bounds 99.9 % from above, and that of fewer does not: 0.999ⁿ ≤ 0.025.
        let is_bounded = |drawn: usize| ranks(drawn, 0.999)[1] <= drawn;
        assert!(is_bounded(3688) && !is_bounded(3687));
        let few = Estimate::quantile(&[1.0, 2.0, 3.0], 0.5).unwrap();
        assert_eq!((few.value, few.low, few.high), (2.0, 0.0, f64::INFINITY));
        assert_eq!(Estimate::quantile(&[], 0.5), None);
    }

    /// Draws one of 10,000 sizes in each of `drawn` equal strata of them, many times, and returns how often an interval
    /// misses the truth.
    fn missed(drawn: usize, interval: &dyn Fn(&[f64]) -> Estimate, truth: f64) -> f64 {
        const RUNS: u32 = 4000;
        const ALL: usize = 10_000;
        let mut random = Pcg64::seed_from_u64(7);
        // Sizes that go with their place, so that strata differ, and sizes that do not.
        let size = |place: usize| if place.is_multiple_of(4) { place as f64 } else { (place * 7919 % ALL) as f64 };
        let mut misses = 0;
        for _ in 0..RUNS {
            let mut sizes: Vec<f64> = (0..drawn)
                .map(|stratum| {
                    let part = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
                    size(((stratum as f64 + part) * ALL as f64 / drawn as f64) as usize)
                })
                .collect();
            sizes.sort_by(f64::total_cmp);
            let Estimate { low, high, .. } = interval(&sizes);
            misses += u32::from(!(low <= truth && truth <= high));
        }
        f64::from(misses) / f64::from(RUNS)
    }

    #[test]
    fn intervals_miss_the_truth_in_at_most_one_of_twenty_and_wrong_ones_are_found() {
        let mut all: Vec<f64> = (0..10_000_usize)
            .map(|place| if place.is_multiple_of(4) { place } else { place * 7919 % 10_000 } as f64)
            .collect();
        all.sort_by(f64::total_cmp);
        for drawn in [64, 200] {
            for share in [0.5, 0.9] {
                let truth = all[(share * 10_000.0) as usize - 1];
                let found = missed(drawn, &|sizes| Estimate::quantile(sizes, share).unwrap(), truth);
                assert!(found <= 0.05, "{share} of {drawn}: {found}");
                // An interval of half as many ranks on both sides is wrong, and misses more often.
                let narrow = |sizes: &[f64]| {
                    let ([low, high], middle) = (ranks(drawn, share), share * drawn as f64);
                    let half =
                        |rank: usize| sizes[(0.5 * (rank as f64 + middle)).round().min(drawn as f64) as usize - 1];
                    Estimate { value: 0.0, low: half(low), high: half(high) }
                };
                let found = missed(drawn, &narrow, truth);
                assert!(found > 0.05, "{share} of {drawn}, planted: {found}");
                let beyond = |sizes: &[f64]| sizes.iter().filter(|size| **size > truth).count();
                let above = all.iter().filter(|size| **size > truth).count() as f64 / 10_000.0;
                let found = missed(drawn, &|sizes| Estimate::share(beyond(sizes), drawn), above);
                assert!(found <= 0.05, "share above {share} of {drawn}: {found}");
                let normal = |sizes: &[f64]| {
                    let value = beyond(sizes) as f64 / drawn as f64;
                    let half = 0.98 * (value * (1.0 - value) / drawn as f64).sqrt();
                    Estimate { value, low: value - half, high: value + half }
                };
                let found = missed(drawn, &normal, above);
                assert!(found > 0.05, "share above {share} of {drawn}, planted: {found}");
            }
        }
    }
}
