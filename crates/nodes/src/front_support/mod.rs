//! What nodes of the front end share: screen coordinates, procedural noise and expressions.

mod expression;
mod noise;
mod noise_reference;
mod parser;
mod program;
mod screen;

pub(crate) use expression::Expression;
pub(crate) use noise::{Axes, Noise, NoiseKind};
pub(crate) use noise_reference::{edges as edges_reference, reference as noise_reference};
pub(crate) use parser::parse;
pub(crate) use program::Program;
pub(crate) use screen::Screen;
