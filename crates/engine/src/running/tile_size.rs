//! Chooses the size of tiles.

use super::prepare::PreparedStage;
use crate::Plan;
use crate::planning::schedule::Reach;
use std::collections::HashMap;
use trochoid_graph::{NodeId, Variance};

/// Size of tiles, which keeps the planes of a few stages in L2.
const TILE: (usize, usize) = (256, 16);

/// Average share of a band for which a thread idles at the end of a picture.
const IDLE: f64 = 0.3;

/// Returns the number of bands, at least `least`, into which to divide a picture for threads that share them. Few
/// bands are better since each one computes `halo` additional rows at both ends; many are better since bands differ,
/// and threads idle at the end of the picture.
fn divided(height: usize, least: usize, halo: usize, threads: usize) -> usize {
    let least = least.max(1);
    let rows = |bands: usize| {
        let band = height as f64 / bands as f64 + 2.0 * halo as f64;
        ((bands as f64 / threads as f64).max(1.0) + IDLE) * band
    };
    let most = least.max(2 * threads).min(height.max(1));
    (least..=most).min_by(|a, b| rows(*a).total_cmp(&rows(*b))).unwrap_or(least)
}

impl Plan<'_> {
    /// Returns the width and height of tiles.
    pub(super) fn tile(&self, ready: &HashMap<NodeId, PreparedStage>, halo: Reach) -> (usize, usize) {
        let fills = self.passes.iter().flat_map(|pass| &pass.fills);
        self.tile_for(fills.filter_map(|fill| ready.get(&fill.node)?.prepared.rows_per_band()).max(), halo)
    }

    /// Returns the width and height of tiles, given how many rows of files are read at a time, if any files are read, and
    /// how far stages reach beyond a tile.
    pub(crate) fn tile_for(&self, bands: Option<usize>, (across, down): Reach) -> (usize, usize) {
        if let Some((width, height)) = self.settings.tile {
            return (width.max(1), height.max(1));
        }
        let fills = || self.passes.iter().flat_map(|pass| &pass.fills);
        let in_place = fills().all(|fill| self.bound[fill.node.0] || fill.variance <= Variance::Column);
        let (width, height) = (self.window.width(), self.window.height());
        // Height of bands that reach beyond their own rows, of which they have at least `least`.
        let band = |least: usize| height.div_ceil(divided(height, height / TILE.1.max(least), down, self.threads()));
        match bands {
            // Whole rows, so that every block of a file is decoded once.
            Some(rows) => {
                let height = if down == 0 { TILE.1 } else { band(4 * down) };
                (width, height.next_multiple_of(rows.max(1)))
            }
            None if in_place && across + down == 0 => (self.window.width(), TILE.1),
            // Tiles that are large compared with the overlap with their neighbors, and wide, since threads share the
            // bands.
            None => {
                let columns = (width / TILE.0.max(12 * across)).max(1);
                (width.div_ceil(columns), band(6 * down))
            }
        }
    }
}
