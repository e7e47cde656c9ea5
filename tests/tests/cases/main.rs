//! Cases that lie in files, each a test by the name of its file: `cargo test -p trochoid-tests -- nodes/Mix`.
//!
//! The same tests write the files beside them that are not written by hand: with `TROCHOID_UPDATE=1` in the
//! environment, sheets and messages are stored as found.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod ends;
mod extremes;
mod memory;
mod messages;
mod nodes;
mod sheet;
#[path = "../support/stored.rs"]
mod stored;
#[allow(dead_code, reason = "the other tests use the rest")]
#[path = "../support/mod.rs"]
mod support;

use libtest_mimic::{Arguments, Trial};
use std::process::ExitCode;

/// Returns the test of a case, named by its folder and file.
fn trial(folder: &str, name: &str, holds: impl FnOnce() -> Result<(), String> + Send + 'static) -> Trial {
    Trial::test(format!("{folder}/{name}"), move || Ok(holds()?))
}

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let trials = [nodes::trials(), ends::trials(), extremes::trials(), memory::trials(), messages::trials()];
    libtest_mimic::run(&arguments, trials.into_iter().flatten().collect()).exit_code()
}
