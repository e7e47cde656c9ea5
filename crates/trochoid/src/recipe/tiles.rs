//! Weights in tiles, which hold only the colors that they have.

use trochoid_engine::{StoredSample, paint};

/// Width and height of a tile: small, so that few colors are in it.
pub(super) const SIDES: [usize; 2] = [64, 8];

/// Weights of some pixels.
#[derive(Debug)]
pub(super) struct Tile<S> {
    /// Weights that are not 0 everywhere, by their place in the recipe.
    places: Vec<u32>,
    /// Whether what images contribute is stored: red, green and blue after the weights.
    has_images: bool,
    /// Samples, pixel by pixel for each weight.
    samples: Vec<S>,
}

impl<S: StoredSample> Tile<S> {
    /// Packs the channels of a recipe at some pixels, which are given by their indices.
    pub(super) fn pack(channels: &[Vec<f32>], weights: usize, pixels: &[usize]) -> Self {
        let (weights, images) = channels.split_at(weights);
        let is_used = |channel: &&Vec<f32>| pixels.iter().any(|pixel| channel[*pixel] != 0.0);
        let used: Vec<u32> = (0..weights.len()).filter(|at| is_used(&&weights[*at])).map(|at| at as u32).collect();
        let has_images = images.iter().any(|channel| is_used(&channel));
        let stored = used.iter().map(|at| &weights[*at as usize]).chain(images.iter().filter(|_| has_images));
        let samples = stored.flat_map(|channel| pixels.iter().map(|pixel| S::store(channel[*pixel]))).collect();
        Self { places: used, has_images, samples }
    }

    /// Returns the bytes that the tile takes.
    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&self.places[..]) + size_of_val(&self.samples[..])
    }

    /// Mixes colors, one for each weight of the recipe.
    pub(super) fn paint(&self, factors: &[[f64; 3]], out: [&mut [f32]; 3]) {
        let count = out[0].len();
        let used: Vec<[f64; 3]> = self.places.iter().map(|place| factors[*place as usize]).collect();
        let rows: Vec<&[S]> = self.samples.chunks_exact(count).collect();
        let (weights, images) = rows.split_at(used.len());
        let images = if self.has_images { images.try_into().ok() } else { None };
        // They were rounded to the sum 1 before they were packed.
        let painted = paint(weights, &used, images, out);
        debug_assert!(painted.is_ok(), "weights with the sum 1");
    }

    /// Adds up what changes of some colors change; returns whether the pixels have weights of any of them.
    pub(super) fn shift(&self, changes: &[Option<[f64; 3]>], mut out: [&mut [f32]; 3]) -> bool {
        let count = out[0].len();
        let mut row = [0.0_f32; SIDES[0] * SIDES[1]];
        let row = &mut row[..count];
        let mut is_any = false;
        for (place, samples) in self.places.iter().zip(self.samples.chunks_exact(count)) {
            let Some(change) = changes[*place as usize] else { continue };
            S::widen(samples, row);
            for (out, change) in out.iter_mut().zip(change) {
                if !is_any {
                    out.fill(0.0);
                }
                let change = change as f32;
                out.iter_mut().zip(&*row).for_each(|(sum, weight)| *sum += weight * change);
            }
            is_any = true;
        }
        is_any
    }

    /// Adds up the weights of some colors.
    pub(super) fn sum(&self, members: &[bool], out: &mut [f32]) {
        out.fill(0.0);
        let mut row = vec![0.0; out.len()];
        for (place, samples) in self.places.iter().zip(self.samples.chunks_exact(out.len())) {
            if members[*place as usize] {
                S::widen(samples, &mut row);
                out.iter_mut().zip(&row).for_each(|(sum, weight)| *sum += weight);
            }
        }
    }

    /// Widens all samples, and returns the places of the weights.
    pub(super) fn widened(&self, samples: &mut Vec<f32>) -> &[u32] {
        samples.resize(self.samples.len(), 0.0);
        S::widen(&self.samples, samples);
        &self.places
    }

    /// Returns the weights of a pixel, each with its place.
    pub(super) fn at(&self, pixel: usize, count: usize) -> Vec<(usize, f32)> {
        let rows = self.samples.chunks_exact(count).zip(&self.places);
        let weight = |samples: &[S]| {
            let mut weight = [0.0];
            S::widen(&samples[pixel..=pixel], &mut weight);
            weight[0]
        };
        let all = rows.map(|(samples, place)| (*place as usize, weight(samples)));
        all.filter(|(_, weight)| *weight > 0.0).collect()
    }
}
