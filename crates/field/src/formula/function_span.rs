//! Spans of FieldMath's functions over spans of their arguments.

use super::Function;
use std::ops::{Add, Div, Mul, Sub};
use trochoid_graph::Span;

impl Function {
    /// Computes the spans of a run of samples.
    pub(super) fn fill_spans(self, [a, b, c]: [&[Span]; 3], out: &mut [Span]) {
        let of_two = |of: fn(Span, Span) -> Span, out: &mut [Span]| {
            out.iter_mut().zip(a).zip(b).for_each(|((out, a), b)| *out = of(*a, *b));
        };
        match self {
            Self::Add => of_two(Add::add, out),
            Self::Subtract => of_two(Sub::sub, out),
            Self::Multiply => of_two(Mul::mul, out),
            Self::Divide => of_two(Div::div, out),
            _ => {
                for (((out, a), b), c) in out.iter_mut().zip(a).zip(b).zip(c) {
                    *out = self.span([*a, *b, *c]);
                }
            }
        }
    }

    /// Returns a span of all values that the function can have for arguments within the spans.
    pub(super) fn span(self, [a, b, c]: [Span; 3]) -> Span {
        let count = self.arguments();
        let arguments = &[a, b, c][..count];
        if arguments.iter().all(|argument| argument.is_exact()) {
            return Span::exactly(self.of(&[a.low, b.low, c.low][..count]));
        }
        if self == Self::If {
            return match (a.holds(0.0), a.is_exact()) {
                (true, true) => c,
                (true, false) if !a.is_any() => Span { clear: false, ..b.or(c) },
                (false, _) if !a.is_any() => b.with(a.clear),
                _ => Span { clear: false, ..b.or(c) },
            };
        }
        if arguments.iter().any(|argument| argument.low.is_nan() || argument.high.is_nan()) {
            return Span::ANY;
        }
        let span = match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power => power(a, b),
            Self::Negate => Span { low: -a.high, high: -a.low, clear: true },
            Self::Less => Span::truth(a.high < b.low, a.low >= b.high),
            Self::LessOrEqual => Span::truth(a.high <= b.low, a.low > b.high),
            Self::Greater => Span::truth(a.low > b.high, a.high <= b.low),
            Self::GreaterOrEqual => Span::truth(a.low >= b.high, a.high < b.low),
            Self::Equal => Span::truth(false, a.high < b.low || a.low > b.high),
            Self::Unequal => Span::truth(a.high < b.low || a.low > b.high, false),
            Self::Least => Span { low: a.low.min(b.low), high: a.high.min(b.high), clear: true },
            Self::Most => Span { low: a.low.max(b.low), high: a.high.max(b.high), clear: true },
            Self::Clamp => Span { low: a.low.max(b.low).min(c.low), high: a.high.max(b.high).min(c.high), clear: true },
            Self::Abs if a.holds(0.0) => Span { low: 0.0, high: a.high.max(-a.low), clear: true },
            Self::Abs => Span { low: a.low.abs().min(a.high.abs()), high: a.low.abs().max(a.high.abs()), clear: true },
            Self::Sign => {
                let [low, high] = [a.low, a.high].map(|a| self.of(&[a]));
                Span { low, high, clear: low == high }
            }
            Self::Floor => a.floor(),
            Self::Ceil => {
                let [low, high] = [a.low.ceil(), a.high.ceil()];
                Span { low, high, clear: low == high }
            }
            // The remainder of an infinity is NaN.
            Self::Fract if !a.is_bounded() => Span::ANY,
            Self::Fract => match a.floor() {
                Span { low, clear: true, .. } => Span::of(&[a.low - low, a.high - low]),
                _ => Span { low: 0.0, high: 1.0, clear: false },
            },
            Self::Mod if b.holds(0.0) || !a.is_bounded() || !b.is_bounded() => Span::ANY,
            Self::Mod => {
                let turns = (a / b).floor();
                if turns.clear {
                    a - b * turns
                } else {
                    // The quotient, its product with b and the difference are rounded relative to a.
                    let lost = Span::ROUNDING * a.low.abs().max(a.high.abs());
                    Span { low: b.low.min(0.0), high: b.high.max(0.0), clear: false }.wider(lost)
                }
            }
            Self::Sqrt | Self::Log if a.low < 0.0 => Span::ANY,
            Self::Sqrt | Self::Exp | Self::Log => Span::of(&[self.of(&[a.low]), self.of(&[a.high])]),
            Self::Sin | Self::Cos => {
                let (middle, radius) = (a.low / 2.0 + a.high / 2.0, a.high / 2.0 - a.low / 2.0);
                let at = self.of(&[middle]);
                // The slope is at most 1. Include the rounding of the middle.
                let reach = radius + middle.abs() * Span::ROUNDING;
                let Span { low, high, .. } = Span::of(&[at - reach, at + reach]);
                if at.is_nan() { Span::ANY } else { Span { low: low.max(-1.0), high: high.min(1.0), clear: true } }
            }
            Self::Atan2 => angle(a, b),
            // ∞/∞ is NaN.
            Self::Smoothstep if !a.is_bounded() || !b.is_bounded() => Span::ANY,
            Self::Smoothstep => {
                if (b - a).holds(0.0) {
                    // 0/0 is NaN too; anything else over 0 is infinite.
                    let is_open = (c - a).holds(0.0);
                    return if is_open { Span::ANY } else { Span { low: 0.0, high: 1.0, clear: false } };
                }
                let step = |t: f64| t * t * (3.0 - 2.0 * t);
                if a.high < b.low {
                    // t rises with x and falls as either end rises, after limiting it to [0, 1].
                    let along = |x: f64, a: f64, b: f64| ((x - a) / (b - a)).clamp(0.0, 1.0);
                    let ends = [along(c.low, a.high, b.high), along(c.high, a.low, b.low)];
                    return Span::of(&ends.map(step)).with(arguments.iter().all(|argument| argument.clear));
                }
                let along = (c - a) / (b - a);
                Span::of(&[along.low, along.high].map(|t| step(t.clamp(0.0, 1.0))))
            }
            // 0·∞ and ∞ − ∞ are NaN.
            Self::Mix if ![a, b, c].iter().all(|span| span.is_bounded()) => Span::ANY,
            Self::Mix => {
                // Linear in each argument, so the extremes lie in the corners.
                let mix = |a: f64, b: f64, t: f64| (1.0 - t) * a + t * b;
                let mut all = [mix(a.low, b.low, c.low), mix(a.low, b.low, c.high), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
                let all = if a.low == a.high && b.low == b.high {
                    &all[..2]
                } else {
                    let pairs = [(a.low, b.high), (a.high, b.low), (a.high, b.high)];
                    for (index, (a, b)) in pairs.into_iter().enumerate() {
                        all[2 + 2 * index..4 + 2 * index].copy_from_slice(&[mix(a, b, c.low), mix(a, b, c.high)]);
                    }
                    &all[..]
                };
                // Beyond t = 0 and 1, products that are much larger than their sum are rounded.
                let most = |span: Span| span.low.abs().max(span.high.abs());
                Span::of(all).wider(Span::ROUNDING * ((1.0 + most(c)) * most(a) + most(c) * most(b)))
            }
            Self::If => unreachable!("dealt with above"),
        };
        if span.is_any() { span } else { span.with(arguments.iter().all(|argument| argument.clear)) }
    }
}

/// Returns the span of aᵇ.
fn power(a: Span, b: Span) -> Span {
    let is_whole = b.low == b.high && b.low == b.low.trunc() && b.low >= 0.0 && b.low < 1e9;
    if is_whole {
        let ends = [libm::pow(a.low, b.low), libm::pow(a.high, b.low)];
        return if b.low % 2.0 == 0.0 && a.holds(0.0) { Span::of(&[0.0, ends[0], ends[1]]) } else { Span::of(&ends) };
    }
    // Monotonic in each argument for a positive base, so the extremes lie in the corners.
    if a.low > 0.0 || (a.low == 0.0 && b.low > 0.0) { a.corners(b, libm::pow) } else { Span::ANY }
}

/// Returns the span of atan2(y, x).
fn angle(y: Span, x: Span) -> Span {
    let pi = std::f64::consts::PI;
    if y.holds(0.0) && x.low <= 0.0 {
        // The spans contain the origin, or cross the branch cut.
        return Span { low: -pi, high: pi, clear: false };
    }
    let middle = |span: Span| (span.low / 2.0 + span.high / 2.0, span.high / 2.0 - span.low / 2.0);
    let nearest = |span: Span| if span.holds(0.0) { 0.0 } else { span.low.abs().min(span.high.abs()) };
    let ((y0, dy), (x0, dx)) = (middle(y), middle(x));
    // The angle changes by at most the distance moved divided by the distance from the origin.
    let reach = libm::hypot(dy, dx) / libm::hypot(nearest(y), nearest(x));
    let at = Function::Atan2.of(&[y0, x0]);
    Span::of(&[at - reach, at + reach])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trochoid_graph::Bound;

    const ENDLESS: [f64; 5] = [f64::NEG_INFINITY, -7.0, 0.0, 1e30, f64::INFINITY];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(10_000))]
        #[test]
        fn no_function_leaves_its_span(
            middle in prop::array::uniform3(prop_oneof![
                -3.0f64..3.0, Just(0.0), Just(1.0), Just(-2.0), -1e6f64..1e6, Just(65504.0), Just(-1e30), Just(1e-45),
                Just(f64::INFINITY), Just(f64::NEG_INFINITY),
            ]),
            size in prop::array::uniform3(prop_oneof![Just(0.0), 0.0f64..1e-6, 0.0f64..2.0, Just(f64::INFINITY)]),
            at in prop::array::uniform3(prop_oneof![-1.0f64..=1.0, Just(-1.0), Just(0.0), Just(1.0)]),
        ) {
            // As stages get them: ∞ ± ∞ leaves everything open.
            let open = |end: f64, open: f64| if end.is_nan() { open } else { end };
            let spans: [Span; 3] = std::array::from_fn(|i| {
                let Span { low, high, clear } = Span::around(middle[i], Bound::of(size[i]));
                Span { low: open(low, f64::NEG_INFINITY), high: open(high, f64::INFINITY), clear }
            });
            let number = |i: usize| match (middle[i], size[i]) {
                (middle, 0.0) => middle,
                // Any number, also an infinite one.
                (_, f64::INFINITY) => ENDLESS[((at[i] + 1.0) * 2.5).min(4.0) as usize],
                (middle, size) => middle + size * at[i],
            };
            let numbers: Vec<f64> = (0..3).map(number).collect();
            for function in Function::ALL {
                let span = function.span(spans);
                let count = function.arguments();
                let value = function.of(&numbers[..count]);
                let inside = span.is_any() || span.holds(value) || (span.is_exact() && value.to_bits() == span.low.to_bits());
                prop_assert!(inside, "{function:?} of {numbers:?} is {value}, beyond {span:?} of {spans:?}");
            }
        }
    }

    #[test]
    fn jumps_are_told_and_smooth_functions_are_not_called_jumps() {
        let around = |number: f64| Span::around(number, Bound::of(0.1));
        let of = |function: Function, numbers: [f64; 3]| function.span(numbers.map(around));
        assert!(!of(Function::Floor, [2.05, 0.0, 0.0]).clear);
        assert!(of(Function::Floor, [2.5, 0.0, 0.0]).clear);
        assert!(!of(Function::Less, [1.0, 1.05, 0.0]).clear);
        assert_eq!(of(Function::Less, [1.0, 2.0, 0.0]), Span::exactly(1.0));
        assert!(!of(Function::If, [0.05, 1.0, 2.0]).clear);
        assert!(of(Function::If, [5.0, 1.0, 2.0]).clear);
        assert!(of(Function::Divide, [1.0, 0.05, 0.0]).is_any());
        assert!(of(Function::Sqrt, [0.05, 0.0, 0.0]).is_any(), "it may be NaN");
        for function in [Function::Multiply, Function::Sin, Function::Smoothstep, Function::Mix, Function::Exp] {
            let span = of(function, [0.3, 0.9, 0.5]);
            assert!(span.clear && span.high - span.low < 1.0, "{function:?}: {span:?}");
        }
    }
}
