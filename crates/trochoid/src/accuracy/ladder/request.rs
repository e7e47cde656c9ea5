//! Request for a ladder.

use crate::accuracy::Request;
use trochoid_image::Format;

/// Measurements that are requested of a ladder.
#[derive(Clone, Copy, Debug)]
pub struct LadderRequest<'a> {
    /// Output, frame and settings of plans; its tolerance is ignored.
    pub request: Request<'a>,
    /// Format of the measured pictures, if not the document's.
    pub format: Option<Format>,
    /// How much is measured.
    pub effort: Effort,
    /// Seed of the pixels that are drawn.
    pub seed: u64,
    /// Tolerances of displayed values to try.
    pub tolerances: &'a [f64],
}

/// How much is measured.
///
/// Two numbers of pixels are meant by n pixels: n drawn in the whole picture, and n drawn where settings differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effort {
    /// As many pixels as fit into this many seconds, up to [`Effort::MOST`]; what does not fit is left out, and said.
    Within(f64),
    /// This many pixels, rounded up to a power of 2, however long it takes.
    Pixels(usize),
    /// This many pixels, rounded up to a power of 2, for the references; bounds of all pixels; and what work costs that is
    /// left out, or that knobs increase.
    Whole(usize),
}

impl Effort {
    /// Most pixels that are drawn if only time limits them.
    pub const MOST: usize = 4096;
}
