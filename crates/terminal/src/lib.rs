//! What the command line and the editor's program share: how they speak on a terminal, the options that both take, and how
//! much memory they may have.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

mod allow;
mod memory;
mod tell;

pub use allow::warn_of_missing;
pub use memory::{MemoryArgs, enough_memory};
pub use tell::{printable, tell};

/// The exit code where input or output failed, input data are bad, or the evaluation failed.
pub const FAILED: u8 = 1;
/// The exit code of wrong usage and of invalid documents.
pub const INVALID: u8 = 2;

/// Arguments of the editor, shared by `trochoid edit` and the editor's own program.
#[derive(Debug, clap::Args)]
pub struct EditArgs {
    /// The document; a new one if none is named
    pub graph: Option<std::path::PathBuf>,
    /// Let documents of this run read and write this file, or what lies beneath this folder; may be repeated [default: beneath
    /// their own folder and, where that lies beneath the current one, beneath that, and what they were allowed in the editor]
    #[arg(long, value_name = "PATH")]
    pub allow: Vec<std::path::PathBuf>,
}
