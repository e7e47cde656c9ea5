//! Windows, planes, tiles, formats, channels and working spaces: the definitions of pixels that all of Trochoid shares.
//!
//! Conventions: y points down, windows are half-open, the center of pixel `x` is at `x + ½`.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

mod channel;
mod color;
mod format;
pub mod oklab;
mod plane;
mod space;
mod spread;
mod window;

pub use channel::{Channel, ChannelSet};
pub use color::{HexError, parse_hex};
pub use format::{Format, FormatError, MAX_PIXELS, MAX_SIDE, Shading};
pub use oklab::{oklab, oklch, shown_oklch};
pub use plane::{Plane, PlaneError};
pub use space::{Chromaticities, WorkingSpace, srgb_decode, srgb_encode, srgb_fall};
pub use spread::spread;
pub use window::{Tiles, Window};

/// A color in the working space: red, green, blue.
pub type Rgb = [f32; 3];
