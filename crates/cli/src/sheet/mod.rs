//! `trochoid sheet`: a contact sheet: frames, documents, or values of a knob, side by side with captions.

mod cells;
mod draw;

use crate::changes::Changes;
use crate::failure::{FAILED, Failure};
use crate::files::{self, FileOptions};
use crate::progress::Progress;
use crate::shell::{self, printable};
use crate::wedge::Wedge;
use crate::{interrupt, remedies, shown, warnings};
use cells::Cells;
use draw::Sheet;
use std::path::PathBuf;
use trochoid::io::{PngImage, Samples, write_png8};
use trochoid::{Cache, Form, marks};

/// Options of `trochoid sheet`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Each picture is evaluated at its small size, as by `trochoid render --scale`. Its caption tells what differs: the document, \
the value of the knob, the frame. Documents and values are rows if there are several frames. Fields are shown from black, \
the smallest value of all pictures, to white, the largest one.

Examples:
  trochoid sheet storm.json --frames 1-96x12 -o storm.png
  trochoid sheet storm.json --wedge sea.height=3,4,5 --frames 1,48 -o heights.png
  trochoid sheet graphs/*.json --width 240 --columns 6 -o all.png
  trochoid sheet storm.json --view spray.coverage -o spray.png")]
pub(crate) struct Args {
    /// The documents
    #[arg(value_name = "GRAPH", required = true)]
    graphs: Vec<PathBuf>,
    /// Frames, such as 1-96x12 (every twelfth frame) [default: up to 12 of a single document; the first frame of several
    /// documents, or with --wedge]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<String>,
    /// Show each of these values of a knob or port, such as sea.height=3,4,5
    #[arg(long, value_name = "NODE.KNOB=VALUES")]
    wedge: Option<String>,
    /// Output to show, a Color, a mask or a Field [default: the first]
    #[arg(long, value_name = "NAME")]
    output: Option<String>,
    /// Show what this node makes instead, or what feeds one of its ports, such as sky or blend.weights[1]
    #[arg(long, value_name = "NODE[.PORT]", conflicts_with = "output")]
    view: Option<String>,
    /// Width of each picture in pixels; at most that of its document
    #[arg(long, value_name = "PIXELS", default_value_t = 320, value_parser = clap::value_parser!(u32).range(16..=4096))]
    width: u32,
    /// Number of columns [default: the frames, if there are rows of them; otherwise what gives the sheet the shape of a
    /// screen]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    columns: Option<u32>,
    /// The file to write, .png
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    files: FileOptions,
    /// Print nothing on stdout, and show no progress
    #[arg(long)]
    quiet: bool,
}

impl Args {
    /// Returns the changes of each document, without the wedge.
    fn assignments(&self) -> Vec<String> {
        let mut assignments = self.changes.assignments();
        assignments.extend(self.view.iter().map(|node| format!("view={node}")));
        assignments
    }
}

/// Draws a sheet.
///
/// # Errors
/// All problems of the options and documents that can be found in advance, together; or a picture cannot be evaluated, or
/// the sheet written. Then nothing is written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let mut faults = Vec::new();
    let wedge = args.wedge.as_deref().map(Wedge::parse).transpose().unwrap_or_else(|fault| {
        faults.push(fault);
        None
    });
    let cells = Cells::new(args, wedge.as_ref(), &mut faults);
    faults.extend(files::ending("--out", &args.out, "png"));
    for variant in &cells.variants {
        let assignments = args.assignments();
        let inputs = files::inputs(&variant.graph, &variant.path, &assignments, &[]);
        faults.extend(args.files.over.refusal(&args.out, Form::Sheet, &inputs));
        faults.extend(args.files.reach.refused(&variant.graph, &[variant.output], &variant.frames, Vec::new()));
    }
    // What holds for each value of a knob is told once.
    let mut told: Vec<Failure> = Vec::new();
    for fault in faults {
        if !told.contains(&fault) {
            told.push(fault);
        }
    }
    let layout = cells.layout(args, &mut told);
    warnings::after(told, &cells.warnings)?;
    interrupt::watch()?;

    let mut progress = Progress::new(cells.count(), args.quiet);
    let (mut pictures, mut range) = (Vec::new(), None);
    for variant in &cells.variants {
        let mut cache = Cache::new();
        for frame in &variant.frames {
            progress.begin(pictures.len(), *frame);
            let picture = shown::show(&variant.graph, variant.output, *frame, &mut cache, &progress)
                .map_err(|failure| failure.at(&cells.place(variant)))?;
            range = shown::joined(range, picture.range());
            pictures.push(picture);
        }
    }
    progress.finish();
    let pictures = pictures.iter().map(|picture| picture.within(picture.range().and(range))).collect();
    let sheet = Sheet { title: cells.title(range), captions: cells.captions(), pictures, layout };
    let size = sheet.layout.size();
    let pixels = sheet.draw().map_err(|error| Failure::new(FAILED, format!("the sheet cannot be drawn: {error}")))?;
    write(args, size, &pixels)?;
    if args.quiet {
        return Ok(());
    }
    let out = printable(&args.out.display().to_string());
    let count = cells.count();
    let pictures = if count == 1 { "1 picture".into() } else { format!("{count} pictures") };
    shell::print(&format!("{pictures} → {out}  {} × {} pixels{}\n", size[0], size[1], shown::told(range)))
}

fn write(args: &Args, [width, height]: [u32; 2], pixels: &[u8]) -> Result<(), Failure> {
    if let Some(folder) = args.out.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        let cannot = |error| Failure::new(FAILED, format!("{}: cannot be made: {error}", folder.display()));
        std::fs::create_dir_all(folder).map_err(cannot)?;
    }
    let channel = |channel: usize| pixels.chunks_exact(3).map(|p| f32::from(p[channel]) / 255.0).collect::<Vec<_>>();
    let channels = [0, 1, 2].map(channel);
    let channels = channels.each_ref().map(|channel| Samples::contiguous(channel));
    let image = PngImage { metadata: marks(Form::Sheet), ..PngImage::new(width, height, channels) };
    let written = write_png8(args.files.over.target(&args.out, Form::Sheet), &image);
    written.map_err(|error| Failure::new(FAILED, remedies::written(&error)))
}
