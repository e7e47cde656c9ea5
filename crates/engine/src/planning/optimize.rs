//! Rewrites a program into a shorter one with the same bits.

use crate::Switches;
use crate::rules::interval::{Bounds, Interval, interval};
use std::collections::HashMap;
use trochoid_graph::{Color, NodeId, Op, Partition, Program, Scalar, Slot};
use trochoid_weights::arithmetic as a;

/// A rewritten program.
#[derive(Debug, Default)]
pub(crate) struct OptimizedProgram {
    pub(crate) program: Program,
    /// New position of each operation of the original program.
    pub(crate) map: Vec<u32>,
    /// Certain bounds of each operation of the rewritten program.
    pub(crate) bounds: Vec<Bounds>,
    /// Branches that were cut.
    pub(crate) cuts: Vec<Cut>,
}

/// An operand that does not affect the result of its operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cut {
    /// Position of the operation in the original program.
    pub(crate) op: u32,
    /// Position of the operand in the original program.
    pub(crate) operand: u32,
    /// Node to which the operation belongs.
    pub(crate) at: NodeId,
    /// Value that proves it: a position in the original program, and a row there.
    pub(crate) proof: (u32, usize),
    /// Whether the operand's weight is 0; otherwise the result is the same for every value of the operand.
    pub(crate) by_weight: bool,
}

/// Folds constants, cuts branches of constant weight, and merges equal operations, in one walk.
///
/// Every rewrite keeps the bits: folding calls the functions that kernels inline; Mix is exact at t = 0, at t = 1 and
/// for equal operands; a zero weight adds nothing to a Blend; products with 0 and 1 are exact.
pub(crate) fn optimize(
    source: &Program,
    switches: Switches,
    slot: &dyn Fn(&Slot, usize) -> Interval,
) -> OptimizedProgram {
    let mut walk = Optimizer { out: OptimizedProgram::default(), seen: HashMap::default(), switches, slot };
    for (op, origin) in source.ops() {
        let renumbered = op.renumbered(|operand| walk.out.map[operand as usize]);
        let position = walk.rewrite(renumbered, op, *origin);
        walk.out.map.push(position);
    }
    walk.out
}

struct Optimizer<'a> {
    out: OptimizedProgram,
    seen: HashMap<Vec<u32>, u32>,
    switches: Switches,
    slot: &'a dyn Fn(&Slot, usize) -> Interval,
}

impl Optimizer<'_> {
    fn op(&self, position: u32) -> &Op {
        &self.out.program.ops()[position as usize].0
    }

    /// Appends an operation, or returns the position of one that replaces it. `original` is the same operation with
    /// the operands of the original program.
    fn rewrite(&mut self, op: Op, original: &Op, origin: NodeId) -> u32 {
        let op = match self.shorter(&op, original, origin) {
            Some(Rewrite::Existing(position)) => return position,
            Some(Rewrite::New(op)) => op,
            None => op,
        };
        if self.switches.merge {
            let key = key(&op);
            if let Some(&position) = self.seen.get(&key) {
                return position;
            }
            let position = self.push(op, origin);
            self.seen.insert(key, position);
            return position;
        }
        self.push(op, origin)
    }

    fn push(&mut self, op: Op, origin: NodeId) -> u32 {
        let bounds = interval(&op, &|position| self.out.bounds[position as usize].clone(), self.slot);
        self.out.bounds.push(bounds);
        self.out.program.push(op, origin)
    }

    fn shorter(&mut self, op: &Op, original: &Op, origin: NodeId) -> Option<Rewrite> {
        if self.switches.fold
            && let Some(folded) = self.folded(op)
        {
            return Some(Rewrite::New(folded));
        }
        if !self.switches.prune {
            return None;
        }
        let constant = |s: Scalar| self.out.bounds[s.0 as usize][0].constant();
        let here = self.out.map.len() as u32;
        match (op, original) {
            (Op::Mix { a, b, .. }, _) if a == b => Some(Rewrite::Existing(a.0)),
            (Op::Mix { a, b, t }, Op::Mix { a: from, b: to, t: by }) => {
                let weight = constant(*t)?;
                let (kept, lost) = if weight == 0.0 {
                    (*a, *to)
                } else if weight == 1.0 {
                    (*b, *from)
                } else {
                    return None;
                };
                self.out.cuts.push(Cut { op: here, operand: lost.0, at: origin, proof: (by.0, 0), by_weight: true });
                Some(Rewrite::Existing(kept.0))
            }
            (Op::Product(t, u), Op::Product(first, second)) => {
                let mut zero = |kept: &Scalar, proof: &Scalar, lost: &Scalar| {
                    self.out.cuts.push(Cut {
                        op: here,
                        operand: lost.0,
                        at: origin,
                        proof: (proof.0, 0),
                        by_weight: false,
                    });
                    Some(Rewrite::Existing(kept.0))
                };
                match (constant(*t), constant(*u)) {
                    (Some(0.0), _) => zero(t, first, second),
                    (_, Some(0.0)) => zero(u, second, first),
                    (_, Some(1.0)) => Some(Rewrite::Existing(t.0)),
                    (Some(1.0), _) => Some(Rewrite::Existing(u.0)),
                    _ => None,
                }
            }
            (Op::Blend { colors, weights }, Op::Blend { colors: originals, weights: by }) => {
                let bounds = &self.out.bounds[weights.0 as usize];
                let used: Vec<bool> = bounds.iter().map(|w| w.high > 0.0).collect();
                if used.iter().all(|&used| used) {
                    return None;
                }
                // Positions of the weights stay; a color of weight 0 is replaced by one that is used anyway.
                let kept = colors.iter().zip(&used).find(|(_, used)| **used).map(|(color, _)| *color)?;
                for (way, operand) in originals.iter().enumerate() {
                    let elsewhere = colors.iter().zip(&used).any(|(color, used)| *used && *color == colors[way]);
                    if !used[way] && !elsewhere {
                        let proof = (by.0, way);
                        self.out.cuts.push(Cut { op: here, operand: operand.0, at: origin, proof, by_weight: true });
                    }
                }
                let replaced: Vec<Color> =
                    colors.iter().zip(&used).map(|(color, used)| if *used { *color } else { kept }).collect();
                if replaced == *colors {
                    return None;
                }
                Some(Rewrite::New(Op::Blend { colors: replaced, weights: *weights }))
            }
            // Operations that are proved constant by interval although they are computed from fields.
            (Op::Clamp { .. } | Op::Step { .. } | Op::Weight(..), _) => {
                let bounds = interval(op, &|position| self.out.bounds[position as usize].clone(), self.slot);
                let value = bounds[0].constant()?;
                if let Op::Clamp { x, .. } | Op::Step { x, .. } = original {
                    self.out.cuts.push(Cut { op: here, operand: x.0, at: origin, proof: (x.0, 0), by_weight: false });
                }
                Some(Rewrite::New(Op::Constant(value as f32)))
            }
            _ => None,
        }
    }

    /// Returns the operation's value if every operand is a constant.
    fn folded(&self, op: &Op) -> Option<Op> {
        let scalar = |s: &Scalar| if let Op::Constant(value) = self.op(s.0) { Some(*value) } else { None };
        let color = |c: &Color| if let Op::ConstantColor(value) = self.op(c.0) { Some(*value) } else { None };
        let partition = |p: &Partition| -> Option<Vec<f32>> {
            match self.op(p.0) {
                Op::Partition(weights) => {
                    let mut values = weights.iter().map(scalar).collect::<Option<Vec<_>>>()?;
                    a::round_partition(&mut values);
                    Some(values)
                }
                Op::Normalize { values, floor } => {
                    let values = values.iter().map(scalar).collect::<Option<Vec<_>>>()?;
                    let mut out = vec![0.0; values.len() + 1];
                    a::normalize(&values, *floor, &mut out);
                    Some(out)
                }
                _ => None,
            }
        };
        match op {
            Op::Clamp { x, min, max } => Some(Op::Constant(a::clamp(scalar(x)?, *min, *max))),
            Op::Smooth(t) => Some(Op::Constant(a::smooth(scalar(t)?))),
            Op::Power { t, p } => Some(Op::Constant(a::power(scalar(t)?, *p))),
            Op::Step { x, threshold } => Some(Op::Constant(a::step(scalar(x)?, *threshold))),
            Op::Complement(t) => Some(Op::Constant(a::complement(scalar(t)?))),
            Op::Product(t, u) => Some(Op::Constant(a::product(scalar(t)?, scalar(u)?))),
            Op::Weight(p, i) => Some(Op::Constant(partition(p)?[*i])),
            Op::Mix { a: from, b: to, t } => {
                let (from, to, t) = (color(from)?, color(to)?, scalar(t)?);
                Some(Op::ConstantColor([0, 1, 2].map(|c| a::mix(from[c], to[c], t))))
            }
            Op::Blend { colors, weights } => {
                let weights = partition(weights)?;
                let colors = colors.iter().map(color).collect::<Option<Vec<_>>>()?;
                Some(Op::ConstantColor([0, 1, 2].map(|c| {
                    let channel: Vec<f32> = colors.iter().map(|color| color[c]).collect();
                    a::blend(&channel, &weights)
                })))
            }
            Op::Load(_)
            | Op::Constant(_)
            | Op::Partition(_)
            | Op::Normalize { .. }
            | Op::LoadColor(_)
            | Op::ConstantColor(_) => None,
        }
    }
}

enum Rewrite {
    Existing(u32),
    New(Op),
}

/// Returns numbers that two operations share exactly if they compute the same value.
fn key(op: &Op) -> Vec<u32> {
    let slot = |tag: u32, s: &Slot| vec![tag, s.node.0 as u32, s.output as u32, s.channel as u32];
    match op {
        Op::Load(s) => slot(0, s),
        Op::Constant(value) => vec![1, value.to_bits()],
        Op::Clamp { x, min, max } => vec![2, x.0, min.to_bits(), max.to_bits()],
        Op::Smooth(t) => vec![3, t.0],
        Op::Power { t, p } => vec![4, t.0, p.to_bits()],
        Op::Step { x, threshold } => vec![5, x.0, threshold.to_bits()],
        Op::Complement(t) => vec![6, t.0],
        // Products commute to the bit.
        Op::Product(t, u) => vec![7, t.0.min(u.0), t.0.max(u.0)],
        Op::Partition(weights) => std::iter::once(8).chain(weights.iter().map(|w| w.0)).collect(),
        Op::Normalize { values, floor } => [9, floor.to_bits()].into_iter().chain(values.iter().map(|v| v.0)).collect(),
        Op::Weight(p, i) => vec![10, p.0, *i as u32],
        Op::LoadColor(s) => slot(11, s),
        Op::ConstantColor(color) => std::iter::once(12).chain(color.iter().map(|c| c.to_bits())).collect(),
        Op::Mix { a, b, t } => vec![13, a.0, b.0, t.0],
        Op::Blend { colors, weights } => [14, weights.0].into_iter().chain(colors.iter().map(|c| c.0)).collect(),
    }
}

/// Returns the positions that `roots` depend on, including the roots.
pub(crate) fn cone(program: &Program, roots: impl IntoIterator<Item = u32>) -> Vec<bool> {
    let mut needed = vec![false; program.ops().len()];
    for root in roots {
        needed[root as usize] = true;
    }
    for position in (0..needed.len()).rev() {
        if needed[position] {
            program.ops()[position].0.operands(|operand| needed[operand as usize] = true);
        }
    }
    needed
}

/// Returns the program of exactly the `kept` positions, and the new position of each.
pub(crate) fn extract(program: &Program, kept: &[bool]) -> (Program, Vec<u32>) {
    let mut out = Program::default();
    let mut map = vec![u32::MAX; kept.len()];
    for (position, (op, origin)) in program.ops().iter().enumerate().filter(|(position, _)| kept[*position]) {
        let op = op.renumbered(|operand| map[operand as usize]);
        map[position] = out.push(op, *origin);
    }
    (out, map)
}
