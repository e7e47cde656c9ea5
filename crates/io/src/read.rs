//! Reading of any kind of image file: its kind, its header, its pixels.

use std::path::Path;

use crate::exr_file::{self, ExrReader};
use crate::source::{self, SourceFile};
use crate::{Error, FileKind, Info, Limits, Picture, PictureInfo, Selection, raster};

/// Returns the kind of an image file by its first bytes, whatever its name.
///
/// # Errors
/// The file cannot be opened, or is not a picture.
pub fn kind(path: impl AsRef<Path>) -> Result<FileKind, Error> {
    source::open(path.as_ref())?.kind()
}

/// Reads a file's header, without decoding pixels.
///
/// Parts that cannot be decoded (deep, HTJ2K) are described, too.
///
/// # Errors
/// The file cannot be opened, is not a picture, its header is damaged, or a window exceeds the limits.
pub fn info(path: impl AsRef<Path>, limits: &Limits) -> Result<Info, Error> {
    info_of(&mut source::open(path.as_ref())?, limits)
}

pub(crate) fn info_of(source: &mut SourceFile, limits: &Limits) -> Result<Info, Error> {
    let kind = source.kind()?;
    let parts = match kind {
        FileKind::Exr => exr_file::Header::read(source)?.into_parts(),
        _ => vec![raster::info(source, kind)?.0],
    };
    for (index, part) in parts.iter().enumerate() {
        part.check_windows(&source.path, index, limits)?;
    }
    Ok(Info { kind, parts })
}

/// Decodes a selection; other parts are not decoded.
///
/// # Errors
/// The file cannot be opened, is not a picture, is damaged, is not supported, lacks what is selected, or exceeds the
/// limits.
pub fn read(path: impl AsRef<Path>, selection: &Selection, limits: &Limits) -> Result<Picture, Error> {
    read_of(source::open(path.as_ref())?, selection, limits)
}

pub(crate) fn read_of(mut source: SourceFile, selection: &Selection, limits: &Limits) -> Result<Picture, Error> {
    match source.kind()? {
        FileKind::Exr => ExrReader::of(source, selection, limits)?.picture(),
        kind => {
            let (info, form) = raster::info(&mut source, kind)?;
            let found = selection.resolve(&source.path, std::slice::from_ref(&info))?;
            let planes = raster::read_planes(&mut source, kind, &info, &form, &found.channels, limits)?;
            Ok(PictureInfo::new(&info, found.part, &found.channels).with_planes(planes))
        }
    }
}
