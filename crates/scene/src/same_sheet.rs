//! Finds out whether meshes show the same parts of surfaces as the surfaces themselves.

use crate::Visible;
use crate::points::around;
use crate::surface::{Sight, Surface};

/// Largest distance of a point that steps from the mesh lead to from the first point of the ray, relative to 1 m +
/// distance, if they are one.
const SAME: f64 = 1e-6;

impl Visible {
    /// Returns for each sample whether the mesh shows what its ray certainly meets: nothing, or a point of the same sheet of
    /// the same surface. `sights` are those of these pixels at the same `offset`
    /// ([`Certain::sights`](crate::Certain::sights)).
    ///
    /// The sheet is the same if the mesh's rest point lies in the rectangle that the ray meets only once, or if steps from
    /// it toward the surface lead to the ray's point.
    ///
    /// # Panics
    /// The view was prepared without rest points, or for other surfaces.
    pub fn same_sheets(
        &self,
        surfaces: &[&dyn Surface],
        pixels: &[[i64; 2]],
        offset: [f64; 2],
        sights: &[Sight],
    ) -> Vec<bool> {
        let sheets = self.nearest_sheets(around(pixels), offset);
        let offset = self.on_raster(offset);
        let is_same = |(&[x, y], sight): (&[i64; 2], &Sight)| {
            let (hit, alone, shown) = match (sight, sheets.at([x, y])[0]) {
                (Sight::Nothing, shown) => return shown.is_none(),
                (Sight::Unclear, _) | (Sight::Point(..), None) => return false,
                (Sight::Point(hit, alone), Some(shown)) => (hit, alone, shown),
            };
            let ray = self.projector.ray(x as f64 + offset[0], y as f64 + offset[1]);
            let (surface, near) = self.mesh_hit(&ray, &shown);
            if surface != hit.surface {
                return false;
            }
            if alone.is_some_and(|alone| alone.holds([near.rest.x, near.rest.z])) {
                return true;
            }
            let led = surfaces[surface].meet_near(&self.projector, &ray, &near);
            led.is_some_and(|led| (led.distance - hit.distance).abs() <= SAME * (1.0 + hit.distance))
        };
        pixels.iter().zip(sights).map(is_same).collect()
    }
}
