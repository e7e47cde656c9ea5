//! Mesh files: Wavefront OBJ and glTF 2.0, as triangles.

mod gltf;
mod obj;
#[cfg(test)]
mod samples;
#[cfg(test)]
mod tests;

use std::path::Path;
use trochoid_graph::NodeError;
use trochoid_scene::{MAX_TRIANGLES, Triangles};

/// What a decoded mesh takes at most of each byte of its file: an index of two digits becomes three of 8 bytes, and a
/// corner of a triangle.
const BYTES_PER_BYTE: u64 = 32;

/// The mesh of a file, in the file's own space. What the file is follows from how it begins.
///
/// # Errors
/// The file cannot be read, is too large for `memory` bytes, or is no mesh: with the line, node or array at fault.
pub(crate) fn read_mesh(path: &Path, memory: u64) -> Result<Triangles, NodeError> {
    let fault = |message: String| NodeError::from(std::io::Error::other(format!("{}: {message}", path.display())));
    let bytes = trochoid_io::read_bytes(path, memory / BYTES_PER_BYTE)?;
    mesh(&bytes).map_err(fault)
}

/// The mesh in a file's bytes.
fn mesh(bytes: &[u8]) -> Result<Triangles, String> {
    // Text has no 0 byte; what has one is a picture, say.
    if !bytes.starts_with(b"glTF") && bytes.iter().take(1024).any(|byte| *byte == 0) {
        return Err("found a binary file that is no GLB; expected a mesh: .obj, .glb and .gltf are read".into());
    }
    let text = bytes.iter().find(|byte| !byte.is_ascii_whitespace());
    let parts =
        if bytes.starts_with(b"glTF") || text == Some(&b'{') { gltf::parts(bytes)? } else { obj::parts(bytes)? };
    let whole = joined(parts)?;
    if whole.triangles.is_empty() {
        return Err(
            "found no triangle; expected a mesh, .obj, .glb or .gltf: export its faces too, or name another file"
                .into(),
        );
    }
    whole.check().map_err(|error| error.to_string())?;
    Ok(whole)
}

/// The parts as one mesh. Where some have normals the others get theirs from their triangles; where some have texture
/// coordinates, those of the others are 0.
fn joined(parts: Vec<Triangles>) -> Result<Triangles, String> {
    let total = |of: fn(&Triangles) -> usize| parts.iter().map(of).sum::<usize>();
    let most = total(|part| part.positions.len()).max(total(|part| part.triangles.len()));
    if most > MAX_TRIANGLES {
        return Err(format!("found {most} triangles or vertices; expected at most {MAX_TRIANGLES}: reduce the mesh"));
    }
    let (normals, uvs) = (total(|part| part.normals.len()) > 0, total(|part| part.uvs.len()) > 0);
    let mut whole = Triangles::default();
    for mut part in parts {
        // Before parts are put together, so that an index cannot reach into another part.
        part.check().map_err(|error| error.to_string())?;
        let first = whole.positions.len() as u32;
        if normals && part.normals.is_empty() {
            part.normals = part.mean_normals();
        }
        if uvs && part.uvs.is_empty() {
            part.uvs = vec![[0.0; 2]; part.positions.len()];
        }
        whole.positions.append(&mut part.positions);
        whole.normals.append(&mut part.normals);
        whole.uvs.append(&mut part.uvs);
        whole.triangles.extend(part.triangles.iter().map(|corners| corners.map(|vertex| first + vertex)));
    }
    Ok(whole)
}
