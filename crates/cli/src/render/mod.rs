//! `trochoid render`: documents into files.

mod accuracy;
mod certify;
mod files;
mod job;
mod line;

use crate::failure::Failure;
use crate::files::Files;
use crate::{frames, interrupt, shell};
use job::Job;
use std::path::PathBuf;
use trochoid::{Diagnostic, Form, Guarantee, RunReport, RunStatus, Tolerance};

/// Options of `trochoid render`.
#[derive(Debug, Default, clap::Args)]
#[command(after_help = "\
Paths in a document are relative to it; PATTERN and FILE are relative to the current folder. {output} stands for the \
output's name, #### or %04d for the frame. A certificate is of one image file: of several, name each by {output}.

Examples:
  trochoid render storm.json
  trochoid render storm.json --frames 1-10,20-40x2 --resume
  trochoid render storm.json --output beauty --out 'out/{output}.####.exr'
  trochoid render storm.json --set storm.height=6 --require hull --report report.json
  trochoid render storm.json --frames 1-96 --certificate 'out/storm.####.json'")]
pub(crate) struct Args {
    /// The document
    #[arg(value_name = "GRAPH")]
    graph: PathBuf,
    /// Render this output; may be repeated [default: all outputs]
    #[arg(long, value_name = "NAME")]
    output: Vec<String>,
    /// Frames, such as 1-10,20-40x2 (every second one) or -5--1 [default: all frames of the document]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<String>,
    /// Where files go, such as out/{output}.####.exr [default: as the document says]
    #[arg(short, long, value_name = "PATTERN")]
    out: Option<String>,
    /// Set a knob or port; VALUE is JSON or a bare word, such as storm.height=3; may be repeated
    #[arg(long, value_name = "NODE.KNOB=VALUE")]
    set: Vec<String>,
    /// Number of threads; 0 takes all cores
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
    /// What must hold on every color, or its file is not written (exit code 3); the stricter of this and the
    /// document's own counts
    #[arg(long, value_name = "GUARANTEE", value_parser = ["hull", "box"])]
    require: Option<String>,
    /// Meet this error in every displayed value, such as 1/512, by the cheapest settings that are certified to; or exact, or
    /// reference: the f64 references themselves [default: as the document says]
    #[arg(long, value_name = "ERROR", value_parser = crate::plan::tolerance, allow_hyphen_values = true)]
    tolerance: Option<Tolerance>,
    /// Use the settings of this plan, as `trochoid plan` writes it; certifies nothing
    #[arg(long, value_name = "FILE", conflicts_with = "tolerance")]
    plan: Option<PathBuf>,
    /// Switch every optimization off; no bit of the pictures changes
    #[arg(long)]
    unoptimized: bool,
    /// Write a report of the run as JSON, in folders that are made where there are none; - is stdout
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Certify each image: write as JSON what it was made from, how far it may lie from the f64 references, and hashes of it;
    /// `trochoid verify` checks that
    #[arg(long, value_name = "FILE")]
    certificate: Option<String>,
    /// Write how far each pixel may lie from the f64 references as EXR, with the share of its samples that are ambiguous
    #[arg(long, value_name = "FILE")]
    error: Option<String>,
    /// Skip frames whose files were made from the same document, --set, inputs and frame
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    files: Files,
    /// Print nothing on stdout, and show no progress
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Print one JSON object a frame
    #[arg(long)]
    json: bool,
}

impl Args {
    fn required(&self) -> Option<Guarantee> {
        self.require.as_deref().and_then(Guarantee::from_name)
    }

    fn report_on_stdout(&self) -> bool {
        self.report.as_ref().is_some_and(|path| path.as_os_str() == "-")
    }
}

/// Renders the frames and outputs asked for.
///
/// # Errors
/// Everything that is wrong beforehand, at once; then nothing has been written. Later, what stopped the run, or that a
/// required guarantee was missed.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    run_with(args, &|plan, sink, cache, monitor| match sink {
        Some(sink) => plan.evaluate_to(sink, &trochoid::Buffers::new(), cache, monitor),
        None => plan.evaluate(&trochoid::Buffers::new(), cache, monitor),
    })
}

fn run_with(args: &Args, evaluate: &job::Evaluate<'_>) -> Result<(), Failure> {
    let mut faults = Vec::new();
    if args.json && args.report_on_stdout() {
        faults.push(Failure::usage(
            "found --json and --report -, which both write JSON on stdout; expected one of them",
            "give the report a file",
        ));
    }
    let frames = match args.frames.as_deref().map(frames::parse).transpose() {
        Ok(frames) => frames,
        Err(pieces) => {
            faults.extend(pieces.into_iter().map(|piece| Failure::usage(piece, "write for example 1-10,20-40x2")));
            None
        }
    };
    let loaded = match args.files.load(&args.graph, &args.set) {
        Ok(loaded) => loaded,
        Err(error) => {
            faults.push(error.into());
            return Failure::all(faults);
        }
    };
    shell::tell(&loaded.warnings.iter().map(Diagnostic::to_string).collect::<Vec<_>>());
    let job = Job::new(&loaded.graph, args, frames.clone(), &mut faults);
    Failure::all(faults)?;
    shell::tell(job.warnings().iter().chain(&job.notes()));
    let accuracy = job.accuracy()?;
    // The document again, as its settings then are.
    let settled = if accuracy.set.is_empty() {
        loaded.graph.clone()
    } else {
        let assignments = [&args.set[..], &accuracy.set].concat();
        args.files.load(&args.graph, &assignments).map_err(|error| accuracy.refused(args, error))?.graph
    };
    // It may have been saved anew since.
    let mut faults = Vec::new();
    let job = Job::new(&settled, args, frames, &mut faults).with(accuracy);
    Failure::all(faults)?;
    interrupt::watch()?;
    let mut report = RunReport::new(&settled);
    let outcome = job.run(evaluate, &mut report);
    let status = outcome.as_ref().err().map_or(RunStatus::Done, Failure::status);
    let written = write_report(args, &report, status);
    Failure::all([outcome.err(), written.err()].into_iter().flatten())
}

fn write_report(args: &Args, report: &RunReport, status: RunStatus) -> Result<(), Failure> {
    let Some(path) = &args.report else { return Ok(()) };
    let text = format!("{:#}\n", report.to_json(status));
    if args.report_on_stdout() {
        return shell::print(&text);
    }
    Ok(trochoid::write_guarded(path, text.as_bytes(), Form::Report, args.files.over.overwrite)?)
}

#[cfg(test)]
mod tests;
