//! What was counted while pixels were judged.

/// The tally of judged pixels: plain data, made per tile and merged in any order.
///
/// [`Default`] is the tally of no pixel, the neutral element of [`merge`](Audit::merge).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Audit {
    /// Pixels made.
    pub pixels: u64,
    /// Pixels judged one by one; the others were only seen to lie in the box of their controls.
    pub judged: u64,
    /// Pixels outside the hull (or box) of their controls by more than the margin; NaN counts.
    pub hull_exits: u64,
    /// The largest distance of such a pixel from the hull, in units of the working space; 0 where there is none, +∞
    /// for a pixel that is not finite.
    pub worst_exit: f64,
    /// The largest |Σω − 1| seen.
    pub weight_sum_max_deviation: f64,
    /// The smallest weight seen; +∞ where no weight was seen.
    pub weight_min: f64,
    /// Pixels with a NaN in any channel or weight.
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
    /// The tally of both sets of pixels.
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
