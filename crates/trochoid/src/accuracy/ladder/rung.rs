//! A rung of a ladder: settings that are rendered, certified and measured.

use super::apart::values;
use super::errors::{ErrorFigures, ErrorSize, Known, distance, size_of_bound, size_of_error};
use super::looked::{Looked, PixelBounds, PixelReference};
use super::statistics::Estimate;
use super::turns::{Rendered, Times};
use super::{PassError, apart::place};
use trochoid_engine::{Certified, Picture};
use trochoid_image::{Window, WorkingSpace};

/// Error that an 8-bit display may show.
pub const EIGHT_BIT: f64 = 1.0 / 255.0;

/// Settings with their certified and measured errors and their cost.
#[derive(Clone, Debug)]
pub struct Rung {
    /// Assignments `NODE.KNOB=VALUE` of the settings.
    pub set: Vec<String>,
    /// Whether `plan` may choose these settings.
    pub is_method: bool,
    /// Bounds of errors; `None` if the time was too short.
    pub certified: Option<ErrorFigures>,
    /// Errors, except of pixels whose references are given up; `None` if the time was too short.
    pub measured: Option<ErrorFigures>,
    /// Largest bound that tolerances are held against, in units of the working space, if it is known: of all pixels that
    /// are not ambiguous and were looked at; of the whole picture, of all samples that are not.
    pub judged: Option<f64>,
    /// Share of pixels with ambiguous samples.
    pub ambiguous: Option<Estimate>,
    /// Share of pixels with ambiguous samples whose displayed error may exceed 1/255.
    pub ambiguous_beyond_8_bit: Option<Estimate>,
    /// Median ratio of certified to measured errors, except where one is 0: of pixels drawn in the whole picture, and of
    /// those where settings differ.
    pub ratios: [Option<f64>; 2],
    /// Pixels whose error exceeds its bound. There must be none.
    pub broken: Vec<BrokenBound>,
    /// Number of pixels of the picture outside the hull, those that are no number included.
    pub hull_exits: u64,
    /// Number of pixels of the picture with a channel that is no number.
    pub nan: u64,
    /// Times of rendering a frame.
    pub times: Times,
    /// Predicted seconds for a frame; `None` if the time was too short.
    pub predicted: Option<f64>,
    /// Seconds for certifying the whole frame; `None` if the time was too short.
    pub certify: Option<CertifyTime>,
    /// Bytes held by stages and planes.
    pub bytes: usize,
    /// Whether no other settings are certified to a smaller error in a time that is no longer beyond the spread.
    pub is_best: bool,
    /// Shares of the passes in the certified error, at chosen pixels without ambiguous samples.
    pub passes: Vec<PassError>,
    /// Bound of each pixel, in display values, row by row; empty unless the whole picture is certified.
    pub map: Vec<f32>,
    /// Picture rendered with the settings.
    pub picture: Picture,
}

/// Pixel whose error exceeds its bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrokenBound {
    /// The pixel.
    pub pixel: [i64; 2],
    /// Bound of the error of a channel.
    pub bound: f64,
    /// Error of that channel.
    pub error: f64,
}

/// Seconds for certifying a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CertifyTime {
    /// Seconds.
    pub seconds: f64,
    /// Whether they are extrapolated from a strip of the picture.
    pub is_predicted: bool,
}

/// Inputs for judging settings.
pub(super) struct Judgement<'a> {
    pub(super) looked: &'a Looked,
    pub(super) window: Window,
    pub(super) space: WorkingSpace,
    /// Pixels where settings differ, by index in the window.
    pub(super) apart: &'a [usize],
}

impl Judgement<'_> {
    /// Judges settings by what is known of pixels: by their index among all settings.
    pub(super) fn rung(
        &self,
        index: usize,
        (set, is_method): (Vec<String>, bool),
        rendered: Rendered,
        whole: Option<&Certified>,
    ) -> Option<Rung> {
        let Rendered { frame, times, predicted } = rendered;
        let planes = |picture: &Picture| picture.planes.len() * frame.window.area() * 4;
        let bytes = frame.nodes.iter().map(|node| node.bytes).sum::<usize>();
        let bytes = bytes + frame.pictures.iter().map(planes).sum::<usize>();
        let picture = frame.pictures.into_iter().next()?;
        let bounds = self.looked.bounds.get(index).and_then(Option::as_ref).map(|bounds| &bounds.pixels[..]);
        let bounded = bounds.map(|bounds| self.bounded(&picture, bounds));
        let errors = self.looked.references.as_ref().map(|references| self.errors(&picture, bounds, references));
        let draws = [&self.looked.picture, &self.looked.apart];
        let figures = |known: &Vec<Option<Known>>| {
            let [picture, apart] = draws;
            ErrorFigures::new(known, &picture.0, &apart.0, [picture.1, apart.1])
        };
        let everywhere = whole.map(|whole| self.whole(&picture, whole));
        let certified = match (&everywhere, &bounded) {
            (Some(known), _) => {
                let all: Vec<usize> = (0..known.len()).collect();
                Some(ErrorFigures::new(known, &all, self.apart, [true; 2]))
            }
            (None, known) => known.as_ref().map(figures),
        };
        let share = |has: &dyn Fn(&Known) -> bool| match (&everywhere, &bounded) {
            (Some(known), _) => {
                let count = known.iter().flatten().filter(|known| has(known)).count();
                Some(Estimate::exact(count as f64 / known.len().max(1) as f64))
            }
            (None, known) => known.as_ref().map(|known| {
                let (drawn, is_whole) = draws[0];
                let count = drawn.iter().filter(|index| known[**index].as_ref().is_some_and(has)).count();
                let share = Estimate::share(count, drawn.len());
                if *is_whole { Estimate::exact(share.value) } else { share }
            }),
        };
        let judged = match whole {
            Some(whole) => (whole.clear.total() > 0).then(|| whole.clear.max()),
            None => certified.as_ref().and_then(|certified| Some(certified.clear_max?.size.working)),
        };
        let ratio = |(draws, _): &(Vec<usize>, bool)| median_ratio(draws, bounded.as_ref()?, errors.as_ref()?);
        Some(Rung {
            set,
            is_method,
            measured: errors.as_ref().map(figures),
            judged,
            ambiguous: share(&|known| !known.is_clear),
            ambiguous_beyond_8_bit: share(&|known| !known.is_clear && known.size.display > EIGHT_BIT),
            ratios: draws.map(ratio),
            broken: self.broken(&picture, bounds),
            hull_exits: picture.audit.hull_exits,
            nan: picture.audit.nan_count,
            times,
            predicted,
            certify: None,
            bytes,
            is_best: false,
            passes: Vec::new(),
            map: everywhere.iter().flatten().flatten().map(|known| known.size.display as f32).collect(),
            certified,
            picture,
        })
    }

    fn bounded(&self, picture: &Picture, bounds: &[PixelBounds]) -> Vec<Option<Known>> {
        let known = |(pixel, bounds): (&usize, &PixelBounds)| {
            Some(self.known(picture, *pixel, &bounds.errors, bounds.is_clear))
        };
        self.looked.pixels.iter().zip(bounds).map(known).collect()
    }

    fn whole(&self, picture: &Picture, whole: &Certified) -> Vec<Option<Known>> {
        let known = |pixel: usize| {
            let errors: Vec<f64> = whole.errors.iter().map(|channel| f64::from(channel[pixel])).collect();
            Some(self.known(picture, pixel, &errors, whole.doubt[pixel] == 0.0))
        };
        (0..whole.window.area()).map(known).collect()
    }

    fn known(&self, picture: &Picture, pixel: usize, errors: &[f64], is_clear: bool) -> Known {
        let size = size_of_bound(picture.kind, self.space, &values(picture, pixel), errors);
        Known { pixel: place(self.window, pixel), size, is_clear }
    }

    /// Measures errors. Without bounds, all pixels count as clear.
    fn errors(
        &self,
        picture: &Picture,
        bounds: Option<&[PixelBounds]>,
        references: &[PixelReference],
    ) -> Vec<Option<Known>> {
        let known = |(index, (pixel, truth)): (usize, (&usize, &PixelReference))| {
            Some(Known {
                pixel: place(self.window, *pixel),
                size: size_of_error(picture.kind, self.space, &values(picture, *pixel), truth.as_ref()?),
                is_clear: bounds.is_none_or(|bounds| bounds[index].is_clear),
            })
        };
        self.looked.pixels.iter().zip(references).enumerate().map(known).collect()
    }

    /// Returns pixels with a channel whose error exceeds its bound.
    fn broken(&self, picture: &Picture, bounds: Option<&[PixelBounds]>) -> Vec<BrokenBound> {
        let (Some(bounds), Some(references)) = (bounds, &self.looked.references) else { return Vec::new() };
        let broken = |((pixel, bounds), truth): ((&usize, &PixelBounds), &PixelReference)| {
            let value = values(picture, *pixel);
            let channels = value.iter().zip(truth.as_ref()?).zip(&bounds.errors);
            let mut errors = channels.map(|((value, truth), bound)| (distance(*value, *truth), *bound));
            let (error, bound) = errors.find(|(error, bound)| error > bound)?;
            Some(BrokenBound { pixel: place(self.window, *pixel), bound, error })
        };
        self.looked.pixels.iter().zip(bounds).zip(references).filter_map(broken).collect()
    }
}

/// Returns the median ratio of bounds to errors of some pixels, except where one is 0.
fn median_ratio(draws: &[usize], bounds: &[Option<Known>], errors: &[Option<Known>]) -> Option<f64> {
    let sizes = draws.iter().filter_map(|index| Some((bounds[*index]?.size, errors[*index]?.size)));
    let known = sizes.filter(|(bound, error): &(ErrorSize, ErrorSize)| bound.working > 0.0 && error.working > 0.0);
    let mut ratios: Vec<f64> = known.map(|(bound, error)| bound.working / error.working).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::super::apart::tests::picture;
    use super::super::looked::SettingsBounds;
    use super::*;
    use trochoid_engine::{Frame, Phases};

    /// A mask of four pixels.
    fn rendered(samples: [f32; 4]) -> Rendered {
        let (nodes, seconds) = (Vec::new(), Phases::default());
        let (window, pictures) = (Window::sized(4, 1), vec![picture(&samples)]);
        let frame = Frame { number: 1, window, pictures, nodes, seconds, threads: 1 };
        Rendered { frame, times: Times::default(), predicted: None }
    }

    fn looked(bounds: [f64; 4], references: Option<[f64; 4]>) -> Looked {
        let clear = [true, true, false, true];
        let pixel = |index: usize| PixelBounds { errors: vec![bounds[index]], is_clear: clear[index] };
        Looked {
            pixels: vec![0, 1, 2, 3],
            picture: (vec![0, 1], false),
            apart: (vec![1, 2], true),
            bounds: vec![Some(SettingsBounds { pixels: (0..4).map(pixel).collect(), unbounded: Vec::new() })],
            references: references.map(|values| values.map(|value| Some(vec![value])).to_vec()),
            preparing: Some(0.0),
        }
    }

    fn judge(looked: &Looked, samples: [f32; 4]) -> Rung {
        let window = Window::sized(4, 1);
        let judgement = Judgement { looked, window, space: WorkingSpace::Srgb, apart: &[1, 2] };
        judgement.rung(0, (vec!["a.b=c".into()], true), rendered(samples), None).unwrap()
    }

    #[test]
    fn errors_are_held_against_the_bounds_of_their_pixels() {
        let bounds = [0.25, 0.25, 1.0, 0.5];
        let rung = judge(&looked(bounds, Some([0.5, 0.25, 0.0, 0.25])), [0.5, 0.5, 0.75, 0.5]);
        let (certified, measured) = (rung.certified.unwrap(), rung.measured.unwrap());
        assert_eq!(rung.broken, []);
        assert_eq!(certified.max.map(|at| (at.pixel, at.size.display)), Some(([2, 0], 1.0)));
        assert_eq!(certified.clear_max.map(|at| (at.pixel, at.size.display)), Some(([3, 0], 0.5)));
        assert_eq!(measured.max.map(|at| (at.pixel, at.size.display)), Some(([2, 0], 0.75)));
        assert_eq!(measured.clear_max.map(|at| (at.pixel, at.size.display)), Some(([1, 0], 0.25)));
        assert_eq!((measured.picture.count(), measured.apart.count(), rung.judged), (2, 2, Some(0.5)));
        // Pixel 0 has no error, so pixel 1 alone counts; of those apart, pixels 1 and 2.
        assert_eq!(rung.ratios, [Some(1.0), Some(4.0 / 3.0)]);
        assert_eq!(rung.ambiguous.map(|share| share.value), Some(0.0), "not drawn in the picture");
    }

    #[test]
    fn bounds_that_are_too_small_are_found_and_named() {
        let planted = [0.25, 0.249, 1.0, 0.5];
        let rung = judge(&looked(planted, Some([0.5, 0.25, 0.0, 0.25])), [0.5, 0.5, 0.75, 0.5]);
        assert_eq!(rung.broken, [BrokenBound { pixel: [1, 0], bound: 0.249, error: 0.25 }]);
        let unclear = [0.25, 0.25, 0.5, 0.5];
        let rung = judge(&looked(unclear, Some([0.5, 0.25, 0.0, 0.25])), [0.5, 0.5, 0.75, 0.5]);
        assert_eq!(rung.broken.len(), 1, "bounds of ambiguous pixels hold as well");
        let nan = judge(&looked(planted, Some([0.5, 0.25, 0.0, 0.25])), [0.5, f32::NAN, 0.75, 0.5]);
        assert_eq!((nan.broken.len(), nan.broken[0].error), (1, f64::INFINITY));
    }

    #[test]
    fn pixels_whose_references_are_given_up_are_not_measured() {
        let mut looked = looked([0.25; 4], Some([0.5; 4]));
        looked.references.as_mut().unwrap()[2] = None;
        let rung = judge(&looked, [0.5, 0.75, 9.0, 0.5]);
        let (certified, measured) = (rung.certified.unwrap(), rung.measured.unwrap());
        assert_eq!((looked.given_up(), rung.broken.len()), (1, 0));
        assert_eq!((certified.apart.count(), measured.apart.count()), (2, 1));
        assert_eq!(measured.max.map(|at| (at.pixel, at.size.display)), Some(([1, 0], 0.25)));
    }

    #[test]
    fn what_there_was_no_time_for_is_unknown() {
        let rung = judge(&looked([0.25; 4], None), [0.5; 4]);
        assert!(rung.measured.is_none() && rung.broken.is_empty() && rung.ratios == [None; 2]);
        assert!(rung.certified.is_some());
        let rung = judge(&Looked { bounds: vec![None], ..looked([0.25; 4], Some([0.5; 4])) }, [0.25; 4]);
        assert!(rung.certified.is_none() && rung.judged.is_none() && rung.ambiguous.is_none());
        assert_eq!(rung.measured.unwrap().max.map(|at| at.size.working), Some(0.25));
    }
}
