//! Makes plans: lowers, optimizes, schedules, and explains what is left out.

use super::bounds::with_bounds;
use super::controls::Controls;
use super::explain::{Account, Explainer};
use super::left_out::Reasons;
use super::lower::{LoweredGraph, lower, positions, roots};
use super::optimize::{cone, optimize};
use super::plan::Pass;
use super::schedule::Scheduler;
use crate::rules::interval::Interval;
use crate::{Plan, Settings};
use std::collections::HashMap;
use std::sync::OnceLock;
use trochoid_graph::{CheckedGraph, FrameContext, Key, Kind, NodeId, Settled, Slot, Source, Stage, Variance};
use trochoid_image::Window;

/// A plan in the making.
pub(crate) struct Planner<'g, 's> {
    pub(crate) graph: &'g CheckedGraph,
    pub(crate) settings: &'s Settings,
    pub(crate) bound: Vec<bool>,
    pub(crate) frame: i64,
}

impl<'g> Planner<'g, '_> {
    /// Makes the plan. Appends what happens to each node to `accounts`, if given.
    pub(crate) fn plan(
        self,
        chosen: &[usize],
        context: FrameContext,
        window: Window,
        accounts: Option<&mut Vec<Account>>,
    ) -> Plan<'g> {
        let graph = self.graph;
        let switches = self.settings.switches;
        let shown: Vec<NodeId> = chosen.iter().map(|&index| graph.outputs()[index].node).collect();
        let settled = self.reachable(&shown);
        let needed: Vec<bool> = settled.iter().map(Option::is_some).collect();
        let keys = graph.keys(&settled, &context);
        let merge_keys: &[Key] = if switches.merge { &keys } else { &[] };
        let mut lowered = lower(graph, settled, &self.bound, merge_keys);

        // Positions of every output's channels, and of every pointwise value that a stage takes.
        let mut output_roots = Vec::new();
        for &index in chosen {
            let spec = &graph.outputs()[index];
            let value = lowered.values[spec.node.0][spec.output].clone();
            output_roots.push(value.map(|value| roots(&mut lowered.program, spec, &value)).unwrap_or_default());
        }
        let mut taps = HashMap::new();
        for &id in graph.order() {
            let Some(settled) = lowered.settled[id.0].as_ref().filter(|_| self.is_stage(id, &lowered)) else {
                continue;
            };
            for source in settled.sources() {
                if let Source::Output { node, output } = source
                    && self.is_pointwise(&lowered, *node)
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
        let source_roots = output_roots;
        let output_roots: Vec<Vec<u32>> = source_roots.iter().map(&remap).collect();
        let taps: HashMap<_, Vec<u32>> = taps.iter().map(|(key, positions)| (*key, remap(positions))).collect();

        let shared = self.shared(&lowered);
        let program = &optimized.program;
        let scheduler = Scheduler { planner: &self, lowered: &lowered, program, taps: &taps, shared: &shared };
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
        let mut passes: Vec<Pass> = groups
            .into_iter()
            .filter(|(members, _)| !members.is_empty())
            .map(|(members, offsets)| scheduler.pass(&members, offsets, &output_roots))
            .collect();
        let prepares = scheduler.prepares(&passes);
        if self.settings.bounds() {
            passes.iter_mut().for_each(|pass| with_bounds(pass, graph));
        }
        let controls = Controls { planner: &self, lowered: &lowered, program: &optimized.program, taps: &taps };
        let outputs = chosen.iter().zip(&output_roots).map(|(&index, roots)| controls.output(index, roots)).collect();
        let alive = cone(&optimized.program, output_roots.iter().chain(taps.values()).flatten().copied());
        let reasons = Reasons {
            planner: &self,
            needed: &needed,
            roots: &shown,
            lowered: &lowered,
            optimized: &optimized,
            alive: &alive,
            used: &self.used(&passes, &prepares),
        };
        let left_out = reasons.list();
        if let Some(accounts) = accounts {
            let supplies = |id| scheduler.supplies(id);
            let explainer =
                Explainer { reasons: &reasons, left_out: &left_out, prepares: &prepares, supplies: &supplies };
            accounts.extend(explainer.accounts());
        }
        Plan {
            graph,
            context,
            settings: self.settings.clone(),
            window,
            outputs,
            passes,
            source: (lowered.program, source_roots),
            prepares,
            settled: lowered.settled,
            keys,
            bound: self.bound,
            pool: OnceLock::new(),
            shared,
            left_out,
        }
    }

    /// Returns the knobs at the frame of every node that the roots depend on, without looking past bound nodes.
    pub(super) fn reachable(&self, roots: &[NodeId]) -> Vec<Option<Settled>> {
        let mut settled: Vec<Option<Settled>> = vec![None; self.graph.nodes().len()];
        let mut open = roots.to_vec();
        while let Some(id) = open.pop() {
            if settled[id.0].is_some() {
                continue;
            }
            let own = settled[id.0].insert(self.graph.settle(id, self.frame));
            if !self.bound[id.0] {
                own.each_needed(|node| open.push(node));
            }
        }
        settled
    }

    /// Returns a node's stage, if it is needed and not filled from outside.
    pub(crate) fn stage<'l>(&self, lowered: &'l LoweredGraph, id: NodeId) -> Option<&'l dyn Stage> {
        lowered.settled[id.0].as_ref().filter(|_| !self.bound[id.0])?.stage()
    }

    pub(crate) fn is_pointwise(&self, lowered: &LoweredGraph, id: NodeId) -> bool {
        !self.bound[id.0] && lowered.settled[id.0].as_ref().is_some_and(|settled| settled.pointwise().is_some())
    }

    fn is_stage(&self, id: NodeId, lowered: &LoweredGraph) -> bool {
        lowered.stands_in[id.0] == id && self.stage(lowered, id).is_some()
    }

    pub(super) fn slot_interval(&self, lowered: &LoweredGraph, slot: &Slot, channel: usize) -> Interval {
        let by_kind = match self.graph.node(slot.node).kinds[slot.output] {
            Kind::Color | Kind::Layers(_) => Interval::COLOR,
            Kind::Weights(_) => Interval::MASK,
            _ => Interval::ALL,
        };
        let Some(stage) = self.stage(lowered, slot.node) else { return by_kind };
        stage.interval(slot.output, channel).map_or(by_kind, |(low, high)| Interval { low, high })
    }

    pub(crate) fn variance(&self, lowered: &LoweredGraph, slot: &Slot) -> Variance {
        self.stage(lowered, slot.node).map_or(Variance::Pixel, |stage| stage.variance(slot.output))
    }

    /// Finds the nodes that are evaluated.
    fn used(&self, passes: &[Pass], prepares: &[(NodeId, Vec<Vec<bool>>)]) -> Vec<bool> {
        let mut used = vec![false; self.graph.nodes().len()];
        for (id, _) in prepares {
            used[id.0] = true;
        }
        for pass in passes {
            for compiled in pass.fills.iter().filter_map(|fill| fill.taps.as_ref()).chain([&pass.program]) {
                for (origin, _) in &compiled.costs {
                    used[origin.0] = true;
                }
                for slot in &compiled.planes {
                    used[slot.node.0] = true;
                }
            }
        }
        used
    }
}
