//! Errors of the search for settings that meet a tolerance.

use crate::LoadError;
use std::fmt;
use trochoid_engine::{EvalError, PlanError};

/// Reason that no settings were found.
#[derive(Debug, thiserror::Error)]
pub enum TargetError {
    /// The document with the settings is not valid.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The document cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The document cannot be evaluated.
    #[error(transparent)]
    Evaluate(#[from] EvalError),
    /// The most accurate settings miss the tolerance.
    #[error("{0}")]
    Missed(Box<MissedTolerance>),
    /// No error of an output is certified.
    #[error(
        "output \"{output}\": found no sample with a certified error, because {why}; expected a bound to compare with the \
         tolerance"
    )]
    Unknown {
        /// Name of the output.
        output: String,
        /// Pass without an error bound, and the reason.
        why: Uncertain,
    },
    /// No output has values that tolerances apply to.
    #[error("found no output of colors or weights; expected one: tolerances apply to displayed values")]
    NothingDisplayed,
}

/// Why nothing is known of the errors of an output.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Uncertain {
    /// Nowhere is it certain what is seen.
    #[error("what is seen is certain nowhere")]
    Unseen,
    /// A pass has no error bound.
    #[error("\"{node}\" ({ty}) has no error bound: {why}")]
    NoBound {
        /// The pass.
        node: String,
        /// Its type.
        ty: &'static str,
        /// Why it knows none.
        why: &'static str,
    },
}

/// Description of how far the most accurate settings miss a tolerance, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct MissedTolerance {
    /// Tolerance in display-encoded values.
    pub tolerance: f64,
    /// Error that the tolerance allows in the working space.
    pub allowed: f64,
    /// Name of the output.
    pub output: String,
    /// Largest certified error of a sample that is not ambiguous, in the working space.
    pub certified: f64,
    /// Pixel with that error.
    pub pixel: [i64; 2],
    /// Pass with the largest share of the error, and its type; `None` if f32 rounding in all passes limits it.
    pub pass: Option<(String, &'static str)>,
}

impl fmt::Display for MissedTolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { output, certified, pixel: [x, y], allowed, tolerance, .. } = self;
        // Two figures that differ are not printed alike.
        let digits =
            (1..17).find(|digits| format!("{certified:.digits$e}") != format!("{allowed:.digits$e}")).unwrap_or(1);
        let space = if allowed == tolerance { "" } else { " in the working space" };
        write!(
            f,
            "output \"{output}\": found a certified error of {certified:.digits$e}{space} at a sample of pixel \
             ({x}, {y}) with the most accurate methods, "
        )?;
        match &self.pass {
            Some((name, ty)) => write!(f, "limited by the pass \"{name}\" ({ty})")?,
            None => write!(f, "limited by f32 rounding in all passes together")?,
        }
        write!(f, "; expected at most {allowed:.digits$e}")?;
        if allowed == tolerance { Ok(()) } else { write!(f, ", which is {tolerance:.1e} in displayed values") }
    }
}
