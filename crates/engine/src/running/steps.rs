//! Divides the filling of a pass into steps: what filters read far around a tile is filled first, over the whole picture.
//!
//! Without steps, a tile also fills what its filters read beyond it, and its neighbors fill that again. Behind filters of
//! filters, a tile holds and fills several times its own pixels.

use super::fill::by_slot;
use crate::Plan;
use crate::planning::plan::Pass;
use crate::planning::schedule::{Reach, larger, reads};
use std::collections::{BTreeSet, HashMap};

/// Most pixels beyond a tile that a stage fills together with it.
const FAR: usize = 16;

/// Steps in which the fills of a pass are filled, counted from the last one, which is 0 and also runs the program.
#[derive(Debug, Default)]
pub(crate) struct Steps {
    /// Steps of each fill; none if nothing of it is needed.
    of: Vec<BTreeSet<usize>>,
    /// Fills whose planes have to be whole before the next step, with the last step that reads them.
    whole: HashMap<usize, usize>,
    /// How far the stages of any step reach beyond its tiles.
    halo: Reach,
}

impl Steps {
    /// Divides a pass. Fills that are `known` take no part; only fills that `can_wait` for all of their pixels begin a step.
    pub(crate) fn new(
        plan: &Plan<'_>,
        pass: &Pass,
        known: &dyn Fn(usize) -> bool,
        can_wait: &dyn Fn(usize) -> bool,
    ) -> Self {
        let fills = &pass.fills;
        let by_slot = by_slot(fills);
        let mut steps = Self { of: vec![BTreeSet::new(); fills.len()], ..Self::default() };
        let mut beyond: Vec<Reach> = vec![(0, 0); fills.len()];
        let mut has_readers = vec![false; fills.len()];
        for (index, fill) in fills.iter().enumerate().rev() {
            // All that read it come after it. What nothing reads is filled too, where demand is switched off.
            if fill.read || !has_readers[index] {
                steps.of[index].insert(0);
            }
            let (own, is_far) = (&steps.of[index], beyond[index].0.max(beyond[index].1) > FAR);
            let (first, last) = (own.last().copied(), own.first().copied());
            let is_needed = !known(index) && !own.is_empty();
            if !is_needed {
                steps.of[index].clear();
            } else if let (Some(first), Some(last)) = (first, last)
                && (is_far || first > last)
                && can_wait(index)
            {
                let step = if is_far { first + 1 } else { first };
                steps.whole.insert(index, last);
                steps.of[index] = BTreeSet::from([step]);
                if is_far {
                    beyond[index] = (0, 0);
                }
            }
            let own = steps.of[index].clone();
            let stage = plan.stage(fill.node);
            for (slot, reach) in reads(fill, stage, plan.graph.format(), beyond[index]) {
                let Some(&input) = by_slot.get(&slot) else { continue };
                has_readers[input] = true;
                if is_needed {
                    steps.of[input].extend(&own);
                    beyond[input] = larger(beyond[input], reach);
                    steps.halo = larger(steps.halo, reach);
                }
            }
        }
        steps
    }

    /// Returns the number of steps.
    pub(crate) fn count(&self) -> usize {
        self.of.iter().filter_map(|steps| steps.last()).max().map_or(1, |step| step + 1)
    }

    pub(crate) fn halo(&self) -> Reach {
        self.halo
    }

    /// Returns whether nothing of a fill is needed, or nothing new.
    pub(crate) fn is_idle(&self, fill: usize) -> bool {
        self.of[fill].is_empty()
    }

    /// Returns whether a fill takes part in a step.
    pub(crate) fn takes_part(&self, fill: usize, step: usize) -> bool {
        self.of[fill].contains(&step)
    }

    /// Returns whether the planes of a fill must be whole before the next step.
    pub(crate) fn is_whole(&self, fill: usize) -> bool {
        self.whole.contains_key(&fill)
    }

    /// Returns whether whole planes of a fill are read after a step.
    pub(crate) fn is_read_after(&self, fill: usize, step: usize) -> bool {
        self.whole.get(&fill).is_some_and(|last| *last < step)
    }

    /// Returns the most bytes of whole planes that are held at once, without those that are `kept` anyway.
    pub(crate) fn held(&self, kept: &dyn Fn(usize) -> bool, bytes: &dyn Fn(usize) -> usize) -> usize {
        let held = |step: usize| {
            let at = self.whole.iter().filter(|(fill, last)| {
                !kept(**fill) && **last <= step && self.of[**fill].last().is_some_and(|first| *first >= step)
            });
            at.map(|(fill, _)| bytes(*fill)).fold(0, usize::saturating_add)
        };
        (0..self.count()).map(held).max().unwrap_or(0)
    }
}
