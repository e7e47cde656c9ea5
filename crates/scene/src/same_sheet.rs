//! Finds out whether meshes show the same parts of surfaces as the surfaces themselves.

use crate::Visible;
use crate::points::around;
use crate::surface::{Sight, Surface};

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
            let (met, shown) = match (sight, sheets.at([x, y])[0]) {
                (Sight::Nothing, shown) => return shown.is_none(),
                (Sight::Unclear, _) | (Sight::Point(..), None) => return false,
                (Sight::Point(met), Some(shown)) => (met, shown),
            };
            let ray = self.projector.ray(x as f64 + offset[0], y as f64 + offset[1]);
            let (surface, near) = self.mesh_hit(&ray, &shown);
            surface == met.hit.surface && surfaces[surface].leads_to(&self.projector, &ray, &near, met)
        };
        pixels.iter().zip(sights).map(is_same).collect()
    }
}
