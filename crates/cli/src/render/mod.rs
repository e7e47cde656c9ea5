//! `trochoid render`: renders documents to files.

mod accuracy;
mod args;
mod certify;
mod chosen;
mod files;
mod job;
mod line;
mod store;
mod tally;
mod written;

use crate::failure::Failure;
use crate::scale::scaled;
use crate::{frames, interrupt, progress, shell, warnings};
pub(crate) use args::Args;
use chosen::Chosen;
use job::Job;
use trochoid::{CheckedGraph, Diagnostic, Form, Loaded, RunReport, RunStatus};

/// Renders the requested frames and outputs.
///
/// # Errors
/// All problems that can be found in advance, together, before anything is written; or the problem that stopped the
/// run, or a missed guarantee.
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
            "write the report to a file",
        ));
    }
    let frames = match args.frames.as_deref().map(frames::parse).transpose() {
        Ok(frames) => frames,
        Err(pieces) => {
            faults.extend(pieces.into_iter().map(|piece| Failure::usage(piece, "use a list such as 1-10,20-40x2")));
            None
        }
    };
    let (graph, warned) = match load(args, &args.assignments()) {
        Ok(loaded) => loaded,
        Err(failure) => return Failure::all(faults.into_iter().chain([failure])),
    };
    let chosen = Chosen::new(graph.clone(), args, &mut faults);
    let job = Job::new(&chosen, args, frames.clone(), &mut faults);
    warnings::after(faults, &warnings::of(&graph, &chosen.outputs, warned))?;
    shell::tell(job.warnings().iter().chain(&job.notes()));
    let accuracy = job.accuracy()?;
    // The document is loaded again with the chosen settings.
    let settled = if accuracy.set.is_empty() {
        graph
    } else {
        let assignments = [&args.assignments()[..], &accuracy.set].concat();
        let loaded = args.files.load(&args.graph, &assignments).map_err(|error| accuracy.refused(args, error))?;
        scaled(loaded.graph, args.scale)?
    };
    // The document may have changed on disk since it was first loaded.
    let mut faults = Vec::new();
    let chosen = Chosen::new(settled, args, &mut faults);
    let job = Job::new(&chosen, args, frames, &mut faults).with(accuracy);
    Failure::all(faults)?;
    interrupt::watch()?;
    let store = args.store.open()?;
    let mut report = RunReport::new(&chosen.graph);
    let outcome = job.run(evaluate, store::cache(store.as_ref()), &mut report);
    let notes = store.map_or_else(Vec::new, |store| store::notes(&store));
    shell::tell(notes.iter().filter(|note| !args.quiet || !note.starts_with("note:")));
    if let Some(message) = outcome.as_ref().err().and_then(|failure| failure.messages.first()) {
        progress::failed(args.progress, message.text());
    }
    let status = outcome.as_ref().err().map_or(RunStatus::Done, Failure::status);
    let written = write_report(args, &report, status);
    Failure::all([outcome.err(), written.err()].into_iter().flatten())
}

/// Loads the document at the size of the run, with its warnings.
fn load(args: &Args, assignments: &[String]) -> Result<(CheckedGraph, Vec<Diagnostic>), Failure> {
    let Loaded { graph, warnings } = args.files.load(&args.graph, assignments)?;
    Ok((scaled(graph, args.scale)?, warnings))
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
