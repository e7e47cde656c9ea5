//! Screen coordinates that do not depend on the picture's size.

use trochoid_image::Format;

/// Screen coordinates of a format: x to the right and y down from the upper left corner, in picture heights, so that
/// nothing measured in them changes with the number of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Screen {
    /// Pixels in a picture height.
    pub(crate) height: f64,
}

impl Screen {
    pub(crate) fn of(format: Format) -> Self {
        Self { height: f64::from(format.height()) }
    }

    /// The coordinates of a place in pixels.
    pub(crate) fn at(self, pixels: [f64; 2]) -> [f64; 2] {
        pixels.map(|coordinate| coordinate / self.height)
    }
}
