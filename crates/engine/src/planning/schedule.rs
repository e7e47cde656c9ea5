//! Decides which stages fill which channels, walking upstream from the outputs.

use super::lower::LoweredGraph;
use super::optimize::{cone, extract};
use super::plan::{Feed, Fill, Pass};
use super::planner::Planner;
use super::shading::{SHARING_CHANNELS, ViewsByNode, sharing_slot};
use crate::Switches;
use std::collections::{HashMap, HashSet};
use trochoid_graph::{
    Channel, ChannelSet, Kind, NodeId, Op, PortId, Program, Rate, Settled, Slot, Source, Stage, Variance, literal,
};
use trochoid_image::{Format, Shading, Window};
use trochoid_kernel::{CompiledProgram, Options, Origin, ValueRule, compile};

/// Channels that stages have to fill.
#[derive(Default)]
struct Demand {
    /// Channels by node, output and channel.
    channels: HashMap<NodeId, Vec<Vec<bool>>>,
    /// Slots that are read at every sample, not only at samples that share no result.
    per_sample: HashSet<Slot>,
}

/// Turns an optimized program and the stages around it into passes.
pub(crate) struct Scheduler<'p, 'g, 's> {
    pub(crate) planner: &'p Planner<'g, 's>,
    pub(crate) lowered: &'p LoweredGraph,
    pub(crate) program: &'p Program,
    pub(crate) taps: &'p HashMap<(NodeId, usize), Vec<u32>>,
    pub(crate) shared: &'p ViewsByNode,
}

impl Scheduler<'_, '_, '_> {
    fn switches(&self) -> Switches {
        self.planner.settings.switches
    }

    /// Plans one walk over the samples for some outputs: demand flows upstream from them.
    pub(crate) fn pass(&self, members: &[usize], offsets: Vec<[f64; 2]>, output_roots: &[Vec<u32>]) -> Pass {
        let graph = self.planner.graph;
        let roots: Vec<u32> = members.iter().flat_map(|&member| output_roots[member].iter().copied()).collect();
        let mut needed = cone(self.program, roots.iter().copied());
        if !self.switches().demand {
            needed.fill(true);
        }
        let mut wanted = Demand::default();
        self.want_loads(&needed, true, &mut wanted);
        if !self.switches().demand {
            // Everything reachable, every channel.
            for index in 0..self.lowered.settled.len() {
                let id = NodeId(index);
                if self.lowered.stands_in[index] == id && self.stage(id).is_some() {
                    wanted.channels.insert(id, self.channels(id, true));
                }
            }
        }
        let sharing = offsets.len() > 1 && graph.format().shading() == Shading::Pixel;
        let mut fills: Vec<Fill> = Vec::new();
        for &id in graph.order().iter().rev() {
            if self.planner.bound[id.0] {
                if let Some(wanted) = wanted.channels.remove(&id) {
                    let (variance, inputs) = (Variance::Pixel, Vec::new());
                    fills.push(Fill {
                        node: id,
                        wanted,
                        variance,
                        inputs,
                        taps: None,
                        steady: false,
                        read: false,
                        shared: None,
                        gates: None,
                    });
                }
                continue;
            }
            let (Some(stage), Some(settled)) = (self.stage(id), self.lowered.settled[id.0].as_ref()) else {
                continue;
            };
            let Some(own) = wanted.channels.get(&id).cloned() else { continue };
            let shared = self.shared[id.0].clone().filter(|_| sharing);
            let mut fill = self.fill(id, stage, settled, own, sharing, shared, &mut wanted);
            if sharing && stage.rate() == Rate::Surface && graph.node(id).kinds.contains(&Kind::View) {
                fills.extend(split(&mut fill, &wanted.per_sample));
            }
            // Cameras, lights and surfaces are only prepared.
            if fill.wanted.iter().any(|channels| channels.iter().any(|&channel| channel)) {
                fills.push(fill);
            }
        }
        fills.reverse();
        let program = self.compile(&roots, !self.switches().demand, self.switches().hoist);
        for fill in &mut fills {
            fill.read = program.planes.iter().any(|slot| fill.fills(slot));
        }
        let is_gated = self.switches().demand && !sharing && !self.planner.settings.bounds();
        let gates = is_gated.then(|| self.gates(&roots, &mut fills)).flatten();
        let halo = self.halo(&fills);
        let mut owners = Vec::new();
        for &member in members {
            for channel in 0..output_roots[member].len() {
                owners.push((member, channel));
            }
        }
        let scattered = (self.is_sparse() && offsets.len() > 1).then(|| self.compile(&roots, false, false));
        Pass { offsets, fills, gates, halo, sharing, program, scattered, roots: owners }
    }

    /// Returns the slots that the `needed` operations load.
    pub(super) fn loads(&self, needed: &[bool]) -> impl Iterator<Item = Slot> {
        let ops = self.program.ops().iter().zip(needed).filter(|(_, needed)| **needed);
        ops.flat_map(|((op, _), _)| match op {
            Op::Load(slot) => vec![*slot],
            Op::LoadColor(slot) => (slot.channel..slot.channel + 3).map(|channel| Slot { channel, ..*slot }).collect(),
            _ => Vec::new(),
        })
    }

    /// Marks the slots that the `needed` operations load.
    fn want_loads(&self, needed: &[bool], per_sample: bool, wanted: &mut Demand) {
        self.loads(needed).for_each(|slot| self.want(wanted, slot, per_sample));
    }

    /// Returns whether further samples of adaptive sampling are taken at single pixels.
    fn is_sparse(&self) -> bool {
        let format = self.planner.graph.format();
        let is_sparse = self.switches().sparse && self.switches().demand && !self.planner.settings.bounds();
        is_sparse && format.adaptive().is_some() && format.samples() > 1
    }

    /// Returns whether a stage's results are mostly the same for all samples of a pixel that share.
    fn is_steady(&self, id: NodeId) -> bool {
        let is_view = self.planner.graph.node(id).kinds.contains(&Kind::View);
        is_view || self.shared[id.0].is_some() || self.planner.bound[id.0]
    }

    fn want(&self, wanted: &mut Demand, slot: Slot, per_sample: bool) {
        let own = wanted.channels.entry(slot.node).or_insert_with(|| self.channels(slot.node, false));
        own[slot.output][slot.channel] = true;
        if per_sample {
            wanted.per_sample.insert(slot);
        }
    }

    /// Returns the channels that a view can supply.
    pub(crate) fn supplies(&self, id: NodeId) -> ChannelSet {
        self.stage(id).map_or(ChannelSet::EMPTY, Stage::supplied_channels)
    }

    pub(super) fn stage(&self, id: NodeId) -> Option<&dyn Stage> {
        self.planner.stage(self.lowered, id)
    }

    fn channels(&self, id: NodeId, wanted: bool) -> Vec<Vec<bool>> {
        let supplied = self.supplies(id);
        let channel =
            |kind: &Kind, index: usize| wanted && (*kind != Kind::View || supplied.contains(Channel::ALL[index]));
        let kinds = &self.planner.graph.node(id).kinds;
        kinds.iter().map(|kind| (0..kind.channels()).map(|index| channel(kind, index)).collect()).collect()
    }

    /// Plans one stage's inputs and marks what it wants from other stages.
    #[expect(clippy::too_many_arguments, reason = "what is known of a stage")]
    fn fill(
        &self,
        id: NodeId,
        stage: &dyn Stage,
        settled: &Settled,
        own: Vec<Vec<bool>>,
        sharing: bool,
        shared: Option<Vec<NodeId>>,
        wanted: &mut Demand,
    ) -> Fill {
        let per_sample = shared.is_none();
        for view in shared.iter().flatten() {
            for channel in SHARING_CHANNELS {
                self.want(wanted, Slot { node: *view, output: 0, channel: channel as usize }, true);
            }
        }
        let outputs_wanted: Vec<bool> = own.iter().map(|channels| channels.iter().any(|&channel| channel)).collect();
        let asks = stage.required_channels(&outputs_wanted);
        let prefers = stage.optional_channels(&outputs_wanted);
        let mut tap_roots: Vec<u32> = Vec::new();
        let mut inputs = Vec::new();
        for (index, (name, sources)) in settled.ports().enumerate() {
            let feeds = sources
                .iter()
                .map(|source| {
                    let feeds = self.feed(id, source, asks, prefers, per_sample, &mut tap_roots, wanted);
                    self.with_layers(id, source, feeds)
                })
                .collect();
            inputs.push((PortId::new(index, name), feeds));
        }
        let needed = cone(self.program, tap_roots.iter().copied());
        let steady = sharing && per_sample && self.loads(&needed).all(|slot| self.is_steady(slot.node));
        let taps = (!tap_roots.is_empty()).then(|| {
            self.want_loads(&needed, per_sample, wanted);
            self.compile(&tap_roots, false, self.switches().hoist && per_sample && !steady && !self.is_sparse())
        });
        let variance = if self.switches().hoist {
            (0..own.len()).map(|output| stage.variance(output)).max().unwrap_or(Variance::Pixel)
        } else {
            Variance::Pixel
        };
        Fill { node: id, wanted: own, variance, inputs, taps, steady, read: false, shared, gates: None }
    }

    #[expect(clippy::too_many_arguments, reason = "what is asked of a source")]
    fn feed(
        &self,
        id: NodeId,
        source: &Source<Vec<f64>>,
        asks: ChannelSet,
        prefers: ChannelSet,
        per_sample: bool,
        tap_roots: &mut Vec<u32>,
        wanted: &mut Demand,
    ) -> Vec<Feed> {
        match self.handed_on(source) {
            Source::Number(values) | Source::Color(values) => {
                values.iter().map(|v| Feed::Constant(literal(*v))).collect()
            }
            Source::Numbers(numbers) => numbers.iter().map(|v| Feed::Constant(literal(*v))).collect(),
            Source::Output { node, output } => {
                let kind = self.planner.graph.node(*node).kinds[*output];
                if let Some(positions) = self.taps.get(&(*node, *output)) {
                    let mut feeds = Vec::new();
                    for (index, &position) in positions.iter().enumerate() {
                        let channels = if matches!(kind, Kind::Color | Kind::Layers(_)) { 3 } else { 1 };
                        if !self.takes(id, kind, channels * index) {
                            feeds.extend([Feed::Nothing; 3]);
                            continue;
                        }
                        tap_roots.push(position);
                        feeds.extend((0..channels).map(|channel| Feed::Tap(tap_roots.len() - 1, channel)));
                    }
                    return feeds;
                }
                // A camera, light or surface still has to be prepared.
                wanted.channels.entry(*node).or_insert_with(|| self.channels(*node, false));
                let asks = asks.union(prefers.intersect(self.supplies(*node)));
                (0..kind.channels())
                    .map(|channel| {
                        let is_unasked = kind == Kind::View && !asks.contains(Channel::ALL[channel]);
                        if is_unasked || !self.takes(id, kind, channel) {
                            return Feed::Nothing;
                        }
                        let slot = Slot { node: *node, output: *output, channel };
                        self.want(wanted, slot, per_sample);
                        Feed::Slot(slot)
                    })
                    .collect()
            }
        }
    }

    /// Gives the layers of an image, whose own channels are `feeds`, to a stage that takes colors with layers.
    fn with_layers(&self, id: NodeId, source: &Source<Vec<f64>>, feeds: Vec<Feed>) -> Vec<Feed> {
        let graph = self.planner.graph;
        let is_color = match source {
            Source::Color(_) => true,
            Source::Output { node, output } => {
                matches!(graph.node(*node).kinds[*output], Kind::Color | Kind::Layers(_))
            }
            _ => false,
        };
        match (graph.recipes(), &graph.node(id).kinds[..], &feeds[..]) {
            (Some(recipes), [Kind::Layers(layers)], &[r, g, b]) if is_color => {
                let constant = |color: [f64; 3]| color.map(|channel| Feed::Constant(literal(channel)));
                (0..*layers).flat_map(|layer| recipes.layer_of_image(layer).map_or([r, g, b], constant)).collect()
            }
            _ => feeds,
        }
    }

    /// Whether a stage takes a channel of a source: not those of layers that no control reaches.
    fn takes(&self, id: NodeId, kind: Kind, channel: usize) -> bool {
        let recipes = self.planner.graph.recipes().filter(|_| matches!(kind, Kind::Layers(_)));
        recipes.is_none_or(|recipes| recipes.is_reached(id, channel / 3))
    }

    /// Follows a source through nodes that only hand it on to the stage behind them, so that a file read through a
    /// Switch keeps its overscan. Returns the source itself if a node in between computes something.
    fn handed_on<'a>(&'a self, source: &'a Source<Vec<f64>>) -> &'a Source<Vec<f64>> {
        let mut at = source;
        while let Source::Output { node, .. } = at {
            if self.planner.bound[node.0] || self.stage(*node).is_some() {
                return at;
            }
            let settled = self.lowered.settled[node.0].as_ref();
            match settled.and_then(|settled| settled.node().identity()) {
                Some(chosen) => at = chosen,
                None => return source,
            }
        }
        source
    }

    /// Returns how far the stages of a pass reach beyond what is requested of the pass, horizontally and vertically.
    fn halo(&self, fills: &[Fill]) -> Reach {
        let format = self.planner.graph.format();
        let mut largest = (0, 0);
        let mut beyond: HashMap<NodeId, Reach> = HashMap::new();
        for fill in fills.iter().rev() {
            let own = beyond.get(&fill.node).copied().unwrap_or_default();
            let reads = Reads::of(fill, self.stage(fill.node), format, own);
            let before = read_before(fill).map(|slot| (slot, reads.taps));
            for (slot, reach) in reads.planes.iter().copied().chain(before) {
                let known = beyond.entry(slot.node).or_default();
                *known = larger(*known, reach);
                largest = larger(largest, reach);
            }
        }
        largest
    }

    /// Compiles what `roots` need, or everything. A program that runs before a stage must not be compiled with
    /// everything, since that would read the stage itself. Without `hoist`, the program may run over single pixels
    /// instead of rows.
    fn compile(&self, roots: &[u32], everything: bool, hoist: bool) -> CompiledProgram {
        self.compile_of(self.program, roots, everything, hoist)
    }

    /// Does the same with another program.
    pub(super) fn compile_of(&self, source: &Program, roots: &[u32], everything: bool, hoist: bool) -> CompiledProgram {
        let mut kept = cone(source, roots.iter().copied());
        if everything {
            kept.fill(true);
        }
        let (program, map) = extract(source, &kept);
        let roots: Vec<u32> = roots.iter().map(|root| map[*root as usize]).collect();
        let switches = self.switches();
        let format = self.planner.graph.format();
        let samples = format.window().area().saturating_mul(format.samples() as usize);
        let rule = |slot: &Slot| {
            let kind = self.planner.graph.node(slot.node).kinds[slot.output];
            self.planner.bound[slot.node.0].then_some(match kind {
                Kind::Color => ValueRule::Color,
                Kind::Weights(_) => ValueRule::Mask,
                _ => ValueRule::Field,
            })
        };
        let options = Options {
            hoist,
            fuse: switches.fuse,
            everything: !switches.demand,
            audits: self.planner.settings.audits,
            instructions: self.planner.settings.instructions,
            native: switches.compile && samples >= self.planner.settings.compile_from,
            variance: &|slot| self.planner.variance(self.lowered, slot),
            rule: &rule,
        };
        let mut compiled = compile(&program, &roots, &options);
        if self.planner.settings.bounds() {
            compiled.origin = Origin { program, roots };
        }
        compiled
    }

    /// Lists every stage that some pass fills, or whose handle another stage takes, inputs first.
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
                    && self.stage(*node).is_some()
                {
                    wanted.entry(*node).or_insert_with(|| self.channels(*node, false));
                }
            }
        }
        graph.order().iter().filter_map(|id| Some((*id, wanted.remove(id)?))).collect()
    }
}

/// Keeps in `view` the channels that every sample needs, and returns a fill of the others, which samples that see the
/// same surface share.
fn split(view: &mut Fill, per_sample: &HashSet<Slot>) -> Option<Fill> {
    let mut rest = view.clone();
    let sharing_slots = SHARING_CHANNELS.map(|channel| sharing_slot(view.node, channel));
    for (output, channels) in view.wanted.iter_mut().enumerate() {
        for (channel, wanted) in channels.iter_mut().enumerate() {
            let slot = Slot { node: view.node, output, channel };
            let is_rest = *wanted && !per_sample.contains(&slot) && !sharing_slots.contains(&slot);
            rest.wanted[output][channel] = is_rest;
            *wanted &= !is_rest;
        }
    }
    if !rest.wanted.iter().flatten().any(|wanted| *wanted) {
        return None;
    }
    // Whether samples share is decided by channels that every sample has.
    sharing_slots.iter().for_each(|slot| view.wanted[slot.output][slot.channel] = true);
    rest.shared = Some(vec![view.node]);
    Some(rest)
}

/// How far something reaches beyond a tile, horizontally and vertically, in pixels.
pub(crate) type Reach = (usize, usize);

/// Returns the larger reach along each axis.
pub(crate) fn larger(a: Reach, b: Reach) -> Reach {
    (a.0.max(b.0), a.1.max(b.1))
}

/// What a fill reads, and how far beyond a tile.
pub(crate) struct Reads {
    /// Planes of other fills.
    pub(crate) planes: Vec<(Slot, Reach)>,
    /// How far beyond the tile the program before the fill runs, whose results it reads.
    pub(crate) taps: Reach,
}

impl Reads {
    /// Lists what a fill reads that itself reaches `own` beyond a tile.
    pub(crate) fn of(fill: &Fill, stage: Option<&dyn Stage>, format: Format, own: Reach) -> Self {
        let asked = |stage: &dyn Stage, port, window| stage.regions_of_interest(port, window, format);
        Self::by(fill, stage, format, own, &asked)
    }

    /// Lists what a fill reads at samples after the first one, if what it found then is known.
    pub(crate) fn after_find(fill: &Fill, stage: Option<&dyn Stage>, format: Format, own: Reach) -> Self {
        let asked = |stage: &dyn Stage, port, window| stage.regions_after_find(port, window, format);
        Self::by(fill, stage, format, own, &asked)
    }

    fn by(
        fill: &Fill,
        stage: Option<&dyn Stage>,
        format: Format,
        own: Reach,
        region: &dyn Fn(&dyn Stage, PortId, Window) -> Window,
    ) -> Self {
        let picture = format.window();
        let grown = |before: i64, after: i64, most: usize| before.max(after).clamp(0, most as i64) as usize;
        let (mut planes, mut taps) = (Vec::new(), own);
        for (port, connections) in &fill.inputs {
            let asked = stage.map_or(picture, |stage| region(stage, *port, picture));
            let reach = (
                own.0 + grown(picture.x0 - asked.x0, asked.x1 - picture.x1, picture.width()),
                own.1 + grown(picture.y0 - asked.y0, asked.y1 - picture.y1, picture.height()),
            );
            for feed in connections.iter().flatten() {
                match feed {
                    Feed::Slot(slot) => planes.push((*slot, reach)),
                    Feed::Tap(..) => taps = larger(taps, reach),
                    Feed::Nothing | Feed::Constant(_) => {}
                }
            }
        }
        let views = fill.shared.iter().flatten();
        planes.extend(views.flat_map(|view| SHARING_CHANNELS.map(|channel| (sharing_slot(*view, channel), own))));
        Self { planes, taps }
    }
}

/// Lists the planes that a program before a fill reads.
pub(crate) fn read_before(fill: &Fill) -> impl Iterator<Item = Slot> {
    fill.taps.iter().flat_map(|taps| &taps.planes).copied()
}
