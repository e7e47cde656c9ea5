//! Makes plans: lower, optimize, schedule, and explain what is left out.

use crate::lower::{Lowered, lower, positions};
use crate::optimize::{Cut, Optimized, cone, optimize};
use crate::plan::{Pass, PlannedOutput};
use crate::rules::interval::Interval;
use crate::schedule::Scheduler;
use crate::{LeftOut, Plan, Settings};
use std::collections::HashMap;
use trochoid_graph::{Body, CheckedGraph, FrameContext, Kind, NodeId, Op, Program, Slot, Source, Stage, Variance};
use trochoid_image::Window;

/// A plan in the making.
pub(crate) struct Planner<'g, 's> {
    pub(crate) graph: &'g CheckedGraph,
    pub(crate) settings: &'s Settings,
    pub(crate) bound: Vec<bool>,
}

impl<'g> Planner<'g, '_> {
    pub(crate) fn plan(self, chosen: &[usize], context: FrameContext, window: Window) -> Plan<'g> {
        let graph = self.graph;
        let switches = self.settings.switches;
        let roots = chosen.iter().map(|&index| graph.outputs()[index].node);
        let needed = self.reachable(roots);
        let keys = graph.keys(&context);
        let merge_keys: &[String] = if switches.merge { &keys } else { &[] };
        let mut lowered = lower(graph, context.frame, &needed, &self.bound, merge_keys);

        // Positions of every output's channels, and of everything pointwise that a stage takes.
        let mut output_roots = Vec::new();
        for &index in chosen {
            let spec = &graph.outputs()[index];
            let value = lowered.values[spec.node.0][spec.output].clone();
            output_roots
                .push(value.map(|value| positions(&mut lowered.program, spec.node, &value)).unwrap_or_default());
        }
        let mut taps = HashMap::new();
        for &id in graph.order() {
            if !self.is_stage(id, &needed, &lowered) {
                continue;
            }
            let Some(settled) = lowered.settled[id.0].clone() else { continue };
            for source in settled.sources() {
                if let Source::Output { node, output } = source
                    && self.is_pointwise(*node)
                    && let Some(value) = lowered.values[node.0][*output].clone()
                {
                    taps.insert((*node, *output), positions(&mut lowered.program, *node, &value));
                }
            }
        }

        let slot_interval = |slot: &Slot, channel: usize| self.slot_interval(&lowered, slot, channel);
        let optimized = optimize(&lowered.program, switches, &slot_interval);
        let remap =
            |positions: &Vec<u32>| -> Vec<u32> { positions.iter().map(|p| optimized.map[*p as usize]).collect() };
        let output_roots: Vec<Vec<u32>> = output_roots.iter().map(&remap).collect();
        let taps: HashMap<_, Vec<u32>> = taps.iter().map(|(key, positions)| (*key, remap(positions))).collect();

        let scheduler = Scheduler { planner: &self, lowered: &lowered, program: &optimized.program, taps: &taps };
        // Colors and weights are averaged over the pixel's samples; a field is taken at the pixel's center.
        let format = graph.format();
        let offsets: Vec<[f64; 2]> = (0..format.samples()).map(|i| format.sample_offset(i)).collect();
        let is_field = |i: &usize| matches!(graph.outputs()[chosen[*i]].kind, Kind::Field(_));
        let all: Vec<usize> = (0..chosen.len()).collect();
        let groups: Vec<(Vec<usize>, Vec<[f64; 2]>)> = if offsets.len() == 1 {
            vec![(all, offsets)]
        } else {
            let (fields, averaged): (Vec<usize>, Vec<usize>) = all.into_iter().partition(is_field);
            vec![(averaged, offsets), (fields, vec![[0.5, 0.5]])]
        };
        let passes: Vec<Pass> = groups
            .into_iter()
            .filter(|(members, _)| !members.is_empty())
            .map(|(members, offsets)| scheduler.pass(&members, offsets, &output_roots))
            .collect();
        let prepares = scheduler.prepares(&passes);
        let outputs = chosen
            .iter()
            .zip(&output_roots)
            .map(|(&index, roots)| planned_output(graph, index, roots, &optimized.program))
            .collect();
        let connected = graph.upstream(chosen.iter().map(|&index| graph.outputs()[index].node));
        let alive = cone(&optimized.program, output_roots.iter().chain(taps.values()).flatten().copied());
        let is_read = |id: NodeId| is_read(id, &lowered, &optimized, &alive);
        let left_out = self.left_out([&needed, &connected], &lowered, (&optimized.cuts, &is_read), &passes, &prepares);
        Plan {
            graph,
            context,
            settings: self.settings.clone(),
            window,
            outputs,
            passes,
            prepares,
            settled: lowered.settled,
            keys,
            bound: self.bound,
            left_out,
        }
    }

    /// Nodes upstream of the roots, not looking past bound ones.
    fn reachable(&self, roots: impl Iterator<Item = NodeId>) -> Vec<bool> {
        let mut needed = vec![false; self.graph.nodes().len()];
        let mut open: Vec<NodeId> = roots.collect();
        while let Some(id) = open.pop() {
            if std::mem::replace(&mut needed[id.0], true) || self.bound[id.0] {
                continue;
            }
            open.extend(self.graph.node(id).record.sources().into_iter().filter_map(|source| match source {
                Source::Output { node, .. } => Some(*node),
                _ => None,
            }));
        }
        needed
    }

    pub(crate) fn stage(&self, id: NodeId) -> Option<&'static dyn Stage> {
        match self.graph.node(id).ty.body() {
            Body::Stage(stage) if !self.bound[id.0] => Some(stage),
            _ => None,
        }
    }

    fn is_pointwise(&self, id: NodeId) -> bool {
        !self.bound[id.0] && matches!(self.graph.node(id).ty.body(), Body::Pointwise(_))
    }

    fn is_stage(&self, id: NodeId, needed: &[bool], lowered: &Lowered) -> bool {
        needed[id.0] && lowered.stands_in[id.0] == id && self.stage(id).is_some()
    }

    fn slot_interval(&self, lowered: &Lowered, slot: &Slot, channel: usize) -> Interval {
        let by_kind = match self.graph.node(slot.node).kinds[slot.output] {
            Kind::Color => Interval::COLOR,
            Kind::Weights(_) => Interval::MASK,
            _ => Interval::ALL,
        };
        let (Some(stage), Some(settled)) = (self.stage(slot.node), &lowered.settled[slot.node.0]) else {
            return by_kind;
        };
        stage.interval(settled, slot.output, channel).map_or(by_kind, |(low, high)| Interval { low, high })
    }

    pub(crate) fn variance(&self, lowered: &Lowered, slot: &Slot) -> Variance {
        match (self.stage(slot.node), &lowered.settled[slot.node.0]) {
            (Some(stage), Some(settled)) => stage.variance(settled, slot.output),
            _ => Variance::Pixel,
        }
    }

    /// Why each node is left out. `needed` ends at bound nodes, `connected` does not; of a pointwise node,
    /// `is_read` tells whether its value is.
    fn left_out(
        &self,
        [needed, connected]: [&[bool]; 2],
        lowered: &Lowered,
        (cuts, is_read): (&[Cut], &dyn Fn(NodeId) -> bool),
        passes: &[Pass],
        prepares: &[(NodeId, Vec<Vec<bool>>)],
    ) -> Vec<Option<LeftOut>> {
        let graph = self.graph;
        let mut used = vec![false; graph.nodes().len()];
        for (id, _) in prepares {
            used[id.0] = true;
        }
        for pass in passes {
            for compiled in pass.fills.iter().filter_map(|fill| fill.taps.as_ref()).chain([&pass.program]) {
                for instruction in compiled.once.iter().chain(&compiled.each) {
                    used[instruction.origin.0] = true;
                }
                for slot in &compiled.planes {
                    used[slot.node.0] = true;
                }
            }
        }
        // Nodes that a cut operand came from, with the cut nearest to the output that explains it.
        let mut cut_by: Vec<Option<&Cut>> = vec![None; graph.nodes().len()];
        for cut in cuts {
            let inside = cone(&lowered.program, [cut.operand]);
            let origins: Vec<NodeId> = lowered
                .program
                .ops()
                .iter()
                .zip(inside)
                // A literal operand bears the name of the mixing node itself, which is not cut off.
                .filter(|((_, origin), inside)| *inside && *origin != cut.at)
                .map(|((_, origin), _)| *origin)
                .collect();
            for (id, feeds) in graph.upstream(origins).iter().enumerate() {
                if *feeds && cut_by[id].is_none() {
                    cut_by[id] = Some(cut);
                }
            }
        }
        graph
            .nodes()
            .iter()
            .enumerate()
            .map(|(id, node)| {
                let same = lowered.stands_in[id];
                if node.disabled {
                    Some(LeftOut::Disabled)
                } else if self.bound[id] || (!needed[id] && connected[id]) {
                    Some(LeftOut::Bound)
                } else if !needed[id] {
                    Some(LeftOut::Unreachable)
                } else if used[id] {
                    None
                } else if same.0 != id {
                    Some(LeftOut::SameAs(graph.node(same).name.clone()))
                } else if let Some(cut) = cut_by[id] {
                    Some(LeftOut::Weight(graph.node(cut.at).name.clone()))
                } else if self.is_pointwise(NodeId(id)) && is_read(NodeId(id)) {
                    // Merged into an equal operation of another node, or folded into a constant.
                    None
                } else {
                    Some(LeftOut::Unneeded)
                }
            })
            .collect()
    }
}

/// Whether anything of a pointwise node is read, folded into a constant, or was nothing but constants.
fn is_read(id: NodeId, lowered: &Lowered, optimized: &Optimized, alive: &[bool]) -> bool {
    let is_constant = |op: &Op| matches!(op, Op::Constant(_) | Op::ConstantColor(_));
    let own =
        lowered.program.ops().iter().zip(&optimized.map).filter(|((op, origin), _)| *origin == id && !is_constant(op));
    let mut positions = own.map(|(_, &position)| position as usize).peekable();
    positions.peek().is_none()
        || positions.any(|position| alive[position] || is_constant(&optimized.program.ops()[position].0))
}

fn planned_output(graph: &CheckedGraph, index: usize, roots: &[u32], program: &Program) -> PlannedOutput {
    let kind = graph.outputs()[index].kind;
    let mut output = PlannedOutput { index, kind, mix_levels: 0, constants: Vec::new(), control_stages: Vec::new() };
    if kind != Kind::Color {
        return output;
    }
    let needed = cone(program, roots.iter().copied());
    let mut levels = vec![0usize; needed.len()];
    for (position, (op, _)) in program.ops().iter().enumerate().filter(|(position, _)| needed[*position]) {
        match op {
            Op::ConstantColor(color) => output.constants.push(*color),
            Op::LoadColor(slot) => output.control_stages.push(slot.node),
            Op::Mix { a, b, .. } => levels[position] = 1 + levels[a.0 as usize].max(levels[b.0 as usize]),
            Op::Blend { colors, .. } => {
                levels[position] = 1 + colors.iter().map(|color| levels[color.0 as usize]).max().unwrap_or(0);
            }
            _ => {}
        }
    }
    output.mix_levels = roots.iter().map(|root| levels[*root as usize]).max().unwrap_or(0);
    output.control_stages.sort();
    output.control_stages.dedup();
    output
}
