//! Clips triangles that reach behind the camera or beyond fixed point.

use super::{Binned, Layer, MeshProjector};
use crate::surface::Mesh;

/// A vertex of a clipped polygon: weights of the triangle's three corners, and its position in view space.
#[derive(Clone, Copy)]
struct ClippedVertex {
    position: [f64; 3],
    weights: [f64; 3],
}

/// The part of a triangle inside of the view volume.
pub(super) struct ClippedTriangle {
    triangle: [u32; 3],
    /// Its primitive, and its index there.
    from: (u32, u32),
    corners: Vec<ClippedVertex>,
}

impl Layer {
    /// Adds a clipped polygon's vertices, with interpolated attributes, and its fan of triangles.
    pub(super) fn append(
        &mut self,
        stage: &MeshProjector<'_>,
        polygon: &ClippedTriangle,
        first: u32,
        out: &mut Vec<Binned>,
    ) {
        let start = self.mesh.positions.len() as u32;
        for corner in &polygon.corners {
            self.screen.push(stage.vertex(corner.position).0);
            let vertices = polygon.triangle.map(|vertex| vertex as usize);
            let blend = |values: [f32; 3]| {
                values.iter().zip(corner.weights).map(|(&value, weight)| f64::from(value) * weight).sum::<f64>() as f32
            };
            let Mesh { positions, normals, rests, rest_heights, uvs, slope_variances, trails, .. } = &mut self.mesh;
            positions.push(std::array::from_fn(|axis| blend(vertices.map(|vertex| positions[vertex][axis]))));
            if !normals.is_empty() {
                normals.push(std::array::from_fn(|axis| blend(vertices.map(|vertex| normals[vertex][axis]))));
            }
            if !rests.is_empty() {
                rests.push(std::array::from_fn(|axis| blend(vertices.map(|vertex| rests[vertex][axis]))));
            }
            if !rest_heights.is_empty() {
                rest_heights.push(blend(vertices.map(|vertex| rest_heights[vertex])));
            }
            if !uvs.is_empty() {
                uvs.push(std::array::from_fn(|axis| blend(vertices.map(|vertex| uvs[vertex][axis]))));
            }
            if !slope_variances.is_empty() {
                slope_variances.push(blend(vertices.map(|vertex| slope_variances[vertex])));
            }
            for values in trails.iter_mut().filter(|values| !values.is_empty()) {
                values.push(blend(vertices.map(|vertex| values[vertex])));
            }
        }
        for next in 1..polygon.corners.len() as u32 - 1 {
            let triangle = [start, start + next, start + next + 1];
            let primitive = first + (self.primitives + self.clipped.len()) as u32;
            self.clipped.push(triangle);
            self.clipped_from.push(polygon.from);
            stage.bin(triangle.into_iter().map(|vertex| self.screen[vertex as usize]), primitive, out);
        }
    }
}

impl MeshProjector<'_> {
    /// Clips by Sutherland–Hodgman against the near plane, then against the limits of fixed point.
    ///
    /// The intersection of an edge with a plane is computed from its ends in an order that depends only on the ends,
    /// so both triangles at an edge get the same point.
    pub(super) fn clip(&self, mesh: &Mesh, triangle: [u32; 3], from: (u32, u32), out: &mut Vec<ClippedTriangle>) {
        let reach = self.clip_reach();
        let mut polygon: Vec<ClippedVertex> = (0..3)
            .map(|index| ClippedVertex {
                position: self.view(mesh.positions[triangle[index] as usize]),
                weights: std::array::from_fn(|corner| if corner == index { 1.0 } else { 0.0 }),
            })
            .collect();
        for plane in 0..5 {
            let distance = |corner: &ClippedVertex| self.planes(corner.position, reach)[plane];
            let mut kept = Vec::with_capacity(polygon.len() + 1);
            for (index, a) in polygon.iter().enumerate() {
                let b = &polygon[(index + 1) % polygon.len()];
                let (at_a, at_b) = (distance(a), distance(b));
                if at_a >= 0.0 {
                    kept.push(*a);
                }
                if (at_a >= 0.0) != (at_b >= 0.0) {
                    kept.push(if precedes(a, b) { cross(a, b, at_a, at_b) } else { cross(b, a, at_b, at_a) });
                }
            }
            polygon = kept;
            if polygon.len() < 3 {
                return;
            }
        }
        out.push(ClippedTriangle { triangle, from, corners: polygon });
    }
}

fn precedes(a: &ClippedVertex, b: &ClippedVertex) -> bool {
    let order = a.position.iter().zip(&b.position).map(|(a, b)| a.total_cmp(b));
    order.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then).is_lt()
}

/// Returns the point between a and b where the distance to a plane is 0.
fn cross(a: &ClippedVertex, b: &ClippedVertex, at_a: f64, at_b: f64) -> ClippedVertex {
    let t = at_a / (at_a - at_b);
    let mix = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|index| a[index] + (b[index] - a[index]) * t);
    ClippedVertex { position: mix(a.position, b.position), weights: mix(a.weights, b.weights) }
}
