//! Points where rays meet a field of heights, near the triangles of its mesh.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use fearless_simd::{Level, dispatch, f32x4, prelude::*};
use glam::DVec3;

use crate::four::transposed;
use crate::grid_values::Number;
use crate::resolve::{BLOCK, Lanes};
use crate::{Channel, ChannelSet, GridSurface, Projector};

/// Number of rays that are solved side by side, in vectors.
const WIDE: usize = 16;
/// How often a ray is looked at.
const LOOKS: u32 = 4;
/// Vertical distance between ray and surface, in pixels, below which one more linear step suffices.
const CLOSE: f64 = 0.01;
/// Most cells between the point of the triangle and that of the surface, along either axis.
const AWAY: f64 = 4.0;
/// Part of a cell by which its own polynomial may be used beyond it: slopes of neighbors are equal along their edge.
const BEYOND: f64 = 1e-3;
/// Part of a cell by which rounding may lead beyond the grid.
const SLACK: f64 = 1e-6;
/// Trails of a cell, filled up to a whole vector.
const TRAILS: usize = 8;

/// A value of each ray.
type Wide = [f32; WIDE];

/// The cells of a [`GridSurface`] as views see them: heights, and the trails that a view wants, in f32.
#[derive(Clone, Debug)]
pub struct HeightField {
    /// Row by row; values of the edge are repeated once around the grid.
    heights: Vec<f32>,
    /// The same for trails; empty if none is wanted.
    trails: Vec<[f32; TRAILS]>,
    /// Values in a row, with those around the grid.
    width: usize,
    /// Last column and row.
    last: [f64; 2],
    spacing: f64,
    origin: [f64; 2],
    level: f64,
}

impl HeightField {
    pub(crate) fn new<T: Number>(grid: &GridSurface<T>, wanted: ChannelSet) -> Self {
        let [columns, rows] = grid.size();
        let width = columns + 2;
        let around = |place: usize, count: usize| place.saturating_sub(1).min(count - 1);
        let cells =
            || (0..rows + 2).flat_map(|j| (0..width).map(move |i| around(j, rows) * columns + around(i, columns)));
        let single = |value: T| Into::<f64>::into(value) as f32;
        let mut trails = Vec::new();
        for (index, channel) in Channel::TRAILS.into_iter().enumerate() {
            // Trails are simulated here, where nothing waits for them, and not when a sample first asks.
            let values = if wanted.contains(channel) { grid.trail(index) } else { &[] };
            if values.is_empty() {
                continue;
            }
            trails.resize(width * (rows + 2), [0.0; TRAILS]);
            for (trails, cell) in trails.iter_mut().zip(cells()) {
                trails[index] = single(values[cell]);
            }
        }
        let heights = grid.heights();
        Self {
            heights: cells().map(|cell| single(heights[cell])).collect(),
            trails,
            width,
            last: [columns - 1, rows - 1].map(|last| last as f64),
            spacing: grid.spacing(),
            origin: grid.origin(),
            level: grid.level(),
        }
    }

    /// Returns the slopes along x and z at a world position x, z, or at the nearest one on the grid.
    pub(crate) fn slopes(&self, place: [f64; 2]) -> [f64; 2] {
        let places = [0, 1].map(|axis| [(place[axis] - self.origin[axis]) / self.spacing; WIDE]);
        let nearest = self.nearest(places.map(|place| place[0])).map(|place| [place; WIDE]);
        let mut cells = Cells::default();
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || self.around(simd, &places, &mut cells)));
        let (_, slopes) = cells.at(&nearest);
        slopes.map(|slopes| f64::from(slopes[0]) / self.spacing)
    }

    /// Returns the bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.heights.len() * size_of::<f32>() + self.trails.len() * size_of::<[f32; TRAILS]>()
    }

    /// Returns the nearest place on the grid, in cells.
    #[inline(always)]
    fn nearest(&self, place: [f64; 2]) -> [f64; 2] {
        [place[0].max(0.0).min(self.last[0]), place[1].max(0.0).min(self.last[1])]
    }

    /// Returns the column and row of the cell at a place, or of the nearest one on the grid.
    #[inline(always)]
    fn corner(&self, place: [f64; 2]) -> [usize; 2] {
        let [x, z] = self.nearest(place);
        [x.min(self.last[0] - 1.0) as usize, z.min(self.last[1] - 1.0) as usize]
    }

    /// Gathers the heights around the cells at some places, or those nearest to them, four at a time.
    #[inline(always)]
    fn around<S: Simd>(&self, simd: S, places: &[[f64; WIDE]; 2], cells: &mut Cells) {
        for lane in (0..WIDE).step_by(4) {
            let range = lane..lane + 4;
            let corners = [0, 1, 2, 3].map(|next| self.corner([places[0][lane + next], places[1][lane + next]]));
            let starts = corners.map(|[i, j]| j * self.width + i);
            let firsts = starts.map(|start| self.heights[start + self.width + 1]);
            cells.first[range.clone()].copy_from_slice(&firsts.map(f64::from));
            for axis in 0..2 {
                cells.corners[axis][range.clone()].copy_from_slice(&corners.map(|corner| corner[axis] as f64));
            }
            let firsts = f32x4::from_slice(simd, &firsts);
            for n in 0..4 {
                let rows = starts.map(|start| &self.heights[start + n * self.width..][..4]);
                for (m, heights) in transposed(simd, &rows, 0).into_iter().enumerate() {
                    (heights - firsts).store_slice(&mut cells.rows[n][m][range.clone()]);
                }
            }
        }
    }
}

/// The heights around a cell of each ray, row by row.
#[derive(Default)]
struct Cells {
    /// Relative to those of the cells' first corners, so that f32 is exact enough.
    rows: [[Wide; 4]; 4],
    first: [f64; WIDE],
    /// Columns and rows of the cells.
    corners: [[f64; WIDE]; 2],
}

/// Catmull–Rom weights of four neighbors at t in 0…1 between the inner two, and their derivatives, as in
/// [`weights`](crate::grid_values::weights).
#[inline(always)]
fn weights(t: f32) -> ([f32; 4], [f32; 4]) {
    let (t2, t3) = (t * t, t * t * t);
    let value = [
        0.5 * (2.0 * t2 - t - t3),
        0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
        0.5 * (t + 4.0 * t2 - 3.0 * t3),
        0.5 * (t3 - t2),
    ];
    let slope = [
        0.5 * (4.0 * t - 1.0 - 3.0 * t2),
        0.5 * (9.0 * t2 - 10.0 * t),
        0.5 * (1.0 + 8.0 * t - 9.0 * t2),
        0.5 * (3.0 * t2 - 2.0 * t),
    ];
    (value, slope)
}

/// Returns Σ wᵢvᵢ of one ray.
#[inline(always)]
fn dot(weights: [f32; 4], values: &[Wide; 4], lane: usize) -> f32 {
    sum(weights, [values[0][lane], values[1][lane], values[2][lane], values[3][lane]])
}

/// Returns Σ aᵢbᵢ.
#[inline(always)]
fn sum(a: [f32; 4], b: [f32; 4]) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

impl Cells {
    /// Returns heights, and their derivatives by the place.
    #[inline(always)]
    fn at(&self, places: &[[f64; WIDE]; 2]) -> ([f64; WIDE], [Wide; 2]) {
        let (mut heights, mut slopes) = ([0.0; WIDE], [[0.0; WIDE]; 2]);
        for lane in 0..WIDE {
            let part = |axis: usize| (places[axis][lane] - self.corners[axis][lane]) as f32;
            let ((wx, dx), (wz, dz)) = (weights(part(0)), weights(part(1)));
            let [a, b, c, d] = &self.rows;
            let values = [dot(wx, a, lane), dot(wx, b, lane), dot(wx, c, lane), dot(wx, d, lane)];
            let by_x = [dot(dx, a, lane), dot(dx, b, lane), dot(dx, c, lane), dot(dx, d, lane)];
            heights[lane] = self.first[lane] + f64::from(sum(wz, values));
            (slopes[0][lane], slopes[1][lane]) = (sum(wz, by_x), sum(dz, values));
        }
        (heights, slopes)
    }
}

/// Rays, and their points on triangles.
pub(crate) struct Starts<'a> {
    pub(crate) count: usize,
    /// Places of the rays across and upward from the middle, as of [`Projector::place`].
    pub(crate) places: &'a [Lanes; 2],
    /// −1 if the outer side is seen, else 1.
    pub(crate) sides: &'a Lanes,
    /// Relative to the camera.
    pub(crate) points: &'a [Lanes; 3],
}

/// Points of a field of heights.
pub(crate) struct Met {
    /// Relative to the camera; those of the triangles where nothing was met.
    pub(crate) points: [Lanes; 3],
    /// Slopes along x and z.
    pub(crate) slopes: [Lanes; 2],
}

/// A ray on its way along its line.
#[derive(Clone, Copy, Default)]
struct Walk {
    lane: usize,
    looks: u32,
    /// Planar depth.
    depth: f64,
}

/// Rays by planar depth, relative to the camera.
struct DepthRays {
    from: [[f64; WIDE]; 3],
    along: [[f64; WIDE]; 3],
}

/// Points of rays over or under the surface.
struct Looked {
    /// Height of the point over the surface, in meters, and its growth per meter of depth.
    gaps: [f64; WIDE],
    closing: [f64; WIDE],
    /// Slopes of the surface along x and z.
    slopes: [[f64; WIDE]; 2],
}

/// A field of heights as a camera sees it.
pub(crate) struct HeightView<'a> {
    field: &'a HeightField,
    projector: &'a Projector,
    /// The camera's place in cells, its height over the level, and cells per meter.
    eye: [f64; 2],
    above: f64,
    per_meter: f64,
}

impl<'a> HeightView<'a> {
    pub(crate) fn new(field: &'a HeightField, projector: &'a Projector) -> Self {
        let (eye, per_meter) = (projector.position, 1.0 / field.spacing);
        let above = eye.y - field.level;
        let eye = [(eye.x - field.origin[0]) * per_meter, (eye.z - field.origin[1]) * per_meter];
        Self { field, projector, eye, above, per_meter }
    }

    /// Moves rays from points of triangles to the surface. A ray that meets nothing nearby, or only the other side,
    /// keeps its point and gets the slopes there.
    #[inline(always)]
    pub(crate) fn meet<S: Simd>(&self, simd: S, starts: &Starts<'_>) -> Met {
        let mut met = Met { points: *starts.points, slopes: [[0.0; BLOCK]; 2] };
        let mut waiting = [Walk::default(); BLOCK];
        let forward = self.projector.forward;
        for lane in 0..starts.count {
            let [x, y, z] = starts.points.each_ref().map(|axis| axis[lane]);
            waiting[lane] = Walk { lane, looks: 0, depth: DVec3::new(x, y, z).dot(forward) };
        }
        let (mut count, mut cells) = (starts.count, Cells::default());
        while count > 0 {
            let first = count.saturating_sub(WIDE);
            count = first + self.advance(simd, &mut waiting[first..count], starts, &mut cells, &mut met);
        }
        met
    }

    /// Takes two steps of at most [`WIDE`] rays, both in the cell to which the first look leads. Returns how many of them,
    /// now the first ones, have to go on.
    #[inline(always)]
    fn advance<S: Simd>(
        &self,
        simd: S,
        walks: &mut [Walk],
        starts: &Starts<'_>,
        cells: &mut Cells,
        met: &mut Met,
    ) -> usize {
        let (mut depths, mut aside) = ([0.0; WIDE], [[0.0; WIDE]; 2]);
        for (lane, walk) in walks.iter().enumerate() {
            depths[lane] = walk.depth;
            for axis in 0..2 {
                aside[axis][lane] = starts.places[axis][walk.lane];
            }
        }
        let rays = self.rays(&aside);
        let places = self.places(&rays, &depths);
        self.field.around(simd, &places, cells);
        let mut nearest = [[0.0; WIDE]; 2];
        for axis in 0..2 {
            for lane in 0..WIDE {
                nearest[axis][lane] = places[axis][lane].max(0.0).min(self.field.last[axis]);
            }
        }
        let start = self.look(cells, &rays, &depths, &nearest);
        for lane in 0..WIDE {
            depths[lane] -= start.gaps[lane] / start.closing[lane];
        }
        let places = self.places(&rays, &depths);
        let found = self.look(cells, &rays, &depths, &places);
        let mut reached = [0.0; WIDE];
        for lane in 0..WIDE {
            reached[lane] = depths[lane] - found.gaps[lane] / found.closing[lane];
        }
        let ends = self.places(&rays, &reached);
        let mut count = 0;
        for lane in 0..walks.len() {
            let walk = walks[lane];
            let at = walk.lane;
            let held = (0..2).all(|axis| (places[axis][lane] - cells.corners[axis][lane] - 0.5).abs() <= 0.5 + BEYOND);
            let on_grid = |places: &[[f64; WIDE]; 2]| {
                (0..2).all(|axis| places[axis][lane] >= -SLACK && places[axis][lane] <= self.field.last[axis] + SLACK)
            };
            let mut point = [0.0; 3];
            for axis in 0..3 {
                point[axis] = rays.from[axis][lane] + reached[lane] * rays.along[axis][lane];
            }
            let moved = |axis: usize| (point[axis] - starts.points[axis][at]).abs() * self.per_meter;
            let scale = if self.projector.orthographic { 1.0 } else { reached[lane] };
            let is_there = held
                && found.gaps[lane].abs() * self.projector.scale <= CLOSE * scale
                && found.closing[lane] * starts.sides[at] > 0.0
                && on_grid(&ends)
                && moved(0) <= AWAY
                && moved(2) <= AWAY;
            if is_there {
                for axis in 0..3 {
                    met.points[axis][at] = point[axis];
                }
            }
            for axis in 0..2 {
                if is_there || walk.looks == 0 {
                    met.slopes[axis][at] = if is_there { found.slopes[axis][lane] } else { start.slopes[axis][lane] };
                }
            }
            if !is_there && walk.looks + 1 < LOOKS && on_grid(&places) {
                walks[count] =
                    Walk { looks: walk.looks + 1, depth: if held { reached[lane] } else { depths[lane] }, ..walk };
                count += 1;
            }
        }
        count
    }

    #[inline(always)]
    fn rays(&self, places: &[[f64; WIDE]; 2]) -> DepthRays {
        let mut rays = DepthRays { from: [[0.0; WIDE]; 3], along: [[0.0; WIDE]; 3] };
        for lane in 0..WIDE {
            let aside = self.projector.right * places[0][lane] + self.projector.up * places[1][lane];
            let (from, along) = if self.projector.orthographic {
                (aside, self.projector.forward)
            } else {
                (DVec3::ZERO, self.projector.forward + aside)
            };
            for axis in 0..3 {
                (rays.from[axis][lane], rays.along[axis][lane]) = (from[axis], along[axis]);
            }
        }
        rays
    }

    /// Returns the places of points of rays, in cells.
    #[inline(always)]
    fn places(&self, rays: &DepthRays, depths: &[f64; WIDE]) -> [[f64; WIDE]; 2] {
        let mut places = [[0.0; WIDE]; 2];
        for (index, axis) in [0, 2].into_iter().enumerate() {
            for lane in 0..WIDE {
                let way = rays.from[axis][lane] + depths[lane] * rays.along[axis][lane];
                places[index][lane] = self.eye[index] + way * self.per_meter;
            }
        }
        places
    }

    #[inline(always)]
    fn look(&self, cells: &Cells, rays: &DepthRays, depths: &[f64; WIDE], places: &[[f64; WIDE]; 2]) -> Looked {
        let (heights, slopes) = cells.at(places);
        let mut looked = Looked { gaps: [0.0; WIDE], closing: [0.0; WIDE], slopes: [[0.0; WIDE]; 2] };
        for lane in 0..WIDE {
            let (x, z) = (f64::from(slopes[0][lane]) * self.per_meter, f64::from(slopes[1][lane]) * self.per_meter);
            let along = [rays.along[0][lane], rays.along[1][lane], rays.along[2][lane]];
            looked.gaps[lane] = self.above + rays.from[1][lane] + depths[lane] * along[1] - heights[lane];
            looked.closing[lane] = along[1] - x * along[0] - z * along[2];
            (looked.slopes[0][lane], looked.slopes[1][lane]) = (x, z);
        }
        looked
    }

    /// Returns the trails at points relative to the camera; 0 for those that are not wanted.
    #[inline(always)]
    pub(crate) fn trails(&self, count: usize, points: &[Lanes; 3]) -> [Lanes; 6] {
        let mut trails = [[0.0; BLOCK]; 6];
        if self.field.trails.is_empty() {
            return trails;
        }
        for lane in 0..count {
            let (x, z) = (points[0][lane] * self.per_meter, points[2][lane] * self.per_meter);
            let place = [self.eye[0] + x, self.eye[1] + z];
            let ([i, j], [x, z]) = (self.field.corner(place), self.field.nearest(place));
            let (wx, wz) = (weights((x - i as f64) as f32).0, weights((z - j as f64) as f32).0);
            let mut sums = [0.0; TRAILS];
            for n in 0..4 {
                let start = (j + n) * self.field.width + i;
                let four = &self.field.trails[start..start + 4];
                for k in 0..TRAILS {
                    let values = [four[0][k], four[1][k], four[2][k], four[3][k]];
                    sums[k] += wz[n] * sum(wx, values);
                }
            }
            for (trail, sum) in trails.iter_mut().zip(sums) {
                trail[lane] = f64::from(sum);
            }
        }
        trails
    }
}
