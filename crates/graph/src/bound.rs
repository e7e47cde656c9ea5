//! Bounds on errors: what is certain of how far a value may lie from its reference.

/// How far a computed value may lie from what the f64 reference gives at the same sample.
///
/// In planes a bound is one f32: its size, negative where it is not *clear*: where the reference may see another surface, or
/// lie on another side of a threshold, so that no smaller error makes the bound smaller.
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
    /// At least the distance, in the unit of the value; +∞ where nothing is known.
    pub size: f64,
    /// Whether a side or a surface is in no doubt.
    pub clear: bool,
}

/// What arithmetic on bounds themselves may have lost: far more than a few hundred roundings in f64.
const SLACK: f64 = 1.0 + 1e-9;

impl Bound {
    /// No error.
    pub const EXACT: Self = Self { size: 0.0, clear: true };
    /// Nothing is known.
    pub const UNKNOWN: Self = Self { size: f64::INFINITY, clear: false };

    /// A clear bound of a size; +∞ in place of NaN.
    pub fn of(size: f64) -> Self {
        Self { size: if size.is_nan() { f64::INFINITY } else { size }, clear: true }
    }

    /// The same size, clear only if all of these are.
    #[must_use]
    pub fn with(self, clear: bool) -> Self {
        Self { clear: self.clear && clear, ..self }
    }

    /// As it stands in planes: rounded up.
    #[inline]
    pub fn encode(self) -> f32 {
        let size = self.size * SLACK;
        let near = size as f32;
        let above = if f64::from(near) < size { near.next_up() } else { near };
        if self.clear { above } else { -above }
    }

    /// From a plane.
    #[inline]
    pub fn decode(bound: f32) -> Self {
        Self { size: f64::from(bound.abs()), clear: bound.is_sign_positive() }
    }
}

/// What f64 arithmetic of the references themselves may lose, relative to the value.
pub const REFERENCE: f64 = 1e-13;

/// Relative error of a literal that was rounded to f32.
pub const LITERAL: f64 = 1.0 / 16_777_216.0;

/// That no bound is known, and why: a sentence without its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoBound(pub &'static str);
