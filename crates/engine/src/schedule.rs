//! Which stages fill which channels, from the outputs upstream.

use crate::Switches;
use crate::kernel::{Compiled, compile};
use crate::lower::Lowered;
use crate::optimize::{cone, extract};
use crate::plan::{Feed, Fill, Pass};
use crate::planner::Planner;
use std::collections::HashMap;
use trochoid_graph::{ChannelSet, Kind, NodeId, Op, Program, Settled, Slot, Source, Stage, Variance, ViewChannel};

/// Turns an optimized program and the stages around it into passes.
pub(crate) struct Scheduler<'p, 'g, 's> {
    pub(crate) planner: &'p Planner<'g, 's>,
    pub(crate) lowered: &'p Lowered,
    pub(crate) program: &'p Program,
    pub(crate) taps: &'p HashMap<(NodeId, usize), Vec<u32>>,
}

impl Scheduler<'_, '_, '_> {
    fn switches(&self) -> Switches {
        self.planner.settings.switches
    }

    /// One walk over the samples for some outputs: demand flows from them upstream.
    pub(crate) fn pass(&self, members: &[usize], offsets: Vec<[f64; 2]>, output_roots: &[Vec<u32>]) -> Pass {
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
    pub(crate) fn prepares(&self, passes: &[Pass]) -> Vec<(NodeId, Vec<Vec<bool>>)> {
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
