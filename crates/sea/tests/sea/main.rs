//! Tests of the fast forms of seas against their f64 references, and against known properties.

mod doubt;
mod drift;
mod evaluation;
mod folding;
mod grids;
mod group;
mod keys;
mod random;
mod ripple;
mod spray;
mod stability;
mod toon;
mod twice;
