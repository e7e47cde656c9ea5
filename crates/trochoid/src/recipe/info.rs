//! Description of a recipe: its colors by name, and how they are stored.

use trochoid_engine::Storing;
use trochoid_graph::{CheckedGraph, Diagnostic};
use trochoid_image::WorkingSpace;

/// Layer that those of the colors are in, unless an output names another.
pub(crate) const LAYER: &str = "recipe";
/// Layer of what images contribute, beside those of the colors.
const IMAGES: &str = "images";
/// Channels of that layer: the weight, and the weighted color.
const IMAGES_CHANNELS: [&str; 4] = ["A", "R", "G", "B"];

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

impl RecipeInfo {
    /// Returns the graph with the recipe of an output's color as a further output, its index, and the description of the
    /// recipe at a frame.
    ///
    /// # Errors
    /// The picture is no function of its colors in a way that a recipe can hold.
    pub(super) fn added(
        graph: &CheckedGraph,
        output: usize,
        frame: i64,
        storing: Storing,
    ) -> Result<(CheckedGraph, usize, Self), Vec<Diagnostic>> {
        let mut graph = graph.clone();
        let recipe = graph.add_recipe(output, storing == Storing::Float);
        let graph = graph.with_recipes(&[recipe])?;
        let info = Self::of(&graph, LAYER, storing, frame).ok_or_else(Vec::new)?;
        Ok((graph, recipe, info))
    }

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
