//! Seas of waves.

use super::{Corner, Most, Near, Smooth};
use crate::reference::hit_of_sea;
use crate::surface::Hit;
use crate::{Projector, Ray, SeaSurface};
use glam::{DMat3, DVec3};
use trochoid_sea::{Precise, PreciseSea};

/// Footprints of the table of bends: so many to the doubling, from so many meters on.
const PER_OCTAVE: f64 = 32.0;
const FIRST: f64 = 1e-3;
const OCTAVES: f64 = 36.0;

/// Newton's steps to the point of a ray, and its error over 1 m + distance at which they end.
const STEPS: usize = 12;
const CLOSE: f64 = 1e-12;

/// The Jacobian below which another part of the sea may have been carried to the same place, which the reference may see,
/// and how far off it is looked for, as a share of how far waves carry anything.
const CROWDED: f64 = 0.7;
const BESIDE: [f64; 8] = [-1.0, -0.4, -0.15, -0.05, 0.05, 0.15, 0.4, 1.0];

/// A sea as one camera sees it.
pub(crate) struct SeenSea<'a> {
    sea: &'a SeaSurface,
    projector: &'a Projector,
    precise: &'a PreciseSea,
    /// At no footprint, and at those of the table.
    most: Vec<[f64; 4]>,
}

impl<'a> SeenSea<'a> {
    pub(crate) fn new(sea: &'a SeaSurface, projector: &'a Projector) -> Self {
        let precise = sea.precise();
        let footprints =
            (0..=(OCTAVES * PER_OCTAVE) as usize).map(|index| FIRST * libm::exp2(index as f64 / PER_OCTAVE));
        let most = std::iter::once(0.0).chain(footprints).map(|footprint| precise.most_bends(footprint)).collect();
        Self { sea, projector, precise, most }
    }

    /// Bounds at a footprint: those of the next smaller one, where waves are larger.
    fn most_at(&self, footprint: f64) -> [f64; 4] {
        let index = if footprint < FIRST { 0 } else { 1 + (libm::log2(footprint / FIRST) * PER_OCTAVE) as usize };
        self.most[index.min(self.most.len() - 1)]
    }
}

/// The sea at a rest point with its footprint.
fn at(sea: &SeaSurface, projector: &Projector, rest: [f64; 2]) -> Precise {
    let footprint = sea.footprint(projector, DVec3::new(rest[0], sea.level, rest[1]));
    sea.precise().evaluate(rest, footprint)
}

/// Derivatives of the point by the rest point's x and z: also by way of the footprint, which changes ahead of the camera
/// alone.
fn derivatives(sea: &SeaSurface, projector: &Projector, rest: [f64; 2], precise: &Precise) -> [DVec3; 2] {
    let ([xx, xz, zz], [yx, yz]) = (precise.sample.strain, precise.sample.slope);
    let (growth, heading) = (growth(sea, projector, rest), projector.heading());
    let by_footprint = DVec3::from(precise.by_footprint) * growth;
    [DVec3::new(1.0 + xx, yx, xz) + by_footprint * heading[0], DVec3::new(xz, yz, 1.0 + zz) + by_footprint * heading[1]]
}

/// How much the footprint grows with each meter ahead.
fn growth(sea: &SeaSurface, projector: &Projector, rest: [f64; 2]) -> f64 {
    let heading = projector.heading();
    let place = |by: f64| DVec3::new(rest[0] + by * heading[0], sea.level, rest[1] + by * heading[1]);
    let step = 1e-4 * (1.0 + (place(0.0) - projector.position).length());
    (sea.footprint(projector, place(step)) - sea.footprint(projector, place(-step))) / (2.0 * step)
}

impl Smooth for SeenSea<'_> {
    fn corner(&self, rest: [f64; 2]) -> Corner {
        let footprint = self.sea.footprint(self.projector, DVec3::new(rest[0], self.sea.level, rest[1]));
        let (precise, bends) = self.precise.bent(rest, footprint);
        let by = derivatives(self.sea, self.projector, rest, &precise);
        let point = DVec3::new(rest[0], self.sea.level, rest[1]) + DVec3::from(precise.sample.displacement);
        let (growth, [x, z]) = (growth(self.sea, self.projector, rest), self.projector.heading().map(|way| 2.0 * way));
        let [xx, xz, zz] = bends.by_rest.map(DVec3::from);
        let [xf, zf] = bends.by_footprint.map(|bend| DVec3::from(bend) * growth);
        let second = [xx + xf * x, xz + (xf * z + zf * x) / 2.0, zz + zf * z];
        Corner { rest, point: point - self.projector.position, by, second }
    }

    /// The footprint f grows by f′ with each meter. What is left of a wave, exp(−k²f²/8), then changes by kf·f′/4 for
    /// every radian of it: by f′/2 and less at each derivative where kf ≤ 2, and of a wave with larger kf the greatest
    /// share that counts here, e^(−k²f²/8)·(1 + kf·f′/4)⁵, is below what (1 + 2f′)⁵ allows where f′ is below 1.
    fn most(&self, corners: &[[f64; 2]; 4]) -> Most {
        let footprint =
            |rest: &[f64; 2]| self.sea.footprint(self.projector, DVec3::new(rest[0], self.sea.level, rest[1]));
        let least = corners.iter().map(footprint).fold(f64::INFINITY, f64::min);
        let growth = corners.iter().map(|rest| growth(self.sea, self.projector, *rest).abs()).fold(0.0, f64::max);
        let more = libm::pow(1.0 + 2.0 * growth, 5.0);
        let [second, _, fourth, fifth] = self.most_at(least);
        Most { fourth: fourth * more, fifth: fifth * more, twist: second * (more - 1.0) * (more - 1.0) }
    }
}

/// The point where a ray meets a sea next to a point of its mesh: Newton's steps in the rest point and the distance.
pub(crate) fn meet_sea(sea: &SeaSurface, projector: &Projector, ray: &Ray, near: &Near) -> Option<Hit> {
    let (mut rest, mut distance) = ([near.rest.x, near.rest.z], near.distance);
    for _ in 0..STEPS {
        let precise = at(sea, projector, rest);
        let point = DVec3::new(rest[0], sea.level, rest[1]) + DVec3::from(precise.sample.displacement);
        let error = point - ray.at(distance);
        let [by_x, by_z] = derivatives(sea, projector, rest, &precise);
        let ways = DMat3::from_cols(by_x, by_z, -ray.direction);
        if error.length() <= CLOSE * (1.0 + distance.abs()) {
            let is_alone = || precise.sample.jacobian() > CROWDED || !is_crowded(sea, projector, rest, &precise);
            let hit = || hit_of_sea(sea, projector, ray, distance, (rest, &precise.sample), near.inside);
            return (distance >= 0.0 && is_alone()).then(hit);
        }
        let step = ways.inverse() * error;
        if !step.is_finite() {
            return None;
        }
        rest = [rest[0] - step.x, rest[1] - step.y];
        distance -= step.z;
    }
    None
}

/// Whether another rest point than this one is carried to the place above or below it, as in folds.
fn is_crowded(sea: &SeaSurface, projector: &Projector, rest: [f64; 2], precise: &Precise) -> bool {
    let [xx, xz, zz] = precise.sample.strain;
    let [dx, _, dz] = precise.sample.displacement;
    let place = [rest[0] + dx, rest[1] + dz];
    // The direction in which the sea is most compressed.
    let turn = 0.5 * libm::atan2(2.0 * xz, xx - zz) + std::f64::consts::FRAC_PI_2;
    let (sin, cos) = libm::sincos(turn);
    let length = sea.bounds.reach;
    let close = CLOSE * (1.0 + libm::hypot(place[0], place[1]));
    BESIDE.iter().any(|share| {
        let mut other = [rest[0] + share * length * cos, rest[1] + share * length * sin];
        for _ in 0..STEPS {
            let there = at(sea, projector, other).sample;
            let error = [other[0] + there.displacement[0] - place[0], other[1] + there.displacement[2] - place[1]];
            if libm::hypot(error[0], error[1]) <= close {
                return libm::hypot(other[0] - rest[0], other[1] - rest[1]) > 1e-6 * length;
            }
            let ([xx, xz, zz], jacobian) = (there.strain, there.jacobian());
            other[0] -= ((1.0 + zz) * error[0] - xz * error[1]) / jacobian;
            other[1] -= ((1.0 + xx) * error[1] - xz * error[0]) / jacobian;
        }
        false
    })
}
