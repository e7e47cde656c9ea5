//! Audits: counts of judged pixels.

/// Counts of judged pixels: plain data, made per tile and merged in any order.
///
/// [`Default`] is the audit of no pixels, the neutral element of [`merge`](Audit::merge).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Audit {
    /// Number of pixels made.
    pub pixels: u64,
    /// Number of pixels judged one by one; the others were only checked to be in the bounding box of their controls.
    pub judged: u64,
    /// Number of pixels outside of the hull (or box) of their controls by more than the margin, including NaN.
    pub hull_exits: u64,
    /// Largest distance of these pixels from the hull, in units of the working space; 0 if there are none, +∞ for a
    /// pixel that is not finite.
    pub worst_exit: f64,
    /// Largest |Σω − 1| found.
    pub weight_sum_max_deviation: f64,
    /// Smallest weight found; +∞ if there were no weights.
    pub weight_min: f64,
    /// Number of pixels with a NaN in any channel or weight.
    pub nan_count: u64,
}

impl Default for Audit {
    fn default() -> Self {
        Self {
            pixels: 0,
            judged: 0,
            hull_exits: 0,
            worst_exit: 0.0,
            weight_sum_max_deviation: 0.0,
            weight_min: f64::INFINITY,
            nan_count: 0,
        }
    }
}

impl Audit {
    /// Merges the audits of two sets of pixels.
    ///
    /// Counts are added and extremes compared, so the result does not depend on the order or grouping of merges.
    #[must_use]
    pub fn merge(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            judged: self.judged + other.judged,
            hull_exits: self.hull_exits + other.hull_exits,
            worst_exit: self.worst_exit.max(other.worst_exit),
            weight_sum_max_deviation: self.weight_sum_max_deviation.max(other.weight_sum_max_deviation),
            weight_min: self.weight_min.min(other.weight_min),
            nan_count: self.nan_count + other.nan_count,
        }
    }
}
