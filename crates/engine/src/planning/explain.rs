//! What becomes of each node in a plan, with the proof of what is left out.

use super::left_out::Reasons;
use super::optimize::Cut;
use crate::LeftOut;
use crate::rules::interval::Interval;
use trochoid_graph::{Channel, ChannelSet, Kind, NodeId, Op, Slot, Source};

/// What becomes of a node in a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Account {
    /// The node.
    pub node: NodeId,
    /// What becomes of it.
    pub fate: Fate,
    /// Why a weight or a value is certain, if that is why the node is left out: from there back to what is known.
    pub proof: Vec<Proved>,
    /// Of a stage that is prepared: what it is asked for, output by output.
    pub channels: Vec<Channels>,
}

/// What becomes of a node in a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It is evaluated.
    Evaluated,
    /// Its result is a constant, worked out while planning.
    Folded,
    /// It gives what the node of this name gives, unchanged; of a literal, what is written at itself.
    HandsOn(String),
    /// The operations of the node of this name are the same, and compute its result too.
    Merged(String),
    /// It is left out.
    LeftOut(LeftOut),
}

/// A node's value that is certain to lie in an interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Proved {
    /// The node's name.
    pub node: String,
    /// Its type.
    pub ty: &'static str,
    /// Where its value lies, at every sample of the frame.
    pub interval: Interval,
    /// How that is known.
    pub evidence: Evidence,
}

/// How a [`Proved`] is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// Its numbers stand in the document; keyed ones hold for this frame alone.
    Written {
        /// Whether some are keyed.
        keyed: bool,
    },
    /// The node's type states it of that output before anything is prepared.
    Stated,
    /// Every value of the kind lies there.
    Kind(Kind),
    /// The node's formula, from the bounds of these nodes, which follow.
    Computed(Vec<String>),
}

/// What a stage is asked for of one of its outputs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channels {
    /// The output's name.
    pub output: &'static str,
    /// Channels that are computed.
    pub wanted: Vec<String>,
    /// Channels that could be had, but nobody asks for.
    pub unasked: Vec<String>,
}

/// What explains a plan.
pub(crate) struct Explainer<'e, 'p> {
    pub(crate) reasons: &'e Reasons<'p>,
    pub(crate) left_out: &'e [Option<LeftOut>],
    /// Stages that are prepared, with the channels wanted of each.
    pub(crate) prepares: &'e [(NodeId, Vec<Vec<bool>>)],
    /// What a view can supply.
    pub(crate) supplies: &'e dyn Fn(NodeId) -> ChannelSet,
}

impl Explainer<'_, '_> {
    /// One account a node, in the graph's order.
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

    /// What becomes of a node that is not left out.
    fn fate(&self, id: NodeId) -> Fate {
        let lowered = self.reasons.lowered;
        let handed_on = lowered.settled[id.0].as_ref().and_then(|settled| settled.node().identity());
        if let Some(source) = handed_on.filter(|_| !self.reasons.planner.bound[id.0]) {
            let Source::Output { node, .. } = source else { return Fate::HandsOn(self.name(id)) };
            return Fate::HandsOn(self.name(*node));
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
            (_, Some(from)) if from != id => Fate::HandsOn(self.name(from)),
            ((_, origin), _) if *origin != id => Fate::Merged(self.name(*origin)),
            _ => Fate::Evaluated,
        }
    }

    /// What a prepared stage is asked for.
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

    /// From what decides a cut back to what is known.
    fn proof(&self, cut: &Cut) -> Vec<Proved> {
        let mut bounds = Vec::new();
        self.prove(cut.proof.0, cut.proof.1, &mut bounds);
        bounds
    }

    /// Where an operation of the original program lies.
    fn interval(&self, position: u32, row: usize) -> Interval {
        let optimized = self.reasons.optimized;
        optimized.bounds[optimized.map[position as usize] as usize][row]
    }

    /// Adds the bound of the node at a position, and of what it is computed from.
    fn prove(&self, position: u32, row: usize, bounds: &mut Vec<Proved>) {
        let planner = self.reasons.planner;
        let ops = self.reasons.lowered.program.ops();
        let id = ops[position as usize].1;
        let node = planner.graph.node(id);
        if bounds.iter().any(|bound| bound.node == node.name) {
            return;
        }
        // The node's own operations, up to what comes from others.
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
            // One factor of 0 is enough.
            let is_zero = |operand: &u32| self.interval(*operand, 0).constant() == Some(0.0);
            if let (Op::Product(..), Some(zero)) = (op, operands.iter().copied().find(is_zero)) {
                operands = vec![zero];
            }
            // Of a partition, the weight that is taken.
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
        bounds.push(Proved { node: node.name.clone(), ty, interval: self.interval(position, row), evidence });
        for (input, row) in inputs {
            self.prove(input, row, bounds);
        }
    }

    /// Why a plane that is filled from outside the program lies where it does.
    fn known(&self, slot: &Slot) -> Evidence {
        let planner = self.reasons.planner;
        let stage = planner.stage(self.reasons.lowered, slot.node);
        if stage.and_then(|stage| stage.interval(slot.output, slot.channel)).is_some() {
            return Evidence::Stated;
        }
        Evidence::Kind(planner.graph.node(slot.node).kinds[slot.output])
    }

    /// Whether a number or color that stands at a port of a node is keyed.
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

/// A channel's name within an output.
fn channel_name(kind: Kind, output: &str, channel: usize) -> String {
    match kind {
        Kind::View => format!("{:?}", Channel::ALL[channel]),
        Kind::Color => ["R", "G", "B"][channel].into(),
        Kind::Weights(2) | Kind::Field(1) => output.into(),
        Kind::Field(_) => ["x", "y", "z", "w"][channel.min(3)].into(),
        _ => channel.to_string(),
    }
}
