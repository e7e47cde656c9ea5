//! `trochoid verify`: checks a certificate and its image.
//!
//! The JSON output has `holds`; `certificate`, `image`, `frame`, `made_by`; `inputs` and `blocks`, the numbers compared
//! with their hashes; `outputs`, a list of `{output, looked_at, pixels, ambiguous, hull, distance, distance_ambiguous,
//! weight_min, weight_sum_max_deviation}`, empty if nothing was evaluated; `failures`, a list of `{place, found,
//! expected}`.

use crate::failure::{Failure, MISSED};
use crate::files::AccessOptions;
use crate::interrupt;
use crate::progress::Progress;
use crate::shell::{self, print_json, printable};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use trochoid::Access;
use trochoid::certificate::{Certificate, Choice, Findings, Request, Verification, verify};

/// Options of `trochoid verify`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The certificate contains the document; its paths are relative to the certificate's folder. Pixels are evaluated by \
the f64 references, which share no program, kernel or tile with the renderer; the certificate's digest selects the \
pixels.

Exit code 3 means that the certificate does not hold.

Examples:
  trochoid verify out/storm.0036.json out/storm.0036.exr
  trochoid verify out/storm.0036.json out/storm.0036.exr --all --document storm.json")]
pub(crate) struct Args {
    /// The certificate, written by `render --certificate`
    #[arg(value_name = "CERTIFICATE")]
    certificate: PathBuf,
    /// The image
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// Evaluate every pixel
    #[arg(long, conflicts_with = "pixels")]
    all: bool,
    /// Number of pixels to evaluate
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(1..))]
    pixels: u64,
    /// Check that this document is the certified one
    #[arg(long, value_name = "GRAPH")]
    document: Option<PathBuf>,
    /// Set a knob or port of --document, as for `render`; may be repeated
    #[arg(long, value_name = "NODE.KNOB=VALUE", requires = "document")]
    set: Vec<String>,
    #[command(flatten)]
    reach: AccessOptions,
    /// Print nothing on stdout, and show no progress
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Checks a certificate.
///
/// # Errors
/// The certificate does not hold, with a message for each failure; or a file cannot be read.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let document = args.document.as_ref().map(|path| args.reach.load(path, &args.set)).transpose()?;
    args.reach.warn();
    let access = access(args);
    let choice = if args.all { Choice::All } else { Choice::Some(args.pixels) };
    interrupt::watch()?;
    let mut progress = Progress::new(1, args.quiet);
    // The frame for the progress bar; `verify` reports a certificate that cannot be read.
    if let Ok(Ok(certificate)) = Certificate::read(&args.certificate) {
        progress.begin(0, certificate.frame);
    }
    let request = Request {
        certificate: &args.certificate,
        image: &args.image,
        choice,
        document: document.as_ref().map(|loaded| &loaded.graph),
        access: Some(&access),
    };
    let found = verify(&request, &progress);
    progress.finish();
    let found = found?;
    if args.json {
        print_json(&as_json(args, &found))?;
        return if found.holds() { Ok(()) } else { Err(Failure::silent(MISSED)) };
    }
    if found.holds() {
        return if args.quiet { Ok(()) } else { shell::print(&text(args, &found)) };
    }
    let failures = found.failures.iter().map(|failed| Failure::new(MISSED, failed));
    let last =
        Failure::new(MISSED, format!("{}: does not hold for {}", args.certificate.display(), args.image.display()));
    Failure::all(failures.chain([last]))
}

/// Returns the access rights of the document in the certificate: those of the certificate's folder, and of the folder
/// of `--document`.
fn access(args: &Args) -> Access {
    let folder = |path: &PathBuf| path.parent().map(Path::to_path_buf).unwrap_or_default();
    let access = args.reach.access(&folder(&args.certificate));
    args.document.iter().fold(access, |access, document| access.allowing(&folder(document)))
}

fn count(number: u64, of: u64, what: &str) -> String {
    if number == of { format!("all {of} {what}") } else { format!("{number} of {of} {what}") }
}

fn text(args: &Args, found: &Verification) -> String {
    let mut lines = Vec::new();
    let frame = found.frame.unwrap_or_default();
    let [certificate, image] = [&args.certificate, &args.image].map(|path| printable(&path.display().to_string()));
    let version = printable(&found.trochoid);
    // Anyone who changes a certificate can compute a new digest, so a digest only detects accidental changes.
    lines.push(format!("{certificate}: matches its own digest; made by Trochoid {version}, of frame {frame}"));
    let document =
        args.document.as_ref().map(|path| format!("{} is its document, ", printable(&path.display().to_string())));
    let inputs = match found.inputs {
        0 => "it has no input files".to_string(),
        1 => "its input file is the same".into(),
        inputs => format!("its {inputs} input files are the same"),
    };
    lines.push(format!("{}{inputs}", document.unwrap_or_default()));
    let blocks = if found.blocks == 1 { "1 block".into() } else { format!("{} blocks", found.blocks) };
    lines.push(format!("{image}: contains the certified pixels, in {blocks}"));
    for output in &found.outputs {
        lines.push(checked(output));
    }
    lines.push("holds".into());
    lines.join("\n") + "\n"
}

/// Formats the line of an output.
fn checked(output: &Findings) -> String {
    let name = printable(&output.output);
    let mut facts =
        vec![format!("{name}: {} evaluated by the references", count(output.looked_at, output.pixels, "pixels"))];
    facts.push(format!("at most {:.1e} from them beyond the rounding of the file", output.distance));
    if output.ambiguous > 0 {
        facts.push(format!("{} ambiguous, at most {:.1e} from them", output.ambiguous, output.distance_ambiguous));
    }
    if output.hull {
        facts.push("none outside the hull".into());
    }
    if output.weight_min.is_finite() {
        facts.push(format!("sums of weights 1 within {:.1e}", output.weight_sum_max_deviation));
    }
    facts.join("; ")
}

fn as_json(args: &Args, found: &Verification) -> Value {
    let finite = |value: f64| if value.is_finite() { json!(value) } else { Value::Null };
    let outputs = found.outputs.iter().map(|output| {
        json!({
            "output": output.output,
            "looked_at": output.looked_at,
            "pixels": output.pixels,
            "ambiguous": output.ambiguous,
            "hull": output.hull,
            "distance": finite(output.distance),
            "distance_ambiguous": finite(output.distance_ambiguous),
            "weight_min": finite(output.weight_min),
            "weight_sum_max_deviation": finite(output.weight_sum_max_deviation),
        })
    });
    let failures = found.failures.iter();
    let failures = failures.map(|f| json!({ "place": f.place, "found": f.found, "expected": f.expected }));
    json!({
        "holds": found.holds(),
        "certificate": args.certificate.display().to_string(),
        "image": args.image.display().to_string(),
        "frame": found.frame,
        "made_by": found.trochoid,
        "inputs": found.inputs,
        "blocks": found.blocks,
        "outputs": outputs.collect::<Vec<_>>(),
        "failures": failures.collect::<Vec<_>>(),
    })
}
