//! Points where rays meet surfaces near points of their meshes, by Newton's method.

use crate::grid_values::Number;
use crate::points::MeshHit;
use crate::reference::hit_of_sea;
use crate::sea_point::SeaPoint;
use crate::surface::{Hit, Met};
use crate::{GridSurface, Projector, Ray, SeaSurface};
use glam::{DMat3, DVec3};
use trochoid_sea::Precise;

/// Most steps to a point of a sea, and the error relative to 1 m + distance at which they end.
const SEA_STEPS: usize = 12;
const SEA_CLOSE: f64 = 1e-12;
/// Most steps to a point of a height field, and the error relative to 1 m + distance at which they end.
const GRID_STEPS: usize = 16;
const GRID_CLOSE: f64 = 1e-13;

/// Returns the point where a ray meets a sea near a point of its mesh, by Newton's method in the rest point and the
/// distance.
pub(crate) fn meet_sea(sea: &SeaSurface, projector: &Projector, ray: &Ray, near: &MeshHit) -> Option<Hit> {
    let mut at = Step::from(near);
    for _ in 0..SEA_STEPS {
        match at.on(sea, projector, ray)? {
            Ok(precise) => {
                let hit = || hit_of_sea(sea, projector, ray, at.distance, at.rest, &precise.sample, near.inside);
                return (at.distance >= 0.0).then(hit);
            }
            Err(next) => at = next,
        }
    }
    None
}

/// Returns whether the same steps lead to the point that a ray meets: they do if they reach its sheet.
pub(crate) fn leads_to(sea: &SeaSurface, projector: &Projector, ray: &Ray, near: &MeshHit, met: &Met) -> bool {
    let mut at = Step::from(near);
    for _ in 0..SEA_STEPS {
        if met.holds(DVec3::new(at.rest[0], sea.level, at.rest[1])) {
            return true;
        }
        match at.on(sea, projector, ray) {
            Some(Ok(_)) => return met.is_at(at.distance),
            Some(Err(next)) => at = next,
            None => return false,
        }
    }
    false
}

/// A rest point of a sea and a distance along a ray, on the way to where both are one.
#[derive(Clone, Copy)]
struct Step {
    rest: [f64; 2],
    distance: f64,
}

impl Step {
    fn from(near: &MeshHit) -> Self {
        Self { rest: [near.rest.x, near.rest.z], distance: near.distance }
    }

    /// Returns the sea at the rest point if it has arrived, otherwise the next step, if there is one.
    fn on(self, sea: &SeaSurface, projector: &Projector, ray: &Ray) -> Option<Result<Precise, Self>> {
        let Self { rest, distance } = self;
        let SeaPoint { point, by: [by_x, by_z], precise, .. } = sea.carried(projector, rest);
        let error = point - ray.at(distance);
        if error.length() <= SEA_CLOSE * (1.0 + distance.abs()) {
            return Some(Ok(precise));
        }
        let step = DMat3::from_cols(by_x, by_z, -ray.direction).inverse() * error;
        let next = Self { rest: [rest[0] - step.x, rest[1] - step.y], distance: distance - step.z };
        step.is_finite().then_some(Err(next))
    }
}

/// Returns the point where a ray meets a height field near a point of its mesh, by Newton's method along the ray.
pub(crate) fn meet_grid<T: Number>(
    grid: &GridSurface<T>,
    projector: &Projector,
    ray: &Ray,
    near: &MeshHit,
) -> Option<Hit> {
    let mut distance = near.distance;
    for _ in 0..GRID_STEPS {
        let point = ray.at(distance);
        let place = grid.within_reach([point.x, point.z]);
        let [height, by_x, by_z] = grid.height(place[0], place[1])?;
        let gap = point.y - grid.level() - height;
        if gap.abs() <= GRID_CLOSE * (1.0 + distance.abs() + height.abs()) {
            // A position outside of the grid by more than rounding is not on its surface.
            let beside = libm::hypot(point.x - place[0], point.z - place[1]);
            let is_on_grid = distance >= 0.0 && beside <= 1e-9 * (1.0 + distance);
            return is_on_grid.then(|| grid.hit(projector, ray, distance, place, near.inside));
        }
        let closing = ray.direction.y - by_x * ray.direction.x - by_z * ray.direction.z;
        if closing == 0.0 {
            return None;
        }
        distance -= gap / closing;
        if !distance.is_finite() {
            return None;
        }
    }
    None
}
