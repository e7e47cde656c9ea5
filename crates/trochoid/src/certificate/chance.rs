//! Choice of the pixels to check, and the number of them that may exceed a quantile by chance.

use std::collections::BTreeSet;

/// Maximum probability that a correct certificate is rejected by chance.
const BAD_LUCK: f64 = 1e-9;

/// Chooses `count` distinct pixels out of `total`, in ascending order. The digest determines the choice, so that any
/// change of a certificate changes it.
pub(super) fn choose(digest: &str, total: usize, count: usize) -> Vec<usize> {
    if count >= total {
        return (0..total).collect();
    }
    // If more than half are chosen, it is faster to draw those that are not.
    let drawn = count.min(total - count);
    let mut stream = blake3::Hasher::new().update(b"trochoid pixels ").update(digest.as_bytes()).finalize_xof();
    let mut chosen = BTreeSet::new();
    let total = total as u64;
    // Numbers beyond the last multiple of the total would favor the first pixels.
    let fair = u64::MAX - u64::MAX % total;
    while chosen.len() < drawn {
        let mut bytes = [0; 8];
        stream.fill(&mut bytes);
        let number = u64::from_le_bytes(bytes);
        if number < fair {
            chosen.insert((number % total) as usize);
        }
    }
    if drawn == count {
        return chosen.into_iter().collect();
    }
    (0..total as usize).filter(|pixel| !chosen.contains(pixel)).collect()
}

/// Returns how many of `looked` pixels may exceed a quantile if at most a share of `p` of all pixels exceeds it. The
/// pixels are drawn without replacement; more than this number exceed it with a probability of at most [`BAD_LUCK`].
///
/// Hoeffding, Probability Inequalities for Sums of Bounded Random Variables, 1963, theorems 1 and 4: at least `k` of
/// `n` exceed it with probability at most exp(−n·D(k/n ‖ p)), where D is the relative entropy.
pub(super) fn allowed(looked: u64, p: f64) -> u64 {
    let n = looked as f64;
    let unlikely = |k: u64| {
        let q = k as f64 / n;
        let term = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a * libm::log(a / b) };
        q > p && -n * (term(q, p) + term(1.0 - q, 1.0 - p)) <= libm::log(BAD_LUCK)
    };
    (0..looked).find(|most| unlikely(most + 1)).unwrap_or(looked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_choice_depends_on_the_digest_alone_and_is_spread_evenly() {
        let some = choose("a", 10_000, 1000);
        assert_eq!(some, choose("a", 10_000, 1000));
        assert_ne!(some, choose("b", 10_000, 1000));
        assert!(some.windows(2).all(|pair| pair[0] < pair[1]) && some.len() == 1000);
        for quarter in 0..4 {
            let count = some.iter().filter(|pixel| **pixel / 2500 == quarter).count();
            assert!((190..=310).contains(&count), "{count} of 250 expected");
        }
        assert_eq!(choose("a", 10, 9).len(), 9);
        assert_eq!(choose("a", 10, 10), (0..10).collect::<Vec<_>>());
        assert_eq!(choose("a", 3, 10), [0, 1, 2]);
    }

    #[test]
    fn chance_allows_more_than_the_mean_and_not_much_more() {
        assert_eq!(allowed(0, 0.001), 0);
        assert_eq!(allowed(1, 0.001), 1, "one in a thousand is not unlikely enough");
        assert!((10..50).contains(&allowed(10_000, 0.001)), "{}", allowed(10_000, 0.001));
        let many = allowed(10_000_000, 0.001);
        assert!((10_000..10_700).contains(&many), "{many}");
    }
}
