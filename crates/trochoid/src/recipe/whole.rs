//! Recipes in memory.

use super::header::RecipeError;
use super::info::{RecipeInfo, Rounding};
use crate::marks::with_mark;
use std::path::Path;
use trochoid_engine::{Storing, paint};
use trochoid_image::{Plane, Window};
use trochoid_io::{ExrChannel, ExrImage, Limits, Samples, Selection, Target, read, read_metadata, write_exr};

/// The weights of a picture over named colors.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Colors, and what else is known of the recipe.
    pub info: RecipeInfo,
    /// What storing it rounded.
    pub rounding: Rounding,
    /// Picture's frame.
    pub window: Window,
    /// For each [channel](RecipeInfo::channels) its samples, row by row. The weights are ≥ 0, and sum to 1 at each pixel.
    pub channels: Vec<Vec<f32>>,
}

impl Recipe {
    /// Reads a recipe.
    ///
    /// # Errors
    /// The file cannot be read, has other metadata or channels, or has weights that are negative, are no number, or do
    /// not sum to 1.
    pub fn read(path: &Path) -> Result<Self, RecipeError> {
        let (info, rounding) = RecipeInfo::read(path, &read_metadata(path)?)?;
        let picture = read(path, &Selection::channels(info.channels()), &Limits::default())?;
        let window = picture.data;
        let channels: Vec<Vec<f32>> =
            picture.channels.into_iter().map(|channel| channel.plane.samples().to_vec()).collect();
        let recipe = Self { info, rounding, window, channels };
        recipe.recolor(&recipe.info.colors).map_err(|pixel| RecipeError::weights(path, window, pixel))?;
        Ok(recipe)
    }

    /// Writes the recipe. Weights must be multiples of the unit in which they are [stored](RecipeInfo::storing), so that
    /// their sums stay exact.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, target: impl Into<Target>) -> Result<(), trochoid_io::Error> {
        let stored = match self.info.storing {
            Storing::Half => ExrChannel::half,
            Storing::Float => ExrChannel::float,
        };
        let channels = self.info.channels().into_iter().zip(&self.channels);
        let image = ExrImage {
            channels: channels.map(|(name, plane)| stored(name, Samples::contiguous(plane))).collect(),
            metadata: with_mark(&[self.info.metadata(self.rounding)]),
            ..ExrImage::new(self.window)
        };
        write_exr(target, &image)
    }

    /// Mixes the picture of other colors, one for each name, in the working space: red, green and blue planes.
    ///
    /// # Errors
    /// The weights of a pixel are not ≥ 0 with the sum 1; its index.
    ///
    /// # Panics
    /// There are not as many colors as names.
    pub fn recolor(&self, colors: &[[f64; 3]]) -> Result<[Plane; 3], usize> {
        assert_eq!(colors.len(), self.info.names.len(), "a color for each name");
        let mut planes = [(); 3].map(|()| Plane::filled(self.window, 0.0));
        let rows: Vec<&[f32]> = self.channels.iter().map(Vec::as_slice).collect();
        let (weights, images) = rows.split_at(self.info.weights());
        paint(weights, &self.info.factors(colors), images.try_into().ok(), planes.each_mut().map(Plane::samples_mut))?;
        Ok(planes)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use trochoid_image::WorkingSpace;

    fn recipe(storing: Storing) -> Recipe {
        let info = RecipeInfo {
            names: ["deep", "glow", "foam"].map(String::from).into(),
            colors: vec![[0.0, 0.1, 0.2], [0.9, 0.5, 0.1], [1.0, 1.0, 0.9]],
            space: WorkingSpace::Srgb,
            has_images: false,
            layer: "recipe".into(),
            storing,
            source: Some(("sea.json".into(), 36)),
            unused: vec!["ember".into()],
        };
        let channels = vec![vec![1.0, 0.5, 0.25, 0.0], vec![0.0, 0.5, 0.25, 0.0], vec![0.0, 0.0, 0.5, 1.0]];
        Recipe { info, rounding: Rounding { moved: 0.125, images: 0.0 }, window: Window::sized(2, 2), channels }
    }

    #[test]
    fn recipes_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for storing in [Storing::Half, Storing::Float] {
            recipe(storing).write(&path).unwrap();
            assert_eq!(Recipe::read(&path).unwrap(), recipe(storing));
        }
        let own = recipe(Storing::Half);
        let [r, g, b] = own.recolor(&own.info.colors).unwrap();
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
        let mut broken = recipe(Storing::Float);
        broken.channels[0][1] = 0.25;
        broken.write(&path).unwrap();
        says("weights at pixel (1, 0) that are not ≥ 0 with the sum 1");
        broken.channels[0][1] = f32::NAN;
        broken.write(&path).unwrap();
        says("weights at pixel (1, 0)");
        let plain = ExrImage {
            channels: vec![ExrChannel::half("Y", Samples::contiguous(&[0.5]))],
            ..ExrImage::new(Window::sized(1, 1))
        };
        write_exr(&path, &plain).unwrap();
        says("a picture without weights");
    }
}
