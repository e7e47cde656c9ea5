//! Screen coordinates that do not depend on the picture's size.

use std::ops::Range;
use trochoid_image::Format;
use trochoid_memory::Scratch;

/// Screen coordinates of a format: x to the right and y down from the upper left corner, in picture heights, so that
/// they do not depend on the number of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Screen {
    /// Picture height, in pixels.
    pub(crate) height: f64,
}

impl Screen {
    pub(crate) fn of(format: Format) -> Self {
        Self { height: f64::from(format.height()) }
    }

    /// Converts a position in pixels to screen coordinates.
    pub(crate) fn at(self, pixels: [f64; 2]) -> [f64; 2] {
        pixels.map(|coordinate| coordinate / self.height)
    }

    /// Converts the positions of samples in some columns, at an offset in their pixels.
    pub(crate) fn columns(self, columns: Range<i64>, offset: f64) -> Scratch<f64> {
        columns.map(|column| (column as f64 + offset) / self.height).collect()
    }

    /// Converts the position of samples in a row, at an offset in their pixels.
    pub(crate) fn row(self, row: i64, offset: f64) -> f64 {
        (row as f64 + offset) / self.height
    }
}
