//! `trochoid decompose`: pictures as recipes, weights over the colors of a palette.
//!
//! The JSON output has `recipes`, a list of `{picture, file, outside, farthest}`: the number of pixels outside of the
//! palette's hull, which get the weights of the nearest color in it, and the largest distance of one, in steps of 255.

use crate::failure::{FAILED, Failure};
use crate::files::{self, OverwriteOptions};
use crate::interrupt;
use crate::palette::{named, source};
use crate::progress::Progress;
use crate::shell;
use rayon::prelude::*;
use serde_json::json;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use trochoid::{Form, Hull, Recipe, RecipeInfo, Rounding, Storing, Window, WorkingSpace, expand_frame};
use trochoid_palette::{Decomposer, MOST_COLORS};

/// Options of `trochoid decompose`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Weights are a function of the color alone: the same color has the same weights in every picture and every frame. They are \
≥ 0, and as stored they sum to exactly 1. A pixel outside of the palette's hull gets the weights of the nearest color in \
it; `trochoid palette` finds palettes without such pixels.

Examples:
  trochoid palette painting.jpg --out inks.json
  trochoid decompose painting.jpg --palette inks.json --out painting.recipe.exr
  trochoid recolor painting.recipe.exr --palette night.json --out night.png
  trochoid decompose shot.*.png --palette inks.json --out 'recipes/{name}.exr'")]
pub(crate) struct Args {
    /// The pictures: EXR, PNG, JPEG or TIFF
    #[arg(value_name = "PICTURE", required = true)]
    pictures: Vec<PathBuf>,
    /// The palette: JSON, .gpl, or a document that has one; of at most 24 colors
    #[arg(long, value_name = "FILE")]
    palette: PathBuf,
    /// How much colors share: 0 for few colors a pixel, 1 for all of them everywhere
    #[arg(long, value_name = "T", default_value_t = 0.2, value_parser = softness)]
    softness: f64,
    /// Write the recipe to this EXR file; {name} stands for the picture's name without its extension
    #[arg(short, long, value_name = "FILE")]
    out: String,
    /// Store 32-bit floats: the sums are exact either way, the colors by 1/255 or better
    #[arg(long)]
    float: bool,
    #[command(flatten)]
    over: OverwriteOptions,
    /// Print nothing on stdout, and show no progress
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Text that is no softness.
#[derive(Debug, thiserror::Error)]
#[error("expected a number from 0 to 1")]
struct NoSoftness;

fn softness(text: &str) -> Result<f64, NoSoftness> {
    text.parse().ok().filter(|softness| (0.0..=1.0).contains(softness)).ok_or(NoSoftness)
}

/// Names the file that is made of another one.
///
/// # Errors
/// Several files would have one name, or the name does not end as it must.
pub(crate) fn outputs(pattern: &str, pictures: &[PathBuf], endings: &[&str]) -> Result<Vec<PathBuf>, Failure> {
    outputs_at(pattern, &pictures.iter().map(|picture| (picture.clone(), None)).collect::<Vec<_>>(), endings)
}

/// Names the file that is made of another one, of which some belong to frames.
///
/// # Errors
/// As [`outputs`].
pub(crate) fn outputs_at(
    pattern: &str,
    pictures: &[(PathBuf, Option<i64>)],
    endings: &[&str],
) -> Result<Vec<PathBuf>, Failure> {
    let has_frame = expand_frame(pattern, 0) != expand_frame(pattern, 1);
    if let Some((picture, _)) = pictures.iter().find(|(_, frame)| has_frame && frame.is_none()) {
        let message = format!("--out {pattern}: found no frame that {} belongs to", picture.display());
        return Err(Failure::usage(message, "write {name} where the picture's name belongs"));
    }
    if pictures.len() > 1 && !pattern.contains("{name}") && !has_frame {
        let message =
            format!("--out {pattern}: found one name for {} pictures; expected {{name}} in it", pictures.len());
        return Err(Failure::usage(message, "write {name} where the picture's name belongs"));
    }
    let of = |(picture, frame): &(PathBuf, Option<i64>)| {
        let name = picture.file_stem().unwrap_or_default().to_string_lossy();
        let named = |pattern: &str| pattern.replace("{name}", &name);
        PathBuf::from(
            frame.filter(|_| has_frame).map_or_else(|| named(pattern), |frame| named(&expand_frame(pattern, frame))),
        )
    };
    let outputs: Vec<PathBuf> = pictures.iter().map(of).collect();
    for (index, out) in outputs.iter().enumerate() {
        let ending = out.extension().map_or(String::new(), |ending| ending.to_string_lossy().to_lowercase());
        if !endings.contains(&ending.as_str()) {
            let message =
                format!("--out {}: found the ending \".{ending}\"; expected .{}", out.display(), endings.join(" or ."));
            return Err(Failure::usage(message, "let the name end so"));
        }
        if outputs[..index].contains(out) {
            let message = format!("--out {pattern}: found one name for two pictures, {}", out.display());
            return Err(Failure::usage(message, "take pictures of different names, or one folder at a time"));
        }
        if pictures.iter().any(|(picture, _)| trochoid::resolved(picture) == trochoid::resolved(out)) {
            return Err(files::written_over(out));
        }
    }
    Ok(outputs)
}

/// Decomposes pictures.
///
/// # Errors
/// All problems that can be found in advance, together; a picture cannot be read; or a recipe cannot be written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let outs = outputs(&args.out, &args.pictures, &["exr"])?;
    let mut faults: Vec<Failure> = Vec::new();
    for out in &outs {
        let cannot = || trochoid::check_destination(out).err().map(Failure::from);
        faults.extend(args.over.foreign(out, Form::Exr).or_else(cannot));
    }
    Failure::all(faults)?;
    let inks = named::read(&args.palette, WorkingSpace::Srgb)?;
    let decomposer = Decomposer::new(&inks.colors, args.softness).ok_or_else(|| {
        let message =
            format!("{}: found {} colors; expected at most {MOST_COLORS}", args.palette.display(), inks.colors.len());
        Failure::usage(message, "leave colors out that nobody will change")
    })?;
    let hull = Hull::new(&inks.colors.iter().map(|color| color.map(|v| v as f32)).collect::<Vec<_>>());
    interrupt::watch()?;
    let mut progress = Progress::new(args.pictures.len(), args.quiet);
    let (mut text, mut all) = (String::new(), Vec::new());
    for (index, (picture, out)) in args.pictures.iter().zip(&outs).enumerate() {
        progress.begin(index, index as i64 + 1);
        let (window, colors) = source::colors(picture, &progress)?;
        let storing = if args.float { Storing::Float } else { Storing::Half };
        let made = decompose(&decomposer, &inks, window, &colors, storing);
        let distances = colors.par_iter().map(|color| hull.signed_distance(color.map(f64::from)));
        let (outside, farthest) = distances
            .map(|distance| if distance > 1e-6 { (1_u64, distance) } else { (0, 0.0) })
            .reduce(|| (0, 0.0), |a, b| (a.0 + b.0, a.1.max(b.1)));
        made.write(args.over.target(out, Form::Exr))
            .map_err(|error| Failure::new(FAILED, crate::remedies::written(&error)))?;
        let _ = writeln!(text, "{}", line(picture, out, outside, 255.0 * farthest, inks.names.len()));
        all.push(json!({
            "picture": picture.display().to_string(),
            "file": out.display().to_string(),
            "outside": outside,
            "farthest": 255.0 * farthest,
        }));
    }
    progress.finish();
    if args.json {
        return shell::print_json(&json!({ "recipes": all }));
    }
    if args.quiet { Ok(()) } else { shell::print(&text) }
}

fn line(picture: &Path, out: &Path, outside: u64, farthest: f64, colors: usize) -> String {
    let exact = match outside {
        0 => "every pixel is a mix of them".into(),
        _ => format!("{outside} pixels outside of their hull, by up to {farthest:.1} steps of 255"),
    };
    format!("{} → {}: {colors} colors, {exact}", picture.display(), out.display())
}

/// Returns the recipe of a picture.
fn decompose(
    decomposer: &Decomposer,
    inks: &named::Named,
    window: Window,
    colors: &[[f32; 3]],
    storing: Storing,
) -> Recipe {
    let (channels, moved) = decomposer.planes(colors, storing);
    Recipe {
        info: RecipeInfo {
            names: inks.names.clone(),
            colors: inks.colors.clone(),
            space: WorkingSpace::Srgb,
            has_images: false,
            layer: "recipe".into(),
            storing,
            source: None,
            unused: Vec::new(),
        },
        rounding: Rounding { moved, images: 0.0 },
        window,
        channels,
    }
}
