//! Counting the pixels that left a hull.

use super::vector::{Point, along, length, sub};
use super::{EVALUATION, Facet, Hull};

/// Pixels judged together: their coordinates and running maximum in f64 take 2 KiB.
const BLOCK: usize = 64;

/// Projections tried before the distance is computed in full.
const PROJECTIONS: usize = 8;

impl Hull {
    /// The distance of a pixel from the hull if it exceeds the margin (≥ 0), else `None`.
    ///
    /// A pixel that is not finite is an exit at distance +∞; so is every pixel of the empty hull.
    #[must_use]
    pub fn exit(&self, pixel: &[f32; 3], margin: f64) -> Option<f64> {
        let point = pixel.map(f64::from);
        let Some((excess, projection)) = self.project(point) else {
            return Some(f64::INFINITY);
        };
        if excess <= 0.0 {
            return None;
        }
        // The excess is the distance if the projection onto the worst plane hits the hull, else a lower bound of it.
        if excess <= margin && self.reachable(point, projection, margin) {
            return None;
        }
        let distance = if self.holds(projection) { excess } else { length(sub(point, self.nearest_on_edges(point))) };
        (distance > margin).then_some(distance)
    }

    /// Whether repeated projection onto the worst plane ends in the hull within the margin.
    ///
    /// Any point of the hull that near proves that the distance is no larger, so this only saves the search for the
    /// nearest one. It seldom takes more steps than planes meet at an edge.
    fn reachable(&self, point: Point, projection: Point, margin: f64) -> bool {
        let slack = EVALUATION * self.largest;
        let mut reached = projection;
        for _ in 0..PROJECTIONS {
            let Some((facet, excess)) = self.worst_facet(reached) else {
                return false;
            };
            if excess <= slack {
                return length(sub(point, reached)) <= margin;
            }
            reached = along(reached, -excess, facet.normal);
        }
        false
    }

    /// Counts the pixels of a row that are outside by more than the margin (≥ 0), and finds the largest distance among
    /// them (0 if there is none). The same verdicts as [`exit`](Hull::exit), at a few nanoseconds per facet and pixel.
    ///
    /// # Panics
    ///
    /// If the three channels differ in length.
    #[must_use]
    pub fn exits(&self, r: &[f32], g: &[f32], b: &[f32], margin: f64) -> (u64, f64) {
        assert!(r.len() == g.len() && g.len() == b.len(), "channels of equal length");
        // The planes of inner polytopes carry an error of their own: stay clear of it.
        let clear = 4.0 * EVALUATION * self.largest;
        let (planes, slack) = if self.core.is_empty() { (&self.planes, 0.0) } else { (&self.core, -clear) };
        let deep = |point| !self.fine.is_empty() && self.fine.iter().all(|facet| facet.excess(point) <= -clear);
        let mut count = 0;
        let mut worst = 0.0_f64;
        for start in (0..r.len()).step_by(BLOCK) {
            let end = r.len().min(start + BLOCK);
            let channels = [&r[start..end], &g[start..end], &b[start..end]];
            let excess = block_excess(planes, channels);
            for (x, &excess) in excess[..end - start].iter().enumerate() {
                let certain = excess <= slack; // false for NaN
                let pixel = channels.map(|c| c[x]);
                if !certain
                    && !deep(pixel.map(f64::from))
                    && let Some(distance) = self.exit(&pixel, margin)
                {
                    count += 1;
                    worst = worst.max(distance);
                }
            }
        }
        (count, worst)
    }
}

/// The largest excess over all planes for each pixel of a block; NaN where a coordinate is not finite, or where there are no
/// planes.
fn block_excess(planes: &[Facet], channels: [&[f32]; 3]) -> [f64; BLOCK] {
    let mut r = [0.0_f64; BLOCK];
    let mut g = [0.0_f64; BLOCK];
    let mut b = [0.0_f64; BLOCK];
    for (wide, narrow) in [&mut r, &mut g, &mut b].into_iter().zip(channels) {
        for (wide, &narrow) in wide.iter_mut().zip(narrow) {
            *wide = f64::from(narrow);
        }
    }
    let Some((first, rest)) = planes.split_first() else {
        return [f64::NAN; BLOCK];
    };
    // 0 for finite coordinates, else NaN.
    let finite = |x: usize| r[x] * 0.0 + g[x] * 0.0 + b[x] * 0.0;
    let mut largest: [f64; BLOCK] = std::array::from_fn(|x| first.excess([r[x], g[x], b[x]]) + finite(x));
    for plane in rest {
        for x in 0..BLOCK {
            let excess = plane.excess([r[x], g[x], b[x]]);
            // In this order the NaN of a pixel that is not finite stays.
            largest[x] = if excess > largest[x] { excess } else { largest[x] };
        }
    }
    largest
}
