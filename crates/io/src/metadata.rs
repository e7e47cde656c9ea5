use std::io::{BufRead, Seek};
use std::path::Path;

use crate::source::{self, Source};
use crate::{Error, FileKind, exr_file, png_file};

/// Reads a file's metadata: the string attributes of an EXR file's first part, or the text chunks of a PNG file, in
/// order. Pixels are not decoded.
///
/// For a file of this crate these are the pairs that [`write_exr`](crate::write_exr),
/// [`write_png8`](crate::write_png8) or [`write_png16`](crate::write_png16) were given. JPEG and TIFF have none.
///
/// # Errors
/// The file cannot be opened, is not a picture, or its header is damaged.
pub fn read_metadata(path: impl AsRef<Path>) -> Result<Vec<(String, String)>, Error> {
    metadata_of(&mut source::open(path.as_ref())?)
}

pub(crate) fn metadata_of<R: BufRead + Seek>(source: &mut Source<R>) -> Result<Vec<(String, String)>, Error> {
    match source.kind()? {
        FileKind::Exr => Ok(exr_file::Header::read(source)?.into_strings()),
        FileKind::Png => png_file::read_text(source),
        FileKind::Jpeg | FileKind::Tiff => Ok(Vec::new()),
    }
}
