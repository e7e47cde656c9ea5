//! What a ladder is asked for.

use crate::accuracy::Request;
use trochoid_image::Format;

/// What is to be measured.
#[derive(Clone, Copy, Debug)]
pub struct LadderRequest<'a> {
    /// Output, frame and how plans run; the tolerance does not count.
    pub request: Request<'a>,
    /// The size at which all is measured, if not the document's.
    pub format: Option<Format>,
    /// How many pixels are held against the f64 reference.
    pub pixels: usize,
    /// Whether all of the picture is certified, or an eighth of it.
    pub whole: bool,
    /// Tolerances to ask for, of displayed values.
    pub tolerances: &'a [f64],
}
