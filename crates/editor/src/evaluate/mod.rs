//! Evaluation on a separate thread: newest request first, coarse before fine, and the interface never waits for it.

pub mod blame;
mod error;
mod evaluator;
mod graphics;
mod known;
mod lane;
pub mod lens;
mod mixture;
mod painter;
mod picture;
mod queue;
mod request;
pub mod shown;
mod subject;
#[cfg(test)]
mod tests;
mod worker;

pub use blame::{Blamed, Origin, Question, Share};
#[cfg(feature = "gpu")]
pub use graphics::Cards;
pub use graphics::Graphics;
pub use lane::Lane;
pub use lens::{Lens, lens};
pub use mixture::Mixture;
pub use painter::{Painted, Painter, Painting, SharedRecipe};
pub use request::{Job, News, Result, Thumbnail};
pub use shown::{Channel, Display, Screen};
pub use subject::Subject;
pub use worker::Worker;
