//! Checks finished pixels against the convex hull of their palette.

use crate::Judging;
use std::sync::Arc;
use trochoid_image::Rgb;
use trochoid_kernel::Range;
use trochoid_weights::{Audit, BoxHull, Hull};

/// Sampled judging checks one row in this many.
const SAMPLED: i64 = 64;

/// Hull, bounding box and tolerance against which a color output is judged.
#[derive(Debug)]
pub(crate) struct Judge {
    pub(crate) hull: Arc<Hull>,
    pub(crate) bounds: BoxHull,
    pub(crate) margin: f64,
    pub(crate) count: usize,
    pub(crate) colors: Vec<Rgb>,
}

impl Judge {
    /// Counts the pixels of a row that left the hull, and the pixels with a NaN.
    pub(crate) fn row(&self, [r, g, b]: [&[f32]; 3]) -> Audit {
        let (hull_exits, worst_exit) = self.hull.exits(r, g, b, self.margin);
        // A NaN always counts as outside of the hull.
        let nan_count = if hull_exits > 0 { nan_count(&[r, g, b]) } else { 0 };
        Audit { hull_exits, worst_exit, nan_count, judged: r.len() as u64, ..Audit::default() }
    }

    /// Returns whether all pixels of these channels are in the bounding box of the palette.
    pub(crate) fn is_boxed(&self, range: &Range) -> bool {
        [range.least, range.largest].iter().all(|corner| self.bounds.exit(corner, self.margin).is_none())
    }
}

/// Returns whether a row is judged pixel by pixel.
pub(crate) fn is_judged(judging: Judging, y: i64) -> bool {
    judging == Judging::All || y.rem_euclid(SAMPLED) == SAMPLED - 1
}

/// Pixels with a NaN in any channel.
pub(crate) fn nan_count(channels: &[&[f32]]) -> u64 {
    let count = channels.first().map_or(0, |channel| channel.len());
    (0..count).filter(|&x| channels.iter().any(|channel| channel[x].is_nan())).count() as u64
}
