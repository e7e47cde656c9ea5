//! How accurate a picture is asked to be.

use std::fmt;

/// The accuracy that is asked for, in place of settings that give it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// The largest error in any channel of any sample that is in no doubt, of the display-encoded output before it is stored:
    /// above 0, at most 1.
    Error(f64),
    /// The most accurate of the fast methods everywhere.
    Exact,
    /// The f64 references themselves, pixel by pixel.
    Reference,
}

impl Tolerance {
    /// Smaller errors take very long to certify, and none of them is seen.
    pub(crate) const FINE: f64 = 1.0 / 4096.0;

    /// What [`Tolerance::parse`] takes.
    pub const EXPECTED: &'static str =
        "an error above 0 and at most 1, such as 0.002 or 1/512, or \"exact\" or \"reference\"";

    /// From a number, a fraction, or a name.
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

    /// An error, if it is one to ask for.
    pub fn error(error: f64) -> Option<Self> {
        (error > 0.0 && error <= 1.0).then_some(Self::Error(error))
    }
}

/// Whether a normal number ≥ 0 is a power of two: nothing stands in its fraction.
fn is_power_of_two(number: f64) -> bool {
    number.is_normal() && number.to_bits() << 12 == 0
}

impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Error(error) => {
                let parts = 1.0 / error;
                let whole = parts.round();
                // As it was asked for, most often: parts of a whole. Halves of halves are such parts however small they are.
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
