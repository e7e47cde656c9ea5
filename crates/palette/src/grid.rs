//! Corners rounded to a grid, so that enclosing can be decided in whole numbers.

use crate::corner::{Data, growth, tangents};
use crate::program::least;
use crate::vector::{Point, dot};

/// Rounds corners to multiples of a unit, one after the other, as the colors allow; the others adapt. `None` if there is
/// no room.
pub(crate) fn snap(corners: &[Point], data: &Data, unit: f64) -> Option<Vec<Point>> {
    let count = corners.len();
    let mut points = corners.to_vec();
    let off = |point: &Point| point.iter().map(|v| (v / unit - (v / unit).round()).abs()).sum::<f64>();
    points.sort_by(|a, b| off(a).total_cmp(&off(b)));
    for fixed in 0..count {
        let halves_of = |points: &[Point], corner: usize| {
            let mesh = data.hull(points).filter(|mesh| mesh.count() == count)?;
            let own = mesh.corners.iter().position(|point| *point == points[corner])?;
            let (edges, _) = mesh.link(&[own], data.inside);
            let boundary: Vec<[Point; 2]> = edges.iter().map(|edge| edge.map(|at| mesh.corners[at])).collect();
            Some((growth(&boundary, data.inside), tangents(&boundary, data)?))
        };
        let (growth, halves) = halves_of(&points, fixed)?;
        let around = points[fixed].map(|v| (v / unit).round());
        let fits = |point: &Point| {
            point.iter().all(|v| (0.0..=255.0).contains(v))
                && halves.iter().all(|half| dot(half.normal, *point) <= half.offset + 1e-9)
        };
        let nearest = [1, 2, 4, 8].into_iter().find_map(|reach: i32| {
            let range = || (-reach..=reach).map(f64::from);
            let all = range().flat_map(|x| range().flat_map(move |y| range().map(move |z| [x, y, z])));
            let all = all.map(|by| [0, 1, 2].map(|c| unit * (around[c] + by[c]))).filter(fits);
            all.min_by(|a, b| dot(growth, *a).total_cmp(&dot(growth, *b)))
        });
        points[fixed] = nearest?;
        for free in fixed + 1..count {
            let (growth, halves) = halves_of(&points, free)?;
            if let Some(point) = least(growth, &halves) {
                points[free] = point;
            }
        }
    }
    Some(points)
}

/// Corner of a palette on a grid: whole numbers of units.
pub(crate) type Whole = [i64; 3];

/// A palette on a grid whose unit is a part of a step of 8 bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Gridded {
    pub(crate) corners: Vec<Whole>,
    /// Units in a step.
    pub(crate) units: i64,
}

impl Gridded {
    /// Rounds points, and puts the prior ones before them; `None` if these are not on the grid.
    pub(crate) fn round(points: &[Point], prior: &[Point], units: i64) -> Option<Self> {
        let whole = |v: f64| ((v * units as f64).round() as i64).clamp(0, 255 * units);
        let corners: Vec<Whole> = prior.iter().chain(points).map(|point| point.map(whole)).collect();
        let found = Self { corners, units };
        found.points().starts_with(prior).then_some(found)
    }

    /// Returns the corners in steps of 8 bits.
    pub(crate) fn points(&self) -> Vec<Point> {
        self.corners.iter().map(|corner| corner.map(|v| v as f64 / self.units as f64)).collect()
    }

    /// Returns the planes of the hull in whole numbers: normals that point inward, and corners. `None` without volume.
    fn planes(&self) -> Option<Vec<(Whole, Whole)>> {
        let (corners, triangles) = trochoid_weights::surface(&self.points())?;
        let sub = |a: Whole, b: Whole| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let plane = |triangle: &[usize; 3]| {
            let [a, b, c] = triangle.map(|corner| self.corners[corners[corner]]);
            let (u, v) = (sub(b, a), sub(c, a));
            ([u[2] * v[1] - u[1] * v[2], u[0] * v[2] - u[2] * v[0], u[1] * v[0] - u[0] * v[1]], a)
        };
        Some(triangles.iter().map(plane).collect())
    }

    /// Counts the colors, given in steps of 8 bits, that lie outside. Everything is a whole number below 2⁶³: with 256
    /// units, coordinates are below 2¹⁶, normals below 2³⁴, and sums of their products below 2⁵³.
    pub(crate) fn outside(&self, colors: impl Iterator<Item = [u8; 3]>) -> Option<u64> {
        let planes = self.planes()?;
        let is_outside = |color: &[u8; 3]| {
            let point = color.map(|v| i64::from(v) * self.units);
            let side = |(normal, at): &(Whole, Whole)| (0..3).map(|c| normal[c] * (point[c] - at[c])).sum::<i64>();
            planes.iter().any(|plane| side(plane) < 0)
        };
        Some(colors.filter(is_outside).count() as u64)
    }
}
