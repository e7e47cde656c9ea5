//! `trochoid-editor`: the graph editor, as started by `trochoid edit`.
//!
//! Exit codes: 0 if the window was closed; 1 if the document cannot be read, there is no display, or memory ran out; 2
//! for a usage error.

use clap::Parser;
use std::process::ExitCode;
use trochoid_terminal::{EditArgs, FAILED, INVALID, MemoryArgs, missing, tell};

#[global_allocator]
static HEAP: trochoid::Heap = trochoid::Heap;

/// The graph editor of Trochoid
#[derive(Debug, Parser)]
#[command(name = "trochoid-editor", version = trochoid::VERSION, max_term_width = 100)]
struct Cli {
    #[command(flatten)]
    edit: EditArgs,
    #[command(flatten)]
    memory: MemoryArgs,
}

fn main() -> ExitCode {
    let Cli { edit, memory } = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are regular output and go to stdout; a closed pipe is not an error.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { INVALID } else { 0 });
        }
    };
    memory.bound();
    tell(&missing(&edit.allow));
    match trochoid_editor::open(edit.graph.as_deref(), &edit.allow) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell(&[format!("error: {error}")]);
            ExitCode::from(FAILED)
        }
    }
}
