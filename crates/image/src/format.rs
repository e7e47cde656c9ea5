use crate::Window;
use trochoid_key::content_key;

/// Largest width and height of a picture, in pixels.
pub const MAX_SIDE: u32 = 1 << 20;
/// Largest number of pixels of a picture.
pub const MAX_PIXELS: u64 = 1 << 31;

/// The size of a document's pictures, how many samples each pixel averages, and how often they are shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Format {
    width: u32,
    height: u32,
    samples: u32,
    shading: Shading,
}

content_key!(Format { width, height, samples, shading });

/// Where the samples of a pixel take passes that vary smoothly over a surface. What is visible, and every back-end
/// operation, is evaluated at each sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Shading {
    /// Each at its own place.
    #[default]
    Sample,
    /// At the place of the pixel's first sample, where both see the same surface at nearly the same depth, see
    /// [`Shading::SAME_DEPTH`]: the multisampling of graphics processors.
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

    /// Samples of a pixel share their shading where their depths differ by at most so much of the first one's. On
    /// surfaces that are seen under less than about three degrees they do not.
    pub const SAME_DEPTH: f64 = 1.0 / 64.0;

    /// As documents name it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sample => "sample",
            Self::Pixel => "pixel",
        }
    }

    /// The shading of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|shading| shading.name() == name)
    }

    /// Whether a sample that sees a surface at a depth takes its shading from the first one of its pixel. Nothing is
    /// seen at depth +∞.
    #[inline]
    pub fn is_shared(first: (f64, f64), (surface, depth): (f64, f64)) -> bool {
        let near = (depth - first.1).abs() <= Self::SAME_DEPTH * first.1.abs();
        (surface == first.0) & (near | (depth == first.1))
    }
}

/// Why a picture's format is refused.
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
    /// Too many pixels in all.
    #[error("a picture of {width} × {height} pixels is refused: at most {MAX_PIXELS} pixels in total")]
    Area {
        /// Width found.
        width: u32,
        /// Height found.
        height: u32,
    },
    /// Not a number of samples that has a pattern.
    #[error("{samples} samples per pixel are refused: use 1, 4 or 16")]
    Samples {
        /// Number found.
        samples: u32,
    },
}

impl Format {
    /// A format of `width` × `height` pixels with 1, 4 or 16 samples a pixel.
    ///
    /// # Errors
    /// A side or the area is outside the limits, or the number of samples has no pattern.
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
        Ok(Self { width, height, samples, shading: Shading::Sample })
    }

    /// The same, shaded so often.
    #[must_use]
    pub fn with_shading(self, shading: Shading) -> Self {
        Self { shading, ..self }
    }

    /// How often pixels are shaded.
    pub fn shading(self) -> Shading {
        self.shading
    }

    /// Width in pixels.
    pub fn width(self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(self) -> u32 {
        self.height
    }

    /// Samples a pixel.
    pub fn samples(self) -> u32 {
        self.samples
    }

    /// The display window, at the origin.
    pub fn window(self) -> Window {
        Window::sized(self.width, self.height)
    }

    /// Offset of sample `index` from its pixel's upper left corner, in pixels.
    ///
    /// One sample stands at the center. 4 and 16 samples form a rotated grid: every row and every column of
    /// the pixel's finer raster holds exactly one, so that edges near the axes come out in as many steps
    /// as there are samples.
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
