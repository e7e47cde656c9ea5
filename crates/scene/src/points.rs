//! Finds the points of surfaces themselves, near those of their meshes.

use crate::project::Layer;
use crate::sheets::{Sheet, Sheets};
use crate::surface::{Between, Hit, Surface};
use crate::{Channel, ChannelSet, Projector, Ray, Samples, Visible};
use glam::DVec3;
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// A point of a surface's mesh along a ray: where to look for the surface itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshHit {
    /// Distance along the ray, in meters.
    pub distance: f64,
    /// The point's rest point, in the world.
    pub rest: DVec3,
    /// Triangle of the mesh; `None` if it was clipped by the picture's edge or the camera.
    pub triangle: Option<usize>,
    /// Whether the camera is on the surface's inner side.
    pub inside: bool,
}

/// Precision in which sums of waves are computed at points of surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sums {
    /// In f32, sixteen points side by side.
    Single,
    /// In f64, to the last digits of the reference.
    #[default]
    Double,
}

/// How much further along a ray than its mesh a surface may lie, as a share of the depth, and still count as found.
const APART: f64 = 0.1;

impl Visible {
    /// Bytes that a thread takes for each pixel for which [`points`](Self::points) are asked: its sheets, where it meets the
    /// mesh, in lists that grow to twice what they hold out of the ones before, and the points found, first by surface.
    pub const BYTES_OF_POINT: u64 =
        (size_of::<Sheets>() + 3 * size_of::<(Ray, MeshHit)>() + 2 * size_of::<Option<Hit>>()) as u64;

    /// Returns what a sample of each of these pixels sees of the surfaces themselves, at `offset` from the pixel's
    /// upper left corner: the point where its ray meets the surface near where it meets the nearest mesh. `None` if
    /// there is no mesh, or no such point.
    ///
    /// # Panics
    /// The view was prepared without rest points, or for other surfaces.
    ///
    /// ```
    /// use trochoid_image::Format;
    /// use trochoid_scene::{Camera, ChannelSet, DVec3, Projection, SeaSurface, Sums, Visible, reference};
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
    /// let visible = Visible::prepare(&camera, &[&surface], format, ChannelSet::REST);
    /// let found = visible.points(&[&surface], &[[32, 35]], format.sample_offset(0), Sums::Double)[0].ok_or("nothing")?;
    /// let truth = reference::trace(&camera, &[&surface], format, 32.5, 35.5)?.ok_or("nothing")?;
    /// assert!((found.position - truth.position).length() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn points(
        &self,
        surfaces: &[&dyn Surface],
        pixels: &[[i64; 2]],
        offset: [f64; 2],
        sums: Sums,
    ) -> Scratch<Option<Hit>> {
        let sheets = self.nearest_sheets(around(pixels), offset);
        let shown = self.on_patches(pixels, offset);
        let offset = self.on_raster(offset);
        let mut found = Scratch::of(None, pixels.len());
        let mut mesh_hits: Scratch<Scratch<(Ray, MeshHit)>> = surfaces.iter().map(|_| Scratch::new()).collect();
        let mut places: Scratch<Scratch<usize>> = surfaces.iter().map(|_| Scratch::new()).collect();
        for (index, &[x, y]) in pixels.iter().enumerate() {
            if let Some(sheet) = sheets.at([x, y])[0] {
                let ray = self.projector.ray(x as f64 + offset[0], y as f64 + offset[1]);
                let (surface, mut near) = self.mesh_hit(&ray, &sheet);
                if let Between::Patches(_) = self.layers[surface].mesh.between {
                    let at = |channel: Channel| f64::from(shown.channel(channel)[index]);
                    (near.rest.x, near.rest.z) = (at(Channel::RestX), at(Channel::RestZ));
                    near.distance = self.distance(&ray, at(Channel::Depth));
                }
                mesh_hits[surface].push((ray, near));
                places[surface].push(index);
            }
        }
        for (surface, (mesh_hits, places)) in mesh_hits.iter().zip(&places).enumerate() {
            let hits = match sums {
                Sums::Single => surfaces[surface].follow(&self.projector, mesh_hits),
                Sums::Double => {
                    let meet = |(ray, near): &(Ray, MeshHit)| surfaces[surface].meet_near(&self.projector, ray, near);
                    mesh_hits.iter().map(meet).collect()
                }
            };
            for ((place, (ray, near)), hit) in places.iter().zip(mesh_hits).zip(&hits) {
                let depth = (ray.at(near.distance) - self.projector.position).dot(self.projector.forward);
                let hit = hit.as_ref().filter(|hit| (hit.depth - depth).abs() <= APART * depth.abs());
                found[*place] = hit.map(|hit| Hit { surface, ..*hit });
            }
        }
        found
    }

    /// Returns where samples meet the patches of meshes: rest points and depths. Nothing if no mesh has patches.
    fn on_patches(&self, pixels: &[[i64; 2]], offset: [f64; 2]) -> Samples {
        let mut shown = Samples::new();
        if !pixels.is_empty() && self.layers.iter().any(|layer| matches!(layer.mesh.between, Between::Patches(_))) {
            let wanted = ChannelSet::of(&[Channel::RestX, Channel::RestZ, Channel::Depth]);
            shown.shape(Window::new(0, 0, pixels.len() as i64, 1), wanted);
            self.look_around(around(pixels), offset, |seen| {
                self.resolve(seen.at(pixels), offset, wanted, &mut shown.targets());
            });
        }
        shown
    }

    /// Returns the distance along a ray to a planar depth, both in meters.
    fn distance(&self, ray: &Ray, depth: f64) -> f64 {
        let (start, forward) = (ray.origin - self.projector.position, self.projector.forward);
        (depth - start.dot(forward)) / ray.direction.dot(forward)
    }

    /// Returns the offset to which the raster rounds a sample's offset.
    pub(crate) fn on_raster(&self, offset: [f64; 2]) -> [f64; 2] {
        offset.map(|part| self.raster.fix(part) as f64 * self.raster.step())
    }

    /// Returns where a ray meets a sheet, and the index of the sheet's surface.
    pub(crate) fn mesh_hit(&self, ray: &Ray, sheet: &Sheet) -> (usize, MeshHit) {
        let projector = &self.projector;
        let index = self.layer(sheet.primitive());
        let layer = &self.layers[index];
        let local = (sheet.primitive() - self.firsts[index]) as usize;
        let triangle = layer.triangles(local)[sheet.part()];
        let distance = self.distance(ray, sheet.depth(projector));
        let near = MeshHit {
            distance,
            rest: rest_at(layer, triangle, projector, ray.at(distance)),
            triangle: (local < layer.primitives).then_some(local),
            inside: layer.mesh.inside,
        };
        (index, near)
    }
}

/// Returns the bounding window of these pixels.
pub(crate) fn around(pixels: &[[i64; 2]]) -> Window {
    pixels.iter().fold(Window::default(), |all, &[x, y]| all.union(Window::new(x, y, x + 1, y + 1)))
}

/// Interpolates the rest point of a triangle's point by the weights of its corners; returns the point itself if the
/// triangle was clipped.
fn rest_at(layer: &Layer, triangle: [u32; 3], projector: &Projector, point: DVec3) -> DVec3 {
    let (flat, heights) = (&layer.mesh.rests, &layer.mesh.rest_heights);
    let vertices = triangle.map(|vertex| vertex as usize);
    if vertices.iter().any(|vertex| *vertex >= flat.len()) {
        return DVec3::new(point.x, layer.mesh.level, point.z);
    }
    let [p, q, r] = vertices.map(|vertex| DVec3::from(layer.mesh.positions[vertex].map(f64::from)));
    let (a, b, to) = (q - p, r - p, point - projector.position - p);
    let normal = a.cross(b);
    let area = normal.length_squared().max(f64::MIN_POSITIVE);
    let (s, t) = (to.cross(b).dot(normal) / area, a.cross(to).dot(normal) / area);
    let blend = |values: [f64; 3]| values[0] + (values[1] - values[0]) * s + (values[2] - values[0]) * t;
    let flat = |axis: usize| blend(vertices.map(|vertex| f64::from(flat[vertex][axis])));
    let eye = projector.position;
    let height = if heights.is_empty() {
        layer.mesh.level
    } else {
        eye.y + blend(vertices.map(|vertex| f64::from(heights[vertex])))
    };
    DVec3::new(eye.x + flat(0), height, eye.z + flat(1))
}
