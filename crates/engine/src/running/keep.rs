//! Planes that stages filled, kept for the next evaluation: an edit refills only what depends on it.

use super::prepare::{Cache, PreparedStage, key_of_planes};
use crate::Plan;
use crate::planning::plan::{Fill, Pass};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use trochoid_graph::{Key, NodeId, Variance};
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
}

/// Stages of a plan whose planes are known, and stages whose planes will be kept.
#[derive(Debug, Default)]
pub(crate) struct PlaneKeeper {
    /// Planes of earlier evaluations, by the index of the fill: a stage has several fills if its samples share only some
    /// channels.
    pub(crate) known: HashMap<usize, Arc<StagePlanes>>,
    /// Planes that are being filled now, tile by tile, with their keys.
    new: HashMap<usize, (Key, Mutex<StagePlanes>)>,
    /// Stages of which all planes are known.
    pub(crate) known_stages: Vec<NodeId>,
}

impl PlaneKeeper {
    /// Looks up the planes that a plan's stages filled before. Of the others, those nearest to the outputs are kept first: they
    /// are needed after the most edits, and stand for all before them.
    pub(crate) fn new(plan: &Plan<'_>, ready: &HashMap<NodeId, PreparedStage>, cache: &mut Cache) -> Self {
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
        let is_known = |node: NodeId| {
            let mut fills = pass.fills.iter().enumerate().filter(|(_, fill)| fill.node == node);
            fills.all(|(index, _)| keeper.known.contains_key(&index))
        };
        keeper.known_stages = pass.fills.iter().map(|fill| fill.node).filter(|node| is_known(*node)).collect();
        let prepared: usize = ready.values().map(|ready| ready.prepared.bytes()).sum();
        let known: usize = keeper.known.values().map(|filled| filled.bytes()).sum();
        let mut room = cache.limit().saturating_sub(prepared + known);
        for (index, fill, key) in unknown.into_iter().rev() {
            let wanted = fill.wanted.iter().flatten().filter(|wanted| **wanted);
            let bytes = wanted.count() * picture.area() * 4 * pass.offsets.len();
            let Some(left) = room.checked_sub(bytes) else { continue };
            room = left;
            let plane = |wanted: &bool| vec![0.0; if *wanted { picture.area() } else { 0 }];
            let planes = || fill.wanted.iter().map(|channels| channels.iter().map(plane).collect()).collect();
            let samples = pass.offsets.iter().map(|_| planes()).collect();
            keeper.new.insert(index, (key, Mutex::new(StagePlanes { samples })));
        }
        keeper
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

impl Plan<'_> {
    /// Returns the only pass, if the planes of its stages can be kept: of the whole picture, from the document alone, and
    /// without bounds.
    fn kept_pass(&self) -> Option<&Pass> {
        let whole = self.window == self.graph.format().window() && !self.settings.bounds();
        match &self.passes[..] {
            [pass] if self.settings.keep && whole && !self.bound.contains(&true) => Some(pass),
            _ => None,
        }
    }
}
