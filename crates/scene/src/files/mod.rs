//! Surfaces in the bytes of files: meshes as Wavefront OBJ and glTF 2.0, and patches as models of Trochoid's own.

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
