//! How every operation's result varies over the picture.

use trochoid_graph::{Op, Slot, Variance};

/// Returns how an operation's result varies, from how its operands vary.
pub fn variance(op: &Op, of: &dyn Fn(u32) -> Variance, slot: &dyn Fn(&Slot) -> Variance) -> Variance {
    match op {
        Op::Load(s) | Op::LoadColor(s) => slot(s),
        Op::Constant(_) | Op::ConstantColor(_) => Variance::Constant,
        _ => {
            let mut joined = Variance::Constant;
            op.operands(|operand| joined = joined.join(of(operand)));
            joined
        }
    }
}
