//! `trochoid check`: prints a document's diagnostics, guarantees, omitted nodes, and notes.

use crate::changes::Changes;
use crate::explain::{self, Explanation};
use crate::failure::{Failure, INVALID, Message, count, once};
use crate::files::{self, AccessOptions};
use crate::outputs::choose;
use crate::shell::{self, HEADING, printable, wrap};
use crate::{remedies, warnings};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;
use trochoid::{
    Access, CheckedGraph, Diagnostic, Guarantee, LeftOut, LoadError, Loaded, MemoryAccount, MemoryConsumer, NodeId,
    OutputError, Pictures, Plan, Settings, Severity, UNNAMED_FILE, guarantee, in_bytes,
};

/// Options of `trochoid check`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  trochoid check storm.json\n  trochoid check storm.json --strict --set storm.height=6\n  \
                  trochoid check storm.json --json\n  trochoid check storm.json --explain --measure"
)]
pub(crate) struct Args {
    /// The document
    #[arg(value_name = "GRAPH")]
    graph: PathBuf,
    /// Explain for each output which nodes are evaluated and which are left out, with the proof; prepares the frame,
    /// so it opens files
    #[arg(long)]
    explain: bool,
    /// With --explain: evaluate the frame at reduced size, and measure each node's time with and without leaving work
    /// out
    #[arg(long, requires = "explain")]
    measure: bool,
    /// With --explain: explain only this output; may be repeated [default: all outputs]
    #[arg(long, value_name = "NAME", requires = "explain")]
    output: Vec<String>,
    /// Frame to check [default: the document's first]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<i64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Allow the document to read and write this file, or anything under this folder, as for `render`; may be repeated
    #[arg(long, value_name = "PATH")]
    allow: Vec<PathBuf>,
    /// Treat warnings as errors (exit code 2), and restrict the document to its own folder, as for `render`
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    changes: Changes,
}

/// Checks a document and prints what was found.
///
/// # Errors
/// The document is invalid (or warned of, with `--strict`), or cannot be read.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let reach = AccessOptions { allow: args.allow.clone(), strict: args.strict };
    let mut loaded = match reach.load(&args.graph, &args.changes.assignments()) {
        Ok(loaded) => loaded,
        Err(LoadError::Invalid(diagnostics)) if args.json => {
            let name = args.graph.display().to_string();
            let diagnostics = remedies::values(&diagnostics);
            shell::print_json(&json!({ "document": name, "valid": false, "diagnostics": diagnostics }))?;
            return Err(Failure::silent(INVALID));
        }
        Err(error) => return Err(error.into()),
    };
    loaded.warnings.extend(trochoid::missing_files(&loaded.graph));
    let (first, last) = loaded.graph.frames();
    let all: Vec<usize> = (0..loaded.graph.outputs().len()).collect();
    let frames: Vec<i64> = (first..=last).take(FRAMES_CHECKED).collect();
    let graph = &loaded.graph;
    let outside =
        [trochoid::refused_files(graph, &all, &frames), trochoid::refused_outputs(graph, &all, &frames)].concat();
    let outside = reach.faults(graph, &outside);
    // `outside` reports forbidden destinations already.
    let named = graph.clone().with_access(Access::everything());
    let written =
        frames.iter().find_map(|&frame| trochoid::output_files(&named, &all, frame, first != last, None).err());
    let inputs = files::inputs(graph, &args.graph, &args.changes.assignments(), &[]);
    let files =
        frames.iter().filter_map(|&frame| trochoid::output_files(&named, &all, frame, first != last, None).ok());
    let over = files.flatten().map(|file| file.path).find(|path| inputs.contains(path));
    let faults = FileFaults { outside, written, over };
    if faults.any() {
        return Err(faults.told(args)?);
    }
    let refused = args.strict && !loaded.warnings.is_empty();
    let frame = args.frame.unwrap_or(first);
    let mut findings = PlanFindings::of(&loaded.graph, frame);
    let explained = explained(args, &loaded.graph, frame, &findings)?;
    if args.json {
        let mut json = to_json(&loaded, &findings, !refused && findings.can_be_rendered());
        if let Some(explained) = &explained {
            json["explained"] = explained.iter().map(Explanation::to_json).collect();
        }
        shell::print_json(&json)?;
    } else {
        let mut text = to_text(&loaded, &findings, explained.is_none());
        explained.iter().flatten().for_each(|explained| text.push_str(&explained.to_text()));
        shell::print(&text)?;
        warnings::after(std::mem::take(&mut findings.faults), &loaded.warnings)?;
    }
    if (refused || !findings.can_be_rendered()) && args.json {
        return Err(Failure::silent(INVALID));
    }
    if refused {
        let found = count(Severity::Warning, loaded.warnings.len());
        let remedy = "fix the warnings, or omit --strict";
        return Err(Failure::usage(
            format!("found {found}; expected none: --strict treats warnings as errors"),
            remedy,
        ));
    }
    Ok(())
}

/// Maximum number of frames whose file names are checked.
const FRAMES_CHECKED: usize = 10_000;

/// Problems with the files that a valid document names.
struct FileFaults {
    /// Files that the document reads or writes without permission.
    outside: Vec<Diagnostic>,
    /// Reason that the outputs cannot be written.
    written: Option<OutputError>,
    /// Input that an output would overwrite.
    over: Option<PathBuf>,
}

impl FileFaults {
    fn any(&self) -> bool {
        !self.outside.is_empty() || self.written.is_some() || self.over.is_some()
    }

    /// Prints the problems if JSON is requested; returns the failure that ends the command.
    fn told(self, args: &Args) -> Result<Failure, Failure> {
        let Self { outside, written, over } = self;
        if !args.json {
            let mut all = Failure::from(LoadError::Invalid(once(outside)));
            written.into_iter().for_each(|error| all.join(error.into()));
            over.into_iter().for_each(|path| all.join(files::written_over(&path)));
            return Ok(all);
        }
        let mut faults = remedies::values(&outside);
        let fault = |found: String, remedy: &str| json!({ "severity": "error", "port": "outputs", "found": found, "remedy": remedy });
        match written {
            Some(OutputError::Pattern(names)) => {
                faults.extend(names.iter().map(|name| {
                    let (found, remedy) = remedies::name(name, "--out");
                    fault(found, &remedy)
                }));
            }
            other => faults.extend(other.map(|error| fault(error.to_string(), ""))),
        }
        faults.extend(over.map(|path| {
            let found = format!("{}: is an input of the document and would be overwritten", path.display());
            fault(found, files::ANOTHER_NAME)
        }));
        let name = args.graph.display().to_string();
        shell::print_json(&json!({ "document": name, "valid": false, "diagnostics": faults }))?;
        Ok(Failure::silent(INVALID))
    }
}

/// Returns the explanations that `--explain` requests.
fn explained<'g>(
    args: &Args,
    graph: &'g CheckedGraph,
    frame: i64,
    findings: &PlanFindings,
) -> Result<Option<Vec<Explanation<'g>>>, Failure> {
    if !args.explain || !findings.can_be_rendered() {
        return Ok(None);
    }
    let mut faults = Vec::new();
    let outputs = choose(graph, &args.output, &mut faults);
    Failure::all(faults)?;
    outputs
        .into_iter()
        .map(|output| explain::explain(graph, output, frame, args.measure))
        .collect::<Result<_, _>>()
        .map(Some)
}

/// Results of planning all outputs at a frame.
struct PlanFindings {
    frame: i64,
    /// Reason that each node is left out, by node.
    left_out: Vec<Option<LeftOut>>,
    /// Notes of the nodes that are not left out.
    notes: Vec<(NodeId, Vec<String>)>,
    /// Memory that the frame needs.
    memory: Option<MemoryAccount>,
    /// Reasons that no plan could be made, or that the planned frame cannot be evaluated.
    faults: Vec<Failure>,
}

impl PlanFindings {
    fn can_be_rendered(&self) -> bool {
        self.faults.is_empty()
    }

    fn of(graph: &CheckedGraph, frame: i64) -> Self {
        match Plan::new(graph, &[], frame, &[], &Settings::default()) {
            Ok(plan) => {
                let account = plan.memory(pictures(graph));
                let faults = plan.check_headers().into_iter().chain(plan.check_memory(&account).err());
                // Here a document that cannot be rendered is invalid, whatever exit code a run would have.
                let place = format!("frame {frame}: ");
                let invalid = |error| Failure { code: INVALID, ..Failure::evaluated(&place, &error) };
                Self {
                    frame,
                    left_out: plan.left_out().to_vec(),
                    notes: plan.notes().into_iter().chain(plan.file_notes()).collect(),
                    faults: faults.map(invalid).collect(),
                    memory: Some(account),
                }
            }
            Err(error) => {
                let all = (0..graph.nodes().len()).map(NodeId);
                let notes = all.map(|id| (id, graph.settle(id, frame).node().notes(graph.times())));
                let notes = notes.filter(|(_, notes)| !notes.is_empty()).collect();
                Self {
                    frame,
                    left_out: vec![None; graph.nodes().len()],
                    notes,
                    memory: None,
                    faults: vec![Failure::new(INVALID, error)],
                }
            }
        }
    }
}

/// Returns how pictures are delivered: row by row if all output files are EXR, as whole pictures otherwise.
fn pictures(graph: &CheckedGraph) -> Pictures {
    let is_exr = |file: &String| file.to_ascii_lowercase().ends_with(".exr");
    let streamed = graph.outputs().iter().filter_map(|output| output.file.as_ref()).all(is_exr);
    if streamed { Pictures::Rows } else { Pictures::Files }
}

fn to_text(loaded: &Loaded, findings: &PlanFindings, with_left_out: bool) -> String {
    let graph = &loaded.graph;
    let (format, (first, last)) = (graph.format(), graph.frames());
    let warnings = match loaded.warnings.len() {
        0 => String::new(),
        number => format!(", {}", count(Severity::Warning, number)),
    };
    let verdict = if findings.can_be_rendered() { "valid" } else { "cannot be rendered" };
    let mut text = format!("{HEADING}{}{HEADING:#}: {verdict}{warnings}\n", printable(graph.name()));
    let samples = match format.samples() {
        1 => "1 sample per pixel".into(),
        samples => format!("{samples} samples per pixel"),
    };
    let _ = writeln!(text, "  {} × {} pixels, {samples}, {}", format.width(), format.height(), graph.space().name());
    let _ = writeln!(text, "  frames {first} to {last}, {} per second", graph.fps());
    if let Some(account) = &findings.memory {
        let (total, limit) = (in_bytes(account.total()), in_bytes(Settings::default().memory_limit));
        let _ = writeln!(text, "  about {total} of memory at frame {}, of {limit} allowed", findings.frame);
    }
    let _ = writeln!(text, "\n{HEADING}Outputs{HEADING:#}");
    let width = graph.outputs().iter().map(|output| output.name.chars().count()).max().unwrap_or(0);
    for output in graph.outputs() {
        let holds = guarantee(output).map_or("no color, no guarantee", Guarantee::name);
        let required = output.require.map_or(String::new(), |require| format!(" (required: {})", require.name()));
        let kind = output.kind.to_string();
        let unnamed = || UNNAMED_FILE.replace("{output}", &output.name);
        let file = printable(&output.file.clone().unwrap_or_else(unnamed));
        let _ = writeln!(text, "  {:width$}  {kind}: {holds}{required} → {file}", output.name);
    }
    let frame = findings.frame;
    let left_out: Vec<(&str, &LeftOut)> = named(graph, &findings.left_out).filter(|_| with_left_out).collect();
    if !left_out.is_empty() {
        let _ = writeln!(text, "\n{HEADING}Left out{HEADING:#} at frame {frame}");
    }
    for (name, why) in left_out {
        let _ = writeln!(text, "  {name}: {why}");
    }
    if !findings.notes.is_empty() {
        let _ = writeln!(text, "\n{HEADING}Notes{HEADING:#} at frame {frame}");
    }
    for (id, notes) in &findings.notes {
        let node = graph.node(*id);
        let _ = writeln!(text, "  {} ({})", node.name, node.ty.declaration().name);
        notes.iter().for_each(|note| text.push_str(&wrap(note, 4)));
    }
    text
}

/// Returns the names of the nodes that are left out, with the reasons.
fn named<'a>(graph: &'a CheckedGraph, left_out: &'a [Option<LeftOut>]) -> impl Iterator<Item = (&'a str, &'a LeftOut)> {
    let pairs = graph.nodes().iter().zip(left_out);
    pairs.filter_map(|(node, why)| Some((node.name.as_str(), why.as_ref()?)))
}

fn memory_to_json(graph: &CheckedGraph, account: &MemoryAccount) -> Value {
    let takers = account.consumers.iter().map(|(taker, bytes, _)| {
        let (what, node) = match taker {
            MemoryConsumer::Node(id) => ("node", Some(id)),
            MemoryConsumer::Preparing(id) => ("preparing", Some(id)),
            MemoryConsumer::Pictures => ("pictures", None),
            MemoryConsumer::Passes => ("passes", None),
            MemoryConsumer::Writing => ("writing pictures", None),
            MemoryConsumer::Whole => ("planes of the whole picture", None),
            MemoryConsumer::Tiles => ("tiles", None),
        };
        json!({ "what": what, "node": node.map(|id| &graph.node(*id).name), "bytes": bytes })
    });
    let takers: Vec<Value> = takers.collect();
    json!({ "bytes": account.total(), "limit": Settings::default().memory_limit, "takers": takers })
}

/// Returns the reasons that the frame cannot be rendered, one or two lines each.
fn not_planned(findings: &PlanFindings) -> Option<String> {
    let messages = findings.faults.iter().flat_map(|fault| &fault.messages);
    let texts: Vec<&str> = messages.map(Message::text).collect();
    (!texts.is_empty()).then(|| texts.join("\n"))
}

fn to_json(loaded: &Loaded, findings: &PlanFindings, valid: bool) -> Value {
    let graph = &loaded.graph;
    let (format, (first, last)) = (graph.format(), graph.frames());
    let outputs: Map<String, Value> = graph
        .outputs()
        .iter()
        .map(|output| {
            let value = json!({
                "kind": output.kind.to_string(),
                "guarantee": guarantee(output).map(Guarantee::name),
                "require": output.require.map(Guarantee::name),
                "file": output.file,
            });
            (output.name.clone(), value)
        })
        .collect();
    let left_out: Map<String, Value> =
        named(graph, &findings.left_out).map(|(name, why)| (name.into(), json!(why.to_string()))).collect();
    let notes: Map<String, Value> =
        findings.notes.iter().map(|(id, notes)| (graph.node(*id).name.clone(), json!(notes))).collect();
    json!({
        "document": graph.name(),
        "document_hash": graph.document_hash(),
        "valid": valid,
        "diagnostics": remedies::values(&loaded.warnings),
        "format": { "width": format.width(), "height": format.height(), "samples": format.samples() },
        "working_space": graph.space().name(),
        "frames": { "first": first, "last": last, "fps": graph.fps() },
        "nodes": graph.nodes().len(),
        "outputs": outputs,
        "left_out": left_out,
        "notes": notes,
        "memory": findings.memory.as_ref().map(|account| memory_to_json(graph, account)),
        "not_planned": not_planned(findings),
    })
}
