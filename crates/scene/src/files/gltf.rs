//! glTF 2.0 in a single file: `.glb`, or `.gltf` with embedded buffers. Parsed by the crate `gltf`.

use super::{AccessorFault, BufferFault, GltfFault, PartFault};
use crate::{DVec3, MAX_TRIANGLES, Triangles};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use gltf::accessor::{DataType, Dimensions};
use gltf::json::Root;
use gltf::json::validation::Checked;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic};
use std::borrow::Cow;

/// Length of the headers of a GLB and of its first chunk.
const GLB_HEADERS: usize = 20;

/// Reads the triangles of all meshes in the default scene, transformed by their nodes. Points and lines are left out;
/// morph targets, skins and animations are ignored.
pub(super) fn parts(bytes: &[u8]) -> Result<Vec<Triangles>, GltfFault> {
    if bytes.starts_with(b"glTF") {
        let length = bytes.get(8..12).and_then(|bytes| bytes.try_into().ok()).map_or(0, u32::from_le_bytes) as usize;
        if length < GLB_HEADERS || length > bytes.len() {
            return Err(GltfFault::Length { found: bytes.len(), length });
        }
    }
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(GltfFault::Unreadable)?;
    let json = document.into_json();
    check_positions(&json)?;
    let document = Document::from_json(json).map_err(GltfFault::Invalid)?;
    let buffers = buffers(&document, blob.as_deref())?;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or(GltfFault::NoScene)?;
    let mut reader = Reader { buffers, seen: vec![false; document.nodes().count()], parts: Vec::new(), vertices: 0 };
    // Each node with what its parents do to it.
    let mut open: Vec<(Node<'_>, Transform)> = scene.nodes().map(|node| (node, IDENTITY)).collect();
    open.reverse();
    while let Some((node, parent)) = open.pop() {
        if std::mem::replace(&mut reader.seen[node.index()], true) {
            return Err(GltfFault::NoTree(node.index()));
        }
        let transform = times(&parent, &node.transform().matrix().map(|column| column.map(f64::from)));
        for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives()) {
            let (node, index) = (node.index(), primitive.index());
            reader.add(&primitive, &transform).map_err(|fault| GltfFault::Primitive {
                node,
                primitive: index,
                fault,
            })?;
        }
        let children: Vec<_> = node.children().collect();
        open.extend(children.into_iter().rev().map(|child| (child, transform)));
    }
    Ok(reader.parts)
}

/// Refuses positions without an existing accessor: the library's validation panics on them.
fn check_positions(json: &Root) -> Result<(), GltfFault> {
    let positions = Checked::Valid(Semantic::Positions);
    for (mesh, found) in json.meshes.iter().enumerate() {
        let accessors = found.primitives.iter().filter_map(|primitive| primitive.attributes.get(&positions));
        let count = json.accessors.len();
        if let Some(accessor) = accessors.map(|accessor| accessor.value()).find(|accessor| *accessor >= count) {
            return Err(GltfFault::Positions { mesh, accessor, count });
        }
    }
    Ok(())
}

/// Columns of an affine transformation.
type Transform = [[f64; 4]; 4];

const IDENTITY: Transform = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

fn times(a: &Transform, b: &Transform) -> Transform {
    b.map(|column| std::array::from_fn(|row| (0..4).map(|i| a[i][row] * column[i]).sum()))
}

/// Returns the bytes of every buffer.
fn buffers<'b>(document: &Document, blob: Option<&'b [u8]>) -> Result<Vec<Cow<'b, [u8]>>, GltfFault> {
    let bytes = |buffer: gltf::Buffer<'_>| -> Result<Cow<'b, [u8]>, BufferFault> {
        let uri = match buffer.source() {
            gltf::buffer::Source::Bin => return blob.map(Cow::Borrowed).ok_or(BufferFault::NoChunk),
            gltf::buffer::Source::Uri(uri) => uri,
        };
        let data = uri.strip_prefix("data:").and_then(|data| data.split_once(";base64,"));
        let Some((_, data)) = data else {
            let start: String = uri.chars().take(40).collect();
            return Err(BufferFault::Elsewhere(start));
        };
        BASE64_STANDARD.decode(data).map(Cow::Owned).map_err(BufferFault::Encoding)
    };
    document
        .buffers()
        .map(|buffer| bytes(buffer.clone()).map_err(|fault| GltfFault::Buffer { buffer: buffer.index(), fault }))
        .collect()
}

struct Reader<'b> {
    buffers: Vec<Cow<'b, [u8]>>,
    /// Whether each node has been visited.
    seen: Vec<bool>,
    parts: Vec<Triangles>,
    /// Number of vertices so far.
    vertices: usize,
}

impl Reader<'_> {
    /// Appends the triangles of a primitive.
    fn add(&mut self, primitive: &Primitive<'_>, transform: &Transform) -> Result<(), PartFault> {
        if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            return Ok(());
        }
        let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(()) };
        self.vertices = self.vertices.saturating_add(positions.count());
        if self.vertices > MAX_TRIANGLES {
            return Err(PartFault::TooMany(self.vertices));
        }
        let count = positions.count();
        let floats = |semantic: Semantic, width: usize| match primitive.get(&semantic) {
            None => Ok(Vec::new()),
            Some(accessor) => {
                let at = |fault| PartFault::Array { array: semantic.to_string(), fault };
                if accessor.count() != count {
                    return Err(at(AccessorFault::Count { found: accessor.count(), positions: count }));
                }
                self.numbers(&accessor, width).map_err(at)
            }
        };
        let [a, b, c, origin] = transform.map(|column| DVec3::new(column[0], column[1], column[2]));
        let vectors = |values: Vec<f64>, map: &dyn Fn(DVec3) -> DVec3| {
            values.chunks_exact(3).map(|vector| map(DVec3::from_slice(vector))).collect()
        };
        // Normals go by the cofactors, which are the inverse transpose but for a positive factor and the mirroring.
        let cofactors = [b.cross(c), c.cross(a), a.cross(b)];
        let mirrored = a.dot(b.cross(c)) < 0.0;
        let side = if mirrored { -1.0 } else { 1.0 };
        let indices = match primitive.indices() {
            Some(accessor) => {
                self.indices(&accessor).map_err(|fault| PartFault::Array { array: "indices".into(), fault })?
            }
            None => (0..count as u32).collect(),
        };
        let part = Triangles {
            positions: vectors(floats(Semantic::Positions, 3)?, &|p| a * p.x + b * p.y + c * p.z + origin),
            normals: vectors(floats(Semantic::Normals, 3)?, &|n| {
                side * (cofactors[0] * n.x + cofactors[1] * n.y + cofactors[2] * n.z)
            }),
            // v falls in glTF.
            uvs: floats(Semantic::TexCoords(0), 2)?.chunks_exact(2).map(|uv| [uv[0], 1.0 - uv[1]]).collect(),
            triangles: triangles(primitive.mode(), &indices, mirrored),
        };
        part.check()?;
        self.parts.push(part);
        Ok(())
    }

    /// Returns an accessor's vectors of `width` components, one after another.
    fn numbers(&self, accessor: &Accessor<'_>, width: usize) -> Result<Vec<f64>, AccessorFault> {
        let ty = accessor.data_type();
        let scale = match ty {
            DataType::F32 => 1.0,
            DataType::U8 if accessor.normalized() => 255.0,
            DataType::U16 if accessor.normalized() => 65535.0,
            _ => return Err(AccessorFault::Number(ty)),
        };
        let number = |bytes: &[u8]| match *bytes {
            [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
            [a, b] => f64::from(u16::from_le_bytes([a, b])) / scale,
            [a] => f64::from(a) / scale,
            _ => 0.0,
        };
        let size = ty.size();
        let elements = self.elements(accessor, width)?;
        Ok(elements.flat_map(|element| element.chunks_exact(size)).map(number).collect())
    }

    fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>, AccessorFault> {
        if accessor.count() > 3 * MAX_TRIANGLES {
            return Err(AccessorFault::TooMany { found: accessor.count() });
        }
        let ty = accessor.data_type();
        if !matches!(ty, DataType::U8 | DataType::U16 | DataType::U32) {
            return Err(AccessorFault::Index(ty));
        }
        let index = |bytes: &[u8]| bytes.iter().rev().fold(0, |index, byte| index << 8 | u32::from(*byte));
        Ok(self.elements(accessor, 1)?.map(index).collect())
    }

    /// Returns the bytes of each element of an accessor, after checking that its buffer has them all.
    fn elements<'r>(
        &'r self,
        accessor: &Accessor<'_>,
        width: usize,
    ) -> Result<impl Iterator<Item = &'r [u8]> + use<'r>, AccessorFault> {
        let (found, expected) =
            (accessor.dimensions(), [Dimensions::Scalar, Dimensions::Vec2, Dimensions::Vec3][width - 1]);
        if found != expected {
            return Err(AccessorFault::Dimensions { found, expected });
        }
        if accessor.sparse().is_some() {
            return Err(AccessorFault::Sparse);
        }
        let view = accessor.view().ok_or(AccessorFault::NoView)?;
        let (size, count) = (width * accessor.data_type().size(), accessor.count());
        let stride = view.stride().unwrap_or(size);
        let beyond = || AccessorFault::Beyond { count, view: view.index(), buffer: view.buffer().index() };
        let buffer = self.buffers.get(view.buffer().index()).ok_or_else(beyond)?;
        let end = view.offset().checked_add(view.length());
        let bytes = end.and_then(|end| buffer.get(view.offset()..end)).ok_or_else(beyond)?;
        let bytes = bytes.get(accessor.offset()..).ok_or_else(beyond)?;
        let needed = count.checked_sub(1).and_then(|last| last.checked_mul(stride)?.checked_add(size));
        if stride < size || count > 0 && needed.is_none_or(|needed| needed > bytes.len()) {
            return Err(beyond());
        }
        Ok((0..count).map(move |index| &bytes[index * stride..][..size]))
    }
}

/// Returns the corners by drawing mode. Every other triangle of a strip is turned around, and every triangle of a
/// mirrored mesh.
fn triangles(mode: Mode, indices: &[u32], mirrored: bool) -> Vec<[u32; 3]> {
    let turned = |[a, b, c]: [u32; 3], turn: bool| if turn != mirrored { [a, c, b] } else { [a, b, c] };
    match mode {
        Mode::TriangleStrip => {
            let triples = indices.windows(3).enumerate();
            triples.map(|(index, t)| turned([t[0], t[1], t[2]], index % 2 == 1)).collect()
        }
        Mode::TriangleFan => {
            let Some((first, rest)) = indices.split_first() else { return Vec::new() };
            rest.windows(2).map(|pair| turned([*first, pair[0], pair[1]], false)).collect()
        }
        _ => indices.as_chunks().0.iter().map(|corners| turned(*corners, false)).collect(),
    }
}
