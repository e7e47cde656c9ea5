//! Boxes along the axes, in f32.

use glam::Vec3;

/// A box along the axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) low: Vec3,
    pub(super) high: Vec3,
}

impl Bounds {
    /// The box without points.
    pub(super) const NOTHING: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// Returns the smallest box around some points.
    pub(super) fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::NOTHING, |all, point| all.union(Self { low: point, high: point }))
    }

    /// Returns the smallest box around two boxes.
    pub(super) fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    pub(super) fn middle(&self) -> Vec3 {
        // Half of each, because the sum may overflow.
        self.low * 0.5 + self.high * 0.5
    }

    /// Returns half the surface area, in f64, where it cannot overflow; 0 for the box without points.
    pub(super) fn area(&self) -> f64 {
        let [x, y, z] = (self.high.as_dvec3() - self.low.as_dvec3()).to_array().map(|side| side.max(0.0));
        x * y + y * z + z * x
    }
}
