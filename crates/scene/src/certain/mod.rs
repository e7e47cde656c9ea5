//! Where it is certain what a camera sees, and what it sees there.
//!
//! A mesh stands for a surface. Move each of its points to that of the surface for which it stands: what a sample sees
//! remains on the same sheet all the way, unless a contour passes over the sample, where a sheet turns away from the
//! camera or ends, or two sheets change places. So every place is covered with boxes where the mesh, the surface or
//! anything between them may have a contour ([`Turn`]); a sample beside all boxes that are nearer than what it sees, and
//! where the surfaces of the nearest sheets lie behind one another as the sheets do, sees the surface where its ray meets it next to where it meets the mesh.
//! That point is found in f64.

mod cells;
mod facets;
mod grid;
mod sea;
mod sheets;
mod turns;

pub(crate) use cells::{Corner, Most, Smooth, contours_of_grid};
pub(crate) use facets::contours_of_facets;
pub(crate) use grid::{SeenGrid, meet_grid};
pub(crate) use sea::{SeenSea, meet_sea};
pub use turns::Search;

use crate::project::Layer;
use crate::surface::{Hit, Surface};
use crate::{ChannelSet, Projector, Ray, Visible};
use glam::DVec3;
use sheets::{Sheet, Sheets};
use trochoid_image::Window;
use turns::{Marks, Turn};

/// What a sample of the continuous surfaces sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sight {
    /// That is not certain.
    Unclear,
    /// No surface.
    Nothing,
    /// This point of a surface.
    Point(Hit),
}

/// What a mesh shows of a surface along a ray: where to look for the surface itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Distance along the ray in meters.
    pub distance: f64,
    /// The point's rest point, in the world.
    pub rest: DVec3,
    /// The triangle of the mesh, unless the picture's edge or the camera has cut it.
    pub triangle: Option<usize>,
    /// Whether the camera stands on the surface's inner side.
    pub inside: bool,
}

/// How much further a surface may lie along a ray than its mesh, as a share of the depth, and what is found still be it.
const APART: f64 = 0.02;

/// Channels that meshes need here.
const NEEDED: ChannelSet = ChannelSet::RESTS.union(ChannelSet::NORMAL);

/// All that is known of the contours of a view.
///
/// ```
/// use trochoid_image::{Format, Window};
/// use trochoid_scene::{Camera, Certain, ChannelSet, DVec3, Projection, SeaSurface, Sight, Visible};
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
/// let visible = Visible::prepare(&camera, &[&surface], format, ChannelSet::DEPTH);
/// let certain = Certain::new(&visible, &[&surface], &|| false).ok_or("stopped")?;
/// let low = [32, 35];
/// let sights = certain.sights(&visible, &[&surface], &[low], format.sample_offset(0));
/// assert!(matches!(sights[0], Sight::Point(hit) if hit.distance < 60.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Certain {
    marks: Marks,
    /// By layer: rest points of the vertices, relative to the camera; x and z, and y where it is not the level.
    rests: Vec<Rests>,
}

#[derive(Debug, Default)]
struct Rests {
    flat: Vec<[f32; 2]>,
    heights: Vec<f32>,
}

impl Certain {
    /// Looks for all contours of a view of these surfaces, which may take some times as long as the view itself; `None` soon
    /// after `stop` has first said that nobody waits for it any longer.
    pub fn new(visible: &Visible, surfaces: &[&dyn Surface], stop: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let projector = &visible.projector;
        let search = Search::new(visible, APART, stop);
        let mut rests = Vec::new();
        for surface in surfaces {
            let mesh = surface.tessellate_unless(projector, NEEDED, stop)?;
            if !surface.contours(&search, &mesh) {
                search.mark(&Turn::everywhere(projector));
            }
            rests.push(Rests { flat: mesh.rests, heights: mesh.rest_heights });
        }
        (!stop()).then(|| Self { marks: search.marks(), rests })
    }

    /// What the sample of each of these pixels sees that stands at `offset` from its pixel's upper left corner.
    pub fn sights(
        &self,
        visible: &Visible,
        surfaces: &[&dyn Surface],
        pixels: &[[i64; 2]],
        offset: [f64; 2],
    ) -> Vec<Sight> {
        let around = pixels.iter().fold(Window::default(), |all, &[x, y]| all.union(Window::new(x, y, x + 1, y + 1)));
        let sheets = visible.nearest_sheets(around, offset);
        // Where the sample stands that the raster looked at.
        let offset = offset.map(|part| visible.raster.fix(part) as f64 * visible.raster.step());
        let sight = |&[x, y]: &[i64; 2]| {
            let place = [x as f64 + offset[0], y as f64 + offset[1]];
            self.sight(visible, surfaces, place, sheets.at([x, y]))
        };
        pixels.iter().map(sight).collect()
    }

    fn sight(&self, visible: &Visible, surfaces: &[&dyn Surface], place: [f64; 2], sheets: Sheets) -> Sight {
        let depth = |sheet: &Option<Sheet>| sheet.map_or(f64::INFINITY, |sheet| sheet.depth(&visible.projector));
        let [first, second] = [depth(&sheets[0]), depth(&sheets[1])];
        if self.marks.cover(place, first) {
            return Sight::Unclear;
        }
        let Some(sheet) = &sheets[0] else { return Sight::Nothing };
        let ray = visible.projector.ray(place[0], place[1]);
        let Some(hit) = self.meet(visible, surfaces, &ray, sheet) else { return Sight::Unclear };
        let off = (hit.depth - first).abs();
        if off > (APART * first.abs()).min((hit.depth - second).abs()) || self.marks.cover(place, hit.depth) {
            return Sight::Unclear;
        }
        // The surfaces of the sheets behind must lie behind too. One that is not found lies within its contours, which would
        // be marked if they were near.
        let is_behind = |sheet: &Sheet| {
            let apart = sheet.depth(&visible.projector) - first > APART * first.abs();
            let met = self.meet(visible, surfaces, &ray, sheet);
            met.map_or(apart, |other| other.distance > hit.distance * (1.0 + 1e-9))
        };
        if sheets[1..].iter().flatten().all(is_behind) { Sight::Point(hit) } else { Sight::Unclear }
    }

    /// The point of the surface itself next to a sheet of its mesh.
    fn meet(&self, visible: &Visible, surfaces: &[&dyn Surface], ray: &Ray, sheet: &Sheet) -> Option<Hit> {
        let projector = &visible.projector;
        let index = visible.layer(sheet.primitive());
        let layer = &visible.layers[index];
        let local = (sheet.primitive() - visible.firsts[index]) as usize;
        let triangle = layer.triangles(local)[sheet.part()];
        let along = ray.direction.dot(projector.forward);
        let distance = (sheet.depth(projector) - (ray.origin - projector.position).dot(projector.forward)) / along;
        let near = Near {
            distance,
            rest: self.rests[index].at(layer, triangle, projector, ray.at(distance)),
            triangle: (local < layer.primitives).then_some(local),
            inside: layer.mesh.inside,
        };
        surfaces[index].meet_near(projector, ray, &near).map(|hit| Hit { surface: index, ..hit })
    }
}

impl Rests {
    /// The rest point of a triangle's point, by the weights of its corners; the point itself where the triangle was cut.
    fn at(&self, layer: &Layer, triangle: [u32; 3], projector: &Projector, point: DVec3) -> DVec3 {
        let vertices = triangle.map(|vertex| vertex as usize);
        if vertices.iter().any(|vertex| *vertex >= self.flat.len()) {
            return DVec3::new(point.x, layer.mesh.level, point.z);
        }
        let [p, q, r] = vertices.map(|vertex| DVec3::from(layer.mesh.positions[vertex].map(f64::from)));
        let (a, b, to) = (q - p, r - p, point - projector.position - p);
        let normal = a.cross(b);
        let area = normal.length_squared().max(f64::MIN_POSITIVE);
        let (s, t) = (to.cross(b).dot(normal) / area, a.cross(to).dot(normal) / area);
        let blend = |values: [f64; 3]| values[0] + (values[1] - values[0]) * s + (values[2] - values[0]) * t;
        let flat = |axis: usize| blend(vertices.map(|vertex| f64::from(self.flat[vertex][axis])));
        let eye = projector.position;
        let height = if self.heights.is_empty() {
            layer.mesh.level
        } else {
            eye.y + blend(vertices.map(|vertex| f64::from(self.heights[vertex])))
        };
        DVec3::new(eye.x + flat(0), height, eye.z + flat(1))
    }
}
