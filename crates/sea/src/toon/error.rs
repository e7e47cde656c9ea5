parameters! {
    /// A parameter of a toon sea.
    ToonParameter {
        Columns = "columns",
        Rows = "rows",
        Cells = "columns × rows",
        Spacing = "spacing",
        Rate = "rate",
        Speed = "speed",
        Damping = "damping",
        Frequency = "frequency",
        Push = "push",
        Injection = "injection",
        RiftDistance = "rift distance",
        RiftGain = "rift gain",
        RiftDecay = "rift decay",
        DriftReach = "drift reach",
        DriftLag = "drift lag",
        DriftDecay = "drift decay",
        DriftRenewal = "drift renewal",
        DriftPeriod = "drift period",
        Bursts = "number of bursts",
        ControlPoint = "control point",
        Duration = "duration",
        Offset = "offset",
        Height = "height",
        Peak = "peak",
        Influence = "influence",
        Fade = "fade",
        Lane = "lane",
        Active = "active",
        BodyLength = "length of a body",
        BodyBeam = "beam of a body",
        BodyDraught = "draught of a body",
    }
}

/// Why a toon sea is rejected.
#[derive(Clone, Debug, PartialEq)]
pub enum ToonError {
    /// A number is outside of its range.
    Range {
        /// Name of the parameter.
        parameter: ToonParameter,
        /// Index among all bursts of the sea, if it belongs to a burst.
        burst: Option<usize>,
        /// Its value.
        found: f64,
        /// Accepted values.
        expected: &'static str,
    },
    /// The height field would grow without bound.
    Unstable(Instability),
    /// M^τ is not real, so the motion cannot be resampled.
    NotResampled {
        /// The coefficients.
        found: [f64; 2],
    },
}

impl std::fmt::Display for ToonError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unstable(instability) => instability.fmt(f),
            Self::Range { .. } | Self::NotResampled { .. } => {
                write!(f, "{}; expected {}", self.found(), self.expected())
            }
        }
    }
}

impl ToonError {
    /// Returns what was found.
    pub fn found(&self) -> String {
        match self {
            Self::Range { parameter, found, .. } => format!("{parameter} {found}"),
            Self::Unstable(instability) => instability.found(),
            Self::NotResampled { found: [c1, c2] } => format!(
                "c1 {c1}, c2 {c2}, which cannot be resampled: some mode changes its sign at every step, so that half a \
                 step has no real value"
            ),
        }
    }

    /// Returns what is accepted instead.
    pub fn expected(&self) -> &'static str {
        match self {
            Self::Range { expected, .. } => expected,
            Self::Unstable(_) => Instability::EXPECTED,
            Self::NotResampled { .. } => "0 < c1 < 1 and c2 of 0 or more, or the literal motion",
        }
    }

    /// Returns the same error for a burst, by its index among all bursts.
    pub fn of_burst(self, index: usize) -> Self {
        match self {
            Self::Range { parameter, found, expected, .. } => {
                Self::Range { parameter, burst: Some(index), found, expected }
            }
            other => other,
        }
    }
}

impl std::error::Error for ToonError {}

/// Accepts finite values within closed bounds; rejects anything else, including NaN, by name.
pub(crate) fn within(
    parameter: ToonParameter,
    found: f64,
    (low, high): (f64, f64),
    expected: &'static str,
) -> Result<(), ToonError> {
    if found.is_finite() && found >= low && found <= high {
        Ok(())
    } else {
        Err(ToonError::Range { parameter, burst: None, found, expected })
    }
}

/// A recurrence that grows without bound, and the nearest one that does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instability {
    /// The coefficients c₁, c₂.
    pub found: [f64; 2],
    /// Factor by which the fastest mode grows per step.
    pub growth: f64,
    /// The nearest stable coefficients, to four decimals.
    pub nearest: [f64; 2],
}

impl Instability {
    /// Accepted coefficients.
    pub(crate) const EXPECTED: &str = "|c1| ≤ 1 and |2·c1·λ + c2| ≤ 1 + c1 for each mode λ of the grid";

    /// Returns what was found.
    pub(crate) fn found(&self) -> String {
        let [c1, c2] = self.found;
        let growth = match self.growth - 1.0 {
            // A double root on the edge.
            none if none < 1e-15 => "evenly, step by step".into(),
            slow if slow < 1e-3 => format!("by 1 + {slow:.1e} a step"),
            _ => format!("by {:.4} a step", self.growth),
        };
        format!("c1 {c1}, c2 {c2}, with which the sea grows {growth}")
    }
}

impl std::fmt::Display for Instability {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([c1, c2], found, expected) = (self.nearest, self.found(), Self::EXPECTED);
        write!(f, "{found}; expected {expected}; the nearest that holds: c1 {c1:.4}, c2 {c2:.4}")
    }
}
