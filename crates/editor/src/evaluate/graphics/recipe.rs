//! Recipes on a card.

use super::card::{Card, Kernel};
use super::conversion::{Conversion, TEXT};
use super::error::CardError;
use crate::evaluate::Painting;
use crate::evaluate::shown::Screen;
use std::sync::{Arc, Weak};
use trochoid::PackedRecipe;
use wgpu::Buffer;

/// Paints recipes, of which the last one stays on the card.
#[derive(Debug)]
pub(super) struct Recipes {
    kernel: Kernel,
    kept: Option<(Weak<PackedRecipe>, Weights)>,
}

/// The weights of a recipe.
#[derive(Debug)]
struct Weights {
    tiles: Buffer,
    places: Buffer,
    samples: Buffer,
}

impl Recipes {
    pub(super) fn new(card: &Card) -> Result<Self, CardError> {
        let kernel = card.kernel(&[TEXT, include_str!("recipe.wgsl")].concat())?;
        Ok(Self { kernel, kept: None })
    }

    /// Paints a picture.
    pub(super) fn paint(&mut self, card: &Card, painting: &Painting) -> Result<Screen, CardError> {
        let recipe = &painting.recipe.0;
        let window = recipe.window();
        let size = [window.width(), window.height()];
        let tile = [recipe.tile_width(), recipe.strip(0).height().max(1)];
        let conversion = Conversion::of_colors(recipe.info().space, &painting.display)?;
        let uploaded = conversion.upload(card, size, tile, painting.spot.is_some())?;
        let is_known = |(known, _): &(Weak<PackedRecipe>, Weights)| std::ptr::eq(known.as_ptr(), Arc::as_ptr(recipe));
        // The one before is gone before the new one needs the memory.
        let kept = self.kept.take().filter(is_known);
        let (_, weights) = match kept {
            Some(kept) => self.kept.insert(kept),
            None => self.kept.insert((Arc::downgrade(recipe), Weights::new(card, recipe)?)),
        };
        // What images contribute is weighted already.
        let images = recipe.info().has_images.then_some([0.0; 3]);
        let colors = painting.colors.iter().copied().chain(images).enumerate();
        let colors: Vec<[f32; 4]> = colors
            .map(|(at, [r, g, b])| {
                let stands_out = painting.spot.as_ref().is_some_and(|members| members[at]);
                [r as f32, g as f32, b as f32, f32::from(u8::from(stands_out))]
            })
            .collect();
        let colors = card.upload(&[bytemuck::cast_slice(&colors)])?;
        let buffers = [
            &uploaded.settings,
            &uploaded.table,
            &uploaded.encoding,
            &weights.tiles,
            &weights.places,
            &weights.samples,
            &colors,
        ];
        Ok(Screen { size, pixels: card.run(&self.kernel, window.area(), &buffers)? })
    }
}

impl Weights {
    /// Copies the weights of a recipe to the card.
    fn new(card: &Card, recipe: &PackedRecipe) -> Result<Self, CardError> {
        let (mut tiles, mut places, mut samples): (Vec<[u32; 4]>, Vec<u32>, Vec<f32>) = Default::default();
        for strip in 0..recipe.strips() {
            recipe.weights(strip, |tile, own, weights| {
                let has_images = weights.len() > own.len() * tile.area();
                let [first, count, sample] = [places.len(), own.len(), samples.len()].map(|at| at as u32);
                tiles.push([first, count, sample, u32::from(has_images)]);
                places.extend(own);
                samples.extend(weights);
            });
            let bytes = size_of_val(&samples[..]) as u64;
            if bytes > card.most() {
                return Err(CardError::Large { bytes, most: card.most() });
            }
        }
        Ok(Self {
            tiles: card.upload(&[bytemuck::cast_slice(&tiles)])?,
            places: card.upload(&[bytemuck::cast_slice(&places)])?,
            samples: card.upload(&[bytemuck::cast_slice(&samples)])?,
        })
    }
}
