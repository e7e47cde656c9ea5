//! What a page takes from a recipe.

use trochoid::{Recipe, Window, WorkingSpace};

/// Weights of a picture over named colors.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Weights {
    pub(super) names: Vec<String>,
    /// Colors in the working space.
    pub(super) colors: Vec<[f64; 3]>,
    pub(super) space: WorkingSpace,
    /// Picture's frame.
    pub(super) window: Window,
    /// For each color its weights, row by row: ≥ 0, and with the sum 1 at each pixel.
    pub(super) weights: Vec<Vec<f32>>,
}

impl Weights {
    /// Takes the weights of a recipe; `None` if images contribute to its picture, which are no mixes of its colors.
    pub(super) fn of(recipe: Recipe) -> Option<Self> {
        let (info, weights) = (recipe.info, recipe.channels);
        (!info.has_images).then_some(Self {
            names: info.names,
            colors: info.colors,
            space: info.space,
            window: recipe.window,
            weights,
        })
    }
}
