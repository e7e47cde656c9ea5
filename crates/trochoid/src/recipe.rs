//! Recipes: the weights of a picture, one plane for each color that it is mixed from.
//!
//! A picture is Σ ωᵢCᵢ, and its weights ω do not depend on its colors C. With the weights in a file, it is painted in
//! other colors without being rendered again. A recipe is an EXR file with one layer, `recipe`, that has a channel for
//! each color, so that other programs read each as a mask. Its metadata `trochoid:recipe` have the colors.

use crate::marks::with_mark;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use trochoid_image::{Plane, Window, WorkingSpace};
use trochoid_io::{ExrChannel, ExrImage, Limits, Samples, Selection, Target, read, read_metadata, write_exr};

/// Key of the metadata of a recipe.
const KEY: &str = "trochoid:recipe";
/// Layer of the weights.
const LAYER: &str = "recipe";
/// Pixels that are mixed at once: their sums stay in the cache.
const CHUNK: usize = 4096;

/// The weights of a picture over named colors.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Names of the colors.
    pub names: Vec<String>,
    /// Colors in the working space.
    pub colors: Vec<[f64; 3]>,
    /// Working space in which the colors mix.
    pub space: WorkingSpace,
    /// Picture's frame.
    pub window: Window,
    /// For each color its weights, row by row: ≥ 0, and with the sum 1 at each pixel.
    pub weights: Vec<Vec<f32>>,
}

/// Reason that a file is not read as a recipe.
#[derive(Debug, thiserror::Error)]
pub enum RecipeError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] trochoid_io::Error),
    /// The file is a picture, but no recipe.
    #[error("{}: found {found}; expected a recipe, as `trochoid decompose` writes it", path.display())]
    NoRecipe {
        /// Path of the file.
        path: PathBuf,
        /// What was found instead.
        found: String,
    },
}

impl Recipe {
    /// Reads a recipe.
    ///
    /// # Errors
    /// The file cannot be read, has other metadata or channels, or has weights that are negative, are no number, or do
    /// not sum to 1.
    pub fn read(path: &Path) -> Result<Self, RecipeError> {
        let none = |found: &str| RecipeError::NoRecipe { path: path.into(), found: found.into() };
        let metadata = read_metadata(path)?;
        let text = metadata.iter().find(|(key, _)| key == KEY).map(|(_, text)| text);
        let text = text.ok_or_else(|| none("a picture without weights"))?;
        let (names, colors, space) = said(text).ok_or_else(|| none("metadata of another form"))?;
        let channels: Vec<String> = names.iter().map(|name| format!("{LAYER}.{name}")).collect();
        let picture = read(path, &Selection::channels(channels), &Limits::default())?;
        let window = picture.data;
        let weights: Vec<Vec<f32>> =
            picture.channels.into_iter().map(|channel| channel.plane.samples().to_vec()).collect();
        for pixel in 0..window.area() {
            let all = weights.iter().map(|plane| plane[pixel]);
            let sum: f64 = all.clone().map(f64::from).sum();
            if !all.clone().all(|weight| weight >= 0.0) || sum != 1.0 {
                let [x, y] = [window.x0 + (pixel % window.width()) as i64, window.y0 + (pixel / window.width()) as i64];
                return Err(none(&format!("weights at pixel ({x}, {y}) that are not ≥ 0 with the sum 1")));
            }
        }
        Ok(Self { names, colors, space, window, weights })
    }

    /// Writes the recipe, with 16-bit floats, or 32-bit ones if `is_float`. Weights must be multiples of 2⁻¹¹ or 2⁻²⁴, so
    /// that their sums stay exact.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, target: impl Into<Target>, is_float: bool) -> Result<(), trochoid_io::Error> {
        let text = json!({
            "names": self.names,
            "colors": self.colors,
            "working_space": self.space.name(),
        });
        let stored = if is_float { ExrChannel::float } else { ExrChannel::half };
        let channels = self.names.iter().zip(&self.weights);
        let image = ExrImage {
            channels: channels
                .map(|(name, plane)| stored(format!("{LAYER}.{name}"), Samples::contiguous(plane)))
                .collect(),
            metadata: with_mark(&[(KEY.into(), text.to_string())]),
            ..ExrImage::new(self.window)
        };
        write_exr(target, &image)
    }

    /// Mixes the picture of other colors, one for each name, in the working space: red, green and blue planes.
    ///
    /// # Panics
    /// There are not as many colors as names.
    pub fn recolor(&self, colors: &[[f64; 3]]) -> [Plane; 3] {
        assert_eq!(colors.len(), self.names.len(), "a color for each name");
        let area = self.window.area();
        let mut planes = [(); 3].map(|()| Plane::filled(self.window, 0.0));
        for (c, plane) in planes.iter_mut().enumerate() {
            for (start, sums) in (0..area).step_by(CHUNK).zip(plane.samples_mut().chunks_mut(CHUNK)) {
                for (weights, color) in self.weights.iter().zip(colors) {
                    let by = color[c] as f32;
                    let weights = &weights[start..start + sums.len()];
                    sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += weight * by);
                }
            }
        }
        planes
    }
}

/// Reads names, colors and the working space from metadata.
fn said(text: &str) -> Option<(Vec<String>, Vec<[f64; 3]>, WorkingSpace)> {
    let value: Value = serde_json::from_str(text).ok()?;
    let names: Vec<String> = serde_json::from_value(value.get("names")?.clone()).ok()?;
    let colors: Vec<[f64; 3]> = serde_json::from_value(value.get("colors")?.clone()).ok()?;
    let space = WorkingSpace::from_name(value.get("working_space")?.as_str()?)?;
    (names.len() == colors.len() && !names.is_empty()).then_some((names, colors, space))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    fn recipe() -> Recipe {
        let weights = vec![vec![1.0, 0.5, 0.25, 0.0], vec![0.0, 0.5, 0.25, 0.0], vec![0.0, 0.0, 0.5, 1.0]];
        Recipe {
            names: ["deep", "glow", "foam"].map(String::from).into(),
            colors: vec![[0.0, 0.1, 0.2], [0.9, 0.5, 0.1], [1.0, 1.0, 0.9]],
            space: WorkingSpace::Srgb,
            window: Window::sized(2, 2),
            weights,
        }
    }

    #[test]
    fn recipes_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for is_float in [false, true] {
            recipe().write(&path, is_float).unwrap();
            assert_eq!(Recipe::read(&path).unwrap(), recipe());
        }
        let [r, g, b] = recipe().recolor(&recipe().colors);
        assert_eq!((r.samples()[0], g.samples()[1], b.samples()[3]), (0.0, 0.3, 0.9));
    }

    #[test]
    fn what_is_no_recipe_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let says = |words: &str| {
            let error = Recipe::read(&path).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        says("a.exr");
        let mut broken = recipe();
        broken.weights[0][1] = 0.25;
        broken.write(&path, false).unwrap();
        says("weights at pixel (1, 0) that are not ≥ 0 with the sum 1");
        broken.weights[0][1] = f32::NAN;
        broken.write(&path, true).unwrap();
        says("weights at pixel (1, 0)");
        let plain = ExrImage {
            channels: vec![ExrChannel::half("Y", Samples::contiguous(&[0.5]))],
            ..ExrImage::new(Window::sized(1, 1))
        };
        write_exr(&path, &plain).unwrap();
        says("a picture without weights");
    }
}
