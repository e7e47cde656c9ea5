//! Finds the triangle that each sample sees.

mod batch;
mod samples;

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

use fearless_simd::{Level, Simd, dispatch};
use trochoid_image::Window;
use trochoid_memory::Scratch;

use crate::Visible;
use crate::project::{BIN, Layer};
use crate::surface::Topology;
use batch::Batch;
use samples::PixelSamples;

/// A triangle that a sample sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SeenTriangle {
    pub(crate) primitive: u32,
    /// Index of the primitive's triangle: 0 or 1.
    pub(crate) part: u32,
    /// Row of the primitive if it is a cell of a grid, else 0.
    pub(crate) row: u32,
}

impl SeenTriangle {
    /// Returns a number that grows with the primitive, then with the part. It holds the row, too, which takes a division
    /// to find; rows of two vertices or more are fewer than 2³¹.
    #[inline(always)]
    pub(crate) fn pack(self) -> u64 {
        u64::from(self.primitive) << 32 | u64::from(self.part) << 31 | u64::from(self.row)
    }

    #[inline(always)]
    pub(crate) fn unpack(number: u64) -> Self {
        Self { primitive: (number >> 32) as u32, part: (number >> 31) as u32 & 1, row: number as u32 & (u32::MAX >> 1) }
    }
}

pub(crate) const NOTHING: u64 = u64::MAX;

/// Triangles that one sample of each pixel of a window sees.
#[derive(Clone, Copy)]
pub(crate) struct SeenTriangles<'a> {
    window: Window,
    /// By pixel and sample: a packed [`SeenTriangle`]; [`NOTHING`] if there is none.
    triangles: &'a [u64],
    samples: usize,
    sample: usize,
}

/// Triangles seen by samples that are adjacent or scattered.
pub(crate) struct Row<'a> {
    /// Index of the first sample in the planes to be filled.
    pub(crate) first: usize,
    pub(crate) y: i64,
    pub(crate) len: usize,
    /// First pixel of adjacent samples; otherwise the pixel of each sample.
    x: Result<i64, &'a [[i64; 2]]>,
    seen: SeenTriangles<'a>,
}

impl<'a> SeenTriangles<'a> {
    /// Returns the packed triangle that a pixel sees.
    #[inline]
    pub(crate) fn triangle(self, x: i64, y: i64) -> u64 {
        let pixel = (y - self.window.y0) as usize * self.window.width() + (x - self.window.x0) as usize;
        self.triangles[pixel * self.samples + self.sample]
    }

    /// Returns the rows of a window within this one.
    pub(crate) fn within(self, window: Window) -> impl Iterator<Item = Row<'a>> {
        let len = window.width();
        (window.y0..window.y1).enumerate().map(move |(row, y)| Row {
            first: row * len,
            y,
            len,
            x: Ok(window.x0),
            seen: self,
        })
    }

    /// Returns pixels of this window, as runs in one row.
    pub(crate) fn at(self, pixels: &'a [[i64; 2]]) -> impl Iterator<Item = Row<'a>> {
        let mut first = 0;
        pixels.chunk_by(|a, b| a[1] == b[1]).map(move |pixels| {
            let row = Row { first, y: pixels[0][1], len: pixels.len(), x: Err(pixels), seen: self };
            first += pixels.len();
            row
        })
    }
}

impl Row<'_> {
    /// Returns the pixel column of a sample.
    #[inline]
    pub(crate) fn x(&self, column: usize) -> i64 {
        match self.x {
            Ok(first) => first + column as i64,
            Err(pixels) => pixels[column][0],
        }
    }

    /// Returns the packed triangles of samples from one on; `None` if these are not adjacent, or not so many.
    #[inline(always)]
    pub(crate) fn adjacent<const N: usize>(&self, column: usize) -> Option<[u64; N]> {
        let x = self.x.ok().filter(|_| column + N <= self.len)? + column as i64;
        let SeenTriangles { window, triangles, samples, sample } = self.seen;
        let first = (self.y - window.y0) as usize * window.width() + (x - window.x0) as usize;
        let triangles = &triangles[first * samples..(first + N) * samples];
        let mut seen = [0; N];
        match triangles.as_chunks::<4>() {
            (of_pixels, []) if samples == 4 => (0..N).for_each(|pixel| seen[pixel] = of_pixels[pixel][sample & 3]),
            _ => (0..N).for_each(|pixel| seen[pixel] = triangles[pixel * samples + sample]),
        }
        Some(seen)
    }

    /// Returns the packed triangle that a sample sees.
    #[inline]
    pub(crate) fn triangle(&self, column: usize) -> u64 {
        self.seen.triangle(self.x(column), self.y)
    }
}

/// Most pixels times samples that are processed together: 16 MiB.
const TOGETHER: usize = 1 << 21;
/// Number of windows that a thread remembers: several views may be evaluated in turn for each sample.
const REMEMBERED: usize = 4;

#[derive(Default)]
struct RasterMemory {
    /// Results of the last windows, the latest first.
    windows: Vec<RememberedWindow>,
    /// Scratch space for the keys of visible triangles during rasterization.
    keys: Vec<f64>,
}

thread_local! {
    static MEMORY: RefCell<RasterMemory> = RefCell::default();
}

/// Triangles that a view saw through a window, for some samples of its pixels.
struct RememberedWindow {
    view: u64,
    window: Window,
    triangles: Vec<u64>,
}

impl Visible {
    /// Bytes that a thread holds per sample, for all views together.
    pub const BYTES_OF_SAMPLE: u64 = (REMEMBERED * size_of::<u64>() + size_of::<f64>()) as u64;
    /// Most samples that a thread processes together.
    pub const MOST_SAMPLES: u64 = TOGETHER as u64;

    #[inline]
    pub(crate) fn layer(&self, primitive: u32) -> usize {
        match self.firsts.len() {
            1 => 0,
            _ => self.firsts.partition_point(|&first| first <= primitive) - 1,
        }
    }

    /// Hands `take` the triangles that the sample at `offset` sees through a window.
    ///
    /// Windows are requested once for each sample of their pixels. Most of the work on a triangle is the same for all
    /// samples, so the first request does it for the others too, and the thread remembers the result.
    pub(crate) fn look(&self, window: Window, offset: [f64; 2], take: impl FnOnce(SeenTriangles<'_>)) {
        self.look_through(window, window, offset, take);
    }

    /// Does the same where other samples of the pixels are likely to be asked for through a window that differs a little:
    /// looks at whole bins.
    pub(crate) fn look_around(&self, window: Window, offset: [f64; 2], take: impl FnOnce(SeenTriangles<'_>)) {
        let first = |axis: usize, at: i64| at.div_euclid(BIN[axis]) * BIN[axis];
        let [x0, y0] = [first(0, window.x0), first(1, window.y0)];
        let [x1, y1] = [first(0, window.x1 - 1) + BIN[0], first(1, window.y1 - 1) + BIN[1]];
        let picture = Window::sized(self.projector.size[0] as u32, self.projector.size[1] as u32);
        let bins = Window::new(x0, y0, x1, y1).intersect(picture).union(window);
        let is_held = self.covers(bins) && bins.area().saturating_mul(self.offsets.len()) <= TOGETHER;
        self.look_through(window, if is_held { bins } else { window }, offset, take);
    }

    fn look_through(&self, window: Window, larger: Window, offset: [f64; 2], take: impl FnOnce(SeenTriangles<'_>)) {
        let sample = self.offsets.iter().position(|known| *known == offset);
        let sample = sample.filter(|_| larger.area().saturating_mul(self.offsets.len()) <= TOGETHER);
        MEMORY.with_borrow_mut(|memory| {
            let Some(sample) = sample else {
                let mut triangles = Scratch::new();
                self.rasterize(window, &[offset], &mut triangles, &mut memory.keys);
                return take(SeenTriangles { window, triangles: &triangles, samples: 1, sample: 0 });
            };
            let known =
                |known: &RememberedWindow| known.view == self.number && known.window.intersect(window) == window;
            let known = match memory.windows.iter().position(known) {
                Some(known) => memory.windows.remove(known),
                None => {
                    // The memory of the oldest window is reused for the new one.
                    let oldest = if memory.windows.len() == REMEMBERED { memory.windows.pop() } else { None };
                    let mut triangles = oldest.map(|oldest| oldest.triangles).unwrap_or_default();
                    self.rasterize(larger, &self.offsets, &mut triangles, &mut memory.keys);
                    RememberedWindow { view: self.number, window: larger, triangles }
                }
            };
            let (samples, triangles) = (self.offsets.len(), &known.triangles[..]);
            take(SeenTriangles { window: known.window, triangles, samples, sample });
            memory.windows.insert(0, known);
        });
    }

    /// Finds the nearest triangle at each sample, by pixel and offset; of two equally near ones, the one with the
    /// lower number.
    fn rasterize(&self, window: Window, offsets: &[[f64; 2]], triangles: &mut Vec<u64>, keys: &mut Vec<f64>) {
        let count = window.area() * offsets.len();
        refill(triangles, count, NOTHING);
        refill(keys, count, f64::NEG_INFINITY);
        let shift = |offset: [f64; 2]| offset.map(|part| self.raster.fix(part) as i32);
        let mut shifts = offsets.iter().copied().map(shift);
        let mut next = |_| shifts.next().unwrap_or_default();
        match offsets.len() {
            4 => self.cover_all::<4>(window, std::array::from_fn(&mut next), triangles, keys),
            16 => self.cover_all::<16>(window, std::array::from_fn(&mut next), triangles, keys),
            _ => self.cover_all::<1>(window, std::array::from_fn(&mut next), triangles, keys),
        }
    }

    fn cover_all<const N: usize>(
        &self,
        window: Window,
        shifts: [[i32; 2]; N],
        triangles: &mut [u64],
        keys: &mut [f64],
    ) {
        let inside = window.intersect(Window::sized(self.projector.size[0] as u32, self.projector.size[1] as u32));
        let (triangles, keys) = (triangles.as_chunks_mut::<N>().0, keys.as_chunks_mut::<N>().0);
        let mut samples = PixelSamples::new(window, shifts, self.raster.bits, triangles, keys);
        let mut batch = Batch::default();
        for bin_y in inside.y0.div_euclid(BIN[1])..inside.y1.div_euclid(BIN[1]) + 1 {
            for bin_x in inside.x0.div_euclid(BIN[0])..inside.x1.div_euclid(BIN[0]) + 1 {
                let (x0, y0) = (bin_x * BIN[0], bin_y * BIN[1]);
                let part = inside.intersect(Window::new(x0, y0, x0 + BIN[0], y0 + BIN[1]));
                if part.is_empty() {
                    continue;
                }
                let bin = (bin_y * self.bins[0] + bin_x) as usize;
                let range = self.starts[bin] as usize..self.starts[bin + 1] as usize;
                dispatch!(Level::new(), simd => simd.vectorize(
                    #[inline(always)]
                    || self.cover_bin(&self.binned[range], part, &mut samples, &mut batch)
                ));
            }
        }
    }

    #[inline(always)]
    fn cover_bin<const N: usize>(
        &self,
        primitives: &[u32],
        part: Window,
        samples: &mut PixelSamples<'_, N>,
        batch: &mut Batch,
    ) {
        let mut at = Cursor { layers: &self.layers, firsts: &self.firsts, layer: 0, row: 0, cells: 0..0 };
        for &primitive in primitives {
            if batch.is_full() {
                samples.cover(batch, part);
            }
            let (layer, corners) = at.corners(primitive);
            let number = |part: u32, row: u32| SeenTriangle { primitive, part, row }.pack();
            let corner = |vertex: u32| layer.screen[vertex as usize];
            match corners {
                Ok([a, b, c, d]) => {
                    let [a, b, c, d] = [corner(a), corner(b), corner(c), corner(d)];
                    batch.push([a, b, c], number(0, at.row));
                    batch.push([b, d, c], number(1, at.row));
                }
                Err([a, b, c]) => batch.push([corner(a), corner(b), corner(c)], number(0, 0)),
            }
        }
        samples.cover(batch, part);
    }
}

/// Fills a list with a number of equal items. A new list has room for no more: windows differ a little in size, and room for
/// twice as much would stay unused. Nothing of the old one is copied.
fn refill<T: Clone>(list: &mut Vec<T>, count: usize, item: T) {
    list.clear();
    if list.capacity() < count {
        *list = Vec::with_capacity(count);
    }
    list.resize(count, item);
}

/// Steps through primitives that mostly follow one another.
struct Cursor<'a> {
    layers: &'a [Arc<Layer>],
    firsts: &'a [u32],
    /// Layer of the last primitive, and for a grid its row and the row's cells.
    layer: usize,
    row: u32,
    cells: Range<u32>,
}

impl<'a> Cursor<'a> {
    /// Returns the layer of a primitive and its corners: four for a cell, in the order of [`Layer::triangles`], or
    /// three.
    #[inline(always)]
    fn corners(&mut self, primitive: u32) -> (&'a Layer, Result<[u32; 4], [u32; 3]>) {
        let is_within = |layer: usize| {
            self.firsts[layer] <= primitive && self.firsts.get(layer + 1).is_none_or(|next| primitive < *next)
        };
        if !is_within(self.layer) {
            self.layer = self.firsts.partition_point(|&first| first <= primitive) - 1;
            self.cells = 0..0;
        }
        let layer = &self.layers[self.layer];
        let local = primitive - self.firsts[self.layer];
        if local as usize >= layer.primitives {
            return (layer, Err(layer.clipped[local as usize - layer.primitives]));
        }
        match &layer.mesh.topology {
            Topology::Triangles(triangles) => (layer, Err(triangles[local as usize])),
            Topology::Grid { columns, .. } => {
                let columns = *columns as u32;
                if !self.cells.contains(&local) {
                    self.row = local / (columns - 1);
                    let first = self.row * (columns - 1);
                    self.cells = first..first + columns - 1;
                }
                let a = self.row * columns + (local - self.cells.start);
                (layer, Ok([a, a + 1, a + columns, a + columns + 1]))
            }
        }
    }
}
