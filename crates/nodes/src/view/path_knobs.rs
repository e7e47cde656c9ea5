//! Thickness of water along rays that leave it.

use super::seen::SeenPoint;
use super::surroundings::{Rays, UNDER, landed};
use trochoid_graph::Items;
use trochoid_memory::Scratch;
use trochoid_scene::{DVec3, Ray, Segment};

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

    /// Returns the points below seen points at which paths start.
    pub(crate) fn starts(self, seen: &[SeenPoint], rays: &dyn Rays) -> Scratch<DVec3> {
        // Start slightly below the surface, so that it is not taken for its own far side.
        let inward = |(seen, surface): (&SeenPoint, &DVec3)| {
            let &SeenPoint { normal, facet, .. } = seen;
            let ray = Ray { origin: *surface - normal * (UNDER * facet), direction: -normal };
            Segment { ray, limit: 2.0 * self.inset }
        };
        let inward: Scratch<Segment> = seen.iter().zip(&landed(seen, rays)).map(inward).collect();
        let through = rays.first(&inward);
        let halfway = through.iter().map(|through| through.map_or(self.inset, |through| 0.5 * through));
        inward.iter().zip(halfway).map(|(inward, halfway)| inward.ray.at(halfway)).collect()
    }

    /// Returns the lengths of the paths out of the water, each from its start along a unit vector.
    pub(crate) fn lengths(self, paths: impl Iterator<Item = (DVec3, DVec3)>, rays: &dyn Rays) -> Scratch<f64> {
        let segment = |(origin, direction)| Segment { ray: Ray { origin, direction }, limit: self.distance };
        let segments: Scratch<Segment> = paths.map(segment).collect();
        let lengths = rays.first(&segments);
        lengths.iter().map(|length| length.map_or(self.distance, |length| length.min(self.distance))).collect()
    }
}
