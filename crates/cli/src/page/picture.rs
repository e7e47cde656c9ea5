//! Pictures of a page, read from recipes.

use super::pack::{Key, pack};
use super::sources::Source;
use super::weights::Weights;
use super::{cube, shrink};
use crate::failure::{FAILED, Failure};
use crate::{interrupt, remedies};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use libdeflater::{CompressionLvl, Compressor};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use trochoid::io::{Limits, info};
use trochoid::{Recipe, WorkingSpace, in_bytes};

/// Most pixels of a picture: what browsers decode at ease, and graphics cards hold.
const MOST_PIXELS: usize = 1 << 24;
/// Largest width and height of a picture, in pixels.
const LARGEST: usize = 8192;
/// Most bytes of all frames of a page.
const MOST_BYTES: usize = 200_000_000;
/// Frames that refer to the first of them.
pub(super) const GROUP: usize = 8;
/// Memory for recipes that are read at a time, in bytes.
const AT_A_TIME: usize = 1 << 30;

/// A picture of a page.
pub(super) struct Picture {
    pub(super) name: String,
    /// Width and height in pixels.
    pub(super) size: [usize; 2],
    pub(super) space: WorkingSpace,
    /// Names of the colors.
    pub(super) names: Vec<String>,
    pub(super) frames: Vec<Frame>,
    /// Weights of a lattice of displayed colors, if the picture's are a function of color.
    pub(super) cube: Option<String>,
}

/// A frame of a picture.
pub(super) struct Frame {
    pub(super) label: String,
    /// Colors in the working space.
    pub(super) colors: Vec<[f64; 3]>,
    /// Mean weight of each color.
    pub(super) shares: Vec<f64>,
    /// Packed weights, as text.
    pub(super) data: String,
    /// Largest change of a pixel by rounding, in steps of 255.
    pub(super) farthest: f64,
}

/// Reads pictures, at most `width` pixels wide.
///
/// # Errors
/// A file is no recipe, too large, or differs from the other frames in size, colors' names or working space; the page is
/// too large; or the user interrupts.
pub(super) fn read(sources: Vec<Source>, width: Option<u32>) -> Result<Vec<Picture>, Failure> {
    let mut bytes = 0;
    sources.into_iter().map(|source| read_one(source, width, &mut bytes)).collect()
}

fn read_one(source: Source, width: Option<u32>, bytes: &mut usize) -> Result<Picture, Failure> {
    let mut picture: Option<Picture> = None;
    for group in source.frames.chunks(GROUP) {
        let (first, mut rest) = (&group[0], &group[1..]);
        let (made, key) = alone(&source.name, first, width, None, picture.is_none())?;
        add(&mut picture, made, &first.1, bytes)?;
        while let Some((_, path)) = rest.first() {
            let (now, later) = rest.split_at(together(path, width)?.min(rest.len()));
            let made: Vec<Result<_, Failure>> =
                now.par_iter().map(|frame| alone(&source.name, frame, width, key.as_ref(), false)).collect();
            for (made, (_, path)) in made.into_iter().zip(now) {
                add(&mut picture, made?.0, path, bytes)?;
            }
            rest = later;
        }
    }
    let message = format!("{}: found no frames; expected some", source.name);
    picture.ok_or_else(|| Failure::usage(message, "say which, for example --frames 1-48"))
}

/// Adds a picture of one frame to those before it, and its bytes.
fn add(picture: &mut Option<Picture>, made: Picture, path: &Path, bytes: &mut usize) -> Result<(), Failure> {
    *bytes += made.frames.iter().map(|frame| frame.data.len()).sum::<usize>();
    if *bytes > MOST_BYTES {
        let message = format!(
            "{}: found frames of {} up to this one; expected at most {} on a page",
            path.display(),
            in_bytes(*bytes as u64),
            in_bytes(MOST_BYTES as u64)
        );
        return Err(Failure::usage(message, "make them smaller, such as --width 960, or take fewer frames"));
    }
    match picture {
        None => *picture = Some(made),
        Some(picture) => {
            agree(picture, &made, path)?;
            picture.frames.extend(made.frames);
        }
    }
    Ok(())
}

/// Returns how many recipes such as this one are read at a time.
///
/// # Errors
/// The file is too large, or cannot be read.
fn together(path: &Path, width: Option<u32>) -> Result<usize, Failure> {
    let part = &info(path, &Limits::default()).map_err(|error| Failure::new(FAILED, error))?.parts[0];
    let bytes = part.display.area().saturating_mul(part.channels.len()).saturating_mul(8).max(1);
    sized(path, [part.display.width(), part.display.height()], width)?;
    Ok((AT_A_TIME / bytes).clamp(1, rayon::current_num_threads()))
}

/// Returns the size of a picture on the page.
///
/// # Errors
/// It is too large.
fn sized(path: &Path, size: [usize; 2], width: Option<u32>) -> Result<[usize; 2], Failure> {
    let [across, down] = shrink::size(size, width);
    if across.max(down) <= LARGEST && across.saturating_mul(down) <= MOST_PIXELS {
        return Ok([across, down]);
    }
    let path = path.display();
    let message =
        format!("{path}: found {across} × {down} pixels; expected at most {LARGEST} each way and {MOST_PIXELS} in all");
    Err(Failure::usage(message, "make it smaller, such as --width 1920"))
}

/// Reads a picture of one frame, and what other frames may refer to.
fn alone(
    name: &str,
    (label, path): &(String, PathBuf),
    width: Option<u32>,
    key: Option<&Key>,
    is_first: bool,
) -> Result<(Picture, Option<Key>), Failure> {
    if interrupt::asked() {
        return Err(Failure::interrupted());
    }
    // Frames need not have the size of the first.
    together(path, width)?;
    let recipe = Recipe::read(path).map_err(|error| remedies::recipe(&error))?;
    let recipe = Weights::of(recipe).ok_or_else(|| {
        let message = format!("{}: found pixels of images; expected mixes of named colors alone", path.display());
        Failure::usage(message, remedies::without_images(path))
    })?;
    let cube = if is_first { cube::of(&recipe).map(|lattice| text(&pack(&lattice, None).bytes)) } else { None };
    let size = sized(path, [recipe.window.width(), recipe.window.height()], width)?;
    let recipe = shrink::shrink(recipe, size);
    let packed = pack(&recipe, key.filter(|key| key.fits(&recipe)));
    let frame = Frame {
        label: label.clone(),
        colors: recipe.colors,
        shares: packed.shares,
        data: text(&packed.bytes),
        farthest: packed.farthest,
    };
    let (space, names) = (recipe.space, recipe.names);
    Ok((Picture { name: name.into(), size, space, names, frames: vec![frame], cube }, packed.key))
}

/// Checks that a frame belongs to a picture.
fn agree(picture: &Picture, frame: &Picture, path: &Path) -> Result<(), Failure> {
    let differs = |found: String, expected: String| {
        let message = format!("{}: found {found}; expected {expected}, as in the frames before it", path.display());
        Err(Failure::usage(message, "give it another name than a frame's, so that it becomes a picture of its own"))
    };
    let pixels = |[width, height]: [usize; 2]| format!("{width} × {height} pixels");
    if frame.size != picture.size {
        return differs(pixels(frame.size), pixels(picture.size));
    }
    if frame.names != picture.names {
        return differs(format!("the colors {}", frame.names.join(", ")), picture.names.join(", "));
    }
    if frame.space != picture.space {
        return differs(format!("the working space {}", frame.space), picture.space.to_string());
    }
    Ok(())
}

/// Compresses bytes, as text that a page can hold.
fn text(bytes: &[u8]) -> String {
    let mut compressor = Compressor::new(CompressionLvl::best());
    let mut packed = vec![0; compressor.zlib_compress_bound(bytes.len())];
    // The bound is enough for any bytes.
    let length = compressor.zlib_compress(bytes, &mut packed).unwrap_or(0);
    STANDARD.encode(&packed[..length])
}
