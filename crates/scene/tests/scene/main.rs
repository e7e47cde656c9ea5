//! Tests of what cameras see, against the f64 references and against known properties.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod anchors;
mod bezier;
mod certain;
mod claws;
mod edge_functions;
mod edges;
mod extent;
#[cfg(feature = "files")]
mod files;
mod fineness;
mod first_hit;
mod first_point;
mod float;
mod footprint;
mod grid;
mod grid_ranges;
mod grid_ray;
mod hermite;
mod invariance;
mod light;
mod obstacles;
mod patches;
mod power;
mod random;
mod reference;
mod resolve;
mod ribbon;
mod shading;
mod spray;
mod stitch;
