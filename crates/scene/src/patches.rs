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

use fearless_simd::{Level, dispatch, f32x4, prelude::*};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::Projector;
use crate::four::transposed;
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
            let rows = rows.map(|(row, weight)| (&positions[row..][..columns], &tangents[row..][..columns], weight));
            let own = &tangents[row * columns..][..columns];
            dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
                for (column, twist) in twists.iter_mut().enumerate() {
                    let across = column_differences(column, columns, closed);
                    let mut sum = Vec3::ZERO;
                    for (positions, tangents, weight) in rows {
                        let mut along = Vec3::from(tangents[column][0]);
                        for (column, weight) in across {
                            along -= Vec3::from(positions[column]) * weight;
                        }
                        sum += along * weight;
                    }
                    for (column, weight) in across {
                        sum += Vec3::from(own[column][1]) * weight;
                    }
                    *twist = sum.to_array();
                }
            }));
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
#[inline(always)]
fn column_differences(column: usize, columns: usize, closed: bool) -> [(usize, f32); 2] {
    let last = columns - 1;
    match (column, closed) {
        (column, _) if column > 0 && column < last => [(column - 1, -0.5), (column + 1, 0.5)],
        (_, true) => [(last - 1, -0.5), (1, 0.5)],
        (0, false) => [(0, -1.0), (1, 1.0)],
        (_, false) => [(last - 1, -1.0), (last, 1.0)],
    }
}

/// Number of rays that are solved side by side, in vectors.
const WIDE: usize = 16;
/// Further cells that a ray may try after its first one.
pub(crate) const MORE_CELLS: u32 = 7;
/// How far beyond a cell its own patch is used, in cells: patches continue each other up to second derivatives.
const BEYOND: f32 = 0.05;
/// Distance between ray and point, in pixels, below which one more linear step suffices.
const CLOSE: f32 = 0.01;
/// Most cells that one step moves.
const LONGEST: f32 = 1.0;

/// A value of each ray.
type Wide = [f32; WIDE];

/// A ray on its way to a patch.
#[derive(Clone, Copy, Default)]
struct Walk {
    lane: u32,
    cells: u32,
    row: u32,
    column: u32,
    u: f32,
    v: f32,
}

/// Where to look for the points of a block of rays: cells of the grid, from triangles.
pub(crate) struct Starts<'a> {
    pub(crate) count: usize,
    pub(crate) rows: &'a [u32; BLOCK],
    pub(crate) columns: &'a [u32; BLOCK],
    /// Places of the rays across and upward from the middle, as of [`Projector::place`].
    pub(crate) places: &'a [Lanes; 2],
    /// −1 if the outer side is seen, else 1.
    pub(crate) sides: &'a Lanes,
}

/// Points of patches; at first, those of triangles, without normals.
pub(crate) struct Met {
    /// Upper left vertex of each point's cell, and its place in the cell.
    pub(crate) vertices: [u32; BLOCK],
    pub(crate) u: Lanes,
    pub(crate) v: Lanes,
    /// Positions relative to the camera.
    pub(crate) positions: [Lanes; 3],
    /// ∂P/∂u × ∂P/∂v.
    pub(crate) normals: [Lanes; 3],
}

impl Default for Met {
    fn default() -> Self {
        let none = [0.0; BLOCK];
        Self { vertices: [0; BLOCK], u: none, v: none, positions: [none; 3], normals: [none; 3] }
    }
}

/// A cell of each ray.
#[derive(Default)]
pub(crate) struct Cells {
    /// Two corners with v = 0, two with v = 1, and the derivatives by t of both; of each, two positions, with u = 0 and
    /// u = 1, and their derivatives by s. Positions are relative to the first one, so that f32 is exact enough.
    sides: [[[Wide; 3]; 4]; 4],
    /// Positions of the first corners relative to the camera.
    firsts: [[f64; WIDE]; 3],
    /// Growth of t over the cell.
    steps: Wide,
}

/// Points of patches, relative to the first corners of their cells, and their derivatives by place in the cell.
struct PatchPoints {
    positions: [Wide; 3],
    by_u: [Wide; 3],
    by_v: [Wide; 3],
}

/// Returns the cubic Hermite basis (values at 0 and 1, derivatives at 0 and 1), and its derivative.
#[inline(always)]
fn hermite(x: f32) -> ([f32; 4], [f32; 4]) {
    let (x2, x3) = (x * x, x * x * x);
    let rise = 3.0 * x2 - 2.0 * x3;
    let slope = 6.0 * (x - x2);
    ([1.0 - rise, rise, x - 2.0 * x2 + x3, x3 - x2], [-slope, slope, 1.0 - 4.0 * x + 3.0 * x2, 3.0 * x2 - 2.0 * x])
}

/// Returns Σ wᵢvᵢ of one axis and ray.
#[inline(always)]
fn blend(weights: [f32; 4], values: &[[Wide; 3]; 4], axis: usize, lane: usize) -> f32 {
    sum(weights, [values[0][axis][lane], values[1][axis][lane], values[2][axis][lane], values[3][axis][lane]])
}

/// Returns Σ aᵢbᵢ.
#[inline(always)]
fn sum(a: [f32; 4], b: [f32; 4]) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

impl Cells {
    #[inline(always)]
    fn at(&self, u: &Wide, v: &Wide) -> PatchPoints {
        let none = [[0.0; WIDE]; 3];
        let mut points = PatchPoints { positions: none, by_u: none, by_v: none };
        let [upper, lower, upper_by_t, lower_by_t] = &self.sides;
        for lane in 0..WIDE {
            let ((a, da), (b, db), step) = (hermite(u[lane]), hermite(v[lane]), self.steps[lane]);
            for axis in 0..3 {
                let values = [
                    blend(a, upper, axis, lane),
                    blend(a, lower, axis, lane),
                    step * blend(a, upper_by_t, axis, lane),
                    step * blend(a, lower_by_t, axis, lane),
                ];
                let slopes = [
                    blend(da, upper, axis, lane),
                    blend(da, lower, axis, lane),
                    step * blend(da, upper_by_t, axis, lane),
                    step * blend(da, lower_by_t, axis, lane),
                ];
                points.positions[axis][lane] = sum(b, values);
                points.by_u[axis][lane] = sum(b, slopes);
                points.by_v[axis][lane] = sum(db, values);
            }
        }
        points
    }
}

/// Rays by two planes that contain each: a point P relative to the camera is on it if P·across = offset for both.
struct Planes {
    across: [[Wide; 3]; 2],
    /// By how much the first corners of the cells miss the planes.
    firsts: [Wide; 2],
    directions: [Wide; 3],
    /// Pixels per meter at the first corners; negative behind the camera.
    scales: Wide,
}

impl Planes {
    #[inline(always)]
    fn new(projector: &Projector, places: &[[f64; WIDE]; 2], firsts: &[[f64; WIDE]; 3]) -> Self {
        let (right, up, forward) = (projector.right, projector.up, projector.forward);
        let none = || [[0.0; WIDE]; 3];
        let mut planes = Self {
            across: [none(), none()],
            firsts: [[0.0; WIDE]; 2],
            directions: none(),
            scales: [projector.scale as f32; WIDE],
        };
        for lane in 0..WIDE {
            let at = [places[0][lane], places[1][lane]];
            let first = DVec3::new(firsts[0][lane], firsts[1][lane], firsts[2][lane]);
            let (across, offsets, direction) = if projector.orthographic {
                ([right, up], at, forward)
            } else {
                planes.scales[lane] = (projector.scale / first.dot(forward)) as f32;
                ([right - forward * at[0], up - forward * at[1]], [0.0; 2], forward + right * at[0] + up * at[1])
            };
            for plane in 0..2 {
                planes.firsts[plane][lane] = (first.dot(across[plane]) - offsets[plane]) as f32;
                for axis in 0..3 {
                    planes.across[plane][axis][lane] = across[plane][axis] as f32;
                }
            }
            for axis in 0..3 {
                planes.directions[axis][lane] = direction[axis] as f32;
            }
        }
        planes
    }

    /// Returns by how much points miss the planes, in meters, and Newton's steps to them.
    #[inline(always)]
    fn steps(&self, points: &PatchPoints) -> (Wide, [Wide; 2]) {
        let (mut gaps, mut steps) = ([0.0; WIDE], [[0.0; WIDE]; 2]);
        for lane in 0..WIDE {
            let [p, q] = &self.across;
            let gap = [
                dot(&points.positions, p, lane) + self.firsts[0][lane],
                dot(&points.positions, q, lane) + self.firsts[1][lane],
            ];
            let (pu, pv) = (dot(&points.by_u, p, lane), dot(&points.by_v, p, lane));
            let (qu, qv) = (dot(&points.by_u, q, lane), dot(&points.by_v, q, lane));
            let inverse = 1.0 / (pu * qv - pv * qu);
            gaps[lane] = gap[0].abs() + gap[1].abs();
            steps[0][lane] = ((pv * gap[1] - qv * gap[0]) * inverse).clamp(-LONGEST, LONGEST);
            steps[1][lane] = ((qu * gap[0] - pu * gap[1]) * inverse).clamp(-LONGEST, LONGEST);
        }
        (gaps, steps)
    }
}

/// Returns a scalar product of one ray.
#[inline(always)]
fn dot(a: &[Wide; 3], b: &[Wide; 3], lane: usize) -> f32 {
    a[0][lane] * b[0][lane] + a[1][lane] * b[1][lane] + a[2][lane] * b[2][lane]
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
    pub(crate) fn meet<S: Simd>(&self, simd: S, starts: &Starts<'_>, cells: &mut Cells, met: &mut Met) {
        let mut waiting = [Walk::default(); BLOCK];
        for lane in 0..starts.count {
            let (row, column) = (starts.rows[lane], starts.columns[lane]);
            met.vertices[lane] = row * self.columns as u32 + column;
            let (u, v) = (met.u[lane] as f32, met.v[lane] as f32);
            waiting[lane] = Walk { lane: lane as u32, cells: 0, row, column, u, v };
        }
        let mut count = starts.count;
        while count > 0 {
            let first = count.saturating_sub(WIDE);
            count = first + self.advance(simd, &mut waiting[first..count], starts, cells, met);
        }
    }

    /// Takes two steps of at most [`WIDE`] rays in one cell each. Returns how many of them, now the first ones, have to go
    /// on.
    #[inline(always)]
    fn advance<S: Simd>(
        &self,
        simd: S,
        walks: &mut [Walk],
        starts: &Starts<'_>,
        cells: &mut Cells,
        met: &mut Met,
    ) -> usize {
        self.gather(simd, walks, cells);
        let (mut u, mut v, mut places) = ([0.0; WIDE], [0.0; WIDE], [[0.0; WIDE]; 2]);
        let mut sides = [0.0; WIDE];
        for (lane, walk) in walks.iter().enumerate() {
            (u[lane], v[lane], sides[lane]) = (walk.u, walk.v, starts.sides[walk.lane as usize]);
            for axis in 0..2 {
                places[axis][lane] = starts.places[axis][walk.lane as usize];
            }
        }
        let planes = Planes::new(self.projector, &places, &cells.firsts);
        let start = cells.at(&u, &v);
        let (_, [by_u, by_v]) = planes.steps(&start);
        for lane in 0..WIDE {
            (u[lane], v[lane]) = (u[lane] + by_u[lane], v[lane] + by_v[lane]);
        }
        let found = cells.at(&u, &v);
        let (gaps, [by_u, by_v]) = planes.steps(&found);
        let (mut positions, mut normals) = ([[0.0; WIDE]; 3], [[0.0; WIDE]; 3]);
        let (mut misses, mut facing) = ([0.0; WIDE], [0.0; WIDE]);
        for lane in 0..WIDE {
            misses[lane] = gaps[lane] * planes.scales[lane];
            for axis in 0..3 {
                let moved = found.by_u[axis][lane] * by_u[lane] + found.by_v[axis][lane] * by_v[lane];
                positions[axis][lane] = cells.firsts[axis][lane] + f64::from(found.positions[axis][lane] + moved);
                normals[axis][lane] = normal(&found, axis, lane);
                facing[lane] += normals[axis][lane] * planes.directions[axis][lane];
            }
            (u[lane], v[lane]) = (u[lane] + by_u[lane], v[lane] + by_v[lane]);
        }
        let mut are_there = [false; WIDE];
        for lane in 0..WIDE {
            let within = |place: f32, low: f32, high: f32| (place >= low) & (place <= high);
            are_there[lane] = within(misses[lane], 0.0, CLOSE)
                & within(u[lane], -BEYOND, 1.0 + BEYOND)
                & within(v[lane], -BEYOND, 1.0 + BEYOND)
                & (f64::from(facing[lane]) * sides[lane] > 0.0);
        }
        let mut count = 0;
        for lane in 0..walks.len() {
            let mut walk = walks[lane];
            let at = walk.lane as usize;
            if are_there[lane] {
                met.vertices[at] = walk.row * self.columns as u32 + walk.column;
                (met.u[at], met.v[at]) = (f64::from(u[lane]), f64::from(v[lane]));
                for axis in 0..3 {
                    met.positions[axis][at] = positions[axis][lane];
                    met.normals[axis][at] = f64::from(normals[axis][lane]);
                }
                continue;
            }
            if walk.cells == 0 {
                for axis in 0..3 {
                    met.normals[axis][at] = f64::from(normal(&start, axis, lane));
                }
            }
            if walk.cells < MORE_CELLS && self.go_on(&mut walk, [u[lane], v[lane]]) {
                walks[count] = walk;
                count += 1;
            }
        }
        count
    }

    /// Moves a ray to the cell to which its steps lead, or one nearer; returns whether there is any sense in it.
    fn go_on(&self, walk: &mut Walk, [u, v]: [f32; 2]) -> bool {
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
        *walk = Walk { cells: walk.cells + 1, row: row as u32, column: column as u32, u, v, ..*walk };
        true
    }

    /// Gathers the cells of at most [`WIDE`] rays, four at a time; those of other lanes are any.
    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, walks: &[Walk], cells: &mut Cells) {
        for lane in (0..walks.len()).step_by(4) {
            let range = lane..lane + 4;
            let four = [0, 1, 2, 3].map(|next| &walks[(lane + next).min(walks.len() - 1)]);
            cells.steps[range.clone()].copy_from_slice(&four.map(|walk| self.patches.steps[walk.row as usize]));
            let upper = four.map(|walk| walk.row as usize * self.columns + walk.column as usize);
            let mut firsts = None;
            for (v, left) in [upper, upper.map(|upper| upper + self.columns)].into_iter().enumerate() {
                // Two neighbors at once: x, y, z of both.
                let positions = left.map(|left| self.positions[left..left + 2].as_flattened());
                let twists = left.map(|left| self.patches.twists[left..left + 2].as_flattened());
                let tangents = left.map(|left| self.patches.tangents[left..left + 2].as_flattened().as_flattened());
                let [x, y, z, _] = transposed(simd, &positions, 0);
                let [_, next_x, next_y, next_z] = transposed(simd, &positions, 2);
                let firsts = *firsts.get_or_insert([x, y, z]);
                let [tx, ty, tz, _] = transposed(simd, &twists, 0);
                let [_, next_tx, next_ty, next_tz] = transposed(simd, &twists, 2);
                let [sx, sy, sz, vx] = transposed(simd, &tangents, 0);
                let [vy, vz, next_sx, next_sy] = transposed(simd, &tangents, 4);
                let [next_sz, next_vx, next_vy, next_vz] = transposed(simd, &tangents, 8);
                let mut put = |side: usize, of: usize, values: [f32x4<S>; 3]| {
                    for axis in 0..3 {
                        values[axis].store_slice(&mut cells.sides[side][of][axis][range.clone()]);
                    }
                };
                put(v, 0, [x - firsts[0], y - firsts[1], z - firsts[2]]);
                put(v, 1, [next_x - firsts[0], next_y - firsts[1], next_z - firsts[2]]);
                put(v, 2, [sx, sy, sz]);
                put(v, 3, [next_sx, next_sy, next_sz]);
                put(2 + v, 0, [vx, vy, vz]);
                put(2 + v, 1, [next_vx, next_vy, next_vz]);
                put(2 + v, 2, [tx, ty, tz]);
                put(2 + v, 3, [next_tx, next_ty, next_tz]);
            }
            for (axis, first) in firsts.into_iter().flatten().enumerate() {
                let mut single = [0.0; 4];
                first.store_slice(&mut single);
                cells.firsts[axis][range.clone()].copy_from_slice(&single.map(f64::from));
            }
        }
    }
}

/// Returns a component of ∂P/∂u × ∂P/∂v.
#[inline(always)]
fn normal(points: &PatchPoints, axis: usize, lane: usize) -> f32 {
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let [u, v] = [&points.by_u, &points.by_v];
    u[next][lane] * v[last][lane] - u[last][lane] * v[next][lane]
}

/// Returns a point of the cell at a row and column of a grid, at a place in it, and its derivatives by this place; for
/// tests.
pub fn point_of(
    patches: &Patches,
    positions: &[[f32; 3]],
    columns: usize,
    [row, column]: [usize; 2],
    [u, v]: [f64; 2],
    projector: &Projector,
) -> [DVec3; 3] {
    let view = PatchView { patches, positions, columns, rows: positions.len() / columns, projector };
    let mut cells = Cells::default();
    let walk = Walk { row: row as u32, column: column as u32, ..Walk::default() };
    dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || view.gather(simd, &[walk], &mut cells)));
    let points = cells.at(&[u as f32; WIDE], &[v as f32; WIDE]);
    let vector = |of: &[Wide; 3]| DVec3::from_array(of.each_ref().map(|axis| f64::from(axis[0])));
    let first = DVec3::from_array(cells.firsts.map(|axis| axis[0]));
    [first + vector(&points.positions), vector(&points.by_u), vector(&points.by_v)]
}
