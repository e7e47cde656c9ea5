//! The darkest and the brightest colors of a part of a picture.

use crate::vector::{Point, add, scale};
use trochoid_image::oklab;

/// Steps of lightness.
const STEPS: usize = 1024;

/// Sums of the colors of pixels, by their lightness in OKLab in 1024 steps. They take 32 KiB for any number of pixels.
///
/// ```
/// let mut tones = trochoid_palette::Tones::default();
/// (0..10).for_each(|step| tones.add([0.1 * f64::from(step); 3]));
/// assert_eq!(tones.darkest(0.1), Some([0.0; 3]));
/// assert!(tones.brightest(0.2).is_some_and(|color| (color[0] - 0.85).abs() < 1e-9));
/// ```
#[derive(Clone, Debug)]
pub struct Tones {
    steps: Vec<(u64, Point)>,
}

impl Default for Tones {
    fn default() -> Self {
        Self { steps: vec![(0, [0.0; 3]); STEPS] }
    }
}

impl Tones {
    /// Adds a pixel by its displayed color; beyond white, it is as light as white.
    pub fn add(&mut self, color: [f64; 3]) {
        let lightness = oklab(color)[0];
        // A color that is no number is as dark as black.
        let (count, sum) = &mut self.steps[((lightness * STEPS as f64) as usize).min(STEPS - 1)];
        *count += 1;
        *sum = add(*sum, color);
    }

    /// Returns the mean of the darkest share of the pixels, from 0 to 1, at least of one; `None` without pixels.
    #[must_use]
    pub fn darkest(&self, share: f64) -> Option<[f64; 3]> {
        self.mean(share, self.steps.iter())
    }

    /// Returns the mean of the brightest share of the pixels, from 0 to 1, at least of one; `None` without pixels.
    #[must_use]
    pub fn brightest(&self, share: f64) -> Option<[f64; 3]> {
        self.mean(share, self.steps.iter().rev())
    }

    fn mean<'s>(&self, share: f64, steps: impl Iterator<Item = &'s (u64, Point)>) -> Option<[f64; 3]> {
        let all: u64 = self.steps.iter().map(|(count, _)| count).sum();
        let wanted = (share.clamp(0.0, 1.0) * all as f64).max(1.0);
        let (mut taken, mut mean) = (0.0, [0.0; 3]);
        for (count, sum) in steps.filter(|(count, _)| *count > 0) {
            // Of the last step, all pixels count, but less.
            let part = (*count as f64).min(wanted - taken);
            mean = add(mean, scale(*sum, part / *count as f64));
            taken += part;
            if taken >= wanted {
                break;
            }
        }
        (all > 0).then(|| scale(mean, 1.0 / taken))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_of_the_darkest_and_the_brightest() {
        assert_eq!((Tones::default().darkest(0.1), Tones::default().brightest(0.1)), (None, None));
        let mut tones = Tones::default();
        let (dark, red, light) = ([0.1, 0.0, 0.1], [0.6, 0.1, 0.1], [0.9, 0.9, 0.8]);
        for (color, count) in [(light, 5), (dark, 10), (red, 85)] {
            (0..count).for_each(|_| tones.add(color));
        }
        let is_near = |found: Option<[f64; 3]>, expected: Point| {
            found.is_some_and(|found| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12))
        };
        assert!(is_near(tones.darkest(0.1), dark) && is_near(tones.darkest(0.0), dark));
        assert!(is_near(tones.brightest(0.05), light));
        let half = |c: usize| 0.5 * (light[c] + red[c]);
        assert!(is_near(tones.brightest(0.1), [half(0), half(1), half(2)]));
        let all = |c: usize| 0.05 * light[c] + 0.1 * dark[c] + 0.85 * red[c];
        assert!(is_near(tones.darkest(1.0), [all(0), all(1), all(2)]));
        // Brighter than white, and no number.
        tones.add([3.0; 3]);
        tones.add([f64::NAN; 3]);
        assert!(is_near(tones.brightest(0.0), [3.0; 3]));
    }
}
