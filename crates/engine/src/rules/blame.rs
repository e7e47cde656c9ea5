//! Finds which control colors made a pixel: blame flows from the output to the controls by the weights.

use super::evaluate::Values;
use trochoid_graph::Op;

/// Passes an operation's blame on to its operands; `value` returns computed values, `give` receives shares.
///
/// The shares add up to `share`, so the weights of a pixel's controls sum to 1. Operations that do not make colors
/// take no blame.
pub(crate) fn blame(op: &Op, share: f64, value: &dyn Fn(u32) -> Values, give: &mut dyn FnMut(u32, f64)) {
    match op {
        Op::Mix { a, b, t } => {
            let t = value(t.0)[0];
            give(a.0, (1.0 - t) * share);
            give(b.0, t * share);
        }
        Op::Blend { colors, weights } => {
            for (color, weight) in colors.iter().zip(value(weights.0)) {
                give(color.0, weight * share);
            }
        }
        // Controls keep their blame.
        Op::LoadColor(_) | Op::ConstantColor(_) => {}
        Op::Load(_)
        | Op::Constant(_)
        | Op::Clamp { .. }
        | Op::Smooth(_)
        | Op::Power { .. }
        | Op::Step { .. }
        | Op::Complement(_)
        | Op::Product(..)
        | Op::Partition(_)
        | Op::Normalize { .. }
        | Op::Weight(..) => {}
    }
}
