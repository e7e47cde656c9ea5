//! What is needed for some outputs at one frame, in which order, and why the rest is not.

use crate::kernel::{Compiled, compile};
use crate::lower::{Lowered, lower, positions};
use crate::optimize::{Cut, cone, extract, optimize};
use crate::rules::interval::Interval;
use crate::{Settings, Switches};
use std::collections::HashMap;
use trochoid_graph::{
    Body, ChannelSet, CheckedGraph, FrameContext, Kind, NodeId, Op, Program, Settled, Slot, Source, Stage, Variance,
    ViewChannel,
};
use trochoid_image::Window;

/// Why a plan cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// An output's name is none of the document's.
    #[error("found the output \"{found}\"; expected one of: {known}")]
    UnknownOutput {
        /// The name asked for.
        found: String,
        /// The document's outputs.
        known: String,
    },
    /// The pictures would take more memory than allowed.
    #[error(
        "{needed} bytes are needed for pictures of {window}, more than the limit of {limit}: evaluate a smaller region, or raise the limit"
    )]
    Memory {
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
        /// The region.
        window: Window,
    },
    /// The region lies outside the picture.
    #[error("the region {region} has no pixel in common with the picture {picture}: choose one within it")]
    Region {
        /// The region asked for.
        region: Window,
        /// The picture's display window.
        picture: Window,
    },
    /// A buffer is bound to something that takes none.
    #[error("cannot bind \"{name}\": {reason}")]
    Binding {
        /// The name as given.
        name: String,
        /// What is wrong with it.
        reason: String,
    },
    /// Shading samples need every front-end node bound.
    #[error("shading samples cannot be evaluated from \"{name}\" (a {ty}): bind it to a buffer")]
    Unbound {
        /// The node.
        name: String,
        /// Its type.
        ty: String,
    },
}

/// A stage to fill in one pass: which planes, from what.
#[derive(Clone, Debug)]
pub(crate) struct Fill {
    pub(crate) node: NodeId,
    /// By output, by channel.
    pub(crate) wanted: Vec<Vec<bool>>,
    pub(crate) variance: Variance,
    /// The inputs: port, and for each connection the planes of its channels.
    pub(crate) inputs: Vec<(&'static str, Vec<Vec<Feed>>)>,
    /// The pointwise values that it takes, computed before it.
    pub(crate) taps: Option<Compiled>,
}

/// Where a plane of a stage's input comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Feed {
    /// Not asked for.
    Nothing,
    /// A plane that another stage filled.
    Slot(Slot),
    /// A value of the program before it: root and channel.
    Tap(usize, usize),
    /// A literal.
    Constant(f32),
}

/// One walk over all samples: at these offsets, fill these stages, then run this program.
#[derive(Clone, Debug)]
pub(crate) struct Pass {
    pub(crate) offsets: Vec<[f64; 2]>,
    pub(crate) fills: Vec<Fill>,
    pub(crate) program: Compiled,
    /// The outputs that the program's roots belong to: output of the plan, first channel.
    pub(crate) roots: Vec<(usize, usize)>,
}

/// An output within a plan.
#[derive(Clone, Debug)]
pub(crate) struct PlannedOutput {
    /// Index in the graph.
    pub(crate) index: usize,
    pub(crate) kind: Kind,
    /// Most Mix operations on a path from a control to the output, for the margin of rounding.
    pub(crate) mix_levels: usize,
    /// Constant control colors.
    pub(crate) constants: Vec<[f32; 3]>,
    /// Stages whose controls count.
    pub(crate) control_stages: Vec<NodeId>,
}

/// Why a node is not evaluated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LeftOut {
    /// The document disables it.
    Disabled,
    /// No requested output is connected to it.
    Unreachable,
    /// A buffer of the caller stands in for it or for everything that it feeds.
    Bound,
    /// Everything that it feeds is cut off by a constant weight: the mixing node, and the weight found.
    Weight {
        /// Name of the node that mixes.
        at: String,
        /// The constant weight, as text.
        weight: String,
    },
    /// Another node computes the same.
    SameAs(String),
    /// What it feeds needs nothing of it: constants, channels that nobody reads.
    Unneeded,
}

impl std::fmt::Display for LeftOut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Disabled => f.write_str("disabled"),
            Self::Unreachable => f.write_str("no requested output needs it"),
            Self::Bound => f.write_str("a bound buffer stands in for it"),
            Self::Weight { at, weight } => write!(f, "its weight at \"{at}\" is proved {weight} everywhere"),
            Self::SameAs(name) => write!(f, "the same as \"{name}\""),
            Self::Unneeded => f.write_str("nothing that is evaluated reads it"),
        }
    }
}

/// A plan: having one is the proof that its graph is checked and its pictures fit in memory.
#[derive(Debug)]
pub struct Plan<'g> {
    pub(crate) graph: &'g CheckedGraph,
    pub(crate) context: FrameContext,
    pub(crate) settings: Settings,
    pub(crate) window: Window,
    pub(crate) outputs: Vec<PlannedOutput>,
    pub(crate) passes: Vec<Pass>,
    /// Stages to prepare, in order, with the channels wanted by any pass.
    pub(crate) prepares: Vec<(NodeId, Vec<Vec<bool>>)>,
    pub(crate) settled: Vec<Option<Settled>>,
    pub(crate) keys: Vec<String>,
    pub(crate) bound: Vec<bool>,
    /// By node: `None` where it is evaluated.
    pub(crate) left_out: Vec<Option<LeftOut>>,
}

impl<'g> Plan<'g> {
    /// Plans some outputs of a graph at a frame.
    ///
    /// `bound` names nodes whose first output the caller will supply as buffers when the plan runs; what only
    /// they needed is left out.
    ///
    /// # Errors
    /// Unknown outputs or bindings, a region outside the picture, or pictures beyond the memory limit.
    pub fn new(
        graph: &'g CheckedGraph,
        outputs: &[&str],
        frame: i64,
        bound: &[&str],
        settings: &Settings,
    ) -> Result<Self, PlanError> {
        let picture = graph.format().window();
        let window = settings.region.unwrap_or(picture).intersect(picture);
        if window.is_empty() {
            return Err(PlanError::Region { region: settings.region.unwrap_or(picture), picture });
        }
        let chosen = choose_outputs(graph, outputs)?;
        let planes: u64 = chosen.iter().map(|&index| graph.outputs()[index].kind.channels() as u64).sum();
        let needed = planes.saturating_mul(4).saturating_mul(window.area() as u64);
        if needed > settings.memory_limit {
            return Err(PlanError::Memory { needed, limit: settings.memory_limit, window });
        }
        let bound = bind(graph, bound)?;
        let context = graph.frame_context(frame, settings.memory_limit);
        Ok(Planner { graph, settings, bound }.plan(&chosen, context, window))
    }

    /// The frame.
    pub fn frame(&self) -> i64 {
        self.context.frame
    }

    /// The pixels that the plan evaluates.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Why each node of the graph is left out; `None` where it is evaluated.
    pub fn left_out(&self) -> &[Option<LeftOut>] {
        &self.left_out
    }
}

fn choose_outputs(graph: &CheckedGraph, names: &[&str]) -> Result<Vec<usize>, PlanError> {
    if names.is_empty() {
        return Ok((0..graph.outputs().len()).collect());
    }
    let mut chosen = Vec::new();
    for name in names {
        let index = graph.outputs().iter().position(|output| output.name == *name).ok_or_else(|| {
            let known: Vec<&str> = graph.outputs().iter().map(|output| output.name.as_str()).collect();
            PlanError::UnknownOutput { found: (*name).into(), known: known.join(", ") }
        })?;
        if !chosen.contains(&index) {
            chosen.push(index);
        }
    }
    Ok(chosen)
}

fn bind(graph: &CheckedGraph, names: &[&str]) -> Result<Vec<bool>, PlanError> {
    let mut bound = vec![false; graph.nodes().len()];
    for name in names {
        let fault = |reason: &str| PlanError::Binding { name: (*name).into(), reason: reason.into() };
        let id = graph.find(name).ok_or_else(|| fault("no node has that name"))?;
        let kind = graph.node(id).kinds.first().copied();
        if !matches!(kind, Some(Kind::Color | Kind::Weights(_) | Kind::Field(_))) {
            return Err(fault("only Colors, masks, Weights and Fields can be bound; bind the passes instead"));
        }
        bound[id.0] = true;
    }
    Ok(bound)
}

struct Planner<'g, 's> {
    graph: &'g CheckedGraph,
    settings: &'s Settings,
    bound: Vec<bool>,
}

impl<'g> Planner<'g, '_> {
    fn plan(self, chosen: &[usize], context: FrameContext, window: Window) -> Plan<'g> {
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
        let left_out = self.left_out(&needed, &lowered, &optimized.cuts, &passes, &prepares);
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

    fn stage(&self, id: NodeId) -> Option<&'static dyn Stage> {
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

    fn variance(&self, lowered: &Lowered, slot: &Slot) -> Variance {
        match (self.stage(slot.node), &lowered.settled[slot.node.0]) {
            (Some(stage), Some(settled)) => stage.variance(settled, slot.output),
            _ => Variance::Pixel,
        }
    }

    fn left_out(
        &self,
        needed: &[bool],
        lowered: &Lowered,
        cuts: &[Cut],
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
                .filter(|(_, inside)| *inside)
                .map(|((_, origin), _)| *origin)
                .collect();
            for (id, feeds) in graph.upstream(origins).iter().enumerate() {
                if *feeds && cut_by[id].is_none() {
                    cut_by[id] = Some(cut);
                }
            }
        }
        let all_reachable = graph.upstream(
            graph.outputs().iter().filter(|_| self.bound.iter().any(|&bound| bound)).map(|output| output.node),
        );
        graph
            .nodes()
            .iter()
            .enumerate()
            .map(|(id, node)| {
                let same = lowered.stands_in[id];
                if node.disabled {
                    Some(LeftOut::Disabled)
                } else if self.bound[id] || (!needed[id] && all_reachable[id]) {
                    Some(LeftOut::Bound)
                } else if !needed[id] {
                    Some(LeftOut::Unreachable)
                } else if used[id] {
                    None
                } else if same.0 != id {
                    Some(LeftOut::SameAs(graph.node(same).name.clone()))
                } else if let Some(cut) = cut_by[id] {
                    let weight = if cut.weight == 0.0 { "0" } else { "1 for its rival" };
                    Some(LeftOut::Weight { at: graph.node(cut.at).name.clone(), weight: weight.into() })
                } else if self.is_pointwise(NodeId(id)) {
                    // Merged into an equal operation of another node, or folded into a constant.
                    None
                } else {
                    Some(LeftOut::Unneeded)
                }
            })
            .collect()
    }
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

struct Scheduler<'p, 'g, 's> {
    planner: &'p Planner<'g, 's>,
    lowered: &'p Lowered,
    program: &'p Program,
    taps: &'p HashMap<(NodeId, usize), Vec<u32>>,
}

impl Scheduler<'_, '_, '_> {
    fn switches(&self) -> Switches {
        self.planner.settings.switches
    }

    /// One walk over the samples for some outputs: demand flows from them upstream.
    fn pass(&self, members: &[usize], offsets: Vec<[f64; 2]>, output_roots: &[Vec<u32>]) -> Pass {
        let graph = self.planner.graph;
        let roots: Vec<u32> = members.iter().flat_map(|&member| output_roots[member].iter().copied()).collect();
        let mut needed = cone(self.program, roots.iter().copied());
        if !self.switches().demand {
            needed.fill(true);
        }
        let mut wanted: HashMap<NodeId, Vec<Vec<bool>>> = HashMap::new();
        self.want_loads(&needed, &mut wanted);
        if !self.switches().demand {
            // Everything reachable, every channel.
            for (index, settled) in self.lowered.settled.iter().enumerate() {
                let id = NodeId(index);
                if settled.is_some() && self.lowered.stands_in[index] == id && self.planner.stage(id).is_some() {
                    wanted.insert(id, self.channels(id, true));
                }
            }
        }
        let mut fills = Vec::new();
        for &id in graph.order().iter().rev() {
            if self.planner.bound[id.0] {
                if let Some(wanted) = wanted.remove(&id) {
                    let variance = Variance::Pixel;
                    fills.push(Fill { node: id, wanted, variance, inputs: Vec::new(), taps: None });
                }
                continue;
            }
            let (Some(stage), Some(settled)) = (self.planner.stage(id), self.lowered.settled[id.0].as_ref()) else {
                continue;
            };
            let Some(own) = wanted.get(&id).cloned() else { continue };
            let fill = self.fill(id, stage, settled, own, &mut wanted);
            // Cameras, lights and surfaces are only prepared.
            if fill.wanted.iter().any(|channels| channels.iter().any(|&channel| channel)) {
                fills.push(fill);
            }
        }
        fills.reverse();
        let program = self.compile(&roots);
        let mut owners = Vec::new();
        for &member in members {
            for channel in 0..output_roots[member].len() {
                owners.push((member, channel));
            }
        }
        Pass { offsets, fills, program, roots: owners }
    }

    /// Marks what `needed` operations load.
    fn want_loads(&self, needed: &[bool], wanted: &mut HashMap<NodeId, Vec<Vec<bool>>>) {
        for (op, _) in self.program.ops().iter().zip(needed).filter(|(_, needed)| **needed).map(|(op, _)| op) {
            match op {
                Op::Load(slot) => self.want(wanted, *slot),
                Op::LoadColor(slot) => (0..3).for_each(|channel| self.want(wanted, Slot { channel, ..*slot })),
                _ => {}
            }
        }
    }

    fn want(&self, wanted: &mut HashMap<NodeId, Vec<Vec<bool>>>, slot: Slot) {
        let own = wanted.entry(slot.node).or_insert_with(|| self.channels(slot.node, false));
        own[slot.output][slot.channel] = true;
    }

    /// What a view can supply.
    fn supplies(&self, id: NodeId) -> ChannelSet {
        match (self.planner.stage(id), &self.lowered.settled[id.0]) {
            (Some(stage), Some(settled)) => stage.supplies(settled),
            _ => ChannelSet::EMPTY,
        }
    }

    fn channels(&self, id: NodeId, wanted: bool) -> Vec<Vec<bool>> {
        let supplied = self.supplies(id);
        let channel =
            |kind: &Kind, index: usize| wanted && (*kind != Kind::View || supplied.contains(ViewChannel::ALL[index]));
        let kinds = &self.planner.graph.node(id).kinds;
        kinds.iter().map(|kind| (0..kind.channels()).map(|index| channel(kind, index)).collect()).collect()
    }

    /// Plans one stage's inputs and marks what it wants of others.
    fn fill(
        &self,
        id: NodeId,
        stage: &'static dyn Stage,
        settled: &Settled,
        own: Vec<Vec<bool>>,
        wanted: &mut HashMap<NodeId, Vec<Vec<bool>>>,
    ) -> Fill {
        let outputs_wanted: Vec<bool> = own.iter().map(|channels| channels.iter().any(|&channel| channel)).collect();
        let asks = stage.asks(settled, &outputs_wanted);
        let prefers = stage.prefers(settled, &outputs_wanted);
        let mut tap_roots: Vec<u32> = Vec::new();
        let mut inputs = Vec::new();
        for (port, sources) in settled.ports() {
            let feeds = sources.iter().map(|source| self.feed(source, asks, prefers, &mut tap_roots, wanted)).collect();
            inputs.push((port, feeds));
        }
        let taps = (!tap_roots.is_empty()).then(|| {
            self.want_loads(&cone(self.program, tap_roots.iter().copied()), wanted);
            self.compile(&tap_roots)
        });
        let variance = if self.switches().hoist {
            (0..own.len()).map(|output| stage.variance(settled, output)).max().unwrap_or(Variance::Pixel)
        } else {
            Variance::Pixel
        };
        Fill { node: id, wanted: own, variance, inputs, taps }
    }

    fn feed(
        &self,
        source: &Source<Vec<f64>>,
        asks: ChannelSet,
        prefers: ChannelSet,
        tap_roots: &mut Vec<u32>,
        wanted: &mut HashMap<NodeId, Vec<Vec<bool>>>,
    ) -> Vec<Feed> {
        match source {
            Source::Number(values) | Source::Color(values) => {
                values.iter().map(|v| Feed::Constant(*v as f32)).collect()
            }
            Source::Numbers(numbers) => numbers.iter().map(|v| Feed::Constant(*v as f32)).collect(),
            Source::Output { node, output } => {
                let kind = self.planner.graph.node(*node).kinds[*output];
                if let Some(positions) = self.taps.get(&(*node, *output)) {
                    let mut feeds = Vec::new();
                    for &position in positions {
                        tap_roots.push(position);
                        let channels = if kind == Kind::Color { 3 } else { 1 };
                        feeds.extend((0..channels).map(|channel| Feed::Tap(tap_roots.len() - 1, channel)));
                    }
                    return feeds;
                }
                // A camera, light or surface still has to be prepared.
                wanted.entry(*node).or_insert_with(|| self.channels(*node, false));
                let asks = asks.union(prefers.intersect(self.supplies(*node)));
                (0..kind.channels())
                    .map(|channel| {
                        if kind == Kind::View && !asks.contains(ViewChannel::ALL[channel]) {
                            return Feed::Nothing;
                        }
                        let slot = Slot { node: *node, output: *output, channel };
                        self.want(wanted, slot);
                        Feed::Slot(slot)
                    })
                    .collect()
            }
        }
    }

    fn compile(&self, roots: &[u32]) -> Compiled {
        let mut kept = cone(self.program, roots.iter().copied());
        if !self.switches().demand {
            kept.fill(true);
        }
        let (program, map) = extract(self.program, &kept);
        let roots: Vec<u32> = roots.iter().map(|root| map[*root as usize]).collect();
        let switches = self.switches();
        compile(&program, &roots, switches.hoist, switches.fuse, &|slot| self.planner.variance(self.lowered, slot))
    }

    /// Every stage that some pass fills, or whose handle another stage takes, inputs first.
    fn prepares(&self, passes: &[Pass]) -> Vec<(NodeId, Vec<Vec<bool>>)> {
        let graph = self.planner.graph;
        let mut wanted: HashMap<NodeId, Vec<Vec<bool>>> = HashMap::new();
        for fill in passes.iter().flat_map(|pass| &pass.fills).filter(|fill| !self.planner.bound[fill.node.0]) {
            let own = wanted.entry(fill.node).or_insert_with(|| self.channels(fill.node, false));
            for (own, fill) in own.iter_mut().flatten().zip(fill.wanted.iter().flatten()) {
                *own |= fill;
            }
        }
        for &id in graph.order().iter().rev() {
            if !wanted.contains_key(&id) {
                continue;
            }
            let Some(settled) = &self.lowered.settled[id.0] else { continue };
            for source in settled.sources() {
                if let Source::Output { node, .. } = source
                    && self.planner.stage(*node).is_some()
                {
                    wanted.entry(*node).or_insert_with(|| self.channels(*node, false));
                }
            }
        }
        graph.order().iter().filter_map(|id| Some((*id, wanted.remove(id)?))).collect()
    }
}
