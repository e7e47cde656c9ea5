//! Readers of surfaces from the bytes of files: meshes (Wavefront OBJ, glTF 2.0), and Bézier patches in Trochoid's own
//! format.

mod faults;
mod gltf;
mod mesh;
mod obj;
mod patches;

pub use faults::{
    AccessorFault, BufferFault, GltfFault, MeshFault, ObjElement, ObjFault, PartFault, PatchesFault, PointPlace,
};
pub(crate) use mesh::joined;
pub use mesh::mesh;
pub use patches::patches;
