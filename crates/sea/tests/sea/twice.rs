//! Numbers of twice the precision of f64: a number and what its rounding lost (Dekker; Knuth).

use std::ops::{Add, Mul, Sub};

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
