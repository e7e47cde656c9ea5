//! Evaluation on a thread of its own: what is newest first, coarse before fine, and never waited for.

pub mod blame;
pub mod lens;
pub mod shown;
#[cfg(test)]
mod tests;
mod wish;
mod worker;

pub use blame::{Blamed, Question, Share};
pub use lens::{Lens, lens};
pub use shown::{Channel, Display, Screen};
pub use wish::{Job, News, Result, Subject, Thumbnail};
pub use worker::Worker;
