use std::path::Path;

use crate::source::{self, SourceFile};
use crate::{Error, FileKind, exr_file, png_file};

/// Reads the metadata of a file: the string attributes of an EXR file's first part, or the text chunks of a PNG file,
/// in order. Pixels are not decoded.
///
/// For files written by this crate, these are the pairs that [`write_exr`](crate::write_exr),
/// [`write_png8`](crate::write_png8) or [`write_png16`](crate::write_png16) were given. JPEG and TIFF have none.
///
/// # Errors
/// The file cannot be opened, is not a picture, or its header is damaged.
pub fn read_metadata(path: impl AsRef<Path>) -> Result<Vec<(String, String)>, Error> {
    metadata_of(&mut source::open(path.as_ref())?)
}

pub(crate) fn metadata_of(source: &mut SourceFile) -> Result<Vec<(String, String)>, Error> {
    match source.kind()? {
        FileKind::Exr => Ok(exr_file::Header::read(source)?.into_strings()),
        FileKind::Png => png_file::read_text(source),
        FileKind::Jpeg | FileKind::Tiff => Ok(Vec::new()),
    }
}

/// Returns the metadata of [`read_metadata`] as far as they can be read; for a truncated file, those before its end.
pub fn readable_metadata(path: impl AsRef<Path>) -> Vec<(String, String)> {
    let Ok(mut source) = source::open(path.as_ref()) else { return Vec::new() };
    match source.kind() {
        Ok(FileKind::Exr) => exr_file::readable_strings(&mut source),
        Ok(FileKind::Png) => png_file::readable_text(&mut source),
        _ => Vec::new(),
    }
}

/// Checks that a file written by this crate is complete and has nothing after its end, by the position and length of
/// every chunk. Pixels are not decoded.
///
/// # Errors
/// The file cannot be opened, is neither EXR nor PNG, is truncated, or has extra bytes.
pub fn check_whole(path: impl AsRef<Path>) -> Result<(), Error> {
    let mut source = source::open(path.as_ref())?;
    match source.kind()? {
        FileKind::Exr => exr_file::check_whole(&mut source),
        FileKind::Png => png_file::check_whole(&mut source),
        kind => Err(Error::invalid(&source.path, "first bytes", format!("a {kind} file"), "an EXR or PNG file")),
    }
}
