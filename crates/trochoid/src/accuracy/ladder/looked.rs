//! Pixels that are looked at: the same ones with all settings, by their bounds and by their references.

use super::apart::{Apart, place};
use super::budget::{Budget, Deadline, Phase, doublings};
use super::request::{Effort, LadderRequest};
use super::strata::Strata;
use super::{Request, TargetError};
use std::collections::HashMap;
use trochoid_engine::{
    Buffers, Cache, CertifiedPixels, Certifier, EvalError, ReferenceError, ReferenceFrame, ReferencePixel,
};
use trochoid_graph::{CheckedGraph, NodeId};
use trochoid_image::Window;

/// Number of pixels of the first round, if time decides how many there are.
const FIRST: usize = 16;

/// What is certified of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PixelBounds {
    /// Bound of each channel's error.
    pub(super) errors: Vec<f64>,
    /// Whether no sample is ambiguous.
    pub(super) is_clear: bool,
}

/// What is certified with some settings.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct SettingsBounds {
    /// By pixel.
    pub(super) pixels: Vec<PixelBounds>,
    /// Stages upstream that know no bound, and why.
    pub(super) unbounded: Vec<(NodeId, &'static str)>,
}

/// Reference of a pixel, by channel; `None` if it is given up, because it takes more effort than is reasonable.
pub(super) type PixelReference = Option<Vec<f64>>;

/// Pixels, each once, with what is known of them.
#[derive(Debug, Default)]
pub(super) struct Looked {
    /// By index in the window, in the order in which they were drawn.
    pub(super) pixels: Vec<usize>,
    /// Draws in the whole picture, by index in `pixels`, and whether these are all pixels.
    pub(super) picture: (Vec<usize>, bool),
    /// Draws where settings differ, and whether these are all such pixels.
    pub(super) apart: (Vec<usize>, bool),
    /// By settings; `None` where the time was too short.
    pub(super) bounds: Vec<Option<SettingsBounds>>,
    /// By pixel, then by channel; `None` if the time was too short.
    pub(super) references: Option<Vec<PixelReference>>,
    /// Seconds that preparing takes before the first bound; `None` if there is none.
    pub(super) preparing: Option<f64>,
}

/// What is looked at, and with what.
pub(super) struct Looking<'a> {
    pub(super) asked: &'a LadderRequest<'a>,
    /// The document, whose references hold for all settings.
    pub(super) document: &'a CheckedGraph,
    pub(super) graphs: &'a [CheckedGraph],
    pub(super) apart: &'a Apart,
    pub(super) budget: &'a Budget<'a>,
}

/// New pixels, and what was found of them.
struct Round {
    bounds: Vec<Option<SettingsBounds>>,
    references: Option<Vec<PixelReference>>,
}

impl Looking<'_> {
    /// Draws pixels and looks at them: in rounds, as long as there is time, or all at once.
    pub(super) fn look(&self, cache: &mut Cache) -> Result<Looked, TargetError> {
        let window = self.document.format().window();
        let extents = [[window.width(), window.height()], [self.apart.pixels.len(), 0]];
        let mut strata = extents.map(|extent| Strata::new(extent, self.asked.seed));
        let (first, most) = match self.asked.effort {
            Effort::Within(_) => (FIRST, Effort::MOST),
            Effort::Pixels(count) | Effort::Whole(count) => [count.next_power_of_two(); 2].into(),
        };
        let mut looked = Looked { preparing: self.prepare(window, cache)?, ..Looked::default() };
        if looked.preparing.is_none() {
            return Ok(looked);
        }
        let mut doubled = first.trailing_zeros();
        loop {
            strata.iter_mut().for_each(|strata| (0..doubled).for_each(|_| strata.halve()));
            let started = self.budget.now();
            let (new, drawn) = looked.drawn(&strata, self.apart, window);
            let round = self.round(&new, window, cache)?;
            let is_complete = round.is_complete();
            if !looked.pixels.is_empty() && !is_complete {
                break;
            }
            let count = new.len();
            looked.add(new, drawn, round);
            let seconds = self.budget.now() - started;
            let left = self.budget.left(Phase::Pixels);
            doubled = doublings(strata[0].count(), count, seconds, left, most.min(window.area().next_power_of_two()));
            if doubled == 0 || !is_complete {
                break;
            }
        }
        Ok(looked)
    }

    /// Prepares bounds with the first settings; returns the seconds, or `None` if they do not fit into the time.
    fn prepare(&self, window: Window, cache: &mut Cache) -> Result<Option<f64>, TargetError> {
        let started = self.budget.now();
        let Some(graph) = self.graphs.first() else { return Ok(None) };
        let found = self.bounds(graph, &[place(window, 0)], cache)?;
        Ok(found.map(|_| self.budget.now() - started))
    }

    fn round(&self, pixels: &[usize], window: Window, cache: &mut Cache) -> Result<Round, TargetError> {
        let places: Vec<[i64; 2]> = pixels.iter().map(|pixel| place(window, *pixel)).collect();
        let mut bounds = Vec::new();
        for graph in self.graphs {
            bounds.push(self.bounds(graph, &places, cache)?);
            self.budget.step();
        }
        let references = self.references(&places, cache)?;
        self.budget.step();
        Ok(Round { bounds, references })
    }

    /// Bounds the errors of some pixels; `None` if the time is too short.
    fn bounds(
        &self,
        graph: &CheckedGraph,
        places: &[[i64; 2]],
        cache: &mut Cache,
    ) -> Result<Option<SettingsBounds>, TargetError> {
        let Request { outputs, frame, settings, .. } = self.asked.request;
        let deadline = self.budget.until(Phase::Pixels);
        let certifier = Certifier::new(graph, outputs, frame, &[], settings)?;
        let Some(found) = in_time(certifier.certify_pixels(places, &Buffers::new(), cache, &deadline), &deadline)?
        else {
            return Ok(None);
        };
        let of = |CertifiedPixels { errors, doubt, unbounded, .. }: &CertifiedPixels| {
            let pixel = |index: usize| PixelBounds {
                errors: errors.iter().map(|channel| f64::from(channel[index])).collect(),
                is_clear: doubt[index] == 0.0,
            };
            SettingsBounds { pixels: (0..places.len()).map(pixel).collect(), unbounded: unbounded.clone() }
        };
        Ok(found.first().map(of))
    }

    /// Evaluates the references of some pixels; `None` if the time is too short.
    fn references(&self, places: &[[i64; 2]], cache: &mut Cache) -> Result<Option<Vec<PixelReference>>, TargetError> {
        let Request { outputs, frame, .. } = self.asked.request;
        let deadline = self.budget.until(Phase::Pixels);
        let found = match ReferenceFrame::beside_bounds(self.document, outputs, frame, cache, &deadline) {
            Ok(reference) => reference.pixels_in_reach(places, &deadline),
            Err(ReferenceError::Plan(error)) => return Err(error.into()),
            Err(ReferenceError::Eval(error)) => Err(error),
        };
        let found = in_time(found, &deadline)?;
        let value = |mut outputs: Vec<Option<ReferencePixel>>| outputs.swap_remove(0).map(|pixel| pixel.value);
        Ok(found.map(|pixels| pixels.into_iter().map(value).collect()))
    }
}

/// Returns what was found, or `None` if the end of the time stopped the work.
pub(super) fn in_time<T>(found: Result<T, EvalError>, deadline: &Deadline<'_>) -> Result<Option<T>, TargetError> {
    match found {
        Err(EvalError::Cancelled) if deadline.is_over() => Ok(None),
        found => Ok(Some(found?)),
    }
}

impl Round {
    fn is_complete(&self) -> bool {
        self.references.is_some() && self.bounds.iter().all(Option::is_some)
    }
}

/// Draws in the whole picture, and where settings differ, with whether these are all pixels.
type Draws = [(Vec<usize>, bool); 2];

impl Looked {
    /// Returns the number of pixels whose references are given up.
    pub(super) fn given_up(&self) -> usize {
        self.references.iter().flatten().filter(|reference| reference.is_none()).count()
    }

    /// Returns pixels that were not looked at yet, and all draws, by index in all pixels with the new ones.
    fn drawn(&self, strata: &[Strata; 2], apart: &Apart, window: Window) -> (Vec<usize>, Draws) {
        let [picture, differing] = strata;
        let mut index: HashMap<usize, usize> = self.pixels.iter().enumerate().map(|(at, pixel)| (*pixel, at)).collect();
        let mut new = Vec::new();
        let mut of = |pixels: &mut dyn Iterator<Item = usize>| -> Vec<usize> {
            let at = |pixel: usize| {
                let next = index.len();
                *index.entry(pixel).or_insert_with(|| {
                    new.push(pixel);
                    next
                })
            };
            pixels.map(at).collect()
        };
        let [all, all_apart] = [window.area(), apart.pixels.len()].map(|all| picture.count() >= all);
        let in_picture = match all {
            true => of(&mut (0..window.area())),
            false => of(&mut picture.cells().map(|[x, y]| y * window.width() + x)),
        };
        let where_apart = match all_apart {
            true => of(&mut apart.pixels.iter().copied()),
            false => of(&mut differing.cells().map(|[rank, _]| apart.pixels[rank])),
        };
        of(&mut apart.most.iter().copied());
        (new, [(in_picture, all), (where_apart, all_apart)])
    }

    fn add(&mut self, new: Vec<usize>, [picture, apart]: Draws, round: Round) {
        if self.pixels.is_empty() {
            (self.bounds, self.references) = (round.bounds, round.references);
        } else {
            for (all, new) in self.bounds.iter_mut().flatten().zip(round.bounds.into_iter().flatten()) {
                all.pixels.extend(new.pixels);
                let unknown: Vec<_> =
                    new.unbounded.into_iter().filter(|stage| !all.unbounded.contains(stage)).collect();
                all.unbounded.extend(unknown);
            }
            self.references.iter_mut().zip(round.references).for_each(|(all, new)| all.extend(new));
        }
        self.pixels.extend(new);
        (self.picture, self.apart) = (picture, apart);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strata(count: u32, apart: usize) -> [Strata; 2] {
        let mut both = [Strata::new([16, 8], 1), Strata::new([apart, 0], 1)];
        both.iter_mut().for_each(|strata| (0..count).for_each(|_| strata.halve()));
        both
    }

    #[test]
    fn each_pixel_is_looked_at_once_and_draws_name_it() {
        let window = Window::sized(16, 8);
        let apart = Apart { pixels: (0..40).map(|pixel| 3 * pixel).collect(), most: vec![0, 127] };
        let mut looked = Looked::default();
        for count in [3, 5] {
            let (new, [picture, differing]) = looked.drawn(&strata(count, 40), &apart, window);
            let nothing = PixelBounds { errors: vec![0.5], is_clear: true };
            let bounds = vec![Some(SettingsBounds { pixels: vec![nothing; new.len()], unbounded: Vec::new() })];
            let references = Some(vec![Some(vec![0.0]); new.len()]);
            looked.add(new, [picture, differing], Round { bounds, references });
            assert_eq!((looked.picture.0.len(), looked.apart.0.len()), (1 << count, 1 << count));
            let known: std::collections::HashSet<usize> = looked.pixels.iter().copied().collect();
            assert_eq!(known.len(), looked.pixels.len(), "a pixel twice");
            assert!(known.contains(&0) && known.contains(&127), "where settings differ most");
            assert!(looked.apart.0.iter().all(|at| looked.pixels[*at] % 3 == 0 && looked.pixels[*at] < 120));
            assert_eq!(looked.bounds[0].as_ref().map(|bounds| bounds.pixels.len()), Some(looked.pixels.len()));
            assert_eq!((looked.picture.1, looked.apart.1), (false, false));
        }
        // As many as there are: all of them.
        let (_, [picture, differing]) = looked.drawn(&strata(7, 40), &apart, window);
        assert_eq!((picture.0.len(), picture.1, differing.0.len(), differing.1), (128, true, 40, true));
    }
}
