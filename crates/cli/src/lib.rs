//! The command line `trochoid`, which renders and checks documents, and describes nodes and images: the program itself
//! ([`main`]), and its commands within another program ([`run`]).
//!
//! Results go to stdout, everything else to stderr. Exit codes: 0 success; 1 input, output or the evaluation failed, or
//! input data are bad; 2 wrong usage or an invalid document; 3 a required guarantee or tolerance is not met, or a
//! certificate does not hold; 130 interrupted.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

mod blame;
mod changes;
mod check;
mod decompose;
mod edit;
mod explain;
mod export;
mod failure;
mod files;
mod fit;
mod frames;
mod graph;
mod host;
mod info;
mod interrupt;
mod job;
mod join;
mod nodes;
mod outputs;
mod page;
mod palette;
mod plan;
mod preview;
mod progress;
mod recolor;
mod remedies;
mod render;
mod report;
mod scale;
mod schema;
mod sheet;
mod shell;
mod shown;
mod stability;
mod verify;
mod warnings;
mod wedge;

use clap::{Parser, Subcommand};
use failure::{Failure, INVALID};
pub use host::{Host, Outcome};
use std::ffi::OsString;
use std::process::ExitCode;
use std::sync::Arc;
use trochoid_terminal::{EditArgs, MemoryArgs};

/// A compositor whose pictures cannot leave their palette, with the sea built in
#[derive(Debug, Parser)]
#[command(
    name = "trochoid",
    version = trochoid::VERSION,
    max_term_width = 100,
    after_help = "Exit codes:\n  \
        0    success\n  \
        1    input, output or the evaluation failed, or input data are bad\n  \
        2    wrong usage, or an invalid document\n  \
        3    a required guarantee or tolerance is not met, or a certificate does not hold\n  \
        130  interrupted\n\n\
        Examples:\n  \
        trochoid check storm.json\n  \
        trochoid render storm.json --frames 1-96\n  \
        trochoid nodes GerstnerSea"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    memory: MemoryArgs,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Open the graph editor
    Edit(EditArgs),
    /// Render outputs of a document to files
    Render(Box<render::Args>),
    /// Join tiles of a picture to the whole
    Join(join::Args),
    /// Write the folder with which a render farm takes a document's frames: Open Job Description or Slurm
    Job(job::Args),
    /// Check a document: print faults, guarantees, and the nodes that are left out
    Check(check::Args),
    /// Draw a document's graph, with its control colors, as SVG
    Graph(graph::Args),
    /// Write what is computed point by point as a shader: GLSL, OSL, MaterialX or WGSL
    Export(export::Args),
    /// Render an output small: as a movie (MP4), an animated WebP, one PNG or a sequence of them
    Preview(preview::Args),
    /// Draw a contact sheet: frames, documents, or values of a knob, side by side with captions
    Sheet(sheet::Args),
    /// Analyze the long-term stability of seas: what is stable, by how much, and what would break it
    Stability(stability::Args),
    /// List the node types, or print the manual of one
    Nodes(nodes::Args),
    /// Print the JSON Schema of documents
    Schema,
    /// Describe an image file: parts, layers, channels and their value ranges
    Info(info::Args),
    /// Find few colors whose hull encloses every pixel of pictures
    Palette(palette::Args),
    /// Take pictures apart into weights over the colors of a palette
    Decompose(decompose::Args),
    /// Paint what was taken apart in other colors
    Recolor(recolor::Args),
    /// Put recipes into one HTML file, whose colors can be changed in any browser
    Page(page::Args),
    /// Find the colors in which a picture comes nearest to a painting
    Fit(fit::Args),
    /// Tell which colors a pixel is mixed from, and how much of each
    Blame(blame::Args),
    /// Find the settings that meet a tolerance
    Plan(plan::Args),
    /// Compare settings by error and run time, as a page of plots
    Report(report::Args),
    /// Check a certificate and its image against the f64 references
    Verify(verify::Args),
}

/// Runs the program with the arguments of the process, prints, and returns its exit code. The process's allocator should be
/// [`trochoid::Heap`], which bounds its memory.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are results and go to stdout; a closed pipe is not an error.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { INVALID } else { 0 });
        }
    };
    cli.memory.bound();
    // Frames follow each other, and take the same memory.
    trochoid::Heap::keep_freed();
    ExitCode::from(ended(cli.command.run()))
}

/// Runs a command within another program, such as `["check", "storm.json", "--json"]`.
///
/// Nothing is printed, drawn or ended, no signal is watched, and no memory is bound: `--memory` only limits what is
/// planned while the run lasts. Relative paths are relative to the current folder. Runs come one after another in a
/// process; a second one waits. All commands but `edit`, which replaces the process, can be run.
///
/// ```
/// use std::sync::Arc;
///
/// struct Patient;
/// impl trochoid_cli::Host for Patient {}
///
/// let outcome = trochoid_cli::run(["nodes", "Mix"], Arc::new(Patient));
/// assert_eq!(outcome.code, 0);
/// assert!(outcome.text.starts_with("Mix"));
/// ```
pub fn run(arguments: impl IntoIterator<Item = impl Into<OsString>>, host: Arc<dyn Host>) -> Outcome {
    let arguments = arguments.into_iter().map(Into::into);
    let cli = match Cli::try_parse_from([OsString::from("trochoid")].into_iter().chain(arguments)) {
        Ok(cli) => cli,
        Err(error) => {
            let text = error.render().to_string();
            return if error.use_stderr() {
                Outcome { code: INVALID, messages: vec![text.trim_end().into()], ..Outcome::default() }
            } else {
                Outcome { text, ..Outcome::default() }
            };
        }
    };
    host::hosted(host, || {
        let _limit = cli.memory.limit_for_now();
        files::warn_anew();
        ended(cli.command.run())
    })
}

/// Tells of a failure; returns the exit code.
fn ended(outcome: Result<(), Failure>) -> u8 {
    match outcome {
        Ok(()) => 0,
        Err(failure) => {
            shell::tell(&failure.messages);
            failure.code
        }
    }
}

impl Command {
    fn run(&self) -> Result<(), Failure> {
        match self {
            Self::Edit(_) => edit::run(),
            Self::Render(args) => render::run(args),
            Self::Join(args) => join::run(args),
            Self::Job(args) => job::run(args),
            Self::Check(args) => check::run(args),
            Self::Graph(args) => graph::run(args),
            Self::Export(args) => export::run(args),
            Self::Preview(args) => preview::run(args),
            Self::Sheet(args) => sheet::run(args),
            Self::Stability(args) => stability::run(args),
            Self::Nodes(args) => nodes::run(args),
            Self::Schema => schema::run(),
            Self::Info(args) => info::run(args),
            Self::Palette(args) => palette::run(args),
            Self::Decompose(args) => decompose::run(args),
            Self::Recolor(args) => recolor::run(args),
            Self::Page(args) => page::run(args),
            Self::Fit(args) => fit::run(args),
            Self::Blame(args) => blame::run(args),
            Self::Plan(args) => plan::run(args),
            Self::Report(args) => report::run(args),
            Self::Verify(args) => verify::run(args),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }
}
