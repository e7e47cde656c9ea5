//! How thick water is along rays that leave it.

use super::seen::Seen;
use super::surroundings::{First, UNDER, landed};
use trochoid_graph::{Item, Knob, Settled};
use trochoid_scene::{DVec3, Ray};

pub(crate) const INSET: Item = Knob::number(
    "inset",
    0.5,
    0.0,
    1e3,
    "How far under the surface the way begins, so that ripples do not count: at most halfway through a thin crest.",
)
.unit("m")
.item();
pub(crate) const DISTANCE: Item =
    Knob::number("distance", 50.0, 1e-3, 1e6, "The thickness of what is thicker, or has no end.").unit("m").item();

/// Figures of a way through water.
#[derive(Clone, Copy)]
pub(crate) struct Way {
    inset: f64,
    distance: f64,
}

impl Way {
    pub(crate) fn of(node: &Settled) -> Self {
        Self { inset: node.number("inset"), distance: node.number("distance") }
    }

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
