//! Reasons that nodes are left out of a plan.

use super::lower::LoweredGraph;
use super::optimize::{Cut, OptimizedProgram};
use super::planner::Planner;
use std::collections::HashSet;
use trochoid_graph::{NodeId, Op};

/// Reason that a node is not evaluated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LeftOut {
    /// The document disables it.
    Disabled,
    /// No requested output is connected to it.
    Unreachable,
    /// A buffer of the caller replaces it, or everything that it feeds.
    Bound,
    /// The switching node of this name hands on another of its inputs at this frame.
    Switched(String),
    /// Its weight is proved to be 0 everywhere, at the mixing node of this name.
    Weight(String),
    /// The node of this name is proved not to depend on it.
    Constant(String),
    /// Another node computes the same.
    SameAs(String),
    /// Nothing that is evaluated reads it: its value was constant, or its channels are not requested.
    Unneeded,
}

/// Certificates quote these words and are checked against them: a change invalidates those made before.
impl std::fmt::Display for LeftOut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Disabled => f.write_str("disabled"),
            Self::Unreachable => f.write_str("no requested output needs it"),
            Self::Bound => f.write_str("a bound buffer stands in for it"),
            Self::Switched(at) => write!(f, "not chosen by \"{at}\""),
            Self::Weight(at) => write!(f, "its weight at \"{at}\" is proved 0 everywhere"),
            Self::Constant(at) => write!(f, "\"{at}\" is proved to be the same whatever it is"),
            Self::SameAs(name) => write!(f, "the same as \"{name}\""),
            Self::Unneeded => f.write_str("nothing that is evaluated reads it"),
        }
    }
}

/// Finds why nodes are left out.
pub(crate) struct Reasons<'p> {
    pub(crate) planner: &'p Planner<'p, 'p>,
    /// Nodes that the outputs depend on, up to bound nodes.
    pub(crate) needed: &'p [bool],
    pub(crate) roots: &'p [NodeId],
    pub(crate) lowered: &'p LoweredGraph,
    pub(crate) optimized: &'p OptimizedProgram,
    /// Operations of the optimized program that something reads.
    pub(crate) alive: &'p [bool],
    /// Nodes that are evaluated.
    pub(crate) used: &'p [bool],
}

impl Reasons<'_> {
    /// Returns, by node, why it is left out; `None` where it is evaluated.
    pub(crate) fn list(&self) -> Vec<Option<LeftOut>> {
        let graph = self.planner.graph;
        let connected = graph.upstream(self.roots.iter().copied());
        let (switched_at, cut_at, is_read) = (self.switched_at(), self.cut_at(), self.is_read());
        let reached = self.reached();
        let name = |id: NodeId| graph.node(id).name.clone();
        graph
            .nodes()
            .iter()
            .enumerate()
            .map(|(id, node)| {
                let same = self.lowered.stands_in[id];
                let is_pointwise = self.planner.is_pointwise(self.lowered, NodeId(id));
                if node.disabled {
                    Some(LeftOut::Disabled)
                } else if !connected[id] {
                    Some(LeftOut::Unreachable)
                } else if let Some(at) = switched_at[id] {
                    Some(LeftOut::Switched(name(at)))
                } else if self.planner.bound[id] || !self.needed[id] {
                    Some(LeftOut::Bound)
                } else if self.used[id] {
                    None
                } else if same.0 != id {
                    Some(LeftOut::SameAs(name(same)))
                } else if let Some(cut) = cut_at[id].filter(|_| !reached[id]) {
                    Some(if cut.by_weight { LeftOut::Weight(name(cut.at)) } else { LeftOut::Constant(name(cut.at)) })
                } else if is_pointwise && is_read[id] {
                    // Merged into an equal operation of another node, or folded into a constant.
                    None
                } else {
                    Some(LeftOut::Unneeded)
                }
            })
            .collect()
    }

    /// Finds nodes that a switching node could hand on but does not, each with the switching node nearest to the
    /// outputs.
    fn switched_at(&self) -> Vec<Option<NodeId>> {
        let graph = self.planner.graph;
        let mut at = vec![None; graph.nodes().len()];
        let passes = |id: NodeId| {
            let settled = self.lowered.settled[id.0].as_ref();
            settled.is_some_and(|settled| settled.node().identity().is_some())
        };
        let passing: Vec<NodeId> = graph.order().iter().rev().copied().filter(|id| passes(*id)).collect();
        if passing.is_empty() {
            return at;
        }
        // Look past bound nodes too: a node behind a bound one was not rejected by a switch.
        let reached = graph.dependencies(self.roots.iter().copied(), self.planner.frame);
        for id in passing {
            let mut open = vec![id];
            while let Some(node) = open.pop() {
                graph.node(node).record.each_node(|input| {
                    if !reached[input.0] && at[input.0].is_none() {
                        at[input.0] = Some(id);
                        open.push(input);
                    }
                });
            }
        }
        at
    }

    /// Finds nodes with operations that outputs or evaluated stages depend on past all cuts: their values reach the
    /// picture, even if folded into a constant.
    fn reached(&self) -> Vec<bool> {
        let (graph, ops) = (self.planner.graph, self.lowered.program.ops());
        let mut nodes = vec![false; graph.nodes().len()];
        for root in self.roots {
            nodes[self.lowered.stands_in[root.0].0] = true;
        }
        for (id, settled) in self.lowered.settled.iter().enumerate().filter(|(id, _)| self.used[*id]) {
            if let (Some(settled), Some(_)) = (settled, self.planner.stage(self.lowered, NodeId(id))) {
                settled.each_node(|input| nodes[input.0] = true);
            }
        }
        let cuts: HashSet<(u32, u32)> = self.optimized.cuts.iter().map(|cut| (cut.op, cut.operand)).collect();
        let (mut reached, mut found) = (vec![false; ops.len()], nodes.clone());
        for (at, (op, origin)) in ops.iter().enumerate().rev() {
            if reached[at] || nodes[origin.0] {
                found[origin.0] = true;
                op.operands(|operand| reached[operand as usize] |= !cuts.contains(&(at as u32, operand)));
            }
        }
        found
    }

    /// Finds nodes that a cut operand came from, each with the first cut that explains it.
    pub(crate) fn cut_at(&self) -> Vec<Option<Cut>> {
        let graph = self.planner.graph;
        let ops = self.lowered.program.ops();
        let mut cut_at = vec![None; graph.nodes().len()];
        // Operations that an earlier cut has explained need no second walk, so all cuts together take one walk.
        let mut explained = vec![false; ops.len()];
        let mut passed = vec![u32::MAX; ops.len()];
        for (index, cut) in self.optimized.cuts.iter().enumerate() {
            let mut open = vec![cut.operand];
            let mut nodes = Vec::new();
            while let Some(position) = open.pop() {
                let (op, origin) = &ops[position as usize];
                let own = &mut passed[position as usize];
                if explained[position as usize] || std::mem::replace(own, index as u32) == index as u32 {
                    continue;
                }
                // A literal operand carries the name of the mixing node itself, which is not cut off.
                if *origin != cut.at {
                    explained[position as usize] = true;
                    nodes.push(*origin);
                }
                op.operands(|operand| open.push(operand));
            }
            while let Some(node) = nodes.pop() {
                if cut_at[node.0].is_none() {
                    cut_at[node.0] = Some(*cut);
                    graph.node(node).record.each_node(|input| nodes.push(input));
                }
            }
        }
        cut_at
    }

    /// Finds nodes whose values are read, were folded into a constant, or were constants to begin with.
    fn is_read(&self) -> Vec<bool> {
        let is_constant = |op: &Op| matches!(op, Op::Constant(_) | Op::ConstantColor(_));
        let count = self.planner.graph.nodes().len();
        let (mut computes, mut read) = (vec![false; count], vec![false; count]);
        for ((op, origin), &position) in self.lowered.program.ops().iter().zip(&self.optimized.map) {
            if !is_constant(op) {
                let position = position as usize;
                computes[origin.0] = true;
                read[origin.0] |= self.alive[position] || is_constant(&self.optimized.program.ops()[position].0);
            }
        }
        computes.into_iter().zip(read).map(|(computes, read)| read || !computes).collect()
    }
}
