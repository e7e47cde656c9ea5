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
    /// Number of pixels that are compared with the f64 reference.
    pub pixels: usize,
    /// Whether the whole picture is certified, or only an eighth of it.
    pub whole: bool,
    /// Tolerances of displayed values to try.
    pub tolerances: &'a [f64],
}
