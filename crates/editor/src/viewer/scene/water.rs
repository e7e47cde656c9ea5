//! How high the water is on which things float.

use super::gizmo::knobs;
use std::collections::HashMap;
use std::sync::Arc;
use trochoid::{CheckedGraph, Knob, NodeId, Placing, ProfileLine};

/// Length of the lines over which the height of the water is averaged, in meters: that of a boat.
const HULL: f64 = 4.0;
/// Number of points on each of them.
const POINTS: usize = 9;

/// Heights of the water at the places of things, as long as the document and the frame are the same.
#[derive(Default)]
pub(super) struct Water {
    of: Option<(Arc<CheckedGraph>, i64)>,
    heights: HashMap<(NodeId, [u64; 2]), f64>,
}

impl Water {
    /// Returns the height of the water under something that floats at x and z: about that of its waterline. Of a sea that
    /// takes seconds to simulate, it is the height at rest.
    pub(super) fn height(&mut self, graph: &Arc<CheckedGraph>, node: NodeId, frame: i64, at: [f64; 2]) -> f64 {
        if !self.of.as_ref().is_some_and(|(known, then)| Arc::ptr_eq(known, graph) && *then == frame) {
            self.of = Some((graph.clone(), frame));
            self.heights.clear();
        }
        let Some((sea, knob)) = sea(graph, node) else { return 0.0 };
        let made = || {
            let settled = graph.settle(sea, frame);
            let (rest, time) = (settled.number(knob.name), graph.frame_context(frame, u64::MAX).time);
            let heights = [0.0, 90.0].into_iter().flat_map(|direction| {
                let line = ProfileLine { through: Some(at), direction, length: Some(HULL), points: POINTS };
                let profile = settled.node().dynamics().and_then(|sea| sea.profile(&line, time));
                profile.into_iter().flat_map(|profile| profile.points).map(|point| point.height)
            });
            let heights: Vec<f64> = heights.collect();
            rest + heights.iter().sum::<f64>() / heights.len().max(1) as f64
        };
        *self.heights.entry((sea, at.map(f64::to_bits))).or_insert_with(made)
    }
}

/// Returns the sea that a node depends on, and its knob for the height at rest.
fn sea(graph: &CheckedGraph, node: NodeId) -> Option<(NodeId, &'static Knob)> {
    let reached = graph.upstream([node]);
    graph.nodes().iter().enumerate().filter(|(index, _)| reached[*index]).find_map(|(index, node)| {
        let knob = knobs(node.ty.declaration().items).find(|knob| knob.places == Some(Placing::Level))?;
        Some((NodeId(index), knob))
    })
}

/// Returns the height at which the sea lies at rest that a node depends on.
pub(super) fn level(graph: &CheckedGraph, node: NodeId, frame: i64) -> Option<f64> {
    sea(graph, node).map(|(sea, knob)| graph.settle(sea, frame).number(knob.name))
}
