//! The fast forms of seas against their f64 references, and against what is known of them.

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
