//! `trochoid recolor`: paints recipes in other colors.

use crate::decompose::outputs;
use crate::failure::{FAILED, Failure};
use crate::files::OverwriteOptions;
use crate::palette::named;
use crate::remedies;
use crate::shell;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use trochoid::io::{ExrChannel, ExrImage, PngImage, Samples, write_exr, write_png8, write_png16};
use trochoid::{Form, Plane, Recipe, RecipeError, WorkingSpace, marks, nearest, srgb_encode};

/// Options of `trochoid recolor`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A recipe has the weights of a picture over colors with names; `trochoid decompose` makes one. Colors that the palette does \
not name stay as they are.

Examples:
  trochoid recolor painting.recipe.exr --palette night.json --out night.png
  trochoid recolor painting.recipe.exr --set glow=#f2c14e --out warm.exr
  trochoid recolor recipes/*.exr --palette night.json --out 'night/{name}.png'")]
pub(crate) struct Args {
    /// The recipes
    #[arg(value_name = "RECIPE", required = true)]
    recipes: Vec<PathBuf>,
    /// Take the colors of this palette: JSON, .gpl, or a document that has one
    #[arg(long, value_name = "FILE")]
    palette: Option<PathBuf>,
    /// Set a color, such as glow=#f2c14e; may be repeated
    #[arg(long, value_name = "NAME=#RRGGBB")]
    set: Vec<String>,
    /// Write the picture to this PNG or EXR file; {name} stands for the recipe's name without its extension
    #[arg(short, long, value_name = "FILE")]
    out: String,
    /// Write PNG with 16 bits a channel
    #[arg(long)]
    deep: bool,
    #[command(flatten)]
    over: OverwriteOptions,
    /// Print nothing on stdout
    #[arg(long)]
    quiet: bool,
}

/// Recolors recipes.
///
/// # Errors
/// All problems that can be found in advance, together; a recipe cannot be read, or lacks a color; or a picture cannot be
/// written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let outs = outputs(&args.out, &args.recipes, &["png", "exr"])?;
    let mut faults: Vec<Failure> = Vec::new();
    for out in &outs {
        let cannot = || trochoid::check_destination(out).err().map(Failure::from);
        faults.extend(args.over.foreign(out, Form::of_picture(out)).or_else(cannot));
    }
    Failure::all(faults)?;
    let mut text = String::new();
    for (path, out) in args.recipes.iter().zip(&outs) {
        let recipe = Recipe::read(path).map_err(|error| match error {
            RecipeError::Read(error) => Failure::new(FAILED, error),
            error @ RecipeError::NoRecipe { .. } => Failure::usage(error, "make one: trochoid decompose PICTURE"),
        })?;
        let colors = colors(args, path, &recipe)?;
        write(args, out, recipe.space, &recipe.recolor(&colors))?;
        let _ = writeln!(text, "{} → {}", path.display(), out.display());
    }
    if args.quiet { Ok(()) } else { shell::print(&text) }
}

/// Returns the colors in which a recipe is painted.
fn colors(args: &Args, path: &Path, recipe: &Recipe) -> Result<Vec<[f64; 3]>, Failure> {
    let mut colors = recipe.colors.clone();
    let mut faults: Vec<Failure> = Vec::new();
    let mut put = |name: &str, color: [f64; 3], from: &str| match recipe.names.iter().position(|own| own == name) {
        Some(index) => colors[index] = color,
        None => {
            let remedy = match nearest(name, recipe.names.iter().map(String::as_str)) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => format!("{} has {}", path.display(), recipe.names.join(", ")),
            };
            faults.push(Failure::usage(
                format!("{from}: found the color \"{name}\"; expected one of the recipe"),
                remedy,
            ));
        }
    };
    if let Some(file) = &args.palette {
        let palette = named::read(file, recipe.space)?;
        let from = file.display().to_string();
        palette.names.iter().zip(&palette.colors).for_each(|(name, color)| put(name, *color, &from));
    }
    for assignment in &args.set {
        let parsed =
            assignment.split_once('=').and_then(|(name, color)| Some((name, trochoid::parse_hex(color).ok()?)));
        match parsed {
            Some((name, color)) => {
                let linear = color.map(trochoid::srgb_decode);
                put(name, recipe.space.from_linear_srgb(linear), &format!("--set {assignment}"));
            }
            None => {
                let message = format!("--set {assignment}: expected NAME=#rrggbb, for example glow=#f2c14e");
                return Err(Failure::usage(message, "name a color of the recipe"));
            }
        }
    }
    Failure::all(faults)?;
    Ok(colors)
}

/// Writes a picture of the working space: PNG as displayed, EXR as linear light.
fn write(args: &Args, out: &Path, space: WorkingSpace, planes: &[Plane; 3]) -> Result<(), Failure> {
    let window = planes[0].window();
    let form = Form::of_picture(out);
    let convert = |f: &dyn Fn([f64; 3]) -> [f64; 3]| -> Vec<[f32; 3]> {
        let [r, g, b] = planes.each_ref().map(Plane::samples);
        let pixels = r.iter().zip(g).zip(b).map(|((r, g), b)| f([*r, *g, *b].map(f64::from)));
        pixels.map(|color| color.map(|channel| channel as f32)).collect()
    };
    let target = args.over.target(out, form);
    let done = if form == Form::Png {
        let pixels = convert(&|color| space.to_linear_srgb(color).map(srgb_encode));
        let image = PngImage::new(window.width() as u32, window.height() as u32, Samples::rgb(&pixels));
        let image = PngImage { clamp: true, metadata: marks(form), ..image };
        if args.deep { write_png16(target, &image) } else { write_png8(target, &image) }
    } else {
        let pixels = convert(&|color| space.to_linear_srgb(color));
        let channels = ["R", "G", "B"].into_iter().zip(Samples::rgb(&pixels));
        let channels = channels.map(|(name, samples)| ExrChannel::half(name, samples)).collect();
        write_exr(target, &ExrImage { channels, metadata: marks(form), ..ExrImage::new(window) })
    };
    done.map_err(|error| Failure::new(FAILED, remedies::written(&error)))
}
