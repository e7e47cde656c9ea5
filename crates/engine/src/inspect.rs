//! One pixel in detail: which controls made it, and how errors of its passes reach it.

use crate::rules::blame::blame;
use crate::rules::error::{Operands, error};
use crate::rules::evaluate::{Values, evaluate};
use trochoid_graph::{Bound, NodeId, Op, Program, Slot};

/// A control color's share of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blame {
    /// The node that holds the control color.
    pub node: NodeId,
    /// The color.
    pub color: [f64; 3],
    /// Its weight; the weights of a pixel sum to 1.
    pub weight: f64,
}

/// A program evaluated in f64 at one sample, with bounds on errors.
#[derive(Clone, Debug)]
pub struct Inspection {
    program: Program,
    values: Vec<Values>,
    bounds: Vec<Vec<Bound>>,
}

/// Results so far.
struct Known<'a> {
    values: &'a [Values],
    bounds: &'a [Vec<Bound>],
}

impl Operands for Known<'_> {
    fn value(&self, position: u32, row: usize) -> f64 {
        self.values[position as usize][row]
    }

    fn bound(&self, position: u32, row: usize) -> Bound {
        self.bounds[position as usize][row]
    }
}

impl Inspection {
    /// Evaluates a program at a sample; `input` gives the value of each plane loaded, and a bound on its error.
    pub fn new(program: &Program, input: &dyn Fn(&Slot) -> (f64, Bound)) -> Self {
        let mut values: Vec<Values> = Vec::with_capacity(program.ops().len());
        let mut bounds: Vec<Vec<Bound>> = Vec::with_capacity(program.ops().len());
        for (op, _) in program.ops() {
            let channel = |slot: &Slot, channel: usize| input(&Slot { channel, ..*slot });
            let value = evaluate(op, &|id| values[id as usize].clone(), &|slot, c| channel(slot, c).0);
            let mut own = vec![Bound::EXACT; value.len()];
            match op {
                Op::Load(slot) => own[0] = channel(slot, slot.channel).1,
                Op::LoadColor(slot) => own.iter_mut().enumerate().for_each(|(c, own)| *own = channel(slot, c).1),
                _ => error(op, &Known { values: &values, bounds: &bounds }, &value, &mut own),
            }
            values.push(value);
            bounds.push(own);
        }
        Self { program: program.clone(), values, bounds }
    }

    /// The value at a position of the program.
    pub fn value(&self, position: u32) -> &[f64] {
        &self.values[position as usize]
    }

    /// Bounds on its error: of f64 arithmetic.
    pub fn bound(&self, position: u32) -> &[Bound] {
        &self.bounds[position as usize]
    }

    /// The control colors of a color and their weights, which sum to 1; controls of weight 0 are left out.
    pub fn blame(&self, position: u32) -> Vec<Blame> {
        let mut shares = vec![0.0; self.program.ops().len()];
        shares[position as usize] = 1.0;
        let mut found = Vec::new();
        for at in (0..=position as usize).rev() {
            let share = shares[at];
            if share == 0.0 {
                continue;
            }
            let (op, origin) = &self.program.ops()[at];
            blame(op, share, &|id| self.values[id as usize].clone(), &mut |operand, part| {
                shares[operand as usize] += part;
            });
            if let (Op::ConstantColor(_) | Op::LoadColor(_), [r, g, b]) = (op, self.values[at].as_slice()) {
                found.push(Blame { node: *origin, color: [*r, *g, *b], weight: share });
            }
        }
        found
    }
}
