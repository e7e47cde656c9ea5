//! Says what happens to each node in a plan, and proves what is left out.

use super::left_out::Reasons;
use super::optimize::Cut;
use crate::LeftOut;
use crate::rules::interval::Interval;
use trochoid_graph::{Channel, ChannelSet, Kind, NodeId, Op, Slot, Source};

/// What happens to a node in a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Account {
    /// The node.
    pub node: NodeId,
    /// What happens to it.
    pub fate: Fate,
    /// Why a weight or a value is certain, if that is why the node is left out: from the deciding value back to known
    /// facts.
    pub proof: Vec<ProofStep>,
    /// Channels requested from the node, by output, if it is a stage that is prepared.
    pub channels: Vec<Channels>,
}

/// What happens to a node in a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fate {
    /// The node is evaluated.
    Evaluated,
    /// Its result is a constant, computed while planning.
    Folded,
    /// It hands on the value of the node of this name unchanged. The name is the node's own if the value is a literal
    /// at one of its ports.
    PassesThrough(String),
    /// The node of this name has the same operations, and computes the result for both.
    Merged(String),
    /// The node is left out.
    LeftOut(LeftOut),
}

/// An interval that certainly contains a node's value.
#[derive(Clone, Debug, PartialEq)]
pub struct ProofStep {
    /// The node's name.
    pub node: String,
    /// The node's type.
    pub ty: &'static str,
    /// Interval that contains its value at every sample of the frame.
    pub interval: Interval,
    /// How the interval is known.
    pub evidence: Evidence,
}

/// How the interval of a [`ProofStep`] is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// Its numbers are in the document; keyframed numbers hold only at this frame.
    Written {
        /// Whether some numbers have keyframes.
        keyed: bool,
    },
    /// The node's type states the interval of that output before anything is prepared.
    Stated,
    /// All values of this kind lie in the interval.
    Kind(Kind),
    /// Computed by the node's formula from the intervals of these nodes, which follow in the proof.
    Computed(Vec<String>),
}

/// Channels of one output that are requested from a stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channels {
    /// The output's name.
    pub output: &'static str,
    /// Channels that are computed.
    pub wanted: Vec<String>,
    /// Channels that the stage could supply but that nothing requests.
    pub unasked: Vec<String>,
}

/// Explains a plan.
pub(crate) struct Explainer<'e, 'p> {
    pub(crate) reasons: &'e Reasons<'p>,
    pub(crate) left_out: &'e [Option<LeftOut>],
    /// Stages that are prepared, with the channels wanted of each.
    pub(crate) prepares: &'e [(NodeId, Vec<Vec<bool>>)],
    /// Returns the channels that a view can supply.
    pub(crate) supplies: &'e dyn Fn(NodeId) -> ChannelSet,
}

impl Explainer<'_, '_> {
    /// Returns one account per node, in the graph's order.
    pub(crate) fn accounts(&self) -> Vec<Account> {
        let cuts = self.reasons.cut_at();
        let mut channels: Vec<Vec<Channels>> = vec![Vec::new(); self.left_out.len()];
        for (id, wanted) in self.prepares {
            channels[id.0] = self.channels(*id, wanted);
        }
        let accounts = self.left_out.iter().zip(channels).zip(cuts).enumerate();
        accounts
            .map(|(index, ((why, channels), cut))| {
                let node = NodeId(index);
                let cut = cut.filter(|_| matches!(why, Some(LeftOut::Weight(_) | LeftOut::Constant(_))));
                let proof = cut.map(|cut| self.proof(&cut)).unwrap_or_default();
                let fate = why.clone().map_or_else(|| self.fate(node), Fate::LeftOut);
                Account { node, fate, proof, channels }
            })
            .collect()
    }

    fn name(&self, id: NodeId) -> String {
        self.reasons.planner.graph.node(id).name.clone()
    }

    /// Returns what happens to a node that is not left out.
    fn fate(&self, id: NodeId) -> Fate {
        let lowered = self.reasons.lowered;
        let handed_on = lowered.settled[id.0].as_ref().and_then(|settled| settled.node().identity());
        if let Some(source) = handed_on.filter(|_| !self.reasons.planner.bound[id.0]) {
            let Source::Output { node, .. } = source else { return Fate::PassesThrough(self.name(id)) };
            return Fate::PassesThrough(self.name(*node));
        }
        let is_constant = |op: &Op| matches!(op, Op::Constant(_) | Op::ConstantColor(_));
        let (ops, optimized) = (lowered.program.ops(), self.reasons.optimized);
        let own = || ops.iter().enumerate().filter(|(_, (op, origin))| *origin == id && !is_constant(op));
        let went = |position: usize| &optimized.program.ops()[optimized.map[position] as usize];
        let runs = own().any(|(at, _)| {
            let (op, origin) = went(at);
            *origin == id && !is_constant(op) && self.reasons.alive[optimized.map[at] as usize]
        });
        let Some((last, (op, _))) = own().next_back().filter(|_| !runs && !self.reasons.planner.bound[id.0]) else {
            return Fate::Evaluated;
        };
        let mut passed = None;
        op.operands(|operand| {
            if optimized.map[operand as usize] == optimized.map[last] {
                passed = Some(ops[operand as usize].1);
            }
        });
        match (went(last), passed) {
            ((op, _), _) if is_constant(op) => Fate::Folded,
            (_, Some(from)) if from != id => Fate::PassesThrough(self.name(from)),
            ((_, origin), _) if *origin != id => Fate::Merged(self.name(*origin)),
            _ => Fate::Evaluated,
        }
    }

    /// Lists the channels that are requested from a prepared stage.
    fn channels(&self, id: NodeId, wanted: &[Vec<bool>]) -> Vec<Channels> {
        let node = self.reasons.planner.graph.node(id);
        let outputs = node.ty.declaration().outputs;
        let supplied = (self.supplies)(id);
        let mut all = Vec::new();
        for (index, (kind, wanted)) in node.kinds.iter().zip(wanted).enumerate() {
            let output = outputs.get(index).map_or("", |output| output.name);
            let (mut own, mut unasked) = (Vec::new(), Vec::new());
            for (channel, is_wanted) in wanted.iter().enumerate() {
                if *is_wanted {
                    own.push(channel_name(*kind, output, channel));
                } else if *kind != Kind::View || supplied.contains(Channel::ALL[channel]) {
                    unasked.push(channel_name(*kind, output, channel));
                }
            }
            if !wanted.is_empty() {
                all.push(Channels { output, wanted: own, unasked });
            }
        }
        all
    }

    /// Proves a cut: from the value that decides it back to known facts.
    fn proof(&self, cut: &Cut) -> Vec<ProofStep> {
        let mut bounds = Vec::new();
        self.prove(cut.proof.0, cut.proof.1, &mut bounds);
        bounds
    }

    /// Returns the interval of an operation of the original program.
    fn interval(&self, position: u32, row: usize) -> Interval {
        let optimized = self.reasons.optimized;
        optimized.bounds[optimized.map[position as usize] as usize][row]
    }

    /// Adds the interval of the node at a position, and those of the nodes from which it is computed.
    fn prove(&self, position: u32, row: usize, bounds: &mut Vec<ProofStep>) {
        let planner = self.reasons.planner;
        let ops = self.reasons.lowered.program.ops();
        let id = ops[position as usize].1;
        let node = planner.graph.node(id);
        if bounds.iter().any(|bound| bound.node == node.name) {
            return;
        }
        // Walk the node's own operations, down to those of other nodes.
        let mut open = vec![position];
        let mut inputs: Vec<(u32, usize)> = Vec::new();
        let mut loaded: Option<Slot> = None;
        while let Some(at) = open.pop() {
            let (op, _) = &ops[at as usize];
            if let Op::Load(slot) | Op::LoadColor(slot) = op {
                loaded = Some(*slot);
            }
            let mut operands = Vec::new();
            op.operands(|operand| operands.push(operand));
            // A product with one factor of 0 needs no other.
            let is_zero = |operand: &u32| self.interval(*operand, 0).constant() == Some(0.0);
            if let (Op::Product(..), Some(zero)) = (op, operands.iter().copied().find(is_zero)) {
                operands = vec![zero];
            }
            // For a partition, only the weight that is used.
            let row = if let Op::Weight(_, way) = op { *way } else { 0 };
            for operand in operands {
                if ops[operand as usize].1 == id { open.push(operand) } else { inputs.push((operand, row)) }
            }
        }
        inputs.sort_unstable();
        inputs.dedup();
        let evidence = match loaded {
            Some(slot) => self.known(&slot),
            None if inputs.is_empty() => Evidence::Written { keyed: self.is_keyed(id) },
            None => {
                let mut names: Vec<String> = inputs.iter().map(|(at, _)| self.name(ops[*at as usize].1)).collect();
                names.dedup();
                Evidence::Computed(names)
            }
        };
        let ty = node.ty.declaration().name;
        bounds.push(ProofStep { node: node.name.clone(), ty, interval: self.interval(position, row), evidence });
        for (input, row) in inputs {
            self.prove(input, row, bounds);
        }
    }

    /// Says how the interval of a plane that is filled from outside the program is known.
    fn known(&self, slot: &Slot) -> Evidence {
        let planner = self.reasons.planner;
        let stage = planner.stage(self.reasons.lowered, slot.node);
        if stage.and_then(|stage| stage.interval(slot.output, slot.channel)).is_some() {
            return Evidence::Stated;
        }
        Evidence::Kind(planner.graph.node(slot.node).kinds[slot.output])
    }

    /// Returns whether a number or color at a port of a node has keyframes.
    fn is_keyed(&self, id: NodeId) -> bool {
        let mut keyed = false;
        self.reasons.planner.graph.node(id).record.each_source(&mut |source| {
            if let Source::Number(numbers) | Source::Color(numbers) = source {
                keyed |= numbers.frames().next().is_some();
            }
        });
        keyed
    }
}

/// Returns a channel's name within an output.
fn channel_name(kind: Kind, output: &str, channel: usize) -> String {
    match kind {
        Kind::View => format!("{:?}", Channel::ALL[channel]),
        Kind::Color => ["R", "G", "B"][channel].into(),
        Kind::Layers(_) => format!("{}{}", ["R", "G", "B"][channel % 3], channel / 3),
        Kind::Weights(2) | Kind::Field(1) => output.into(),
        Kind::Field(_) => ["x", "y", "z", "w"][channel.min(3)].into(),
        _ => channel.to_string(),
    }
}
