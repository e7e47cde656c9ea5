//! Edges that neighbors share: both must cut them identically, to the bit.

use std::cmp::Ordering;

use glam::DVec3;

use super::{MAX_SEGMENTS, curve};
use crate::Projector;

/// Nearest depth that counts for the size of things in the picture, in meters.
const NEAR_M: f64 = 1e-3;

/// A curve in the direction on which both of its patches agree.
pub(super) struct SharedCurve {
    points: [DVec3; 4],
    reversed: bool,
}

impl SharedCurve {
    /// Makes the shared curve of an edge as one patch sees it.
    pub(super) fn new(points: [DVec3; 4]) -> Self {
        let [a, b, c, d] = points;
        let turned = [d, c, b, a];
        let order = points.iter().zip(&turned).map(|(p, q)| {
            p.to_array().iter().zip(q.to_array()).fold(Ordering::Equal, |o, (p, q)| o.then(p.total_cmp(&q)))
        });
        match order.fold(Ordering::Equal, Ordering::then) {
            Ordering::Greater => Self { points: turned, reversed: true },
            _ => Self { points, reversed: false },
        }
    }

    /// Returns the number of straight pieces, from the edge alone.
    pub(super) fn segments(&self, scale: &Scale<'_>) -> usize {
        scale.segments(6.0 * curve::bend(&self.points), &self.points)
    }

    /// Returns the point at `index` of `count` pieces from the patch's own first end.
    pub(super) fn point(&self, index: usize, count: usize) -> DVec3 {
        let index = if self.reversed { count - index } else { index };
        match index {
            0 => self.points[0],
            _ if index == count => self.points[3],
            _ => curve::point(self.points, index as f64 / count as f64),
        }
    }
}

/// How finely to cut for one camera.
pub(super) struct Scale<'a> {
    pub(super) projector: &'a Projector,
    /// Largest distance of facets from the surface, in pixels.
    pub(super) tolerance: f64,
}

impl Scale<'_> {
    /// Returns the pixels per meter at the nearest of some points.
    pub(super) fn pixels_per_meter(&self, points: &[DVec3]) -> f64 {
        let p = self.projector;
        if p.orthographic {
            return p.scale;
        }
        let depth = points.iter().map(|point| (*point - p.position).dot(p.forward)).fold(f64::INFINITY, f64::min);
        p.scale / depth.max(NEAR_M)
    }

    /// Returns the number of pieces of a curve with second derivatives up to `bend` near `points`: an arc over h
    /// deviates from its chord by up to bend·h²/8.
    pub(super) fn segments(&self, bend: f64, points: &[DVec3]) -> usize {
        whole(libm::sqrt(bend * self.pixels_per_meter(points) / (8.0 * self.tolerance)))
    }
}

/// Rounds a number of pieces up to an integer from 1 to [`MAX_SEGMENTS`].
pub(super) fn whole(count: f64) -> usize {
    // NaN, from points that are not finite, becomes 1.
    count.ceil().max(1.0).min(MAX_SEGMENTS as f64) as usize
}
