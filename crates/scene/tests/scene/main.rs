//! Tests of what cameras see, against the f64 references and against known properties.

mod anchors;
mod bezier;
mod certain;
mod edges;
mod fineness;
mod float;
mod grid;
mod invariance;
mod patches;
mod random;
mod reference;
mod spray;
