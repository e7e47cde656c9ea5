//! Choice of the pixels to check.

use std::hash::{BuildHasher, Hasher};

/// Choice of the pixels that are derived again and evaluated by the references. In addition, a check always looks at
/// the pixels that a certificate names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// All pixels.
    All,
    /// One pixel in each of this many equal strata of the picture; all pixels if the picture has no more.
    Some(u64),
}

/// Number of pixels by default: the smallest that finds a share of 0.1 % with a probability of 99 %.
const USUAL: u64 = 4603;

/// Probability of missing what [`Choice::share_found`] tells.
const MISSED: f64 = 0.01;

impl Default for Choice {
    /// Returns a choice of 4603 pixels.
    fn default() -> Self {
        Self::Some(USUAL)
    }
}

impl Choice {
    /// Returns how many of a picture's pixels are chosen; a pixel may be chosen twice.
    fn drawn(self, total: usize) -> usize {
        match self {
            Self::All => total,
            Self::Some(count) => total.min(usize::try_from(count).unwrap_or(usize::MAX)),
        }
    }

    /// Returns the chosen pixels out of `total`, in ascending order.
    ///
    /// Strata are equal parts of the interval from 0 to `total`, whose pixels lie side by side in rows; in each one, a
    /// place is drawn evenly. The digest takes part, so that a forger gains nothing from a seed that is always the
    /// same.
    pub(super) fn pixels(self, seed: u64, digest: &str, total: usize) -> Vec<usize> {
        let drawn = self.drawn(total);
        if drawn == total {
            return (0..total).collect();
        }
        let mut stream = blake3::Hasher::new();
        stream.update(b"trochoid pixels ").update(&seed.to_le_bytes()).update(digest.as_bytes());
        let mut stream = stream.finalize_xof();
        // Numbers beyond the last multiple of the total would favor the first places.
        let fair = u64::MAX - u64::MAX % total as u64;
        let mut place = || {
            loop {
                let mut bytes = [0; 8];
                stream.fill(&mut bytes);
                let number = u64::from_le_bytes(bytes);
                if number < fair {
                    return u128::from(number % total as u64);
                }
            }
        };
        // Stratum i holds the places from i·total to (i + 1)·total, of which each pixel has `drawn`.
        let pixel = |stratum: usize| ((stratum as u128 * total as u128 + place()) / drawn as u128) as usize;
        let mut pixels: Vec<usize> = (0..drawn).map(pixel).collect();
        pixels.dedup();
        pixels
    }

    /// Returns the share of a picture's pixels that is found with a probability of 99 %, wherever they are, if it was
    /// changed; `None` if every change is found.
    ///
    /// If pixels of the share pᵢ of stratum i are changed, all n draws miss them with the probability Π(1 − pᵢ), which
    /// is at most (1 − p)ⁿ for the mean p of the pᵢ (the geometric mean of numbers is at most their arithmetic mean).
    /// This is 0.01 at p = 1 − 0.01^(1/n).
    pub fn share_found(self, total: u64) -> Option<f64> {
        let total = usize::try_from(total).unwrap_or(usize::MAX);
        let drawn = self.drawn(total);
        (drawn < total).then(|| -libm::expm1(libm::log(MISSED) / drawn as f64))
    }
}

/// Draws a seed for [`Request::seed`](super::Request::seed) that nobody can predict, from the operating system.
pub fn random_seed() -> u64 {
    // The keys of a hash map are the one source of such numbers in the standard library.
    std::hash::RandomState::new().build_hasher().finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_stratum_gives_one_pixel_that_depends_on_seed_and_digest() {
        let some = |seed: u64, digest: &str, count: u64| Choice::Some(count).pixels(seed, digest, 10_000);
        assert_eq!(some(1, "a", 1000), some(1, "a", 1000));
        assert_ne!(some(1, "a", 1000), some(2, "a", 1000));
        assert_ne!(some(1, "a", 1000), some(1, "b", 1000));
        for (stratum, pixel) in some(1, "a", 1000).into_iter().enumerate() {
            assert_eq!(pixel / 10, stratum);
        }
        assert_eq!(Choice::Some(10).pixels(1, "a", 10), (0..10).collect::<Vec<_>>());
        assert_eq!(Choice::Some(99).pixels(1, "a", 3), [0, 1, 2]);
        assert_eq!(Choice::All.pixels(1, "a", 3), [0, 1, 2]);
    }

    #[test]
    fn pixels_on_the_border_of_two_strata_are_as_likely_as_others() {
        // 3 of 7 pixels: each is drawn by 3 of the 7 places of its strata, so on average 3/7 times; pixels 2 and 4 lie
        // in two strata each, and are drawn twice at times.
        let mut drawn = [0_u32; 7];
        for seed in 0..7000 {
            Choice::Some(3).pixels(seed, "", 7).into_iter().for_each(|pixel| drawn[pixel] += 1);
        }
        // 1 − Π(1 − share of each stratum).
        let expected = [3, 3, 3, 3, 3, 3, 3].map(|share| f64::from(share) / 7.0);
        let twice = [0.0, 0.0, 1.0 / 7.0 * 2.0 / 7.0, 0.0, 2.0 / 7.0 * 1.0 / 7.0, 0.0, 0.0];
        for (pixel, count) in drawn.iter().enumerate() {
            let share = f64::from(*count) / 7000.0;
            let expected = expected[pixel] - twice[pixel];
            assert!((share - expected).abs() < 0.025, "pixel {pixel}: {share}, expected {expected}");
        }
    }

    #[test]
    fn the_usual_number_finds_one_in_a_thousand() {
        let usual = Choice::default();
        let Choice::Some(count) = usual else { unreachable!("the usual choice is not of all pixels") };
        let share = |count: u64| Choice::Some(count).share_found(1 << 30).expect("some are missed");
        assert!(share(count) <= 0.001 && share(count - 1) > 0.001, "{}", share(count));
        assert!((share(459) - 0.01).abs() < 1e-4 && (share(46_050) - 0.0001).abs() < 1e-8);
        assert_eq!((usual.share_found(4603), Choice::All.share_found(1 << 30)), (None, None));
    }

    #[test]
    fn changes_are_missed_no_more_often_than_the_share_found_tells() {
        const SEEDS: u64 = 4000;
        // As many pixels as are found with 99 %: in a block, spread, or in every second stratum.
        let (total, choice) = (3000, Choice::Some(300));
        let share = choice.share_found(3000).expect("some are missed");
        let count = (share * 3000.0).ceil() as usize;
        let block: Vec<usize> = (500..500 + count).collect();
        let spread: Vec<usize> = (0..count).map(|index| index * 3000 / count).collect();
        let strata: Vec<usize> = (0..count).map(|index| index * 20 % 3000).collect();
        for changed in [block, spread, strata] {
            let missed = (0..SEEDS).filter(|seed| {
                let looked = choice.pixels(*seed, "digest", total);
                !changed.iter().any(|pixel| looked.binary_search(pixel).is_ok())
            });
            // 40 are expected of 4000; 72 or more have a probability below 10⁻⁵.
            let missed = missed.count();
            assert!(missed < 72, "{missed} of {SEEDS}");
        }
    }

    #[test]
    fn seeds_differ() {
        assert_ne!(random_seed(), random_seed());
    }
}
