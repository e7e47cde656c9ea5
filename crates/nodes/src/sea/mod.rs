//! Seas and other water, their spray and floating lines, and the foam on them.

#[cfg(feature = "sea")]
mod bake;
mod crest_foam;
#[cfg(feature = "sea")]
mod drift_lines;
mod fold_foam;
#[cfg(feature = "sea")]
mod gerstner_sea;
#[cfg(feature = "sea")]
mod profile;
mod rift;
#[cfg(feature = "sea")]
mod ripple_sea;
#[cfg(feature = "sea")]
mod spray;
#[cfg(feature = "sea")]
mod stability;
mod surface_lines;
#[cfg(feature = "sea")]
mod toon;
#[cfg(feature = "sea")]
mod toon_sea;
mod waterline_foam;
mod waters;

pub(crate) use waters::{
    Roots, check_indices, check_roots, check_same_camera, check_sea, check_surfaces, check_trails,
};

use crate::view::{ViewCopy, ViewMask};
use trochoid_graph::NodeType;

pub(crate) static NODES: &[NodeType] = &[
    #[cfg(feature = "sea")]
    NodeType::of::<bake::Bake>(),
    NodeType::of::<ViewMask<crest_foam::CrestFoam>>(),
    #[cfg(feature = "sea")]
    NodeType::of::<drift_lines::DriftLines>(),
    NodeType::of::<ViewMask<fold_foam::FoldFoam>>(),
    #[cfg(feature = "sea")]
    NodeType::of::<gerstner_sea::GerstnerSea>(),
    NodeType::of::<ViewCopy<rift::Rift>>(),
    #[cfg(feature = "sea")]
    NodeType::of::<ripple_sea::RippleSea>(),
    #[cfg(feature = "sea")]
    NodeType::of::<spray::Spray>(),
    NodeType::of::<surface_lines::SurfaceLines>(),
    #[cfg(feature = "sea")]
    NodeType::of::<toon_sea::ToonSea>(),
    NodeType::of::<waterline_foam::WaterlineFoam>(),
];
