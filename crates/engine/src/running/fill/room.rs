//! Estimates what a thread's fills of a pass take beside the planes that stages fill over a tile.

use super::gated::MOST as OPEN;
use super::places::with_room;
use super::sparse::Sparse;
use crate::Plan;
use crate::planning::plan::{Fill, Pass};
use crate::running::adaptive;
use std::collections::HashSet;
use trochoid_graph::{NodeId, Variance};

/// Bytes of a sample of a plane.
const SAMPLE: u64 = size_of::<f32>() as u64;

/// Bytes of a pixel in a list: its index in a plane, and its position.
const LISTED: u64 = (size_of::<usize>() + size_of::<[i64; 2]>()) as u64;

/// Returns the most bytes that a thread's fills take for lists of pixels, results of the first sample, planes at single pixels
/// and conditions, given the pixels of a tile and of each fill's window.
pub(crate) fn bytes_beside_planes(plan: &Plan<'_>, pass: &Pass, tile: u64, windows: &[u64]) -> u64 {
    let fills = || pass.fills.iter().zip(windows.iter().copied()).filter(|(fill, _)| fill.variance == Variance::Pixel);
    let mut bytes = Bytes(0);
    if let Some(gates) = &pass.gates {
        let roots: usize = gates.levels.iter().map(|level| level.roots.len()).sum();
        bytes.add(with_room(tile), roots as u64 * SAMPLE);
        bytes.add(tile, gates.sets.len() as u64 * (1 + (OPEN * LISTED as f64) as u64));
        let is_part = |fill: &Fill| fill.gates.is_some() && plan.stage(fill.node).is_some_and(|s| !s.is_pixelwise());
        let parts: u64 = pass.fills.iter().filter(|fill| is_part(fill)).map(|fill| fill.planes() as u64).sum();
        bytes.add(tile, (OPEN * (parts * SAMPLE) as f64) as u64);
    }
    if pass.offsets.len() > 1 {
        // Results of the first sample that others replace, and the pixels at which they do.
        let shared = || fills().filter(|(fill, _)| fill.shared.is_some());
        shared()
            .for_each(|(fill, window)| bytes.add(window, fill.planes() as u64 * SAMPLE + size_of::<usize>() as u64));
        let views: HashSet<(&[NodeId], u64)> =
            shared().map(|(fill, window)| (fill.shared.as_deref().unwrap_or_default(), window)).collect();
        views.into_iter().for_each(|(_, window)| bytes.add(window, LISTED));
        // Results at single pixels, before they are stored.
        bytes
            .add(shared().map(|(fill, window)| window.saturating_mul(fill.planes() as u64)).max().unwrap_or(0), SAMPLE);
    }
    if plan.graph.format().adaptive().is_some() && pass.offsets.len() > 1 {
        bytes.add(with_room(tile), adaptive::bytes_of_pixel(pass));
        if let Some(sparse) = Sparse::of(plan, pass) {
            bytes.add(with_room(tile), sparse.planes() * SAMPLE + size_of::<[i64; 2]>() as u64 + SAMPLE);
            let listed = sparse.margins().zip(windows).collect::<HashSet<_>>();
            let (is_near, index) = (1, size_of::<usize>() as u64);
            listed.into_iter().for_each(|(_, window)| bytes.add(with_room(*window), is_near + index));
            bytes.add(with_room(windows.iter().copied().max().unwrap_or(0)), LISTED);
        }
    }
    bytes.0
}

/// A sum of bytes, which saturates.
struct Bytes(u64);

impl Bytes {
    fn add(&mut self, count: u64, each: u64) {
        self.0 = self.0.saturating_add(count.saturating_mul(each));
    }
}
