//! Contours of height fields on grids.

use super::{DerivativeLimits, SmoothSurface, SurfaceCorner};
use crate::points::MeshHit;
use crate::surface::Hit;
use crate::{GridSurface, Projector, Ray};
use glam::DVec3;

/// Most Newton steps to the point on a ray, and the error relative to 1 m + distance at which they end.
const STEPS: usize = 16;
const CLOSE: f64 = 1e-13;

/// A height field as one camera sees it.
pub(crate) struct SeenGrid<'a> {
    pub(crate) grid: &'a GridSurface,
    pub(crate) eye: DVec3,
}

impl SmoothSurface for SeenGrid<'_> {
    fn corner(&self, rest: [f64; 2]) -> SurfaceCorner {
        let rest = self.grid.within_reach(rest);
        let ([height, by_x, by_z], twist) = self.grid.twisted(rest);
        let point = DVec3::new(rest[0], self.grid.level() + height, rest[1]) - self.eye;
        let by = [DVec3::new(1.0, by_x, 0.0), DVec3::new(0.0, by_z, 1.0)];
        // Cells run along the axes, so the other second derivatives do not matter.
        SurfaceCorner { rest, point, by, second: [DVec3::ZERO, DVec3::new(0.0, twist, 0.0), DVec3::ZERO] }
    }

    /// Vertices are placed so that every cell of the mesh lies in a single cell of the grid, where the field is
    /// bicubic.
    fn derivative_limits(&self, _corners: &[[f64; 2]; 4]) -> DerivativeLimits {
        DerivativeLimits::default()
    }
}

/// Returns the point where a ray meets a height field near a point of its mesh, by Newton's method along the ray.
pub(crate) fn meet_grid(grid: &GridSurface, projector: &Projector, ray: &Ray, near: &MeshHit) -> Option<Hit> {
    let mut distance = near.distance;
    for _ in 0..STEPS {
        let point = ray.at(distance);
        let place = grid.within_reach([point.x, point.z]);
        let [height, by_x, by_z] = grid.height(place[0], place[1])?;
        let gap = point.y - grid.level() - height;
        if gap.abs() <= CLOSE * (1.0 + distance.abs() + height.abs()) {
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
