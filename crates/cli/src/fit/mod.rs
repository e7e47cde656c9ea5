//! `trochoid fit`: the colors in which a picture comes nearest to a painting.
//!
//! The JSON output has `palette`, the file; `before` and `after`, the distances of picture and painting: that of the
//! sliced clouds of pixels in OKLab, or the root mean square of displayed values with `--aligned`; and `colors`, a list of
//! `{name, before, after, share}`.

mod aligned;
mod lab;
mod painting;
mod picture;
mod sliced;
pub(crate) mod source;

use crate::changes::Changes;
use crate::failure::Failure;
use crate::files::{self, AccessOptions, OverwriteOptions};
use crate::palette::write;
use crate::progress::Progress;
use crate::{interrupt, shell, warnings};
use painting::Painting;
use serde_json::{Value, json};
use source::Source;
use std::fmt::Write as _;
use std::path::PathBuf;
use trochoid::nearest;
use trochoid_palette::Palette;

/// Options of `trochoid fit`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Only colors with names change, those of the document's palette or of the recipe; where they lie in the picture does not. \
Without --aligned, the picture gets the colors of the painting wherever they are; with it, those of the same motif, pixel \
by pixel, scaled to the picture.

Examples:
  trochoid fit storm.json painting.jpg --frame 36 --out painted.json
  trochoid render storm.json --frames 36 --palette painted.json
  trochoid fit storm.recipe.exr painting.jpg --keep 0.1 --fix white --out painted.json
  trochoid fit repaint.json photo.png --aligned --out photo.gpl")]
pub(crate) struct Args {
    /// The picture: a document, or a recipe as `render --recipe` and `decompose` write it
    #[arg(value_name = "PICTURE")]
    picture: PathBuf,
    /// The painting: EXR, PNG, JPEG or TIFF
    #[arg(value_name = "PAINTING")]
    painting: PathBuf,
    /// Write the palette to this .json or .gpl file
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Frame of the document [default: its first]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    frame: Option<i64>,
    /// Output of the document [default: its first color]
    #[arg(long, value_name = "NAME")]
    output: Option<String>,
    /// Compare pixel by pixel
    #[arg(long)]
    aligned: bool,
    /// How strongly colors stay as they are, from 0 [default: 0.2, or 0.001 with --aligned]
    #[arg(long, value_name = "K", value_parser = keep)]
    keep: Option<f64>,
    /// Leave this color as it is; may be repeated
    #[arg(long, value_name = "NAME")]
    fix: Vec<String>,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    reach: AccessOptions,
    #[command(flatten)]
    over: OverwriteOptions,
    /// Print nothing on stdout, and show no progress
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Pixels that are compared one by one: more change no color that one sees.
const ALIGNED: usize = 200_000;

/// Text that is no strength.
#[derive(Debug, thiserror::Error)]
#[error("expected a number from 0")]
struct NoStrength;

fn keep(text: &str) -> Result<f64, NoStrength> {
    text.parse().ok().filter(|keep: &f64| keep.is_finite() && *keep >= 0.0).ok_or(NoStrength)
}

/// What was found.
struct Fitted {
    /// Indices of the colors that were free.
    free: Vec<usize>,
    /// All colors, as displayed, on the grid of 8 bits.
    colors: Vec<[f64; 3]>,
    /// Mean weights of the free colors.
    shares: Vec<f64>,
    before: f64,
    after: f64,
}

/// Fits a palette.
///
/// # Errors
/// All problems that can be found in advance, together; a file cannot be read or written, or is of the wrong kind; no color
/// is free.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let form = write::form(&args.out).filter(|form| *form != trochoid::Form::Swatches);
    let Some(form) = form else { return Err(write::no_form(&args.out)) };
    let inputs = [&args.picture, &args.painting];
    if inputs.iter().any(|input| trochoid::resolved(input) == trochoid::resolved(&args.out)) {
        return Err(files::written_over(&args.out));
    }
    let cannot = || trochoid::check_destination(&args.out).err().map(Failure::from);
    Failure::all(args.over.foreign(&args.out, form).or_else(cannot))?;
    interrupt::watch()?;
    let mut progress = Progress::new(1, args.quiet);
    progress.begin(0, args.frame.unwrap_or(1));
    let source = source(args, &progress)?;
    let free = free(&source, args)?;
    source::check_interrupted()?;
    let fitted = fitted(&source, free, args, &progress)?;
    source::check_interrupted()?;
    progress.finish();
    let names = fitted.free.iter().map(|index| source.names[*index].clone()).collect();
    let colors = fitted.free.iter().map(|index| fitted.colors[*index]).collect();
    write::write(&args.out, &Palette { colors, names, units: 1 }, &args.over)?;
    told(&source, &fitted, args)
}

/// Returns the picture's weights.
fn source(args: &Args, progress: &Progress) -> Result<Source, Failure> {
    let is_document = args.picture.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("exr"));
    if !is_document {
        let given = [("--frame", args.frame.is_some()), ("--output", args.output.is_some())];
        let given = given.into_iter().chain([("--set or --palette", !args.changes.assignments().is_empty())]);
        Failure::all(given.filter(|(_, is_given)| *is_given).map(|(option, _)| {
            Failure::usage(format!("{option}: found a recipe; expected a document"), "leave it out, or name a document")
        }))?;
        return Source::of_recipe(&args.picture);
    }
    let loaded = args.reach.load(&args.picture, &args.changes.assignments())?;
    let output = source::output(&loaded.graph, args.output.as_deref())?;
    let warned = warnings::of(&loaded.graph, &[output], loaded.warnings);
    shell::tell(&crate::remedies::texts(&warned));
    let frame = args.frame.unwrap_or(loaded.graph.frames().0);
    Source::of_graph(&loaded.graph, output, frame, None, progress)
}

/// Returns the colors that may change: those with names, but not the fixed ones.
fn free(source: &Source, args: &Args) -> Result<Vec<usize>, Failure> {
    // Literals are named by their place, such as sea.a, which no palette can replace.
    let has_name = |name: &String| !name.contains('.');
    let unknown = args.fix.iter().filter(|name| !source.names.contains(name)).map(|name| {
        let near = nearest(name, source.names.iter().map(String::as_str));
        let remedy = near
            .map_or_else(|| format!("it has {}", source.names.join(", ")), |near| format!("did you mean \"{near}\"?"));
        Failure::usage(format!("--fix {name}: found no such color; expected one of the picture"), remedy)
    });
    Failure::all(unknown)?;
    let named = source.names.iter().enumerate().filter(|(_, name)| has_name(name) && !args.fix.contains(name));
    let free: Vec<usize> = named.map(|(index, _)| index).collect();
    if free.is_empty() {
        let message = format!("{}: found no color that may change; expected a palette", args.picture.display());
        return Err(Failure::usage(message, "give the document's colors names in its \"palette\", or fix fewer"));
    }
    Ok(free)
}

/// Finds the colors.
fn fitted(source: &Source, free: Vec<usize>, args: &Args, progress: &Progress) -> Result<Fitted, Failure> {
    let space = source.space;
    let pixels = source.pixels(ALIGNED);
    let picture = source.weighed(&free, &pixels);
    let before: Vec<[f64; 3]> = free.iter().map(|index| source.colors[*index]).collect();
    let painting = match args.aligned {
        true => Painting::aligned(&args.painting, [source.width, source.height], &pixels, progress)?,
        false => Painting::cloud(&args.painting, progress)?,
    };
    let found = painting.fit(&picture, &before, args.keep, space);
    // As the file has them.
    let rounded: Vec<[f64; 3]> = found
        .iter()
        .map(|color| space.to_display(*color).map(|v| (255.0 * v.clamp(0.0, 1.0)).round() / 255.0))
        .collect();
    let stored: Vec<[f64; 3]> =
        rounded.iter().map(|color| space.from_linear_srgb(color.map(trochoid::srgb_decode))).collect();
    let [before, after] = [&before, &stored].map(|colors| painting.distance(&picture, colors, space));
    let mut colors: Vec<[f64; 3]> = source.colors.iter().map(|color| space.to_display(*color)).collect();
    free.iter().zip(&rounded).for_each(|(index, color)| colors[*index] = *color);
    Ok(Fitted { shares: picture.shares(), free, colors, before, after })
}

/// Prints the result.
fn told(source: &Source, fitted: &Fitted, args: &Args) -> Result<(), Failure> {
    let hex = |color: [f64; 3]| write::hex(color.map(|v| v.clamp(0.0, 1.0)));
    let before = |index: &usize| hex(source.space.to_display(source.colors[*index]));
    let (out, unit) = (args.out.display(), if args.aligned { "rms, of 1" } else { "in OKLab" });
    if args.json {
        let color = |(index, share): (&usize, &f64)| -> Value {
            let after = hex(fitted.colors[*index]);
            json!({ "name": source.names[*index], "before": before(index), "after": after, "share": share })
        };
        let colors: Vec<Value> = fitted.free.iter().zip(&fitted.shares).map(color).collect();
        let Fitted { before, after, .. } = fitted;
        return shell::print_json(&json!({
            "palette": out.to_string(), "before": before, "after": after, "colors": colors,
        }));
    }
    if args.quiet {
        return Ok(());
    }
    let mut text = String::new();
    let width = fitted.free.iter().map(|index| source.names[*index].chars().count()).max().unwrap_or(0);
    for (index, share) in fitted.free.iter().zip(&fitted.shares) {
        let name = &source.names[*index];
        let share = 100.0 * share;
        let after = hex(fitted.colors[*index]);
        let _ = writeln!(text, "  {name:width$}  {} → {after}  {share:5.1} %", before(index));
    }
    let _ = writeln!(text, "{out}: distance {:.4} → {:.4} {unit}", fitted.before, fitted.after);
    shell::print(&text)
}
