//! How errors pass through every operation: the bounds of non-expansion.

use super::evaluate::Values;
use trochoid_graph::Op;

/// A bound on the error of an operation's rows at one sample, from values and bounds of its operands.
///
/// `value` gives the computed values, `error` the bounds on their errors, both in rows as in
/// [`evaluate`](super::evaluate::evaluate). Rounding of the operation itself is not included. Infinity where
/// the side of a threshold is not certain.
pub(crate) fn error(
    op: &Op,
    value: &dyn Fn(u32) -> Values,
    error: &dyn Fn(u32) -> Values,
    slot: &dyn Fn(&trochoid_graph::Slot, usize) -> f64,
) -> Values {
    let v = |s: trochoid_graph::Scalar| value(s.0)[0];
    let e = |s: trochoid_graph::Scalar| error(s.0)[0];
    match op {
        Op::Load(s) => vec![slot(s, s.channel)],
        Op::LoadColor(s) => (0..3).map(|channel| slot(s, channel)).collect(),
        Op::Constant(_) => vec![0.0],
        Op::ConstantColor(_) => vec![0.0; 3],
        Op::Clamp { x, min, max } => {
            let (x, dx, min, max) = (v(*x), e(*x), f64::from(*min), f64::from(*max));
            // Saturated for every value within the error: no error passes. (∞ ± ∞ is no certainty.)
            if dx == 0.0 || x - dx >= max || x + dx < min {
                vec![0.0]
            } else if max == min {
                vec![f64::INFINITY]
            } else {
                vec![(dx / (max - min)).min(1.0)]
            }
        }
        Op::Step { x, threshold } => {
            let (x, dx, at) = (v(*x), e(*x), f64::from(*threshold));
            vec![if dx == 0.0 || x - dx >= at || x + dx < at { 0.0 } else { f64::INFINITY }]
        }
        // The slope of t²(3 − 2t) is 6t(1 − t), at most 1.5.
        Op::Smooth(t) => vec![(1.5 * e(*t)).min(1.0)],
        // The slope of tᵖ on [0, t + dt] is at most p·(t + dt)^(p−1).
        Op::Power { t, p } => {
            let (p, top) = (f64::from(*p), (v(*t) + e(*t)).min(1.0));
            vec![(p * top.powf(p - 1.0) * e(*t)).min(1.0)]
        }
        Op::Complement(t) => vec![e(*t)],
        Op::Product(t, u) => vec![v(*t) * e(*u) + v(*u) * e(*t) + e(*t) * e(*u)],
        Op::Partition(weights) => weights.iter().map(|w| e(*w)).collect(),
        Op::Normalize { values, floor } => {
            let floor = f64::from(*floor);
            let errors: Values = values.iter().map(|v| e(*v)).collect();
            let total: f64 = errors.iter().sum();
            let sum: f64 = values.iter().map(|s| v(*s).max(0.0)).sum();
            // Over any S' ≥ max(S − total, τ): |d(v/S)| ≤ (dv + w·dS)/S'.
            let least = (sum - total).max(floor);
            let mut bounds: Values = values
                .iter()
                .zip(&errors)
                .map(|(s, dv)| ((dv + v(*s).max(0.0) / sum.max(floor) * total) / least).min(1.0))
                .collect();
            bounds.push((total / least).min(1.0));
            bounds
        }
        Op::Weight(partition, i) => vec![error(partition.0)[*i]],
        Op::Mix { a, b, t } => {
            let (t, dt) = (v(*t), e(*t).min(1.0));
            let (va, vb, ea, eb) = (value(a.0), value(b.0), error(a.0), error(b.0));
            (0..3).map(|c| (1.0 - t) * ea[c] + t * eb[c] + dt * ((vb[c] - va[c]).abs() + ea[c] + eb[c])).collect()
        }
        Op::Blend { colors, weights } => {
            let (w, dw) = (value(weights.0), error(weights.0));
            let values: Vec<Values> = colors.iter().map(|color| value(color.0)).collect();
            let errors: Vec<Values> = colors.iter().map(|color| error(color.0)).collect();
            let total: f64 = dw.iter().sum();
            (0..3)
                .map(|c| {
                    // Σ dw = 0, so only differences of colors count: at most half the diameter times Σ|dw|.
                    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                    let mut own = 0.0;
                    for (i, color) in values.iter().enumerate() {
                        low = low.min(color[c] - errors[i][c]);
                        high = high.max(color[c] + errors[i][c]);
                        own += (w[i] + dw[i]) * errors[i][c];
                    }
                    own + 0.5 * (high - low) * total
                })
                .collect()
        }
    }
}
