//! Reasons that a picture cannot be made, below everything that makes one.

use super::lens::LensError;
use trochoid::{EvalError, FormatError, PlanError};

/// Reason that a picture cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The node cannot be viewed.
    #[error(transparent)]
    Lens(#[from] LensError),
    /// The format is invalid.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Planning failed.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Evaluation failed.
    #[error(transparent)]
    Evaluate(#[from] EvalError),
    /// Evaluation panicked.
    #[error(
        "found a fault of Trochoid itself, not of the document: {0}\n  remedy: change what was changed last, and report this with the document"
    )]
    Panic(String),
    /// No picture was made.
    #[error("nothing was evaluated")]
    Nothing,
}

impl PictureError {
    /// Returns the node at fault, if the failure belongs to one.
    pub fn node(&self) -> Option<&str> {
        match self {
            Self::Evaluate(EvalError::Node { node, .. }) => Some(node),
            Self::Lens(LensError::Fault(fault)) => fault.node.as_deref(),
            _ => None,
        }
    }
}
