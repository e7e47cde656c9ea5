//! Palettes that are given as files.

use crate::failure::{FAILED, Failure};
use serde_json::json;
use std::path::Path;
use trochoid::{Access, PaletteColor, WorkingSpace, parse_within};

/// Colors by name, in a working space.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Named {
    pub(crate) names: Vec<String>,
    pub(crate) colors: Vec<[f64; 3]>,
}

/// Reads a palette as a document would: JSON, another document, or a `.gpl` file. Keyed colors are those of frame 1.
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
    if let Err(error) = std::fs::metadata(path) {
        return Err(Failure::new(FAILED, format!("{}: cannot open the file: {error}", path.display())));
    }
    let document = json!({
        "trochoid": 1,
        "format": { "width": 1, "height": 1 },
        "working_space": space.name(),
        "palette": trochoid::resolved(path).to_string_lossy(),
        "nodes": { "nothing": { "type": "Constant", "color": "#000" } },
        "outputs": { "nothing": { "color": "nothing" } },
    });
    let name = path.display().to_string();
    let loaded = parse_within(&name, &document.to_string(), Path::new("."), &[], Access::everything())?;
    let colors = loaded.graph.palette().to_vec();
    if colors.is_empty() {
        return Err(Failure::usage(format!("{name}: found no colors; expected some"), "name a palette with colors"));
    }
    Ok(colors)
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
