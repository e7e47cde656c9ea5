//! What cameras see, against the f64 references and against what is known of it.

mod bezier;
mod edges;
mod grid;
mod invariance;
mod reference;
mod spray;
