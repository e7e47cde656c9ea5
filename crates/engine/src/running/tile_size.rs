//! Chooses the size of tiles.

use super::prepare::PreparedStage;
use crate::Plan;
use crate::planning::schedule::{Reach, larger};
use std::collections::{BTreeMap, HashMap};
use trochoid_graph::{NodeId, Variance};

/// Size of tiles, which keeps the planes of a few stages in L2.
const TILE: (usize, usize) = (256, 16);

/// Most pixels of a tile whose stages reach beyond it, but not far.
const AREA: usize = 480 * 270;

/// Time that a thread loses, as a share of that for a tile: about half of a tile while it idles at the end of a picture,
/// and as much for the pages of the memory that its first tile takes.
const LOST: f64 = 1.0;

/// Most work of all threads together, in units of what a single thread would do, if there are more tiles than threads.
const MORE: f64 = 1.05;

/// Time to copy a sample of a plane, in the units of [`super::steps`].
const COPY: f64 = 1.0;

/// Time that stages take for a tile, by how far beyond it they compute.
#[derive(Clone, Debug, Default)]
pub(crate) struct Load {
    times: BTreeMap<Reach, f64>,
    /// Time to copy the parts of whole planes that stages read, unless a tile is as wide as the picture.
    copies: BTreeMap<Reach, f64>,
}

impl Load {
    /// Returns the load of stages of which about half reach so far.
    pub(crate) fn of(reach: Reach) -> Self {
        let mut load = Self::default();
        [(0, 0), reach].into_iter().for_each(|reach| load.add(reach, 0.5));
        load
    }

    /// Adds the time of a stage.
    pub(crate) fn add(&mut self, reach: Reach, time: f64) {
        *self.times.entry(reach).or_default() += time;
    }

    /// Adds the time to copy a part of a whole plane.
    pub(crate) fn copy(&mut self, reach: Reach) {
        *self.copies.entry(reach).or_default() += COPY;
    }

    /// Returns the load if a program and all stages compute at least so many pixels beyond a tile.
    fn beyond_by(&self, pixels: usize) -> Self {
        let mut load = Self { copies: self.copies.clone(), ..Self::default() };
        load.add((pixels, pixels), COPY);
        self.times.iter().for_each(|(reach, time)| load.add(larger(*reach, (pixels, pixels)), *time));
        load
    }

    /// Returns how far any stage reaches.
    fn farthest(&self) -> Reach {
        self.times.keys().copied().fold((0, 0), larger)
    }
}

/// Returns the numbers of columns, at most `most`, and of bands into which to divide a picture whose stages reach beyond
/// a tile, for threads that share the tiles. Few tiles are better since their stages fill the same pixels again; many are
/// better since tiles differ, and threads idle at the end of the picture.
fn divided((width, height): (usize, usize), most: usize, load: &Load, threads: usize) -> (usize, usize) {
    let (across, down) = load.farthest();
    let area = AREA.max(across.saturating_mul(down).saturating_mul(72));
    // Work for a tile.
    let work = |&(columns, bands): &(usize, usize)| -> f64 {
        let copies = load.copies.iter().filter(|_| columns > 1);
        let times = load.times.iter().chain(copies).map(|(&(across, down), time)| {
            let ([_, wide], [_, high]) = (filled(width, columns, across), filled(height, bands, down));
            wide * high * time
        });
        times.sum()
    };
    let is_small = |&(columns, bands): &(usize, usize)| width.div_ceil(columns) * height.div_ceil(bands) <= area;
    // At least as many rows as a tile without a halo has.
    let (columns, bands) = (1..=most.max(1), 1..=(height / TILE.1).max(1));
    let ways = columns.flat_map(|columns| bands.clone().map(move |bands| (columns, bands)));
    // With the number of tiles, and the work for one.
    let ways: Vec<((usize, usize), usize, f64)> =
        ways.filter(is_small).map(|way| (way, way.0 * way.1, work(&way))).collect();
    let fastest = |threads: usize, most: f64| {
        let ways = ways.iter().map(|(way, tiles, work)| {
            let time = ((*tiles as f64 / threads as f64).max(1.0) + LOST) * work;
            (way, time, *tiles as f64 * work, *tiles <= threads)
        });
        let ways = ways.filter(|(.., all, has_few)| *has_few || *all <= most);
        ways.min_by(|(_, a, ..), (_, b, ..)| a.total_cmp(b)).map(|(way, _, all, _)| (*way, all))
    };
    let alone = fastest(1, f64::INFINITY);
    let chosen = alone.and_then(|(_, least)| fastest(threads, MORE * least));
    chosen.or(alone).map_or((most.max(1), (height / TILE.1).max(1)), |(way, _)| way)
}

/// Returns how many pixels a part of an axis has, and how many it fills on average if its stages reach beyond it.
fn filled(size: usize, parts: usize, halo: usize) -> [f64; 2] {
    let own = size as f64 / parts as f64;
    let beyond = (2 * halo * (parts - 1)) as f64 / parts as f64;
    [own, (own + beyond).min(size as f64)]
}

impl Plan<'_> {
    /// Returns the share of the picture's pixels that tiles fill again, if stages reach this far beyond a tile.
    pub(super) fn filled_again(&self, (across, down): Reach) -> f64 {
        let (width, height) = (self.window.width(), self.window.height());
        let (columns, bands) = match self.settings.tile {
            Some(tile) => (width.div_ceil(tile.0.max(1)), height.div_ceil(tile.1.max(1))),
            None => divided((width, height), width / TILE.0, &Load::of((across, down)), self.threads()),
        };
        let ([x, wide], [y, high]) = (filled(width, columns, across), filled(height, bands, down));
        (wide * high) / (x * y) - 1.0
    }

    /// Returns the width and height of tiles.
    pub(super) fn tile(&self, ready: &HashMap<NodeId, PreparedStage>, load: &Load) -> (usize, usize) {
        let fills = self.passes.iter().flat_map(|pass| &pass.fills);
        self.tile_for(fills.filter_map(|fill| ready.get(&fill.node)?.prepared.rows_per_band()).max(), load)
    }

    /// Returns the width and height of tiles, given how many rows of files are read at a time, if any files are read, and
    /// the work on a tile and beyond it.
    pub(crate) fn tile_for(&self, bands: Option<usize>, load: &Load) -> (usize, usize) {
        if let Some((width, height)) = self.settings.tile {
            return (width.max(1), height.max(1));
        }
        // Where adaptive sampling compares neighbors, the first sample of those beyond the tile is taken, too.
        let load = &match self.graph.format().adaptive() {
            Some(_) => load.beyond_by(1),
            None => load.clone(),
        };
        let (across, down) = load.farthest();
        let fills = || self.passes.iter().flat_map(|pass| &pass.fills);
        let in_place = fills().all(|fill| self.bound[fill.node.0] || fill.variance <= Variance::Column);
        let (width, height) = (self.window.width(), self.window.height());
        let tile = |most: usize| {
            let (columns, bands) = divided((width, height), most, load, self.threads());
            (width.div_ceil(columns), height.div_ceil(bands))
        };
        match bands {
            // Whole rows, so that every block of a file is decoded once.
            Some(rows) => {
                let height = if down == 0 { TILE.1 } else { tile(1).1 };
                (width, height.next_multiple_of(rows.max(1)))
            }
            None if in_place && across + down == 0 => (width, TILE.1),
            None if across + down == 0 => (width.div_ceil((width / TILE.0).max(1)), TILE.1),
            None => tile(width / TILE.0),
        }
    }
}
