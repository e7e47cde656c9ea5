//! Definitions for all raster formats: their form, receivers of rows, and errors.

use std::ops::ControlFlow;
use std::path::Path;

use image::metadata::Orientation;
use trochoid_image::Window;

use crate::{Encoding, Error, FileKind, SampleType};

/// Name of the picture in messages, since these files have only one.
pub(crate) const PLACE: &str = "the picture";
/// Remedy for an unsupported picture.
pub(crate) const CONVERT: &str =
    "convert it, for example with oiiotool or ImageMagick, to PNG, to TIFF with 8 or 16 bits, or to EXR";

/// Form of a picture as described by its header.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Form {
    /// Stored width and height, before the picture is turned upright.
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Type of the decoded samples.
    pub(crate) sample_type: SampleType,
    /// Number of interleaved channels per pixel.
    pub(crate) bases: &'static [&'static str],
    pub(crate) orientation: Orientation,
    pub(crate) encoding: Encoding,
    /// Number of rows that are decoded together.
    pub(crate) rows: u32,
    /// Maximum memory for decoding in addition to these rows, in bytes.
    pub(crate) working: u64,
}

/// Channel names of gray, gray with alpha, color, and color with alpha.
pub(crate) fn bases(color: bool, alpha: bool) -> &'static [&'static str] {
    match (color, alpha) {
        (false, false) => &["Y"],
        (false, true) => &["Y", "A"],
        (true, false) => &["R", "G", "B"],
        (true, true) => &["R", "G", "B", "A"],
    }
}

impl Form {
    /// Returns the size of a decoded pixel, in bytes.
    pub(crate) fn pixel(&self) -> usize {
        self.bases.len() * self.sample_type.bytes()
    }

    pub(crate) fn row_bytes(&self) -> usize {
        self.width as usize * self.pixel()
    }

    pub(crate) fn stored(&self) -> Window {
        Window::sized(self.width, self.height)
    }

    /// Returns whether rows are decoded upright and in order.
    pub(crate) fn in_order(&self) -> bool {
        matches!(self.orientation, Orientation::NoTransforms | Orientation::FlipHorizontal)
    }

    /// Returns the maximum memory for decoding, in bytes, in addition to the result.
    pub(crate) fn decoding(&self) -> u64 {
        let rows = if self.in_order() { self.rows.min(self.height) } else { self.height };
        (self.row_bytes() as u64).saturating_mul(u64::from(rows)).saturating_add(self.working)
    }
}

/// Receiver of a row: its number, and one list of samples per channel; may stop the decoding.
pub type TakeRow<'a> = dyn FnMut(i64, &[Vec<f32>]) -> ControlFlow<()> + 'a;

/// Receiver of decoded rows: the number of the first, and interleaved samples in native byte order.
pub(crate) type TakeBytes<'a> = dyn FnMut(usize, &[u8]) -> ControlFlow<()> + 'a;

/// Refuses a picture that claims more pixels than its file can contain, before memory is taken for them.
pub(crate) fn check_claim(path: &Path, form: &Form, length: u64, densest: u64) -> Result<(), Error> {
    let claimed = (form.row_bytes() as u64).saturating_mul(u64::from(form.height));
    if claimed > length.saturating_mul(densest) {
        let found = format!("{length} bytes");
        return Err(Error::invalid(path, PLACE, found, format!("enough for {} × {} pixels", form.width, form.height)));
    }
    Ok(())
}

/// Returns the error of a file whose bytes do not decode, with the rows that did.
pub(crate) fn damaged(path: &Path, kind: FileKind, row: usize) -> Error {
    let place = if row == 0 { PLACE.into() } else { format!("{PLACE}, row {row}") };
    Error::invalid(path, place, "bytes that do not decode", format!("a whole {kind} file"))
}

/// Returns the error of an unsupported kind of file.
pub(crate) fn unsupported(path: &Path, found: impl Into<String>) -> Error {
    Error::Unsupported { path: path.into(), place: PLACE.into(), found: found.into(), remedy: CONVERT }
}
