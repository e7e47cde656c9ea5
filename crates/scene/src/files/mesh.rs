//! Mesh files: Wavefront OBJ and glTF 2.0, as triangles.

use super::{MeshFault, gltf, obj};
use crate::{MAX_TRIANGLES, Triangles};

/// Reads a mesh from a file's bytes, in the file's own coordinates. The first bytes determine the format.
///
/// # Errors
/// The bytes are not a valid mesh. The error names the line, node or array.
pub fn mesh(bytes: &[u8]) -> Result<Triangles, MeshFault> {
    // Text has no 0 byte; what has one is a picture, say.
    if !bytes.starts_with(b"glTF") && bytes.iter().take(1024).any(|byte| *byte == 0) {
        return Err(MeshFault::Binary);
    }
    let text = bytes.iter().find(|byte| !byte.is_ascii_whitespace());
    let parts =
        if bytes.starts_with(b"glTF") || text == Some(&b'{') { gltf::parts(bytes)? } else { obj::parts(bytes)? };
    let whole = joined(parts)?;
    if whole.triangles.is_empty() {
        return Err(MeshFault::Empty);
    }
    whole.check()?;
    Ok(whole)
}

/// Joins parts into one mesh. If some have normals, the others get theirs from their triangles; if some have texture
/// coordinates, those of the others are 0.
pub(crate) fn joined(parts: Vec<Triangles>) -> Result<Triangles, MeshFault> {
    let total = |of: fn(&Triangles) -> usize| parts.iter().map(of).sum::<usize>();
    let most = total(|part| part.positions.len()).max(total(|part| part.triangles.len()));
    if most > MAX_TRIANGLES {
        return Err(MeshFault::TooMany(most));
    }
    let (normals, uvs) = (total(|part| part.normals.len()) > 0, total(|part| part.uvs.len()) > 0);
    let mut whole = Triangles::default();
    for mut part in parts {
        // Before parts are put together, so that an index cannot reach into another part.
        part.check()?;
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
