//! Readers of surfaces from the bytes of files: meshes (Wavefront OBJ, glTF 2.0), and Bézier patches in Trochoid's own
//! format.

mod faults;
mod gltf;
mod mesh;
mod obj;
mod patches;
#[cfg(test)]
mod samples;
#[cfg(test)]
mod tests;

pub use faults::{
    AccessorFault, BufferFault, GltfFault, MeshFault, ObjElement, ObjFault, PartFault, PatchesFault, PointPlace,
};
pub use mesh::mesh;
pub use patches::patches;
