//! Planes that stages filled, kept for the next evaluation: an edit refills only what depends on it.

use super::fill::by_slot;
use super::prepare::{Cache, PreparedStage, key_of_planes};
use crate::planning::plan::{Fill, Pass};
use crate::{Keep, Plan};
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError};
use trochoid_graph::{FrameContext, Key, NodeId, Settled, Variance};
use trochoid_image::Window;

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

/// Stages of a plan whose planes are known, and stages whose planes will be kept.
#[derive(Debug, Default)]
pub(crate) struct PlaneKeeper {
    /// Planes of earlier evaluations, by the index of the fill: a stage has several fills if its samples share only some
    /// channels.
    pub(crate) known: HashMap<usize, Arc<StagePlanes>>,
    /// Planes that are being filled now, tile by tile, with their keys.
    new: HashMap<usize, (Key, Mutex<StagePlanes>)>,
    /// Fills of which nothing is needed, because all that reads them is known.
    idle: HashSet<usize>,
    /// Stages that fill nothing.
    pub(crate) spared: Vec<NodeId>,
}

impl PlaneKeeper {
    /// Looks up the planes that a plan's stages filled before. Of the others that are needed, those nearest to the outputs are
    /// kept first: they are needed after the most edits, and stand for all before them. `held` is what prepared stages will
    /// hold, in bytes: more than they hold now, if they decode files on demand.
    pub(crate) fn new(plan: &Plan<'_>, ready: &HashMap<NodeId, PreparedStage>, held: usize, cache: &mut Cache) -> Self {
        let mut keeper = Self::default();
        let Some(pass) = plan.kept_pass() else { return keeper };
        let picture = plan.graph.format().window();
        let extents = super::fill::extents(plan, ready, &pass.fills);
        // Planes kept hold no pixels beyond the picture, and what varies along one axis costs almost nothing to
        // refill.
        let is_kept = |fill: &Fill| fill.variance == Variance::Pixel && extents.get(&fill.node) == Some(&picture);
        let mut unknown = Vec::new();
        for (index, fill) in pass.fills.iter().enumerate().filter(|(_, fill)| is_kept(fill)) {
            let Some(key) = ready.get(&fill.node).map(|ready| key_of_planes(plan, pass, fill, ready)) else { continue };
            match cache.planes(&key) {
                Some(filled) => _ = keeper.known.insert(index, filled),
                None => unknown.push((index, fill, key)),
            }
        }
        keeper.idle = idle(&pass.fills, &keeper.known);
        let is_spared = |node: NodeId| {
            let mut fills = pass.fills.iter().enumerate().filter(|(_, fill)| fill.node == node);
            fills.all(|(index, _)| keeper.known.contains_key(&index) || keeper.idle.contains(&index))
        };
        keeper.spared = pass.fills.iter().map(|fill| fill.node).filter(|node| is_spared(*node)).collect();
        unknown.retain(|(index, ..)| !keeper.idle.contains(index));
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
        let mut kept = Vec::new();
        for (index, fill, key) in unknown.into_iter().rev() {
            let wanted = fill.wanted.iter().flatten().filter(|wanted| **wanted);
            let bytes = wanted.count() * picture.area() * 4 * pass.offsets.len();
            let Some(left) = room.checked_sub(bytes) else { continue };
            room = left;
            kept.push((index, fill, key, bytes));
        }
        // Old planes go before new ones take memory.
        cache.make_way(kept.iter().map(|(.., bytes)| bytes).sum::<usize>().saturating_add(prepared - now));
        for (index, fill, key, _) in kept {
            let plane = |wanted: &bool| vec![0.0; if *wanted { picture.area() } else { 0 }];
            let planes = || fill.wanted.iter().map(|channels| channels.iter().map(plane).collect()).collect();
            let samples = pass.offsets.iter().map(|_| planes()).collect();
            keeper.new.insert(index, (key, Mutex::new(StagePlanes { samples })));
        }
        keeper
    }

    /// Returns whether nothing of a fill is needed.
    pub(crate) fn is_idle(&self, fill: usize) -> bool {
        self.idle.contains(&fill)
    }

    /// Returns whether the planes of a fill are being kept.
    pub(crate) fn wants(&self, fill: usize) -> bool {
        self.new.contains_key(&fill)
    }

    /// Copies a tile of a sample from planes that cover a window around it.
    pub(crate) fn take(
        &self,
        fill: usize,
        sample: usize,
        tile: Window,
        window: Window,
        picture: Window,
        from: &[Vec<Vec<f32>>],
    ) {
        let Some((_, filled)) = self.new.get(&fill) else { return };
        let mut filled = filled.lock().unwrap_or_else(PoisonError::into_inner);
        let start = |within: Window, y: i64| (y - within.y0) as usize * within.width() + (tile.x0 - within.x0) as usize;
        for (to, from) in filled.samples[sample].iter_mut().flatten().zip(from.iter().flatten()) {
            if to.is_empty() {
                continue;
            }
            for y in tile.y0..tile.y1 {
                let (to, from) = (&mut to[start(picture, y)..], &from[start(window, y)..]);
                to[..tile.width()].copy_from_slice(&from[..tile.width()]);
            }
        }
    }

    /// Hands the filled planes to the cache, once every tile is done.
    pub(crate) fn finish(self, cache: &mut Cache) {
        for (key, filled) in self.new.into_values() {
            let filled = filled.into_inner().unwrap_or_else(PoisonError::into_inner);
            cache.keep_planes(key, Arc::new(filled));
        }
    }
}

/// Returns the fills that some others read, but only known ones or such as are idle themselves.
fn idle(fills: &[Fill], known: &HashMap<usize, Arc<StagePlanes>>) -> HashSet<usize> {
    let by_slot = by_slot(fills);
    let (mut readers, mut needs) = (vec![0_usize; fills.len()], vec![0_usize; fills.len()]);
    let mut idle = HashSet::new();
    for (index, fill) in fills.iter().enumerate().rev() {
        // All that read it come after it.
        if !fill.read && readers[index] > 0 && needs[index] == 0 {
            idle.insert(index);
        }
        let reads = !known.contains_key(&index) && !idle.contains(&index);
        let mut inputs: Vec<usize> = fill.slots().filter_map(|slot| by_slot.get(&slot).copied()).collect();
        inputs.sort_unstable();
        inputs.dedup();
        for input in inputs {
            readers[input] += 1;
            needs[input] += usize::from(reads);
        }
    }
    idle
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

    /// Returns the only pass, if the planes of its stages can be kept: of the whole picture, from the document alone, and
    /// without bounds.
    fn kept_pass(&self) -> Option<&Pass> {
        let whole = self.window == self.graph.format().window() && !self.settings.bounds();
        match &self.passes[..] {
            [pass] if self.settings.keep != Keep::Nothing && whole && !self.bound.contains(&true) => Some(pass),
            _ => None,
        }
    }
}
