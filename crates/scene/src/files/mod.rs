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

pub use faults::{AccessorFault, BufferFault, GltfFault, Indexed, MeshFault, ObjFault, PartFault, PatchesFault, Place};
pub use mesh::mesh;
pub use patches::patches;
