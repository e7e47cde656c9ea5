//! Shared by the command line and the editor program: terminal messages, common options, and the memory limit.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

mod allow;
mod memory;
mod tell;

pub use allow::missing;
pub use memory::{Limited, MemoryArgs, SizeError, enough_memory, size};
pub use tell::{printable, tell};

/// Exit code if input or output failed, input data is invalid, or the evaluation failed.
pub const FAILED: u8 = 1;
/// Exit code for wrong usage and invalid documents.
pub const INVALID: u8 = 2;

/// Options of the editor, for `trochoid edit` and the editor's own program.
#[derive(Debug, clap::Args)]
pub struct EditArgs {
    /// Document to open; a new document if omitted
    pub graph: Option<std::path::PathBuf>,
    /// Let documents of this run read and write this file, or what lies beneath this folder; may be repeated [default: beneath
    /// their own folder and, where that lies beneath the current one, beneath that, and what they were allowed in the editor]
    #[arg(long, value_name = "PATH")]
    pub allow: Vec<std::path::PathBuf>,
}
