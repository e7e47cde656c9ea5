//! `trochoid page`: recipes as one HTML file, whose colors can be changed in any browser.

mod cube;
mod html;
mod pack;
mod picture;
mod shrink;
mod sources;
mod weights;

use crate::failure::Failure;
use crate::files::{self, OverwriteOptions};
use crate::interrupt;
use crate::palette::named::{self, Named};
use crate::shell::{self, printable};
use picture::Picture;
use std::path::PathBuf;
use trochoid::{Form, WorkingSpace, in_bytes, nearest};

/// Options of `trochoid page`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The page needs no network and no other files. Each pixel differs from what `trochoid recolor` makes of the same colors by \
at most 1 of 255. Files in a row whose names differ only in the frame are frames of one picture; other files are pictures \
of their own, which the page offers by name.

Examples:
  trochoid page painting.recipe.exr --palette night.json --palette fall.gpl -o painting.html
  trochoid page 'recipes/storm.####.exr' --frames 1-48 --title 'The storm' -o storm.html
  trochoid page large.exr --width 1920 -o large.html")]
pub(crate) struct Args {
    /// The recipes; #### stands for the frame
    #[arg(value_name = "RECIPE", required = true)]
    recipes: Vec<PathBuf>,
    /// Frames of names with ####, such as 1-48
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<String>,
    /// Frames a second
    #[arg(long, value_name = "N", default_value_t = 24.0, value_parser = rate)]
    fps: f64,
    /// Offer the colors of this palette, by the file's name: JSON, .gpl, or a document that has one; may be repeated
    #[arg(long, value_name = "FILE")]
    palette: Vec<PathBuf>,
    /// Title of the page [default: the name of the first picture]
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// Make pictures that are wider than this smaller, in pixels
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    width: Option<u32>,
    /// The HTML file to write
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    over: OverwriteOptions,
    /// Print nothing on stdout
    #[arg(long)]
    quiet: bool,
}

/// Text that is no number of frames a second.
#[derive(Debug, thiserror::Error)]
#[error("expected a number from 1 to 120")]
struct NoRate;

fn rate(text: &str) -> Result<f64, NoRate> {
    text.parse().ok().filter(|rate| (1.0..=120.0).contains(rate)).ok_or(NoRate)
}

/// A palette that the page offers.
struct Offered {
    name: String,
    colors: Named,
}

/// Writes the page.
///
/// # Errors
/// All problems that can be found in advance, together; a recipe or a palette cannot be read, or they do not belong
/// together; or the page cannot be written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let out = &args.out;
    let cannot = || trochoid::check_destination(out).err().map(Failure::from);
    let foreign = || args.over.foreign(out, Form::Page);
    let mut faults: Vec<Failure> =
        files::ending("--out", out, "html").or_else(foreign).or_else(cannot).into_iter().collect();
    let sources = sources::find(&args.recipes, args.frames.as_deref()).unwrap_or_else(|found| {
        faults.push(found);
        Vec::new()
    });
    let inputs = sources.iter().flat_map(|source| &source.frames).map(|(_, path)| path).chain(&args.palette);
    if inputs.into_iter().any(|input| trochoid::resolved(input) == trochoid::resolved(out)) {
        faults.push(files::written_over(out));
    }
    // Names are compared once the recipes are known.
    faults.extend(args.palette.iter().filter_map(|path| named::read(path, WorkingSpace::Srgb).err()));
    Failure::all(faults)?;
    interrupt::watch()?;
    let pictures = picture::read(sources, args.width)?;
    let space = pictures[0].space;
    if let Some(other) = pictures.iter().find(|picture| picture.space != space) {
        let message = format!(
            "{}: found the working space {}; expected {space}, as in the pictures before it",
            other.name, other.space
        );
        return Err(Failure::usage(message, "make a page for each working space"));
    }
    let palettes = offered(args, &pictures)?;
    let title = args.title.clone().unwrap_or_else(|| pictures[0].name.clone());
    let line = told(&pictures);
    let page = html::page(&title, args.fps, pictures, &palettes);
    trochoid::write_guarded(out, page.as_bytes(), Form::Page, args.over.overwrite)?;
    if args.quiet {
        return Ok(());
    }
    shell::print(&format!("{line} → {}  {}\n", printable(&out.display().to_string()), in_bytes(page.len() as u64)))
}

/// Reads the palettes.
fn offered(args: &Args, pictures: &[Picture]) -> Result<Vec<Offered>, Failure> {
    let known: Vec<&str> = pictures.iter().flat_map(|picture| &picture.names).map(String::as_str).collect();
    let mut faults = Vec::new();
    let mut palettes = Vec::new();
    for path in &args.palette {
        let colors = named::read(path, pictures[0].space)?;
        for name in colors.names.iter().filter(|name| !known.contains(&name.as_str())) {
            let remedy = match nearest(name, known.iter().copied()) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => format!("the recipes have {}", known.join(", ")),
            };
            let message = format!("{}: found the color \"{name}\"; expected one of a recipe", path.display());
            faults.push(Failure::usage(message, remedy));
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        palettes.push(Offered { name, colors });
    }
    Failure::all(faults)?;
    Ok(palettes)
}

/// Returns what the page has, as a line.
fn told(pictures: &[Picture]) -> String {
    let farthest = pictures.iter().flat_map(|picture| &picture.frames).map(|frame| frame.farthest).fold(0.0, f64::max);
    let what = match pictures {
        [picture] => {
            let [width, height] = picture.size;
            let frames = match picture.frames.len() {
                1 => "1 frame".into(),
                count => format!("{count} frames"),
            };
            format!("{}: {frames}, {width} × {height} pixels, {} colors", printable(&picture.name), picture.names.len())
        }
        _ => format!("{} pictures", pictures.len()),
    };
    format!("{what}, within {farthest:.2} steps of 255")
}
