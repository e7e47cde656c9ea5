//! Evaluates every operation by its plain definition in f64 at one sample, against which error and blame are
//! measured.

use trochoid_graph::{Op, Slot};
use trochoid_weights::reference as r;

/// Rows of an operation at one sample: one number for a scalar, three for a color, n for a partition.
pub(crate) type Values = Vec<f64>;

/// Returns the value of an operation from those of its operands.
pub(crate) fn evaluate(op: &Op, of: &dyn Fn(u32) -> Values, slot: &dyn Fn(&Slot, usize) -> f64) -> Values {
    let scalar = |s: trochoid_graph::Scalar| of(s.0)[0];
    match op {
        Op::Load(s) => vec![slot(s, s.channel)],
        Op::Constant(value) => vec![f64::from(*value)],
        Op::Clamp { x, min, max } => vec![r::clamp(scalar(*x), f64::from(*min), f64::from(*max))],
        Op::Smooth(t) => vec![r::smooth(scalar(*t))],
        Op::Power { t, p } => vec![r::power(scalar(*t), f64::from(*p))],
        Op::Step { x, threshold } => vec![r::step(scalar(*x), f64::from(*threshold))],
        Op::Complement(t) => vec![r::complement(scalar(*t))],
        Op::Product(t, u) => vec![r::product(scalar(*t), scalar(*u))],
        Op::Partition(weights) => r::partition(&weights.iter().map(|w| scalar(*w)).collect::<Values>()),
        Op::Normalize { values, floor } => {
            let values: Values = values.iter().map(|v| scalar(*v)).collect();
            r::normalize(&values, f64::from(*floor))
        }
        Op::Weight(partition, i) => vec![of(partition.0)[*i]],
        Op::LoadColor(s) => (s.channel..s.channel + 3).map(|channel| slot(s, channel)).collect(),
        Op::ConstantColor(color) => color.iter().map(|&c| f64::from(c)).collect(),
        Op::Mix { a, b, t } => {
            let t = scalar(*t);
            of(a.0).into_iter().zip(of(b.0)).map(|(a, b)| r::mix(a, b, t)).collect()
        }
        Op::Blend { colors, weights } => {
            let weights = of(weights.0);
            let colors: Vec<Values> = colors.iter().map(|color| of(color.0)).collect();
            (0..3)
                .map(|c| {
                    let channel: Values = colors.iter().map(|color| color[c]).collect();
                    r::blend(&channel, &weights)
                })
                .collect()
        }
    }
}
