//! Numbers of twice the precision of f64: a number and what its rounding lost (Dekker; Knuth).

use std::f64::consts::PI;
use std::ops::{Add, Div, Mul, Sub};

#[derive(Clone, Copy, Debug)]
pub(crate) struct Twice(f64, f64);

impl From<f64> for Twice {
    fn from(value: f64) -> Self {
        Self(value, 0.0)
    }
}

/// Returns a sum, and what its rounding lost.
fn sum(a: f64, b: f64) -> Twice {
    let sum = a + b;
    let added = sum - a;
    Twice(sum, (a - (sum - added)) + (b - added))
}

impl Twice {
    pub(crate) fn abs(self) -> f64 {
        (self.0 + self.1).abs()
    }

    pub(crate) fn max(self, other: Self) -> Self {
        let less = self - other;
        if less.0 + less.1 < 0.0 { other } else { self }
    }

    pub(crate) fn sqrt(self) -> Self {
        if self.0 <= 0.0 {
            return Self(0.0, 0.0);
        }
        let root = self.0.sqrt();
        let rest = self - Self::from(root) * Self::from(root);
        sum(root, rest.0 / (2.0 * root))
    }

    /// Returns sine and cosine of an angle in half turns.
    pub(crate) fn sincos(self) -> [Self; 2] {
        const DOUBLINGS: i32 = 4;
        let nearest = self.0.round();
        let part = self - Self::from(nearest);
        let angle = part * Self(PI, 1.224_646_799_147_353_2e-16) * Self::from(0.5_f64.powi(DOUBLINGS));
        let mut term = Self::from(1.0);
        let [mut sin, mut cos] = [Self::from(0.0), term];
        for power in 1..24_u32 {
            term = term * angle / Self::from(f64::from(power));
            let signed = if power % 4 < 2 { term } else { Self::from(0.0) - term };
            if power % 2 == 1 { sin = sin + signed } else { cos = cos + signed }
        }
        for _ in 0..DOUBLINGS {
            [sin, cos] = [Self::from(2.0) * sin * cos, cos * cos - sin * sin];
        }
        let sign = Self::from(if nearest.rem_euclid(2.0) == 1.0 { -1.0 } else { 1.0 });
        [sign * sin, sign * cos]
    }
}

impl Add for Twice {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, low) = (sum(self.0, other.0), sum(self.1, other.1));
        let high = sum(high.0, high.1 + low.0);
        sum(high.0, high.1 + low.1)
    }
}

impl Sub for Twice {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + Self(-other.0, -other.1)
    }
}

impl Mul for Twice {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let lost = self.0.mul_add(other.0, -product) + (self.0 * other.1 + self.1 * other.0);
        sum(product, lost)
    }
}

impl Div for Twice {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let quotient = self.0 / other.0;
        let rest = self - Self::from(quotient) * other;
        sum(quotient, rest.0 / other.0)
    }
}
