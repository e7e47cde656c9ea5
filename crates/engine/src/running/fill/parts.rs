//! Fills weights from buffers of the caller, divided by their sum.

use super::Fills;
use trochoid_graph::{Bound, Kind, NodeId, REFERENCE};
use trochoid_memory::Scratch;
use trochoid_weights::sums;

impl Fills<'_> {
    /// Returns whether a node is bound to weights, which are divided by their sum before anything reads them. All
    /// other buffers are read in place.
    pub(super) fn is_divided(&self, node: NodeId) -> bool {
        self.plan.bound[node.0] && matches!(self.plan.graph.node(node).kinds[0], Kind::Weights(n) if n > 2)
    }

    /// Fills the planes of such a node over its window, and the bounds of what rounding them loses.
    pub(super) fn fill_parts(&mut self, index: usize) {
        let state = &mut self.fills[index];
        let weights = self.buffers.get(&self.plan.graph.node(state.fill.node).name).unwrap_or_default();
        let (picture, window) = (self.plan.graph.format().window(), state.window);
        let (count, width) = (weights.len(), window.width());
        for (plane, wanted) in state.planes[0].iter_mut().zip(&state.fill.wanted[0]) {
            plane.resize(if *wanted { window.area() } else { 0 }, 0.0);
        }
        for (row, y) in (window.y0..window.y1).enumerate() {
            let start = (y - picture.y0) as usize * picture.width() + (window.x0 - picture.x0) as usize;
            let rows: Scratch<&[f32]> = weights.iter().map(|plane| &plane[start..start + width]).collect();
            let sums = sums::sums(&rows);
            for (channel, plane) in state.planes[0].iter_mut().enumerate().filter(|(_, plane)| !plane.is_empty()) {
                let parts =
                    rows[channel % count].iter().zip(&sums).map(|(weight, sum)| sums::part(*weight, *sum, count));
                for (out, part) in plane[row * width..][..width].iter_mut().zip(parts) {
                    // Adding 0 turns −0 into 0.
                    let rounded = part as f32 + 0.0;
                    // In plans that certify, the channels of bounds follow those of values.
                    *out = if channel < count { rounded } else { off(rounded, part).encode() };
                }
            }
        }
    }
}

/// Bounds the difference of a rounded weight from its exact part of the sum.
fn off(rounded: f32, part: f64) -> Bound {
    let distance = (f64::from(rounded) - part).abs();
    if distance == 0.0 { Bound::EXACT } else { Bound::of(distance + part * REFERENCE) }
}
