//! Bounding balls of patches, for rays that miss them.

use crate::Ray;
use glam::DVec3;

/// Tolerance of the test whether a part of a patch may contain the ray, relative to the patch's distance and size:
/// rounding must not open gaps between parts.
pub(super) const SLACK: f64 = 1e-12;

/// Bounding ball of a patch or a model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    center: DVec3,
    radius: f64,
}

impl Ball {
    /// Returns the ball around a box.
    pub(super) fn around(low: DVec3, high: DVec3) -> Self {
        Self { center: (low + high) / 2.0, radius: low.distance(high) / 2.0 }
    }

    /// Returns whether a ray may meet the ball between two distances.
    pub(super) fn may_meet(&self, ray: &Ray, [from, to]: [f64; 2]) -> bool {
        let offset = self.center - ray.origin;
        let reach = self.radius + SLACK * (self.radius + offset.length());
        let along = offset.dot(ray.direction);
        let aside = (offset - along * ray.direction).length();
        !(aside > reach || along + reach < from || along - reach > to)
    }
}
