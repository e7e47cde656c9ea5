//! `trochoid recolor`: paints recipes in other colors.
//!
//! The JSON output has `pictures`, a list of `{recipe, file, colors, outside, within}`: the number of pixels outside of the
//! hull of the colors, null if images contribute, and the largest difference of a channel from a render in the same
//! colors, in the working space.

use crate::decompose::outputs_at;
use crate::failure::Failure;
use crate::files::OverwriteOptions;
use crate::palette::named::{self, Named};
use crate::progress::Progress;
use crate::{frames, interrupt, remedies, shell};
use painting::{Painting, Written};
use serde_json::json;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use trochoid::{Form, PaletteColor, RecipeReader, WorkingSpace, expand_frame, nearest};

mod painting;

/// Options of `trochoid recolor`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A recipe has the weights of a picture over colors with names; `trochoid render --recipe` and `trochoid decompose` make \
one. Colors that the palette does not name stay as they are. The picture is the one that a render in these colors would \
make, up to what storing the weights rounds, which is printed.

Examples:
  trochoid recolor painting.recipe.exr --palette night.json --out night.png
  trochoid recolor painting.recipe.exr --set glow=#f2c14e --out warm.exr
  trochoid recolor storm.recipe.####.exr --frames 1-96 --palette night.json --out 'night.####.png'
  trochoid recolor recipes/*.exr --palette night.json --out 'night/{name}.png'")]
pub(crate) struct Args {
    /// The recipes; with --frames, #### or %04d stands for the frame
    #[arg(value_name = "RECIPE", required = true)]
    recipes: Vec<PathBuf>,
    /// Frames of the recipes, such as 1-10,20-40x2
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<String>,
    /// Take the colors of this palette: JSON, .gpl, or a document that has one
    #[arg(long, value_name = "FILE")]
    palette: Option<PathBuf>,
    /// Set a color, such as glow=#f2c14e; may be repeated
    #[arg(long, value_name = "NAME=#RRGGBB")]
    set: Vec<String>,
    /// Write the picture to this PNG or EXR file; {name} stands for the recipe's name without its extension, #### or %04d
    /// for the frame
    #[arg(short, long, value_name = "FILE")]
    out: String,
    /// Write PNG with 16 bits a channel
    #[arg(long)]
    deep: bool,
    /// Write EXR with 32-bit floats
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

/// Recolors recipes.
///
/// # Errors
/// All problems that can be found in advance, together; a recipe cannot be read, or lacks a color; or a picture cannot be
/// written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let recipes = recipes(args)?;
    // Headers name the frames of recipes that are given one by one.
    let frame = |(path, frame): &(PathBuf, Option<i64>)| {
        let known =
            RecipeReader::open(path).ok().and_then(|recipe| recipe.info().source.as_ref().map(|source| source.1));
        (path.clone(), frame.or(known))
    };
    let recipes: Vec<(PathBuf, Option<i64>)> = recipes.iter().map(frame).collect();
    let outs = outputs_at("--out", &args.out, &recipes, &["png", "exr"])?;
    let mut faults: Vec<Failure> = Vec::new();
    for out in &outs {
        let cannot = || trochoid::check_destination(out).err().map(Failure::from);
        faults.extend(args.over.foreign(out, Form::of_picture(out)).or_else(cannot));
    }
    Failure::all(faults)?;
    interrupt::watch()?;
    let mut progress = Progress::new(recipes.len(), args.quiet);
    // Palettes by working space: recipes of one run usually share it.
    let (mut palettes, mut all) = (Vec::new(), Vec::new());
    for (index, ((path, frame), out)) in recipes.iter().zip(&outs).enumerate() {
        progress.begin(index, frame.unwrap_or(index as i64 + 1));
        let recipe = opened(path)?;
        let space = recipe.info().space;
        if let Some(file) = args.palette.as_ref().filter(|_| !palettes.iter().any(|(known, _)| *known == space)) {
            palettes.push((space, named::keyed(file, space)?));
        }
        let palette = palettes.iter().find(|(known, _)| *known == space).map(|(_, palette)| &palette[..]);
        let colors = colors(args, path, &recipe, palette.unwrap_or_default(), frame.unwrap_or(1))?;
        let painting = Painting { recipe: &recipe, colors: &colors, is_deep: args.deep, is_float: args.float };
        let written = painting.write(out, args.over, &progress)?;
        if args.json {
            all.push(json!({
                "recipe": path.display().to_string(),
                "file": out.display().to_string(),
                "colors": recipe.info().names.len(),
                "outside": written.outside,
                "within": written.bound,
            }));
        } else if !args.quiet {
            progress.print(&line(path, out, &recipe, &written))?;
        }
    }
    progress.finish();
    if args.json { shell::print_json(&json!({ "pictures": all })) } else { Ok(()) }
}

/// Returns the paths of the recipes, each with its frame if the command line says it.
fn recipes(args: &Args) -> Result<Vec<(PathBuf, Option<i64>)>, Failure> {
    let has_frame = |path: &&PathBuf| {
        let pattern = path.to_string_lossy();
        expand_frame(&pattern, 0) != expand_frame(&pattern, 1)
    };
    let Some(list) = &args.frames else {
        // A file may have such a name.
        if let Some(path) = args.recipes.iter().filter(has_frame).find(|path| !path.exists()) {
            let message = format!("{}: found a pattern of frames; expected --frames", path.display());
            return Err(Failure::usage(message, "say which: --frames 1-96"));
        }
        return Ok(args.recipes.iter().map(|path| (path.clone(), None)).collect());
    };
    let frames = frames::parse(list).map_err(|pieces| {
        let faults = pieces.into_iter().map(|piece| Failure::usage(piece, "use a list such as 1-10,20-40x2"));
        Failure::all(faults).err().unwrap_or_default()
    })?;
    if let Some(path) = args.recipes.iter().find(|path| !has_frame(path)) {
        let message = format!("{}: found one name for all frames; expected #### or %04d in it", path.display());
        return Err(Failure::usage(message, "write #### where the frame belongs, or leave out --frames"));
    }
    let of = |path: &PathBuf| {
        let pattern = path.to_string_lossy().into_owned();
        let file = move |frame: &i64| (PathBuf::from(expand_frame(&pattern, *frame)), Some(*frame));
        frames.iter().map(file).collect::<Vec<_>>()
    };
    Ok(args.recipes.iter().flat_map(of).collect())
}

fn opened(path: &Path) -> Result<RecipeReader, Failure> {
    RecipeReader::open(path).map_err(|error| remedies::recipe(&error))
}

/// Formats the line of a picture: `a.exr → night.png: 24 colors, hull, 0 outside, within 0.12/255`.
fn line(path: &Path, out: &Path, recipe: &RecipeReader, written: &Written) -> String {
    let mut line = format!("{} → {}: ", path.display(), out.display());
    let unit = if recipe.info().space == WorkingSpace::Srgb { "" } else { " of linear light" };
    let hull = match written.outside {
        Some(outside) => format!("hull, {outside} outside"),
        None => "hull not judged, because of images".into(),
    };
    let (count, bound) = (recipe.info().names.len(), 255.0 * written.bound);
    let _ = writeln!(line, "{count} colors, {hull}, within {bound:.2}/255{unit}");
    line
}

/// Returns the colors in which a recipe is painted.
fn colors(
    args: &Args,
    path: &Path,
    recipe: &RecipeReader,
    palette: &[PaletteColor],
    frame: i64,
) -> Result<Vec<[f64; 3]>, Failure> {
    let info = recipe.info();
    let mut colors = info.colors.clone();
    let (mut faults, mut unread) = (Vec::new(), Vec::new());
    // `None` is a color that cannot be read.
    let mut put = |name: &str, color: Option<[f64; 3]>, from: &str| match info.names.iter().position(|own| own == name)
    {
        Some(index) => colors[index] = color.unwrap_or(colors[index]),
        // A color of the document that is not in this picture.
        None if info.unused.iter().any(|unused| unused == name) => {}
        None => {
            let remedy = match nearest(name, info.names.iter().map(String::as_str)) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => format!("{} has {}", path.display(), info.names.join(", ")),
            };
            faults.push(Failure::usage(
                format!("{from}: found the color \"{name}\"; expected one of the recipe"),
                remedy,
            ));
        }
    };
    if let Some(file) = &args.palette {
        let from = file.display().to_string();
        let Named { names, colors } = Named::at(palette, frame);
        names.iter().zip(colors).for_each(|(name, color)| put(name, Some(color), &from));
    }
    for assignment in &args.set {
        let from = format!("--set {assignment}");
        let Some((name, text)) = assignment.split_once('=') else {
            let message = format!("{from}: found no =; expected NAME=#rrggbb");
            unread.push(Failure::usage(message, "set a color of the recipe, such as glow=#f2c14e"));
            continue;
        };
        // As render names it.
        let name = name.strip_prefix("palette.").unwrap_or(name);
        let parsed = trochoid::parse_hex(text).map(|color| {
            // As in documents, where colors are ≥ 0.
            info.space.from_linear_srgb(color.map(trochoid::srgb_decode)).map(|channel| channel.max(0.0))
        });
        if parsed.is_err() {
            let message = format!("{from}: found \"{text}\" as the color; expected #rrggbb or #rgb");
            unread.push(Failure::usage(message, format!("write its hexadecimal digits, such as {name}=#f2c14e")));
        }
        put(name, parsed.ok(), &from);
    }
    faults.extend(unread);
    Failure::all(faults)?;
    Ok(colors)
}
