//! What all rasters share: their form, who takes their rows, and what can be wrong with them.

use std::ops::ControlFlow;
use std::path::Path;

use image::metadata::Orientation;
use trochoid_image::Window;

use crate::{Encoding, Error, FileKind, SampleType};

/// The picture, for messages: these files have one.
pub(crate) const PLACE: &str = "the picture";
/// What to do about a picture that is not read.
pub(crate) const CONVERT: &str =
    "convert it, for example with oiiotool or ImageMagick, to PNG, to TIFF with 8 or 16 bits, or to EXR";

/// A picture as its header describes it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Form {
    /// Stored, before it is turned upright.
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Type of the decoded samples.
    pub(crate) sample_type: SampleType,
    /// Channels of a pixel, interleaved.
    pub(crate) bases: &'static [&'static str],
    pub(crate) orientation: Orientation,
    pub(crate) encoding: Encoding,
    /// Rows that are decoded together.
    pub(crate) rows: u32,
    /// Bytes that decoding takes at most besides these rows.
    pub(crate) working: u64,
}

/// The names of gray, gray with alpha, color, color with alpha.
pub(crate) fn bases(color: bool, alpha: bool) -> &'static [&'static str] {
    match (color, alpha) {
        (false, false) => &["Y"],
        (false, true) => &["Y", "A"],
        (true, false) => &["R", "G", "B"],
        (true, true) => &["R", "G", "B", "A"],
    }
}

impl Form {
    /// Bytes of a decoded pixel.
    pub(crate) fn pixel(&self) -> usize {
        self.bases.len() * self.sample_type.bytes()
    }

    pub(crate) fn row_bytes(&self) -> usize {
        self.width as usize * self.pixel()
    }

    pub(crate) fn stored(&self) -> Window {
        Window::sized(self.width, self.height)
    }

    /// Whether rows come upright in their order.
    pub(crate) fn in_order(&self) -> bool {
        matches!(self.orientation, Orientation::NoTransforms | Orientation::FlipHorizontal)
    }

    /// Bytes that decoding takes at most, besides what is kept of it.
    pub(crate) fn decoding(&self) -> u64 {
        let rows = if self.in_order() { self.rows.min(self.height) } else { self.height };
        (self.row_bytes() as u64).saturating_mul(u64::from(rows)).saturating_add(self.working)
    }
}

/// Takes a row: its number, and its samples, one list a channel; may break off.
pub type TakeRow<'a> = dyn FnMut(i64, &[Vec<f32>]) -> ControlFlow<()> + 'a;

/// Takes decoded rows: their number, and their interleaved samples in the machine's byte order.
pub(crate) type TakeBytes<'a> = dyn FnMut(usize, &[u8]) -> ControlFlow<()> + 'a;

/// A picture that claims more pixels than its file can hold, before memory is taken for them.
pub(crate) fn check_claim(path: &Path, form: &Form, length: u64, densest: u64) -> Result<(), Error> {
    let claimed = (form.row_bytes() as u64).saturating_mul(u64::from(form.height));
    if claimed > length.saturating_mul(densest) {
        let found = format!("{length} bytes");
        return Err(Error::invalid(path, PLACE, found, format!("enough for {} × {} pixels", form.width, form.height)));
    }
    Ok(())
}

/// A file whose bytes do not decode, with the rows that did.
pub(crate) fn damaged(path: &Path, kind: FileKind, row: usize) -> Error {
    let place = if row == 0 { PLACE.into() } else { format!("{PLACE}, row {row}") };
    Error::invalid(path, place, "bytes that do not decode", format!("a whole {kind} file"))
}

/// A file of a kind that is not read.
pub(crate) fn unsupported(path: &Path, found: impl Into<String>) -> Error {
    Error::Unsupported { path: path.into(), place: PLACE.into(), found: found.into(), remedy: CONVERT }
}
