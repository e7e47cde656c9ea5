//! `trochoid preview`: renders frames of an output at reduced size, as an animated WebP or a still PNG.

use crate::changes::Changes;
use crate::failure::{FAILED, Failure, INTERRUPTED};
use crate::files::{self, FileOptions};
use crate::progress::Progress;
use crate::remedies;
use crate::shell::{self, printable};
use crate::{frames, interrupt, outputs, webp};
use std::path::PathBuf;
use trochoid::io::{PngImage, Samples, write_png8};
use trochoid::{
    Buffers, Cache, CheckedGraph, EvalError, Form, Kind, MemoryConsumer, Picture, Pictures, Plan, Settings, marks,
    quoted_path,
};
use webp_animation::{ColorMode, Encoder, EncoderOptions, EncodingConfig};

/// Options of `trochoid preview`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
An animation uses lossy compression, and carries no guarantee about its colors.

Examples:
  trochoid preview storm.json -o storm.webp
  trochoid preview storm.json --frames 1-96x2 --shrink 4 --quality 75 -o storm.webp
  trochoid preview storm.json --frames 12 -o storm.png")]
pub(crate) struct Args {
    /// The document
    #[arg(value_name = "GRAPH")]
    graph: PathBuf,
    /// Output to show, a Color or a mask [default: the first]
    #[arg(long, value_name = "NAME")]
    output: Option<String>,
    /// Frames, such as 1-96x2 (every second frame) [default: all frames of the document]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<String>,
    /// Average blocks of N × N pixels into one pixel
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u16).range(1..=64))]
    shrink: u16,
    /// Compression quality of the animation, 0 to 100
    #[arg(long, value_name = "Q", default_value_t = 80, value_parser = clap::value_parser!(u8).range(0..=100))]
    quality: u8,
    /// The file to write: .webp for an animation, .png for one frame
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

/// Maximum width and height of a WebP file, in pixels.
const LARGEST: u32 = 16_383;

/// Renders the requested frames into one animation, which loops forever, or one frame into a still.
///
/// # Errors
/// All problems that can be found in advance, together; or the problem that stopped the run. In either case nothing
/// is written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let loaded = args.files.load(&args.graph, &args.changes.assignments())?;
    shell::tell(&remedies::texts(&loaded.warnings));
    let graph = &loaded.graph;
    let mut faults = Vec::new();
    let output = outputs::choose(graph, args.output.as_slice(), &mut faults)[0];
    let chosen = choose_frames(graph, args.frames.as_deref(), &mut faults);
    let size = [graph.format().width(), graph.format().height()].map(|size| size.div_ceil(u32::from(args.shrink)));
    look(args, graph, output, chosen.len(), size, &mut faults);
    faults.extend(args.files.reach.refused(graph, &[output], &chosen, Vec::new()));
    let inputs = files::inputs(graph, &args.graph, &args.changes.assignments(), &[]);
    faults.extend(args.files.over.refusal(&args.out, form(args), &inputs));
    Failure::all(faults)?;
    interrupt::watch()?;

    let mut progress = Progress::new(chosen.len(), args.quiet);
    let mut cache = Cache::new();
    let mut small = |index: usize| {
        progress.begin(index, chosen[index]);
        let picture = render(graph, output, chosen[index], &mut cache, &progress)?;
        cache.forget_unused();
        Ok::<_, Failure>(shrink(graph, &picture, usize::from(args.shrink)))
    };
    if ends(args, "png") {
        let channels = small(0)?;
        let channels = channels.each_ref().map(|channel| Samples::contiguous(channel));
        let image =
            PngImage { clamp: true, metadata: marks(Form::Preview), ..PngImage::new(size[0], size[1], channels) };
        write_png8(args.files.over.target(&args.out, form(args)), &image)
            .map_err(|error| Failure::new(FAILED, remedies::written(&error)))?;
    } else {
        let cannot = |error: webp_animation::Error| Failure::new(FAILED, format!("{}: {error}", args.out.display()));
        let encoding = Some(EncodingConfig::new_lossy(f32::from(args.quality)));
        // Every frame is a keyframe: between frames that store only changes, slow drift stays below the threshold and
        // appears frozen.
        let options =
            EncoderOptions { encoding_config: encoding, color_mode: ColorMode::Rgb, kmax: 1, ..Default::default() };
        let mut encoder = Encoder::new_with_options((size[0], size[1]), options).map_err(cannot)?;
        let times = times(&chosen, graph.fps());
        for (index, time) in times[..chosen.len()].iter().enumerate() {
            encoder.add_frame(&bytes(&small(index)?), *time).map_err(cannot)?;
        }
        let file = encoder.finalize(times[chosen.len()]).map_err(cannot)?;
        trochoid::write_guarded(&args.out, &webp::marked(&file, size), form(args), args.files.over.overwrite)?;
    }
    progress.finish();
    if args.quiet {
        return Ok(());
    }
    let frames = match chosen[..] {
        [frame] => format!("frame {frame}"),
        _ => format!("{} frames", chosen.len()),
    };
    let (name, out) = (&graph.outputs()[output].name, printable(&args.out.display().to_string()));
    shell::print(&format!("{frames}: {name} → {out}  {} × {} pixels\n", size[0], size[1]))
}

/// Returns the kind of file to write.
fn form(args: &Args) -> Form {
    if ends(args, "png") { Form::Preview } else { Form::WebP }
}

fn ends(args: &Args, ending: &str) -> bool {
    args.out.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
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

/// Adds faults of the output and of the file.
fn look(args: &Args, graph: &CheckedGraph, output: usize, frames: usize, size: [u32; 2], faults: &mut Vec<Failure>) {
    let spec = &graph.outputs()[output];
    if !matches!(spec.kind, Kind::Color | Kind::Weights(2)) {
        let message = format!("output \"{}\" is a {}; expected a Color or a mask", spec.name, spec.kind);
        faults.push(Failure::usage(message, "choose another with --output"));
    }
    if size.iter().any(|&side| side > LARGEST) {
        let message =
            format!("found a preview of {} × {} pixels; expected at most {LARGEST} on each side", size[0], size[1]);
        faults.push(Failure::usage(message, "raise --shrink"));
    }
    if ends(args, "png") && frames > 1 {
        let message = format!("--out {}: found {frames} frames; expected one in a PNG", quoted_path(&args.out));
        faults.push(Failure::usage(message, "choose one with --frames, or use a name such as storm.webp"));
    } else if !ends(args, "png") && !ends(args, "webp") {
        let message = format!("--out {}: found another extension; expected .webp or .png", quoted_path(&args.out));
        faults.push(Failure::usage(message, "use a name such as storm.webp"));
    }
}

fn render(
    graph: &CheckedGraph,
    output: usize,
    frame: i64,
    cache: &mut Cache,
    progress: &Progress,
) -> Result<Picture, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::new(FAILED, format!("frame {frame}: {error}"));
    let stopped = || Failure::new(INTERRUPTED, "interrupted; nothing was written");
    if interrupt::asked() {
        return Err(stopped());
    }
    let name = graph.outputs()[output].name.as_str();
    let plan = Plan::new(graph, &[name], frame, &[], &Settings::default()).map_err(|error| failed(&error))?;
    // The whole picture is needed: it is reduced and encoded afterward.
    let account = plan.memory(Pictures::Files);
    plan.check_memory(&account).map_err(|mut error| {
        if let EvalError::TooMuchMemory { remedy, .. } = &mut error
            && let Some((MemoryConsumer::Pictures | MemoryConsumer::Writing, ..)) = account.consumers.first()
        {
            // The remedy of writing EXR does not apply to previews.
            *remedy = "lower the format's \"width\" and \"height\"";
        }
        Failure::evaluated(&format!("frame {frame}: "), &error)
    })?;
    let evaluated = plan.evaluate(&Buffers::new(), cache, progress).map_err(|error| match error {
        EvalError::Cancelled => stopped(),
        error => Failure::evaluated(&format!("frame {frame}: "), &error),
    })?;
    evaluated.pictures.into_iter().next().ok_or_else(|| failed(&"no picture was made"))
}

/// Returns when each frame begins and when the last one ends, in milliseconds from the start. A frame also stays for
/// the frames that the list skips after it.
fn times(frames: &[i64], fps: f64) -> Vec<i32> {
    let mut gaps: Vec<f64> = frames.windows(2).map(|two| (two[1] - two[0]).abs().max(1) as f64).collect();
    gaps.push(gaps.last().copied().unwrap_or(1.0));
    let mut now = 0.0;
    let mut times = vec![0];
    for gap in gaps {
        now += gap * 1000.0 / fps;
        times.push(now.round() as i32);
    }
    times
}

/// Averages blocks of pixels with equal weights, and encodes the results for display.
fn shrink(graph: &CheckedGraph, picture: &Picture, block: usize) -> [Vec<f32>; 3] {
    let [width, height] = [graph.format().width(), graph.format().height()].map(|side| side as usize);
    let color = picture.kind == Kind::Color;
    let mut small: [Vec<f32>; 3] = Default::default();
    for top in (0..height).step_by(block) {
        for left in (0..width).step_by(block) {
            let (bottom, right) = ((top + block).min(height), (left + block).min(width));
            let mean = [0, 1, 2].map(|channel| {
                let samples = picture.planes[if color { channel } else { 0 }].samples();
                let rows = (top..bottom).flat_map(|row| &samples[row * width + left..row * width + right]);
                rows.map(|&sample| f64::from(sample)).sum::<f64>() / ((bottom - top) * (right - left)) as f64
            });
            let shown = if color { graph.space().to_display(mean) } else { mean };
            small.iter_mut().zip(shown).for_each(|(channel, value)| channel.push(value as f32));
        }
    }
    small
}

/// Returns interleaved R, G and B of 8 bits each.
fn bytes([r, g, b]: &[Vec<f32>; 3]) -> Vec<u8> {
    let pixels = r.iter().zip(g).zip(b).flat_map(|((r, g), b)| [*r, *g, *b]);
    pixels.map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRAPH: &str = r##"{
      "trochoid": 1, "format": { "width": 6, "height": 3 }, "working_space": "srgb",
      "frames": { "first": 1, "last": 4, "fps": 20 },
      "nodes": {
        "across": { "type": "ScreenX" },
        "beauty": { "type": "Mix", "a": { "keys": [[1, "#000000"], [4, "#ff0000"]] }, "b": "#ffffff", "weight": "across" }
      },
      "outputs": { "beauty": { "color": "beauty" }, "mask": { "weights": "across" } }
    }"##;

    fn args(folder: &std::path::Path, out: &str) -> Args {
        let graph = folder.join("graph.json");
        std::fs::write(&graph, GRAPH).unwrap();
        let out = folder.join(out);
        Args {
            graph,
            output: None,
            frames: None,
            shrink: 2,
            quality: 90,
            out,
            changes: Changes::default(),
            files: FileOptions::default(),
            quiet: true,
        }
    }

    #[test]
    fn an_animation_has_the_size_and_times_that_were_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let args = Args { frames: Some("1-4x3".into()), ..args(folder.path(), "x.webp") };
        run(&args).unwrap();
        let bytes = std::fs::read(&args.out).unwrap();
        let frames: Vec<_> = webp_animation::Decoder::new(&bytes).unwrap().into_iter().collect();
        assert_eq!(frames.len(), 2);
        assert_eq!(frames[0].dimensions(), (3, 2));
        assert_eq!(frames.iter().map(webp_animation::Frame::timestamp).collect::<Vec<_>>(), [150, 300], "ends, in ms");
        let first = |frame: usize| frames[frame].data()[0];
        assert!(first(1) > first(0) + 100, "{} after {}", first(1), first(0));
    }

    #[test]
    fn slow_drift_does_not_stand_still() {
        let folder = tempfile::tempdir().unwrap();
        let args = Args { shrink: 1, ..args(folder.path(), "x.webp") };
        let drifting = GRAPH
            .replace(r#""width": 6, "height": 3"#, r#""width": 96, "height": 64"#)
            .replace(r#""last": 4"#, r#""last": 24"#)
            .replace(r##"[1, "#000000"], [4, "#ff0000"]"##, r##"[1, "#405060"], [24, "#506070"]"##);
        std::fs::write(&args.graph, &drifting).unwrap();
        run(&args).unwrap();
        let bytes = std::fs::read(&args.out).unwrap();
        let last = webp_animation::Decoder::new(&bytes).unwrap().into_iter().last().unwrap();
        let still = trochoid::parse("graph.json", &drifting, std::path::Path::new("."), &[]).unwrap();
        let still = render(&still.graph, 0, 24, &mut Cache::new(), &Progress::new(1, true)).unwrap();
        let expected = |pixel: usize| (still.planes[2].samples()[pixel] * 255.0).round() as i32;
        // The left part of a row, whose colors come from the drift alone.
        let apart = (0..24).map(|x| (i32::from(last.data()[4 * (96 * 32 + x) + 2]) - expected(96 * 32 + x)).abs());
        let furthest = apart.max().unwrap();
        assert!(furthest < 6, "{furthest} levels from the still");
    }

    #[test]
    fn nothing_that_the_document_reads_is_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let args = Args { frames: Some("1".into()), ..args(folder.path(), "x.png") };
        run(&args).unwrap();
        let before = std::fs::read(&args.out).unwrap();
        let reads = r##"{ "trochoid": 1, "format": { "width": 3, "height": 2 }, "working_space": "srgb",
            "nodes": { "picture": { "type": "Read", "as": "color", "file": "x.png" } }, "outputs": { "beauty": { "color": "picture" } } }"##;
        std::fs::write(&args.graph, reads).unwrap();
        let failure = run(&args).unwrap_err();
        assert!(failure.messages[0].text().contains("is an input of the document"), "{:?}", failure.messages);
        assert_eq!(std::fs::read(&args.out).unwrap(), before);
    }

    #[test]
    fn one_frame_is_a_still() {
        let folder = tempfile::tempdir().unwrap();
        let args = Args { frames: Some("4".into()), shrink: 3, ..args(folder.path(), "x.png") };
        run(&args).unwrap();
        let info = trochoid::io::info(&args.out, &trochoid::io::Limits::default()).unwrap();
        assert_eq!((info.parts[0].data.width(), info.parts[0].data.height()), (2, 1));
        let failure = run(&Args { frames: None, ..args }).unwrap_err();
        assert!(failure.messages[0].text().contains("4 frames"), "{:?}", failure.messages);
    }

    #[test]
    fn what_is_wrong_is_told_at_once_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let args = Args { frames: Some("x".into()), output: Some("beuty".into()), ..args(folder.path(), "x.gif") };
        let failure = run(&args).unwrap_err();
        assert_eq!((failure.code, failure.messages.len()), (crate::failure::INVALID, 3), "{:?}", failure.messages);
        assert!(!args.out.exists());
    }

    #[test]
    fn blocks_are_averaged_and_shown() {
        let loaded = trochoid::parse("graph.json", GRAPH, std::path::Path::new("."), &[]).unwrap();
        let picture = render(&loaded.graph, 0, 1, &mut Cache::new(), &Progress::new(1, true)).unwrap();
        // Columns hold 0, 51, … 255.
        assert_eq!(bytes(&shrink(&loaded.graph, &picture, 2))[..9], [26, 26, 26, 128, 128, 128, 230, 230, 230]);
        assert_eq!(shrink(&loaded.graph, &picture, 4)[2].len(), 2);
    }

    #[test]
    fn frames_last_until_the_next() {
        assert_eq!(times(&[1, 3, 4], 10.0), [0, 200, 300, 400]);
        assert_eq!(times(&[7], 24.0), [0, 42]);
    }
}
