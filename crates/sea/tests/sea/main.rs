//! The fast forms of seas against their f64 references, and against what is known of them.

mod evaluation;
mod folding;
mod grids;
mod group;
mod random;
mod spray;
mod ripple;
mod toon;
