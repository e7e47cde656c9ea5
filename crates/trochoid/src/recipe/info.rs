//! Description of a recipe: its colors by name, and what else its metadata say.

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use trochoid_engine::Storing;
use trochoid_graph::CheckedGraph;
use trochoid_image::{Window, WorkingSpace};

/// Key of the metadata of a recipe.
const KEY: &str = "trochoid:recipe";
/// Layer that those of the colors are in, unless an output names another.
pub(crate) const LAYER: &str = "recipe";
/// Layer of what images contribute, beside those of the colors.
const IMAGES: &str = "images";
/// Channels of that layer: the weight, and the weighted color.
const IMAGES_CHANNELS: [&str; 4] = ["A", "R", "G", "B"];
/// Bytes to reserve for what is known only when all weights are stored.
pub(crate) const LATE: usize = 128;

/// What a recipe is made of, without its weights.
#[derive(Clone, Debug, PartialEq)]
pub struct RecipeInfo {
    /// Names of the colors.
    pub names: Vec<String>,
    /// Colors in the working space.
    pub colors: Vec<[f64; 3]>,
    /// Working space in which the colors mix.
    pub space: WorkingSpace,
    /// Whether control images contribute to the picture.
    pub has_images: bool,
    /// Layer that those of the colors are in.
    pub layer: String,
    /// How the weights are stored.
    pub storing: Storing,
    /// Document and frame that the picture is of, if it was rendered.
    pub source: Option<(String, i64)>,
    /// Names of the document's palette that no pixel of the picture depends on.
    pub unused: Vec<String>,
}

/// What storing a recipe rounded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounding {
    /// Largest weight that moved from some colors to others at a pixel.
    pub moved: f64,
    /// Largest change of a channel of what images contribute.
    pub images: f64,
}

impl Rounding {
    /// Returns the larger of both, number by number.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self { moved: self.moved.max(other.moved), images: self.images.max(other.images) }
    }

    /// Bounds how far storing moves a channel of a pixel, for colors of which that channel has this range.
    #[must_use]
    pub fn bound(self, range: f64) -> f64 {
        self.moved * range + self.images
    }
}

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
    /// Describes the recipe of an output of a graph at a frame; `None` unless the graph is one
    /// [with recipes](CheckedGraph::with_recipes).
    pub(crate) fn of(graph: &CheckedGraph, layer: &str, storing: Storing, frame: i64) -> Option<Self> {
        let recipes = graph.recipes()?;
        let color = |color: &trochoid_graph::Animated| {
            let color = color.at(frame as f64);
            [color[0], color[1], color[2]]
        };
        let names: Vec<String> = recipes.controls().iter().map(|control| control.name.clone()).collect();
        let unused = graph.palette().iter().map(|named| &named.name).filter(|name| !names.contains(name));
        Some(Self {
            unused: unused.cloned().collect(),
            names,
            colors: recipes.controls().iter().map(|control| color(&control.color)).collect(),
            space: graph.space(),
            has_images: recipes.has_images(),
            layer: layer.into(),
            storing,
            source: Some((graph.name().into(), frame)),
        })
    }

    /// Returns the number of weights: one for each color, and one for all images together.
    pub fn weights(&self) -> usize {
        self.names.len() + usize::from(self.has_images)
    }

    /// Returns the color for each weight: those of images are weighted already.
    pub(super) fn factors(&self, colors: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let images = self.has_images.then_some([0.0; 3]);
        colors.iter().copied().chain(images).collect()
    }

    /// Returns the names of the channels in the file: of the weights in the order of the colors, then of what images
    /// contribute.
    ///
    /// Each color is a layer with the one channel `Y`, such as `recipe.night.Y`, since other programs merge or drop the
    /// channels of a layer that has more than four or eight. The layer's name has only letters, digits, `_` and `-`,
    /// since a dot ends it; so `sea.stops[1].color` becomes `sea_stops_1_color`.
    pub fn channels(&self) -> Vec<String> {
        // Taken even without images, so that a color's name does not depend on them.
        let mut layers = vec![IMAGES.to_owned()];
        for name in &self.names {
            let legal = |c: char| c.is_alphanumeric() || c == '-';
            let words: Vec<&str> = name.split(|c| !legal(c) && c != '_').filter(|word| !word.is_empty()).collect();
            let plain = words.join("_");
            let others = (2..).map(|n: usize| format!("{plain}_{n}"));
            let free = std::iter::once(plain.clone()).chain(others).find(|name| !layers.contains(name));
            layers.push(free.unwrap_or_default());
        }
        let mut channels: Vec<String> = layers[1..].iter().map(|layer| format!("{}.{layer}.Y", self.layer)).collect();
        if self.has_images {
            channels.extend(IMAGES_CHANNELS.map(|channel| format!("{}.{IMAGES}.{channel}", self.layer)));
        }
        channels
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_color_is_a_layer_of_its_own() {
        let names = ["night", "images", "sky.stops[1].color", "sky_stops_1_color", "Y"].map(String::from);
        let info = RecipeInfo {
            names: names.into(),
            colors: vec![[0.0; 3]; 5],
            space: WorkingSpace::Srgb,
            has_images: true,
            layer: LAYER.into(),
            storing: Storing::Half,
            source: None,
            unused: Vec::new(),
        };
        let colors = ["night", "images_2", "sky_stops_1_color", "sky_stops_1_color_2", "Y"];
        let colors = colors.map(|name| format!("recipe.{name}.Y"));
        let images = ["A", "R", "G", "B"].map(|channel| format!("recipe.images.{channel}"));
        assert_eq!(info.channels(), [&colors[..], &images].concat());
    }
}
