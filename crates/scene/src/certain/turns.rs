//! Places of a picture where something may have a contour.

use crate::{Channel, ChannelSet, Projector, Samples, Visible};
use glam::DVec3;
use trochoid_image::Window;

/// A box of the picture in which a contour may lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Least x and y in pixels.
    low: [f32; 2],
    /// Greatest x and y.
    high: [f32; 2],
    /// Least planar depth of the contour in meters.
    near: f32,
}

impl Turn {
    /// The whole picture, at any depth.
    pub(crate) fn everywhere(projector: &Projector) -> Self {
        Self { low: [0.0; 2], high: projector.size.map(|side| side as f32), near: f32::NEG_INFINITY }
    }

    /// The box around the hull of points relative to the camera, each of which may stand off by `slack` meters, and
    /// `pixels` more in the picture. `None` where the picture does not hold it.
    pub(crate) fn around(projector: &Projector, points: &[DVec3], slack: f64, pixels: f64) -> Option<Self> {
        let depth = |point: &DVec3| point.dot(projector.forward);
        let near = points.iter().map(depth).fold(f64::INFINITY, f64::min) - slack;
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
                // x/z moves by dx/z + (x/z)·dz/z.
                off = off.max(1.0 + place[axis].abs() / projector.scale);
            }
        }
        let by = if projector.orthographic { slack * projector.scale } else { slack * projector.scale / near * off };
        let [low, high] = [(low, -1.0), (high, 1.0)]
            .map(|(side, sign)| [0, 1].map(|axis| projector.size[axis] / 2.0 + side[axis] + sign * (by + pixels)));
        let [low, high] = [(low, -1.0), (high, 1.0)].map(|(side, sign)| side.map(|at| rounded(at, sign)));
        Some(Self { low, high, near: rounded(near, -1.0) })
    }

    /// How many pixels a length in meters covers at its depth.
    pub(crate) fn pixels(&self, projector: &Projector, meters: f64) -> f64 {
        if projector.orthographic { meters * projector.scale } else { meters * projector.scale / f64::from(self.near) }
    }

    /// The longer side in pixels.
    pub(crate) fn size(&self) -> f64 {
        f64::from((self.high[0] - self.low[0]).max(self.high[1] - self.low[1]))
    }

    fn holds(&self, place: [f64; 2], depth: f64) -> bool {
        let within =
            |axis: usize| place[axis] >= f64::from(self.low[axis]) && place[axis] <= f64::from(self.high[axis]);
        within(0) && within(1) && f64::from(self.near) <= depth
    }
}

/// Whether points lie wholly beyond one side of what the camera sees, or behind it.
fn is_beside(projector: &Projector, points: &[DVec3], slack: f64, pixels: f64) -> bool {
    let (forward, orthographic) = (projector.forward, projector.orthographic);
    let sides = [(0, projector.right), (0, -projector.right), (1, projector.up), (1, -projector.up)];
    let beyond = |(axis, side): (usize, DVec3)| {
        let reach = (projector.size[axis] / 2.0 + pixels + 1.0) / projector.scale;
        let (plane, edge) = if orthographic { (side, reach) } else { (side - forward * reach, 0.0) };
        points.iter().all(|point| point.dot(plane) > edge + slack * plane.length())
    };
    (!orthographic && points.iter().all(|point| point.dot(forward) < -slack)) || sides.into_iter().any(beyond)
}

/// What contours are looked for in.
#[derive(Debug)]
pub struct Search<'a> {
    pub(crate) projector: &'a Projector,
    /// How far the raster may have moved a place, in pixels.
    pub(crate) step: f64,
    columns: usize,
    /// By pixel: the greatest depth that any of its samples sees.
    farthest: Vec<f32>,
}

impl<'a> Search<'a> {
    /// In all that a view sees.
    pub(super) fn new(visible: &'a Visible) -> Self {
        let [columns, rows] = visible.projector.size.map(|side| side as u32);
        let mut farthest = vec![f32::NEG_INFINITY; columns as usize * rows as usize];
        let mut samples = Samples::new();
        for offset in &visible.offsets {
            visible.fill(Window::sized(columns, rows), *offset, ChannelSet::DEPTH, &mut samples);
            for (farthest, depth) in farthest.iter_mut().zip(samples.channel(Channel::Depth)) {
                *farthest = farthest.max(*depth);
            }
        }
        Self { projector: &visible.projector, step: visible.raster.step(), columns: columns as usize, farthest }
    }

    /// Whether all samples of the pixels that a box meets see what is nearer.
    pub(crate) fn hides(&self, turn: &Turn) -> bool {
        let size = [self.columns, self.farthest.len() / self.columns];
        let mut hidden = true;
        each_pixel(turn, size, |pixel, _| hidden &= self.farthest[pixel] * (1.0 + 2e-6) < turn.near);
        hidden
    }
}

/// To f32, away from what lies on the other side.
fn rounded(value: f64, sign: f64) -> f32 {
    let near = value as f32;
    if sign < 0.0 { near.next_down() } else { near.next_up() }
}

/// Boxes by the pixels that they meet.
#[derive(Debug)]
pub(super) struct Turns {
    columns: usize,
    rows: usize,
    /// By pixel: the least depth of all boxes that hold the whole of it; NaN where none does.
    covered: Vec<f32>,
    /// Where each pixel's boxes begin that hold a part of it, with one more entry.
    starts: Vec<u32>,
    boxes: Vec<Turn>,
}

impl Turns {
    pub(super) fn new(projector: &Projector, turns: &[Turn]) -> Self {
        let [columns, rows] = projector.size.map(|side| side as usize);
        let mut covered = vec![f32::NAN; columns * rows];
        let mut starts = vec![0_u32; columns * rows + 1];
        // First how many each pixel has, then the boxes themselves.
        for turn in turns {
            each_pixel(turn, [columns, rows], |pixel, whole| {
                if whole {
                    covered[pixel] = covered[pixel].min(turn.near);
                } else {
                    starts[pixel + 1] += 1;
                }
            });
        }
        for pixel in 0..columns * rows {
            starts[pixel + 1] += starts[pixel];
        }
        let mut next = starts.clone();
        let nothing = Turn { low: [0.0; 2], high: [0.0; 2], near: 0.0 };
        let mut boxes = vec![nothing; starts[columns * rows] as usize];
        for turn in turns {
            each_pixel(turn, [columns, rows], |pixel, whole| {
                if !whole {
                    boxes[next[pixel] as usize] = *turn;
                    next[pixel] += 1;
                }
            });
        }
        Self { columns, rows, covered, starts, boxes }
    }

    /// Whether some box holds a place, and may be as near as a depth.
    pub(super) fn cover(&self, place: [f64; 2], depth: f64) -> bool {
        let [x, y] = place.map(|at| at.floor());
        if x < 0.0 || y < 0.0 || x >= self.columns as f64 || y >= self.rows as f64 {
            return true;
        }
        let pixel = y as usize * self.columns + x as usize;
        // Depths of the raster are f32.
        let depth = depth * (1.0 + 1e-6);
        let boxes = &self.boxes[self.starts[pixel] as usize..self.starts[pixel + 1] as usize];
        f64::from(self.covered[pixel]) <= depth || boxes.iter().any(|turn| turn.holds(place, depth))
    }
}

/// Every pixel that a box meets, and whether the box holds it whole.
fn each_pixel(turn: &Turn, [columns, rows]: [usize; 2], mut take: impl FnMut(usize, bool)) {
    let range = |axis: usize, count: usize| {
        let first = turn.low[axis].floor().max(0.0) as usize;
        first..(turn.high[axis].floor() as usize + 1).min(count)
    };
    if turn.high[0] < 0.0 || turn.high[1] < 0.0 {
        return;
    }
    let whole = |axis: usize, at: usize| turn.low[axis] <= at as f32 && turn.high[axis] >= (at + 1) as f32;
    for y in range(1, rows) {
        for x in range(0, columns) {
            take(y * columns + x, whole(0, x) && whole(1, y));
        }
    }
}
