//! Surfaces of triangles and patches, and their placement in the world.

mod bezier_model;
mod float;
pub(crate) mod memory;
mod mesh;
mod model_files;
mod placement;

use model_files::{check_mesh, read_mesh, read_model};
use placement::{PlacementKnobs, check_ending};
pub(crate) use placement::{PreparedSurface, Up};

use trochoid_graph::NodeType;

pub(crate) static NODES: &[NodeType] =
    &[NodeType::of::<bezier_model::BezierModel>(), NodeType::of::<float::Float>(), NodeType::of::<mesh::Mesh>()];
