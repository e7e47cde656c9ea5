//! `trochoid stability`: compares theory and measurements of the long-term behavior of time-dependent nodes.

mod map;
mod steps;
mod text;

use crate::changes::Changes;
use crate::failure::{FAILED, Failure};
use crate::files::{self, OverwriteOptions};
use crate::remedies;
use crate::shell;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use trochoid::{CheckedGraph, Figure, Form, InputFiles, Loaded, NodeId, Offer, Stability, StepErrors, quoted_path};

/// Options of `trochoid stability`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Measurements run the code that makes pictures, and compute powers of its step in f64, which takes some seconds per \
node. If a measurement contradicts its prediction, the exit code is 1.

Examples:
  trochoid stability -o map.png
  trochoid stability storm.json
  trochoid stability sea.json --steps 100000 -o maps
  trochoid stability storm.json --set sea.c1=0.9 --set sea.c2=0.05 -o maps
  trochoid stability --json")]
pub(crate) struct Args {
    /// The document [default: a ToonSea with default knobs]
    #[arg(value_name = "GRAPH")]
    graph: Option<PathBuf>,
    /// Write the map of each recurrence's coefficients: a .png file for a single map, or a folder for all maps
    #[arg(short, long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Also measure what 32-bit floats lose over N steps, beside 64-bit floats, for the node's settings and others like
    /// them, which takes up to a minute [default N: 10000]; with --out, also plot it, as NODE.steps.png
    #[arg(
        long,
        value_name = "N",
        num_args = 0..=1,
        default_missing_value = "10000",
        value_parser = clap::value_parser!(u64).range(10..=10_000_000)
    )]
    steps: Option<u64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Frame at which keyframed knobs are evaluated [default: the document's first]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<i64>,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    over: OverwriteOptions,
}

/// Document that is analyzed if none is named.
const DEFAULT: &str = r#"{
  "trochoid": 1, "format": { "width": 16, "height": 16 },
  "nodes": {
    "sea": { "type": "ToonSea", "bursts": [{ "path": [1, 1, 1, 2, 2, 2, 2, 1] }] },
    "bake": { "type": "Bake", "sea": "sea" }
  },
  "outputs": { "height": { "field": "bake.height" } }
}"#;

/// Analyzes every time-dependent node.
///
/// # Errors
/// The document is invalid or cannot be read, a map cannot be written, or a measurement contradicts its prediction.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let Loaded { graph, warnings } = match &args.graph {
        Some(path) => trochoid::load(path, &args.changes.assignments())?,
        None => trochoid::parse("the default ToonSea", DEFAULT, Path::new("."), &args.changes.assignments())?,
    };
    shell::tell(&remedies::texts(&warnings));
    if let Some(out) = &args.out {
        if let Some(ending) = out.extension().filter(|_| !is_png(out) && !out.is_dir()) {
            let message = format!(
                "--out {}: found the extension .{}; expected .png or a folder",
                quoted_path(out),
                ending.display()
            );
            return Err(Failure::usage(
                message,
                "use a name such as map.png, or name a folder for the maps of all nodes",
            ));
        }
        let inputs = match &args.graph {
            Some(path) => files::inputs(&graph, path, &args.changes.assignments(), &[]),
            None => InputFiles::new(&graph, &[]),
        };
        Failure::all(named(args, out, &graph).iter().filter_map(|path| args.over.refusal(path, Form::Map, &inputs)))?;
    }
    let frame = args.frame.unwrap_or(graph.frames().0);
    let found = trochoid::stability(&graph, frame);
    let maps = write_maps(args, &graph, &found)?;
    let errors = step_errors(args, &graph, &found, frame)?;
    if args.json {
        shell::print_json(&to_json(&graph, &found, &maps, &errors))?;
    } else {
        shell::print(&text::report(&graph, &found, &maps, &errors))?;
    }
    let contradicted = |(id, report): &(NodeId, Stability)| {
        let name = &graph.node(*id).name;
        let wrong = report.figures.iter().filter(|figure| figure.holds() == Some(false));
        wrong.map(|figure| contradiction(name, figure)).collect::<Vec<_>>()
    };
    Failure::all(found.iter().flat_map(contradicted))
}

fn contradiction(name: &str, figure: &Figure) -> Failure {
    let number = |number: Option<f64>| number.map_or("nothing".into(), text::number);
    let (measured, predicted) = (number(figure.measured), number(figure.predicted));
    Failure::new(FAILED, format!("node \"{name}\", {}: measured {measured}; predicted {predicted}", figure.name.trim()))
}

/// Returns the files that maps and plots may be written to.
fn named(args: &Args, out: &Path, graph: &CheckedGraph) -> Vec<PathBuf> {
    let plot = |name: &str| args.steps.map(|_| plot_of(out, name));
    if is_png(out) {
        return [Some(out.into()), plot("")].into_iter().flatten().collect();
    }
    let mapped = graph.nodes().iter().filter(|node| node.ty.declaration().offers.contains(&Offer::StabilityMap));
    let names: Vec<PathBuf> =
        mapped.flat_map(|node| [Some(map_of(out, &node.name)), plot(&node.name)].into_iter().flatten()).collect();
    // Faults of the folder itself are found even if no node has a map.
    if names.is_empty() { vec![out.join("map.png")] } else { names }
}

/// Returns the file of a node's map in a folder.
fn map_of(out: &Path, name: &str) -> PathBuf {
    out.join(format!("{name}.png"))
}

/// Returns the file of a node's plot of errors in a folder, or beside its map.
fn plot_of(out: &Path, name: &str) -> PathBuf {
    if is_png(out) { out.with_extension("steps.png") } else { out.join(format!("{name}.steps.png")) }
}

/// Whether a path names a picture, not a folder.
fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"))
}

/// Remedy if no node has a map.
const NO_MAP: &str = "omit --out: only the recurrence of a ToonSea has a map";

/// Writes the map of each node that has one; returns their paths.
fn write_maps(
    args: &Args,
    graph: &CheckedGraph,
    found: &[(NodeId, Stability)],
) -> Result<Vec<(NodeId, PathBuf)>, Failure> {
    let Some(out) = &args.out else { return Ok(Vec::new()) };
    let mapped: Vec<_> = found.iter().filter_map(|(id, report)| Some((*id, report.map.as_ref()?))).collect();
    if is_png(out) && mapped.len() != 1 {
        let message = format!("--out {}: found {} nodes with a map; expected one", quoted_path(out), mapped.len());
        let remedy = match mapped.len() {
            0 => NO_MAP,
            _ => "name a folder for all maps",
        };
        return Err(Failure::usage(message, remedy));
    }
    if mapped.is_empty() {
        shell::tell(&[format!(
            "warning: --out {}: found no node with a map; expected at least one; nothing is written there\n  remedy: \
             {NO_MAP}",
            quoted_path(out)
        )]);
    }
    let mut written = Vec::new();
    for (id, map) in mapped {
        let name = &graph.node(id).name;
        let path = if is_png(out) { out.clone() } else { map_of(out, name) };
        map::write(&path, args.over, name, map).map_err(|error| {
            let told = error.downcast_ref().map_or_else(|| error.to_string(), remedies::written);
            Failure::new(FAILED, told)
        })?;
        written.push((id, path));
    }
    Ok(written)
}

/// Errors by steps of a node, and their plot.
type NodeErrors = (NodeId, StepErrors, Option<PathBuf>);

/// Measures the errors by steps of every node that carries a state, if they are requested, and writes their plots.
fn step_errors(
    args: &Args,
    graph: &CheckedGraph,
    found: &[(NodeId, Stability)],
    frame: i64,
) -> Result<Vec<NodeErrors>, Failure> {
    let Some(steps) = args.steps else { return Ok(Vec::new()) };
    let mut measured = Vec::new();
    for (id, _) in found {
        let Some(errors) = trochoid::step_errors_of(graph, *id, frame, steps, &|| false) else { continue };
        let name = &graph.node(*id).name;
        let path = args.out.as_ref().map(|out| plot_of(out, name));
        if let Some(path) = &path {
            steps::write(path, args.over, name, &errors).map_err(|error| {
                let told = error.downcast_ref().map_or_else(|| error.to_string(), remedies::written);
                Failure::new(FAILED, told)
            })?;
        }
        measured.push((*id, errors, path));
    }
    Ok(measured)
}

fn to_json(
    graph: &CheckedGraph,
    found: &[(NodeId, Stability)],
    maps: &[(NodeId, PathBuf)],
    errors: &[NodeErrors],
) -> Value {
    let nodes = found.iter().map(|(id, report)| {
        let figures = report.figures.iter().map(|figure| {
            json!({
                "figure": figure.key,
                "unit": figure.unit,
                "predicted": json_number(figure.predicted),
                "measured": json_number(figure.measured),
                "holds": figure.holds(),
                "note": figure.note,
            })
        });
        let map = maps.iter().find(|(mapped, _)| mapped == id).map(|(_, path)| path.display().to_string());
        let region =
            report.map.as_ref().map(|map| json!({ "axes": map.axes, "point": map.point, "region": map.region }));
        json!({
            "node": graph.node(*id).name,
            "type": graph.node(*id).ty.declaration().name,
            "verdict": report.verdict.name(),
            "says": report.explanation,
            "figures": figures.collect::<Vec<_>>(),
            "plane": region,
            "map": map,
            "steps": errors.iter().find(|(measured, ..)| measured == id).map(|(_, errors, plot)| json!({
                "steps": errors.steps,
                "note": errors.note,
                "groups": errors.groups.iter().map(|group| json!({
                    "name": group.name,
                    "rows": group.rows.iter().map(|row| json!({
                        "setting": row.name,
                        "errors": row.errors.iter().map(|error| json_number(Some(*error))).collect::<Vec<_>>(),
                        "f64": json_number(Some(row.doubt)),
                    })).collect::<Vec<_>>(),
                })).collect::<Vec<_>>(),
                "plot": plot.as_ref().map(|path| path.display().to_string()),
            })),
        })
    });
    json!({ "document": graph.name(), "nodes": nodes.collect::<Vec<_>>() })
}

/// Returns a number as JSON: as a string if it is infinite, since JSON has no infinity.
fn json_number(number: Option<f64>) -> Value {
    match number {
        Some(number) if number.is_finite() => json!(number),
        Some(number) => json!(number.to_string()),
        None => Value::Null,
    }
}
