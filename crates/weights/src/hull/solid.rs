//! Hulls of points that span space: quickhull with exact orientation tests.
//!
//! Barber, Dobkin, Huhdanpaa, *The Quickhull Algorithm for Convex Hulls*, 1996, with one change: a face is visible from
//! a point only if the point lies *strictly* above it, and that sign is computed exactly. Therefore no input needs a
//! tolerance:
//!
//! - Coplanar triangles are either all visible or all invisible, so the visible part is a union of true facets. It is
//!   connected through edges, and its boundary, the horizon, is a simple cycle, as in general position.
//! - A new triangle joins the point p to a horizon edge. If p were collinear with it, p would lie in the plane of the
//!   visible face at that edge, hence not strictly above it. So no triangle is degenerate.
//! - A point above a removed face but above no new face is inside. (The faces that it sees are connected; if they
//!   reach beyond the horizon, they cross it at an edge whose two faces it sees, and the normal of the new face there
//!   is a positive combination of their two normals.)
//!
//! The next point of an outside set is chosen in plain f64, since the choice affects only the time.

use super::vector::{Point, area_vector, dot, side};

/// A triangle of the hull, counterclockwise as seen from outside.
struct Face {
    vertices: [u32; 3],
    /// Faces across the edges from `vertices[i]` to `vertices[i + 1]`.
    neighbors: [u32; 3],
    /// Points strictly above this face. Each point is in the set of only one face.
    outside: Vec<u32>,
    alive: bool,
}

/// Surface of a solid hull; coplanar triangles have the same facet number.
pub(super) struct Mesh {
    /// Corner indices and facet number of each triangle.
    pub(super) triangles: Vec<([u32; 3], u32)>,
    /// Pairs of points joined by an edge between two different facets.
    pub(super) edges: Vec<[u32; 2]>,
    /// Number of facets.
    pub(super) facets: usize,
    /// Extreme points, at which at least three facets meet, in ascending order.
    pub(super) vertices: Vec<u32>,
}

struct Quickhull<'a> {
    points: &'a [Point],
    faces: Vec<Face>,
    /// For each point, the new face whose horizon edge starts there. Only entries of the current horizon are valid.
    starting: Vec<u32>,
}

/// Returns the hull of distinct points; `simplex` are four of them that are not coplanar.
pub(super) fn hull(points: &[Point], simplex: [u32; 4]) -> Mesh {
    let mut work = Quickhull { points, faces: Vec::new(), starting: vec![0; points.len()] };
    work.start(simplex);
    work.grow();
    work.finish()
}

impl Quickhull<'_> {
    fn above(&self, face: u32, point: u32) -> bool {
        let [a, b, c] = self.corners(self.faces[face as usize].vertices);
        side(a, b, c, self.points[point as usize]) > 0.0
    }

    fn corners(&self, vertices: [u32; 3]) -> [Point; 3] {
        vertices.map(|v| self.points[v as usize])
    }

    fn start(&mut self, [a, b, c, d]: [u32; 4]) {
        let [pa, pb, pc] = self.corners([a, b, c]);
        let (b, c) = if side(pa, pb, pc, self.points[d as usize]) > 0.0 { (c, b) } else { (b, c) };
        let face = |vertices, neighbors| Face { vertices, neighbors, outside: Vec::new(), alive: true };
        self.faces.push(face([a, b, c], [1, 2, 3]));
        self.faces.push(face([b, a, d], [0, 3, 2]));
        self.faces.push(face([c, b, d], [0, 1, 3]));
        self.faces.push(face([a, c, d], [0, 2, 1]));
        let all = 0..self.points.len() as u32;
        self.assign(all.filter(|p| ![a, b, c, d].contains(p)).collect(), 0..4);
    }

    /// Adds each point to the outside set of the first face that it is above, or drops it if there is none.
    fn assign(&mut self, points: Vec<u32>, faces: std::ops::Range<u32>) {
        for point in points {
            if let Some(face) = faces.clone().find(|&face| self.above(face, point)) {
                self.faces[face as usize].outside.push(point);
            }
        }
    }

    fn grow(&mut self) {
        let mut pending: Vec<u32> = (0..4).collect();
        while let Some(face) = pending.pop() {
            if !self.faces[face as usize].alive || self.faces[face as usize].outside.is_empty() {
                continue;
            }
            let first = self.faces.len() as u32;
            let apex = self.farthest(face);
            self.add(face, apex);
            pending.extend(first..self.faces.len() as u32);
        }
    }

    /// Returns the point of a nonempty outside set that is farthest from the face, up to rounding.
    fn farthest(&self, face: u32) -> u32 {
        let face = &self.faces[face as usize];
        let [a, b, c] = self.corners(face.vertices);
        let normal = area_vector(a, b, c);
        let height = |p: u32| dot(normal, self.points[p as usize]);
        let mut best = (face.outside[0], height(face.outside[0]));
        for &point in &face.outside[1..] {
            let height = height(point);
            if height > best.1 {
                best = (point, height);
            }
        }
        best.0
    }

    /// Adds point `apex`, which is above `face`: replaces all visible faces by a cone to their horizon.
    fn add(&mut self, face: u32, apex: u32) {
        let mut visible = vec![face];
        let mut horizon: Vec<(u32, u32, u32)> = Vec::new();
        let mut orphans = Vec::new();
        self.faces[face as usize].alive = false;
        let mut next = 0;
        while let Some(&face) = visible.get(next) {
            next += 1;
            orphans.append(&mut self.faces[face as usize].outside);
            for edge in 0..3 {
                let Face { vertices, neighbors, .. } = &self.faces[face as usize];
                let (from, to, neighbor) = (vertices[edge], vertices[(edge + 1) % 3], neighbors[edge]);
                if !self.faces[neighbor as usize].alive {
                    continue;
                }
                if self.above(neighbor, apex) {
                    self.faces[neighbor as usize].alive = false;
                    visible.push(neighbor);
                } else {
                    horizon.push((from, to, neighbor));
                }
            }
        }
        let first = self.faces.len() as u32;
        for (&(from, to, neighbor), new) in horizon.iter().zip(first..) {
            self.starting[from as usize] = new;
            let across = &mut self.faces[neighbor as usize];
            for edge in 0..3 {
                if across.vertices[edge] == to && across.vertices[(edge + 1) % 3] == from {
                    across.neighbors[edge] = new;
                }
            }
            // The other neighbors are set below, when every new face is known.
            let neighbors = [neighbor, 0, 0];
            self.faces.push(Face { vertices: [from, to, apex], neighbors, outside: Vec::new(), alive: true });
        }
        for new in first..self.faces.len() as u32 {
            let to = self.faces[new as usize].vertices[1];
            let after = self.starting[to as usize];
            self.faces[new as usize].neighbors[1] = after;
            self.faces[after as usize].neighbors[2] = new;
        }
        orphans.retain(|&point| point != apex);
        self.assign(orphans, first..self.faces.len() as u32);
    }

    /// Merges coplanar triangles into facets and finds edges and extreme points.
    fn finish(self) -> Mesh {
        const NONE: u32 = u32::MAX;
        let mut facet = vec![NONE; self.faces.len()];
        let mut facets = 0;
        let mut triangles = Vec::new();
        for seed in 0..self.faces.len() as u32 {
            if !self.faces[seed as usize].alive || facet[seed as usize] != NONE {
                continue;
            }
            let [a, b, c] = self.corners(self.faces[seed as usize].vertices);
            facet[seed as usize] = facets;
            let mut spread = vec![seed];
            while let Some(face) = spread.pop() {
                triangles.push((self.faces[face as usize].vertices, facets));
                for neighbor in self.faces[face as usize].neighbors {
                    let corners = self.corners(self.faces[neighbor as usize].vertices);
                    if facet[neighbor as usize] == NONE && corners.iter().all(|&p| side(a, b, c, p) == 0.0) {
                        facet[neighbor as usize] = facets;
                        spread.push(neighbor);
                    }
                }
            }
            facets += 1;
        }
        let mut edges = Vec::new();
        let mut meeting = vec![[NONE; 3]; self.points.len()];
        for (index, face) in self.faces.iter().enumerate().filter(|(_, face)| face.alive) {
            for edge in 0..3 {
                let (from, to) = (face.vertices[edge], face.vertices[(edge + 1) % 3]);
                if from < to && facet[face.neighbors[edge] as usize] != facet[index] {
                    edges.push([from, to]);
                }
                let meeting = &mut meeting[from as usize];
                if !meeting.contains(&facet[index])
                    && let Some(free) = meeting.iter_mut().find(|entry| **entry == NONE)
                {
                    *free = facet[index];
                }
            }
        }
        let extreme = |p: &u32| meeting[*p as usize].iter().all(|&entry| entry != NONE);
        let vertices = (0..self.points.len() as u32).filter(extreme).collect();
        Mesh { triangles, edges, facets: facets as usize, vertices }
    }
}
