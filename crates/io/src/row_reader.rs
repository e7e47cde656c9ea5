use std::path::Path;

use crate::raster::{self, Form, TakeRow};
use crate::source::{self, SourceFile};
use crate::{Error, FileKind, Limits, PictureInfo, Selection};

/// PNG, JPEG or TIFF file opened for reading row by row, from the top down.
///
/// Memory is held for the rows that are decoded together: one row of most PNGs, a row of strips or tiles of a TIFF.
/// Interlaced PNGs, JPEGs and rotated pictures are first decoded as a whole, to their stored bytes.
///
/// ```
/// use std::ops::ControlFlow;
/// use trochoid_io::{Limits, PngImage, RowReader, Samples, Selection, write_png8};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("swatch.png");
/// write_png8(&path, &PngImage::new(1, 2, Samples::rgb(&[[1.0, 0.0, 0.2], [0.0, 0.4, 1.0]])))?;
/// let mut reader = RowReader::open(&path, &Selection::channels(["B"]), &Limits::default())?;
/// let mut blue = Vec::new();
/// reader.rows(&mut |_, channels| {
///     blue.extend_from_slice(&channels[0]);
///     ControlFlow::Continue(())
/// })?;
/// assert_eq!(blue, [0.2, 1.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct RowReader {
    source: SourceFile,
    kind: FileKind,
    form: Form,
    info: PictureInfo,
    channels: Vec<usize>,
    limits: Limits,
}

impl RowReader {
    /// Opens a file and reads its header, but no pixels.
    ///
    /// # Errors
    /// The file cannot be opened, is not a PNG, JPEG or TIFF, is damaged, is not supported, lacks what is selected, or
    /// exceeds the limits, where [`Limits::bytes`] applies to the rows that are decoded together.
    pub fn open(path: impl AsRef<Path>, selection: &Selection, limits: &Limits) -> Result<Self, Error> {
        let mut source = source::open(path.as_ref())?;
        let kind = source.kind()?;
        if kind == FileKind::Exr {
            return Err(Error::invalid(&source.path, "first bytes", "an EXR file", "a PNG, JPEG or TIFF file"));
        }
        let (part, form) = raster::info(&mut source, kind)?;
        part.check_windows(&source.path, 0, limits)?;
        limits.check_bytes(&source.path, raster::PLACE, form.decoding())?;
        let found = selection.resolve(&source.path, std::slice::from_ref(&part))?;
        let info = PictureInfo::new(&part, found.part, &found.channels);
        Ok(Self { source, kind, form, info, channels: found.channels, limits: *limits })
    }

    /// Returns the description of the selected channels.
    pub fn info(&self) -> &PictureInfo {
        &self.info
    }

    /// Decodes the picture and passes the number of each row and one list of samples per channel to the receiver, until
    /// the receiver stops.
    ///
    /// # Errors
    /// The file is damaged or cannot be read, or there is not enough memory.
    pub fn rows(&mut self, take: &mut TakeRow<'_>) -> Result<(), Error> {
        raster::each_row(&mut self.source, self.kind, &self.form, &self.channels, &self.limits, take)
    }
}

impl std::fmt::Debug for RowReader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RowReader").field("path", &self.source.path).field("info", &self.info).finish_non_exhaustive()
    }
}
