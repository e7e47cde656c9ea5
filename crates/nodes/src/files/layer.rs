//! Layer: one plane of a file, laid over the document's picture.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use super::kept::Grid;
use super::knobs::FitBy;
use crate::filter::{self, LANES};
use fearless_simd::{Level, Simd, dispatch};
use std::path::Path;
use std::sync::Arc;
use trochoid_graph::{BadData, Block, Choice, NodeError};
use trochoid_image::{Format, Plane, Window};
use trochoid_memory::Scratch;

/// Mapping of the document's pixels to the pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fit {
    sampling: Sampling,
    /// Corner of the picture's display window.
    origin: [i64; 2],
    /// Picture pixels per document pixel, across and down.
    scale: [f64; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sampling {
    /// Pixel by pixel, with the upper left corners aligned.
    Pixel,
    /// Scaled; takes the pixel that contains the sample.
    Nearest,
    /// Scaled; blends the four pixels around the sample.
    Bilinear,
}

/// The two neighbors of a sample along an axis, and its position between them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tap {
    low: i64,
    t: f64,
}

impl Fit {
    /// Fits a picture with this display window to a document's formats, the one being rendered and the whole one. A
    /// picture rendered at a smaller size shows the same part of the file.
    ///
    /// # Errors
    /// The sizes differ, and the knob is unset.
    pub(crate) fn new(
        by: Option<FitBy>,
        words: &[&str],
        display: Window,
        [format, whole]: [Format; 2],
        path: &Path,
    ) -> Result<Self, NodeError> {
        let (width, height) = (display.width(), display.height());
        let sides = |format: Format| [format.width(), format.height()];
        let per = |from: [f64; 2]| [0, 1].map(|axis| from[axis] / f64::from(sides(format)[axis]));
        let scale = per([width as f64, height as f64]);
        let same = (width, height) == (whole.width() as usize, whole.height() as usize);
        let sampling = match by {
            _ if same || by == Some(FitBy::Crop) => {
                let (sampling, scale) = match sides(format) == sides(whole) {
                    true => (Sampling::Pixel, scale),
                    false => (Sampling::Nearest, per(sides(whole).map(f64::from))),
                };
                return Ok(Self { sampling, origin: [display.x0, display.y0], scale });
            }
            Some(FitBy::Nearest) => Sampling::Nearest,
            Some(FitBy::Bilinear) => Sampling::Bilinear,
            Some(FitBy::Crop) | None => {
                let scale = words.iter().filter(|word| **word != FitBy::Crop.word()).map(|fit| format!("\"{fit}\""));
                let found = format_args!("a picture of {width} × {height} pixels");
                let expected = format!("{} × {}, as the document has", whole.width(), whole.height());
                let remedy = format!(
                    "set \"fit\" to {} to scale it, or to \"crop\" to align the upper left corners",
                    scale.collect::<Vec<_>>().join(" or ")
                );
                return Err(BadData::new(found, expected, remedy).in_file(path).into());
            }
        };
        Ok(Self { sampling, origin: [display.x0, display.y0], scale })
    }

    /// Returns the neighbors of a sample, given its position in the document along an axis, in pixels.
    fn tap(&self, axis: usize, at: f64) -> Tap {
        let origin = self.origin[axis];
        match self.sampling {
            Sampling::Pixel => Tap { low: origin + at.floor() as i64, t: 0.0 },
            Sampling::Nearest => Tap { low: origin + (at * self.scale[axis]).floor() as i64, t: 0.0 },
            Sampling::Bilinear => {
                let center = at * self.scale[axis] - 0.5;
                Tap { low: origin + center.floor() as i64, t: center - center.floor() }
            }
        }
    }

    /// Returns the pixels that can contribute to a sample at a position along an axis.
    pub(crate) fn neighbors(&self, axis: usize, at: f64) -> std::ops::RangeInclusive<i64> {
        let low = self.tap(axis, at).low;
        low..=if self.sampling == Sampling::Bilinear { low + 1 } else { low }
    }

    /// Whether each document pixel corresponds to one picture pixel.
    pub(crate) fn is_pixel(&self) -> bool {
        self.sampling == Sampling::Pixel
    }

    /// Whether every sample is an unblended pixel of the picture.
    pub(crate) fn is_exact(&self) -> bool {
        self.sampling != Sampling::Bilinear
    }

    /// Lays rows of a picture over a block. `line` supplies the pixels from (x, y) on, one row for each channel.
    pub(crate) fn lay(
        &self,
        block: &Block<'_>,
        outs: &mut [Option<&mut [f32]>],
        mut line: impl FnMut(i64, i64, &mut [Option<&mut [f32]>]) -> Result<(), NodeError>,
    ) -> Result<(), NodeError> {
        let (window, offset) = (block.window, block.offset);
        let width = window.width();
        if window.is_empty() {
            return Ok(());
        }
        let columns: Scratch<Tap> = match self.sampling {
            Sampling::Pixel => Scratch::new(),
            _ => (window.x0..window.x1).map(|x| self.tap(0, x as f64 + offset[0])).collect(),
        };
        // Taps never decrease, so the first and the last are the outermost.
        let left = self.tap(0, window.x0 as f64 + offset[0]).low;
        let length = columns.last().map_or(0, |last| (last.low + 2 - left) as usize);
        let none = |out: &Option<&mut [f32]>| out.as_ref().map(|_| Scratch::of(0.0, length));
        let mut lines: [Lines; 2] = [outs.iter().map(none).collect(), outs.iter().map(none).collect()];
        // Rows of the picture in these lines. A larger document reads the same ones again and again.
        let mut held = [None; 2];
        for (row, y) in (window.y0..window.y1).enumerate() {
            let down = self.tap(1, y as f64 + offset[1]);
            if self.sampling == Sampling::Pixel {
                let mut rows: Scratch<Option<&mut [f32]>> =
                    outs.iter_mut().map(|out| out.as_deref_mut().map(|out| &mut out[row * width..][..width])).collect();
                line(left, down.low, &mut rows)?;
                continue;
            }
            if held[1] == Some(down.low) {
                lines.swap(0, 1);
                held.swap(0, 1);
            }
            let needed = if self.sampling == Sampling::Bilinear { 2 } else { 1 };
            for (below, lines) in lines.iter_mut().enumerate().take(needed) {
                let y = down.low + below as i64;
                if held[below].replace(y) == Some(y) {
                    continue;
                }
                let mut rows: Scratch<Option<&mut [f32]>> =
                    lines.iter_mut().map(|line| line.as_mut().map(|line| &mut line[..])).collect();
                line(left, y, &mut rows)?;
            }
            if self.sampling == Sampling::Bilinear {
                dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
                    blend_row(&lines, left, &columns, down.t, row * width, outs);
                }));
                continue;
            }
            for (out, line) in outs.iter_mut().zip(&lines[0]) {
                let (Some(out), Some(line)) = (out, line) else { continue };
                for (out, across) in out[row * width..].iter_mut().zip(&columns) {
                    *out = line[(across.low - left) as usize];
                }
            }
        }
        Ok(())
    }

    /// Returns the values at a position in the document, in pixels, in f64, from a picture with these pixels.
    pub(crate) fn blend<E>(
        &self,
        at: [f64; 2],
        texel: &mut dyn FnMut(i64, i64) -> Result<Vec<f64>, E>,
    ) -> Result<Vec<f64>, E> {
        let (across, down) = (self.tap(0, at[0]), self.tap(1, at[1]));
        let nearest = texel(across.low, down.low)?;
        let mut sums = vec![0.0; nearest.len()];
        for (dy, v) in [(0, 1.0 - down.t), (1, down.t)] {
            for (dx, u) in [(0, 1.0 - across.t), (1, across.t)] {
                if u * v > 0.0 {
                    let values = texel(across.low + dx, down.low + dy)?;
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += u * v * value);
                }
            }
        }
        Ok(sums.into_iter().zip(nearest).map(|(sum, nearest)| if sum.is_nan() { nearest } else { sum }).collect())
    }

    /// Returns the data window of a picture in the document's pixels.
    pub(crate) fn window(&self, data: Window) -> Window {
        let axis = |axis: usize, first: i64, end: i64| {
            let (first, end) = (first - self.origin[axis], end - self.origin[axis]);
            match self.sampling {
                Sampling::Pixel => (first, end),
                Sampling::Nearest | Sampling::Bilinear => {
                    let place = |at: i64| at as f64 / self.scale[axis];
                    (place(first).floor() as i64, place(end).ceil() as i64)
                }
            }
        };
        let ((x0, x1), (y0, y1)) = (axis(0, data.x0, data.x1), axis(1, data.y0, data.y1));
        Window { x0, y0, x1, y1 }
    }
}

/// A row of a picture by channel, where it is needed.
type Lines = Scratch<Option<Scratch<f32>>>;

/// Blends two rows of a picture, which begin at `left`, at columns and at a fraction `down` between the rows, into the
/// samples from `start` on.
#[inline(always)]
fn blend_row(
    [upper, lower]: &[Lines; 2],
    left: i64,
    columns: &[Tap],
    down: f64,
    start: usize,
    outs: &mut [Option<&mut [f32]>],
) {
    for (columns, start) in columns.chunks(LANES).zip((start..).step_by(LANES)) {
        // Columns beyond the last one read a pixel that every row has.
        let (mut across, mut at) = ([0.0; LANES], [0; LANES]);
        for (lane, column) in columns.iter().enumerate() {
            (across[lane], at[lane]) = (column.t, (column.low - left) as usize);
        }
        let weights = filter::weights_together(&across, &[down; LANES]);
        for ((out, upper), lower) in outs.iter_mut().zip(upper).zip(lower) {
            let (Some(out), Some(upper), Some(lower)) = (out, upper, lower) else { continue };
            let mut values = [[0.0; LANES]; 4];
            for lane in 0..LANES {
                let at = at[lane];
                values[0][lane] = upper[at];
                values[1][lane] = upper[at + 1];
                values[2][lane] = lower[at];
                values[3][lane] = lower[at + 1];
            }
            let mut blends = filter::blended_together(&values, &weights);
            for lane in 0..LANES {
                blends[lane] = if across[lane] == 0.0 && down == 0.0 { values[0][lane] } else { blends[lane] };
            }
            let out = &mut out[start..start + columns.len()];
            if let Some(out) = out.first_chunk_mut() {
                *out = blends;
            } else {
                out.copy_from_slice(&blends[..out.len()]);
            }
        }
    }
}

/// Returns the index, row by row, of the pixel of a window that is nearest to (x, y); `None` if the window is empty.
pub(crate) fn index_of_nearest(window: Window, x: i64, y: i64) -> Option<usize> {
    if window.is_empty() {
        return None;
    }
    let (column, row) = (x.clamp(window.x0, window.x1 - 1) - window.x0, y.clamp(window.y0, window.y1 - 1) - window.y0);
    Some(row as usize * window.width() + column as usize)
}

/// Samples of a channel.
#[derive(Clone, Debug)]
enum Pixels {
    Whole(Plane),
    /// Only the samples on a grid.
    Kept(Arc<Grid>, Vec<f32>),
}

/// One plane of a file, laid over the document's picture.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    pixels: Pixels,
    fit: Fit,
    /// Value outside the plane's window; if `None`, the nearest pixel repeats.
    outside: Option<f32>,
    /// What the samples are rounded from; `None` if they are exact.
    exact: Option<Vec<f64>>,
}

impl Layer {
    pub(crate) fn new(plane: Plane, fit: Fit, outside: Option<f32>) -> Self {
        Self { pixels: Pixels::Whole(plane), fit, outside, exact: None }
    }

    /// Returns a layer of a picture of which only some pixels are kept.
    pub(crate) fn kept(grid: Arc<Grid>, samples: Vec<f32>, fit: Fit, outside: Option<f32>) -> Self {
        Self { pixels: Pixels::Kept(grid, samples), fit, outside, exact: None }
    }

    /// Sets what the samples are rounded from, sample by sample, if they are not exact.
    #[must_use]
    pub(crate) fn with_exact(self, exact: Option<Vec<f64>>) -> Self {
        Self { exact, ..self }
    }

    /// Whether all pixels that a block needs are kept.
    pub(crate) fn covers(&self, block: &Block<'_>) -> bool {
        let Pixels::Kept(grid, _) = &self.pixels else { return true };
        let (window, [across, down]) = (block.window, block.offset);
        let near = |axis, at: i64, offset| self.fit.neighbors(axis, at as f64 + offset);
        (window.x0..window.x1).all(|x| near(0, x, across).all(|x| grid.has_column(x)))
            && (window.y0..window.y1).all(|y| near(1, y, down).all(|y| grid.has_row(y)))
    }

    /// Whether all pixels that the value at a position needs are kept.
    pub(crate) fn covers_place(&self, [x, y]: [f64; 2]) -> bool {
        let Pixels::Kept(grid, _) = &self.pixels else { return true };
        self.fit.neighbors(0, x).all(|x| grid.has_column(x)) && self.fit.neighbors(1, y).all(|y| grid.has_row(y))
    }

    /// Returns the plane's window.
    fn data(&self) -> Window {
        match &self.pixels {
            Pixels::Whole(plane) => plane.window(),
            Pixels::Kept(grid, _) => grid.data(),
        }
    }

    /// Fills a block with samples, row by row.
    pub(crate) fn fill(&self, block: &Block<'_>, out: &mut [f32]) {
        let window = block.window;
        if window.is_empty() {
            return;
        }
        let down = |y: i64| self.fit.tap(1, y as f64 + block.offset[1]);
        let rows = out.chunks_mut(window.width()).zip(window.y0..);
        if let (Sampling::Pixel, Pixels::Whole(plane)) = (self.fit.sampling, &self.pixels) {
            let left = self.fit.tap(0, window.x0 as f64 + block.offset[0]).low;
            rows.for_each(|(row, y)| self.copy(plane, left, down(y).low, row));
            return;
        }
        let columns: Scratch<Tap> =
            (window.x0..window.x1).map(|x| self.fit.tap(0, x as f64 + block.offset[0])).collect();
        for (row, y) in rows {
            let down = down(y);
            for (out, across) in row.iter_mut().zip(&columns) {
                *out = self.sample(*across, down);
            }
        }
    }

    /// Copies the pixels from (`left`, `y`) on; those within the plane are copied at once.
    fn copy(&self, plane: &Plane, left: i64, y: i64, out: &mut [f32]) {
        let data = plane.window();
        let stored = match self.outside {
            Some(_) => plane.row(y),
            None => plane.row(y.clamp(data.y0, data.y1 - 1)),
        };
        let within = |x: i64| (x - left).clamp(0, out.len() as i64) as usize;
        let (first, last) = (within(data.x0), within(data.x1));
        if let Some(row) = stored.filter(|_| first < last) {
            let start = (left + first as i64 - data.x0) as usize;
            out[first..last].copy_from_slice(&row[start..start + last - first]);
            out[..first].fill(self.texel(data.x0 - 1, y));
            out[last..].fill(self.texel(data.x1, y));
        } else {
            // Outside the plane there is one value, unless rows repeat above and below it.
            out.iter_mut().zip(left..).for_each(|(out, x)| *out = self.texel(x, y));
        }
    }

    /// Returns the blend of four pixels, or the pixel that contains the sample.
    fn sample(&self, across: Tap, down: Tap) -> f32 {
        let nearest = self.texel(across.low, down.low);
        if across.t == 0.0 && down.t == 0.0 {
            return nearest;
        }
        let values = [
            nearest,
            self.texel(across.low + 1, down.low),
            self.texel(across.low, down.low + 1),
            self.texel(across.low + 1, down.low + 1),
        ];
        filter::blended(values, &filter::weights(across.t, down.t))
    }

    /// Returns the value at a position in the document, in pixels, in f64.
    pub(crate) fn reference(&self, at: [f64; 2]) -> f64 {
        let mut texel = |x: i64, y: i64| Ok::<_, std::convert::Infallible>(vec![self.exact(x, y)]);
        match self.fit.blend(at, &mut texel) {
            Ok(values) => values[0],
            Err(never) => match never {},
        }
    }

    fn texel(&self, x: i64, y: i64) -> f32 {
        match (self.outside, &self.pixels) {
            (Some(outside), _) if !self.data().contains(x, y) => outside,
            (_, Pixels::Whole(plane)) => plane.nearest(x, y),
            // `covers` was checked before: the pixel is kept.
            (_, Pixels::Kept(grid, samples)) => grid.place(x, y).map_or(f32::NAN, |place| samples[place]),
        }
    }

    /// Returns what the pixel nearest to (x, y) is rounded from.
    fn exact(&self, x: i64, y: i64) -> f64 {
        let Some(exact) = &self.exact else { return f64::from(self.texel(x, y)) };
        let place = match &self.pixels {
            Pixels::Whole(plane) => index_of_nearest(plane.window(), x, y),
            Pixels::Kept(grid, _) => grid.place(x, y),
        };
        place.map_or(f64::NAN, |place| exact[place])
    }

    /// Returns the memory held, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.samples()) + self.exact.as_ref().map_or(0, |exact| size_of_val(&exact[..]))
    }

    /// Returns the file's data window in the document's pixels.
    pub(crate) fn window(&self) -> Window {
        self.fit.window(self.data())
    }

    /// Returns all kept samples.
    pub(crate) fn samples(&self) -> &[f32] {
        match &self.pixels {
            Pixels::Whole(plane) => plane.samples(),
            Pixels::Kept(_, samples) => samples,
        }
    }
}
