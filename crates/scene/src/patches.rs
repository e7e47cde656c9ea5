//! Bicubic patches between the vertices of a grid, and the points where rays meet them.
//!
//! A cell of a grid is the Hermite patch of the positions, first derivatives and mixed derivatives of its four
//! vertices. Neighbors share those of the edge between them, so patches meet without cracks or creases. With vertices
//! a distance h apart, a wave of amplitude a and wave number k is missed by at most a·(kh)⁴/384 along either
//! direction, and its slope by a·k·√3·(kh)³/216, where triangles with normals at their vertices miss it by a·(kh)²/8
//! and a·k·(kh)²/8.
//!
//! Source: Farin, *Curves and Surfaces for CAGD*, 2002, on bicubic Hermite patches; bounds of Hermite interpolation
//! after Birkhoff and Priver, *Hermite Interpolation Errors for Derivatives*, 1967.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::Projector;
use crate::resolve::{BLOCK, Lanes};

/// Derivatives at the vertices of a grid, by which each of its cells is a bicubic patch: s grows by 1 from column to
/// column, t by a step of its own from each row to the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patches {
    /// ∂P/∂s and ∂P/∂t by vertex, in meters.
    pub tangents: Vec<[[f32; 3]; 2]>,
    /// ∂²P/∂s∂t by vertex, in meters.
    pub twists: Vec<[f32; 3]>,
    /// Growth of t from each row to the next.
    pub steps: Vec<f32>,
    /// Whether the last column repeats the first one.
    pub closed: bool,
}

impl Patches {
    /// Makes patches from positions and first derivatives, row by row; mixed derivatives follow from those of the
    /// neighbors.
    ///
    /// With central differences δ, ∂s∂t ≈ δt∂s + δs∂t − δsδt: the error is (∂s − δs)(∂t − δt)P, of the order of
    /// h⁴k⁶/36 relative to the wave.
    pub(crate) fn new(
        columns: usize,
        positions: &[[f32; 3]],
        tangents: Vec<[[f32; 3]; 2]>,
        steps: Vec<f32>,
        closed: bool,
    ) -> Self {
        let mut twists = vec![[0.0; 3]; positions.len()];
        twists.par_chunks_mut(columns).enumerate().for_each(|(row, twists)| {
            let rows = row_differences(row, &steps).map(|(row, weight)| (row * columns, weight));
            for (column, twist) in twists.iter_mut().enumerate() {
                let across = column_differences(column, columns, closed);
                let mut sum = Vec3::ZERO;
                for (row, weight) in rows {
                    let mut along = Vec3::from(tangents[row + column][0]);
                    for (column, weight) in across {
                        along -= Vec3::from(positions[row + column]) * weight;
                    }
                    sum += along * weight;
                }
                let row = row * columns;
                for (column, weight) in across {
                    sum += Vec3::from(tangents[row + column][1]) * weight;
                }
                *twist = sum.to_array();
            }
        });
        Self { tangents, twists, steps, closed }
    }

    /// Returns the bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.tangents.len() * 24 + self.twists.len() * 12 + self.steps.len() * 4
    }
}

/// Returns rows and weights of the derivative by t at a row, exact for parabolas within the grid.
fn row_differences(row: usize, steps: &[f32]) -> [(usize, f32); 3] {
    let before = row.checked_sub(1).and_then(|before| steps.get(before)).copied().filter(|step| *step > 0.0);
    let after = steps.get(row).copied().filter(|step| *step > 0.0);
    match (before, after) {
        (Some(before), Some(after)) => {
            let both = before + after;
            let (least, most) = (-after / (before * both), before / (after * both));
            [(row - 1, least), (row, -(least + most)), (row + 1, most)]
        }
        (None, Some(after)) => [(row, -1.0 / after), (row + 1, 1.0 / after), (row, 0.0)],
        (Some(before), None) => [(row - 1, -1.0 / before), (row, 1.0 / before), (row, 0.0)],
        (None, None) => [(row, 0.0); 3],
    }
}

/// Returns columns and weights of the derivative by s at a column.
fn column_differences(column: usize, columns: usize, closed: bool) -> [(usize, f32); 2] {
    let last = columns - 1;
    let (before, after) = match (column, closed) {
        (0, true) => (last - 1, 1),
        (0, false) => (0, 1),
        (column, true) if column == last => (last - 1, 1),
        (column, false) if column == last => (last - 1, last),
        _ => (column - 1, column + 1),
    };
    let apart = if column == 0 && !closed || column == last && !closed { 1.0 } else { 2.0 };
    [(before, -1.0 / apart), (after, 1.0 / apart)]
}

/// Number of rays that are solved side by side, in vectors.
const WIDE: usize = 8;
/// Newton steps of a ray in one cell before it is looked at; further cells that a ray may try after its first one.
const STEPS: usize = 1;
const MORE_CELLS: u32 = 3;
/// How far beyond a cell its own patch is used, in cells: patches continue each other up to second derivatives.
const BEYOND: f64 = 0.05;
/// Distance between ray and point, in pixels, below which one more linear step suffices.
const CLOSE: f64 = 0.01;
/// Most cells that one step moves.
const LONGEST: f64 = 1.0;

/// A ray on its way to a patch.
#[derive(Clone, Copy, Default)]
struct Walk {
    lane: usize,
    cells: u32,
    row: usize,
    column: usize,
    u: f64,
    v: f64,
}

/// Where to look for the points of a block of rays: cells of the grid, and places in them, from triangles.
pub(crate) struct Starts {
    pub(crate) count: usize,
    pub(crate) rows: [u32; BLOCK],
    pub(crate) columns: [u32; BLOCK],
    pub(crate) u: Lanes,
    pub(crate) v: Lanes,
    /// Pixel column of each ray; all have one pixel row.
    pub(crate) x: Lanes,
    pub(crate) y: f64,
    /// −1 if the outer side is seen, else 1.
    pub(crate) sides: Lanes,
}

/// Points of patches.
pub(crate) struct Met {
    /// Upper left vertex of each point's cell, and its place in the cell.
    pub(crate) vertices: [u32; BLOCK],
    pub(crate) u: Lanes,
    pub(crate) v: Lanes,
    /// Positions relative to the camera; the given ones where no patch was met.
    pub(crate) positions: [Lanes; 3],
    /// ∂P/∂u × ∂P/∂v.
    pub(crate) normals: [Lanes; 3],
}

/// Data of the corners of cells: (0, 0), (1, 0), (0, 1), (1, 1) in (u, v).
struct Corners {
    positions: [[[f32; WIDE]; 3]; 4],
    by_s: [[[f32; WIDE]; 3]; 4],
    by_t: [[[f32; WIDE]; 3]; 4],
    twists: [[[f32; WIDE]; 3]; 4],
    /// Growth of t over the cell.
    steps: [f32; WIDE],
}

/// A point of a patch, and its derivatives by place in the cell.
#[derive(Clone, Copy)]
struct PatchPoint {
    position: DVec3,
    by_u: DVec3,
    by_v: DVec3,
}

/// Returns the cubic Hermite basis (values at 0 and 1, derivatives at 0 and 1), and its derivative.
#[inline(always)]
fn hermite(x: f64) -> ([f64; 4], [f64; 4]) {
    let (x2, x3) = (x * x, x * x * x);
    let rise = 3.0 * x2 - 2.0 * x3;
    let slope = 6.0 * (x - x2);
    ([1.0 - rise, rise, x - 2.0 * x2 + x3, x3 - x2], [-slope, slope, 1.0 - 4.0 * x + 3.0 * x2, 3.0 * x2 - 2.0 * x])
}

impl Corners {
    #[inline(always)]
    fn at(&self, lane: usize, u: f64, v: f64) -> PatchPoint {
        let (a, da) = hermite(u);
        let (mut b, mut db) = hermite(v);
        let step = f64::from(self.steps[lane]);
        (b[2], b[3], db[2], db[3]) = (b[2] * step, b[3] * step, db[2] * step, db[3] * step);
        let mut point = [[0.0; 3]; 3];
        for axis in 0..3 {
            let along =
                |basis: &[f64; 4], values: &[[[f32; WIDE]; 3]; 4], ways: &[[[f32; WIDE]; 3]; 4], first: usize| {
                    let of = |values: &[[[f32; WIDE]; 3]; 4], corner: usize| f64::from(values[corner][axis][lane]);
                    (basis[0] * of(values, first) + basis[1] * of(values, first + 1))
                        + (basis[2] * of(ways, first) + basis[3] * of(ways, first + 1))
                };
            let rows = |basis: &[f64; 4]| {
                [
                    along(basis, &self.positions, &self.by_s, 0),
                    along(basis, &self.positions, &self.by_s, 2),
                    along(basis, &self.by_t, &self.twists, 0),
                    along(basis, &self.by_t, &self.twists, 2),
                ]
            };
            let (values, slopes) = (rows(&a), rows(&da));
            let blend = |basis: &[f64; 4], of: &[f64; 4]| {
                (basis[0] * of[0] + basis[1] * of[1]) + (basis[2] * of[2] + basis[3] * of[3])
            };
            point[0][axis] = blend(&b, &values);
            point[1][axis] = blend(&b, &slopes);
            point[2][axis] = blend(&db, &values);
        }
        let [position, by_u, by_v] = point.map(DVec3::from_array);
        PatchPoint { position, by_u, by_v }
    }
}

/// A ray by two planes that contain it: a point P relative to the camera is on it if P·across = offset for both.
#[derive(Clone, Copy)]
struct Planes {
    across: [DVec3; 2],
    offsets: [f64; 2],
    direction: DVec3,
}

impl Planes {
    #[inline(always)]
    fn new(projector: &Projector, x: f64, y: f64) -> Self {
        let (right, up, forward) = (projector.right, projector.up, projector.forward);
        let at = [(x - projector.size[0] / 2.0) / projector.scale, (projector.size[1] / 2.0 - y) / projector.scale];
        if projector.orthographic {
            Self { across: [right, up], offsets: at, direction: forward }
        } else {
            let across = [right - forward * at[0], up - forward * at[1]];
            Self { across, offsets: [0.0; 2], direction: forward + right * at[0] + up * at[1] }
        }
    }

    /// Returns by how much a point misses the planes, and Newton's step to them.
    #[inline(always)]
    fn step(&self, point: &PatchPoint) -> ([f64; 2], [f64; 2]) {
        let [p, q] = self.across;
        let gap = [point.position.dot(p) - self.offsets[0], point.position.dot(q) - self.offsets[1]];
        let [pu, pv, qu, qv] = [point.by_u.dot(p), point.by_v.dot(p), point.by_u.dot(q), point.by_v.dot(q)];
        let inverse = 1.0 / (pu * qv - pv * qu);
        (gap, [(pv * gap[1] - qv * gap[0]) * inverse, (qu * gap[0] - pu * gap[1]) * inverse])
    }
}

/// The patches of a mesh, as a camera sees them.
pub(crate) struct PatchView<'a> {
    pub(crate) patches: &'a Patches,
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pub(crate) projector: &'a Projector,
}

impl PatchView<'_> {
    /// Moves rays from points of triangles to the patches of their cells, or of cells nearby. A ray that meets none
    /// there, or only the other side of one, keeps its point and gets the normal of the patch there.
    #[inline(always)]
    pub(crate) fn meet(&self, starts: &Starts, points: [Lanes; 3]) -> Met {
        let mut met =
            Met { vertices: [0; BLOCK], u: starts.u, v: starts.v, positions: points, normals: [[0.0; BLOCK]; 3] };
        let mut waiting = [Walk::default(); BLOCK];
        for lane in 0..starts.count {
            let (row, column) = (starts.rows[lane] as usize, starts.columns[lane] as usize);
            met.vertices[lane] = (row * self.columns + column) as u32;
            waiting[lane] = Walk { lane, cells: 0, row, column, u: starts.u[lane], v: starts.v[lane] };
        }
        let mut count = starts.count;
        while count > 0 {
            let first = count.saturating_sub(WIDE);
            let together = count - first;
            let mut walks = [Walk::default(); WIDE];
            walks[..together].copy_from_slice(&waiting[first..count]);
            count = first + self.advance(&mut walks, together, starts, &mut met);
            waiting[first..count].copy_from_slice(&walks[..count - first]);
        }
        met
    }

    /// Takes the steps of some rays in one cell each. Returns how many of them, now the first ones, have to go on.
    #[inline(always)]
    fn advance(&self, walks: &mut [Walk; WIDE], together: usize, starts: &Starts, met: &mut Met) -> usize {
        let corners = self.corners(walks, together);
        let (mut u, mut v, mut x) = ([0.0; WIDE], [0.0; WIDE], [0.0; WIDE]);
        for lane in 0..together {
            (u[lane], v[lane], x[lane]) = (walks[lane].u, walks[lane].v, starts.x[walks[lane].lane]);
        }
        let mut first = [[0.0; WIDE]; 3];
        for step in 0..STEPS {
            for lane in 0..WIDE {
                let point = corners.at(lane, u[lane], v[lane]);
                let (_, [by_u, by_v]) = Planes::new(self.projector, x[lane], starts.y).step(&point);
                if step == 0 {
                    let normal = point.by_u.cross(point.by_v);
                    (first[0][lane], first[1][lane], first[2][lane]) = (normal.x, normal.y, normal.z);
                }
                u[lane] += by_u.clamp(-LONGEST, LONGEST);
                v[lane] += by_v.clamp(-LONGEST, LONGEST);
            }
        }
        let (mut positions, mut normals) = ([[0.0; WIDE]; 3], [[0.0; WIDE]; 3]);
        let (mut misses, mut facing) = ([0.0; WIDE], [0.0; WIDE]);
        for lane in 0..WIDE {
            let point = corners.at(lane, u[lane], v[lane]);
            let planes = Planes::new(self.projector, x[lane], starts.y);
            let (gap, [by_u, by_v]) = planes.step(&point);
            let (by_u, by_v) = (by_u.clamp(-LONGEST, LONGEST), by_v.clamp(-LONGEST, LONGEST));
            let depth = if self.projector.orthographic { 1.0 } else { point.position.dot(self.projector.forward) };
            // In pixels; negative behind the camera.
            misses[lane] = (gap[0].abs() + gap[1].abs()) * self.projector.scale / depth;
            let normal = point.by_u.cross(point.by_v);
            facing[lane] = normal.dot(planes.direction);
            let position = point.position + point.by_u * by_u + point.by_v * by_v;
            (positions[0][lane], positions[1][lane], positions[2][lane]) = (position.x, position.y, position.z);
            (normals[0][lane], normals[1][lane], normals[2][lane]) = (normal.x, normal.y, normal.z);
            u[lane] += by_u;
            v[lane] += by_v;
        }
        let mut count = 0;
        for lane in 0..together {
            let mut walk = walks[lane];
            let at = walk.lane;
            let within = |place: f64| place >= -BEYOND && place <= 1.0 + BEYOND;
            let is_there = (0.0..=CLOSE).contains(&misses[lane])
                && within(u[lane])
                && within(v[lane])
                && facing[lane] * starts.sides[at] > 0.0;
            if is_there {
                met.vertices[at] = (walk.row * self.columns + walk.column) as u32;
                (met.u[at], met.v[at]) = (u[lane], v[lane]);
            }
            for axis in 0..3 {
                if is_there {
                    met.positions[axis][at] = positions[axis][lane];
                    met.normals[axis][at] = normals[axis][lane];
                } else if walk.cells == 0 {
                    met.normals[axis][at] = first[axis][lane];
                }
            }
            if !is_there && walk.cells < MORE_CELLS && self.go_on(&mut walk, [u[lane], v[lane]]) {
                walks[count] = walk;
                count += 1;
            }
        }
        count
    }

    /// Moves a ray to the cell to which its steps lead, or one nearer; returns whether there is any sense in it.
    fn go_on(&self, walk: &mut Walk, [u, v]: [f64; 2]) -> bool {
        if !(u.is_finite() && v.is_finite()) {
            return false;
        }
        let (right, down) = (u.floor().clamp(-1.0, 1.0), v.floor().clamp(-1.0, 1.0));
        let cells = self.columns - 1;
        let row = walk.row as isize + down as isize;
        let mut column = walk.column as isize + right as isize;
        if self.patches.closed {
            column = column.rem_euclid(cells as isize);
        }
        if row < 0 || row as usize >= self.rows - 1 || column < 0 || column as usize >= cells {
            return false;
        }
        let (u, v) = ((u - right).clamp(-LONGEST, 1.0 + LONGEST), (v - down).clamp(-LONGEST, 1.0 + LONGEST));
        *walk = Walk { cells: walk.cells + 1, row: row as usize, column: column as usize, u, v, ..*walk };
        true
    }

    #[inline(always)]
    fn corners(&self, walks: &[Walk; WIDE], together: usize) -> Corners {
        let none = || [[[0.0; WIDE]; 3]; 4];
        let mut corners = Corners { positions: none(), by_s: none(), by_t: none(), twists: none(), steps: [0.0; WIDE] };
        for lane in 0..together {
            let Walk { row, column, .. } = walks[lane];
            corners.steps[lane] = self.patches.steps[row];
            let first = row * self.columns + column;
            for (corner, vertex) in
                [first, first + 1, first + self.columns, first + self.columns + 1].into_iter().enumerate()
            {
                let (position, [by_s, by_t], twist) =
                    (self.positions[vertex], self.patches.tangents[vertex], self.patches.twists[vertex]);
                for axis in 0..3 {
                    corners.positions[corner][axis][lane] = position[axis];
                    corners.by_s[corner][axis][lane] = by_s[axis];
                    corners.by_t[corner][axis][lane] = by_t[axis];
                    corners.twists[corner][axis][lane] = twist[axis];
                }
            }
        }
        corners
    }
}

#[cfg(test)]
#[path = "patches_tests.rs"]
mod tests;
