//! Errors of pixels, and figures of many of them.

use super::apart::shown;
use super::statistics::Estimate;
use crate::display::{linear_errors, near};
use trochoid_graph::Kind;
use trochoid_image::WorkingSpace;

/// Size of an error, or a bound of it: that of the largest channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorSize {
    /// In display values from 0 to 1; for weights, as they are.
    pub display: f64,
    /// In units of the working space.
    pub working: f64,
}

/// Size of an error, or a bound of it, and the pixel that has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorAt {
    /// The size.
    pub size: ErrorSize,
    /// The pixel.
    pub pixel: [i64; 2],
}

/// Errors, or bounds of errors, of pixels that were drawn, in display values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorSample {
    /// In ascending order.
    sizes: Vec<f64>,
    /// Whether these are all pixels.
    is_whole: bool,
}

impl ErrorSample {
    /// Takes sizes, in any order, and whether they are those of all pixels.
    pub fn new(mut sizes: Vec<f64>, is_whole: bool) -> Self {
        sizes.sort_by(f64::total_cmp);
        Self { sizes, is_whole }
    }

    /// Returns the number of pixels that were drawn; a pixel that was drawn twice counts twice.
    pub fn count(&self) -> usize {
        self.sizes.len()
    }

    /// Returns the size that a share of the pixels does not exceed; `None` without pixels.
    pub fn quantile(&self, share: f64) -> Option<Estimate> {
        let found = Estimate::quantile(&self.sizes, share)?;
        Some(if self.is_whole { Estimate::exact(found.value) } else { found })
    }

    /// Returns the share of pixels whose size exceeds another one; `None` without pixels.
    pub fn above(&self, size: f64) -> Option<Estimate> {
        let all = self.sizes.len();
        let above = all - self.sizes.partition_point(|own| *own <= size);
        let share =
            if self.is_whole { Estimate::exact(above as f64 / all as f64) } else { Estimate::share(above, all) };
        (all > 0).then_some(share)
    }

    /// Returns the root of the mean square; `None` without pixels.
    pub fn rms(&self) -> Option<f64> {
        let squares: f64 = self.sizes.iter().map(|size| size * size).sum();
        (!self.sizes.is_empty()).then(|| (squares / self.sizes.len() as f64).sqrt())
    }
}

/// Errors of settings, or bounds of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorFigures {
    /// Of pixels drawn in the whole picture.
    pub picture: ErrorSample,
    /// Of pixels drawn where settings differ.
    pub apart: ErrorSample,
    /// The largest of all pixels that were looked at.
    pub max: Option<ErrorAt>,
    /// The largest of those of which no sample is ambiguous.
    pub clear_max: Option<ErrorAt>,
}

/// What is known of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub(super) pixel: [i64; 2],
    pub(super) size: ErrorSize,
    pub(super) is_clear: bool,
}

impl ErrorFigures {
    /// Makes figures of pixels: the draws in the picture and those where settings differ, by index into all pixels that
    /// were looked at. Pixels of which nothing is known are left out.
    pub(super) fn new(
        known: &[Option<Known>],
        picture: &[usize],
        apart: &[usize],
        [all, all_apart]: [bool; 2],
    ) -> Self {
        let sample = |draws: &[usize], is_whole| {
            let sizes = draws.iter().filter_map(|index| Some(known[*index].as_ref()?.size.display));
            let sizes: Vec<f64> = sizes.collect();
            let is_whole = is_whole && sizes.len() == draws.len();
            ErrorSample::new(sizes, is_whole)
        };
        let largest = |of: &dyn Fn(&&Known) -> bool| {
            // Of equal ones, the first.
            let most = known.iter().flatten().filter(of).rev().max_by(|a, b| a.size.display.total_cmp(&b.size.display));
            most.map(|known| ErrorAt { size: known.size, pixel: known.pixel })
        };
        Self {
            picture: sample(picture, all),
            apart: sample(apart, all_apart),
            max: largest(&|_| true),
            clear_max: largest(&|known| known.is_clear),
        }
    }
}

/// Returns the size of a bound of each channel's error, given the value of the picture.
pub(super) fn size_of_bound(kind: Kind, space: WorkingSpace, value: &[f64], bounds: &[f64]) -> ErrorSize {
    let working = bounds.iter().copied().fold(0.0, f64::max);
    let display = match (kind, value) {
        _ if working == 0.0 => 0.0,
        (Kind::Color, [r, g, b]) if space != WorkingSpace::Srgb => {
            let linear = space.to_linear_srgb([*r, *g, *b]).map(|channel| (channel, channel));
            near(linear, linear_errors(space, bounds))
        }
        _ => working.min(1.0),
    };
    ErrorSize { display, working }
}

/// Returns the size of the error of a value.
pub(super) fn size_of_error(kind: Kind, space: WorkingSpace, value: &[f64], truth: &[f64]) -> ErrorSize {
    let most = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max);
    let [shown, exact] = [value, truth].map(|value| shown(kind, value, space));
    ErrorSize { display: most(&shown, &exact), working: most(value, truth) }
}

/// Returns how far two values lie apart: equal infinities by 0, and what is no number by infinity.
pub(super) fn distance(value: f64, truth: f64) -> f64 {
    match (value - truth).abs() {
        _ if value == truth => 0.0,
        distance if distance.is_nan() => f64::INFINITY,
        distance => distance,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    fn known(x: i64, display: f64, is_clear: bool) -> Option<Known> {
        Some(Known { pixel: [x, 0], size: ErrorSize { display, working: 2.0 * display }, is_clear })
    }

    #[test]
    fn figures_are_of_the_pixels_that_they_name() {
        let all = [known(0, 0.1, true), known(1, 0.4, false), known(2, 0.2, true), known(3, 0.2, true)];
        let figures = ErrorFigures::new(&all, &[0, 2, 2], &[1], [false, true]);
        assert_eq!((figures.picture.count(), figures.apart.count()), (3, 1));
        assert_eq!(figures.max.map(|at| (at.pixel, at.size.working)), Some(([1, 0], 0.8)));
        assert_eq!(figures.clear_max.map(|at| at.pixel), Some([2, 0]), "the first of two");
        assert_eq!(figures.picture.quantile(0.5).map(|median| median.value), Some(0.2));
        assert_eq!(figures.apart.quantile(0.5), Some(Estimate::exact(0.4)));
        let above = figures.picture.above(0.1).unwrap();
        assert!(above.value == 2.0 / 3.0 && above.low < 0.2 && above.high > 0.9, "{above:?}");
        assert_eq!(figures.picture.above(0.2).map(|above| above.value), Some(0.0));
        assert!((figures.picture.rms().unwrap() - (0.09_f64 / 3.0).sqrt()).abs() < 1e-12);
        // What is unknown counts nowhere, and then not all is known.
        let some = [all[0], None, all[2], all[3]];
        let figures = ErrorFigures::new(&some, &[0, 1, 2], &[1], [true; 2]);
        assert_eq!((figures.picture.count(), figures.apart.count()), (2, 0));
        assert_eq!(figures.max.map(|at| at.pixel), Some([2, 0]));
        let above = figures.picture.above(0.1).unwrap();
        assert!(above.low < above.value && above.value < above.high, "{above:?}");
        assert_eq!((ErrorSample::default().rms(), ErrorSample::default().above(0.0)), (None, None));
    }

    #[test]
    fn errors_as_displayed_stay_within_their_bounds_as_displayed() {
        let mut random = 1_u64;
        let mut next = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 11) as f64 / (1_u64 << 53) as f64
        };
        for space in [WorkingSpace::Srgb, WorkingSpace::LinearSrgb, WorkingSpace::AcesCg] {
            for _ in 0..20_000 {
                let value = [(); 3].map(|()| 1.4 * next() - 0.2);
                let bounds = [(); 3].map(|()| 10.0_f64.powf(-6.0 * next()));
                let truth = [0, 1, 2].map(|c| value[c] + (2.0 * next() - 1.0) * bounds[c]);
                let bound = size_of_bound(Kind::Color, space, &value, &bounds);
                let error = size_of_error(Kind::Color, space, &value, &truth);
                let slack = 1e-12;
                assert!(error.display <= bound.display + slack, "{space}: {value:?}, {truth:?}: {error:?}, {bound:?}");
                assert!(error.working <= bound.working + slack, "{space}: {value:?}, {truth:?}: {error:?}, {bound:?}");
            }
        }
        let none = size_of_bound(Kind::Color, WorkingSpace::AcesCg, &[0.5; 3], &[0.0; 3]);
        assert_eq!(none, ErrorSize::default());
        let unknown = size_of_bound(Kind::Color, WorkingSpace::AcesCg, &[0.5; 3], &[f64::INFINITY; 3]);
        assert_eq!((unknown.working, unknown.display <= 1.0), (f64::INFINITY, true));
        let weights = size_of_error(Kind::MASK, WorkingSpace::AcesCg, &[0.5], &[0.25]);
        assert_eq!(weights, ErrorSize { display: 0.25, working: 0.25 });
    }

    #[test]
    fn values_without_a_difference_lie_apart_by_what_is_safe() {
        let inf = f64::INFINITY;
        assert_eq!((distance(inf, inf), distance(inf, 1.0), distance(f64::NAN, 1.0)), (0.0, inf, inf));
        assert_eq!(distance(0.25, 1.0), 0.75);
    }
}
