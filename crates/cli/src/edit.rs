//! `trochoid edit`: the graph editor.

use crate::failure::{FAILED, Failure};
use crate::files::Reach;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The document; a new one if none is named
    graph: Option<PathBuf>,
    /// Let documents of this run read and write this file, or what lies beneath this folder; may be repeated [default: beneath
    /// their own folder and, where that lies beneath the current one, beneath that, and what they were allowed in the editor]
    #[arg(long, value_name = "PATH")]
    allow: Vec<PathBuf>,
}

pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    Reach { allow: args.allow.clone(), strict: false }.warn();
    trochoid_editor::open(args.graph.as_deref(), &args.allow).map_err(|error| Failure::new(FAILED, error))
}
