//! Required accuracy of pictures.

use std::fmt;

/// Required accuracy of a picture, from which settings are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// Largest error in any channel of any sample whose bound is clear ([`Bound::clear`](crate::Bound::clear)), in the
    /// display-encoded output before it is stored: above 0, at most 1.
    Error(f64),
    /// The most accurate fast method of every node.
    Exact,
    /// The f64 references themselves, pixel by pixel.
    Reference,
}

impl Tolerance {
    /// Error below which validation warns: smaller ones take very long to certify, and are invisible.
    pub(crate) const CERTIFIABLE: f64 = 1.0 / 4096.0;

    /// Description of the texts that [`Tolerance::parse`] accepts, for messages.
    pub const EXPECTED: &'static str =
        "an error above 0 and at most 1, such as 0.002 or 1/512, or \"exact\" or \"reference\"";

    /// Parses a number, a fraction or a name.
    ///
    /// ```
    /// use trochoid_graph::Tolerance;
    ///
    /// assert_eq!(Tolerance::parse("1/512"), Some(Tolerance::Error(1.0 / 512.0)));
    /// assert_eq!(Tolerance::parse("exact"), Some(Tolerance::Exact));
    /// assert_eq!(Tolerance::parse("0"), None);
    /// ```
    pub fn parse(text: &str) -> Option<Self> {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        match text.trim() {
            "exact" => Some(Self::Exact),
            "reference" => Some(Self::Reference),
            text => match text.split_once('/') {
                Some((over, under)) => Self::error(number(over)? / number(under)?),
                None => Self::error(number(text)?),
            },
        }
    }

    /// Makes a tolerance of an error; `None` unless it is above 0 and at most 1.
    pub fn error(error: f64) -> Option<Self> {
        (error > 0.0 && error <= 1.0).then_some(Self::Error(error))
    }
}

/// Whether a number ≥ 0 is normal and a power of two: its fraction bits are all 0.
fn is_power_of_two(number: f64) -> bool {
    number.is_normal() && number.to_bits() << 12 == 0
}

impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Error(error) => {
                let parts = 1.0 / error;
                let whole = parts.round();
                // Errors are mostly given as 1/n, and shown like that. Powers of two are exact at any size.
                let is_part = (parts - whole).abs() < 1e-9 * whole && whole < 1e5;
                if is_part || is_power_of_two(parts) {
                    if whole == 1.0 { write!(f, "1") } else { write!(f, "1/{whole}") }
                } else {
                    write!(f, "{error:e}")
                }
            }
            Self::Exact => write!(f, "exact"),
            Self::Reference => write!(f, "reference"),
        }
    }
}
