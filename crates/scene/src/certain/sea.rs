//! Contours of seas of waves.

use super::{DerivativeLimits, SmoothSurface, SurfaceCorner};
use crate::points::MeshHit;
use crate::reference::hit_of_sea;
use crate::sea_point::SeaPoint;
use crate::surface::Hit;
use crate::{Projector, Ray, SeaSurface};
use glam::{DMat3, DVec3};

/// Most Newton steps to the point on a ray, and the error relative to 1 m + distance at which they end.
const STEPS: usize = 12;
const CLOSE: f64 = 1e-12;

/// A sea as one camera sees it.
pub(crate) struct SeenSea<'a> {
    pub(crate) sea: &'a SeaSurface,
    pub(crate) projector: &'a Projector,
}

impl SmoothSurface for SeenSea<'_> {
    fn corner(&self, rest: [f64; 2]) -> SurfaceCorner {
        let footprint = self.sea.footprint(self.projector, DVec3::new(rest[0], self.sea.level, rest[1]));
        let (precise, bends) = self.sea.precise().bent(rest, footprint);
        let SeaPoint { point, by, growth, .. } = self.sea.carried_as(self.projector, rest, footprint, precise);
        let [x, z] = self.projector.heading().map(|way| 2.0 * way);
        let [xx, xz, zz] = bends.by_rest.map(DVec3::from);
        let [xf, zf] = bends.by_footprint.map(|bend| DVec3::from(bend) * growth);
        let second = [xx + xf * x, xz + (xf * z + zf * x) / 2.0, zz + zf * z];
        SurfaceCorner { rest, point: point - self.projector.position, by, second }
    }

    /// The footprint f grows by f′ per meter. The remainder of a wave, exp(−k²f²/8), then changes by kf·f′/4 per
    /// radian: by f′/2 or less at each derivative if kf ≤ 2. For a wave with larger kf, the largest share that counts
    /// here, e^(−k²f²/8)·(1 + kf·f′/4)⁵, is below what (1 + 2f′)⁵ allows if f′ is below 1.
    fn derivative_limits(&self, corners: &[[f64; 2]; 4]) -> DerivativeLimits {
        let (eye, [x, z]) = (self.projector.position, self.projector.heading());
        let ahead = corners.map(|rest| (rest[0] - eye.x) * x + (rest[1] - eye.z) * z);
        let ends = [
            ahead.iter().fold(f64::INFINITY, |a, b| a.min(*b)),
            ahead.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b)),
        ];
        let least = self.sea.least_footprint(self.projector, ends);
        let growth = corners.iter().map(|rest| self.sea.growth(self.projector, *rest).abs()).fold(0.0, f64::max);
        let more = libm::pow(1.0 + 2.0 * growth, 5.0);
        let [_, _, second, _, fourth, fifth] = self.sea.limits().at(least);
        DerivativeLimits { fourth: fourth * more, fifth: fifth * more, twist: second * (more - 1.0) * (more - 1.0) }
    }
}

/// Returns the point where a ray meets a sea near a point of its mesh, by Newton's method in the rest point and the
/// distance.
pub(crate) fn meet_sea(sea: &SeaSurface, projector: &Projector, ray: &Ray, near: &MeshHit) -> Option<Hit> {
    let (mut rest, mut distance) = ([near.rest.x, near.rest.z], near.distance);
    for _ in 0..STEPS {
        let SeaPoint { point, by: [by_x, by_z], precise, .. } = sea.carried(projector, rest);
        let error = point - ray.at(distance);
        let ways = DMat3::from_cols(by_x, by_z, -ray.direction);
        if error.length() <= CLOSE * (1.0 + distance.abs()) {
            let hit = || hit_of_sea(sea, projector, ray, distance, rest, &precise.sample, near.inside);
            return (distance >= 0.0).then(hit);
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
