//! Convex hulls of few points as meshes of triangles. Some of the corners may be prior ones, which nothing moves.

use crate::vector::{Point, cross, dot, sub};

/// Convex hull of points: its corners, and triangles that are counterclockwise as seen from outside.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub(crate) corners: Vec<Point>,
    pub(crate) triangles: Vec<[usize; 3]>,
    pub(crate) volume: f64,
    /// For each corner, whether it is none of the prior ones.
    pub(crate) is_own: Vec<bool>,
}

impl Mesh {
    /// Makes the hull of points and of prior ones; `None` if it has no volume.
    pub(crate) fn new(points: &[Point], prior: &[Point]) -> Option<Self> {
        let all = [prior, points].concat();
        let (indices, triangles) = trochoid_weights::surface(&all)?;
        let corners: Vec<Point> = indices.iter().map(|&index| all[index]).collect();
        let volume = volume(&corners, &triangles);
        let is_own = indices.iter().map(|index| *index >= prior.len()).collect();
        (volume > 0.0).then_some(Self { corners, triangles, volume, is_own })
    }

    /// Returns the number of corners beside the prior ones.
    pub(crate) fn count(&self) -> usize {
        self.is_own.iter().filter(|own| **own).count()
    }

    /// Returns the corners beside the prior ones.
    pub(crate) fn own(&self) -> Vec<Point> {
        self.corners.iter().zip(&self.is_own).filter(|(_, own)| **own).map(|(corner, _)| *corner).collect()
    }

    /// Returns the own corners without some.
    pub(crate) fn without(&self, left_out: &[usize]) -> Vec<Point> {
        let kept = (0..self.corners.len()).filter(|index| self.is_own[*index] && !left_out.contains(index));
        kept.map(|index| self.corners[index]).collect()
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
