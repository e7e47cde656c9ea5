//! `trochoid graph`: draws a document's graph as SVG.

use crate::changes::Changes;
use crate::failure::Failure;
use crate::files::{self, OverwriteOptions};
use crate::shell::{self, printable};
use crate::{outputs, warnings};
use std::path::PathBuf;
use trochoid::{CheckedGraph, Form, GENERATOR, Plan, Settings, VERSION, nearest};
use trochoid_diagram::Groups;

/// Options of `trochoid graph`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  trochoid graph storm.json -o storm.svg\n  trochoid graph storm.json --output beauty -o -"
)]
pub(crate) struct Args {
    /// The document
    #[arg(value_name = "GRAPH")]
    graph: PathBuf,
    /// Show only the nodes that this output needs; may be repeated [default: all nodes of the document]
    #[arg(long, value_name = "NAME")]
    output: Vec<String>,
    /// Draw all nodes of groups, instead of one box for each use of a group
    #[arg(long)]
    open: bool,
    /// Draw only the inside of this use of a group, such as front or front/rowers, with what leads into it
    #[arg(long, value_name = "USE", conflicts_with_all = ["open", "output"])]
    inside: Option<String>,
    /// SVG file to write; - means stdout
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    over: OverwriteOptions,
}

/// Draws a document's graph.
///
/// # Errors
/// The document is invalid or cannot be read, has no such output, or the file cannot be written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let loaded = trochoid::load(&args.graph, &args.changes.assignments())?;
    let graph = &loaded.graph;
    let mut faults = Vec::new();
    let chosen = outputs::choose(graph, &args.output, &mut faults);
    let groups = match &args.inside {
        Some(path) => {
            faults.extend(no_use(graph, path));
            Groups::Inside(path)
        }
        None if args.open => Groups::Open,
        None => Groups::Closed,
    };
    let is_stdout = args.out.as_os_str() == "-";
    if !is_stdout {
        faults.extend(files::ending("--out", &args.out, "svg"));
        faults.extend(args.over.refusal(
            &args.out,
            Form::Svg,
            &files::inputs(graph, &args.graph, &args.changes.assignments(), &[]),
        ));
    }
    warnings::after(faults, &warnings::of(graph, &chosen, loaded.warnings))?;
    let shown: &[usize] = if args.output.is_empty() { &[] } else { &chosen };
    let names: Vec<&str> = args.output.iter().map(String::as_str).collect();
    // A graph that cannot be planned because it needs too much memory is still drawn.
    let left_out = match Plan::new(graph, &names, graph.frames().0, &[], &Settings::default()) {
        Ok(plan) => plan.left_out().iter().map(|why| why.as_ref().map(ToString::to_string)).collect(),
        Err(_) => vec![None; graph.nodes().len()],
    };
    let picture = trochoid_diagram::tree(graph, shown, &left_out, groups);
    // A comment at the end is legal, and does not disturb programs that look at the start of the file.
    let picture = format!("{}\n<!-- {GENERATOR}{VERSION} -->\n", picture.trim_end());
    if is_stdout {
        return shell::print(&picture);
    }
    trochoid::write_guarded(&args.out, picture.as_bytes(), Form::Svg, args.over.overwrite)?;
    shell::print(&format!("graph of {} → {}\n", printable(graph.name()), printable(&args.out.display().to_string())))
}

/// Returns the failure if a document has no use of a group with a path.
fn no_use(graph: &CheckedGraph, path: &str) -> Option<Failure> {
    let known: Vec<&str> = graph.groups().iter().map(|used| used.path.as_str()).collect();
    if known.contains(&path) {
        return None;
    }
    let message = format!("--inside {path}: found no such use of a group; expected one of the document's");
    let remedy = match nearest(path, known.iter().copied()) {
        Some(near) => format!("did you mean {near}?"),
        None if known.is_empty() => "leave the option out: the document uses no groups".into(),
        None => format!("uses: {}", known.join(", ")),
    };
    Some(Failure::usage(message, remedy))
}
