//! Errors of surface files, as data and in words: place, what was found, what was expected, and what to do.

use crate::bezier::{MAX_PATCHES, RailsError};
use crate::{MAX_TRIANGLES, TrianglesError};
use gltf::accessor::{DataType, Dimensions};
use thiserror::Error;
use tobj::LoadError;

/// Largest coordinate of a mesh, in absolute value: beyond it, a scene could not tell neighboring vertices apart.
pub(super) const MAX_COORDINATE: f64 = 1e15;
/// Largest coordinate of a model of patches, in absolute value.
pub(super) const MAX_PATCH_COORDINATE: f64 = 1e9;

/// Error in the bytes of a mesh file.
#[derive(Debug, Error)]
pub enum MeshFault {
    /// The bytes are neither text nor a GLB.
    #[error("found a binary file that is not a GLB; expected a mesh: .obj, .glb and .gltf are read")]
    Binary,
    /// Invalid Wavefront OBJ, or text of another kind.
    #[error(transparent)]
    Obj(#[from] ObjFault),
    /// Invalid glTF, or JSON of another kind.
    #[error(transparent)]
    Gltf(#[from] GltfFault),
    /// Too many triangles or vertices.
    #[error("found {0} triangles or vertices; expected at most {MAX_TRIANGLES}: reduce the mesh")]
    TooMany(usize),
    /// Arrays that do not fit each other, in a part or in the whole mesh.
    #[error(transparent)]
    Triangles(#[from] TrianglesError),
    /// A mesh without triangles.
    #[error("found no triangle; expected a mesh, .obj, .glb or .gltf: export its faces too, or name another file")]
    Empty,
}

/// Elements that the faces of a Wavefront OBJ refer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjElement {
    /// Positions, lines of `v`.
    Vertices,
    /// Texture coordinates, lines of `vt`.
    TextureCoordinates,
    /// Normals, lines of `vn`.
    Normals,
}

impl std::fmt::Display for ObjElement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Vertices => "vertices",
            Self::TextureCoordinates => "texture coordinates",
            Self::Normals => "normals",
        })
    }
}

/// Error in a Wavefront OBJ.
#[derive(Debug, Error)]
pub enum ObjFault {
    /// A line that cannot be parsed.
    #[error("line {line}: {}", explained(.fault))]
    Line {
        /// Line, from 1.
        line: usize,
        /// Reason.
        fault: LoadError,
    },
    /// An index of an element that does not exist.
    #[error(
        "line {line}: found the index {index} after {count} {of}; expected 1 to their number, or -1 to -{count} to count \
         back: correct it"
    )]
    Index {
        /// Line, from 1.
        line: usize,
        /// Index.
        index: i128,
        /// Kind of element.
        of: ObjElement,
        /// Number of such elements up to there.
        count: i64,
    },
    /// A coordinate that is not finite, or too large.
    #[error(
        "object {object}: found the coordinate {found:?} of a vertex; expected finite numbers up to {MAX_COORDINATE:e}: correct it, \
         or export the file again"
    )]
    Coordinate {
        /// Name of its object.
        object: String,
        /// Coordinate.
        found: f64,
    },
    /// Corners of one object that differ in whether they have texture coordinates or normals.
    #[error("object {object}: {fault}: give all corners of an object the same parts, such as 1/1/1")]
    Corners {
        /// Name of the object.
        object: String,
        /// Mismatch between its arrays.
        fault: TrianglesError,
    },
}

/// Error in a glTF 2.0 file.
#[derive(Debug, Error)]
pub enum GltfFault {
    /// A GLB whose length differs from the one in its header.
    #[error("found {found} bytes of a GLB that says it has {length}; expected the whole file: copy it again")]
    Length {
        /// Actual number.
        found: usize,
        /// Number in the header.
        length: usize,
    },
    /// Bytes that cannot be parsed as glTF.
    #[error("found JSON or a GLB that is no glTF ({0}); expected glTF 2.0: export the mesh again, as .glb or .obj")]
    Unreadable(gltf::Error),
    /// A violation of the glTF specification.
    #[error("found a glTF with a fault ({0}); expected a valid one: export the mesh again")]
    Invalid(gltf::Error),
    /// Positions whose accessor does not exist.
    #[error("mesh {mesh}: found accessor {accessor} for POSITION, but there are {count}")]
    Positions {
        /// Mesh.
        mesh: usize,
        /// Accessor that the mesh names.
        accessor: usize,
        /// Actual number.
        count: usize,
    },
    /// A glTF without a scene.
    #[error("found no scene; expected one, with nodes that show meshes: export the whole scene")]
    NoScene,
    /// A node that is reached twice, so that the nodes are not a tree.
    #[error("node {0}: found it below two nodes, or below itself; expected a tree")]
    NoTree(usize),
    /// A buffer without bytes.
    #[error("buffer {buffer}: {fault}")]
    Buffer {
        /// Buffer.
        buffer: usize,
        /// Reason.
        fault: BufferFault,
    },
    /// A primitive that cannot be read as triangles.
    #[error("node {node}, primitive {primitive}: {fault}")]
    Primitive {
        /// Node that shows the mesh.
        node: usize,
        /// Primitive within the mesh.
        primitive: usize,
        /// Reason.
        fault: PartFault,
    },
}

/// Reason why a glTF buffer has no bytes.
#[derive(Debug, Error)]
pub enum BufferFault {
    /// The buffer is that of a GLB, but the file is only JSON.
    #[error("found no binary chunk")]
    NoChunk,
    /// The bytes are in another file; the start of its address.
    #[error(
        "found its bytes in another file, \"{0}\"; expected them in this one: export as .glb, or with buffers embedded"
    )]
    Elsewhere(String),
    /// Embedded bytes that are not valid base64.
    #[error("found no base64: {0}")]
    Encoding(base64::DecodeError),
}

/// Reason why a glTF primitive cannot be read as triangles.
#[derive(Debug, Error)]
pub enum PartFault {
    /// Too many vertices, counting those of all primitives before.
    #[error("found {0} vertices; expected at most {MAX_TRIANGLES}: reduce the mesh")]
    TooMany(usize),
    /// An array that cannot be read.
    #[error("{array}: {fault}")]
    Array {
        /// Its semantic, or "indices".
        array: String,
        /// Reason.
        fault: AccessorFault,
    },
    /// Arrays that do not fit each other.
    #[error(transparent)]
    Triangles(#[from] TrianglesError),
}

/// Reason why a glTF accessor cannot be read.
#[derive(Debug, Error)]
pub enum AccessorFault {
    /// A number of elements that differs from the number of positions.
    #[error("found {found} for {positions} positions; expected as many")]
    Count {
        /// Actual number.
        found: usize,
        /// Number of positions.
        positions: usize,
    },
    /// Too many indices.
    #[error("found {found}; expected at most {}: reduce the mesh", 3 * MAX_TRIANGLES)]
    TooMany {
        /// Actual number.
        found: usize,
    },
    /// A component type not allowed for coordinates.
    #[error("found components of type {0:?}; expected floats, or normalized bytes or shorts")]
    Number(DataType),
    /// A component type not allowed for indices.
    #[error("found components of type {0:?}; expected unsigned bytes, shorts or ints")]
    Index(DataType),
    /// Vectors of a wrong length.
    #[error("found {found:?}; expected {expected:?}")]
    Dimensions {
        /// Actual length.
        found: Dimensions,
        /// Expected length.
        expected: Dimensions,
    },
    /// A sparse accessor, which is not supported.
    #[error("found a sparse accessor; expected a plain one: export without sparse data")]
    Sparse,
    /// An accessor without a buffer view.
    #[error("found no bufferView; expected one with its bytes")]
    NoView,
    /// More elements than its buffer has bytes for.
    #[error("found {count} elements that reach beyond bufferView {view} or buffer {buffer}")]
    Beyond {
        /// Number of elements.
        count: usize,
        /// Range of bytes needed.
        view: usize,
        /// Range of bytes available.
        buffer: usize,
    },
}

/// Error in a model of patches.
#[derive(Debug, Error)]
pub enum PatchesFault {
    /// Bytes that are not JSON.
    #[error(
        "found a file that is not JSON ({0}); expected a model of patches, JSON with \"trochoid_model\": 1: name one, or \
         correct it there"
    )]
    NoJson(serde_json::Error),
    /// JSON of another kind.
    #[error("found {0}; expected a model of patches: correct the file there")]
    NoModel(serde_json::Error),
    /// An unknown version of the format.
    #[error("found \"trochoid_model\": {0}; expected 1")]
    Version(u32),
    /// JSON that does not say that it is a model.
    #[error(
        "found no \"trochoid_model\"; expected \"trochoid_model\": 1: add it if the file is a model of patches, or name \
         another file"
    )]
    NoVersion,
    /// A point that is not finite, or too large.
    #[error("{at}: found {found:?}; expected coordinates within ±{MAX_PATCH_COORDINATE:e}")]
    Point {
        /// Place of the point in the file.
        at: PointPlace,
        /// Coordinates.
        found: [f64; 3],
    },
    /// A patch with a point that does not exist.
    #[error("patch {patch}: names point {point}, but there are {count}")]
    NoPoint {
        /// Patch.
        patch: usize,
        /// Number of the point.
        point: u32,
        /// Actual number.
        count: usize,
    },
    /// A patch with a wrong number of points.
    #[error("patch {patch}: found {found} points; expected 4 (bilinear) or 16 (bicubic)")]
    Points {
        /// Patch.
        patch: usize,
        /// Actual number.
        found: usize,
    },
    /// Rails that no surface can pass through.
    #[error("sheet {sheet}: {fault}")]
    Sheet {
        /// Sheet of the rails.
        sheet: usize,
        /// Reason.
        fault: RailsError,
    },
    /// Too many patches.
    #[error("found {0} patches; expected 1 to {MAX_PATCHES}")]
    Count(usize),
}

/// Place of a point in a model of patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointPlace {
    /// In the list of points, by number.
    Points(usize),
    /// On a rail of a sheet.
    Rail {
        /// Sheet.
        sheet: usize,
        /// Rail.
        rail: usize,
        /// Point of the rail.
        point: usize,
    },
}

impl std::fmt::Display for PointPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Points(point) => write!(f, "point {point}"),
            Self::Rail { sheet, rail, point } => write!(f, "sheet {sheet}, rail {rail}, point {point}"),
        }
    }
}

/// Translates an error of the library: what was expected, and what to do.
fn explained(error: &LoadError) -> String {
    let (expected, remedy) = match error {
        LoadError::PositionParseError => ("v and three numbers", "correct the line"),
        LoadError::NormalParseError => ("vn and three numbers", "correct the line"),
        LoadError::TexcoordParseError => ("vt and two numbers", "correct the line"),
        LoadError::FaceParseError => ("f and corners such as 1, 1/1, 1//1 or 1/1/1", "correct the line"),
        LoadError::FaceVertexOutOfBounds => ("corners of vertices that come before the face", "correct the index"),
        LoadError::FaceTexCoordOutOfBounds => ("corners of texture coordinates before the face", "correct the index"),
        LoadError::FaceNormalOutOfBounds => ("corners of normals that come before the face", "correct the index"),
        LoadError::ReadError => ("text in UTF-8", "is it a mesh? Read are .obj, .glb and .gltf"),
        _ => ("a Wavefront OBJ", "export the mesh again, as .obj or .glb"),
    };
    format!("found a {error}; expected {expected}: {remedy}")
}
