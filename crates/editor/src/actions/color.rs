//! Colors that are tried before they are written: one that is dragged, and a palette that is compared.

use crate::document::Edit;
use serde_json::Value;

/// A color that is being dragged.
#[derive(Clone, Debug, PartialEq)]
pub struct Tint {
    /// Names of the colors in a recipe that have it.
    pub controls: Vec<String>,
    /// The color, as sRGB values from 0 to 1.
    pub color: [f32; 3],
    /// The edit that gives the document this color, for pictures without a recipe.
    pub edit: Edit,
}

/// A palette that is compared with the document's.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherPalette {
    /// Name of its file.
    pub name: String,
    /// Its colors as documents have them.
    pub entries: Vec<(String, Value)>,
}
