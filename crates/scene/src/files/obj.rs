//! Wavefront OBJ, parsed by the crate `tobj`.

use super::faults::MAX_COORDINATE;
use super::{ObjElement, ObjFault};
use crate::{DVec3, Triangles};
use std::cell::Cell;
use std::io::{BufRead, Read};
use tobj::LoadOptions;

/// Reads the objects and groups of a file. Points, lines and materials are left out.
pub(super) fn parts(bytes: &[u8]) -> Result<Vec<Triangles>, ObjFault> {
    check_faces(bytes)?;
    let options = LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let line = Cell::new(0);
    let mut lines = Lines { rest: bytes, line: &line };
    // Colors are the document's, so no material file is opened.
    let models = tobj::load_obj_buf(&mut lines, &options, |_| Ok(Default::default()))
        .map_err(|fault| ObjFault::Line { line: line.get(), fault })?
        .0;
    models.into_iter().map(|model| part(model.name, model.mesh)).collect()
}

fn part(object: String, mesh: tobj::Mesh) -> Result<Triangles, ObjFault> {
    let vectors = |values: &[f64]| values.chunks_exact(3).map(DVec3::from_slice).collect();
    let (triangles, _) = mesh.indices.as_chunks();
    let part = Triangles {
        positions: vectors(&mesh.positions),
        normals: vectors(&mesh.normals),
        uvs: mesh.texcoords.as_chunks().0.to_vec(),
        triangles: triangles.to_vec(),
    };
    let wild = |v: &f64| !v.is_finite() || v.abs() > MAX_COORDINATE;
    if let Some(at) = mesh.positions.iter().position(wild) {
        return Err(ObjFault::Coordinate { object, found: mesh.positions[at] });
    }
    // The library drops what a corner lacks, which would shift what the others have.
    match part.check() {
        Ok(()) => Ok(part),
        Err(fault) => Err(ObjFault::Corners { object, fault }),
    }
}

/// Reader that counts the lines it returns.
struct Lines<'a> {
    rest: &'a [u8],
    line: &'a Cell<usize>,
}

impl Read for Lines<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        self.rest.read(out)
    }
}

impl BufRead for Lines<'_> {
    /// Returns one line at a time, so that the last one returned is the one being parsed.
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        let end = self.rest.iter().position(|byte| *byte == b'\n').map_or(self.rest.len(), |at| at + 1);
        Ok(&self.rest[..end])
    }

    fn consume(&mut self, count: usize) {
        let (taken, rest) = self.rest.split_at(count);
        self.line.set(self.line.get() + usize::from(!taken.is_empty()));
        self.rest = rest;
    }
}

/// Refuses indices that are 0, beyond u32, or negative beyond the first element: the library's arithmetic on them would
/// overflow.
fn check_faces(bytes: &[u8]) -> Result<(), ObjFault> {
    const KINDS: [(&str, ObjElement); 3] =
        [("v", ObjElement::Vertices), ("vt", ObjElement::TextureCoordinates), ("vn", ObjElement::Normals)];
    let mut counts = [0i64; 3];
    for (index, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
        // What is not UTF-8 is refused by the library, with its line.
        let mut words = str::from_utf8(line).unwrap_or_default().split_ascii_whitespace();
        let Some(first) = words.next() else { continue };
        if let Some(kind) = KINDS.iter().position(|(name, _)| *name == first) {
            counts[kind] += 1;
        }
        if !matches!(first, "f" | "l" | "p") {
            continue;
        }
        for (kind, part) in words.flat_map(|word| word.split('/').take(3).enumerate()) {
            let Ok(number) = part.parse::<i128>() else { continue };
            if number == 0 || number < -i128::from(counts[kind]) || number > i128::from(u32::MAX) {
                let (line, of, count) = (index + 1, KINDS[kind].1, counts[kind]);
                return Err(ObjFault::Index { line, index: number, of, count });
            }
        }
    }
    Ok(())
}
