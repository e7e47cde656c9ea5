//! Points of a sea as they appear in a camera's picture: each is filtered by the footprint of the pixel that sees its
//! rest point.

use crate::{Projector, SeaSurface};
use glam::DVec3;
use trochoid_sea::{Precise, PreciseSea};

/// The point to which a sea carries a rest point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeaPoint {
    /// Position in the world.
    pub(crate) point: DVec3,
    /// Derivatives by the rest point's x and z. They include the effect of the footprint, which changes only along
    /// the camera's heading.
    pub(crate) by: [DVec3; 2],
    pub(crate) precise: Precise,
    pub(crate) footprint: f64,
    /// Growth of the footprint per meter ahead of the camera.
    pub(crate) growth: f64,
}

impl SeaSurface {
    pub(crate) fn carried(&self, projector: &Projector, rest: [f64; 2]) -> SeaPoint {
        let footprint = self.footprint(projector, DVec3::new(rest[0], self.level, rest[1]));
        self.carried_as(projector, rest, footprint, self.precise().evaluate(rest, footprint))
    }

    /// Does the same if the sea at the rest point is already known.
    pub(crate) fn carried_as(
        &self,
        projector: &Projector,
        rest: [f64; 2],
        footprint: f64,
        precise: Precise,
    ) -> SeaPoint {
        let growth = self.growth(projector, rest);
        let ([xx, xz, zz], [yx, yz]) = (precise.sample.strain, precise.sample.slope);
        let [x, z] = projector.heading();
        let by_footprint = DVec3::from(precise.by_footprint) * growth;
        SeaPoint {
            point: DVec3::new(rest[0], self.level, rest[1]) + DVec3::from(precise.sample.displacement),
            by: [DVec3::new(1.0 + xx, yx, xz) + by_footprint * x, DVec3::new(xz, yz, 1.0 + zz) + by_footprint * z],
            precise,
            footprint,
            growth,
        }
    }

    /// Returns the growth of the footprint at a rest point per meter ahead of the camera.
    pub(crate) fn growth(&self, projector: &Projector, rest: [f64; 2]) -> f64 {
        let heading = projector.heading();
        let place = |by: f64| DVec3::new(rest[0] + by * heading[0], self.level, rest[1] + by * heading[1]);
        let step = 1e-4 * (1.0 + (place(0.0) - projector.position).length());
        (self.footprint(projector, place(step)) - self.footprint(projector, place(-step))) / (2.0 * step)
    }
}

/// Footprints of the table: entries per octave, first footprint in meters, and number of octaves.
const PER_OCTAVE: f64 = 32.0;
const FIRST: f64 = 1e-3;
const OCTAVES: f64 = 36.0;

/// Limits of the derivatives of a sea's displacement by footprint: a table of [`PreciseSea::most`].
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    /// Row for no footprint, then one row for each footprint of the table.
    rows: Vec<[f64; 6]>,
    /// The footprints of the table, and the slope variance of the waves that each filters out.
    rough: Vec<[f64; 2]>,
}

impl Limits {
    pub(crate) fn new(precise: &PreciseSea) -> Self {
        let footprints =
            (0..=(OCTAVES * PER_OCTAVE) as usize).map(|index| FIRST * libm::exp2(index as f64 / PER_OCTAVE));
        let lost = |footprint: f64| precise.evaluate([0.0; 2], footprint).sample.slope_variance;
        Self {
            rows: std::iter::once(0.0).chain(footprints.clone()).map(|footprint| precise.most(footprint)).collect(),
            rough: footprints.map(|footprint| [footprint, lost(footprint)]).collect(),
        }
    }

    /// Returns the limits by order of the derivative; those of the next smaller footprint, where waves are larger.
    pub(crate) fn at(&self, footprint: f64) -> [f64; 6] {
        let index = if footprint < FIRST { 0 } else { 1 + (libm::log2(footprint / FIRST) * PER_OCTAVE) as usize };
        self.rows[index.min(self.rows.len() - 1)]
    }

    /// Returns the slope variance of the waves that a footprint filters out, and how far it may be off; `None` outside of
    /// the table.
    ///
    /// It is Σv·(1 − exp(−w)) with w = k²f²/4. Its second derivative by f is Σv·2w·(1 − 2w)·exp(−w)/f², and 1.7·Σv/f² at
    /// most, so that a straight line between neighbors that are a factor of 2^(1/32) apart is off by a ten-thousandth.
    pub(crate) fn roughness(&self, footprint: f64) -> Option<(f64, f64)> {
        const OFF: f64 = 1.1e-4;
        if footprint < FIRST {
            return None;
        }
        let index = (libm::log2(footprint / FIRST) * PER_OCTAVE) as usize;
        let [[low, less], [high, more]] = [*self.rough.get(index)?, *self.rough.get(index + 1)?];
        let all = self.rough.last()?[1];
        Some((less + (more - less) * (footprint - low) / (high - low), OFF * all))
    }
}
