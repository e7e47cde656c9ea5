//! Finds where a stage shows: weights of the program, without which nothing of the stage reaches an output.

use super::optimize::cone;
use super::plan::Fill;
use super::schedule::Scheduler;
use std::collections::BTreeSet;
use trochoid_graph::{Kind, NodeId, Op, Program, Slot, Stage, Variance};
use trochoid_image::Window;
use trochoid_kernel::CompiledProgram;

/// Most operations of a program whose gates are looked for: sets of gates grow with the depth at which a value is read, and
/// memory with the square of the number of operations.
const MOST: usize = 4096;

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
    /// Programs that compute the values on which it depends. Each reads stages of its own level and of those before it.
    pub(crate) levels: Vec<CompiledProgram>,
    /// Sets of conditions. Stages refer to them by index.
    pub(crate) sets: Vec<GateSet>,
}

/// Conditions that all hold where something shows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GateSet {
    /// Level of the stages that show there: what the levels before it compute decides.
    pub(crate) level: usize,
    pub(crate) conditions: Vec<Condition>,
}

/// A condition on a root of a level's program: what it must not be for something to show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Condition {
    pub(crate) level: usize,
    pub(crate) root: usize,
    pub(crate) hides: f32,
}

impl Scheduler<'_, '_, '_> {
    /// Finds the stages of a pass that show only in places, says so in them, and moves them behind those that decide where.
    ///
    /// *That a stage may be left out where it does not show, although the values that decide this depend on such stages
    /// themselves:* if a value decides, all of its own uses are behind the same gates as the operations at which it decides.
    /// So where a stage before it was left out, either one of these gates is closed, and the stage does not show whatever the
    /// value is; or the value does not depend on what was left out.
    pub(crate) fn gates(&self, roots: &[u32], fills: &mut [Fill]) -> Option<Gates> {
        let is_costly = |fill: &Fill| self.stage(fill.node).is_some_and(Stage::is_costly);
        if self.program.ops().len() > MOST || !fills.iter().any(is_costly) {
            return None;
        }
        let read = self.read_where(roots);
        let mut shown = self.shown_where(fills, &read);
        for (fill, shown) in fills.iter().zip(&mut shown) {
            if !is_costly(fill) {
                shown.clear();
            }
        }
        let mut gates: Vec<Gate> = shown.iter().flatten().copied().collect();
        gates.sort_unstable();
        gates.dedup();
        if gates.is_empty() {
            return None;
        }
        let levels = self.levels(fills, &shown, &gates)?;
        let level_of = |gate: &Gate| levels.gates[gates.binary_search(gate).unwrap_or_default()];
        let mut source = self.program.clone();
        let count = levels.gates.iter().max().map_or(0, |level| level + 1);
        let mut compiled = Vec::new();
        let mut at = vec![(0, 0); gates.len()];
        for level in 0..count {
            let of_level = gates.iter().enumerate().filter(|(index, _)| levels.gates[*index] == level);
            let mut positions = Vec::new();
            for (index, gate) in of_level {
                at[index] = (level, positions.len());
                positions.push(scalar(&mut source, *gate));
            }
            compiled.push(self.compile_of(&source, &positions, false, false));
        }
        let mut sets: Vec<GateSet> = Vec::new();
        for (fill, shown) in fills.iter_mut().zip(&shown).filter(|(_, shown)| !shown.is_empty()) {
            let condition = |gate: &Gate| {
                let (level, root) = at[gates.binary_search(gate).unwrap_or_default()];
                Condition { level, root, hides: if matches!(gate, Gate::NotOne(_)) { 1.0 } else { 0.0 } }
            };
            let level = shown.iter().map(level_of).max().map_or(0, |level| level + 1);
            let set = GateSet { level, conditions: shown.iter().map(condition).collect() };
            let known = sets.iter().position(|known| *known == set);
            fill.gates = Some(known.unwrap_or_else(|| {
                sets.push(set);
                sets.len() - 1
            }));
        }
        let mut order: Vec<usize> = (0..fills.len()).collect();
        order.sort_by_key(|index| levels.fills[*index]);
        let sorted: Vec<Fill> = order.into_iter().map(|index| fills[index].clone()).collect();
        fills.clone_from_slice(&sorted);
        Some(Gates { levels: compiled, sets })
    }

    /// Returns the levels of fills and of gates: a fill is behind its gates and what it reads, a gate at the highest level of
    /// what it depends on. `None` if there is no such order.
    fn levels(&self, fills: &[Fill], shown: &[Closed], gates: &[Gate]) -> Option<Levels> {
        let of_slot = |slot: &Slot| (0..fills.len()).filter(|index| fills[*index].fills(slot)).collect::<Vec<_>>();
        let before: Vec<Vec<usize>> = fills.iter().map(|fill| fill.slots().flat_map(of_slot).collect()).collect();
        let behind: Vec<Vec<usize>> = gates
            .iter()
            .map(|gate| self.loads(&cone(self.program, [gate.position()])).flat_map(|slot| of_slot(&slot)).collect())
            .collect();
        let mut levels = Levels { fills: vec![0; fills.len()], gates: vec![0; gates.len()] };
        // Each round that changes something raises a level, of which there are no more than fills.
        for _ in 0..=fills.len() {
            let old = levels.clone();
            for (gate, behind) in behind.iter().enumerate() {
                levels.gates[gate] = behind.iter().map(|fill| levels.fills[*fill]).max().unwrap_or_default();
            }
            for fill in 0..fills.len() {
                let own =
                    shown[fill].iter().map(|gate| gates.binary_search(gate).map_or(0, |gate| levels.gates[gate] + 1));
                let read = before[fill].iter().map(|fill| levels.fills[*fill]);
                levels.fills[fill] = own.chain(read).max().unwrap_or_default();
            }
            if levels == old {
                return Some(levels);
            }
        }
        None
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

    /// Returns the gates through which each fill shows. What shows everywhere has none.
    fn shown_where(&self, fills: &[Fill], read: &[(Slot, Closed)]) -> Vec<Closed> {
        let mut shown: Vec<Option<Closed>> = vec![None; fills.len()];
        let narrow = |known: &mut Option<Closed>, gates: &Closed| {
            *known = Some(match known.take() {
                Some(known) => known.intersection(gates).copied().collect(),
                None => gates.clone(),
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

    /// Returns whether a fill may be left out where it does not show, and 0 stand for it, or for a view what it has where no
    /// surface is seen.
    fn can_be_gated(&self, fill: &Fill) -> bool {
        let kinds = &self.planner.graph.node(fill.node).kinds;
        let is_legal = |kind: &Kind| match kind {
            Kind::Color | Kind::Field(_) | Kind::View => true,
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

/// Levels by fill and by gate.
#[derive(Clone, PartialEq)]
struct Levels {
    fills: Vec<usize>,
    gates: Vec<usize>,
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
