//! `trochoid verify`: checks a certificate and its image.
//!
//! The JSON output has `holds`; `certificate`, `image`, `frame`, `made_by`; `signed_by`, the public key, `null` if the
//! certificate is not signed; `inputs` and `blocks`, the numbers compared with their hashes; `seed`, and `share_found`,
//! the share of the pixels that would have been found with a probability of 99 % if they had been changed, `null` if all
//! were looked at; `outputs`, a list of `{output, looked_at, pixels, ambiguous, given_up, hull, distance,
//! distance_ambiguous, weight_min, weight_sum_max_deviation}`, empty if nothing was evaluated; `failures`, a list of
//! `{place, found, expected}`.

use crate::changes::Changes;
use crate::failure::{Failure, MISSED};
use crate::files::AccessOptions;
use crate::interrupt;
use crate::progress::Progress;
use crate::shell::{self, print_json, printable};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use trochoid::Access;
use trochoid::certificate::{Certificate, Choice, Findings, PublicKey, Request, Verification, random_seed, verify};

/// Options of `trochoid verify`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The certificate contains the document; its paths are relative to the certificate's folder. At each pixel that is \
looked at, value, error bound and ambiguity are derived again, and the f64 references are evaluated: nothing that the \
certificate says is believed. The pixels are drawn by a random seed, which is printed, one in each of equal parts of the \
picture.

Exit code 3 means that the certificate does not hold.

Examples:
  trochoid verify out/storm.0036.json out/storm.0036.exr
  trochoid verify out/storm.0036.json out/storm.0036.exr --all --document storm.json
  trochoid verify out/storm.0036.json out/storm.0036.exr --key maker.pub.pem
  trochoid verify out/storm.0036.json out/storm.0036.exr --pixels 459 --seed 5d0b8a4f00c1e972")]
pub(crate) struct Args {
    /// The certificate, written by `render --certificate`
    #[arg(value_name = "CERTIFICATE")]
    certificate: PathBuf,
    /// The image
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// Look at every pixel, so that no change is missed
    #[arg(long, conflicts_with_all = ["pixels", "seed"])]
    all: bool,
    /// Number of equal parts of the picture, in each of which one pixel is looked at; 4603 find a changed share of 0.1 %
    /// of the pixels with a probability of 99 %
    #[arg(long, value_name = "N", default_value_t = 4603, value_parser = clap::value_parser!(u64).range(1..))]
    pixels: u64,
    /// Look at the same pixels as a run that printed this seed [default: drawn by the operating system]
    #[arg(long, value_name = "HEX", value_parser = seed)]
    seed: Option<u64>,
    /// Check that the certificate is signed by this Ed25519 public key, PEM as `openssl pkey -pubout` writes it
    #[arg(long, value_name = "KEYFILE")]
    key: Option<PathBuf>,
    /// Check that this document is the certified one
    #[arg(long, value_name = "GRAPH")]
    document: Option<PathBuf>,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    reach: AccessOptions,
    /// Print nothing on stdout, and show no progress
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Text that is not a seed.
#[derive(Debug, thiserror::Error)]
#[error("expected up to 16 hexadecimal digits, as an earlier run printed them")]
struct NoSeed;

/// Reads a seed as it is printed.
fn seed(text: &str) -> Result<u64, NoSeed> {
    u64::from_str_radix(text, 16).map_err(|_| NoSeed)
}

/// Checks a certificate.
///
/// # Errors
/// The certificate does not hold, with a message for each failure; or a file cannot be read.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let changes = args.changes.assignments();
    if let (Some(change), None) = (changes.first(), &args.document) {
        let message = format!("found the change {change}, but no --document; expected the document that is changed");
        return Err(Failure::usage(message, "name it with --document, or leave out --set and --palette"));
    }
    let document = args.document.as_ref().map(|path| args.reach.load(path, &changes)).transpose()?;
    let key = args.key.as_ref().map(|path| PublicKey::read(path)).transpose()?;
    args.reach.warn();
    let access = access(args);
    let choice = if args.all { Choice::All } else { Choice::Some(args.pixels) };
    let seed = args.seed.unwrap_or_else(random_seed);
    interrupt::watch()?;
    let mut progress = Progress::new(1, args.quiet);
    // The frame for the progress bar; `verify` reports a certificate that cannot be read.
    match Certificate::read(&args.certificate) {
        Ok(Ok(certificate)) => progress.begin(0, certificate.frame),
        Err(_) if matches!(Certificate::read(&args.image), Ok(Ok(_))) => {
            let found = format!("{}: found a certificate; expected an image in second place", args.image.display());
            return Err(Failure::usage(found, "give the certificate first, then the image"));
        }
        _ => (),
    }
    let request = Request {
        certificate: &args.certificate,
        image: &args.image,
        choice,
        seed,
        key: key.as_ref(),
        document: document.as_ref().map(|loaded| &loaded.graph),
        access: Some(&access),
    };
    let found = verify(&request, &progress);
    progress.finish();
    let found = found?;
    if args.json {
        print_json(&as_json(args, &found, seed))?;
        return if found.holds() { Ok(()) } else { Err(Failure::silent(MISSED)) };
    }
    if found.holds() {
        return if args.quiet { Ok(()) } else { shell::print(&text(args, &found, seed)) };
    }
    let failures = found.failures.iter().map(|failed| Failure::new(MISSED, failed));
    // Without pixels, the seed decides nothing.
    let again = if found.outputs.is_empty() { String::new() } else { format!(" (seed {seed:016x})") };
    let [certificate, image] = [&args.certificate, &args.image].map(|path| path.display());
    // Of a changed certificate nothing else is checked.
    let is_changed = found.frame.is_none();
    let remedy = if is_changed {
        "give the certificate as it was written, or certify the picture anew: render its document with --certificate"
    } else {
        "give the picture that was certified, or certify this one: render its document with --certificate"
    };
    let last = format!("{certificate}: does not hold for {image}{again}\n  remedy: {remedy}");
    let last = Failure::new(MISSED, last);
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

fn text(args: &Args, found: &Verification, seed: u64) -> String {
    let mut lines = Vec::new();
    let frame = found.frame.unwrap_or_default();
    let [certificate, image] = [&args.certificate, &args.image].map(|path| printable(&path.display().to_string()));
    let version = printable(&found.trochoid);
    // Anyone who changes a certificate can compute a new digest, so a digest only detects accidental changes.
    lines
        .push(format!("{certificate}: matches its own digest; of frame {frame}; says that Trochoid {version} made it"));
    lines.push(match found.signed_by {
        None => "it is not signed, so anyone may have made it".into(),
        Some(key) if args.key.is_some() => format!("it is signed by the key {key}"),
        Some(key) => format!("it is signed by the key {key}; --key tells whether that is a key that you know"),
    });
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
    lines.push(certainty(found, seed));
    lines.push("holds".into());
    lines.join("\n") + "\n"
}

/// Formats the line that says what the choice of pixels is worth.
fn certainty(found: &Verification, seed: u64) -> String {
    let Some(share) = found.share_found else {
        return "every pixel was looked at: no change of a pixel is missed".into();
    };
    // Rounded up: a smaller share would be found less often.
    let percent = 100.0 * share;
    let digits = 10_f64.powi(1 - percent.log10().floor() as i32);
    let percent = (percent * digits).ceil() / digits;
    format!(
        "if {percent} % of the pixels had been changed, wherever they are, one of them would have been looked at with a \
         probability of 99 %; seed {seed:016x}"
    )
}

/// Formats the line of an output.
fn checked(output: &Findings) -> String {
    let name = printable(&output.output);
    let mut facts = vec![format!(
        "{name}: {} derived again, each with its own bound",
        count(output.looked_at, output.pixels, "pixels")
    )];
    facts.push(match output.distance {
        0.0 => "no farther from the references than the file rounds".into(),
        distance => format!("at most {distance:.1e} from the references beyond the rounding of the file"),
    });
    if output.ambiguous > 0 {
        facts.push(match output.distance_ambiguous {
            0.0 => format!("{} ambiguous, no farther either", output.ambiguous),
            distance => format!("{} ambiguous, at most {distance:.1e} from them", output.ambiguous),
        });
    }
    if output.given_up > 0 {
        let surfaces = "where surfaces are too rough to find what their rays meet";
        facts.push(format!("{} of the ambiguous ones without a reference, {surfaces}", output.given_up));
    }
    if output.hull {
        facts.push("none outside the hull".into());
    }
    if output.weight_min.is_finite() {
        facts.push(match output.weight_sum_max_deviation {
            0.0 => "sums of weights exactly 1".into(),
            deviation => format!("sums of weights 1 within {deviation:.1e}"),
        });
    }
    facts.join("; ")
}

fn as_json(args: &Args, found: &Verification, seed: u64) -> Value {
    let finite = |value: f64| if value.is_finite() { json!(value) } else { Value::Null };
    let outputs = found.outputs.iter().map(|output| {
        json!({
            "output": output.output,
            "looked_at": output.looked_at,
            "pixels": output.pixels,
            "ambiguous": output.ambiguous,
            "given_up": output.given_up,
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
        "signed_by": found.signed_by.map(|key| key.to_string()),
        "inputs": found.inputs,
        "blocks": found.blocks,
        "seed": format!("{seed:016x}"),
        "share_found": found.share_found,
        "outputs": outputs.collect::<Vec<_>>(),
        "failures": failures.collect::<Vec<_>>(),
    })
}
