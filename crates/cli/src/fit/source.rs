//! The weights of the picture that is fitted: from a recipe, or from a document that is rendered.

use super::picture::{Weighed, evenly};
use crate::failure::{FAILED, Failure, INTERRUPTED};
use crate::progress::Progress;
use crate::{interrupt, remedies};
use std::path::Path;
use trochoid::{
    Buffers, Cache, CheckedGraph, EvalError, Kind, LoadError, Plan, Plane, Recipe, Settings, Window, WorkingSpace,
};

/// A picture by its weights.
pub(crate) struct Source {
    /// Names of all colors.
    pub(crate) names: Vec<String>,
    /// The colors, in the working space.
    pub(crate) colors: Vec<[f64; 3]>,
    pub(crate) space: WorkingSpace,
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Weights of each color, then what images add to red, green and blue, if there are any.
    channels: Vec<Vec<f32>>,
}

impl Source {
    /// Takes a recipe.
    ///
    /// # Errors
    /// The file cannot be read, or is none.
    pub(crate) fn of_recipe(path: &Path) -> Result<Self, Failure> {
        let mut recipe = Recipe::read(path).map_err(|error| remedies::recipe(&error))?;
        if recipe.info.has_images {
            // The weight of all images together.
            recipe.channels.remove(recipe.info.names.len());
        }
        let Recipe { info, window, channels, .. } = recipe;
        let (width, height) = (window.width(), window.height());
        Ok(Self { names: info.names, colors: info.colors, space: info.space, width, height, channels })
    }

    /// Renders the weights of an output of a document at a frame, of all pixels or of a region.
    ///
    /// # Errors
    /// The graph has no recipe, or cannot be rendered.
    pub(crate) fn of_graph(
        graph: &CheckedGraph,
        output: usize,
        frame: i64,
        region: Option<Window>,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let mut graph = graph.clone();
        let recipe = graph.add_recipe(output, true);
        let graph = graph.with_recipes(&[recipe]).map_err(|refused| Failure::from(LoadError::Invalid(refused)))?;
        let failed = |error: &dyn std::fmt::Display| Failure::new(FAILED, format!("frame {frame}: {error}"));
        let name = graph.outputs()[recipe].name.as_str();
        let mut settings = Settings::default();
        settings.region = region;
        let plan = Plan::new(&graph, &[name], frame, &[], &settings).map_err(|error| failed(&error))?;
        let evaluated = plan.evaluate(&Buffers::new(), &mut Cache::new(), progress).map_err(|error| match error {
            EvalError::Cancelled => Failure::new(INTERRUPTED, "interrupted; nothing was written"),
            error => Failure::new(FAILED, format!("frame {frame}: {}", remedies::evaluation(&error))),
        })?;
        let (Some(recipes), Some(picture)) = (graph.recipes(), evaluated.pictures.into_iter().next()) else {
            return Err(failed(&"no picture was made"));
        };
        let color = |control: &trochoid::Control| {
            let color = control.color.at(frame as f64);
            [color[0], color[1], color[2]]
        };
        let count = recipes.controls().len();
        let images = if recipes.has_images() { picture.planes.len() - 3 } else { picture.planes.len() };
        let planes = picture.planes[..count].iter().chain(&picture.planes[images..]);
        Ok(Self {
            names: recipes.controls().iter().map(|control| control.name.clone()).collect(),
            colors: recipes.controls().iter().map(color).collect(),
            space: graph.space(),
            width: evaluated.window.width(),
            height: evaluated.window.height(),
            channels: planes.map(|plane: &Plane| plane.samples().to_vec()).collect(),
        })
    }

    /// Returns the weights of the colors with these indices at some pixels; the others are part of the rest.
    pub(crate) fn weighed(&self, free: &[usize], pixels: &[usize]) -> Weighed {
        let (weights, images) = self.channels.split_at(self.names.len());
        let rest = pixels.iter().map(|pixel| {
            let mut sum = [0.0_f64; 3];
            images.iter().zip(&mut sum).for_each(|(image, sum)| *sum += f64::from(image[*pixel]));
            for (index, color) in self.colors.iter().enumerate().filter(|(index, _)| !free.contains(index)) {
                (0..3).for_each(|c| sum[c] += f64::from(weights[index][*pixel]) * color[c]);
            }
            sum.map(|v| v as f32)
        });
        Weighed {
            colors: free.len(),
            rest: rest.collect(),
            weights: pixels.iter().flat_map(|pixel| free.iter().map(|index| weights[*index][*pixel])).collect(),
        }
    }

    /// Returns the weight of each color at a pixel, and what images add to its red, green and blue.
    pub(crate) fn at(&self, pixel: usize) -> (Vec<f64>, [f64; 3]) {
        let (weights, images) = self.channels.split_at(self.names.len());
        let mut added = [0.0; 3];
        images.iter().zip(&mut added).for_each(|(image, sum)| *sum = f64::from(image[pixel]));
        (weights.iter().map(|plane| f64::from(plane[pixel])).collect(), added)
    }

    /// Returns at most so many pixels, evenly from all over the picture.
    pub(crate) fn pixels(&self, most: usize) -> Vec<usize> {
        evenly(self.width * self.height, most)
    }
}

/// Returns the output of a document that is fitted: the one that is asked for, or the first color.
///
/// # Errors
/// There is none, or it is no color.
pub(crate) fn output(graph: &CheckedGraph, asked: Option<&str>) -> Result<usize, Failure> {
    let is_color = |index: &usize| graph.outputs()[*index].kind == Kind::Color && !graph.outputs()[*index].is_recipe;
    let colors: Vec<usize> = (0..graph.outputs().len()).filter(is_color).collect();
    let named = |name: &str| colors.iter().copied().find(|index| graph.outputs()[*index].name == name);
    let found = match asked {
        Some(name) => named(name),
        None => colors.first().copied(),
    };
    found.ok_or_else(|| {
        let names: Vec<&str> = colors.iter().map(|index| graph.outputs()[*index].name.as_str()).collect();
        let what = asked.map_or("no output that is a color".into(), |name| format!("--output {name}"));
        Failure::usage(format!("found {what}; expected a color"), format!("the document has: {}", names.join(", ")))
    })
}

/// Fails if the run was interrupted.
pub(crate) fn check_interrupted() -> Result<(), Failure> {
    if interrupt::asked() { Err(Failure::new(INTERRUPTED, "interrupted; nothing was written")) } else { Ok(()) }
}
