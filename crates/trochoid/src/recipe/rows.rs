//! Weights as the engine computes them, rounded to what a file stores.

use super::info::{RecipeInfo, Rounding};
use std::sync::{Mutex, PoisonError};
use trochoid_engine::{Apportioner, Storing};

/// The channels of a recipe while rows of pixels are rounded, from many threads.
#[derive(Debug)]
pub(crate) struct RecipeRows {
    pub(crate) info: RecipeInfo,
    rounding: Mutex<Rounding>,
}

impl RecipeRows {
    pub(crate) fn new(info: RecipeInfo) -> Self {
        Self { info, rounding: Mutex::default() }
    }

    /// Returns what was rounded so far.
    pub(super) fn rounding(&self) -> Rounding {
        *self.rounding.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the metadata, when all rows are stored.
    #[cfg(feature = "io")]
    pub(crate) fn metadata(&self) -> (String, String) {
        self.info.metadata(self.rounding())
    }

    /// Rounds pixels: turns the layers of a recipe, channel by channel, into the channels of the file.
    pub(crate) fn store(&self, layers: &[&[f32]], channels: &mut Vec<Vec<f32>>) {
        let RecipeInfo { has_images, storing, .. } = &self.info;
        let rows = &layers[..self.info.weights()];
        channels.resize_with(rows.len(), Vec::new);
        channels.iter_mut().zip(rows).for_each(|(channel, row)| channel.resize(row.len(), 0.0));
        let mut found = Rounding { moved: Apportioner::new(*storing).rows(rows, channels), ..Rounding::default() };
        if *has_images {
            // The color stands in the last layer; where rounding leaves an image no weight, it may keep a color.
            for row in &layers[layers.len() - 3..] {
                if *storing == Storing::Half {
                    let off = row.iter().map(|value| half_step(*value));
                    found.images = off.fold(found.images, f64::max);
                }
                channels.push(row.to_vec());
            }
        }
        let mut rounding = self.rounding.lock().unwrap_or_else(PoisonError::into_inner);
        *rounding = rounding.max(found);
    }
}

/// Largest share by which a half differs from a number that was rounded to it: 2⁻¹¹.
const HALF: f64 = 1.0 / 2048.0;
/// Half of the smallest half: 2⁻²⁵.
const LEAST: f64 = 1.0 / 33_554_432.0;

/// Bounds how far a value ≥ 0 moves as it is rounded to a half.
fn half_step(value: f32) -> f64 {
    if value > 0.0 { (f64::from(value) * HALF).max(LEAST) } else { 0.0 }
}
