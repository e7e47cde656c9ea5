//! What is wrong with files of surfaces: the place, what was found, what was expected, and what to do.

use super::obj::{MOST, explained};
use super::patches::FARTHEST;
use crate::bezier::{MAX_PATCHES, RailsError};
use crate::{MAX_TRIANGLES, TrianglesError};
use gltf::accessor::{DataType, Dimensions};
use thiserror::Error;

/// Why bytes are no mesh.
#[derive(Debug, Error)]
pub enum MeshFault {
    /// They are neither text nor a GLB.
    #[error("found a binary file that is no GLB; expected a mesh: .obj, .glb and .gltf are read")]
    Binary,
    /// They are a Wavefront OBJ with a fault, or text of another kind.
    #[error(transparent)]
    Obj(#[from] ObjFault),
    /// They are a glTF with a fault, or JSON of another kind.
    #[error(transparent)]
    Gltf(#[from] GltfFault),
    /// So many triangles or vertices.
    #[error("found {0} triangles or vertices; expected at most {MAX_TRIANGLES}: reduce the mesh")]
    TooMany(usize),
    /// A part, or all of them, whose arrays do not fit each other.
    #[error(transparent)]
    Triangles(#[from] TrianglesError),
    /// A mesh of nothing that is seen.
    #[error("found no triangle; expected a mesh, .obj, .glb or .gltf: export its faces too, or name another file")]
    Empty,
}

/// What indices of faces count in a Wavefront OBJ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Indexed {
    /// Lines of v.
    Vertices,
    /// Lines of vt.
    TextureCoordinates,
    /// Lines of vn.
    Normals,
}

impl std::fmt::Display for Indexed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Vertices => "vertices",
            Self::TextureCoordinates => "texture coordinates",
            Self::Normals => "normals",
        })
    }
}

/// Why bytes are no Wavefront OBJ.
#[derive(Debug, Error)]
pub enum ObjFault {
    /// A line that cannot be read.
    #[error("line {line}: {}", explained(.fault))]
    Line {
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        fault: tobj::LoadError,
    },
    /// An index that points nowhere.
    #[error(
        "line {line}: found the index {index} after {count} {of}; expected 1 to their number, or -1 to -{count} to count \
         back: correct it"
    )]
    Index {
        /// The line, from 1.
        line: usize,
        /// The index.
        index: i128,
        /// What it counts.
        of: Indexed,
        /// How many of those come before.
        count: i64,
    },
    /// A coordinate that is not finite, or too far away.
    #[error(
        "object {object}: found the coordinate {found:?} of a vertex; expected finite numbers up to {MOST:e}: correct it, \
         or export the file again"
    )]
    Coordinate {
        /// Its object's name.
        object: String,
        /// The coordinate.
        found: f64,
    },
    /// Corners of one object that have unlike parts.
    #[error("object {object}: {fault}: give all corners of an object the same parts, such as 1/1/1")]
    Corners {
        /// The object's name.
        object: String,
        /// What follows from that.
        fault: TrianglesError,
    },
}

/// Why bytes are no glTF 2.0 whose meshes can be taken.
#[derive(Debug, Error)]
pub enum GltfFault {
    /// A GLB whose bytes are not those that it says it has.
    #[error("found {found} bytes of a GLB that says it has {length}; expected the whole file: copy it again")]
    Length {
        /// How many there are.
        found: usize,
        /// How many it says.
        length: usize,
    },
    /// What cannot be read as glTF.
    #[error("found JSON or a GLB that is no glTF ({0}); expected glTF 2.0: export the mesh again, as .glb or .obj")]
    Unreadable(gltf::Error),
    /// A glTF that breaks its own rules.
    #[error("found a glTF with a fault ({0}); expected a valid one: export the mesh again")]
    Invalid(gltf::Error),
    /// Positions of which there is no accessor.
    #[error("mesh {mesh}: found accessor {accessor} for POSITION, but there are {count}")]
    Positions {
        /// The mesh.
        mesh: usize,
        /// The accessor that it names.
        accessor: usize,
        /// How many there are.
        count: usize,
    },
    /// A glTF without a scene.
    #[error("found no scene; expected one, with nodes that show meshes: export the whole scene")]
    NoScene,
    /// A node that is no node of a tree.
    #[error("node {0}: found it below two nodes, or below itself; expected a tree")]
    NoTree(usize),
    /// A buffer without its bytes.
    #[error("buffer {buffer}: {fault}")]
    Buffer {
        /// The buffer.
        buffer: usize,
        /// Why it has none.
        fault: BufferFault,
    },
    /// A primitive that makes no triangles.
    #[error("node {node}, primitive {primitive}: {fault}")]
    Primitive {
        /// The node that shows it.
        node: usize,
        /// The primitive within the node's mesh.
        primitive: usize,
        /// Why it makes none.
        fault: PartFault,
    },
}

/// Why a buffer of a glTF has no bytes.
#[derive(Debug, Error)]
pub enum BufferFault {
    /// It is that of a GLB, in JSON alone.
    #[error("found no binary chunk")]
    NoChunk,
    /// They lie elsewhere: where that begins.
    #[error(
        "found its bytes in another file, \"{0}\"; expected them in this one: export as .glb, or with buffers embedded"
    )]
    Elsewhere(String),
    /// What is embedded is not encoded as it says.
    #[error("found no base64: {0}")]
    Encoding(base64::DecodeError),
}

/// Why a primitive of a glTF makes no triangles.
#[derive(Debug, Error)]
pub enum PartFault {
    /// So many vertices, with those of all primitives before.
    #[error("found {0} vertices; expected at most {MAX_TRIANGLES}: reduce the mesh")]
    TooMany(usize),
    /// An array that cannot be read.
    #[error("{array}: {fault}")]
    Array {
        /// Its semantic, or "indices".
        array: String,
        /// Why it cannot.
        fault: AccessorFault,
    },
    /// Arrays that do not fit each other.
    #[error(transparent)]
    Triangles(#[from] TrianglesError),
}

/// Why an accessor of a glTF gives no numbers.
#[derive(Debug, Error)]
pub enum AccessorFault {
    /// It has not as many elements as there are positions.
    #[error("found {found} for {positions} positions; expected as many")]
    Count {
        /// How many it has.
        found: usize,
        /// How many positions there are.
        positions: usize,
    },
    /// More indices than are taken.
    #[error("found {found}; expected at most {}: reduce the mesh", 3 * MAX_TRIANGLES)]
    TooMany {
        /// How many it has.
        found: usize,
    },
    /// Numbers of a type that is no coordinate's.
    #[error("found components of type {0:?}; expected floats, or normalized bytes or shorts")]
    Number(DataType),
    /// Numbers of a type that is no index's.
    #[error("found components of type {0:?}; expected unsigned bytes, shorts or ints")]
    Index(DataType),
    /// Vectors of another length.
    #[error("found {found:?}; expected {expected:?}")]
    Dimensions {
        /// Which it has.
        found: Dimensions,
        /// Which it should have.
        expected: Dimensions,
    },
    /// Only what differs from something else.
    #[error("found a sparse accessor; expected a plain one: export without sparse data")]
    Sparse,
    /// No place where its bytes lie.
    #[error("found no bufferView; expected one with its bytes")]
    NoView,
    /// More elements than there are bytes for.
    #[error("found {count} elements that reach beyond bufferView {view} or buffer {buffer}")]
    Beyond {
        /// How many.
        count: usize,
        /// Where their bytes should lie.
        view: usize,
        /// Where those lie.
        buffer: usize,
    },
}

/// Why bytes are no model of patches.
#[derive(Debug, Error)]
pub enum PatchesFault {
    /// They are no JSON.
    #[error(
        "found a file that is no JSON ({0}); expected a model of patches, JSON with \"trochoid_model\": 1: name one, or \
         correct it there"
    )]
    NoJson(serde_json::Error),
    /// They are JSON of another kind.
    #[error("found {0}; expected a model of patches: correct the file there")]
    NoModel(serde_json::Error),
    /// They are of this version of the format.
    #[error("found \"trochoid_model\": {0}; expected 1")]
    Version(u32),
    /// A point that is not finite, or too far away.
    #[error("{at}: found {found:?}; expected coordinates within ±{FARTHEST:e}")]
    Point {
        /// Where it is written.
        at: Place,
        /// Its coordinates.
        found: [f64; 3],
    },
    /// A patch of a point that there is not.
    #[error("patch {patch}: names point {point}, but there are {count}")]
    NoPoint {
        /// The patch.
        patch: usize,
        /// The point that it names.
        point: u32,
        /// How many there are.
        count: usize,
    },
    /// A patch of another number of points.
    #[error("patch {patch}: found {found} points; expected 4 (bilinear) or 16 (bicubic)")]
    Points {
        /// The patch.
        patch: usize,
        /// How many it has.
        found: usize,
    },
    /// Rails through which no surface passes.
    #[error("sheet {sheet}: {fault}")]
    Sheet {
        /// The sheet that they are of.
        sheet: usize,
        /// Why none does.
        fault: RailsError,
    },
    /// So many patches.
    #[error("found {0} patches; expected 1 to {MAX_PATCHES}")]
    Count(usize),
}

/// Where a point of a model of patches is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Among its points.
    Points(usize),
    /// On a rail of a sheet.
    Rail {
        /// The sheet.
        sheet: usize,
        /// The rail.
        rail: usize,
        /// The point of the rail.
        point: usize,
    },
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Points(point) => write!(f, "point {point}"),
            Self::Rail { sheet, rail, point } => write!(f, "sheet {sheet}, rail {rail}, point {point}"),
        }
    }
}
