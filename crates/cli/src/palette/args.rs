//! Options of `trochoid palette`.

use super::regions::{Region, region};
use crate::files::FileOptions;
use std::path::PathBuf;

/// Options of `trochoid palette`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A palette encloses a picture if no pixel lies outside of the convex hull of its colors: then every pixel is a mix of them. \
That is counted in whole numbers, on the colors as displayed, which are those of the working space \"srgb\". Pictures \
between the steps of 8 bits are enclosed by the steps around them. Pixels with alpha 0 are left out.

Colors are whole steps of 8 bits if such a palette is found; otherwise they lie on a grid of 1/16 or 1/256 of a step, are \
printed as numbers from 0 to 1, and fit only into .json.

With few colors, the palette is loud: its colors lie far from every pixel. By default it has the fewest colors whose \
hull is at most 2.5 times as large as that of the pixels. --within and --prior take the fewest of all.

--by-region takes colors off the picture as a painter would: the darkest and the brightest tenth of each --region, and of \
a sixteenth of it at each of its corners, averaged. Ten colors a region, named after it. They lie among the pixels; \
--prior adds what is missing to enclose all.

Exit code 3 means that no palette of that many colors was found to enclose every pixel.

Examples:
  trochoid palette painting.jpg
  trochoid palette painting.jpg --colors 7 --out painting.json --out swatches.png --report painting.html
  trochoid palette photo.jpg --within 0.5 --out photo.json
  trochoid palette photo.jpg --ignore 0.001 --out photo.json
  trochoid palette shot.####.png --frames 1-96 --out shot.gpl
  trochoid palette painting.jpg --region sky=0,0,1920,400 --by-region --out sky.json
  trochoid palette painting.jpg --prior sky.json --out painting.json
  trochoid decompose painting.jpg --palette painting.json --out painting.recipe.exr")]
pub(crate) struct Args {
    /// The pictures: EXR, PNG, JPEG or TIFF; with --frames, #### or %04d in a name stands for the frame
    #[arg(value_name = "PICTURE", required = true)]
    pub(super) pictures: Vec<PathBuf>,
    /// Frames of sequences, such as 1-10,20-40x2
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub(super) frames: Option<String>,
    /// Number of colors, from 1 to 24 [default: the fewest that are not loud]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=24))]
    pub(super) colors: Option<u8>,
    /// Take the fewest colors that leave no pixel farther outside of their hull than this, in steps of 255, such as 0.5
    #[arg(long, value_name = "STEPS", value_parser = steps)]
    pub(super) within: Option<f64>,
    /// Keep the colors of this palette, JSON or .gpl, with their names, and add as few as possible
    #[arg(long, value_name = "FILE")]
    pub(super) prior: Option<PathBuf>,
    /// Leave out the rarest colors, of at most this share of the pixels, such as 0.001: a few pixels may then lie outside
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub(super) ignore: Option<f64>,
    /// Take only this part of each picture, in pixels from its upper left corner, perhaps with a name, such as
    /// sky=0,0,1920,400; may be repeated
    #[arg(long, value_name = "[NAME=]X,Y,WIDTH,HEIGHT", value_parser = region)]
    pub(super) region: Vec<Region>,
    /// Take the darkest and the brightest colors of each --region and its corners instead of a hull
    #[arg(long, requires = "region", conflicts_with_all = ["colors", "within", "prior", "ignore"])]
    pub(super) by_region: bool,
    /// Write the palette to this file: .json for documents, .gpl for GIMP, Krita and Inkscape, or .png for a picture of
    /// its colors; may be repeated
    #[arg(short, long, value_name = "FILE")]
    pub(super) out: Vec<PathBuf>,
    /// Write a page about the palette to this .html file: its colors and their shares, what other numbers of colors cost,
    /// and the pixels in the hull, to be turned
    #[arg(long, value_name = "FILE")]
    pub(super) report: Option<PathBuf>,
    #[command(flatten)]
    pub(super) files: FileOptions,
    /// Print nothing on stdout, and show no progress
    #[arg(long, conflicts_with = "json")]
    pub(super) quiet: bool,
    /// Print JSON
    #[arg(long)]
    pub(super) json: bool,
}

/// Text that is no share of pixels to leave out.
#[derive(Debug, thiserror::Error)]
#[error("expected a number from 0 to 0.1, such as 0.001")]
struct NoShare;

/// Parses a share of pixels to leave out.
fn share(text: &str) -> Result<f64, NoShare> {
    text.parse().ok().filter(|share| (0.0..=0.1).contains(share)).ok_or(NoShare)
}

/// Text that is no distance.
#[derive(Debug, thiserror::Error)]
#[error("expected a number of steps from 0 to 255, such as 0.5")]
struct NoSteps;

/// Parses how far pixels may lie outside.
fn steps(text: &str) -> Result<f64, NoSteps> {
    text.parse().ok().filter(|steps| (0.0..=255.0).contains(steps)).ok_or(NoSteps)
}
