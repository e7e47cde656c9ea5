//! Finds the controls against which an output's colors are judged, and the number of roundings between the controls
//! and the output.

use super::lower::LoweredGraph;
use super::optimize::cone;
use super::plan::PlannedOutput;
use super::planner::Planner;
use std::collections::HashMap;
use std::sync::OnceLock;
use trochoid_graph::{Kind, NodeId, Op, Program, Source, literal};

/// Finds the controls of outputs, through the program and through the inputs of filters.
pub(crate) struct Controls<'p> {
    pub(crate) planner: &'p Planner<'p, 'p>,
    pub(crate) lowered: &'p LoweredGraph,
    pub(crate) program: &'p Program,
    pub(crate) taps: &'p HashMap<(NodeId, usize), Vec<u32>>,
}

impl Controls<'_> {
    /// Plans output `index` of the graph, whose channels are at `roots` of the program.
    pub(crate) fn output(&self, index: usize, roots: &[u32]) -> PlannedOutput {
        let kind = self.planner.graph.outputs()[index].kind;
        let mut output = PlannedOutput {
            index,
            kind,
            mix_levels: 0,
            constants: Vec::new(),
            control_stages: Vec::new(),
            judge: OnceLock::new(),
        };
        if kind == Kind::Color {
            let mut walk = ControlsWalk {
                of: self,
                counted: vec![false; self.program.ops().len()],
                levels: HashMap::new(),
                output: &mut output,
            };
            let levels = walk.program(roots);
            output.mix_levels = levels;
            output.control_stages.sort();
            output.control_stages.dedup();
        }
        output
    }
}

struct ControlsWalk<'w, 'p> {
    of: &'w Controls<'p>,
    /// Operations whose constant color is listed already.
    counted: Vec<bool>,
    /// Mix levels of the color stages that are done.
    levels: HashMap<NodeId, usize>,
    output: &'w mut PlannedOutput,
}

impl ControlsWalk<'_, '_> {
    /// Lists the controls of some roots, and returns the largest number of mixing operations on a path from a control
    /// to a root.
    fn program(&mut self, roots: &[u32]) -> usize {
        let ops = self.of.program.ops();
        let needed = cone(self.of.program, roots.iter().copied());
        let mut levels = vec![0usize; needed.len()];
        for (position, (op, _)) in ops.iter().enumerate().filter(|(position, _)| needed[*position]) {
            match op {
                Op::ConstantColor(_) if std::mem::replace(&mut self.counted[position], true) => {}
                Op::ConstantColor(color) => self.output.constants.push(*color),
                Op::LoadColor(slot) => levels[position] = self.stage(slot.node),
                Op::Mix { a, b, .. } => levels[position] = 1 + levels[a.0 as usize].max(levels[b.0 as usize]),
                Op::Blend { colors, .. } => {
                    levels[position] = 1 + colors.iter().map(|color| levels[color.0 as usize]).max().unwrap_or(0);
                }
                _ => {}
            }
        }
        roots.iter().map(|root| levels[*root as usize]).max().unwrap_or(0)
    }

    /// Does the same for a stage that makes colors: a filter has the controls of its inputs, and counts as one more
    /// Mix.
    fn stage(&mut self, id: NodeId) -> usize {
        if let Some(&levels) = self.levels.get(&id) {
            return levels;
        }
        self.output.control_stages.push(id);
        let (planner, lowered) = (self.of.planner, self.of.lowered);
        let settled = lowered.settled[id.0].as_ref().filter(|_| planner.stage(lowered, id).is_some());
        let mut levels = 0;
        for source in settled.map(|settled| settled.sources()).unwrap_or_default() {
            let below = match source {
                Source::Color(color) => {
                    self.output.constants.push([0, 1, 2].map(|c| literal(color[c]) + 0.0));
                    0
                }
                Source::Output { node, output }
                    if matches!(planner.graph.node(*node).kinds[*output], Kind::Color | Kind::Layers(_)) =>
                {
                    match self.of.taps.get(&(*node, *output)) {
                        // The first layer is the color itself.
                        Some(roots) => self.program(&roots[..1]),
                        None => self.stage(*node),
                    }
                }
                _ => continue,
            };
            levels = levels.max(1 + below);
        }
        self.levels.insert(id, levels);
        levels
    }
}
