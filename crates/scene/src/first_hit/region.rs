//! The part of space that a camera sees of a sea's slab.

use crate::extent::HORIZON_M;
use crate::{Projector, Ray, SeaSurface};
use glam::DVec3;

/// Pixels by which the region is wider than the picture.
const MARGIN: f64 = 1.0;
/// Tolerance of vertices, relative to the coordinates.
const TOLERANCE: f64 = 1e-9;

/// Coordinates relative to a camera's position: u along its heading, height over the sea's level, v across.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    pub(super) heading: [f64; 2],
    pub(super) eye: DVec3,
    pub(super) level: f64,
}

impl Axes {
    pub(super) fn new(sea: &SeaSurface, projector: &Projector) -> Self {
        Self { heading: projector.heading(), eye: projector.position, level: sea.level }
    }

    pub(super) fn direction(&self, way: DVec3) -> DVec3 {
        let [x, z] = self.heading;
        DVec3::new(way.x * x + way.z * z, way.y, way.z * x - way.x * z)
    }

    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        self.direction(DVec3::new(point.x - self.eye.x, point.y - self.level, point.z - self.eye.z))
    }

    /// Returns the world's direction of one in these axes.
    pub(super) fn of_world(&self, way: DVec3) -> DVec3 {
        let [x, z] = self.heading;
        DVec3::new(way.x * x - way.z * z, way.y, way.x * z + way.z * x)
    }

    /// Returns the world's x and z of a rest point.
    pub(super) fn rest(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [x, z] = self.heading;
        [self.eye.x + u * x - v * z, self.eye.z + u * z + v * x]
    }
}

/// A half space: `normal`·P ≤ `limit`.
#[derive(Clone, Copy, Debug)]
struct HalfSpace {
    normal: DVec3,
    limit: f64,
}

/// What a camera sees of the slab of heights that a sea reaches: a convex polyhedron in [`Axes`].
#[derive(Clone, Debug)]
pub(super) struct Region {
    sides: Vec<HalfSpace>,
}

impl Region {
    pub(super) fn new(sea: &SeaSurface, projector: &Projector, axes: &Axes) -> Self {
        let eye = axes.point(projector.position);
        let [right, up, forward] = [projector.right, projector.up, projector.forward].map(|way| axes.direction(way));
        let mut sides = Vec::new();
        let mut add = |normal: DVec3, limit: f64| sides.push(HalfSpace { normal, limit });
        for (axis, way) in [(0, right), (0, -right), (1, up), (1, -up)] {
            let reach = (projector.size[axis] / 2.0 + MARGIN) / projector.scale;
            let (normal, most) = if projector.orthographic { (way, reach) } else { (way - forward * reach, 0.0) };
            add(normal, most + normal.dot(eye));
        }
        add(-forward, -forward.dot(eye));
        // A ray's part within the slab is a little longer because of rounding.
        let summit = sea.summit + 1e-6 * (1.0 + sea.summit + eye.y.abs());
        for (way, limit) in [(DVec3::Y, summit), (DVec3::X, HORIZON_M), (DVec3::Z, HORIZON_M)] {
            add(way, limit);
            add(-way, limit);
        }
        Self { sides }
    }

    /// Returns the range of u; `None` if the camera sees nothing of the slab.
    pub(super) fn along(&self) -> Option<[f64; 2]> {
        range(&self.sides, DVec3::X)
    }

    /// Returns the range of v between two places ahead.
    pub(super) fn across(&self, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
        let mut sides = self.sides.clone();
        sides.push(HalfSpace { normal: DVec3::X, limit: to });
        sides.push(HalfSpace { normal: -DVec3::X, limit: -from });
        range(&sides, DVec3::Z)
    }

    /// Returns whether some side has a whole box beyond it.
    pub(super) fn misses(&self, [low, high]: [DVec3; 2]) -> bool {
        self.sides.iter().any(|side| {
            let nearest = DVec3::select(side.normal.cmpge(DVec3::ZERO), low, high);
            side.normal.dot(nearest) > side.limit + TOLERANCE * (1.0 + nearest.abs().max_element())
        })
    }

    /// Returns whether a part of a ray lies in the region.
    pub(super) fn holds(&self, ray: &Ray, [start, end]: [f64; 2]) -> bool {
        [start, end].into_iter().all(|distance| {
            let point = ray.at(distance);
            let slack = TOLERANCE * (1.0 + point.abs().max_element());
            self.sides.iter().all(|side| side.normal.dot(point) <= side.limit + slack * side.normal.length())
        })
    }
}

/// Returns the least and the greatest part of a bounded polyhedron along a direction, a little widened: its vertices are
/// where three sides meet.
fn range(sides: &[HalfSpace], along: DVec3) -> Option<[f64; 2]> {
    let mut found: Option<[f64; 2]> = None;
    for (i, a) in sides.iter().enumerate() {
        for (j, b) in sides.iter().enumerate().skip(i + 1) {
            for c in &sides[j + 1..] {
                let crossed = b.normal.cross(c.normal);
                let volume = a.normal.dot(crossed);
                if volume.abs() <= 1e-14 * a.normal.length() * b.normal.length() * c.normal.length() {
                    continue;
                }
                let point =
                    (crossed * a.limit + c.normal.cross(a.normal) * b.limit + a.normal.cross(b.normal) * c.limit)
                        / volume;
                let slack = 1e3 * TOLERANCE * (1.0 + point.abs().max_element());
                if sides.iter().all(|side| side.normal.dot(point) <= side.limit + slack * side.normal.length()) {
                    let part = point.dot(along);
                    let [low, high] = found.unwrap_or([part; 2]);
                    found = Some([low.min(part), high.max(part)]);
                }
            }
        }
    }
    let widen = |[low, high]: [f64; 2]| {
        let by = 1e-6 * (1.0 + low.abs().max(high.abs()));
        [low - by, high + by]
    };
    found.map(widen)
}
