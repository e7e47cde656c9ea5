//! Obstacles for rays that do not start at the camera: surfaces as triangles in a bounding volume hierarchy.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::surface::{GivenUp, Mesh, Topology};
use crate::{ChannelSet, Projector, Ray, Surface};

/// Number of triangles in a leaf, and of children of a box.
const LEAF: usize = 8;
const CHILDREN: usize = 4;
/// Most boxes on the stack: on each level of a tree of 2³² leaves, all children but one.
const STACK: usize = 3 * 17 + 1;
/// Distance by which a ray may miss a triangle's edge, relative to the triangle, so that no ray slips through between
/// two triangles.
const EDGE: f32 = 1e-5;
/// Relative rounding error of the end of a ray's segment within a box.
const SLACK: f32 = 1e-6;

/// Surfaces as tessellated for a camera, ready for intersection with rays from anywhere.
///
/// Rays only meet what the camera may see; nothing outside of its picture blocks a ray. Widen the picture
/// ([`surroundings`]) to take more into account.
///
/// ```
/// use trochoid_image::Format;
/// use trochoid_scene::{Camera, DVec3, Obstacles, Projection, Ray, SeaSurface, Surface};
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
/// let met = obstacles.first(&down, 10.0).unwrap();
/// assert!((met - 2.0).abs() < 1e-5);
/// assert_eq!(obstacles.first(&down, 1.0), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Obstacles {
    /// Origin of the positions.
    origin: DVec3,
    positions: Vec<Vec3>,
    /// Triangles, sorted so that neighbors in space are neighbors in the list.
    triangles: Vec<[u32; 3]>,
    /// Boxes of leaves, then of each level above, up to the root, and the start of each level.
    boxes: Vec<[Vec3; 2]>,
    levels: Vec<usize>,
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
    /// The surfaces have 2³² vertices or more in total.
    pub fn new(projector: &Projector, surfaces: &[&dyn Surface]) -> Self {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for surface in surfaces {
            let mesh = surface.tessellate(projector, ChannelSet::EMPTY);
            let first = u32::try_from(positions.len()).expect("fewer than 2³² vertices");
            positions.extend(mesh.positions.iter().copied().map(Vec3::from));
            assert!(u32::try_from(positions.len()).is_ok(), "fewer than 2³² vertices");
            let ordered = in_order(&mesh);
            triangles.extend(ordered.into_iter().map(|triangle| triangle.map(|vertex| vertex + first)));
        }
        let (boxes, levels) = boxes(&positions, &triangles);
        Self { origin: projector.position, positions, triangles, boxes, levels }
    }

    /// Returns the distance to the first point along a ray, within `limit`.
    pub fn first(&self, ray: &Ray, limit: f64) -> Option<f64> {
        self.meet::<false>(ray, limit)
    }

    /// Returns whether there is any point along a ray within `limit`.
    pub fn blocks(&self, ray: &Ray, limit: f64) -> bool {
        self.meet::<true>(ray, limit).is_some()
    }

    /// Returns the number of bytes held.
    pub fn bytes(&self) -> usize {
        self.positions.len() * 12 + self.triangles.len() * 12 + self.boxes.len() * 24
    }

    fn meet<const ANY: bool>(&self, ray: &Ray, limit: f64) -> Option<f64> {
        if self.triangles.is_empty() {
            return None;
        }
        let origin = (ray.origin - self.origin).as_vec3();
        let direction = ray.direction.as_vec3();
        // A component of 0 would compute 0·∞ for a box that starts at the ray's origin.
        let inverse = direction.map(|part| if part.abs() < 1e-18 { 1e18 } else { 1.0 / part });
        let mut nearest = limit as f32;
        let mut found = None;
        let mut stack = [(0.0_f32, 0_u32, 0_u32); STACK];
        let top = self.levels.len() - 1;
        let mut waiting = 0;
        if let Some(near) = within(&self.boxes[self.levels[top]], origin, inverse, nearest) {
            stack[0] = (near, top as u32, 0);
            waiting = 1;
        }
        while waiting > 0 {
            waiting -= 1;
            let (near, level, index) = stack[waiting];
            if near > nearest {
                continue;
            }
            if level == 0 {
                let start = index as usize * LEAF;
                for triangle in &self.triangles[start..(start + LEAF).min(self.triangles.len())] {
                    let corners = triangle.map(|vertex| self.positions[vertex as usize]);
                    if let Some(distance) = pierce(corners, origin, direction).filter(|distance| *distance <= nearest) {
                        (nearest, found) = (distance, Some(distance));
                        if ANY {
                            return Some(f64::from(distance));
                        }
                    }
                }
                continue;
            }
            let below = level as usize - 1;
            let (start, first) = (self.levels[below], index as usize * CHILDREN);
            let last = (first + CHILDREN).min(self.levels[below + 1] - start);
            let base = waiting;
            for child in first..last {
                let Some(near) = within(&self.boxes[start + child], origin, inverse, nearest) else { continue };
                // The nearest box is visited first: it is pushed last, so it is popped first.
                let mut place = waiting;
                while place > base && stack[place - 1].0 < near {
                    stack[place] = stack[place - 1];
                    place -= 1;
                }
                stack[place] = (near, below as u32, child as u32);
                waiting += 1;
            }
        }
        found.map(f64::from)
    }
}

/// Returns where a ray enters a box, if it does so within `limit`.
#[inline]
fn within(bounds: &[Vec3; 2], origin: Vec3, inverse: Vec3, limit: f32) -> Option<f32> {
    let (a, b) = ((bounds[0] - origin) * inverse, (bounds[1] - origin) * inverse);
    let near = a.min(b).max_element().max(0.0);
    let far = a.max(b).min_element();
    let slack = SLACK * far.abs();
    (near - slack <= far + slack && near <= limit).then_some(near - slack)
}

/// Returns the distance along a ray to a triangle.
///
/// After Möller and Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997.
#[inline]
fn pierce([p, q, r]: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<f32> {
    let (a, b) = (q - p, r - p);
    let across = direction.cross(b);
    let determinant = a.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let offset = origin - p;
    let u = offset.dot(across) / determinant;
    let along = offset.cross(a);
    let v = direction.dot(along) / determinant;
    let distance = b.dot(along) / determinant;
    (u >= -EDGE && v >= -EDGE && u + v <= 1.0 + EDGE && distance >= 0.0 && distance.is_finite()).then_some(distance)
}

/// Returns the triangles of a mesh, with neighbors close to each other.
fn in_order(mesh: &Mesh) -> Vec<[u32; 3]> {
    match &mesh.topology {
        Topology::Grid { columns, rows } => {
            let (across, along) = (columns.saturating_sub(1), rows.saturating_sub(1));
            let mut triangles = Vec::with_capacity(2 * across * along);
            let side = across.max(along).next_power_of_two();
            quarters([0, 0], side, [across, along], &mut |[column, row]| {
                let corner = |right: usize, down: usize| ((row + down) * columns + column + right) as u32;
                triangles.push([corner(0, 0), corner(0, 1), corner(1, 0)]);
                triangles.push([corner(1, 0), corner(0, 1), corner(1, 1)]);
            });
            triangles
        }
        Topology::Triangles(triangles) => {
            let (low, high) = bounds(mesh.positions.iter().copied().map(Vec3::from));
            let size = (high - low).max(Vec3::splat(f32::MIN_POSITIVE));
            let mut keyed: Vec<(u32, usize)> = triangles
                .par_iter()
                .enumerate()
                .map(|(index, corners)| {
                    let sum: Vec3 = corners.iter().map(|vertex| Vec3::from(mesh.positions[*vertex as usize])).sum();
                    let place = ((sum / 3.0 - low) / size * 1023.0).to_array().map(|part| part as u32);
                    (interleaved(place), index)
                })
                .collect();
            keyed.par_sort_unstable();
            keyed.into_iter().map(|(_, index)| triangles[index]).collect()
        }
    }
}

/// Calls `visit` with the cells of a square of `side` cells that lie within `size`, quarter by quarter.
fn quarters(at: [usize; 2], side: usize, size: [usize; 2], visit: &mut impl FnMut([usize; 2])) {
    if at[0] >= size[0] || at[1] >= size[1] {
        return;
    }
    if side == 1 {
        return visit(at);
    }
    let half = side / 2;
    for (right, down) in [(0, 0), (half, 0), (0, half), (half, half)] {
        quarters([at[0] + right, at[1] + down], half, size, visit);
    }
}

/// Interleaves the bits of three numbers below 2¹⁰ (Morton order).
fn interleaved(place: [u32; 3]) -> u32 {
    (0..10)
        .flat_map(|bit| (0..3).map(move |axis| (bit, axis)))
        .fold(0, |key, (bit, axis)| key | ((place[axis] >> bit) & 1) << (3 * bit + axis))
}

fn bounds(points: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    let nothing = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    points.fold(nothing, |(low, high), point| (low.min(point), high.max(point)))
}

/// Returns the boxes of leaves and of each level above, and the start of each level.
fn boxes(positions: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<[Vec3; 2]>, Vec<usize>) {
    let mut boxes: Vec<[Vec3; 2]> = triangles
        .par_chunks(LEAF)
        .map(|leaf| {
            let (low, high) = bounds(leaf.iter().flatten().map(|vertex| positions[*vertex as usize]));
            [low, high]
        })
        .collect();
    let mut levels = vec![0];
    while boxes.len() - levels[levels.len() - 1] > 1 {
        let start = levels[levels.len() - 1];
        levels.push(boxes.len());
        let above: Vec<[Vec3; 2]> = boxes[start..]
            .chunks(CHILDREN)
            .map(|children| {
                let (low, high) = bounds(children.iter().flatten().copied());
                [low, high]
            })
            .collect();
        boxes.extend(above);
    }
    (boxes, levels)
}
