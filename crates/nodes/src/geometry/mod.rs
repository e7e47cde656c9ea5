//! Surfaces of triangles and patches, and their placement in the world.

mod bezier_model;
mod float;
pub(crate) mod memory;
mod mesh;
mod mesh_files;
mod model;
mod placement;

use mesh_files::read_mesh;
use model::{patch, read_model};
use placement::{Stance, check_ending};
pub(crate) use placement::{Standing, Up};

use trochoid_graph::NodeType;

pub(crate) static NODES: &[NodeType] =
    &[NodeType::of::<bezier_model::BezierModel>(), NodeType::of::<float::Float>(), NodeType::of::<mesh::Mesh>()];
