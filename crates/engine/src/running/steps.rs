//! Divides the filling of a pass into steps: what filters read far around a tile is filled first, over the whole picture.
//!
//! Without steps, a tile also fills what its filters read beyond it, and its neighbors fill that again. Behind filters of
//! filters, a tile holds and fills several times its own pixels. Planes over the whole picture cost memory instead, and the
//! time to write and read them; so planes are held where tiles would spend more time on filling again.

use super::fill::by_slot;
use super::tile_size::Load;
use crate::Plan;
use crate::planning::plan::{Fill, Pass};
use crate::planning::schedule::{Reach, Reads, larger, read_before};
use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};
use trochoid_graph::{NodeId, Slot, Variance};

/// Time that a stage takes to fill a sample of a plane, in units of the time to write and read it: about that of a short
/// formula. Views and noise take several times as long.
const STAGE: f64 = 4.0;

/// The same for a costly stage, such as a filter.
const COSTLY: f64 = 16.0;

/// Least shares of a picture's pixels that tiles fill again for planes to be held, and if memory is too short for these.
const AGAIN: [f64; 2] = [0.05, 0.5];

/// Planes that are held over the whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Whole {
    /// Those of a fill.
    Fill(usize),
    /// Those of the program before a fill.
    Taps(usize),
}

impl Whole {
    /// Returns the number of planes for each sample of a pixel.
    pub(crate) fn channels(self, pass: &Pass) -> usize {
        match self {
            Self::Fill(fill) => pass.fills[fill].planes(),
            Self::Taps(fill) => pass.fills[fill].taps.iter().flat_map(|taps| &taps.roots).sum(),
        }
    }
}

/// Steps in which the fills of a pass are filled, counted from the last one, which is 0 and also runs the program.
#[derive(Debug, Default)]
pub(crate) struct Steps {
    /// Steps of each fill; none if nothing of it is needed.
    of: Vec<BTreeSet<usize>>,
    /// Planes that have to be whole before the next step: the step that fills them, and the last one that reads them.
    whole: HashMap<Whole, [usize; 2]>,
    /// The work of each step on a tile and beyond it.
    loads: Vec<Load>,
}

impl Steps {
    /// Returns the ways to divide a pass, from the one that holds the most planes on to the one that holds none. Fills that are
    /// `known` take no part; only planes that `can_wait` for all of their pixels begin a step.
    pub(crate) fn ways<'w>(
        plan: &'w Plan<'_>,
        pass: &'w Pass,
        known: &'w dyn Fn(usize) -> bool,
        can_wait: &'w dyn Fn(Whole) -> bool,
    ) -> impl Iterator<Item = Self> + 'w {
        let shares: RefCell<HashMap<Reach, f64>> = RefCell::default();
        let [often, seldom] = AGAIN;
        let ways = [(true, true, often), (true, false, often), (true, false, seldom), (false, false, f64::INFINITY)];
        ways.into_iter().map(move |(fills, taps, least)| {
            let is_meant = |planes: Whole| if matches!(planes, Whole::Fill(_)) { fills } else { taps };
            Self::new(plan, pass, known, &|planes| is_meant(planes) && can_wait(planes), least, &shares)
        })
    }

    /// Divides a pass. Fills that are `known` take no part; only planes that `can_wait` for all of their pixels begin a step,
    /// and only where tiles would fill at least this share of the pixels again. `shares` are those of reaches that were asked for
    /// before.
    fn new(
        plan: &Plan<'_>,
        pass: &Pass,
        known: &dyn Fn(usize) -> bool,
        can_wait: &dyn Fn(Whole) -> bool,
        least: f64,
        shares: &RefCell<HashMap<Reach, f64>>,
    ) -> Self {
        let fills = &pass.fills;
        let by_slot = by_slot(fills);
        let filled_again = |reach: Reach| match reach {
            (0, 0) => 0.0,
            _ => *shares.borrow_mut().entry(reach).or_insert_with(|| plan.filled_again(reach)),
        };
        let pays = |reach: Reach, planes: usize, upstream: &dyn Fn() -> usize| {
            let again = filled_again(reach);
            again > least && STAGE * again * upstream() as f64 > planes as f64
        };
        let mut steps = Self { of: vec![BTreeSet::new(); fills.len()], ..Self::default() };
        let mut beyond: Vec<Reach> = vec![(0, 0); fills.len()];
        let mut has_readers = vec![false; fills.len()];
        // Planes that are read, with the step and how far beyond a tile.
        let mut reads_of: Vec<(usize, Reach, usize)> = Vec::new();
        for (index, fill) in fills.iter().enumerate().rev() {
            // All that read it come after it. What nothing reads is filled too, where demand is switched off.
            if fill.read || !has_readers[index] {
                steps.of[index].insert(0);
            }
            let own = &steps.of[index];
            let is_needed = !known(index) && !own.is_empty();
            let whole = Whole::Fill(index);
            let all = || upstream(fills, &by_slot, fill.slots().copied(), known) + whole.channels(pass);
            let can_be_whole = is_needed && can_wait(whole);
            let is_far = can_be_whole && pays(beyond[index], whole.channels(pass), &all);
            if !is_needed {
                steps.of[index].clear();
            } else if let (Some(&first), Some(&last)) = (own.last(), own.first())
                && can_be_whole
                && (is_far || first > last)
            {
                let step = if is_far { first + 1 } else { first };
                steps.whole.insert(whole, [step, last]);
                steps.of[index] = BTreeSet::from([step]);
                if is_far {
                    beyond[index] = (0, 0);
                }
            }
            let own = steps.of[index].clone();
            let stage = plan.stage(fill.node);
            let reads = Reads::of(fill, stage, plan.graph.format(), beyond[index]);
            let time = if stage.is_some_and(|stage| stage.is_costly()) { COSTLY } else { STAGE };
            let time = time * whole.channels(pass) as f64;
            // Inputs with the steps in which they are read, and how far beyond a tile.
            let with_input = |slot: Slot, steps: &BTreeSet<usize>, reach: Reach| {
                by_slot.get(&slot).map(|input| (*input, steps.clone(), reach))
            };
            let mut inputs: Vec<(usize, BTreeSet<usize>, Reach)> =
                reads.planes.iter().filter_map(|(slot, reach)| with_input(*slot, &own, *reach)).collect();
            let mut before = (own.clone(), reads.taps);
            if let (true, Some(&first), Some(&last)) = (is_needed, own.last(), own.first()) {
                // Filters that read whole planes reach beyond tiles too, and compute about half of their work again.
                let reach = inputs.iter().map(|(.., reach)| *reach).chain([reads.taps]).fold((0, 0), larger);
                own.iter().for_each(|step| steps.take_time(*step, [beyond[index], reach], time));
                let whole = Whole::Taps(index);
                let programs = || upstream(fills, &by_slot, read_before(fill), known);
                if can_wait(whole) && pays(reads.taps, whole.channels(pass), &programs) {
                    steps.whole.insert(whole, [first + 1, last]);
                    before = (BTreeSet::from([first + 1]), (0, 0));
                }
            }
            if is_needed {
                let read =
                    inputs.iter().flat_map(|(input, steps, reach)| steps.iter().map(|step| (*step, *reach, *input)));
                reads_of.extend(read);
            }
            inputs.extend(read_before(fill).filter_map(|slot| with_input(slot, &before.0, before.1)));
            for (input, own, reach) in inputs {
                has_readers[input] = true;
                if is_needed {
                    steps.of[input].extend(own);
                    beyond[input] = larger(beyond[input], reach);
                }
            }
        }
        for (step, reach, input) in reads_of {
            if known(input) || steps.is_whole(Whole::Fill(input)) {
                steps.loads[step].copy(reach);
            }
        }
        steps
    }

    /// Returns the number of steps.
    pub(crate) fn count(&self) -> usize {
        let whole = self.whole.values().map(|[first, _]| first);
        self.of.iter().filter_map(|steps| steps.last()).chain(whole).max().map_or(1, |step| step + 1)
    }

    /// Returns the work of the stages of a step.
    pub(crate) fn load(&self, step: usize) -> Load {
        self.loads.get(step).cloned().unwrap_or_default()
    }

    fn take_time(&mut self, step: usize, reaches: [Reach; 2], time: f64) {
        let count = self.loads.len().max(step + 1);
        self.loads.resize(count, Load::default());
        reaches.into_iter().for_each(|reach| self.loads[step].add(reach, time / 2.0));
    }

    /// Returns whether nothing of a fill is needed, or nothing new.
    pub(crate) fn is_idle(&self, fill: usize) -> bool {
        self.of[fill].is_empty()
    }

    /// Returns whether a fill takes part in a step.
    pub(crate) fn takes_part(&self, fill: usize, step: usize) -> bool {
        self.of[fill].contains(&step)
    }

    /// Lists all planes that must be whole before some step.
    pub(crate) fn whole(&self) -> impl Iterator<Item = Whole> {
        self.whole.keys().copied()
    }

    /// Lists the planes that must be whole after a step.
    pub(crate) fn filled_by(&self, step: usize) -> impl Iterator<Item = Whole> {
        self.whole.iter().filter(move |(_, [first, _])| *first == step).map(|(planes, _)| *planes)
    }

    /// Returns whether a step fills some whole planes.
    pub(crate) fn is_filled_by(&self, planes: Whole, step: usize) -> bool {
        self.whole.get(&planes).is_some_and(|[first, _]| *first == step)
    }

    /// Returns whether some whole planes are filled by a step before this one.
    pub(crate) fn is_filled_before(&self, planes: Whole, step: usize) -> bool {
        self.whole.get(&planes).is_some_and(|[first, _]| *first > step)
    }

    /// Returns whether some planes must be whole before the next step.
    pub(crate) fn is_whole(&self, planes: Whole) -> bool {
        self.whole.contains_key(&planes)
    }

    /// Returns whether some whole planes are read after a step.
    pub(crate) fn is_read_after(&self, planes: Whole, step: usize) -> bool {
        self.whole.get(&planes).is_some_and(|[_, last]| *last < step)
    }

    /// Returns the most bytes of whole planes that are held at once, without those of fills that are `kept` anyway.
    pub(crate) fn held(&self, kept: &dyn Fn(usize) -> bool, bytes: &dyn Fn(Whole) -> usize) -> usize {
        let is_kept = |planes: Whole| matches!(planes, Whole::Fill(fill) if kept(fill));
        let held = |step: usize| {
            let at = self
                .whole
                .iter()
                .filter(|(planes, [first, last])| !is_kept(**planes) && (*last..=*first).contains(&step));
            at.map(|(planes, _)| bytes(*planes)).fold(0, usize::saturating_add)
        };
        (0..self.count()).map(held).max().unwrap_or(0)
    }
}

impl Plan<'_> {
    /// Returns whether planes may be held over the whole picture, given which nodes have an image of just that size.
    pub(super) fn can_hold(&self, pass: &Pass, planes: Whole, is_picture: &dyn Fn(NodeId) -> bool) -> bool {
        let (Whole::Fill(index) | Whole::Taps(index)) = planes;
        let fill = &pass.fills[index];
        self.settings.switches.hold
            && match planes {
                // What varies along one axis costs almost nothing to refill.
                Whole::Fill(_) => fill.variance == Variance::Pixel && is_picture(fill.node),
                // Others run the program before them at single pixels.
                Whole::Taps(_) => fill.shared.is_none() && self.stage(fill.node).is_some_and(|s| !s.is_pixelwise()),
            }
    }

    /// Returns the bytes of whole planes.
    pub(super) fn bytes_of(&self, pass: &Pass, planes: Whole) -> usize {
        let plane = self.graph.format().window().area().saturating_mul(4 * pass.offsets.len());
        plane.saturating_mul(planes.channels(pass))
    }
}

/// Returns the number of planes of all fills that planes depend on, except for known ones.
fn upstream(
    fills: &[Fill],
    by_slot: &HashMap<Slot, usize>,
    from: impl Iterator<Item = Slot>,
    known: &dyn Fn(usize) -> bool,
) -> usize {
    let mut seen = BTreeSet::new();
    let mut open: Vec<usize> = from.filter_map(|slot| by_slot.get(&slot).copied()).collect();
    while let Some(index) = open.pop() {
        if !known(index) && seen.insert(index) {
            open.extend(fills[index].slots().filter_map(|slot| by_slot.get(slot)));
        }
    }
    seen.into_iter().map(|index| fills[index].planes()).sum()
}
