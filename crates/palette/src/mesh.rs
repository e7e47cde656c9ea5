//! Convex hulls of few points as meshes of triangles.

use crate::vector::{Point, cross, dot, sub};

/// Convex hull of points: its corners, and triangles that are counterclockwise as seen from outside.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub(crate) corners: Vec<Point>,
    pub(crate) triangles: Vec<[usize; 3]>,
    pub(crate) volume: f64,
}

impl Mesh {
    /// Makes the hull of points; `None` if it has no volume.
    pub(crate) fn new(points: &[Point]) -> Option<Self> {
        let (corners, triangles) = trochoid_weights::surface(points)?;
        let corners: Vec<Point> = corners.iter().map(|&index| points[index]).collect();
        let volume = volume(&corners, &triangles);
        (volume > 0.0).then_some(Self { corners, triangles, volume })
    }

    /// Returns the number of corners.
    pub(crate) fn count(&self) -> usize {
        self.corners.len()
    }

    /// Returns the pairs of corners that are joined.
    pub(crate) fn edges(&self) -> Vec<[usize; 2]> {
        let of = |triangle: &[usize; 3]| [0, 1, 2].map(|i| [triangle[i], triangle[(i + 1) % 3]]);
        // Each edge has two directions, in two triangles.
        let mut edges: Vec<[usize; 2]> = self.triangles.iter().flat_map(of).filter(|[a, b]| a < b).collect();
        edges.sort_unstable();
        edges
    }

    /// Returns the boundary of the triangles that touch some corners, as directed edges, and the volume of these
    /// triangles as seen from a point.
    pub(crate) fn link(&self, of: &[usize], from: Point) -> (Vec<[usize; 2]>, f64) {
        let touching: Vec<[usize; 3]> = self
            .triangles
            .iter()
            .filter(|triangle| triangle.iter().any(|corner| of.contains(corner)))
            .copied()
            .collect();
        let all: Vec<[usize; 2]> =
            touching.iter().flat_map(|triangle| [0, 1, 2].map(|i| [triangle[i], triangle[(i + 1) % 3]])).collect();
        let boundary = all.iter().filter(|[a, b]| !all.contains(&[*b, *a])).copied().collect();
        let seen: Vec<Point> = self.corners.iter().map(|corner| sub(*corner, from)).collect();
        (boundary, volume(&seen, &touching))
    }
}

/// Returns the volume between some triangles and the origin.
fn volume(corners: &[Point], triangles: &[[usize; 3]]) -> f64 {
    let of = |[a, b, c]: &[usize; 3]| dot(cross(corners[*a], corners[*b]), corners[*c]);
    triangles.iter().map(of).sum::<f64>() / 6.0
}
