//! Contours of surfaces given by their triangles.

use super::{ContourBox, Search};
use crate::surface::{Mesh, Topology};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Size in pixels of the boxes into which triangles are cut, and most cuts.
const FINE: f64 = 1.0 / 16.0;
const CUTS: u32 = 24;

/// Marks the contours of triangles that represent a surface within their tolerance. If the surface is `curved`, its
/// normals are those of the vertices: within a triangle they are assumed to turn by at most twice the largest
/// difference between a vertex normal and the triangle's own normal.
pub(crate) fn contours_of_facets(mesh: &Mesh, search: &Search<'_>, curved: bool) -> bool {
    let Some(pixels) = mesh.tolerance else { return false };
    let projector = search.projector;
    let Topology::Triangles(triangles) = &mesh.topology else { return false };
    let point = |vertex: u32| DVec3::from(mesh.positions[vertex as usize].map(f64::from));
    let ray = |point: DVec3| if projector.orthographic { projector.forward } else { point };
    let is_outer = |triangle: &[u32; 3]| {
        let [p, q, r] = triangle.map(point);
        (q - p).cross(r - p).dot(ray(p)) < 0.0
    };
    let outer: Vec<bool> = triangles.par_iter().map(is_outer).collect();
    // Vertices at one position count as one.
    let mut places = HashMap::with_capacity(mesh.positions.len());
    let same: Vec<u32> = (0..)
        .zip(&mesh.positions)
        .map(|(vertex, position)| *places.entry(position.map(|part| (part + 0.0).to_bits())).or_insert(vertex))
        .collect();
    let mut edges: HashMap<[u32; 2], Vec<bool>> = HashMap::with_capacity(2 * triangles.len());
    for (triangle, outer) in triangles.iter().zip(&outer) {
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let mut ends = [same[triangle[from] as usize], same[triangle[to] as usize]];
            if ends[0] != ends[1] {
                ends.sort_unstable();
                edges.entry(ends).or_default().push(*outer);
            }
        }
    }
    let turns_at = |(_, sides): &(&[u32; 2], &Vec<bool>)| sides.len() != 2 || sides[0] != sides[1];
    let mut pieces: Vec<[DVec3; 3]> =
        edges.iter().filter(turns_at).map(|([a, b], _)| [point(*a), point(*b), point(*b)]).collect();
    if curved {
        let turns = |(triangle, outer): &(&[u32; 3], &bool)| {
            let [p, q, r] = triangle.map(point);
            let own = (q - p).cross(r - p).normalize_or_zero();
            let normals = triangle.map(|vertex| DVec3::from(mesh.normals[vertex as usize].map(f64::from)));
            let differ = normals.iter().map(|normal| (*normal - own).length()).fold(0.0, f64::max);
            let side = if **outer { -1.0 } else { 1.0 };
            normals.iter().zip([p, q, r]).any(|(normal, at)| {
                let cosine = normal.dot(ray(at).normalize_or_zero()) * side;
                cosine <= 2.0 * differ
            })
        };
        pieces.extend(triangles.iter().zip(&outer).filter(turns).map(|(triangle, _)| triangle.map(point)));
    }
    pieces.par_iter().for_each(|piece| {
        if !search.is_stopped() {
            cut(piece, search, pixels + search.step, CUTS);
        }
    });
    true
}

/// Marks the parts of a triangle.
fn cut(corners: &[DVec3; 3], search: &Search<'_>, pixels: f64, cuts: u32) {
    let reach = corners.iter().map(|point| point.length()).fold(0.0, f64::max);
    let slack = 4.0 * f64::from(f32::EPSILON) * reach;
    let Some(contour) = ContourBox::around(search.projector, corners, slack, pixels) else { return };
    if search.hides(&contour) {
        return;
    }
    if cuts == 0 || contour.size() - 2.0 * pixels <= FINE {
        search.mark(&contour);
        return;
    }
    // Bisects the longest side.
    let [p, q, r] = *corners;
    let long = [(p - q).length_squared(), (q - r).length_squared(), (r - p).length_squared()];
    let [p, q, r] = if long[0] >= long[1] && long[0] >= long[2] {
        [p, q, r]
    } else if long[1] >= long[2] {
        [q, r, p]
    } else {
        [r, p, q]
    };
    let middle = 0.5 * (p + q);
    cut(&[p, middle, r], search, pixels, cuts - 1);
    cut(&[middle, q, r], search, pixels, cuts - 1);
}
