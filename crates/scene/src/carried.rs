//! Points of a sea as the picture of a camera has them: each under the footprint of the pixel that sees its rest point.

use crate::{Projector, SeaSurface};
use glam::DVec3;
use trochoid_sea::{Precise, PreciseSea};

/// The point that a sea carries a rest point to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carried {
    /// In the world.
    pub(crate) point: DVec3,
    /// Its derivatives by the rest point's x and z: also by way of the footprint, which changes ahead of the camera alone.
    pub(crate) by: [DVec3; 2],
    pub(crate) precise: Precise,
    pub(crate) footprint: f64,
    /// How much the footprint grows with each meter ahead of the camera.
    pub(crate) growth: f64,
}

impl SeaSurface {
    pub(crate) fn carried(&self, projector: &Projector, rest: [f64; 2]) -> Carried {
        let footprint = self.footprint(projector, DVec3::new(rest[0], self.level, rest[1]));
        self.carried_as(projector, rest, footprint, self.precise().evaluate(rest, footprint))
    }

    /// The same, where the sea is known already.
    pub(crate) fn carried_as(
        &self,
        projector: &Projector,
        rest: [f64; 2],
        footprint: f64,
        precise: Precise,
    ) -> Carried {
        let growth = self.growth(projector, rest);
        let ([xx, xz, zz], [yx, yz]) = (precise.sample.strain, precise.sample.slope);
        let [x, z] = projector.heading();
        let by_footprint = DVec3::from(precise.by_footprint) * growth;
        Carried {
            point: DVec3::new(rest[0], self.level, rest[1]) + DVec3::from(precise.sample.displacement),
            by: [DVec3::new(1.0 + xx, yx, xz) + by_footprint * x, DVec3::new(xz, yz, 1.0 + zz) + by_footprint * z],
            precise,
            footprint,
            growth,
        }
    }

    /// How much the footprint grows at a rest point with each meter ahead of the camera.
    pub(crate) fn growth(&self, projector: &Projector, rest: [f64; 2]) -> f64 {
        let heading = projector.heading();
        let place = |by: f64| DVec3::new(rest[0] + by * heading[0], self.level, rest[1] + by * heading[1]);
        let step = 1e-4 * (1.0 + (place(0.0) - projector.position).length());
        (self.footprint(projector, place(step)) - self.footprint(projector, place(-step))) / (2.0 * step)
    }
}

/// Footprints of the table: so many to the doubling, from so many meters on.
const PER_OCTAVE: f64 = 32.0;
const FIRST: f64 = 1e-3;
const OCTAVES: f64 = 36.0;

/// What the derivatives of a sea's displacement cannot pass, by the footprint: [`PreciseSea::most`] as a table.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    /// At no footprint, and at those of the table.
    rows: Vec<[f64; 6]>,
}

impl Limits {
    pub(crate) fn new(precise: &PreciseSea) -> Self {
        let footprints =
            (0..=(OCTAVES * PER_OCTAVE) as usize).map(|index| FIRST * libm::exp2(index as f64 / PER_OCTAVE));
        Self { rows: std::iter::once(0.0).chain(footprints).map(|footprint| precise.most(footprint)).collect() }
    }

    /// By the order of the derivative: those of the next smaller footprint, where waves are larger.
    pub(crate) fn at(&self, footprint: f64) -> [f64; 6] {
        let index = if footprint < FIRST { 0 } else { 1 + (libm::log2(footprint / FIRST) * PER_OCTAVE) as usize };
        self.rows[index.min(self.rows.len() - 1)]
    }
}
