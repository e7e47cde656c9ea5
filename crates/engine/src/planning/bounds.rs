//! Adds channels of error bounds beside those of values, in plans that certify.

use super::plan::{Feed, Pass};
use trochoid_graph::{Bound, CheckedGraph, NodeId, literal_error};

/// Offset from channels of values to those of bounds, among the roots that a program hands to a stage.
pub(crate) const BOUNDS: usize = 3;

/// Gives every plane of a pass a second plane for its bounds, as a channel that follows those of its output.
pub(crate) fn with_bounds(pass: &mut Pass, graph: &CheckedGraph) {
    let channels = |node: NodeId, output: usize| graph.node(node).kinds[output].channels();
    for fill in &mut pass.fills {
        fill.wanted.iter_mut().for_each(|wanted| wanted.extend_from_within(..));
        for feeds in fill.inputs.iter_mut().flat_map(|(_, connections)| connections) {
            let bound = |feed: &Feed| match feed {
                Feed::Nothing => Feed::Nothing,
                Feed::Slot(slot) => {
                    let mut slot = *slot;
                    slot.channel += channels(slot.node, slot.output);
                    Feed::Slot(slot)
                }
                Feed::Tap(root, channel) => Feed::Tap(*root, BOUNDS + channel),
                Feed::Constant(value) => Feed::Constant(Bound::of(literal_error(*value)).encode()),
            };
            let bounds: Vec<Feed> = feeds.iter().map(bound).collect();
            feeds.extend(bounds);
        }
    }
    let programs = pass.fills.iter_mut().filter_map(|fill| fill.taps.as_mut()).chain([&mut pass.program]);
    for program in programs {
        program.planes.extend_from_within(..);
        let middle = program.planes.len() / 2;
        for slot in &mut program.planes[middle..] {
            slot.channel += channels(slot.node, slot.output);
        }
    }
}
