//! A picture as the weights of the colors that are looked for.

/// Weights of a picture over colors, and what is not looked for.
#[derive(Clone, Debug)]
pub(crate) struct Weighed {
    /// Number of the colors that are looked for.
    pub(crate) colors: usize,
    /// Their weights, pixel by pixel.
    pub(crate) weights: Vec<f32>,
    /// What the other colors, and images, add to each pixel, in the working space.
    pub(crate) rest: Vec<[f32; 3]>,
}

impl Weighed {
    /// Returns the number of pixels.
    pub(crate) fn pixels(&self) -> usize {
        self.rest.len()
    }

    /// Returns the weights of a pixel.
    pub(crate) fn of(&self, pixel: usize) -> &[f32] {
        &self.weights[pixel * self.colors..][..self.colors]
    }

    /// Returns the mean weight of each color.
    pub(crate) fn shares(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.colors];
        for pixel in 0..self.pixels() {
            sums.iter_mut().zip(self.of(pixel)).for_each(|(sum, weight)| *sum += f64::from(*weight));
        }
        let count = self.pixels().max(1) as f64;
        sums.into_iter().map(|sum| sum / count).collect()
    }

    /// Returns a pixel in some colors.
    pub(crate) fn mixed(&self, pixel: usize, colors: &[[f64; 3]]) -> [f64; 3] {
        let mut sum = self.rest[pixel].map(f64::from);
        for (weight, color) in self.of(pixel).iter().zip(colors) {
            (0..3).for_each(|c| sum[c] += f64::from(*weight) * color[c]);
        }
        sum
    }

    /// Returns so many pixels, or all if there are fewer, evenly from all over the picture.
    pub(crate) fn sampled(&self, most: usize) -> Self {
        let pixels = evenly(self.pixels(), most);
        Self {
            colors: self.colors,
            weights: pixels.iter().flat_map(|pixel| self.of(*pixel)).copied().collect(),
            rest: pixels.iter().map(|pixel| self.rest[*pixel]).collect(),
        }
    }
}

/// Returns so many of some indices, or all if there are fewer: evenly, and without the beat that a constant step would have
/// with the rows of a picture.
pub(crate) fn evenly(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    // Multiples of the golden ratio, modulo 1, are evenly apart.
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    (0..most).map(|index| (((index as f64 + 0.5) * GOLDEN).fract() * count as f64) as usize).collect()
}
