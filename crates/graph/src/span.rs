//! Interval arithmetic, for numbers known only within bounds.

use crate::Bound;
use std::ops::{Add, Div, Mul, Sub};

/// Interval of all numbers from `low` to `high`. If they are NaN, nothing is known.
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
    /// Smallest number.
    pub low: f64,
    /// Largest number.
    pub high: f64,
    /// Whether the interval contains no jump of a function.
    pub clear: bool,
}

impl Span {
    /// Margin for rounding errors, relative to the values of functions.
    pub const ROUNDING: f64 = 1e-14;
    /// Any number, or NaN.
    pub const ANY: Self = Self { low: f64::NAN, high: f64::NAN, clear: false };

    /// Returns the interval of a single number.
    #[inline]
    pub fn exactly(number: f64) -> Self {
        Self { low: number, high: number, clear: true }
    }

    /// Returns the interval around a number within a bound.
    #[inline]
    pub fn around(number: f64, bound: Bound) -> Self {
        if bound.size == 0.0 {
            return Self::exactly(number).with(bound.clear);
        }
        Self { low: number - bound.size, high: number + bound.size, clear: bound.clear }
    }

    /// Returns the largest distance of a number from those in the interval.
    #[inline]
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

    /// Returns the interval, clear only if `clear` is true too.
    #[must_use]
    #[inline]
    pub fn with(self, clear: bool) -> Self {
        Self { clear: self.clear && clear, ..self }
    }

    /// Returns the interval between two numbers, for a value whose side of a threshold is uncertain.
    pub fn unclear(low: f64, high: f64) -> Self {
        Self { low, high, clear: false }
    }

    /// Returns the smallest interval that contains both.
    #[must_use]
    #[inline]
    pub fn or(self, other: Self) -> Self {
        if self.is_any() || other.is_any() {
            return Self::ANY;
        }
        let clear = self.clear && other.clear;
        Self { low: self.low.min(other.low), high: self.high.max(other.high), clear }
    }

    /// Returns the interval clamped to two numbers, or all between them if nothing is known.
    #[must_use]
    #[inline]
    pub fn within(self, low: f64, high: f64) -> Self {
        if self.low.is_nan() || self.high.is_nan() {
            return Self::unclear(low, high);
        }
        Self { low: self.low.clamp(low, high), high: self.high.clamp(low, high), clear: self.clear }
    }

    /// Returns the interval widened on both sides.
    #[must_use]
    #[inline]
    pub fn wider(self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by, ..self }
    }

    /// Returns the interval of a monotonic function, rising or falling.
    #[must_use]
    pub fn through(self, monotone: impl Fn(f64) -> f64) -> Self {
        Self::of(&[monotone(self.low), monotone(self.high)]).with(self.clear)
    }

    /// Returns the middle.
    #[inline]
    pub fn middle(self) -> f64 {
        if self.low == self.high { self.low } else { self.low / 2.0 + self.high / 2.0 }
    }

    /// Returns half the length; 0 for a single number.
    #[inline]
    pub fn half(self) -> f64 {
        if self.low == self.high { 0.0 } else { self.high / 2.0 - self.low / 2.0 }
    }

    /// Returns whether the interval contains a number.
    #[inline]
    pub fn holds(self, number: f64) -> bool {
        self.low <= number && number <= self.high
    }

    /// Returns whether nothing is known. A NaN that is certain is known.
    #[inline]
    pub fn is_any(self) -> bool {
        (self.low.is_nan() || self.high.is_nan()) && !self.is_exact()
    }

    /// Returns whether it is a single number, and certain.
    #[inline]
    pub fn is_exact(self) -> bool {
        self.clear && self.low.to_bits() == self.high.to_bits()
    }

    /// Returns the smallest interval that contains some numbers, widened for rounding.
    #[inline]
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

    /// Returns 1 if a condition certainly holds, 0 if it certainly fails, else the interval from 0 to 1.
    pub fn truth(holds: bool, fails: bool) -> Self {
        match (holds, fails) {
            (true, _) => Self::exactly(1.0),
            (_, true) => Self::exactly(0.0),
            _ => Self { low: 0.0, high: 1.0, clear: false },
        }
    }

    /// Returns the interval rounded down; clear if all of it rounds to one number.
    #[must_use]
    pub fn floor(self) -> Self {
        let [low, high] = [self.low.floor(), self.high.floor()];
        Self { low, high, clear: low == high }
    }

    /// Returns the interval of a function of two numbers: exact if both are certain, else from `span`.
    #[inline]
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

    /// Returns whether both ends are finite.
    #[inline]
    pub fn is_bounded(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    /// Returns whether the interval reaches an infinity, and another, times `sign`, the same: then their difference
    /// may be NaN.
    #[inline]
    fn reaches(self, other: Self, sign: f64) -> bool {
        let infinities = |span: Self| [span.low, span.high].into_iter().filter(|end| end.is_infinite());
        infinities(self).any(|end| infinities(other).any(|there| there * sign == end))
    }

    /// Returns the interval of a function that is monotonic in each of two numbers, from its values at the corners.
    #[must_use]
    #[inline]
    pub fn corners(self, other: Self, of: fn(f64, f64) -> f64) -> Self {
        let (a, b) = (self, other);
        Self::of(&[of(a.low, b.low), of(a.low, b.high), of(a.high, b.low), of(a.high, b.high)])
    }
}

impl Add for Span {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        let sum = || match self.reaches(other, -1.0) {
            true => Self::ANY,
            false => Self::of(&[self.low + other.low, self.high + other.high]),
        };
        self.of_two(other, |a, b| a + b, sum)
    }
}

impl Sub for Span {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        let difference = || match self.reaches(other, 1.0) {
            true => Self::ANY,
            false => Self::of(&[self.low - other.high, self.high - other.low]),
        };
        self.of_two(other, |a, b| a - b, difference)
    }
}

impl Mul for Span {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        // 0·∞ is NaN.
        let is_open = (self.holds(0.0) && !other.is_bounded()) || (other.holds(0.0) && !self.is_bounded());
        self.of_two(other, |a, b| a * b, || if is_open { Self::ANY } else { self.corners(other, |a, b| a * b) })
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

    #[inline]
    fn div(self, other: Self) -> Self {
        let quotients = || if other.holds(0.0) { Self::ANY } else { self.corners(other, |a, b| a / b) };
        self.of_two(other, |a, b| a / b, quotients)
    }
}
