//! Tests of the fast forms of seas against their f64 references, and against known properties.

mod doubt;
mod drift;
mod evaluation;
mod flight;
mod folding;
mod framed;
mod grids;
mod group;
mod keys;
mod line;
mod precise;
mod random;
mod ripple;
mod run;
mod spectrum;
mod spray;
mod stability;
mod toon;
mod trails;
mod transforms;
mod twice;
