//! Determines where it is certain what a camera sees, and what it sees there.
//!
//! A mesh approximates a surface. If each of its points is moved to the corresponding point of the surface, a sample
//! keeps seeing the same sheet all the way, unless a contour passes over the sample: a line where a sheet turns away
//! from the camera or ends, or where two sheets change places. Therefore every position where the mesh, the surface
//! or anything between them may have a contour is covered with boxes ([`ContourBox`]). Consider a sample that lies
//! outside of all boxes that are nearer than the sheet it sees, and where the surfaces of the nearest sheets lie behind
//! one another in the order of the sheets: its ray meets the visible surface near the point where it meets the mesh.
//! That point is found in f64.

mod cells;
mod contours;
mod facets;
mod grid;
mod sea;

pub(crate) use cells::{DerivativeLimits, SmoothSurface, SurfaceCorner, contours_of_grid};
pub use contours::Search;
pub(crate) use facets::contours_of_facets;
pub(crate) use grid::{SeenGrid, meet_grid};
pub(crate) use sea::{SeenSea, meet_sea};

use crate::channel::FINE;
use crate::points::{APART, around};
use crate::sheets::{Sheet, Sheets};
use crate::surface::{Hit, Surface};
use crate::{Camera, Projector, Visible};
use contours::{ContourBox, Marks};
use trochoid_image::Format;

/// What a sample of the continuous surfaces sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sight {
    /// It is not certain.
    Unclear,
    /// No surface.
    Nothing,
    /// A point of a surface.
    Point(Hit),
}

/// The contours of a view, and what its samples certainly see.
///
/// ```
/// use trochoid_image::Format;
/// use trochoid_scene::{Camera, Certain, DVec3, Projection, SeaSurface, Sight};
/// use trochoid_sea::{GerstnerSpectrum, Sea};
///
/// let sea = Sea::new(GerstnerSpectrum { count: 20, ..GerstnerSpectrum::default() }.waves()?);
/// let surface = SeaSurface::new(&sea, 0.0, 0.0);
/// let camera = Camera {
///     position: DVec3::new(0.0, 6.0, 30.0),
///     target: DVec3::new(0.0, 2.0, 0.0),
///     roll: 0.0,
///     projection: Projection::Perspective { fov: 0.7 },
/// };
/// let format = Format::new(64, 36, 1)?;
/// let certain = Certain::new(&camera, &[&surface], format, &|| false).ok_or("stopped")?;
/// let low = [32, 35];
/// let sights = certain.sights(&[&surface], &[low], format.sample_offset(0));
/// assert!(matches!(sights[0], Sight::Point(hit) if hit.distance < 60.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Certain {
    /// Finer meshes than those of a picture, with normals and rest points.
    visible: Visible,
    marks: Marks,
}

impl Certain {
    /// Searches for all contours of a view of these surfaces, which may take several times as long as the view
    /// itself; `None` soon after `stop` first says that the result is no longer needed.
    pub fn new(
        camera: &Camera,
        surfaces: &[&dyn Surface],
        format: Format,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let finely = |surface: &dyn Surface, projector: &Projector| surface.tessellate_finely(projector, stop);
        let visible = Visible::of_meshes(camera.projector(format), surfaces, format, FINE, finely)?;
        let search = Search::new(&visible, APART, stop);
        for (surface, layer) in surfaces.iter().zip(&visible.layers) {
            if !surface.contours(&search, &layer.mesh) {
                search.mark(&ContourBox::everywhere(&visible.projector));
            }
        }
        let marks = search.marks();
        (!stop()).then_some(Self { visible, marks })
    }

    /// Returns what a sample of each of these pixels sees, at `offset` from its pixel's upper left corner.
    pub fn sights(&self, surfaces: &[&dyn Surface], pixels: &[[i64; 2]], offset: [f64; 2]) -> Vec<Sight> {
        let visible = &self.visible;
        let sheets = visible.nearest_sheets(around(pixels), offset);
        let offset = visible.on_raster(offset);
        let sight = |&[x, y]: &[i64; 2]| {
            let place = [x as f64 + offset[0], y as f64 + offset[1]];
            self.sight(surfaces, place, sheets.at([x, y]))
        };
        pixels.iter().map(sight).collect()
    }

    fn sight(&self, surfaces: &[&dyn Surface], place: [f64; 2], sheets: Sheets) -> Sight {
        let visible = &self.visible;
        let depth = |sheet: &Option<Sheet>| sheet.map_or(f64::INFINITY, |sheet| sheet.depth(&visible.projector));
        let [first, second] = [depth(&sheets[0]), depth(&sheets[1])];
        if self.marks.cover(place, first) {
            return Sight::Unclear;
        }
        let Some(sheet) = &sheets[0] else { return Sight::Nothing };
        let ray = visible.projector.ray(place[0], place[1]);
        let Some(hit) = visible.meet(surfaces, &ray, sheet) else { return Sight::Unclear };
        let off = (hit.depth - first).abs();
        if off > (APART * first.abs()).min((hit.depth - second).abs()) || self.marks.cover(place, hit.depth) {
            return Sight::Unclear;
        }
        // The surfaces of the sheets behind must lie behind too. A surface that is not found is within its contours,
        // which would be marked if they were near.
        let is_behind = |sheet: &Sheet| {
            let apart = sheet.depth(&visible.projector) - first > APART * first.abs();
            let met = visible.meet(surfaces, &ray, sheet);
            met.map_or(apart, |other| other.distance > hit.distance * (1.0 + 1e-9))
        };
        if sheets[1..].iter().flatten().all(is_behind) { Sight::Point(hit) } else { Sight::Unclear }
    }
}
