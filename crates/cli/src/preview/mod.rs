//! `trochoid preview`: renders frames of an output at a small size of its own, as a movie, an animated WebP, a PNG, or a
//! sequence of PNGs.

mod movie;
mod target;
mod webp;

use crate::changes::Changes;
use crate::failure::{FAILED, Failure};
use crate::files::{self, FileOptions};
use crate::progress::Progress;
use crate::shell::{self, printable};
use crate::{frames, interrupt, outputs, remedies, scale, shown, warnings};
use movie::Movie;
use std::path::{Path, PathBuf};
use target::Kind;
use trochoid::io::{PngImage, Samples, write_png8};
use trochoid::{Cache, CheckedGraph, Form, Loaded, marks};

/// Options of `trochoid preview`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Frames are evaluated at the small size, so that they take little time: widths in pixels shrink with it. The name of FILE \
tells what is written: .mp4 needs the program ffmpeg; .webp is read by browsers, but not by ffmpeg; .png is one frame; \
with #### or %04d in its name, .png is a sequence. Movies and animations use lossy compression, and carry no guarantee about \
their colors. A Field is shown from black, its smallest value in the first of these frames, to white, its largest one.

Examples:
  trochoid preview storm.json -o storm.mp4
  trochoid preview storm.json --frames 1-96x2 --scale 1/4 --quality 75 -o storm.webp
  trochoid preview storm.json --view spray.coverage -o 'spray.####.png'
  trochoid preview storm.json --frames 12 -o storm.png")]
pub(crate) struct Args {
    /// The document
    #[arg(value_name = "GRAPH")]
    graph: PathBuf,
    /// Output to show, a Color, a mask or a Field [default: the first]
    #[arg(long, value_name = "NAME")]
    output: Option<String>,
    /// Show what this node makes instead, or what feeds one of its ports, such as sky or blend.weights[1]
    #[arg(long, value_name = "NODE[.PORT]", conflicts_with = "output")]
    view: Option<String>,
    /// Frames, such as 1-96x2 (every second frame) [default: all frames of the document]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<String>,
    /// Size, as a share of the document's, such as 1/4 or 0.75 [default: 1/2]
    #[arg(long, value_name = "FACTOR", value_parser = scale::factor)]
    scale: Option<f64>,
    /// The same as --scale 1/N
    #[arg(long, value_name = "N", conflicts_with = "scale", value_parser = clap::value_parser!(u16).range(1..=64))]
    shrink: Option<u16>,
    /// Compression quality of a movie or an animation, 0 to 100
    #[arg(long, value_name = "Q", default_value_t = 80, value_parser = clap::value_parser!(u8).range(0..=100))]
    quality: u8,
    /// The file to write: .mp4 for a movie, .webp for an animation, .png for one frame, .####.png for each frame
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    files: FileOptions,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
}

impl Args {
    /// Returns the changes of the document for this run.
    fn assignments(&self) -> Vec<String> {
        let mut assignments = self.changes.assignments();
        assignments.extend(self.view.iter().map(|node| format!("view={node}")));
        assignments
    }

    fn factor(&self) -> f64 {
        self.scale.or(self.shrink.map(|n| 1.0 / f64::from(n))).unwrap_or(0.5)
    }
}

/// Frames to show, and the files that they become.
struct Preview<'a> {
    args: &'a Args,
    kind: Kind,
    graph: CheckedGraph,
    output: usize,
    frames: Vec<i64>,
}

/// Renders the requested frames. A movie or an animation appears whole or not at all, and so does each PNG.
///
/// # Errors
/// All problems that can be found in advance, together, before anything is written; or the problem that stopped the
/// run.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let Loaded { graph, warnings: warned } = args.files.load(&args.graph, &args.assignments())?;
    let mut faults = Vec::new();
    let kind = Kind::of(&args.out).unwrap_or_else(|fault| {
        faults.push(fault);
        Kind::Still
    });
    let output = match args.view {
        Some(_) => graph.outputs().len() - 1,
        None => outputs::choose(&graph, args.output.as_slice(), &mut faults)[0],
    };
    let frames = choose_frames(&graph, args.frames.as_deref(), &mut faults);
    let size = scale::size(graph.format(), args.factor(), kind == Kind::Movie);
    let graph = scale::sized(graph, size)?;
    let preview = Preview { args, kind, graph, output, frames };
    preview.check(&mut faults);
    let warned = warnings::of(&preview.graph, &[output], warned);
    warnings::after(faults, &warned)?;
    interrupt::watch()?;

    let mut progress = Progress::new(preview.frames.len(), args.quiet);
    let range = preview.write(&mut progress)?;
    progress.finish();
    if args.quiet {
        return Ok(());
    }
    let frames = match preview.frames[..] {
        [frame] => format!("frame {frame}"),
        _ => format!("{} frames", preview.frames.len()),
    };
    let (name, out) = (&preview.graph.outputs()[output].name, printable(&args.out.display().to_string()));
    let range = shown::told(range);
    shell::print(&format!("{frames}: {name} → {out}  {} × {} pixels{range}\n", size[0], size[1]))
}

fn choose_frames(graph: &CheckedGraph, list: Option<&str>, faults: &mut Vec<Failure>) -> Vec<i64> {
    match list.map(frames::parse).transpose() {
        Ok(Some(frames)) => frames,
        Ok(None) => frames::all(graph, false, faults),
        Err(pieces) => {
            faults.extend(pieces.into_iter().map(|piece| Failure::usage(piece, "use a list such as 1-96x2")));
            Vec::new()
        }
    }
}

/// Creates the folder of a file.
fn make_folder(path: &Path) -> Result<(), Failure> {
    match path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        Some(folder) => std::fs::create_dir_all(folder)
            .map_err(|error| Failure::new(FAILED, format!("{}: cannot be made: {error}", folder.display()))),
        None => Ok(()),
    }
}

impl Preview<'_> {
    fn size(&self) -> [u32; 2] {
        [self.graph.format().width(), self.graph.format().height()]
    }

    /// Adds faults of the output and of the files.
    fn check(&self, faults: &mut Vec<Failure>) {
        let Self { args, kind, graph, output, frames } = self;
        faults.extend(shown::refused(&graph.outputs()[*output]));
        faults.extend(kind.refused(&args.out, self.size(), frames.len()));
        faults.extend(args.files.reach.refused(graph, &[*output], frames, Vec::new()));
        let inputs = files::inputs(graph, &args.graph, &args.assignments(), &[]);
        let paths = frames.iter().map(|frame| kind.path(&args.out, *frame));
        // A name without a frame is the same for all.
        let mut paths: Vec<PathBuf> = paths.collect();
        paths.dedup();
        faults.extend(paths.iter().filter_map(|path| args.files.over.refusal(path, kind.form(), &inputs)));
        if *kind == Kind::Movie && faults.is_empty() {
            faults.extend(movie::missing(&args.out));
        }
    }

    /// Writes all files; returns the values of a Field that are black and white.
    fn write(&self, progress: &mut Progress) -> Result<Option<[f32; 2]>, Failure> {
        let Self { args, kind, graph, output, frames } = self;
        let (mut cache, mut range) = (Cache::new(), None);
        let mut small = |index: usize| {
            progress.begin(index, frames[index]);
            let picture = shown::show(graph, *output, frames[index], &mut cache, progress)?;
            range = range.or(picture.range());
            Ok::<_, Failure>(picture.within(range))
        };
        match kind {
            Kind::Still | Kind::Sequence => {
                for (index, frame) in frames.iter().enumerate() {
                    self.write_png(&kind.path(&args.out, *frame), small(index)?)?;
                }
            }
            Kind::Animation => {
                let times = times(frames, graph.fps());
                let mut next = |index: usize| Ok(shown::bytes(&small(index)?));
                let file = webp::encoded(&args.out, self.size(), args.quality, &times, &mut next)?;
                trochoid::write_guarded(&args.out, &file, Form::WebP, args.files.over.overwrite)?;
            }
            Kind::Movie => {
                make_folder(&args.out)?;
                let movie = Movie { size: self.size(), quality: args.quality, fps: graph.fps(), frames };
                movie.write(&args.out, args.files.over, &mut |index| Ok(shown::bytes(&small(index)?)))?;
            }
        }
        Ok(range)
    }

    fn write_png(&self, path: &Path, channels: [Vec<f32>; 3]) -> Result<(), Failure> {
        make_folder(path)?;
        let channels = channels.each_ref().map(|channel| Samples::contiguous(channel));
        let [width, height] = self.size();
        let image = PngImage { clamp: true, metadata: marks(Form::Preview), ..PngImage::new(width, height, channels) };
        write_png8(self.args.files.over.target(path, Form::Preview), &image)
            .map_err(|error| Failure::new(FAILED, remedies::written(&error)))
    }
}

/// Returns for how many frames of the document each frame stays: also for those that the list skips after it.
fn gaps(frames: &[i64]) -> Vec<u64> {
    let mut gaps: Vec<u64> = frames.windows(2).map(|two| two[0].abs_diff(two[1]).max(1)).collect();
    gaps.push(gaps.last().copied().unwrap_or(1));
    gaps
}

/// Returns when each frame begins and when the last one ends, in milliseconds from the start.
fn times(frames: &[i64], fps: f64) -> Vec<i32> {
    let mut now = 0.0;
    let mut times = vec![0];
    for gap in gaps(frames) {
        now += gap as f64 * 1000.0 / fps;
        times.push(now.round() as i32);
    }
    times
}

#[cfg(test)]
mod tests;
