//! The pointwise program of one output, for code that runs it elsewhere.

use super::lower::{lower, roots};
use super::optimize::{cone, extract, optimize};
use super::planner::Planner;
use crate::{Settings, Switches};
use trochoid_graph::{CheckedGraph, NodeId, Program};

/// The pointwise program of one output at one frame, optimized: exactly the operations that the output needs. Whoever runs it
/// supplies what it loads.
///
/// It is taken after optimization, which keeps every bit: then it loads nothing that is proved not to matter, and has
/// no operation whose result is known.
#[derive(Clone, Debug, PartialEq)]
pub struct PointwiseProgram {
    /// The operations, in order.
    pub program: Program,
    /// Positions of the output's channels in the program: one of a color, one for each other channel.
    pub roots: Vec<u32>,
}

impl PointwiseProgram {
    /// Makes the program of an output, given by its index in the graph.
    ///
    /// The program loads the outputs of `bound` nodes, with any value of their kind. It also loads the outputs of other
    /// nodes that are not pointwise; there it relies on the intervals that these nodes promise.
    pub fn new(graph: &CheckedGraph, output: usize, frame: i64, bound: &[NodeId]) -> Self {
        let settings = Settings::default();
        let bound = (0..graph.nodes().len()).map(|id| bound.contains(&NodeId(id))).collect();
        let planner = Planner { graph, settings: &settings, bound, frame };
        let spec = &graph.outputs()[output];
        let settled = planner.reachable(&[spec.node]);
        // Equal nodes need not be merged: equal operations are.
        let mut lowered = lower(graph, settled, &planner.bound, &[]);
        let value = lowered.values[spec.node.0][spec.output].clone();
        let roots = value.map(|value| roots(&mut lowered.program, spec, &value)).unwrap_or_default();
        let optimized =
            optimize(&lowered.program, Switches::ALL, &|slot, channel| planner.slot_interval(&lowered, slot, channel));
        let roots: Vec<u32> = roots.iter().map(|root| optimized.map[*root as usize]).collect();
        let (program, map) = extract(&optimized.program, &cone(&optimized.program, roots.iter().copied()));
        Self { program, roots: roots.iter().map(|root| map[*root as usize]).collect() }
    }
}
