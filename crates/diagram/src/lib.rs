//! A document's graph as a picture: its nodes from sources at the top to outputs at the bottom, with their control
//! colors as swatches.
//!
//! Boxes are laid out in layers ([`layers`]) and drawn as SVG ([`tree`]), whose text is selectable and whose boxes and
//! wires say more when pointed at.

mod layers;
mod palette;
mod tree;

pub use layers::{Layout, Net, Point, layers};
pub use palette::{Swatch, controls, palette};
pub use tree::tree;
