//! `trochoid decompose`: pictures as recipes, weights over the colors of a palette.
//!
//! `--graph` writes a document that repaints the picture, `--cube` a table of colors for other programs.
//!
//! The JSON output has `recipes`, a list of `{picture, files, outside, farthest}`: the number of pixels that are farther
//! outside of the palette's hull than the file's rounding moves a color, and the largest distance of a pixel, in steps of
//! 255. Each gets the weights of the nearest color in the hull.

use crate::failure::{FAILED, Failure};
use crate::files::{self, OverwriteOptions};
use crate::interrupt;
use crate::palette::named;
use crate::palette::source::{self, Pixels};
use crate::progress::Progress;
use crate::shell;
use rayon::prelude::*;
use serde_json::json;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use trochoid::{Form, Hull, Recipe, RecipeInfo, Rounding, Storing, Window, WorkingSpace, expand_frame};
use trochoid_palette::{Decomposer, MOST_COLORS};

mod cube;
mod graph;

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
  trochoid decompose shot.*.png --palette inks.json --out 'recipes/{name}.exr'
  trochoid decompose painting.jpg --palette inks.json --graph repainted.json
  trochoid decompose --palette inks.json --to night.json --cube night.cube")]
pub(crate) struct Args {
    /// The pictures: EXR, PNG, JPEG or TIFF
    #[arg(value_name = "PICTURE", required_unless_present = "cube")]
    pictures: Vec<PathBuf>,
    /// The palette: JSON, .gpl, or a document that has one; of at most 24 colors
    #[arg(long, value_name = "FILE")]
    palette: PathBuf,
    /// How much colors share: 0 for few colors a pixel, 1 for all of them everywhere
    #[arg(long, value_name = "T", default_value_t = 0.2, value_parser = softness)]
    softness: f64,
    /// Write the recipe to this EXR file; {name} stands for the picture's name without its extension
    #[arg(short, long, value_name = "FILE", requires = "pictures", required_unless_present_any = ["graph", "cube"])]
    out: Option<String>,
    /// Write a small document that takes the picture apart and mixes it again, of colors with names; {name} as in --out
    #[arg(long, value_name = "FILE", requires = "pictures")]
    graph: Option<String>,
    /// Write a 3-D LUT for other programs, which does to pictures what painting them in the colors of --to does
    #[arg(long, value_name = "FILE", requires = "to")]
    cube: Option<PathBuf>,
    /// The colors for --cube, by the names of the palette: JSON, .gpl, or a document
    #[arg(long, value_name = "FILE", requires = "cube")]
    to: Option<PathBuf>,
    /// Colors along each axis of the LUT
    #[arg(long, value_name = "N", default_value_t = 65, value_parser = clap::value_parser!(u16).range(2..=129), requires = "cube")]
    cube_size: u16,
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

/// Distance from the hull that evaluating in f32 makes.
const EVALUATED: f64 = 1e-6;

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
fn outputs(option: &str, pattern: &str, pictures: &[PathBuf], endings: &[&str]) -> Result<Vec<PathBuf>, Failure> {
    outputs_at(option, pattern, &pictures.iter().map(|picture| (picture.clone(), None)).collect::<Vec<_>>(), endings)
}

/// Names the file that is made of another one, of which some belong to frames.
///
/// # Errors
/// As [`outputs`].
pub(crate) fn outputs_at(
    option: &str,
    pattern: &str,
    pictures: &[(PathBuf, Option<i64>)],
    endings: &[&str],
) -> Result<Vec<PathBuf>, Failure> {
    let has_frame = expand_frame(pattern, 0) != expand_frame(pattern, 1);
    if let Some((picture, _)) = pictures.iter().find(|(_, frame)| has_frame && frame.is_none()) {
        let message = format!("{option} {pattern}: found no frame that {} belongs to", picture.display());
        return Err(Failure::usage(message, "write {name} where the picture's name belongs"));
    }
    if pictures.len() > 1 && !pattern.contains("{name}") && !has_frame {
        let message =
            format!("{option} {pattern}: found one name for {} pictures; expected {{name}} in it", pictures.len());
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
            let message = format!(
                "{option} {}: found the ending \".{ending}\"; expected .{}",
                out.display(),
                endings.join(" or .")
            );
            return Err(Failure::usage(message, "let the name end so"));
        }
        if outputs[..index].contains(out) {
            let message = format!("{option} {pattern}: found one name for two pictures, {}", out.display());
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
/// All problems that can be found in advance, together; a picture cannot be read; or a file cannot be written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let named = |option: &str, pattern: &Option<String>, ending: &str| match pattern {
        Some(pattern) => outputs(option, pattern, &args.pictures, &[ending]).map(Some),
        None => Ok(None),
    };
    let outs = named("--out", &args.out, "exr")?;
    let graphs = named("--graph", &args.graph, "json")?;
    if let Some(cube) =
        args.cube.as_ref().filter(|cube| !cube.extension().is_some_and(|e| e.eq_ignore_ascii_case("cube")))
    {
        let message = format!("--cube {}: found another ending; expected .cube", cube.display());
        return Err(Failure::usage(message, "let the name end so"));
    }
    let recipes = outs.iter().flatten().map(|out| (out, Form::Exr));
    let documents = graphs.iter().flatten().map(|out| (out, Form::Document));
    let written = recipes.chain(documents).chain(args.cube.iter().map(|out| (out, Form::Cube)));
    let mut faults: Vec<Failure> = Vec::new();
    for (out, form) in written {
        let cannot = || trochoid::check_destination(out).err().map(Failure::from);
        faults.extend(args.over.foreign(out, form).or_else(cannot));
    }
    Failure::all(faults)?;
    let inks = named::read(&args.palette, WorkingSpace::Srgb)?;
    let decomposer = Decomposer::new(&inks.colors, args.softness).ok_or_else(|| {
        let message =
            format!("{}: found {} colors; expected at most {MOST_COLORS}", args.palette.display(), inks.colors.len());
        Failure::usage(message, "leave colors out that nobody will change")
    })?;
    let table = args.cube.as_ref().map(|path| Ok::<_, Failure>((path, cube(args, &inks, &decomposer)?))).transpose()?;
    let hull = Hull::new(&inks.colors.iter().map(|color| color.map(|v| v as f32)).collect::<Vec<_>>());
    interrupt::watch()?;
    let mut progress = Progress::new(args.pictures.len(), args.quiet);
    let (mut text, mut all) = (String::new(), Vec::new());
    for (index, picture) in args.pictures.iter().enumerate() {
        progress.begin(index, index as i64 + 1);
        let Pixels { window, colors, rounding, .. } = source::pixels(picture, &progress)?;
        let distances = colors.par_iter().map(|color| hull.signed_distance(color.map(f64::from)));
        let (outside, farthest) = distances
            .map(|distance| (u64::from(distance > rounding + EVALUATED), distance.max(0.0)))
            .reduce(|| (0, 0.0), |a, b| (a.0 + b.0, a.1.max(b.1)));
        let mut files: Vec<&PathBuf> = Vec::new();
        if let Some(out) = outs.as_ref().map(|outs| &outs[index]) {
            let storing = if args.float { Storing::Float } else { Storing::Half };
            let made = decompose(&decomposer, &inks, window, &colors, storing);
            made.write(args.over.target(out, Form::Exr))
                .map_err(|error| Failure::new(FAILED, crate::remedies::written(&error)))?;
            files.push(out);
        }
        if let Some(out) = graphs.as_ref().map(|graphs| &graphs[index]) {
            let size = [window.width(), window.height()];
            let document = graph::document(out, picture, size, &inks, args.softness);
            trochoid::write_guarded(out, format!("{document:#}\n").as_bytes(), Form::Document, args.over.overwrite)?;
            files.push(out);
        }
        let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
        let _ = writeln!(text, "{}", line(picture, &names, outside, 255.0 * farthest, inks.names.len()));
        all.push(json!({
            "picture": picture.display().to_string(),
            "files": names,
            "outside": outside,
            "farthest": 255.0 * farthest,
        }));
    }
    progress.finish();
    if let Some((path, table)) = table {
        trochoid::write_guarded(path, table.as_bytes(), Form::Cube, args.over.overwrite)?;
        let _ = writeln!(text, "{}: {} colors along each axis", path.display(), args.cube_size);
    }
    if args.json {
        return shell::print_json(&json!({ "recipes": all }));
    }
    if args.quiet { Ok(()) } else { shell::print(&text) }
}

/// Returns the text of a LUT that paints pictures in the colors of `--to`.
fn cube(args: &Args, inks: &named::Named, decomposer: &Decomposer) -> Result<String, Failure> {
    let mut into = inks.colors.clone();
    let mut faults = Vec::new();
    if let Some(file) = &args.to {
        let to = named::read(file, WorkingSpace::Srgb)?;
        for (name, color) in to.names.iter().zip(to.colors) {
            match inks.names.iter().position(|own| own == name) {
                Some(index) => into[index] = color,
                None => {
                    let near = trochoid::nearest(name, inks.names.iter().map(String::as_str));
                    let remedy = match near {
                        Some(near) => format!("did you mean \"{near}\"?"),
                        None => format!("{} has {}", args.palette.display(), inks.names.join(", ")),
                    };
                    let found = format!("{}: found the color \"{name}\"; expected one of the palette", file.display());
                    faults.push(Failure::usage(found, remedy));
                }
            }
        }
    }
    Failure::all(faults)?;
    let title = |path: &PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let titles = [title(&args.palette), args.to.as_ref().map(title).unwrap_or_default()];
    Ok(cube::text(&titles.join(" to "), decomposer, &into, usize::from(args.cube_size)))
}

fn line(picture: &Path, files: &[String], outside: u64, farthest: f64, colors: usize) -> String {
    let exact = match outside {
        0 if farthest > 255.0 * EVALUATED => "every pixel is a mix of them, up to the rounding of the file".into(),
        0 => "every pixel is a mix of them".into(),
        1 => format!("1 pixel outside of their hull, by {farthest:.1} steps of 255"),
        _ => format!("{outside} pixels outside of their hull, by up to {farthest:.1} steps of 255"),
    };
    let files = if files.is_empty() { "no file".into() } else { files.join(", ") };
    format!("{} → {files}: {colors} colors, {exact}", picture.display())
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
