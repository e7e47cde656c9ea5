//! What cameras see, against the f64 references and against what is known of it.

mod anchors;
mod bezier;
mod certain;
mod edges;
mod fineness;
mod float;
mod grid;
mod invariance;
mod random;
mod reference;
mod spray;
