//! Certain bounds on every operation's result.

use trochoid_graph::Op;

/// A closed interval of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Least possible value.
    pub low: f64,
    /// Greatest possible value.
    pub high: f64,
}

impl Interval {
    /// Contains every mask.
    pub const MASK: Self = Self { low: 0.0, high: 1.0 };
    /// Contains every number.
    pub const ALL: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };
    /// Contains every color channel.
    pub const COLOR: Self = Self { low: 0.0, high: f64::INFINITY };

    /// Returns the interval of exactly one value.
    pub fn exactly(value: f32) -> Self {
        Self { low: f64::from(value), high: f64::from(value) }
    }

    /// Returns the value, if there is only one.
    pub fn constant(self) -> Option<f64> {
        (self.low == self.high).then_some(self.low)
    }

    fn map_rising(self, f: impl Fn(f32) -> f32) -> Self {
        Self { low: f64::from(f(self.low as f32)), high: f64::from(f(self.high as f32)) }
    }

    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// Intervals of one operation's rows: one for a scalar, three for a color, n for a partition.
pub(crate) type Bounds = Vec<Interval>;

/// Bounds an operation's result from the intervals of its operands; `slot` bounds planes from outside.
pub(crate) fn interval(
    op: &Op,
    of: &dyn Fn(u32) -> Bounds,
    slot: &dyn Fn(&trochoid_graph::Slot, usize) -> Interval,
) -> Bounds {
    use trochoid_weights::arithmetic as a;
    let scalar = |s: trochoid_graph::Scalar| of(s.0)[0];
    match op {
        Op::Load(s) => vec![slot(s, s.channel)],
        Op::Constant(value) => vec![Interval::exactly(*value)],
        // Bounds of fields are stated in f64; every bound of a mask is an f32.
        Op::Clamp { x, min, max } => vec![scalar(*x).map_rising(|x| a::clamp(x, *min, *max))],
        Op::Smooth(t) => vec![scalar(*t).map_rising(a::smooth)],
        Op::Power { t, p } => vec![scalar(*t).map_rising(|t| a::power(t, *p))],
        Op::Step { x, threshold } => vec![scalar(*x).map_rising(|x| a::step(x, *threshold))],
        Op::Complement(t) => {
            let t = scalar(*t);
            vec![Interval {
                low: f64::from(a::complement(t.high as f32)),
                high: f64::from(a::complement(t.low as f32)),
            }]
        }
        Op::Product(t, u) => {
            // Masks are ≥ 0, so the product rises in both.
            let (t, u) = (scalar(*t), scalar(*u));
            let product = |t: f64, u: f64| f64::from(a::product(t as f32, u as f32));
            vec![Interval { low: product(t.low, u.low), high: product(t.high, u.high) }]
        }
        Op::Partition(weights) => {
            let raw: Bounds = weights.iter().map(|w| scalar(*w)).collect();
            // Constants round exactly as in the kernel; any other weight may gain or lose the residual.
            if let Some(values) = raw.iter().map(|w| w.constant()).collect::<Option<Vec<f64>>>() {
                let mut values: Vec<f32> = values.into_iter().map(|v| v as f32).collect();
                a::round_partition(&mut values);
                return values.into_iter().map(Interval::exactly).collect();
            }
            vec![Interval::MASK; weights.len()]
        }
        Op::Normalize { values, .. } => vec![Interval::MASK; values.len() + 1],
        Op::Weight(partition, i) => vec![of(partition.0)[*i]],
        Op::LoadColor(s) => (s.channel..s.channel + 3).map(|channel| slot(s, channel)).collect(),
        Op::ConstantColor(color) => color.iter().map(|&c| Interval::exactly(c)).collect(),
        Op::Mix { a, b, t } => match scalar(*t).constant() {
            Some(0.0) => of(a.0),
            Some(1.0) => of(b.0),
            _ => of(a.0).into_iter().zip(of(b.0)).map(|(a, b)| a.union(b)).collect(),
        },
        Op::Blend { colors, weights } => {
            let weights = of(weights.0);
            // A weight of exactly 0 adds nothing.
            let used = colors.iter().zip(weights).filter(|(_, w)| w.high > 0.0).map(|(color, _)| of(color.0));
            used.reduce(|a, b| a.into_iter().zip(b).map(|(a, b)| a.union(b)).collect())
                .unwrap_or_else(|| vec![Interval::COLOR; 3])
        }
    }
}
