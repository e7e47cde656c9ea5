//! Points where rays meet surfaces near points of their meshes, by Newton's method.

use crate::grid_values::Number;
use crate::points::MeshHit;
use crate::reference::hit_of_sea;
use crate::sea_point::SeaPoint;
use crate::surface::Hit;
use crate::{GridSurface, Projector, Ray, SeaSurface};
use glam::DMat3;

/// Most steps to a point of a sea, and the error relative to 1 m + distance at which they end.
const SEA_STEPS: usize = 12;
const SEA_CLOSE: f64 = 1e-12;
/// Most steps to a point of a height field, and the error relative to 1 m + distance at which they end.
const GRID_STEPS: usize = 16;
const GRID_CLOSE: f64 = 1e-13;

/// Returns the point where a ray meets a sea near a point of its mesh, by Newton's method in the rest point and the
/// distance.
pub(crate) fn meet_sea(sea: &SeaSurface, projector: &Projector, ray: &Ray, near: &MeshHit) -> Option<Hit> {
    let (mut rest, mut distance) = ([near.rest.x, near.rest.z], near.distance);
    for _ in 0..SEA_STEPS {
        let SeaPoint { point, by: [by_x, by_z], precise, .. } = sea.carried(projector, rest);
        let error = point - ray.at(distance);
        let ways = DMat3::from_cols(by_x, by_z, -ray.direction);
        if error.length() <= SEA_CLOSE * (1.0 + distance.abs()) {
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
