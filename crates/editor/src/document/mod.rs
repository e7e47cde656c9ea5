//! The document model: text, interpretation, and edits. Independent of drawing.

pub mod change;
pub mod clip;
pub mod color;
pub mod curve;
pub mod decor;
pub mod dropped;
pub mod edit;
pub mod find;
pub mod group;
pub mod history;
pub mod json;
pub mod keep;
pub mod keyed;
pub mod link;
pub mod meaning;
pub mod output;
pub mod palette;
pub mod palette_file;
pub mod relocate;
pub mod session;
pub mod sheet;
pub mod swatches;
pub mod template;
#[cfg(test)]
pub(crate) mod tests;
mod trial;
pub mod version;

pub use change::{Edit, spoken};
pub use json::{Op, Path, Step};
pub use session::Session;
pub use sheet::{Node, Pin, Point, Sheet, Wire};
pub use version::VersionStatus;
