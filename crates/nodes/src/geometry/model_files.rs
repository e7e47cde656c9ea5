//! Reads files of surfaces within limits, and adds their paths to errors.

use std::error::Error;
use std::fmt::{Debug, Display};
use std::path::{Path, PathBuf};
use thiserror::Error;
use trochoid_graph::NodeError;
use trochoid_scene::Triangles;
use trochoid_scene::bezier::Patch;
use trochoid_scene::files;

/// Maximum memory of a decoded mesh per byte of its file: an index of two digits becomes three of 8 bytes, and a corner
/// of a triangle.
const BYTES_PER_BYTE: u64 = 32;
/// Maximum size of a model file in bytes, and of a mesh that checking a document decodes.
const MAX_FILE_BYTES: u64 = 8 << 20;

/// Reads the mesh of a file, in the file's own coordinates. The first bytes determine the format.
///
/// # Errors
/// The file cannot be read, is too large for `memory` bytes, or is not a valid mesh. The error names the line, node or
/// array.
pub(crate) fn read_mesh(path: &Path, memory: u64) -> Result<Triangles, NodeError> {
    read(path, memory / BYTES_PER_BYTE, files::mesh)
}

/// Checks a mesh's file: the whole mesh if decoding takes a moment, otherwise only that it is a file.
///
/// # Errors
/// As [`read_mesh`].
pub(crate) fn check_mesh(path: &Path) -> Result<(), NodeError> {
    if trochoid_io::open_file(path)?.length <= MAX_FILE_BYTES {
        read(path, MAX_FILE_BYTES, files::mesh)?;
    }
    Ok(())
}

/// Reads the patches of a model file.
///
/// # Errors
/// The file cannot be read, is too large, or is not a valid model. The error names the line and column, or the patch and
/// point.
pub(crate) fn read_model(path: &Path) -> Result<Vec<Patch>, NodeError> {
    read(path, MAX_FILE_BYTES, files::patches)
}

/// Error in a file.
#[derive(Debug, Error)]
#[error("{}: {fault}", path.display())]
struct OfFile<E: Debug + Display> {
    path: PathBuf,
    fault: E,
}

fn read<T, E: Error + Send + Sync + 'static>(
    path: &Path,
    most: u64,
    decode: fn(&[u8]) -> Result<T, E>,
) -> Result<T, NodeError> {
    let bytes = trochoid_io::read_bytes(path, most)?;
    Ok(decode(&bytes).map_err(|fault| OfFile { path: path.into(), fault })?)
}
