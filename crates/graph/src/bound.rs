//! Error bounds: guaranteed limits on the difference between a value and its reference.

/// Error bound: largest possible difference between a computed value and the f64 reference at the same sample.
///
/// In planes a bound is stored as one f32: its size, with a negative sign if it is not *clear*. A bound is not clear
/// if the reference may see another surface, or lie on the other side of a threshold; then higher accuracy of the
/// inputs does not make it smaller.
///
/// ```
/// use trochoid_graph::Bound;
///
/// let bound = Bound::decode(Bound::of(0.25).encode());
/// assert!(bound.clear && bound.size >= 0.25 && bound.size < 0.250001);
/// assert!(!Bound::decode(Bound::UNKNOWN.encode()).clear);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Upper limit of the difference, in the unit of the value; +∞ if nothing is known.
    pub size: f64,
    /// Whether the surface, and the side of every threshold, are certain.
    pub clear: bool,
}

/// Factor that covers the rounding errors in the arithmetic on bounds: far more than a few hundred roundings in f64.
const SLACK: f64 = 1.0 + 1e-9;

impl Bound {
    /// No error.
    pub const EXACT: Self = Self { size: 0.0, clear: true };
    /// No knowledge.
    pub const UNKNOWN: Self = Self { size: f64::INFINITY, clear: false };

    /// Makes a clear bound of a size; NaN becomes +∞.
    #[inline(always)]
    pub fn of(size: f64) -> Self {
        Self { size: if size.is_nan() { f64::INFINITY } else { size }, clear: true }
    }

    /// Keeps the bound clear only if `clear` is true.
    #[inline(always)]
    #[must_use]
    pub fn with(self, clear: bool) -> Self {
        Self { clear: self.clear && clear, ..self }
    }

    /// Encodes the bound for planes, rounded up.
    #[inline(always)]
    pub fn encode(self) -> f32 {
        let size = self.size * SLACK;
        let near = size as f32;
        // The next f32 above a finite one ≥ 0 has the next bits; without a branch, so that loops vectorize.
        let above = f32::from_bits(near.to_bits() + u32::from(f64::from(near) < size));
        if self.clear { above } else { -above }
    }

    /// Decodes a bound from a plane.
    #[inline(always)]
    pub fn decode(bound: f32) -> Self {
        Self { size: f64::from(bound.abs()), clear: bound.is_sign_positive() }
    }
}

/// Rounding error of the f64 arithmetic in the references themselves, relative to the value.
pub const REFERENCE: f64 = 1e-13;

/// Relative error of a literal that was rounded to f32: 2⁻²⁴, and 2⁻⁴⁸ for the f64 operations before.
pub const LITERAL: f64 = (1.0 + 1.0 / 16_777_216.0) / 16_777_216.0;

/// Error: no bound is known. Holds the reason, a sentence without its period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoBound(pub &'static str);
