//! Bounds the distance from the hull of points that exceed no plane by much.
//!
//! Near a face the distance is the excess. Beyond a sharp edge or corner it is larger: there a point may exceed every
//! plane by almost nothing. [`Nearness`] bounds the distance for each plane by a factor, so that nearly all pixels
//! that rounding has moved across a plane are judged without a search for the nearest point.
//!
//! *Proof* that the distance, as [`Hull::exit`](super::Hull::exit) finds it, is at most `factor`·e + `error` for a
//! largest excess e > 0, with both numbers of its plane. Let w be that plane, and q the projection of the point p
//! onto it. If q is inside of all planes, the distance found is e. Otherwise q is outside the hull, hence outside the
//! polygon of facet w, and its nearest point c on that polygon lies on one of the edges that the search goes through;
//! so the distance found is at most √(e² + t²), t = |q − c|. Let g be the other facet at that edge, with unit normals
//! n_w and n_g. p violates g by at most e, so q violates it by at most e·(1 − n_g·n_w). From c, which lies in plane
//! g, to q that excess grows by t·(n_g·u), where u is the direction from c to q, a unit vector in plane w:
//! - If c lies inside an edge, u is the edge's normal m within plane w, and n_g·u = n_g·m.
//! - If c is a corner, u lies between the normals m of the two edges there, no further from one of them than half
//!   their angle φ. With n_g = (n_g·m)·m + r + (a multiple of n_w), n_g·u ≥ (n_g·m)·cos(φ/2) − |r| for the edge with
//!   that normal. (In exact arithmetic r = 0.)
//!
//! The second bound is the smaller one, so t ≤ R·e with R the maximum, over both edges at each corner of the facet,
//! of (1 − n_g·n_w) / ((n_g·m)·cos(φ/2) − |r|), and the factor is √(1 + R²). Both depend only on the edge, so no
//! error is extrapolated along it. Rounding moves the corners of a facet off its plane and q off plane w, and changes
//! each excess, by a few [`EVALUATION`] of the largest coordinate, which is checked here for the corners. Divided by
//! the same denominator, this is the error. ∎
//!
//! A polygon is a solid with two faces and no height. Its sides are perpendicular to the plane, so that on the plane
//! R = 1/cos(φ/2); beyond a side, q may be off the plane by e and beyond the end of the side by e·tan(φ/2), which gives
//! the same factor √(2 + tan²(φ/2)). Segments and points are boxes without width: √3.

use std::collections::HashMap;

use super::solid::Mesh;
use super::vector::{Point, along, cross, dot, length, sub, unit};
use super::{EVALUATION, Facet};

/// Bound of the distance of points for which a plane of a hull has the largest excess.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Nearness {
    factor: f64,
    error: f64,
}

impl Nearness {
    /// No bound.
    pub(super) const NONE: Self = Self { factor: f64::INFINITY, error: 0.0 };

    /// Makes the bounds for points and segments.
    pub(super) fn of_box(planes: &[Facet], corners: &[Point], largest: f64) -> Vec<Self> {
        // The planes across directions without width, which contain all corners.
        let across = &planes[if corners.len() == 1 { 0 } else { 2 }..];
        let sound = across.iter().all(|plane| corners.iter().all(|&c| lies_in(plane, c, largest)));
        vec![Self::bounded(3.0, 1.0, sound, largest); planes.len()]
    }

    /// Makes the bounds for polygons, given by the half-spaces of the plane, those of the sides, and the corners in
    /// order.
    pub(super) fn of_polygon(planes: &[Facet], corners: &[Point], largest: f64) -> Vec<Self> {
        let (faces, sides) = planes.split_at(2);
        let count = corners.len();
        let mut flat = faces.iter().all(|plane| corners.iter().all(|&c| lies_in(plane, c, largest)));
        let mut least: f64 = 1.0;
        for (i, side) in sides.iter().enumerate() {
            let next = (i + 1) % count;
            flat &= lies_in(side, corners[i], largest) && lies_in(side, corners[next], largest);
            least = least.min(length(along(side.normal, 1.0, sides[next].normal)) / 2.0);
        }
        vec![Self::bounded(1.0 + 1.0 / (least * least), least, flat && sides.len() == count, largest); planes.len()]
    }

    /// Makes the bounds for solids.
    pub(super) fn of_solid(mesh: &Mesh, planes: &[Facet], points: &[Point], largest: f64) -> Vec<Self> {
        let none = || vec![Self::NONE; planes.len()];
        let sides =
            |&(corners, facet): &([u32; 3], u32)| (0..3).map(move |i| (corners[i], corners[(i + 1) % 3], facet));
        let owner: HashMap<(u32, u32), u32> =
            mesh.triangles.iter().flat_map(sides).map(|(from, to, facet)| ((from, to), facet)).collect();
        // The boundary of each facet: the next corner after a corner, and the facet across that edge.
        let mut onward: HashMap<(u32, u32), (u32, u32)> = HashMap::with_capacity(2 * mesh.edges.len());
        for (from, to, facet) in mesh.triangles.iter().flat_map(sides) {
            match owner.get(&(to, from)) {
                Some(&other) if other != facet => drop(onward.insert((facet, from), (to, other))),
                Some(_) => {}
                None => return none(),
            }
        }
        // The largest ratio, the smallest slope, and whether the facet satisfies the assumptions of the proof.
        let mut found = vec![(0.0_f64, 1.0_f64, true); planes.len()];
        for (&(facet, from), &(at, before)) in &onward {
            let Some(&(to, after)) = onward.get(&(facet, at)) else {
                return none();
            };
            let plane = &planes[facet as usize];
            let (ratio, least, sound) = &mut found[facet as usize];
            let [from, at, to] = [from, at, to].map(|v| points[v as usize]);
            let outward = |a: Point, b: Point| unit(cross(sub(b, a), plane.normal));
            let normals = [outward(from, at), outward(at, to)];
            *sound &= lies_in(plane, at, largest) && dot(cross(normals[0], normals[1]), plane.normal) > -1e-9;
            let half = length(along(normals[0], 1.0, normals[1])) / 2.0;
            for (normal, other) in normals.into_iter().zip([before, after]) {
                let across = planes[other as usize].normal;
                let (rise, turn) = (dot(across, normal), dot(across, plane.normal));
                let rest = along(along(across, -rise, normal), -turn, plane.normal);
                let slope = rise * half - length(rest);
                *sound &= slope > 0.0;
                *ratio = ratio.max((1.0 - turn) / slope);
                *least = least.min(slope);
            }
        }
        found
            .into_iter()
            .map(|(ratio, least, sound)| Self::bounded(1.0 + ratio * ratio, least, sound, largest))
            .collect()
    }

    fn bounded(square: f64, slope: f64, sound: bool, largest: f64) -> Self {
        // Six errors of up to one evaluation each affect t.
        let error = 16.0 * EVALUATION * largest / slope;
        // `excess` allows for the rounding of the factor itself.
        if sound && square.is_finite() && error.is_finite() {
            Self { factor: square.sqrt(), error }
        } else {
            Self::NONE
        }
    }

    /// Returns a bound that holds for all planes.
    pub(super) fn of_worst(of_planes: &[Self]) -> Self {
        let worse = |a: Self, b: &Self| Self { factor: a.factor.max(b.factor), error: a.error.max(b.error) };
        of_planes.iter().fold(Self { factor: 1.0, error: 0.0 }, worse)
    }

    /// Returns an excess up to which the distance is certainly within the margin; 0 if none is known.
    pub(super) fn excess(&self, margin: f64, largest: f64) -> f64 {
        // The error of the search for the nearest point on an edge is less than a hundred roundings.
        let left = margin - self.error - 16.0 * EVALUATION * largest;
        // `max` replaces the NaN of an infinite margin without a bound with 0.
        (left / self.factor * (1.0 - 1e-6)).max(0.0)
    }
}

/// Whether a corner is in a plane, within 6 roundings of the largest coordinate. A projection that is rejected by the
/// 16 of [`EVALUATION`] is then still outside of the polygon.
fn lies_in(plane: &Facet, corner: Point, largest: f64) -> bool {
    plane.excess(corner) >= -6.0 * f64::EPSILON * largest
}
