//! What the header of a recipe's file says.

use super::info::{LAYER, RecipeInfo, Rounding};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use trochoid_engine::Storing;
use trochoid_image::{Window, WorkingSpace};

/// Key of the metadata of a recipe.
pub(crate) const KEY: &str = "trochoid:recipe";
/// Bytes to reserve for what is known only when all weights are stored.
pub(crate) const LATE: usize = 128;

/// Reason that a file is not read as a recipe.
#[derive(Debug, thiserror::Error)]
pub enum RecipeError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] trochoid_io::Error),
    /// The file is a picture, but no recipe.
    #[error("{}: found {found}; expected a recipe, as `trochoid render --recipe` or `decompose` writes it", path.display())]
    NoRecipe {
        /// Path of the file.
        path: PathBuf,
        /// What was found instead.
        found: String,
    },
}

impl RecipeError {
    pub(super) fn of(path: &Path, found: impl Into<String>) -> Self {
        Self::NoRecipe { path: path.into(), found: found.into() }
    }

    /// Returns the error of illegal weights at a pixel of a window, counted row by row.
    pub(super) fn weights(path: &Path, window: Window, pixel: usize) -> Self {
        let [x, y] = [window.x0 + (pixel % window.width()) as i64, window.y0 + (pixel / window.width()) as i64];
        Self::of(path, format!("weights at pixel ({x}, {y}) that are not ≥ 0 with the sum 1"))
    }
}

impl RecipeInfo {
    /// Returns the metadata of a file.
    pub(crate) fn metadata(&self, rounding: Rounding) -> (String, String) {
        let text = json!({
            "names": self.names,
            "colors": self.colors,
            "working_space": self.space.name(),
            "layer": self.layer,
            "images": self.has_images,
            "stored": if self.storing == Storing::Half { "half" } else { "float" },
            "document": self.source.as_ref().map(|(document, _)| document),
            "frame": self.source.as_ref().map(|(_, frame)| frame),
            "unused": self.unused,
            "moved": rounding.moved,
            "images_moved": rounding.images,
        });
        (KEY.into(), text.to_string())
    }

    /// Reads the description from the metadata of a file.
    ///
    /// # Errors
    /// They are not those of a recipe.
    pub(crate) fn read(path: &Path, metadata: &[(String, String)]) -> Result<(Self, Rounding), RecipeError> {
        let text = metadata.iter().find(|(key, _)| key == KEY).map(|(_, text)| text);
        let text = text.ok_or_else(|| RecipeError::of(path, "a picture without weights"))?;
        said(text).ok_or_else(|| RecipeError::of(path, "metadata of another form"))
    }
}

/// Reads what metadata say.
fn said(text: &str) -> Option<(RecipeInfo, Rounding)> {
    let value: Value = serde_json::from_str(text).ok()?;
    let list = |key: &str| -> Option<Vec<String>> { serde_json::from_value(value.get(key)?.clone()).ok() };
    let word = |key: &str| value.get(key).and_then(Value::as_str);
    let number = |key: &str| value.get(key).and_then(Value::as_f64);
    let names = list("names")?;
    let colors: Vec<[f64; 3]> = serde_json::from_value(value.get("colors")?.clone()).ok()?;
    let frame = value.get("frame").and_then(Value::as_i64);
    let info = RecipeInfo {
        colors,
        space: WorkingSpace::from_name(word("working_space")?)?,
        has_images: value.get("images").and_then(Value::as_bool).unwrap_or_default(),
        layer: word("layer").unwrap_or(LAYER).into(),
        storing: if word("stored") == Some("float") { Storing::Float } else { Storing::Half },
        source: word("document").map(String::from).zip(frame),
        unused: list("unused").unwrap_or_default(),
        names,
    };
    let rounding = Rounding { moved: number("moved")?, images: number("images_moved")? };
    let has_weights = info.has_images || !info.names.is_empty();
    (has_weights && info.names.len() == info.colors.len()).then_some((info, rounding))
}
