//! Points where rays meet a field of heights, near the triangles of its mesh.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use glam::DVec3;

use crate::grid_surface::{Weights, weights};
use crate::resolve::{BLOCK, Lanes};
use crate::{GridSurface, Projector};

/// Number of rays that are solved side by side, in vectors.
const WIDE: usize = 8;
/// Newton steps of a ray before it is looked at, and how often it is looked at.
const STEPS: usize = 1;
const LOOKS: u32 = 4;
/// Vertical distance between ray and surface, in pixels, below which one more linear step suffices.
const CLOSE: f64 = 0.01;
/// Most cells between the point of the triangle and that of the surface, along either axis.
const AWAY: f64 = 4.0;
/// Part of a cell by which rounding may lead beyond the grid.
const SLACK: f64 = 1e-6;

/// A ray on its way along its line.
#[derive(Clone, Copy, Default)]
struct Walk {
    lane: usize,
    looks: u32,
    /// Planar depth.
    depth: f64,
}

/// Rays of one pixel row, and their points on triangles.
pub(crate) struct Starts<'a> {
    pub(crate) count: usize,
    /// Pixel column of each ray.
    pub(crate) x: &'a Lanes,
    pub(crate) y: f64,
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

/// Values around a cell, row by row.
type Around = [[[f32; WIDE]; 4]; 4];

/// Returns the interpolation of values around a cell, and its derivatives by the place in it.
#[inline(always)]
fn blend(values: &Around, lane: usize, (wx, dx): Weights, (wz, dz): Weights) -> [f64; 3] {
    let (mut sum, mut by_x, mut by_z) = (0.0, 0.0, 0.0);
    for row in 0..4 {
        let [a, b, c, d] = &values[row];
        let (a, b, c, d) = (f64::from(a[lane]), f64::from(b[lane]), f64::from(c[lane]), f64::from(d[lane]));
        sum += wz[row] * ((wx[0] * a + wx[1] * b) + (wx[2] * c + wx[3] * d));
        by_x += wz[row] * ((dx[0] * a + dx[1] * b) + (dx[2] * c + dx[3] * d));
        by_z += dz[row] * ((wx[0] * a + wx[1] * b) + (wx[2] * c + wx[3] * d));
    }
    [sum, by_x, by_z]
}

/// A field of heights as a camera sees it.
pub(crate) struct HeightView<'a> {
    grid: &'a GridSurface,
    projector: &'a Projector,
    /// The camera's place in cells, its height over the level, and cells per meter.
    eye: DVec3,
    per_meter: f64,
    /// Last column and row.
    last: [f64; 2],
}

impl<'a> HeightView<'a> {
    pub(crate) fn new(grid: &'a GridSurface, projector: &'a Projector) -> Self {
        let (origin, eye, per_meter) = (grid.origin(), projector.position, 1.0 / grid.spacing());
        let eye = DVec3::new((eye.x - origin[0]) * per_meter, eye.y - grid.level(), (eye.z - origin[1]) * per_meter);
        Self { grid, projector, eye, per_meter, last: grid.size().map(|count| (count - 1) as f64) }
    }

    /// Moves rays from points of triangles to the surface. A ray that meets nothing nearby, or only the other side,
    /// keeps its point and gets the slopes there.
    #[inline(always)]
    pub(crate) fn meet(&self, starts: &Starts<'_>) -> Met {
        let mut met = Met { points: *starts.points, slopes: [[0.0; BLOCK]; 2] };
        let mut waiting = [Walk::default(); BLOCK];
        let forward = self.projector.forward;
        for lane in 0..starts.count {
            let [x, y, z] = starts.points.each_ref().map(|axis| axis[lane]);
            waiting[lane] = Walk { lane, looks: 0, depth: DVec3::new(x, y, z).dot(forward) };
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

    /// Takes the steps of some rays. Returns how many of them, now the first ones, have to go on.
    #[inline(always)]
    fn advance(&self, walks: &mut [Walk; WIDE], together: usize, starts: &Starts<'_>, met: &mut Met) -> usize {
        let mut depth = [0.0; WIDE];
        let (mut from, mut along) = ([[0.0; WIDE]; 3], [[0.0; WIDE]; 3]);
        for lane in 0..together {
            let walk = &walks[lane];
            depth[lane] = walk.depth;
            let (across, upward) = self.projector.plane(starts.x[walk.lane], starts.y);
            let aside = across + upward;
            let (start, way) = if self.projector.orthographic {
                (aside, self.projector.forward)
            } else {
                (DVec3::ZERO, self.projector.forward + aside)
            };
            for axis in 0..3 {
                (from[axis][lane], along[axis][lane]) = (start[axis], way[axis]);
            }
        }
        let mut first = [[0.0; WIDE]; 2];
        for step in 0..STEPS {
            let found = self.look(&from, &along, &depth);
            if step == 0 {
                first = found.slopes;
            }
            for lane in 0..WIDE {
                depth[lane] -= found.gap[lane] / found.closing[lane];
            }
        }
        let found = self.look(&from, &along, &depth);
        let mut count = 0;
        for lane in 0..together {
            let walk = walks[lane];
            let at = walk.lane;
            let (gap, closing) = (found.gap[lane], found.closing[lane]);
            let reached = depth[lane] - gap / closing;
            let point = [0, 1, 2].map(|axis| from[axis][lane] + reached * along[axis][lane]);
            let pixel = self.projector.pixel_size(reached);
            let within = [0, 2].map(|axis| {
                let place = self.eye[axis] + point[axis] * self.per_meter;
                let moved = (point[axis] - starts.points[axis][at]).abs() * self.per_meter;
                place >= -SLACK && place <= self.last[axis / 2] + SLACK && moved <= AWAY
            });
            let is_there = gap.abs() <= CLOSE * pixel && within[0] && within[1] && closing * starts.sides[at] > 0.0;
            for axis in 0..3 {
                if is_there {
                    met.points[axis][at] = point[axis];
                }
            }
            for axis in 0..2 {
                if is_there || walk.looks == 0 {
                    met.slopes[axis][at] = if is_there { found.slopes[axis][lane] } else { first[axis][lane] };
                }
            }
            if !is_there && walk.looks + 1 < LOOKS && reached.is_finite() && within[0] && within[1] {
                walks[count] = Walk { looks: walk.looks + 1, depth: reached, ..walk };
                count += 1;
            }
        }
        count
    }

    /// Looks at the surface below or above points of rays; beyond the grid, at that of its edge.
    #[inline(always)]
    fn look(&self, from: &[[f64; WIDE]; 3], along: &[[f64; WIDE]; 3], depth: &[f64; WIDE]) -> Looked {
        let mut at = [[0.0; WIDE]; 2];
        for (index, axis) in [0, 2].into_iter().enumerate() {
            for lane in 0..WIDE {
                at[index][lane] = from[axis][lane] + depth[lane] * along[axis][lane];
            }
        }
        let places = self.places(&at);
        let values = self.around(self.grid.heights(), &places.cells);
        let mut looked = Looked { gap: [0.0; WIDE], closing: [0.0; WIDE], slopes: [[0.0; WIDE]; 2] };
        for lane in 0..WIDE {
            let (x, z) = (weights(places.parts[0][lane]), weights(places.parts[1][lane]));
            let [height, by_x, by_z] = blend(&values, lane, x, z);
            let (by_x, by_z) = (by_x * self.per_meter, by_z * self.per_meter);
            looked.gap[lane] = self.eye.y + from[1][lane] + depth[lane] * along[1][lane] - height;
            looked.closing[lane] = along[1][lane] - by_x * along[0][lane] - by_z * along[2][lane];
            (looked.slopes[0][lane], looked.slopes[1][lane]) = (by_x, by_z);
        }
        looked
    }

    /// Returns the places of points x, z relative to the camera, or of the nearest ones on the grid.
    #[inline(always)]
    fn places(&self, at: &[[f64; WIDE]; 2]) -> Places {
        let mut places = Places { cells: [[0; WIDE]; 2], parts: [[0.0; WIDE]; 2] };
        for (index, eye) in [self.eye.x, self.eye.z].into_iter().enumerate() {
            for lane in 0..WIDE {
                let place = (eye + at[index][lane] * self.per_meter).max(0.0).min(self.last[index]);
                let cell = place.floor().min(self.last[index] - 1.0);
                (places.cells[index][lane], places.parts[index][lane]) = (cell as u32, place - cell);
            }
        }
        places
    }

    /// Gathers the values around cells; those of the edge repeat beyond it.
    #[inline(always)]
    fn around(&self, values: &[f32], cells: &[[u32; WIDE]; 2]) -> Around {
        let [columns, rows] = self.grid.size();
        let mut around = [[[0.0; WIDE]; 4]; 4];
        for lane in 0..WIDE {
            let (i, j) = (cells[0][lane] as usize, cells[1][lane] as usize);
            for row in 0..4 {
                let start = (j + row).saturating_sub(1).min(rows - 1) * columns;
                if i >= 1 && i + 2 < columns {
                    let four = &values[start + i - 1..][..4];
                    for column in 0..4 {
                        around[row][column][lane] = four[column];
                    }
                } else {
                    for column in 0..4 {
                        around[row][column][lane] = values[start + (i + column).saturating_sub(1).min(columns - 1)];
                    }
                }
            }
        }
        around
    }

    /// Returns trails at points relative to the camera, in the order of their indices.
    #[inline(always)]
    pub(crate) fn trails(&self, indices: &[usize], count: usize, points: &[Lanes; 3]) -> [Lanes; 6] {
        let mut trails = [[0.0; BLOCK]; 6];
        for first in (0..count).step_by(WIDE) {
            let mut at = [[0.0; WIDE]; 2];
            for (index, axis) in [0, 2].into_iter().enumerate() {
                at[index].copy_from_slice(&points[axis][first..first + WIDE]);
            }
            let places = self.places(&at);
            for (trail, index) in trails.iter_mut().zip(indices) {
                let values = self.grid.trail(*index);
                if values.is_empty() {
                    continue;
                }
                let values = self.around(values, &places.cells);
                for lane in 0..WIDE {
                    let (x, z) = (weights(places.parts[0][lane]), weights(places.parts[1][lane]));
                    trail[first + lane] = blend(&values, lane, x, z)[0];
                }
            }
        }
        trails
    }
}

/// Cells and the places in them, along x and z.
struct Places {
    cells: [[u32; WIDE]; 2],
    parts: [[f64; WIDE]; 2],
}

/// A surface below or above points of rays.
struct Looked {
    /// Height of the point over the surface, in meters, and its growth per meter of depth.
    gap: [f64; WIDE],
    closing: [f64; WIDE],
    /// Slopes of the surface along x and z.
    slopes: [[f64; WIDE]; 2],
}
