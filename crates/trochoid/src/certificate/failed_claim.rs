//! Failures of a check.

use std::fmt;

/// Claim of a certificate that does not hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FailedClaim {
    /// Place of the failure.
    pub place: String,
    /// Value that was found there.
    pub found: String,
    /// Value of the certificate or of the references.
    pub expected: String,
}

impl fmt::Display for FailedClaim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: found {}; expected {}", self.place, self.found, self.expected)
    }
}
