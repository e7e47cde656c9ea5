//! Finds the triangle that each sample sees.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use std::cell::RefCell;
use std::ops::Range;

use fearless_simd::{Level, Simd, dispatch};
use trochoid_image::Window;

use crate::Visible;
use crate::edges::{Edges, Whole};
use crate::project::{BIN, Layer, ScreenVertex};
use crate::surface::Topology;

/// Triangles that one sample of each pixel of a window sees.
#[derive(Clone, Copy)]
pub(crate) struct SeenTriangles<'a> {
    window: Window,
    /// By pixel and sample: the primitive and the index of its triangle, packed; [`NOTHING`] if there is none.
    triangles: &'a [u64],
    samples: usize,
    sample: usize,
}

pub(crate) const NOTHING: u64 = u64::MAX;

/// Triangles seen by samples that are adjacent or scattered.
pub(crate) struct Row<'a> {
    /// Index of the first sample in the planes to be filled.
    pub(crate) first: usize,
    pub(crate) y: i64,
    /// First pixel of adjacent samples; otherwise the pixel of each sample.
    x: Result<i64, &'a [[i64; 2]]>,
    pub(crate) triangles: Vec<u64>,
}

impl<'a> SeenTriangles<'a> {
    /// Returns the triangle that a pixel sees.
    pub(crate) fn triangle(self, x: i64, y: i64) -> u64 {
        let pixel = (y - self.window.y0) as usize * self.window.width() + (x - self.window.x0) as usize;
        self.triangles[pixel * self.samples + self.sample]
    }

    /// Returns the rows of a window within this one.
    pub(crate) fn within(self, window: Window) -> impl Iterator<Item = Row<'a>> {
        (window.y0..window.y1).enumerate().map(move |(row, y)| {
            let triangles = (window.x0..window.x1).map(|x| self.triangle(x, y)).collect();
            Row { first: row * window.width(), y, x: Ok(window.x0), triangles }
        })
    }

    /// Returns pixels of this window, as runs in one row.
    pub(crate) fn at(self, pixels: &'a [[i64; 2]]) -> impl Iterator<Item = Row<'a>> {
        let mut first = 0;
        pixels.chunk_by(|a, b| a[1] == b[1]).map(move |pixels| {
            let triangles = pixels.iter().map(|&[x, y]| self.triangle(x, y)).collect();
            let row = Row { first, y: pixels[0][1], x: Err(pixels), triangles };
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
        let sample = self.offsets.iter().position(|known| *known == offset);
        let sample = sample.filter(|_| window.area().saturating_mul(self.offsets.len()) <= TOGETHER);
        MEMORY.with_borrow_mut(|memory| {
            let Some(sample) = sample else {
                let mut triangles = Vec::new();
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
                    self.rasterize(window, &self.offsets, &mut triangles, &mut memory.keys);
                    RememberedWindow { view: self.number, window, triangles }
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
        // Windows differ a little in size; room for twice as much would stay unused.
        triangles.clear();
        triangles.reserve_exact(count);
        triangles.resize(count, NOTHING);
        keys.clear();
        keys.reserve_exact(count);
        keys.resize(count, f64::NEG_INFINITY);
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
                    || self.cover_bin(&self.binned[range], part, &mut samples)
                ));
            }
        }
    }

    #[inline(always)]
    fn cover_bin<const N: usize>(&self, primitives: &[u32], part: Window, samples: &mut PixelSamples<'_, N>) {
        let mut at = Cursor { layers: &self.layers, firsts: &self.firsts, layer: 0, row: 0, cells: 0..0 };
        for &primitive in primitives {
            let number = u64::from(primitive) * 2;
            let (layer, corners) = at.corners(primitive);
            match corners {
                Ok([a, b, c, d]) => {
                    let corner = |vertex: u32| layer.screen[vertex as usize];
                    let [a, b, c, d] = [corner(a), corner(b), corner(c), corner(d)];
                    samples.cover([a, b, c], number, part, self.raster.bits);
                    samples.cover([b, d, c], number + 1, part, self.raster.bits);
                }
                Err([a, b, c]) => {
                    let corner = |vertex: u32| layer.screen[vertex as usize];
                    samples.cover([corner(a), corner(b), corner(c)], number, part, self.raster.bits);
                }
            }
        }
    }
}

/// Steps through primitives that mostly follow one another.
struct Cursor<'a> {
    layers: &'a [Layer],
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

/// Samples of each pixel of a window.
struct PixelSamples<'a, const N: usize> {
    window: Window,
    /// Positions within their pixel, in fixed point.
    shifts: [[i32; 2]; N],
    /// Least and greatest of these, horizontally and vertically.
    outer: [[i32; 2]; 2],
    /// Distance between samples along an axis, as a power of two.
    apart: u32,
    triangles: &'a mut [[u64; N]],
    /// Keys of the visible triangles.
    keys: &'a mut [[f64; N]],
}

impl<'a, const N: usize> PixelSamples<'a, N> {
    fn new(
        window: Window,
        shifts: [[i32; 2]; N],
        bits: u32,
        triangles: &'a mut [[u64; N]],
        keys: &'a mut [[f64; N]],
    ) -> Self {
        let along = |axis: usize| {
            let mut along = shifts.map(|shift| shift[axis]);
            along.sort_unstable();
            along
        };
        let outer = [0, 1].map(|axis| [along(axis)[0], along(axis)[N - 1]]);
        // With the samples of a format, every row and column of an even subdivision of the pixel holds a sample;
        // other samples may be anywhere.
        let rows = bits.saturating_sub(N.ilog2());
        let even = |axis: usize| along(axis).windows(2).all(|pair| pair[1] - pair[0] == 1 << rows);
        let apart = if bits >= N.ilog2() && even(0) && even(1) { rows } else { 0 };
        Self { window, shifts, outer, apart, triangles, keys }
    }

    /// Returns whether no sample lies between two positions along an axis.
    #[inline(always)]
    fn misses(&self, axis: usize, least: i32, most: i32) -> bool {
        let row = |at: i32| (at - self.outer[axis][0]) >> self.apart;
        row(most) == row(least - 1)
    }

    /// Assigns the triangle's number to every sample of `part` that it covers and that sees nothing nearer.
    #[inline(always)]
    fn cover(&mut self, corners: [ScreenVertex; 3], number: u64, part: Window, bits: u32) {
        // First and last pixel of which some sample may lie within the triangle's bounds.
        let range = |axis: usize, values: [i32; 3], low: i64, high: i64| {
            let least = values[0].min(values[1]).min(values[2]);
            let most = values[0].max(values[1]).max(values[2]);
            if self.misses(axis, least, most) {
                return ([1, 0], 0);
            }
            let [first, last] = self.outer[axis];
            let up = (1 << bits) - 1;
            let pixels = [i64::from((least - last + up) >> bits), i64::from((most - first) >> bits)];
            ([pixels[0].max(low), pixels[1].min(high - 1)], most - least)
        };
        let [p, q, r] = corners;
        let ([y0, y1], height) = range(1, [p.y, q.y, r.y], part.y0, part.y1);
        if y0 > y1 {
            return;
        }
        let ([x0, x1], width) = range(0, [p.x, q.x, r.x], part.x0, part.x1);
        if x0 > x1 {
            return;
        }
        let pixels = Window::new(x0, y0, x1 + 1, y1 + 1);
        // For small triangles the edge functions fit in half the width.
        if width.max(height) < 1 << 13 && bits <= 12 {
            self.cover_by(Edges::<i32>::new(corners, [x0, y0].map(|at| at << bits)), number, pixels, bits);
        } else {
            self.cover_by(Edges::<i64>::new(corners, [x0, y0].map(|at| at << bits)), number, pixels, bits);
        }
    }

    #[inline(always)]
    fn cover_by<I: Whole>(&mut self, edges: Option<Edges<I>>, number: u64, pixels: Window, bits: u32) {
        let Some(edges) = edges else { return };
        // By edge and sample, the difference of the functions from their value at the pixel's corner. Loops instead
        // of closures, which are not always inlined into code for an instruction set.
        let mut beyond = [[I::of(0); N]; 3];
        for sample in 0..N {
            let [x, y] = self.shifts[sample];
            let change = edges.change(I::of(i64::from(x)), I::of(i64::from(y)));
            for edge in 0..3 {
                beyond[edge][sample] = change[edge];
            }
        }
        let pixel = I::of(1 << bits);
        let (right, down) = (edges.change(pixel, I::of(0)), edges.change(I::of(0), pixel));
        let mut left = edges.first;
        for y in pixels.y0..pixels.y1 {
            let mut corner = left;
            let start = (y - self.window.y0) as usize * self.window.width() + (pixels.x0 - self.window.x0) as usize;
            for index in start..start + pixels.width() {
                let mut at = [[I::of(0); N]; 3];
                for edge in 0..3 {
                    for sample in 0..N {
                        at[edge][sample] = corner[edge] + beyond[edge][sample];
                    }
                    corner[edge] = corner[edge] + right[edge];
                }
                let mut inside = [I::of(0); N];
                let mut some = I::of(-1);
                for sample in 0..N {
                    inside[sample] = Edges::inside([at[0][sample], at[1][sample], at[2][sample]]);
                    some = some & inside[sample];
                }
                if some < I::of(0) {
                    continue;
                }
                let (nearest, seen) = (&mut self.keys[index], &mut self.triangles[index]);
                for sample in 0..N {
                    if inside[sample] < I::of(0) {
                        continue;
                    }
                    let key = edges.key([at[0][sample], at[1][sample], at[2][sample]]);
                    if key > nearest[sample] || (key == nearest[sample] && number < seen[sample]) {
                        nearest[sample] = key;
                        seen[sample] = number;
                    }
                }
            }
            for edge in 0..3 {
                left[edge] = left[edge] + down[edge];
            }
        }
    }
}
