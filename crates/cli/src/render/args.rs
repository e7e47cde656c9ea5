//! Options of `trochoid render`.

use super::store::StoreOptions;
use crate::changes::Changes;
use crate::files::FileOptions;
use crate::progress::Form as ProgressForm;
use std::path::PathBuf;
use trochoid::{CheckedGraph, Guarantee, Tolerance, Window};

/// Options of `trochoid render`.
#[derive(Debug, Default, clap::Args)]
#[command(after_help = "\
Paths in a document are relative to it; PATTERN and FILE are relative to the current folder. {output} stands for the \
output's name, #### or %04d for the frame. A certificate covers one image file: for several, put {output} into FILE.

Examples:
  trochoid render storm.json
  trochoid render storm.json --frames 1-10,20-40x2 --resume
  trochoid render storm.json --output beauty --out 'out/{output}.####.exr'
  trochoid render storm.json --frames 36 --recipe storm.recipe.####.exr
  trochoid render storm.json --frames 36 --view spray.coverage --scale 1/2 --out spray.png
  trochoid render storm.json --set sea.height=6 --require hull --report report.json
  trochoid render storm.json --frames 1-96 --certificate 'out/storm.####.json' --sign mine.pem")]
pub(crate) struct Args {
    /// The document
    #[arg(value_name = "GRAPH")]
    pub(super) graph: PathBuf,
    /// Render this output; may be repeated [default: all outputs]
    #[arg(long, value_name = "NAME")]
    pub(super) output: Vec<String>,
    /// Render what this node makes instead of the document's outputs, or what feeds one of its ports, such as sky,
    /// view.coverage or blend.weights[1]; may be repeated. A Field is written as it is, into EXR
    #[arg(long, value_name = "NODE[.PORT]", conflicts_with_all = ["output", "certificate"])]
    pub(super) view: Vec<String>,
    /// Render the same picture smaller, such as 1/2 or 0.25: sizes in pixels shrink with it. As for --view, a tolerance of
    /// the document does not count
    #[arg(long, value_name = "FACTOR", value_parser = crate::scale::factor,
          conflicts_with_all = ["certificate", "tolerance"])]
    pub(super) scale: Option<f64>,
    /// Frames, such as 1-10,20-40x2 (every second frame) or -5--1 [default: all frames of the document]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub(super) frames: Option<String>,
    /// Pattern for the files to write, such as out/{output}.####.exr [default: the document's file names]
    #[arg(short, long, value_name = "PATTERN")]
    pub(super) out: Option<String>,
    /// Also write the weights of each color as a recipe, EXR, which `trochoid recolor` paints in other colors
    #[arg(long, value_name = "FILE")]
    pub(super) recipe: Option<String>,
    /// Store the weights of --recipe as 32-bit floats instead of 16-bit ones; their sums are exact either way
    #[arg(long, requires = "recipe")]
    pub(super) float: bool,
    /// Render only these pixels, counted from the upper left; `trochoid join` makes one picture of such tiles
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT", value_parser = region, conflicts_with_all = ["certificate", "error"])]
    pub(super) region: Option<Window>,
    #[command(flatten)]
    pub(super) changes: Changes,
    /// Number of threads; 0 uses all cores
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub(super) threads: u16,
    /// Guarantee that every color must meet, or its file is not written (exit code 3); if the document has a stricter
    /// requirement, that applies
    #[arg(long, value_name = "GUARANTEE", value_parser = ["hull", "box"])]
    pub(super) require: Option<String>,
    /// Maximum error of every displayed value, such as 1/512, met by the cheapest settings that are certified to do so;
    /// or exact; or reference, to render with the f64 references themselves [default: the document's tolerance]
    #[arg(long, value_name = "ERROR", value_parser = crate::plan::tolerance, allow_hyphen_values = true)]
    pub(super) tolerance: Option<Tolerance>,
    /// Use the settings of this plan, written by `trochoid plan`; certifies nothing
    #[arg(long, value_name = "FILE", conflicts_with = "tolerance")]
    pub(super) plan: Option<PathBuf>,
    /// Disable all optimizations; the pictures stay bit-identical
    #[arg(long)]
    pub(super) unoptimized: bool,
    /// Write a report of the run as JSON, creating missing folders; - means stdout
    #[arg(long, value_name = "FILE")]
    pub(super) report: Option<PathBuf>,
    /// Certify each image: write what it was made from, its error bounds against the f64 references, and its hashes as
    /// JSON, for `trochoid verify` to check; for a sea this takes many times as long as rendering
    #[arg(long, value_name = "FILE")]
    pub(super) certificate: Option<String>,
    /// Sign the certificates with this Ed25519 private key, PEM as `openssl genpkey -algorithm ed25519` writes it
    #[arg(long, value_name = "KEYFILE", requires = "certificate")]
    pub(super) sign: Option<PathBuf>,
    /// Write the error bound of each pixel against the f64 references as EXR, with the share of its samples that are
    /// ambiguous
    #[arg(long, value_name = "FILE")]
    pub(super) error: Option<String>,
    /// Skip frames whose files were made from the same document, --set assignments, inputs and frame
    #[arg(long)]
    pub(super) resume: bool,
    /// Share the frames with other runs of the same command that write to the same folder, also on other machines: each
    /// takes frames that nobody has taken, skips what is up to date, and ends when all are done
    #[arg(long)]
    pub(super) share: bool,
    /// Go on with the next frame when one fails; the exit code tells of the failure at the end
    #[arg(long)]
    pub(super) keep_going: bool,
    #[command(flatten)]
    pub(super) store: StoreOptions,
    #[command(flatten)]
    pub(super) files: FileOptions,
    /// Form of progress
    #[arg(long, value_name = "FORM", value_enum, default_value_t)]
    pub(super) progress: ProgressForm,
    /// Print nothing on stdout, and show no progress
    #[arg(long, conflicts_with_all = ["json", "progress"])]
    pub(super) quiet: bool,
    /// Print one JSON object per frame
    #[arg(long)]
    pub(super) json: bool,
}

/// Reads a region such as `960,0,960,1080`: left, top, width and height in pixels.
fn region(text: &str) -> Result<Window, NoRegion> {
    let numbers = text.split(',').map(|number| number.trim().parse::<u32>().ok()).collect::<Option<Vec<_>>>();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width.min(height) > 0 => {
            let [x, y, width, height] = [x, y, width, height].map(i64::from);
            Ok(Window::new(x, y, x + width, y + height))
        }
        _ => Err(NoRegion),
    }
}

/// A text is no region.
#[derive(Debug, thiserror::Error)]
#[error("expected left, top, width and height in pixels, such as 960,0,960,1080")]
struct NoRegion;

impl Args {
    /// Returns the changes of the document for this run.
    pub(super) fn assignments(&self) -> Vec<String> {
        let mut assignments = self.changes.assignments();
        assignments.extend(self.view.iter().map(|node| format!("view={node}")));
        assignments
    }

    /// Returns the tolerance of the run. That of a document is for its own outputs, at their own size.
    pub(super) fn tolerance(&self, graph: &CheckedGraph) -> Option<Tolerance> {
        let own = graph.tolerance().filter(|_| self.scale.is_none() && self.view.is_empty());
        self.tolerance.or(own)
    }

    /// Whether files that are up to date are skipped.
    pub(super) fn resumes(&self) -> bool {
        self.resume || self.share
    }

    pub(super) fn required(&self) -> Option<Guarantee> {
        self.require.as_deref().and_then(Guarantee::from_name)
    }

    pub(super) fn report_on_stdout(&self) -> bool {
        self.report.as_ref().is_some_and(|path| path.as_os_str() == "-")
    }
}
