//! What nodes of the front end share: screen coordinates, procedural noise and expressions.

mod expression;
mod known;
#[cfg_attr(not(feature = "scene"), allow(dead_code, reason = "only lines on water ask for slopes"))]
mod noise;
#[cfg_attr(not(feature = "scene"), allow(dead_code, reason = "only lines on water ask for slopes"))]
mod noise_reference;
mod noise_span;
mod parser;
mod program;
mod screen;
mod span;

pub(crate) use expression::Expression;
#[cfg(feature = "io")]
pub(crate) use known::bound_exact;
pub(crate) use known::{bound_at, bound_by, certain, known, where_covered};
#[cfg(feature = "scene")]
pub(crate) use noise::Octave;
pub(crate) use noise::{Axes, Noise, NoiseKind};
#[cfg(feature = "scene")]
pub(crate) use noise_reference::edges as edges_reference;
pub(crate) use noise_reference::reference as noise_reference;
pub(crate) use noise_span::span as noise_span;
pub(crate) use parser::parse;
pub(crate) use program::Program;
pub(crate) use screen::Screen;
pub(crate) use span::Span;
