//! A picture, reduced to what a page shows.

use super::super::source::Pixels;
use crate::report::pictures::data_url;
use std::error::Error;

/// Most pixels of a preview from left to right, and from top to bottom.
const MOST: usize = 560;

/// A reduced picture, without its transparent parts.
pub(in super::super) struct Preview {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
}

impl Preview {
    /// Reduces a picture: each pixel is the mean of a square.
    pub(in super::super) fn of(pixels: &Pixels) -> Self {
        let [width, height] = [pixels.window.width(), pixels.window.height()];
        let side = width.max(height).div_ceil(MOST).max(1);
        let [small_width, small_height] = [width, height].map(|length| length.div_ceil(side));
        let mut sums = vec![([0.0; 3], 0.0); small_width * small_height];
        for ([x, y], color) in pixels.seen() {
            let (sum, count) = &mut sums[y / side * small_width + x / side];
            sum.iter_mut().zip(color).for_each(|(sum, v)| *sum += v.clamp(0.0, 1.0));
            *count += 1.0;
        }
        // Where nothing is seen, a middle gray.
        let mean = |(sum, count): ([f32; 3], f32)| if count > 0.0 { sum.map(|v| v / count) } else { [0.5; 3] };
        Self { width: small_width, height: small_height, pixels: sums.into_iter().map(mean).collect() }
    }

    /// Returns the picture as a data URL.
    ///
    /// # Errors
    /// It cannot be encoded.
    pub(super) fn data_url(&self) -> Result<String, Box<dyn Error>> {
        data_url(&self.pixels, self.width, self.height)
    }
}
