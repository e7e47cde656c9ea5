//! Renders a document's graph as a diagram: nodes from sources at the top to outputs at the bottom, with their control
//! colors as swatches.
//!
//! Boxes are laid out in layers ([`layers`]) and drawn as SVG ([`tree`]) with selectable text and with tooltips for
//! boxes and wires.

mod boxes;
mod layers;
mod palette;
mod tree;

pub use boxes::Groups;
pub use layers::{Layout, Net, Point, layers};
pub use palette::{Swatch, color_name, controls, palette};
pub use tree::tree;
