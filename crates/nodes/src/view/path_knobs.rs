//! Thickness of water along rays that leave it.

use super::seen::SeenPoint;
use super::surroundings::{First, UNDER, landed};
use trochoid_graph::Items;
use trochoid_scene::{DVec3, Ray};

/// Knobs of a path through water.
#[derive(Clone, Copy, Items)]
pub(crate) struct PathKnobs {
    /// Depth below the surface at which the path starts, so that ripples do not count; at most halfway through a thin
    /// crest.
    #[knob(default = 0.5, range = 0.0..=1e3, unit = "m")]
    inset: f64,
    /// Maximum thickness, also used where the path never ends.
    #[knob(default = 50.0, range = 1e-3..=1e6, unit = "m")]
    distance: f64,
}

impl PathKnobs {
    /// Returns the maximum length.
    pub(crate) fn most(self) -> f64 {
        self.distance
    }

    /// Returns the length of the path from below a seen point out of the water, along a unit vector.
    pub(crate) fn length(self, seen: &SeenPoint, along: DVec3, first: First<'_>) -> f64 {
        let &SeenPoint { point, normal, facet, .. } = seen;
        let surface = landed(point, normal, facet, first);
        // Start slightly below the surface, so that it is not taken for its own far side.
        let inward = Ray { origin: surface - normal * (UNDER * facet), direction: -normal };
        let halfway = first(&inward, 2.0 * self.inset).map_or(self.inset, |through| 0.5 * through);
        let start = Ray { origin: inward.at(halfway), direction: along };
        first(&start, self.distance).map_or(self.distance, |length| length.min(self.distance))
    }
}
