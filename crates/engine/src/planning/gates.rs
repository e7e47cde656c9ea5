//! Finds where a stage shows: weights of the program, without which nothing of the stage reaches an output.

use super::optimize::cone;
use super::plan::Fill;
use super::schedule::Scheduler;
use std::collections::BTreeSet;
use trochoid_graph::{Kind, NodeId, Op, Program, Slot, Variance};
use trochoid_image::Window;
use trochoid_kernel::CompiledProgram;

/// A value of the program, and what it is where something shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Gate {
    /// A scalar that is not 0.
    NotZero(u32),
    /// A scalar that is not 1.
    NotOne(u32),
    /// A weight of a partition that is not 0.
    Weight(u32, usize),
}

impl Gate {
    /// Returns the position of the value.
    fn position(self) -> u32 {
        match self {
            Self::NotZero(position) | Self::NotOne(position) | Self::Weight(position, _) => position,
        }
    }
}

/// Gates that are all open where something shows.
type Closed = BTreeSet<Gate>;

/// Where some stages of a pass show.
#[derive(Clone, Debug)]
pub(crate) struct Gates {
    /// Computes the values on which it depends.
    pub(crate) program: CompiledProgram,
    /// Sets of conditions. Stages refer to them by index.
    pub(crate) sets: Vec<Vec<Condition>>,
}

/// A condition on a root of the program: what it must not be for something to show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Condition {
    pub(crate) root: usize,
    pub(crate) hides: f32,
}

impl Scheduler<'_, '_, '_> {
    /// Finds the stages of a pass that show only in places, says so in them, and moves them behind the others, of which
    /// the values depend that tell the places.
    pub(crate) fn gates(&self, roots: &[u32], fills: &mut [Fill]) -> Option<Gates> {
        let read = self.read_where(roots);
        let all = self.shown_where(fills, &read, &|_| true);
        // A gate must not depend on a stage that is itself filled in places only.
        let hidden = |gate: &Gate| {
            let needed = cone(self.program, [gate.position()]);
            let mut loads = self.loads(&needed);
            loads.any(|slot| fills.iter().zip(&all).any(|(fill, gates)| !gates.is_empty() && fill.fills(&slot)))
        };
        let mut gates: Vec<Gate> = all.iter().flatten().copied().collect();
        gates.sort_unstable();
        gates.dedup();
        gates.retain(|gate| !hidden(gate));
        let shown = self.shown_where(fills, &read, &|gate| gates.contains(gate));
        gates.retain(|gate| shown.iter().any(|shown| shown.contains(gate)));
        if gates.is_empty() {
            return None;
        }
        let mut source = self.program.clone();
        let positions: Vec<u32> = gates.iter().map(|gate| scalar(&mut source, *gate)).collect();
        let program = self.compile_of(&source, &positions, false, false);
        let mut sets: Vec<Vec<Condition>> = Vec::new();
        for (fill, shown) in fills.iter_mut().zip(&shown).filter(|(_, shown)| !shown.is_empty()) {
            let condition = |gate: &Gate| Condition {
                root: gates.iter().position(|known| known == gate).unwrap_or_default(),
                hides: if matches!(gate, Gate::NotOne(_)) { 1.0 } else { 0.0 },
            };
            let set: Vec<Condition> = shown.iter().map(condition).collect();
            let known = sets.iter().position(|known| *known == set);
            fill.gates = Some(known.unwrap_or_else(|| {
                sets.push(set);
                sets.len() - 1
            }));
        }
        fills.sort_by_key(|fill| fill.gates.is_some());
        Some(Gates { program, sets })
    }

    /// Returns the gates through which each slot is read that the program loads.
    fn read_where(&self, roots: &[u32]) -> Vec<(Slot, Closed)> {
        let program = self.program;
        let mut through: Vec<Option<Closed>> = vec![None; program.ops().len()];
        for root in roots {
            through[*root as usize] = Some(Closed::new());
        }
        let mut read: Vec<(Slot, Closed)> = Vec::new();
        for position in (0..program.ops().len()).rev() {
            let Some(own) = through[position].clone() else { continue };
            let mut reach = |operand: u32, gate: Option<Gate>| {
                let mut gates = own.clone();
                gates.extend(gate);
                let known = &mut through[operand as usize];
                *known = Some(match known.take() {
                    Some(known) => known.intersection(&gates).copied().collect(),
                    None => gates,
                });
            };
            match &program.ops()[position].0 {
                Op::Mix { a, b, t } => {
                    reach(a.0, Some(Gate::NotOne(t.0)));
                    reach(b.0, Some(Gate::NotZero(t.0)));
                    reach(t.0, None);
                }
                Op::Blend { colors, weights } => {
                    colors
                        .iter()
                        .enumerate()
                        .for_each(|(way, color)| reach(color.0, Some(Gate::Weight(weights.0, way))));
                    reach(weights.0, None);
                }
                // What costs less tells where the other one shows.
                Op::Product(t, u) => {
                    let (cheap, dear) = if self.cost(t.0) <= self.cost(u.0) { (t, u) } else { (u, t) };
                    reach(cheap.0, None);
                    reach(dear.0, Some(Gate::NotZero(cheap.0)));
                }
                Op::Load(slot) => read.push((*slot, own)),
                Op::LoadColor(slot) => {
                    read.extend(
                        (slot.channel..slot.channel + 3).map(|channel| (Slot { channel, ..*slot }, own.clone())),
                    );
                }
                op => op.operands(|operand| reach(operand, None)),
            }
        }
        read
    }

    /// Returns the number of stages on which a value depends directly.
    fn cost(&self, position: u32) -> usize {
        let nodes: BTreeSet<NodeId> = self.loads(&cone(self.program, [position])).map(|slot| slot.node).collect();
        nodes.len()
    }

    /// Returns the gates through which each fill shows, of those that count. What shows everywhere has none.
    fn shown_where(&self, fills: &[Fill], read: &[(Slot, Closed)], counts: &dyn Fn(&Gate) -> bool) -> Vec<Closed> {
        let mut shown: Vec<Option<Closed>> = vec![None; fills.len()];
        let narrow = |known: &mut Option<Closed>, gates: &Closed| {
            *known = Some(match known.take() {
                Some(known) => known.intersection(gates).copied().collect(),
                None => gates.iter().filter(|gate| counts(gate)).copied().collect(),
            });
        };
        for index in (0..fills.len()).rev() {
            let fill = &fills[index];
            for (_, gates) in read.iter().filter(|(slot, _)| fill.fills(slot)) {
                narrow(&mut shown[index], gates);
            }
            if !self.can_be_gated(fill) {
                shown[index] = Some(Closed::new());
            }
            // What it reads shows where it does itself, if it reads nothing beside its own place.
            let own = shown[index].clone().unwrap_or_default();
            let own = if self.is_pixelwise(fill) { own } else { Closed::new() };
            for slot in fill.slots() {
                for (before, shown) in fills[..index].iter().zip(&mut shown) {
                    if before.fills(slot) {
                        narrow(shown, &own);
                    }
                }
            }
        }
        shown.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// Returns whether a fill may be left out where it does not show, and 0 stand for it.
    fn can_be_gated(&self, fill: &Fill) -> bool {
        let kinds = &self.planner.graph.node(fill.node).kinds;
        let is_legal = |kind: &Kind| match kind {
            Kind::Color | Kind::Field(_) => true,
            Kind::Weights(ways) => *ways == 2,
            _ => false,
        };
        fill.variance == Variance::Pixel
            && fill.shared.is_none()
            && !self.planner.bound[fill.node.0]
            && kinds.iter().all(is_legal)
    }

    fn is_pixelwise(&self, fill: &Fill) -> bool {
        let format = self.planner.graph.format();
        let window = Window::new(1, 1, 2, 2);
        self.stage(fill.node).is_some_and(|stage| {
            fill.inputs.iter().all(|(port, _)| stage.regions_of_interest(*port, window, format) == window)
        })
    }
}

/// Returns the position of a gate's value as a scalar, which may have to be appended.
fn scalar(program: &mut Program, gate: Gate) -> u32 {
    match gate {
        Gate::NotZero(position) | Gate::NotOne(position) => position,
        Gate::Weight(position, way) => {
            let origin = program.ops()[position as usize].1;
            program.push(Op::Weight(trochoid_graph::Partition(position), way), origin)
        }
    }
}
