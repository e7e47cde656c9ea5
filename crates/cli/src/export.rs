//! `trochoid export`: an output's pointwise program as a shader for another program.

use crate::changes::Changes;
use crate::failure::Failure;
use crate::files::{self, AccessOptions, OverwriteOptions};
use crate::shell::{self, printable};
use crate::{outputs, warnings};
use std::path::{Path, PathBuf};
use trochoid::{Form, GENERATOR, LookBuilder, VERSION, quoted};
use trochoid_export::{ExportError, InputError, Language, Request};

/// Options of `trochoid export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Mixes, ramps, blends and what makes masks out of fields and masks go into the shader, for the value at one point suffices for \
them. Everything else, such as noise, files and what a camera sees, becomes an input of the shader, to be named by --bind: a \
color, a number, or a number for each weight or component. Masks are clamped and weights divided by their sum, so that \
the shader's colors stay in the hull of its palette up to rounding.

Examples:
  trochoid export look.json --to glsl --bind light --bind rim -o look.glsl
  trochoid export look.json --to osl --bind light --bind rim -o look.osl
  trochoid export storm.json --to materialx --output beauty --bind view.coverage")]
pub(crate) struct Args {
    /// The document
    #[arg(value_name = "GRAPH")]
    graph: PathBuf,
    /// Language of the shader
    #[arg(long, value_name = "LANGUAGE", value_enum)]
    to: To,
    /// Output to export [default: the document's first]
    #[arg(long, value_name = "NAME")]
    output: Option<String>,
    /// Make this node, or this output of a node, an input of the shader; may be repeated, and inputs keep this order
    #[arg(long, value_name = "NODE[.OUTPUT]")]
    bind: Vec<String>,
    /// Return linear light: decode the color at the end, if the working space is encoded for display
    #[arg(long)]
    linear: bool,
    /// Frame at which keyed knobs are taken [default: the document's first]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    frame: Option<i64>,
    /// File to write: .glsl, .osl, .mtlx or .wgsl; - means stdout
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    access: AccessOptions,
    #[command(flatten)]
    over: OverwriteOptions,
}

/// A language, as users write it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum To {
    /// A function of GLSL, from 1.30 or ES 3.00 on
    Glsl,
    /// A shader of the Open Shading Language
    Osl,
    /// A node graph of MaterialX 1.39
    Materialx,
    /// A function of WGSL
    Wgsl,
}

impl To {
    fn language(self) -> Language {
        match self {
            Self::Glsl => Language::Glsl,
            Self::Osl => Language::Osl,
            Self::Materialx => Language::MaterialX,
            Self::Wgsl => Language::Wgsl,
        }
    }
}

/// Exports an output.
///
/// # Errors
/// The document is invalid or cannot be read, the output depends on nodes that are neither pointwise nor bound, or the
/// file cannot be written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    args.access.warn();
    // A shader has no size, so a document needs none.
    let folder = args.graph.parent().unwrap_or(Path::new("."));
    let document = LookBuilder::open(&args.graph)?.with_access(args.access.access(folder));
    let loaded = args.changes.assignments().iter().fold(document, |document, set| document.set(set)).load()?;
    let graph = &loaded.graph;
    let language = args.to.language();
    let mut faults = Vec::new();
    let output = outputs::choose(graph, args.output.as_slice(), &mut faults)[0];
    let is_stdout = args.out.as_os_str() == "-";
    if !is_stdout {
        let inputs = files::inputs(graph, &args.graph, &args.changes.assignments(), &[]);
        faults.extend(files::ending("--out", &args.out, language.extension()));
        faults.extend(args.over.refusal(&args.out, Form::Shader, &inputs));
    }
    let bound: Vec<&str> = args.bind.iter().map(String::as_str).collect();
    let by = format!("{GENERATOR}{VERSION}");
    let frame = args.frame.unwrap_or(graph.frames().0);
    let shader = trochoid_export::export(
        graph,
        &Request { output, frame, bound: &bound, linear: args.linear, language, by: &by },
    );
    let shader = shader.map_err(|refused| faults.extend(failures(refused)));
    warnings::after(faults, &warnings::of(graph, &[output], loaded.warnings))?;
    // Without a shader, there was a failure.
    let Ok(shader) = shader else { return Ok(()) };
    let unread = shader.unread.iter().map(|name| {
        format!(
            "warning: --bind {}: the output does not depend on it; the shader takes it, and does not read it",
            quoted(name)
        )
    });
    shell::tell(&unread.collect::<Vec<_>>());
    if is_stdout {
        return shell::print(&shader.text);
    }
    trochoid::write_guarded(&args.out, shader.text.as_bytes(), Form::Shader, args.over.overwrite)?;
    let (name, out) = (&graph.outputs()[output].name, args.out.display().to_string());
    shell::print(&format!("{} as {} → {}\n", printable(name), language.name(), printable(&out)))
}

/// Returns the failures of an export, with the options that remedy them.
fn failures(refused: ExportError) -> Vec<Failure> {
    match refused {
        ExportError::Inputs(faults) => {
            let failure = |fault: InputError| {
                let remedy = match &fault {
                    InputError::Constant { name, .. } => {
                        format!("bind the node that takes it, or export once for each value: --set {name}=VALUE")
                    }
                    _ => "name nodes that the output depends on".into(),
                };
                Failure::usage(format!("--bind: {fault}"), remedy)
            };
            faults.into_iter().map(failure).collect()
        }
        ExportError::Unbound(unbound) => {
            let options: Vec<String> = unbound.iter().map(|node| format!("--bind {}", quoted(&node.input))).collect();
            let remedy = format!("make them inputs of the shader: {}", options.join(" "));
            let mut faults: Vec<Failure> =
                unbound.iter().map(|node| Failure::new(crate::failure::INVALID, node)).collect();
            if let Some(last) = unbound.last() {
                faults.pop();
                faults.push(Failure::usage(last, remedy));
            }
            faults
        }
        refused => vec![Failure::usage(refused, "name it with --output")],
    }
}
