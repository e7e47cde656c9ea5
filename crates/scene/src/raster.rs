//! Which triangle each sample sees.

use std::borrow::Cow;
use std::cell::RefCell;

use trochoid_image::Window;

use crate::Visible;
use crate::project::{BIN, ScreenVertex};

/// The triangle that each sample of a window sees.
pub(crate) struct Seen {
    pub(crate) window: Window,
    /// Primitive and which of its triangles, packed; [`NOTHING`] where there is none.
    pub(crate) triangles: Vec<u64>,
}

/// What samples see that lie side by side, or scattered.
pub(crate) struct Row<'a> {
    /// Their places in the planes to be filled.
    pub(crate) first: usize,
    pub(crate) y: i64,
    /// The first one's pixel, of samples side by side; else that of each.
    pub(crate) x: Result<i64, &'a [[i64; 2]]>,
    pub(crate) triangles: Cow<'a, [u64]>,
}

impl Seen {
    fn start(&self, x: i64, y: i64) -> usize {
        (y - self.window.y0) as usize * self.window.width() + (x - self.window.x0) as usize
    }

    /// The rows of a window within this one.
    pub(crate) fn within(&self, window: Window) -> impl Iterator<Item = Row<'_>> {
        let width = window.width();
        (window.y0..window.y1).enumerate().map(move |(row, y)| {
            let start = self.start(window.x0, y);
            let triangles = self.triangles[start..start + width].into();
            Row { first: row * width, y, x: Ok(window.x0), triangles }
        })
    }

    /// Pixels of this window, by runs in one row.
    pub(crate) fn at<'a>(&'a self, pixels: &'a [[i64; 2]]) -> impl Iterator<Item = Row<'a>> {
        let mut first = 0;
        pixels.chunk_by(|a, b| a[1] == b[1]).map(move |pixels| {
            let triangles = pixels.iter().map(|&[x, y]| self.triangles[self.start(x, y)]).collect();
            let row = Row { first, y: pixels[0][1], x: Err(pixels), triangles };
            first += pixels.len();
            row
        })
    }
}

impl Row<'_> {
    /// The pixel of a sample.
    pub(crate) fn x(&self, column: usize) -> i64 {
        match self.x {
            Ok(first) => first + column as i64,
            Err(pixels) => pixels[column][0],
        }
    }
}

pub(crate) const NOTHING: u64 = u64::MAX;

/// Twice a triangle's signed area and its edge functions at points, exact in i64.
struct Edges {
    /// Edge functions A·x + B·y + C, each positive inside.
    a: [i64; 3],
    b: [i64; 3],
    c: [i64; 3],
    /// Least value inside: 0 where the edge itself belongs to the triangle, else 1.
    least: [i64; 3],
    /// Keys of the corner across from each edge, over twice the area.
    keys: [f64; 3],
}

impl Edges {
    /// `None` for a triangle without area.
    ///
    /// Both orientations are seen: where a sea folds over, its triangles turn over. A sample exactly on an edge
    /// belongs to the triangle for which the edge is a top or a left one, so that exactly one of two neighbors
    /// takes it.
    #[inline]
    fn new(mut corners: [ScreenVertex; 3]) -> Option<Self> {
        let at = |vertex: ScreenVertex| (i64::from(vertex.x), i64::from(vertex.y));
        let [(x0, y0), (x1, y1), (x2, y2)] = corners.map(at);
        let mut area = (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0);
        if area == 0 {
            return None;
        }
        if area < 0 {
            corners.swap(1, 2);
            area = -area;
        }
        let (mut a, mut b, mut c, mut least) = ([0; 3], [0; 3], [0; 3], [0; 3]);
        for edge in 0..3 {
            let (px, py) = at(corners[(edge + 1) % 3]);
            let (qx, qy) = at(corners[(edge + 2) % 3]);
            a[edge] = py - qy;
            b[edge] = qx - px;
            // With positive area and y down: a left edge rises (A > 0), a top edge is level and runs right (B > 0).
            let takes_edge = a[edge] > 0 || (a[edge] == 0 && b[edge] > 0);
            c[edge] = -(a[edge] * px + b[edge] * py);
            least[edge] = i64::from(!takes_edge);
        }
        Some(Self { a, b, c, least, keys: corners.map(|corner| f64::from(corner.key) / area as f64) })
    }

    /// Key at a sample, or `None` outside.
    #[inline]
    fn key(&self, x: i64, y: i64) -> Option<f64> {
        let at = |edge: usize| self.a[edge] * x + self.b[edge] * y + self.c[edge];
        let weights = [at(0), at(1), at(2)];
        if (0..3).any(|edge| weights[edge] < self.least[edge]) {
            return None;
        }
        Some(weights[0] as f64 * self.keys[0] + weights[1] as f64 * self.keys[1] + weights[2] as f64 * self.keys[2])
    }
}

/// Pixels times samples that are looked at together at most: 2 MiB.
const TOGETHER: usize = 1 << 18;
/// Windows that a thread remembers: some views may be asked in turn for each sample.
const REMEMBERED: usize = 4;

thread_local! {
    /// What was seen through the last windows, the latest one first.
    static MEMORY: RefCell<Vec<Remembered>> = const { RefCell::new(Vec::new()) };
}

/// What a view saw through a window, for all samples of its pixels.
struct Remembered {
    view: u64,
    window: Window,
    seen: Vec<Seen>,
}

impl Visible {
    #[inline]
    pub(crate) fn layer(&self, primitive: u32) -> usize {
        match self.firsts.len() {
            1 => 0,
            _ => self.firsts.partition_point(|&first| first <= primitive) - 1,
        }
    }

    /// Hands `take` what is seen through a window by the sample at `offset`.
    ///
    /// Windows are asked for once for each sample of their pixels. Most of the work on a triangle is the same for all
    /// samples, so the first of them does it for the others too, and the thread remembers.
    pub(crate) fn look(&self, window: Window, offset: [f64; 2], take: impl FnOnce(&Seen)) {
        let sample = self.offsets.iter().position(|known| *known == offset);
        let Some(sample) = sample.filter(|_| window.area().saturating_mul(self.offsets.len()) <= TOGETHER) else {
            return take(&self.rasterize(window, &[offset])[0]);
        };
        MEMORY.with_borrow_mut(|memory| {
            let known = |known: &Remembered| known.view == self.number && known.window.intersect(window) == window;
            let known = memory.iter().position(known);
            let known = known.map(|known| memory.remove(known)).unwrap_or_else(|| {
                let seen = self.rasterize(window, &self.offsets);
                Remembered { view: self.number, window, seen }
            });
            take(&known.seen[sample]);
            memory.truncate(REMEMBERED - 1);
            memory.insert(0, known);
        });
    }

    /// The nearest triangle at each sample, for every offset; of two equally near ones that with the lower number.
    pub(crate) fn rasterize(&self, window: Window, offsets: &[[f64; 2]]) -> Vec<Seen> {
        let inside = window.intersect(Window::sized(self.projector.size[0] as u32, self.projector.size[1] as u32));
        let mut seen: Vec<Seen> =
            offsets.iter().map(|_| Seen { window, triangles: vec![NOTHING; window.area()] }).collect();
        if inside.is_empty() {
            return seen;
        }
        let mut keys = vec![f64::NEG_INFINITY; window.area() * offsets.len()];
        let mut samples: Vec<Sample<'_>> = offsets
            .iter()
            .zip(&mut seen)
            .zip(keys.chunks_exact_mut(window.area()))
            .map(|((offset, seen), keys)| Sample {
                shift: offset.map(|part| self.raster.fix(part) as i32),
                seen: &mut seen.triangles,
                keys,
            })
            .collect();
        for bin_y in inside.y0 / BIN[1]..=(inside.y1 - 1) / BIN[1] {
            for bin_x in inside.x0 / BIN[0]..=(inside.x1 - 1) / BIN[0] {
                let (x0, y0) = (bin_x * BIN[0], bin_y * BIN[1]);
                let part = inside.intersect(Window::new(x0, y0, x0 + BIN[0], y0 + BIN[1]));
                let bin = (bin_y * self.bins[0] + bin_x) as usize;
                let range = self.starts[bin] as usize..self.starts[bin + 1] as usize;
                for &primitive in &self.binned[range] {
                    let layer = self.layer(primitive);
                    let local = (primitive - self.firsts[layer]) as usize;
                    let layer = &self.layers[layer];
                    for (half, triangle) in layer.triangles(local).iter().enumerate() {
                        let corners = triangle.map(|vertex| layer.screen[vertex as usize]);
                        let number = u64::from(primitive) * 2 + half as u64;
                        self.cover(corners, number, part, window, &mut samples);
                    }
                }
            }
        }
        seen
    }

    /// Gives every sample of `part` that the triangle covers, and that sees nothing nearer, its number.
    #[inline]
    fn cover(&self, corners: [ScreenVertex; 3], number: u64, part: Window, window: Window, samples: &mut [Sample<'_>]) {
        let bits = self.raster.bits;
        let bounds = |values: [i32; 3]| {
            (values[0].min(values[1]).min(values[2]) + ((1 << bits) - 1), values[0].max(values[1]).max(values[2]))
        };
        let [p, q, r] = corners;
        let (across, down) = (bounds([p.x, q.x, r.x]), bounds([p.y, q.y, r.y]));
        // First and last pixel whose sample lies within the triangle's bounds.
        let range = |(least, most): (i32, i32), shift: i32, low: i64, high: i64| {
            (i64::from((least - shift) >> bits).max(low), i64::from((most - shift) >> bits).min(high - 1))
        };
        let mut edges = None;
        for sample in samples {
            let (y0, y1) = range(down, sample.shift[1], part.y0, part.y1);
            let (x0, x1) = range(across, sample.shift[0], part.x0, part.x1);
            if y0 > y1 || x0 > x1 {
                continue;
            }
            let edges = match &mut edges {
                Some(edges) => edges,
                none => match Edges::new(corners) {
                    Some(edges) => none.insert(edges),
                    None => return,
                },
            };
            let shift = sample.shift.map(i64::from);
            for y in y0..=y1 {
                let row = (y - window.y0) as usize * window.width();
                for x in x0..=x1 {
                    let Some(key) = edges.key((x << bits) + shift[0], (y << bits) + shift[1]) else { continue };
                    let index = row + (x - window.x0) as usize;
                    let nearest = &mut sample.keys[index];
                    if key > *nearest || (key == *nearest && number < sample.seen[index]) {
                        *nearest = key;
                        sample.seen[index] = number;
                    }
                }
            }
        }
    }
}

/// One sample of each pixel of a window.
struct Sample<'a> {
    /// Its offset in fixed point.
    shift: [i32; 2],
    seen: &'a mut [u64],
    /// Keys of what is seen.
    keys: &'a mut [f64],
}
