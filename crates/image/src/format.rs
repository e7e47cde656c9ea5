//! The format of pictures: size, samples per pixel and shading.

use crate::Window;
use trochoid_key::content_key;

/// Largest width and height of a picture, in pixels.
pub const MAX_SIDE: u32 = 1 << 20;
/// Largest number of pixels of a picture.
pub const MAX_PIXELS: u64 = 1 << 31;

/// Format of a document's pictures: their size, the number of samples averaged per pixel, and how often they are
/// shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Format {
    width: u32,
    height: u32,
    samples: u32,
    shading: Shading,
    /// Bits of the tolerance of adaptive sampling.
    adaptive: Option<u32>,
}

content_key!(Format { width, height, samples, shading, adaptive });

/// Samples at which passes that vary smoothly over a surface are evaluated. Visibility and back-end operations are
/// evaluated at every sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Shading {
    /// Every sample.
    #[default]
    Sample,
    /// The pixel's first sample, for all samples that see the same surface at nearly the same depth
    /// ([`Shading::SAME_DEPTH`]), like the multisampling of graphics processors.
    Pixel,
}

content_key!(
    enum Shading {
        Sample,
        Pixel,
    }
);

impl Shading {
    /// Every shading.
    pub const ALL: [Self; 2] = [Self::Sample, Self::Pixel];

    /// Largest difference in depth, relative to the first sample, of samples that share their shading. On surfaces
    /// seen at an angle of less than about three degrees, samples do not share it.
    pub const SAME_DEPTH: f64 = 1.0 / 64.0;

    /// Returns the name in documents.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sample => "sample",
            Self::Pixel => "pixel",
        }
    }

    /// Returns the shading with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|shading| shading.name() == name)
    }

    /// Whether a sample, given by its surface and depth, takes its shading from the first sample of the pixel. Depth
    /// +∞ means that nothing is seen.
    #[inline]
    pub fn is_shared(first: (f64, f64), (surface, depth): (f64, f64)) -> bool {
        let near = (depth - first.1).abs() <= Self::SAME_DEPTH * first.1.abs();
        (surface == first.0) & (near | (depth == first.1))
    }
}

/// Error: a format of pictures is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// A side is 0 or too large.
    #[error("a picture of {width} × {height} pixels is refused: each side must have 1 to {MAX_SIDE} pixels")]
    Side {
        /// Width found.
        width: u32,
        /// Height found.
        height: u32,
    },
    /// The picture has too many pixels in total.
    #[error("a picture of {width} × {height} pixels is refused: at most {MAX_PIXELS} pixels in total")]
    Area {
        /// Width found.
        width: u32,
        /// Height found.
        height: u32,
    },
    /// No sample pattern exists for the number of samples.
    #[error("{samples} samples per pixel are refused: use 1, 4 or 16")]
    Samples {
        /// Number found.
        samples: u32,
    },
}

impl Format {
    /// Makes a format of `width` × `height` pixels with 1, 4 or 16 samples per pixel.
    ///
    /// # Errors
    /// A side or the area is outside of the limits, or no sample pattern exists for the number of samples.
    pub fn new(width: u32, height: u32, samples: u32) -> Result<Self, FormatError> {
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return Err(FormatError::Side { width, height });
        }
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(FormatError::Area { width, height });
        }
        if !matches!(samples, 1 | 4 | 16) {
            return Err(FormatError::Samples { samples });
        }
        Ok(Self { width, height, samples, shading: Shading::Sample, adaptive: None })
    }

    /// Sets how often pixels are shaded.
    #[must_use]
    pub fn with_shading(self, shading: Shading) -> Self {
        Self { shading, ..self }
    }

    /// Returns how often pixels are shaded.
    pub fn shading(self) -> Shading {
        self.shading
    }

    /// Sets the tolerance of adaptive sampling, from 0 to 1; every sample of every pixel is taken if `None`.
    ///
    /// A pixel keeps its first sample if the first samples of the pixels around it, its own among them, differ by at most the
    /// tolerance in every channel; else all of its samples are averaged. Differences are between square roots, since that is
    /// about how eyes compare light: −√−v for negative values.
    ///
    /// ```
    /// let format = trochoid_image::Format::new(1920, 1080, 4)?.with_adaptive(Some(1.0 / 64.0));
    /// assert_eq!(format.adaptive(), Some(0.015625));
    /// # Ok::<(), trochoid_image::FormatError>(())
    /// ```
    #[must_use]
    pub fn with_adaptive(self, tolerance: Option<f32>) -> Self {
        Self { adaptive: tolerance.map(|tolerance| tolerance.clamp(0.0, 1.0).to_bits()), ..self }
    }

    /// Returns the tolerance of adaptive sampling, in \[0, 1\]; `None` if every sample is taken.
    pub fn adaptive(self) -> Option<f32> {
        self.adaptive.map(f32::from_bits)
    }

    /// Samples and shades pixels like another format, but for the number of samples.
    #[must_use]
    pub fn sampled_like(self, other: Self) -> Self {
        Self { shading: other.shading, adaptive: other.adaptive, ..self }
    }

    /// Returns the width in pixels.
    pub fn width(self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(self) -> u32 {
        self.height
    }

    /// Returns the number of samples per pixel.
    pub fn samples(self) -> u32 {
        self.samples
    }

    /// Returns the display window, at the origin.
    pub fn window(self) -> Window {
        Window::sized(self.width, self.height)
    }

    /// Returns the offset of sample `index` from its pixel's upper left corner, in pixels.
    ///
    /// A single sample is at the center. 4 and 16 samples form a rotated grid: every row and every column of the
    /// pixel's finer raster contains exactly one, so that antialiased edges near the axes have as many steps as there
    /// are samples.
    pub fn sample_offset(self, index: u32) -> [f64; 2] {
        match self.samples {
            1 => [0.5, 0.5],
            n => {
                // Sample (i, j) of an m × m grid, shifted by the other index: all n rows and columns differ.
                let m = if n == 4 { 2 } else { 4 };
                let (i, j) = (index % m, index / m);
                let fine = f64::from(n);
                [(f64::from(i * m + j) + 0.5) / fine, (f64::from(j * m + (m - 1 - i)) + 0.5) / fine]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fine_row_and_column_holds_one_sample() {
        for n in [4, 16] {
            let format = Format::new(8, 8, n).expect("valid");
            for axis in 0..2 {
                let mut cells: Vec<u32> =
                    (0..n).map(|i| (format.sample_offset(i)[axis] * f64::from(n)).floor() as u32).collect();
                cells.sort_unstable();
                assert_eq!(cells, (0..n).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn limits_hold() {
        assert!(Format::new(0, 1, 1).is_err());
        assert!(Format::new(MAX_SIDE + 1, 1, 1).is_err());
        assert!(Format::new(MAX_SIDE, MAX_SIDE, 1).is_err());
        assert!(Format::new(MAX_SIDE, 2048, 16).is_ok());
        assert!(Format::new(1, 1, 3).is_err());
    }
}
