//! Obstacles for rays that do not start at the camera: surfaces as triangles in a tree, which packets of rays walk through.

mod beam;
mod bounds;
mod facets;
mod halves;
mod packet;
mod tree;
mod walk;

use crate::surface::GivenUp;
use crate::{Projector, Ray, Surface};
use facets::Facets;
use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;
use packet::{Packet, RAYS};
use tree::Tree;
use trochoid_memory::Scratch;

/// Surfaces as tessellated for a camera, ready for intersection with rays from anywhere.
///
/// Rays are answered in packets: those that follow one another in a list should be close to each other. An answer
/// depends on its own ray alone, down to the last bit. A ray meets a triangle if it passes within 1e-5 of its size, in
/// f32, and enters its box, which is slightly larger than the triangle; it meets it where it passes the plane, but not
/// before it enters the box. It meets the surfaces at the least of these distances.
///
/// *That the tree, and the other rays of a packet, change nothing:* Rounded differences, products, minima and maxima are
/// monotone, so that a ray never enters a box before, or without, entering the boxes around it. What is beyond a
/// distance already found, or not entered, is therefore not met either.
///
/// Rays only meet what the camera may see; nothing outside of its picture blocks a ray. Widen the picture
/// ([`surroundings`]) to take more into account.
///
/// ```
/// use trochoid_image::Format;
/// use trochoid_scene::{Camera, DVec3, Obstacles, Projection, Ray, SeaSurface, Segment, Surface};
/// use trochoid_sea::Sea;
///
/// let sea = SeaSurface::new(&Sea::new(Vec::new()), 0.0, 0.0);
/// let camera = Camera {
///     position: DVec3::new(0.0, 6.0, 30.0),
///     target: DVec3::ZERO,
///     roll: 0.0,
///     projection: Projection::Perspective { fov: 0.7 },
/// };
/// let obstacles = Obstacles::new(&camera.projector(Format::new(64, 36, 1)?), &[&sea as &dyn Surface]);
/// let down = Ray { origin: DVec3::new(0.0, 2.0, 0.0), direction: DVec3::NEG_Y };
/// let found = obstacles.first(&[Segment { ray: down, limit: 10.0 }, Segment { ray: down, limit: 1.0 }]);
/// assert!((found[0].unwrap() - 2.0).abs() < 1e-5);
/// assert_eq!(found[1], None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Obstacles {
    /// Origin of the positions.
    origin: DVec3,
    facets: Facets,
    tree: Tree,
}

/// A ray up to a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// The ray.
    pub ray: Ray,
    /// Distance beyond which nothing is met, in meters.
    pub limit: f64,
}

/// Returns a camera's projector for a picture that is enlarged on each side by the share `beyond` of its size, with
/// pixels as large as `detail` of the original pixels.
pub fn surroundings(projector: &Projector, beyond: f64, detail: f64) -> Projector {
    let size = projector.size.map(|side| side * (1.0 + 2.0 * beyond) / detail);
    Projector { scale: projector.scale / detail, size, ..*projector }
}

/// Returns the distance to the first point of the continuous surfaces along a ray within `limit`, in f64.
///
/// # Errors
/// A surface is too rough along the ray.
pub fn first_reference(
    projector: &Projector,
    surfaces: &[&dyn Surface],
    ray: &Ray,
    limit: f64,
) -> Result<Option<f64>, GivenUp> {
    let (mut nearest, mut end) = (None, limit.next_up());
    for surface in surfaces {
        if let Some(hit) = surface.trace(projector, ray, end)? {
            (nearest, end) = (Some(hit.distance), hit.distance);
        }
    }
    Ok(nearest)
}

impl Obstacles {
    /// Tessellates surfaces for a camera.
    ///
    /// # Panics
    /// The surfaces have 2³² vertices, or 2³⁰ triangles, or more in total.
    pub fn new(projector: &Projector, surfaces: &[&dyn Surface]) -> Self {
        let (facets, parts) = Facets::of(projector, surfaces);
        let tree = Tree::new(&facets, parts);
        Self { origin: projector.position, facets, tree }
    }

    /// Returns the distance to the first point along each ray, if there is one within its limit.
    pub fn first(&self, segments: &[Segment]) -> Scratch<Option<f64>> {
        self.answers::<false, _>(Level::new(), segments, |distance| distance.map(f64::from))
    }

    /// Returns whether there is any point along each ray within its limit.
    pub fn blocks(&self, segments: &[Segment]) -> Scratch<bool> {
        self.answers::<true, _>(Level::new(), segments, |distance| distance.is_some())
    }

    /// Returns the origin of the corners, and the corners of the triangles, for tests.
    pub(crate) fn triangles(&self) -> (DVec3, Vec<[[f32; 3]; 3]>) {
        let triangles = 0..self.facets.triangles.len() as u32;
        (self.origin, triangles.map(|index| self.facets.corners(index).map(|corner| corner.to_array())).collect())
    }

    /// Returns what the two methods above do, with the slowest instructions, for tests.
    pub(crate) fn slowly(&self, segments: &[Segment]) -> Vec<(Option<f64>, bool)> {
        let level = Level::baseline();
        let first = self.answers::<false, _>(level, segments, |distance| distance.map(f64::from));
        let any = self.answers::<true, _>(level, segments, |distance| distance.is_some());
        first.iter().copied().zip(any.iter().copied()).collect()
    }

    /// Returns the number of bytes held.
    pub fn bytes(&self) -> usize {
        let Facets { positions, triangles } = &self.facets;
        size_of_val(&positions[..]) + size_of_val(&triangles[..]) + size_of_val(&self.tree.nodes[..])
    }

    /// Returns what `answer` says about the distance at which each ray meets the surfaces: if `ANY`, of any of their
    /// points, otherwise of the first.
    fn answers<const ANY: bool, T>(
        &self,
        level: Level,
        segments: &[Segment],
        answer: impl Fn(Option<f32>) -> T,
    ) -> Scratch<T> {
        let mut answers = Scratch::new();
        let mut waiting = Scratch::new();
        dispatch!(level, simd => simd.vectorize(
            #[inline(always)]
            || for segments in segments.chunks(RAYS) {
                let mut packet = Packet::new(segments, self.origin);
                let tree = (&self.facets, &self.tree);
                let found = walk::walk::<_, ANY>(simd, tree, (&mut packet, segments.len()), &mut waiting);
                for (lane, distance) in packet.nearest.iter().enumerate().take(segments.len()) {
                    answers.push(answer((found >> lane & 1 == 1).then_some(*distance)));
                }
            }
        ));
        answers
    }
}
