//! Numbers that are only known within bounds: interval arithmetic.

use crate::Bound;
use std::ops::{Add, Div, Mul, Sub};

/// All numbers from `low` to `high`; where they are NaN, nothing is known.
///
/// ```
/// use trochoid_graph::{Bound, Span};
///
/// let (a, b) = (Span::around(2.0, Bound::of(0.5)), Span::exactly(3.0));
/// assert!((a * b).holds(4.5) && (a * b).holds(7.5) && !(a * b).holds(8.0));
/// assert!((b / (a - b - Span::exactly(-1.0))).is_any(), "the divisor may be 0");
/// assert!((a * b).bound(6.0).size >= 1.5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The least of them.
    pub low: f64,
    /// The greatest of them.
    pub high: f64,
    /// Whether no jump of a function lies within.
    pub clear: bool,
}

impl Span {
    /// Wider than any rounding of the functions, relative to their values.
    pub const ROUNDING: f64 = 1e-14;
    /// Anything, NaN included.
    pub const ANY: Self = Self { low: f64::NAN, high: f64::NAN, clear: false };

    /// One number.
    pub fn exactly(number: f64) -> Self {
        Self { low: number, high: number, clear: true }
    }

    /// What lies within a bound of a number.
    pub fn around(number: f64, bound: Bound) -> Self {
        if bound.size == 0.0 {
            return Self::exactly(number).with(bound.clear);
        }
        Self { low: number - bound.size, high: number + bound.size, clear: bound.clear }
    }

    /// How far a number may lie from what is in it.
    pub fn bound(self, number: f64) -> Bound {
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
    #[must_use]
    pub fn with(self, clear: bool) -> Self {
        Self { clear: self.clear && clear, ..self }
    }

    /// What lies between two numbers, where a side of a threshold is not certain.
    pub fn unclear(low: f64, high: f64) -> Self {
        Self { low, high, clear: false }
    }

    /// What either may be.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        if self.is_any() || other.is_any() {
            return Self::ANY;
        }
        let clear = self.clear && other.clear;
        Self { low: self.low.min(other.low), high: self.high.max(other.high), clear }
    }

    /// The same, as far as it lies between two numbers; all between them where nothing is known.
    #[must_use]
    pub fn within(self, low: f64, high: f64) -> Self {
        if self.low.is_nan() || self.high.is_nan() {
            return Self::unclear(low, high);
        }
        Self { low: self.low.clamp(low, high), high: self.high.clamp(low, high), clear: self.clear }
    }

    /// So much more on both sides.
    #[must_use]
    pub fn wider(self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by, ..self }
    }

    /// What a function that never turns gives of it, whichever way it goes.
    #[must_use]
    pub fn through(self, monotone: impl Fn(f64) -> f64) -> Self {
        Self::of(&[monotone(self.low), monotone(self.high)]).with(self.clear)
    }

    /// Its middle.
    pub fn middle(self) -> f64 {
        if self.low == self.high { self.low } else { self.low / 2.0 + self.high / 2.0 }
    }

    /// Half its length; 0 where it is one number.
    pub fn half(self) -> f64 {
        if self.low == self.high { 0.0 } else { self.high / 2.0 - self.low / 2.0 }
    }

    /// Whether a number lies within, an end included.
    pub fn holds(self, number: f64) -> bool {
        self.low <= number && number <= self.high
    }

    /// Whether nothing is known; of a NaN that is certain, that much is.
    pub fn is_any(self) -> bool {
        (self.low.is_nan() || self.high.is_nan()) && !self.is_exact()
    }

    /// Whether it is one number for certain.
    pub fn is_exact(self) -> bool {
        self.clear && self.low.to_bits() == self.high.to_bits()
    }

    /// The span of some numbers, widened for rounding.
    pub fn of(numbers: &[f64]) -> Self {
        if numbers.iter().any(|number| number.is_nan()) {
            return Self::ANY;
        }
        let low = numbers.iter().copied().fold(f64::INFINITY, f64::min);
        let high = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let slack =
            |number: f64| if number.is_finite() { number.abs() * Self::ROUNDING + f64::MIN_POSITIVE } else { 0.0 };
        Self { low: low - slack(low), high: high + slack(high), clear: true }
    }

    /// 1 where something holds for certain, 0 where it certainly does not.
    pub fn truth(holds: bool, fails: bool) -> Self {
        match (holds, fails) {
            (true, _) => Self::exactly(1.0),
            (_, true) => Self::exactly(0.0),
            _ => Self { low: 0.0, high: 1.0, clear: false },
        }
    }

    /// Rounded down; clear where all of it is so to one number.
    #[must_use]
    pub fn floor(self) -> Self {
        let [low, high] = [self.low.floor(), self.high.floor()];
        Self { low, high, clear: low == high }
    }

    /// What a function of two numbers gives: the number where both are certain, else a span that holds its values.
    fn of_two(self, other: Self, of: fn(f64, f64) -> f64, span: impl FnOnce() -> Self) -> Self {
        if self.is_exact() && other.is_exact() {
            return Self::exactly(of(self.low, other.low));
        }
        if [self, other].iter().any(|span| span.low.is_nan() || span.high.is_nan()) {
            return Self::ANY;
        }
        let span = span();
        if span.is_any() { span } else { span.with(self.clear && other.clear) }
    }

    /// The span of a function that is monotone in each of two numbers: its extremes lie in corners.
    #[must_use]
    pub fn corners(self, other: Self, of: fn(f64, f64) -> f64) -> Self {
        let (a, b) = (self, other);
        Self::of(&[of(a.low, b.low), of(a.low, b.high), of(a.high, b.low), of(a.high, b.high)])
    }
}

impl Add for Span {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.of_two(other, |a, b| a + b, || Self::of(&[self.low + other.low, self.high + other.high]))
    }
}

impl Sub for Span {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.of_two(other, |a, b| a - b, || Self::of(&[self.low - other.high, self.high - other.low]))
    }
}

impl Mul for Span {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        self.of_two(other, |a, b| a * b, || self.corners(other, |a, b| a * b))
    }
}

impl Mul<f64> for Span {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self * Self::exactly(factor)
    }
}

impl Div for Span {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let quotients = || if other.holds(0.0) { Self::ANY } else { self.corners(other, |a, b| a / b) };
        self.of_two(other, |a, b| a / b, quotients)
    }
}
