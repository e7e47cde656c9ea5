//! Planes that stages filled, kept for the next evaluation: an edit refills only what depends on it.

use super::prepare::{Cache, PreparedStage, key_of_planes};
use super::steps::{Steps, Whole};
use super::tile_size::Load;
use crate::planning::plan::{Fill, Pass};
use crate::{Keep, Plan};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError};
use trochoid_graph::{FrameContext, Key, NodeId, Settled, Variance};
use trochoid_image::Window;
use trochoid_memory::zeros;

/// A stage's planes over the whole picture, by sample, output and channel; empty where not wanted.
#[derive(Debug)]
pub(crate) struct StagePlanes {
    pub(crate) samples: Vec<Vec<Vec<Vec<f32>>>>,
}

impl StagePlanes {
    pub(crate) fn bytes(&self) -> usize {
        self.samples.iter().flatten().flatten().map(|plane| 4 * plane.len()).sum()
    }

    /// Whether the planes are of a picture with fewer pixels.
    pub(crate) fn is_smaller(&self, area: usize) -> bool {
        self.samples.iter().flatten().flatten().all(|plane| plane.len() < area)
    }
}

/// Planes of whole pictures while a plan is evaluated: known ones, those that one step fills for later ones, and those that
/// will be kept.
#[derive(Debug, Default)]
pub(crate) struct PlaneKeeper {
    /// Planes of earlier evaluations and steps, by the index of the fill: a stage has several fills if its samples share
    /// only some channels.
    known: HashMap<Whole, Arc<StagePlanes>>,
    /// Planes that the current step fills, tile by tile.
    new: HashMap<Whole, Mutex<StagePlanes>>,
    /// Keys of the planes to keep.
    keys: HashMap<usize, Key>,
    /// Planes to keep that are filled.
    kept: Vec<(Key, Arc<StagePlanes>)>,
    /// `None` if all is filled in one step.
    steps: Option<Steps>,
    /// The current step, counted from the last one.
    step: usize,
    /// Planes of steps that no later one reads, whose memory the next ones fill again.
    spare: Vec<Vec<f32>>,
    /// Stages that fill nothing.
    pub(crate) spared: Vec<NodeId>,
}

impl PlaneKeeper {
    /// Looks up the planes that a plan's stages filled before. Of the others that are needed, those nearest to the outputs are
    /// kept first: they are needed after the most edits, and stand for all before them. `held` is what prepared stages will
    /// hold, in bytes: more than they hold now, if they decode files on demand. Steps take at most `spare` bytes.
    pub(crate) fn new(
        plan: &Plan<'_>,
        ready: &HashMap<NodeId, PreparedStage>,
        [held, spare]: [usize; 2],
        cache: &mut Cache,
    ) -> Self {
        let mut keeper = Self { step: 1, ..Self::default() };
        let Some(pass) = plan.whole_pass() else { return keeper };
        let picture = plan.graph.format().window();
        let extents = super::fill::extents(plan, ready, &pass.fills);
        let is_picture = |node: NodeId| extents.get(&node) == Some(&picture);
        // Planes kept hold no pixels beyond the picture, and what varies along one axis costs almost nothing to
        // refill.
        let can_wait = |index: usize| {
            let fill = &pass.fills[index];
            fill.variance == Variance::Pixel && is_picture(fill.node)
        };
        let can_hold = |planes: Whole| plan.can_hold(pass, planes, &is_picture);
        let mut unknown = Vec::new();
        let keeps = plan.settings.keep != Keep::Nothing;
        for (index, fill) in pass.fills.iter().enumerate().filter(|(index, _)| keeps && can_wait(*index)) {
            let Some(key) = ready.get(&fill.node).map(|ready| key_of_planes(plan, pass, fill, ready)) else { continue };
            match cache.planes(&key) {
                Some(filled) => _ = keeper.known.insert(Whole::Fill(index), filled),
                None => unknown.push((index, fill, key)),
            }
        }
        let known_before: HashSet<Whole> = keeper.known.keys().copied().collect();
        let is_known = |fill: usize| known_before.contains(&Whole::Fill(fill));
        let mut ways = Steps::ways(plan, pass, &is_known, &can_hold);
        let Some(mut steps) = ways.next() else { return keeper };
        let is_spared = |node: NodeId| {
            let mut fills = pass.fills.iter().enumerate().filter(|(_, fill)| fill.node == node);
            fills.all(|(index, _)| steps.is_idle(index))
        };
        keeper.spared = pass.fills.iter().map(|fill| fill.node).filter(|node| is_spared(*node)).collect();
        unknown.retain(|(index, ..)| !steps.is_idle(*index));
        if plan.settings.keep == Keep::ForFrames && !unknown.is_empty() {
            let still = plan.still();
            unknown.retain(|(_, fill, _)| still[fill.node.0]);
        }
        let now: usize = ready.values().map(|ready| ready.prepared.bytes()).sum();
        let prepared = now.max(held);
        let known: usize = keeper.known.values().map(|filled| filled.bytes()).sum();
        // Coarse pictures of the same edit go before the whole one, and after the next edit again.
        let coarse = cache.recent(picture.area()).saturating_sub(now);
        // Estimates saturate.
        let mut room = cache.limit().saturating_sub(prepared.saturating_add(known).saturating_add(coarse));
        let bytes = |whole: Whole| plan.bytes_of(pass, whole);
        let mut taken = prepared - now;
        for (index, _, key) in unknown.into_iter().rev() {
            let Some(left) = room.checked_sub(bytes(Whole::Fill(index))) else { continue };
            room = left;
            taken = taken.saturating_add(bytes(Whole::Fill(index)));
            keeper.keys.insert(index, key);
        }
        // Old planes go before new ones take memory.
        if keeps {
            cache.make_way(taken);
        }
        while steps.held(&|fill| keeper.keys.contains_key(&fill), &bytes) > spare {
            let Some(fewer) = ways.next() else { break };
            steps = fewer;
        }
        drop(ways);
        keeper.step = steps.count();
        keeper.steps = Some(steps);
        keeper
    }

    /// Begins the next step, and makes room for the planes that it fills; returns `false` after the last one.
    pub(crate) fn begin_step(&mut self, plan: &Plan<'_>) -> bool {
        let (Some(steps), Some(pass)) = (&self.steps, plan.whole_pass()) else {
            return std::mem::replace(&mut self.step, 0) > 0;
        };
        let Some(step) = self.step.checked_sub(1) else { return false };
        self.step = step;
        let area = plan.graph.format().window().area();
        let kept = self.keys.keys().copied().filter(|fill| steps.takes_part(*fill, step)).map(Whole::Fill);
        let filled: Vec<Whole> = steps.filled_by(step).chain(kept).collect();
        let count: usize = filled.iter().map(|whole| whole.channels(pass) * pass.offsets.len()).sum();
        // All threads ask for memory, and get it from the system: tiles would wait for each other's.
        let missing = count.saturating_sub(self.spare.len());
        self.spare.par_extend((0..missing).into_par_iter().map(|_| zeros(area)));
        // Tiles fill all samples, so that nothing is left of what a spare plane held.
        let spare = &mut self.spare;
        let mut plane = |wanted: bool| match wanted {
            true => spare.pop().unwrap_or_else(|| zeros(area)),
            false => Vec::new(),
        };
        for whole in filled {
            let mut planes = || match whole {
                Whole::Fill(fill) => {
                    let wanted = pass.fills[fill].wanted.iter();
                    wanted.map(|channels| channels.iter().map(|wanted| plane(*wanted)).collect()).collect()
                }
                Whole::Taps(fill) => {
                    let channels = tap_channels(&pass.fills[fill]);
                    channels.map(|channels| (0..channels).map(|_| plane(true)).collect()).collect()
                }
            };
            let samples = pass.offsets.iter().map(|_| planes()).collect();
            self.new.insert(whole, Mutex::new(StagePlanes { samples }));
        }
        if step == 0 {
            self.spare = Vec::new();
        }
        true
    }

    /// Ends a step once every tile is done: what it filled is known to the next one, and what no later one reads goes.
    pub(crate) fn end_step(&mut self) {
        let Some(steps) = &self.steps else { return };
        for (whole, filled) in self.new.drain() {
            let filled = Arc::new(filled.into_inner().unwrap_or_else(PoisonError::into_inner));
            if let Whole::Fill(fill) = whole
                && let Some(key) = self.keys.get(&fill)
            {
                self.kept.push((*key, filled.clone()));
            }
            self.known.insert(whole, filled);
        }
        let is_read = |whole: Whole| !steps.is_whole(whole) || steps.is_read_after(whole, self.step);
        for (_, filled) in self.known.extract_if(|whole, _| !is_read(*whole)) {
            // Those that are kept are not free.
            let free = Arc::into_inner(filled).into_iter().flat_map(|filled| filled.samples);
            self.spare.extend(free.flatten().flatten().filter(|plane| !plane.is_empty()));
        }
    }

    /// Returns how the evaluation is divided.
    pub(crate) fn steps(&self) -> Option<&Steps> {
        self.steps.as_ref()
    }

    /// Returns whether the current step is the last one, which also runs the program.
    pub(crate) fn is_last_step(&self) -> bool {
        self.step == 0
    }

    /// Returns the number of steps before the current one, and of all steps.
    pub(crate) fn progress(&self) -> [usize; 2] {
        let count = self.steps.as_ref().map_or(1, Steps::count);
        [count - 1 - self.step, count]
    }

    /// Lists the planes that steps hold, with the number of planes for each sample and the bytes of all.
    pub(crate) fn whole(&self, plan: &Plan<'_>, pass: &Pass) -> Vec<(Whole, usize, usize)> {
        let mut whole: Vec<Whole> = self.steps.iter().flat_map(Steps::whole).collect();
        whole.sort_unstable();
        whole.into_iter().map(|whole| (whole, whole.channels(pass), plan.bytes_of(pass, whole))).collect()
    }

    /// Returns the work of stages on a tile and beyond it in the last step, or in the current one.
    pub(crate) fn load(&self, plan: &Plan<'_>, of_last: bool) -> Load {
        let step = if of_last { 0 } else { self.step };
        self.steps.as_ref().map_or_else(|| Load::of(plan.halo()), |steps| steps.load(step))
    }

    /// Returns whether the current step needs nothing of a fill.
    pub(crate) fn is_idle(&self, fill: usize) -> bool {
        self.steps.as_ref().is_some_and(|steps| !steps.takes_part(fill, self.step))
    }

    /// Returns whether the current step fills some whole planes.
    pub(crate) fn wants(&self, whole: Whole) -> bool {
        self.new.contains_key(&whole)
    }

    /// Returns whether the current step fills any whole planes.
    pub(crate) fn wants_any(&self) -> bool {
        !self.new.is_empty()
    }

    /// Returns whole planes that are known, for a sample, by output or root and channel.
    pub(crate) fn known(&self, whole: Whole, sample: usize) -> Option<&[Vec<Vec<f32>>]> {
        self.known.get(&whole).map(|filled| &filled.samples[sample][..])
    }

    /// Copies a tile of a sample from planes that cover a window around it.
    pub(crate) fn take<'f>(
        &self,
        whole: Whole,
        sample: usize,
        tile: Window,
        window: Window,
        picture: Window,
        from: impl Iterator<Item = &'f [f32]>,
    ) {
        let Some(filled) = self.new.get(&whole) else { return };
        let mut filled = filled.lock().unwrap_or_else(PoisonError::into_inner);
        let start = |within: Window, y: i64| (y - within.y0) as usize * within.width() + (tile.x0 - within.x0) as usize;
        for (to, from) in filled.samples[sample].iter_mut().flatten().zip(from) {
            if to.is_empty() {
                continue;
            }
            for y in tile.y0..tile.y1 {
                let (to, from) = (&mut to[start(picture, y)..], &from[start(window, y)..]);
                to[..tile.width()].copy_from_slice(&from[..tile.width()]);
            }
        }
    }

    /// Hands the filled planes to the cache, after the last step.
    pub(crate) fn finish(self, cache: &mut Cache) {
        for (key, filled) in self.kept {
            cache.keep_planes(key, filled);
        }
    }
}

impl Plan<'_> {
    /// Returns, for each node, whether its result is the same at the next frame.
    fn still(&self) -> Vec<bool> {
        let next = self.graph.frame_context(self.context.frame + 1, self.context.memory_limit);
        let (format, document_format) = (self.context.format, self.context.document_format);
        let context = FrameContext { format, document_format, ..next };
        let settle = |(index, settled): (usize, &Option<Settled>)| {
            settled.as_ref().map(|_| self.graph.settle(NodeId(index), context.frame))
        };
        let settled: Vec<Option<Settled>> = self.settled.iter().enumerate().map(settle).collect();
        self.graph.keys(&settled, &context).iter().zip(&self.keys).map(|(next, now)| next == now).collect()
    }

    /// Returns the only pass, if its stages may be filled over the whole picture: from the document alone, and without bounds.
    pub(super) fn whole_pass(&self) -> Option<&Pass> {
        let whole = self.window == self.graph.format().window() && !self.settings.bounds();
        match &self.passes[..] {
            [pass] if whole && !self.bound.contains(&true) => Some(pass),
            _ => None,
        }
    }
}

/// Returns the number of channels of each root of the program before a fill.
fn tap_channels(fill: &Fill) -> impl Iterator<Item = usize> {
    fill.taps.iter().flat_map(|taps| &taps.roots).copied()
}
