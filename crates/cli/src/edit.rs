//! `trochoid edit`: the graph editor.

use crate::failure::{FAILED, Failure};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The document; a new one if none is named
    graph: Option<PathBuf>,
}

pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    trochoid_editor::open(args.graph.as_deref()).map_err(|error| Failure::new(FAILED, error))
}
