//! Palettes that are given as files.

use crate::failure::Failure;
use std::path::Path;
use trochoid::{Access, PaletteColor, WorkingSpace, load_palette};

/// Colors by name, in a working space.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Named {
    pub(crate) names: Vec<String>,
    pub(crate) colors: Vec<[f64; 3]>,
}

/// Reads a palette as [`load_palette`] does. Keyed colors are those of frame 1.
///
/// # Errors
/// The file cannot be read, or is no palette.
pub(crate) fn read(path: &Path, space: WorkingSpace) -> Result<Named, Failure> {
    Ok(Named::at(&keyed(path, space)?, 1))
}

/// Reads a palette as [`read`], with its keys.
///
/// # Errors
/// As [`read`].
pub(crate) fn keyed(path: &Path, space: WorkingSpace) -> Result<Vec<PaletteColor>, Failure> {
    Ok(load_palette(path, space, &Access::everything())?)
}

impl Named {
    /// Returns the colors of a palette at a frame.
    pub(crate) fn at(palette: &[PaletteColor], frame: i64) -> Self {
        let color = |named: &PaletteColor| {
            let color = named.color.at(frame as f64);
            (named.name.clone(), [color[0], color[1], color[2]])
        };
        let (names, colors) = palette.iter().map(color).unzip();
        Self { names, colors }
    }
}
