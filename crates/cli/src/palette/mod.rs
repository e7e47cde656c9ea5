//! `trochoid palette`: few colors whose hull encloses every pixel of pictures.
//!
//! The JSON output has `pictures`; `pixels`; `distinct`, the number of different colors, rounded to 8 bits; `corners`,
//! of their hull; `brighter`, the number of pixels with a channel beyond white, which count as white there; `ignored`,
//! the number of pixels left out by --ignore; `outside` and `outside_largest`, how many of them lie outside of the
//! palette, and by how many steps of 8 bits at most; `enclosing`, a list of `{colors, names, units, volume, distances,
//! usual}`, palettes that enclose every pixel: displayed colors from 0 to 1, parts into which their grid divides a step
//! of 8 bits, the volume of their hull relative to that of the pixels' hull, and the distance of each color from the
//! nearest pixel in steps of 8 bits; `short`, a list of `{colors, outside, largest, rms}`, palettes of fewer colors:
//! the share of the pixels outside of their hull, and distances from it in steps of 8 bits; `palette`, the palette that
//! is written.

pub(crate) mod named;
pub(crate) mod source;
mod text;
mod write;

use crate::failure::{FAILED, Failure, MISSED};
use crate::files::{self, FileOptions};
use crate::interrupt;
use crate::progress::Progress;
use crate::shell;
use serde_json::{Value, json};
use source::Region;
use std::path::PathBuf;
use trochoid_palette::{Cloud, Enclosing, Extraction, extract};

/// Options of `trochoid palette`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A palette encloses a picture if no pixel lies outside of the convex hull of its colors: then every pixel is a mix of them. \
That is counted in whole numbers, on the colors as displayed, which are those of the working space \"srgb\". Pictures \
between the steps of 8 bits are enclosed by the steps around them.

Colors are whole steps of 8 bits if such a palette is found; otherwise they lie on a grid of 1/16 or 1/256 of a step, are \
printed as numbers from 0 to 1, and fit only into .json.

With few colors, the palette is loud: its colors lie far from every pixel. By default it has the fewest colors whose \
hull is at most 2.5 times as large as that of the pixels.

Exit code 3 means that no palette of that many colors was found to enclose every pixel.

Examples:
  trochoid palette painting.jpg
  trochoid palette painting.jpg --colors 7 --out painting.json --out swatches.png
  trochoid palette shot.0001.png shot.0096.png --out shot.gpl
  trochoid palette painting.jpg --region 0,0,1920,400 --out sky.json
  trochoid palette photo.jpg --ignore 0.001 --out photo.json
  trochoid decompose painting.jpg --palette painting.json --out painting.recipe.exr")]
pub(crate) struct Args {
    /// The pictures: EXR, PNG, JPEG or TIFF
    #[arg(value_name = "PICTURE", required = true)]
    pictures: Vec<PathBuf>,
    /// Number of colors, from 1 to 12 [default: the fewest that are not loud]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=12))]
    colors: Option<u8>,
    /// Leave out the rarest colors, of at most this share of the pixels, such as 0.001: a few pixels may then lie outside
    #[arg(long, value_name = "SHARE", value_parser = share)]
    ignore: Option<f64>,
    /// Take only this part of each picture, in pixels from its upper left corner; may be repeated
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT", value_parser = source::region)]
    region: Vec<Region>,
    /// Write the palette to this file: .json for documents, .gpl for GIMP, Krita and Inkscape, or .png for a picture of
    /// its colors; may be repeated
    #[arg(short, long, value_name = "FILE")]
    out: Vec<PathBuf>,
    #[command(flatten)]
    files: FileOptions,
    /// Print nothing on stdout, and show no progress
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Text that is no share of pixels to leave out.
#[derive(Debug, thiserror::Error)]
#[error("expected a number from 0 to 0.1, such as 0.001")]
struct NoShare;

/// Parses a share of pixels to leave out.
fn share(text: &str) -> Result<f64, NoShare> {
    text.parse().ok().filter(|share| (0.0..=0.1).contains(share)).ok_or(NoShare)
}

/// What was found in pictures.
struct Found {
    cloud: Cloud,
    /// Number of pixels that are brighter than white.
    brighter: u64,
    /// Number of pixels that no palette has to enclose.
    ignored: u64,
    palettes: Extraction,
}

/// Finds palettes of pictures, and prints or writes them.
///
/// # Errors
/// All problems that can be found in advance, together; a picture cannot be read; no palette has as many colors as were
/// asked for; or a file cannot be written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let mut faults: Vec<Failure> = Vec::new();
    for out in &args.out {
        match write::form(out) {
            Some(form) => {
                let is_input =
                    args.pictures.iter().any(|picture| trochoid::resolved(picture) == trochoid::resolved(out));
                faults.extend(is_input.then(|| files::written_over(out)));
                let cannot = || trochoid::check_destination(out).err().map(Failure::from);
                faults.extend(args.files.over.foreign(out, form).or_else(cannot));
            }
            None => faults.push(write::no_form(out)),
        }
    }
    Failure::all(faults)?;
    interrupt::watch()?;
    let mut progress = Progress::new(args.pictures.len(), args.quiet);
    let (mut cloud, mut brighter) = (Cloud::new(), 0);
    for (index, picture) in args.pictures.iter().enumerate() {
        progress.begin(index, index as i64 + 1);
        brighter += source::read(picture, &args.region, &mut cloud, &progress)?;
    }
    progress.finish();
    let kept = args.ignore.map(|share| cloud.without(share));
    let palettes = extract(kept.as_ref().unwrap_or(&cloud));
    let ignored = kept.map_or(0, |kept| cloud.pixels() - kept.pixels());
    let found = Found { cloud, brighter, ignored, palettes };
    let chosen = choose(args, &found.palettes)?;
    Failure::all(args.out.iter().filter_map(|out| write::unfit(out, chosen)))?;
    for out in &args.out {
        write::write(out, chosen, &args.files.over)?;
    }
    if args.json {
        return shell::print_json(&as_json(args, &found, chosen));
    }
    if args.quiet { Ok(()) } else { shell::print(&text::text(args.pictures.len(), &found, chosen)) }
}

/// Returns the palette that is asked for.
fn choose<'f>(args: &Args, found: &'f Extraction) -> Result<&'f Enclosing, Failure> {
    let missed = |message: String, remedy: &str| Failure::new(MISSED, format!("{message}\n  remedy: {remedy}"));
    match args.colors.map(usize::from) {
        None => found.usual().ok_or_else(|| Failure::new(FAILED, "found no pixel; expected a picture")),
        Some(count) => found.of(count).ok_or_else(|| {
            let counts: Vec<String> = found.enclosing.iter().map(|palette| palette.colors.len().to_string()).collect();
            missed(
                format!(
                    "found no palette of {count} colors that encloses every pixel; expected one of {} colors",
                    counts.join(", ")
                ),
                "ask for one of these numbers with --colors, or for a part of the picture with --region",
            )
        }),
    }
}

fn as_json(args: &Args, Found { cloud, brighter, ignored, palettes: found }: &Found, chosen: &Enclosing) -> Value {
    let outside = chosen.outside(cloud);
    let enclosing = found.enclosing.iter().map(|palette| {
        json!({
            "colors": palette.colors,
            "names": palette.names,
            "units": palette.units,
            "volume": palette.volume,
            "distances": palette.distances,
            "usual": found.usual() == Some(palette),
        })
    });
    let short = found.short.iter().map(|palette| {
        json!({
            "colors": palette.colors,
            "outside": palette.outside,
            "largest": palette.largest,
            "rms": palette.rms,
        })
    });
    json!({
        "pictures": args.pictures.iter().map(|picture| picture.display().to_string()).collect::<Vec<_>>(),
        "pixels": cloud.pixels(),
        "distinct": found.distinct,
        "corners": found.corners,
        "brighter": brighter,
        "ignored": ignored,
        "outside": outside.pixels,
        "outside_largest": outside.largest,
        "enclosing": enclosing.collect::<Vec<_>>(),
        "short": short.collect::<Vec<_>>(),
        "palette": write::colors(chosen),
    })
}
