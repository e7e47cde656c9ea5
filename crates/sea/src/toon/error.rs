/// Why a toon sea is refused.
#[derive(Clone, Debug, PartialEq)]
pub enum ToonError {
    /// A number outside its range.
    Range {
        /// What it is.
        quantity: &'static str,
        /// Its value.
        found: f64,
        /// What is accepted instead.
        expected: &'static str,
    },
    /// The height field would grow without bound.
    Unstable(Instability),
    /// M^τ is not real: the motion cannot be resampled.
    NotResampled {
        /// The coefficients.
        found: [f64; 2],
    },
}

impl std::fmt::Display for ToonError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Range { quantity, found, expected } => write!(f, "{quantity} {found}; expected {expected}"),
            Self::Unstable(instability) => instability.fmt(f),
            Self::NotResampled { found: [c1, c2] } => write!(
                f,
                "c1 {c1}, c2 {c2}, which cannot be resampled: some mode changes its sign at every step, so that half a \
                 step has no real value; expected 0 < c1 < 1 and c2 of 0 or more, or the literal motion"
            ),
        }
    }
}

impl std::error::Error for ToonError {}

/// Finite values within closed bounds pass; anything else, NaN too, is refused by name.
pub(crate) fn within(
    quantity: &'static str,
    found: f64,
    (low, high): (f64, f64),
    expected: &'static str,
) -> Result<(), ToonError> {
    if found.is_finite() && found >= low && found <= high {
        Ok(())
    } else {
        Err(ToonError::Range { quantity, found, expected })
    }
}

/// A recurrence that grows without bound, and the nearest one that does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instability {
    /// The coefficients c₁, c₂.
    pub found: [f64; 2],
    /// By how much the fastest mode grows in a step.
    pub growth: f64,
    /// The stable coefficients closest to them, to four decimals.
    pub nearest: [f64; 2],
}

impl std::fmt::Display for Instability {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([c1, c2], [near1, near2]) = (self.found, self.nearest);
        write!(
            f,
            "c1 {c1}, c2 {c2}, with which the sea grows by {:.4} a step; expected |c1| ≤ 1 and |2·c1·λ + c2| ≤ 1 + c1 \
             for each mode λ of the grid; the nearest that holds: c1 {near1:.4}, c2 {near2:.4}",
            self.growth
        )
    }
}
