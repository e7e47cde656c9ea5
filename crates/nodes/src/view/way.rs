//! How thick water is along rays that leave it.

use super::seen::Seen;
use super::surroundings::{First, UNDER, landed};
use trochoid_graph::Items;
use trochoid_scene::{DVec3, Ray};

/// Figures of a way through water.
#[derive(Clone, Copy, Items)]
pub(crate) struct Way {
    /// How far under the surface the way begins, so that ripples do not count: at most halfway through a thin crest.
    #[knob(default = 0.5, range = 0.0..=1e3, unit = "m")]
    inset: f64,
    /// The thickness of what is thicker, or has no end.
    #[knob(default = 50.0, range = 1e-3..=1e6, unit = "m")]
    distance: f64,
}

impl Way {
    /// The longest length.
    pub(crate) fn most(self) -> f64 {
        self.distance
    }

    /// Length of the way from under a seen point out of the water, along a unit vector.
    pub(crate) fn length(self, seen: &Seen, along: DVec3, first: First<'_>) -> f64 {
        let &Seen { point, normal, facet, .. } = seen;
        let surface = landed(point, normal, facet, first);
        // A little below it, so that the surface itself is not its other side.
        let inward = Ray { origin: surface - normal * (UNDER * facet), direction: -normal };
        let halfway = first(&inward, 2.0 * self.inset).map_or(self.inset, |through| 0.5 * through);
        let start = Ray { origin: inward.at(halfway), direction: along };
        first(&start, self.distance).map_or(self.distance, |length| length.min(self.distance))
    }
}
