//! What formulas can give where their inputs are only known within bounds: interval arithmetic.

use super::program::Function;
use trochoid_graph::Bound;

/// All numbers from `low` to `high`; where they are NaN, nothing is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Whether no jump of a function lies within.
    pub(crate) clear: bool,
}

/// Wider than any rounding of the functions, relative to their values.
const ROUNDING: f64 = 1e-14;

impl Span {
    /// Anything, NaN included.
    const ANY: Self = Self { low: f64::NAN, high: f64::NAN, clear: false };

    /// One number.
    pub(crate) fn exactly(number: f64) -> Self {
        Self { low: number, high: number, clear: true }
    }

    /// What lies within a bound of a number.
    pub(crate) fn around(number: f64, bound: Bound) -> Self {
        if bound.size == 0.0 {
            return Self::exactly(number).with(bound.clear);
        }
        Self { low: number - bound.size, high: number + bound.size, clear: bound.clear }
    }

    /// How far a number may lie from what is in it.
    pub(crate) fn bound(self, number: f64) -> Bound {
        if number.is_nan() && !self.is_exact() {
            return Bound::UNKNOWN;
        }
        let size = if self.low == number && self.high == number {
            0.0
        } else {
            (self.high - number).max(number - self.low).max(0.0)
        };
        if self.is_any() { Bound::UNKNOWN } else { Bound::of(size).with(self.clear) }
    }

    /// The same, clear only if all of these are.
    pub(crate) fn with(self, clear: bool) -> Self {
        Self { clear: self.clear && clear, ..self }
    }

    /// What lies between two numbers, where a side of a threshold is not certain.
    pub(crate) fn unclear(low: f64, high: f64) -> Self {
        Self { low, high, clear: false }
    }

    /// What either may be.
    pub(crate) fn or(self, other: Self) -> Self {
        if self.is_any() || other.is_any() {
            return Self::ANY;
        }
        let clear = self.clear && other.clear;
        Self { low: self.low.min(other.low), high: self.high.max(other.high), clear }
    }

    /// The same, as far as it lies between two numbers; all between them where nothing is known.
    pub(crate) fn within(self, low: f64, high: f64) -> Self {
        if self.low.is_nan() || self.high.is_nan() {
            return Self::unclear(low, high);
        }
        Self { low: self.low.clamp(low, high), high: self.high.clamp(low, high), clear: self.clear }
    }

    /// So much more on both sides.
    pub(crate) fn wider(self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by, ..self }
    }

    /// What a function that never turns gives of it, whichever way it goes.
    pub(crate) fn through(self, monotone: impl Fn(f64) -> f64) -> Self {
        Self::of(&[monotone(self.low), monotone(self.high)]).with(self.clear)
    }

    /// Its middle.
    pub(crate) fn middle(self) -> f64 {
        if self.low == self.high { self.low } else { self.low / 2.0 + self.high / 2.0 }
    }

    /// Half its length; 0 where it is one number.
    pub(crate) fn half(self) -> f64 {
        if self.low == self.high { 0.0 } else { self.high / 2.0 - self.low / 2.0 }
    }

    /// Whether a number lies within, an end included.
    pub(crate) fn holds(self, number: f64) -> bool {
        self.low <= number && number <= self.high
    }

    /// Whether nothing is known; of a NaN that is certain, that much is.
    pub(crate) fn is_any(self) -> bool {
        (self.low.is_nan() || self.high.is_nan()) && !self.is_exact()
    }

    /// Whether it is one number for certain.
    pub(crate) fn is_exact(self) -> bool {
        self.clear && self.low.to_bits() == self.high.to_bits()
    }

    /// The span of some numbers, widened for rounding.
    pub(crate) fn of(numbers: &[f64]) -> Self {
        if numbers.iter().any(|number| number.is_nan()) {
            return Self::ANY;
        }
        let low = numbers.iter().copied().fold(f64::INFINITY, f64::min);
        let high = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let slack = |number: f64| if number.is_finite() { number.abs() * ROUNDING + f64::MIN_POSITIVE } else { 0.0 };
        Self { low: low - slack(low), high: high + slack(high), clear: true }
    }

    /// 1 where something holds for certain, 0 where it certainly does not.
    fn truth(holds: bool, fails: bool) -> Self {
        match (holds, fails) {
            (true, _) => Self::exactly(1.0),
            (_, true) => Self::exactly(0.0),
            _ => Self { low: 0.0, high: 1.0, clear: false },
        }
    }

    fn floor(self) -> Self {
        let [low, high] = [self.low.floor(), self.high.floor()];
        Self { low, high, clear: low == high }
    }
}

impl std::ops::Add for Span {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Function::Add.span([self, other, other])
    }
}

impl std::ops::Sub for Span {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Function::Subtract.span([self, other, other])
    }
}

impl std::ops::Mul for Span {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Function::Multiply.span([self, other, other])
    }
}

impl std::ops::Mul<f64> for Span {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self * Self::exactly(factor)
    }
}

impl std::ops::Div for Span {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        Function::Divide.span([self, other, other])
    }
}

impl Function {
    /// All that the function can give of numbers within these spans.
    pub(crate) fn span(self, [a, b, c]: [Span; 3]) -> Span {
        let (_, count) = self.arguments();
        let arguments = &[a, b, c][..count];
        if arguments.iter().all(|argument| argument.is_exact()) {
            let numbers: Vec<f64> = arguments.iter().map(|argument| argument.low).collect();
            return Span::exactly(self.of(&numbers));
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
        let corners = |of: fn(f64, f64) -> f64| {
            Span::of(&[of(a.low, b.low), of(a.low, b.high), of(a.high, b.low), of(a.high, b.high)])
        };
        let span = match self {
            Self::Add => Span::of(&[a.low + b.low, a.high + b.high]),
            Self::Subtract => Span::of(&[a.low - b.high, a.high - b.low]),
            Self::Multiply => corners(|a, b| a * b),
            Self::Divide if b.holds(0.0) => Span::ANY,
            Self::Divide => corners(|a, b| a / b),
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
            Self::Fract => match a.floor() {
                Span { low, clear: true, .. } => Span::of(&[a.low - low, a.high - low]),
                _ => Span { low: 0.0, high: 1.0, clear: false },
            },
            Self::Mod if b.holds(0.0) => Span::ANY,
            Self::Mod => {
                let turns = Self::Divide.span([a, b, b]).floor();
                if turns.clear {
                    Self::Subtract.span([a, Self::Multiply.span([b, turns, turns]), a])
                } else {
                    Span { low: b.low.min(0.0), high: b.high.max(0.0), clear: false }
                }
            }
            Self::Sqrt | Self::Log if a.low < 0.0 => Span::ANY,
            Self::Sqrt | Self::Exp | Self::Log => Span::of(&[self.of(&[a.low]), self.of(&[a.high])]),
            Self::Sin | Self::Cos => {
                let (middle, radius) = (a.low / 2.0 + a.high / 2.0, a.high / 2.0 - a.low / 2.0);
                let at = self.of(&[middle]);
                // The slope is 1 at most. What the middle has been rounded by counts too.
                let reach = radius + middle.abs() * ROUNDING;
                let Span { low, high, .. } = Span::of(&[at - reach, at + reach]);
                if at.is_nan() { Span::ANY } else { Span { low: low.max(-1.0), high: high.min(1.0), clear: true } }
            }
            Self::Atan2 => angle(a, b),
            Self::Smoothstep => {
                if Self::Subtract.span([b, a, a]).holds(0.0) {
                    return Span { low: 0.0, high: 1.0, clear: false };
                }
                let step = |t: f64| t * t * (3.0 - 2.0 * t);
                if a.high < b.low {
                    // How far along it lies rises with x and falls with both ends, as far as it counts.
                    let along = |x: f64, a: f64, b: f64| ((x - a) / (b - a)).clamp(0.0, 1.0);
                    let ends = [along(c.low, a.high, b.high), along(c.high, a.low, b.low)];
                    return Span::of(&ends.map(step)).with(arguments.iter().all(|argument| argument.clear));
                }
                let along = Self::Divide.span([Self::Subtract.span([c, a, a]), Self::Subtract.span([b, a, a]), a]);
                Span::of(&[along.low, along.high].map(|t| step(t.clamp(0.0, 1.0))))
            }
            Self::Mix => {
                // Straight in each argument, so that the extremes lie in corners.
                let mut all = Vec::with_capacity(8);
                for x in [a.low, a.high] {
                    for y in [b.low, b.high] {
                        all.extend([c.low, c.high].map(|t| self.of(&[x, y, t])));
                    }
                }
                Span::of(&all)
            }
            Self::If => unreachable!("dealt with above"),
        };
        if span.is_any() { span } else { span.with(arguments.iter().all(|argument| argument.clear)) }
    }
}

fn power(a: Span, b: Span) -> Span {
    let of = |a: f64, b: f64| Function::Power.of(&[a, b]);
    let is_whole = b.low == b.high && b.low == b.low.trunc() && b.low >= 0.0 && b.low < 1e9;
    if is_whole {
        let ends = [of(a.low, b.low), of(a.high, b.low)];
        return if b.low % 2.0 == 0.0 && a.holds(0.0) { Span::of(&[0.0, ends[0], ends[1]]) } else { Span::of(&ends) };
    }
    // Monotone in each argument where the base is positive, so that the extremes lie in corners.
    if a.low > 0.0 || (a.low == 0.0 && b.low > 0.0) {
        Span::of(&[of(a.low, b.low), of(a.low, b.high), of(a.high, b.low), of(a.high, b.high)])
    } else {
        Span::ANY
    }
}

/// atan2(y, x).
fn angle(y: Span, x: Span) -> Span {
    let pi = std::f64::consts::PI;
    if y.holds(0.0) && x.low <= 0.0 {
        // Around the origin, or across the cut.
        return Span { low: -pi, high: pi, clear: false };
    }
    let middle = |span: Span| (span.low / 2.0 + span.high / 2.0, span.high / 2.0 - span.low / 2.0);
    let nearest = |span: Span| if span.holds(0.0) { 0.0 } else { span.low.abs().min(span.high.abs()) };
    let ((y0, dy), (x0, dx)) = (middle(y), middle(x));
    // An arc turns by no more than its length over its distance from the origin.
    let reach = libm::hypot(dy, dx) / libm::hypot(nearest(y), nearest(x));
    let at = Function::Atan2.of(&[y0, x0]);
    Span::of(&[at - reach, at + reach])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]
        #[test]
        fn no_function_leaves_its_span(
            middle in prop::array::uniform3(prop_oneof![-3.0f64..3.0, Just(0.0), Just(1.0), Just(-2.0), -1e6f64..1e6]),
            size in prop::array::uniform3(prop_oneof![Just(0.0), 0.0f64..1e-6, 0.0f64..2.0]),
            at in prop::array::uniform3(-1.0f64..=1.0),
        ) {
            let spans: [Span; 3] = std::array::from_fn(|i| Span::around(middle[i], Bound::of(size[i])));
            let numbers: Vec<f64> = (0..3).map(|i| middle[i] + size[i] * at[i]).collect();
            for function in Function::all() {
                let span = function.span(spans);
                let (_, count) = function.arguments();
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
