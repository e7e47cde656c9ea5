//! Positions in a picture where a contour may be.

use crate::{Projector, Visible};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicI32, AtomicU64, Ordering};
use trochoid_image::Window;

/// A box of the picture in which a contour may lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContourBox {
    /// Least x and y, in pixels.
    low: [f32; 2],
    /// Greatest x and y, in pixels.
    high: [f32; 2],
    /// Least planar depth of the contour, in meters.
    near: f32,
}

impl ContourBox {
    /// Returns the whole picture, at any depth.
    pub(crate) fn everywhere(projector: &Projector) -> Self {
        Self { low: [0.0; 2], high: projector.size.map(|side| side as f32), near: f32::NEG_INFINITY }
    }

    /// Returns the box around the convex hull of points relative to the camera, each of which may be off by `slack`
    /// meters, and by another `pixels` in the picture. `None` if it is outside of the picture.
    pub(crate) fn around(projector: &Projector, points: &[DVec3], slack: f64, pixels: f64) -> Option<Self> {
        let depth = |point: &DVec3| point.dot(projector.forward);
        let near = points.iter().map(depth).fold(f64::INFINITY, f64::min) - slack;
        if !points.iter().all(|point| point.is_finite()) {
            return Some(Self::everywhere(projector));
        }
        if is_beside(projector, points, slack, pixels) {
            return None;
        }
        if near <= 0.0 && !projector.orthographic {
            return Some(Self { near: near as f32, ..Self::everywhere(projector) });
        }
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut off = 0.0_f64;
        for point in points {
            let scale = if projector.orthographic { projector.scale } else { projector.scale / depth(point) };
            let place = [point.dot(projector.right) * scale, -point.dot(projector.up) * scale];
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
                // x/z changes by dx/z + (x/z)·dz/z.
                off = off.max(1.0 + place[axis].abs() / projector.scale);
            }
        }
        let by = if projector.orthographic { slack * projector.scale } else { slack * projector.scale / near * off };
        let [low, high] = [(low, -1.0), (high, 1.0)]
            .map(|(side, sign)| [0, 1].map(|axis| projector.size[axis] / 2.0 + side[axis] + sign * (by + pixels)));
        let [low, high] = [(low, -1.0), (high, 1.0)].map(|(side, sign)| side.map(|at| rounded(at, sign)));
        Some(Self { low, high, near: rounded(near, -1.0) })
    }

    /// Returns how many pixels a length in meters covers at its depth.
    pub(crate) fn pixels(&self, projector: &Projector, meters: f64) -> f64 {
        if projector.orthographic { meters * projector.scale } else { meters * projector.scale / f64::from(self.near) }
    }

    /// Returns the longer side, in pixels.
    pub(crate) fn size(&self) -> f64 {
        f64::from((self.high[0] - self.low[0]).max(self.high[1] - self.low[1]))
    }

    /// Returns whether the contour may lie on both sides of the camera's plane, where meshes end.
    pub(crate) fn is_cut(&self) -> bool {
        self.near <= 0.0
    }
}

/// Returns whether all points lie beyond one side of what the camera sees, or behind it.
fn is_beside(projector: &Projector, points: &[DVec3], slack: f64, pixels: f64) -> bool {
    let (forward, orthographic) = (projector.forward, projector.orthographic);
    let sides = [(0, projector.right), (0, -projector.right), (1, projector.up), (1, -projector.up)];
    let beyond = |(axis, side): (usize, DVec3)| {
        let reach = (projector.size[axis] / 2.0 + pixels + 1.0) / projector.scale;
        let (plane, edge) = if orthographic { (side, reach) } else { (side - forward * reach, 0.0) };
        points.iter().all(|point| point.dot(plane) > edge + slack * plane.length())
    };
    points.iter().all(|point| point.dot(forward) < -slack) || sides.into_iter().any(beyond)
}

/// Number of rows of pixels that are processed together.
const BAND: usize = 32;

/// A search for all contours of a view.
pub struct Search<'a> {
    pub(crate) projector: &'a Projector,
    /// Rounding error of positions in the raster, in pixels.
    pub(crate) step: f64,
    /// Greatest depth at which any sample of a pixel may see something, by pixel.
    farthest: Vec<f32>,
    marks: Marks,
    stop: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Search<'a> {
    /// Starts a search in everything that a view sees. `further` is the share of the depth by which the surface may
    /// lie behind its mesh.
    pub(super) fn new(visible: &'a Visible, further: f64, stop: &'a (dyn Fn() -> bool + Sync)) -> Self {
        let projector = &visible.projector;
        let [columns, rows] = projector.size.map(|side| side as usize);
        let mut farthest = vec![f32::NEG_INFINITY; columns * rows];
        let bands = farthest.par_chunks_mut(columns * BAND).enumerate();
        bands.for_each(|(band, farthest)| {
            let first = (band * BAND) as i64;
            let window = Window::new(0, first, columns as i64, first + (farthest.len() / columns) as i64);
            for offset in visible.offsets.iter().filter(|_| !stop()) {
                let sheets = visible.nearest_sheets(window, *offset);
                for (farthest, depth) in farthest.iter_mut().zip(sheets.depths(projector)) {
                    *farthest = farthest.max((depth + (further * depth).abs()) as f32);
                }
            }
        });
        let pixels = columns * rows;
        let marks = Marks {
            columns,
            places: (0..pixels).map(|_| AtomicU64::new(0)).collect(),
            nearest: (0..pixels).map(|_| AtomicI32::new(ordered(f32::INFINITY))).collect(),
        };
        Self { projector, step: visible.raster.step(), farthest, marks, stop }
    }

    /// Returns whether the result is no longer needed.
    pub(crate) fn is_stopped(&self) -> bool {
        (self.stop)()
    }

    /// Returns whether all samples of the pixels that a box touches see something nearer.
    pub(crate) fn hides(&self, contour: &ContourBox) -> bool {
        let mut hidden = true;
        self.marks.each_pixel(contour, |pixel, _| hidden &= self.farthest[pixel] < contour.near);
        hidden
    }

    /// Records that a contour may lie in a box.
    pub(crate) fn mark(&self, contour: &ContourBox) {
        self.marks.each_pixel(contour, |pixel, places| {
            self.marks.places[pixel].fetch_or(places, Ordering::Relaxed);
            self.marks.nearest[pixel].fetch_min(ordered(contour.near), Ordering::Relaxed);
        });
    }

    pub(super) fn marks(self) -> Marks {
        self.marks
    }
}

/// Rounds to f32 in the direction of `sign`, by at least one step.
fn rounded(value: f64, sign: f64) -> f32 {
    let near = value as f32;
    if sign < 0.0 { near.next_down() } else { near.next_up() }
}

/// Returns integers in the order of floating-point numbers.
fn ordered(value: f32) -> i32 {
    let bits = value.to_bits() as i32;
    bits ^ ((bits >> 31) as u32 >> 1) as i32
}

/// Number of rows and of columns into which a pixel is divided.
const DIVIDED: usize = 8;

/// Positions where contours may lie.
#[derive(Debug)]
pub(super) struct Marks {
    columns: usize,
    /// One bit for each part of a pixel, row by row; by pixel.
    places: Vec<AtomicU64>,
    /// Least depth of all its contours, [`ordered`]; by pixel.
    nearest: Vec<AtomicI32>,
}

impl Marks {
    /// Returns whether a contour may lie at a position, at most as far as a depth.
    pub(super) fn cover(&self, [x, y]: [f64; 2], depth: f64) -> bool {
        let (column, row) = (x.floor(), y.floor());
        if column < 0.0 || row < 0.0 || column >= self.columns as f64 || row >= self.rows() as f64 {
            return true;
        }
        let pixel = row as usize * self.columns + column as usize;
        let part = |at: f64, from: f64| ((at - from) * DIVIDED as f64) as usize;
        let place = part(y, row) * DIVIDED + part(x, column);
        // Depths of the raster are f32.
        let depth = ordered((depth * (1.0 + 1e-6)) as f32);
        let is_near = self.nearest[pixel].load(Ordering::Relaxed) <= depth;
        is_near && self.places[pixel].load(Ordering::Relaxed) >> place & 1 == 1
    }

    fn rows(&self) -> usize {
        self.places.len() / self.columns
    }

    /// Calls `take` for every pixel that a box touches, with the parts that it touches.
    fn each_pixel(&self, contour: &ContourBox, mut take: impl FnMut(usize, u64)) {
        // Parts of pixels, clamped to the picture; NaN counts as everywhere.
        let range = |axis: usize, count: usize| {
            let last = (count * DIVIDED) as f32;
            let [low, high] = [contour.low[axis], contour.high[axis]].map(|at| at * DIVIDED as f32);
            let from = if low > 0.0 { low.min(last) as usize } else { 0 };
            let to = if high < last { (high + 1.0).max(0.0) as usize } else { last as usize };
            from..to
        };
        let (across, down) = (range(0, self.columns), range(1, self.rows()));
        if across.is_empty() || down.is_empty() {
            return;
        }
        // Parts of one pixel among those along an axis.
        let own = |parts: &Range<usize>, pixel: usize| {
            let of = |at: usize| at.saturating_sub(pixel * DIVIDED).min(DIVIDED);
            of(parts.start)..of(parts.end)
        };
        for y in down.start / DIVIDED..down.end.div_ceil(DIVIDED) {
            for x in across.start / DIVIDED..across.end.div_ceil(DIVIDED) {
                let columns = own(&across, x).fold(0_u64, |bits, part| bits | 1 << part);
                let places = own(&down, y).fold(0_u64, |bits, part| bits | columns << (part * DIVIDED));
                take(y * self.columns + x, places);
            }
        }
    }
}
