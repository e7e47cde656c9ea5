//! The page about a palette: one file that needs no other files and no network.

mod curve;
mod page;
mod preview;
mod space;

use super::Found;
use crate::failure::{FAILED, Failure};
pub(super) use preview::Preview;
use std::path::Path;
use trochoid::Form;
use trochoid_palette::{Decomposer, Palette};

/// Softness with which pixels are taken apart for the colors' shares, as `trochoid decompose` does.
const SOFTNESS: f64 = 0.2;

/// Writes the page.
///
/// # Errors
/// A picture cannot be encoded, or the file cannot be written.
pub(super) fn write(path: &Path, found: &Found, overwrites: bool) -> Result<(), Failure> {
    let page = page::page(found).map_err(|error| Failure::new(FAILED, format!("{}: {error}", path.display())))?;
    Ok(trochoid::write_guarded(path, page.as_bytes(), Form::Page, overwrites)?)
}

/// Returns the share of each color in the pixels: the mean of its weights. `None` if the colors are too many to take
/// pictures apart.
fn shares(palette: &Palette, cells: &[space::Cell]) -> Option<Vec<f64>> {
    let decomposer = Decomposer::new(&palette.colors, SOFTNESS)?;
    let mut shares = vec![0.0; palette.colors.len()];
    let pixels: f64 = cells.iter().map(|cell| cell.pixels as f64).sum();
    for cell in cells {
        let weights = decomposer.weights(cell.color.map(|v| v / 255.0));
        shares.iter_mut().zip(weights).for_each(|(share, weight)| *share += weight * cell.pixels as f64 / pixels);
    }
    Some(shares)
}
