//! Why no settings meet a tolerance.

use crate::LoadError;
use std::fmt;
use trochoid_engine::{EvalError, PlanError};

/// Why there are no such settings.
#[derive(Debug, thiserror::Error)]
pub enum TargetError {
    /// The document with the settings is not valid.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// There is no plan.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// It cannot be evaluated.
    #[error(transparent)]
    Evaluate(#[from] EvalError),
    /// The most accurate settings miss it.
    #[error("{0}")]
    Missed(Box<Missed>),
    /// Nothing is known of the errors of an output.
    #[error(
        "output \"{output}\": found no sample whose error is certain, since {why}; expected a bound to hold against the \
         tolerance"
    )]
    Unknown {
        /// The output.
        output: String,
        /// Why.
        why: Uncertain,
    },
    /// No output has errors that a tolerance speaks of.
    #[error("found no output of colors or weights; expected one: a tolerance speaks of what is displayed")]
    NothingDisplayed,
}

/// Why nothing is known of the errors of an output.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Uncertain {
    /// Nowhere is it certain what is seen.
    #[error("what is seen is certain nowhere")]
    Unseen,
    /// A pass knows no bound.
    #[error("\"{node}\" ({ty}) knows no bound: {why}")]
    NoBound {
        /// The pass.
        node: String,
        /// Its type.
        ty: &'static str,
        /// Why it knows none.
        why: &'static str,
    },
}

/// By how much the most accurate settings miss a tolerance, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Missed {
    /// The tolerance, in display-encoded values.
    pub tolerance: f64,
    /// What it allows in the working space.
    pub allowed: f64,
    /// The output.
    pub output: String,
    /// The largest certified error of a sample in no doubt, in the working space.
    pub certified: f64,
    /// Where.
    pub pixel: [i64; 2],
    /// The pass that makes most of it, with its type; `None` where it is the rounding of f32 all over the graph.
    pub pass: Option<(String, &'static str)>,
}

impl fmt::Display for Missed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { output, certified, pixel: [x, y], allowed, .. } = self;
        write!(
            f,
            "output \"{output}\": found {certified:.1e} certified at pixel ({x}, {y}) by the most accurate methods, "
        )?;
        match &self.pass {
            Some((name, ty)) => write!(f, "limited by the pass \"{name}\" ({ty})")?,
            None => write!(f, "limited by the rounding of f32 in all passes together")?,
        }
        write!(f, "; expected at most {allowed:.1e}")
    }
}
