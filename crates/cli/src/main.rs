//! `trochoid`: the command line, which renders and checks documents, and describes nodes and images.
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
use std::process::ExitCode;
use trochoid_terminal::{EditArgs, MemoryArgs};

#[global_allocator]
static HEAP: trochoid::Heap = trochoid::Heap;

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
    /// Write what is computed point by point as a shader: GLSL, OSL or MaterialX
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

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are results and go to stdout; a closed pipe is not an error.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { failure::INVALID } else { 0 });
        }
    };
    cli.memory.bound();
    let outcome = match &cli.command {
        Command::Edit(_) => edit::run(),
        Command::Render(args) => render::run(args),
        Command::Join(args) => join::run(args),
        Command::Job(args) => job::run(args),
        Command::Check(args) => check::run(args),
        Command::Graph(args) => graph::run(args),
        Command::Export(args) => export::run(args),
        Command::Preview(args) => preview::run(args),
        Command::Sheet(args) => sheet::run(args),
        Command::Stability(args) => stability::run(args),
        Command::Nodes(args) => nodes::run(args),
        Command::Schema => schema::run(),
        Command::Info(args) => info::run(args),
        Command::Palette(args) => palette::run(args),
        Command::Decompose(args) => decompose::run(args),
        Command::Recolor(args) => recolor::run(args),
        Command::Page(args) => page::run(args),
        Command::Fit(args) => fit::run(args),
        Command::Blame(args) => blame::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Report(args) => report::run(args),
        Command::Verify(args) => verify::run(args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            shell::tell(&failure.messages);
            ExitCode::from(failure.code)
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
