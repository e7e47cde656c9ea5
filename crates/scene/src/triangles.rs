//! Triangle meshes as surfaces, such as those read from files.

use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use crate::bezier::Placement;
use crate::boxes::{Line, Tree};
use crate::channel::{NORMALS, RESTS};
use crate::points::MeshHit;
use crate::surface::{Anchor, GivenUp, Hit, Mesh, Surface, Topology};
use crate::{ChannelSet, Projector, Ray};

/// Most triangles, and most vertices, of one mesh.
pub const MAX_TRIANGLES: usize = 1 << 24;

/// A mesh in its own space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// Vertices.
    pub positions: Vec<DVec3>,
    /// Normals of any length, one per vertex. If empty, each vertex gets the [mean](Self::mean_normals) of the
    /// normals around it.
    pub normals: Vec<DVec3>,
    /// Texture coordinates, one per vertex, or empty.
    pub uvs: Vec<[f64; 2]>,
    /// Three vertices per triangle, counterclockwise seen from the outer side.
    pub triangles: Vec<[u32; 3]>,
}

/// Why arrays do not form a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TrianglesError {
    /// Triangle `triangle` names vertex `vertex` of `vertices`.
    Vertex {
        /// Index of the triangle.
        triangle: usize,
        /// Vertex that it names.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// The number of normals or texture coordinates does not match the number of vertices.
    Counts {
        /// Name of the array.
        what: &'static str,
        /// Length of the array.
        found: usize,
        /// Number of vertices.
        vertices: usize,
    },
    /// Vertex `vertex` is not finite, or beyond 1e15.
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Name of the array.
        what: &'static str,
    },
    /// There are more triangles or vertices than [`MAX_TRIANGLES`].
    TooMany(usize),
}

impl std::fmt::Display for TrianglesError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Vertex { triangle, vertex, vertices } => {
                write!(f, "triangle {triangle} names vertex {vertex}, but there are {vertices} vertices")
            }
            Self::Counts { what, found, vertices } => {
                write!(f, "{found} {what} for {vertices} vertices; expected one for each vertex, or none")
            }
            Self::NotFinite { vertex, what } => {
                write!(f, "the {what} of vertex {vertex} holds a number that is not finite or beyond 1e15")
            }
            Self::TooMany(found) => write!(f, "{found} triangles or vertices; at most {MAX_TRIANGLES} are allowed"),
        }
    }
}

impl std::error::Error for TrianglesError {}

impl Triangles {
    /// Checks that the arrays fit each other.
    ///
    /// # Errors
    /// They do not fit; the error says which one, and where.
    pub fn check(&self) -> Result<(), TrianglesError> {
        let vertices = self.positions.len();
        let most = vertices.max(self.triangles.len());
        if most > MAX_TRIANGLES {
            return Err(TrianglesError::TooMany(most));
        }
        for (what, found) in [("normals", self.normals.len()), ("texture coordinates", self.uvs.len())] {
            if found != 0 && found != vertices {
                return Err(TrianglesError::Counts { what, found, vertices });
            }
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|vertex| **vertex as usize >= vertices) {
                return Err(TrianglesError::Vertex { triangle, vertex, vertices });
            }
        }
        let legal = |value: f64| value.abs() <= 1e15;
        let vectors = |what, vectors: &[DVec3]| {
            let at = vectors.iter().position(|vector| !vector.to_array().into_iter().all(legal));
            at.map_or(Ok(()), |vertex| Err(TrianglesError::NotFinite { vertex, what }))
        };
        vectors("position", &self.positions)?;
        vectors("normal", &self.normals)?;
        let at = self.uvs.iter().position(|uv| !uv.iter().copied().all(legal));
        at.map_or(Ok(()), |vertex| Err(TrianglesError::NotFinite { vertex, what: "texture coordinate" }))
    }

    /// Returns for each vertex the mean of the normals of the triangles around its position, weighted by their areas,
    /// of unit length or 0. Vertices at the same position have the same normal, so that no seam of texture
    /// coordinates shows.
    ///
    /// # Panics
    /// A triangle names a vertex that does not exist; see [`check`](Self::check).
    pub fn mean_normals(&self) -> Vec<DVec3> {
        mean_normals(&self.positions, &self.triangles)
    }

    /// Returns the same triangles with three corners each that carry the triangle's normal; no vertex is shared any
    /// more.
    ///
    /// # Panics
    /// A triangle names a vertex that does not exist; see [`check`](Self::check).
    pub fn faceted(&self) -> Self {
        let corners = || self.triangles.iter().flatten().map(|vertex| *vertex as usize);
        let positions: Vec<DVec3> = corners().map(|vertex| self.positions[vertex]).collect();
        let facet = |corners: &[DVec3]| [unit((corners[1] - corners[0]).cross(corners[2] - corners[0])); 3];
        Self {
            normals: positions.chunks_exact(3).flat_map(facet).collect(),
            uvs: if self.uvs.is_empty() { Vec::new() } else { corners().map(|vertex| self.uvs[vertex]).collect() },
            triangles: (0..self.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
            positions,
        }
    }
}

/// A mesh placed in the world; visible from both sides.
#[derive(Clone, Debug)]
pub struct TriangleModel {
    mesh: Triangles,
    /// Vertices and normals in the world.
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// Corners, with the outer side as placed.
    triangles: Vec<[u32; 3]>,
    /// Boxes around the triangles, made for the first ray.
    tree: Arc<OnceLock<Option<Tree>>>,
}

impl TriangleModel {
    /// Places a mesh; with `flip` the outer side is swapped. Heights are measured from world y = 0.
    ///
    /// # Errors
    /// The arrays do not fit each other.
    pub fn new(mesh: Triangles, placement: Placement, flip: bool) -> Result<Self, TrianglesError> {
        mesh.check()?;
        let positions: Vec<DVec3> = mesh.positions.par_iter().map(|point| placement.apply(*point)).collect();
        let turned = placement.mirrors() != flip;
        let triangles: Vec<[u32; 3]> =
            mesh.triangles.iter().map(|&[a, b, c]| if turned { [a, c, b] } else { [a, b, c] }).collect();
        let normals = if mesh.normals.is_empty() {
            mean_normals(&positions, &triangles)
        } else {
            // Normals transform by the inverse transpose: scale factors are inverted, rotations stay.
            let cofactor = DVec3::new(
                placement.scale.y * placement.scale.z,
                placement.scale.z * placement.scale.x,
                placement.scale.x * placement.scale.y,
            );
            let turn = Placement { scale: cofactor, rotate: placement.rotate, translate: DVec3::ZERO };
            let sign = if turned { -1.0 } else { 1.0 };
            mesh.normals.par_iter().map(|normal| unit(turn.apply(*normal) * sign)).collect()
        };
        Ok(Self { mesh, positions, normals, triangles, tree: Arc::default() })
    }

    /// Returns the number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Returns whether there are no triangles.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }
}

/// Returns the vector at unit length, or 0 if it has no direction.
fn unit(vector: DVec3) -> DVec3 {
    vector.try_normalize().unwrap_or(DVec3::ZERO)
}

fn mean_normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    // Among the vertices at one position, the first one accumulates the sum.
    let mut places = HashMap::with_capacity(positions.len());
    let first: Vec<usize> = positions
        .iter()
        .enumerate()
        // Adding 0 turns −0 into 0.
        .map(|(index, point)| *places.entry(point.to_array().map(|v| (v + 0.0).to_bits())).or_insert(index))
        .collect();
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let [p, q, r] = triangle.map(|vertex| positions[vertex as usize]);
        let normal = (q - p).cross(r - p);
        triangle.iter().for_each(|vertex| normals[first[*vertex as usize]] += normal);
    }
    first.into_iter().map(|first| unit(normals[first])).collect()
}

impl Surface for TriangleModel {
    /// Returns the anchors in all triangles that contain the texture coordinates.
    fn anchors(&self, uv: [f64; 2]) -> Vec<Anchor> {
        let uvs = &self.mesh.uvs;
        let anchor = |triangle: &[u32; 3]| {
            let corners = triangle.map(|vertex| vertex as usize);
            let [a, b, c] = corners.map(|corner| *uvs.get(corner).unwrap_or(&[f64::NAN; 2]));
            let ([p, q], r) = ([b, c].map(|to| [to[0] - a[0], to[1] - a[1]]), [uv[0] - a[0], uv[1] - a[1]]);
            let area = p[0] * q[1] - p[1] * q[0];
            let [s, t] = [(r[0] * q[1] - r[1] * q[0]) / area, (p[0] * r[1] - p[1] * r[0]) / area];
            // Fails if the triangle has no area, or no coordinates.
            (s >= 0.0 && t >= 0.0 && s + t < 1.0).then(|| {
                let [a, b, c] = corners.map(|corner| self.positions[corner]);
                let (b, c) = (b - a, c - a);
                Anchor {
                    point: a + b * s + c * t,
                    along_u: (b * q[1] - c * p[1]) / area,
                    along_v: (c * p[0] - b * q[0]) / area,
                }
            })
        };
        self.triangles.iter().filter_map(anchor).collect()
    }

    fn tessellate(&self, projector: &Projector, wanted: ChannelSet) -> Mesh {
        let relative = |point: &DVec3| (*point - projector.position).as_vec3().to_array();
        let when = |channels: ChannelSet| wanted.intersects(channels);
        let mut mesh = Mesh::empty(0.0);
        mesh.positions = self.positions.par_iter().map(relative).collect();
        if when(NORMALS) {
            mesh.normals = self.normals.par_iter().map(|normal| normal.as_vec3().to_array()).collect();
        }
        if when(RESTS) || (when(ChannelSet::UV) && self.mesh.uvs.is_empty()) {
            let rests: Vec<[f32; 3]> = self.mesh.positions.par_iter().map(relative).collect();
            mesh.rests = rests.iter().map(|rest| [rest[0], rest[2]]).collect();
            mesh.rest_heights = rests.iter().map(|rest| rest[1]).collect();
        }
        if when(ChannelSet::UV) {
            mesh.uvs = self.mesh.uvs.par_iter().map(|uv| uv.map(|part| part as f32)).collect();
        }
        mesh.tolerance = Some(0.0);
        mesh.topology = Topology::Triangles(self.triangles.clone());
        mesh
    }

    /// Returns the hit of the triangle itself, unless rounding has moved the ray beside it.
    fn meet_near(&self, projector: &Projector, ray: &Ray, near: &MeshHit) -> Option<Hit> {
        // There may be several bodies of this model.
        let triangle = near.triangle.map(|triangle| self.triangles[triangle % self.triangles.len()]);
        let met = triangle.and_then(|triangle| Some((meet(&self.positions, triangle, ray)?, triangle)));
        met.map_or_else(
            || self.before(projector, ray, f64::INFINITY),
            |(met, triangle)| Some(self.hit(projector, ray, met, triangle)),
        )
    }

    fn trace(&self, projector: &Projector, ray: &Ray, end: f64) -> Result<Option<Hit>, GivenUp> {
        Ok(self.before(projector, ray, end))
    }
}

impl TriangleModel {
    /// Returns the first point on a ray before a distance.
    fn before(&self, projector: &Projector, ray: &Ray, end: f64) -> Option<Hit> {
        let mut nearest: Option<(Crossing, usize)> = None;
        let tree = self.tree.get_or_init(|| {
            let corners = |triangle: &[u32; 3]| triangle.map(|vertex| self.positions[vertex as usize]);
            let bounds = |[a, b, c]: [DVec3; 3]| [a.min(b).min(c), a.max(b).max(c)];
            Tree::new(&self.triangles.iter().map(|triangle| bounds(corners(triangle))).collect::<Vec<_>>())
        });
        tree.as_ref()?.visit(&Line::new(ray.origin, ray.direction), end, |index| {
            if let Some(met) = meet(&self.positions, self.triangles[index], ray).filter(|met| met.distance < end) {
                // Of equally near triangles, the first one counts.
                let is_nearer = |(known, of): &(Crossing, usize)| (met.distance, index) < (known.distance, *of);
                if nearest.as_ref().is_none_or(is_nearer) {
                    nearest = Some((met, index));
                }
            }
            nearest.as_ref().map_or(end, |(met, _)| met.distance)
        });
        let (met, index) = nearest?;
        Some(self.hit(projector, ray, met, self.triangles[index]))
    }

    /// Interpolates the point of a triangle by the weights of its corners.
    fn hit(&self, projector: &Projector, ray: &Ray, crossing: Crossing, triangle: [u32; 3]) -> Hit {
        let Crossing { distance, weights } = crossing;
        let corners = triangle.map(|vertex| vertex as usize);
        let blend = |vectors: &[DVec3]| (0..3).map(|i| weights[i] * vectors[corners[i]]).sum::<DVec3>();
        let position = blend(&self.positions);
        let [p, q, r] = corners.map(|corner| self.positions[corner]);
        let normal = blend(&self.normals).try_normalize().unwrap_or(DVec3::Y);
        // The normal is flipped if the inner side is seen.
        let normal = if (q - p).cross(r - p).dot(ray.direction) > 0.0 { -normal } else { normal };
        let rest = blend(&self.mesh.positions);
        let uv = if self.mesh.uvs.is_empty() {
            [rest.x, rest.z]
        } else {
            [0, 1].map(|axis| (0..3).map(|i| weights[i] * self.mesh.uvs[corners[i]][axis]).sum())
        };
        Hit {
            surface: 0,
            distance,
            depth: (position - projector.position).dot(projector.forward),
            position,
            normal,
            rest,
            height: position.y,
            rest_distance: position.distance(rest),
            slope_variance: 0.0,
            jacobian: 1.0,
            trails: [0.0; 6],
            uv,
        }
    }
}

/// Point where a ray crosses a triangle.
struct Crossing {
    /// Distance along the ray, in meters.
    distance: f64,
    /// Weights of the triangle's corners.
    weights: [f64; 3],
}

/// Returns the point where a ray crosses a triangle.
///
/// After Möller and Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997.
fn meet(positions: &[DVec3], triangle: [u32; 3], ray: &Ray) -> Option<Crossing> {
    let [p, q, r] = triangle.map(|vertex| positions[vertex as usize]);
    let (a, b) = (q - p, r - p);
    let across = ray.direction.cross(b);
    let determinant = a.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let offset = ray.origin - p;
    let u = offset.dot(across) / determinant;
    let along = offset.cross(a);
    let v = ray.direction.dot(along) / determinant;
    let distance = b.dot(along) / determinant;
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance >= 0.0 && distance.is_finite();
    inside.then_some(Crossing { distance, weights: [1.0 - u - v, u, v] })
}
