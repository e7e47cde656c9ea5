//! Adaptive sampling: further samples only where the first ones of a pixel and of those around it differ.

use super::bands::Rows;
use super::fill::make_room;
use super::tile::{Worker, audit_tile, channel_count, run_samples, slices};
use crate::planning::plan::{Pass, Sample};
use crate::{EvalError, Plan};
use fearless_simd::{Level, Simd, dispatch};
use std::time::Instant;
use trochoid_graph::Kind;
use trochoid_image::Window;
use trochoid_kernel::Machine;
use trochoid_memory::{Scratch, Target};
use trochoid_weights::Audit;

/// Share of a tile's pixels from which on further samples are taken everywhere.
const MOST: f64 = 0.6;

/// Finds the pixels of tiles around which samples differ.
#[derive(Default)]
pub(crate) struct Contrast {
    /// Square roots of a row, with a sample more at either end.
    roots: Vec<f32>,
    /// Least and largest of three neighbors, row by row.
    least: Vec<f32>,
    most: Vec<f32>,
}

/// Returns the number whose differences are compared.
#[inline(always)]
fn root(value: f32) -> f32 {
    let root = value.abs().sqrt().copysign(value);
    // NaN counts as infinite.
    if root.is_nan() { f32::INFINITY } else { root }
}

impl Contrast {
    /// Marks the pixels of a tile around which samples of a channel differ by more than a tolerance. The samples are those of
    /// `around`: the tile and the pixels beside it, as far as the picture has any.
    pub(crate) fn mark(
        &mut self,
        samples: &[f32],
        around: Window,
        tile: Window,
        tolerance: f32,
        differs: &mut [bool],
        level: Level,
    ) {
        let (width, stride) = (tile.width(), around.width());
        let before = (tile.x0 - around.x0) as usize;
        let Self { roots, least, most } = self;
        let rows = around.height();
        least.resize(rows * width, 0.0);
        most.resize(rows * width, 0.0);
        roots.resize(width + 2, 0.0);
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
            for ((row, least), most) in
                samples.chunks_exact(stride).zip(least.chunks_exact_mut(width)).zip(most.chunks_exact_mut(width))
            {
                // Beyond the picture its border repeats.
                for (root_of, value) in roots[1 - before..].iter_mut().zip(row) {
                    *root_of = root(*value);
                }
                if before == 0 {
                    roots[0] = roots[1];
                }
                if stride == before + width {
                    roots[width + 1] = roots[width];
                }
                let beside = roots.iter().zip(&roots[1..]).zip(&roots[2..]);
                for (((a, b), c), (least, most)) in beside.zip(least.iter_mut().zip(most)) {
                    *least = smaller(*a, smaller(*b, *c));
                    *most = larger(*a, larger(*b, *c));
                }
            }
            for (y, differs) in (tile.y0..).zip(differs.chunks_exact_mut(width)) {
                let row = |y: i64| (y.clamp(around.y0, around.y1 - 1) - around.y0) as usize * width;
                let [above, here, below] = [row(y - 1), row(y), row(y + 1)];
                let (low, high) = (&*least, &*most);
                let low = low[above..above + width].iter().zip(&low[here..here + width]).zip(&low[below..below + width]);
                let high = high[above..above + width].iter().zip(&high[here..here + width]).zip(&high[below..below + width]);
                for (differs, (((a, b), c), ((d, e), f))) in differs.iter_mut().zip(low.zip(high)) {
                    let (low, high) = (smaller(*a, smaller(*b, *c)), larger(*d, larger(*e, *f)));
                    // Between equal infinite values, the difference is NaN.
                    *differs |= high - low > tolerance;
                }
            }
        }));
    }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Returns a tile with the pixels beside it, as far as the picture has any.
pub(crate) fn around(plan: &Plan<'_>, tile: Window) -> Window {
    let grown = Window::new(tile.x0 - 1, tile.y0 - 1, tile.x1 + 1, tile.y1 + 1);
    grown.intersect(plan.graph.format().window())
}

/// Returns whether an output may keep first samples: recipes do not, so that pictures in all colors are means.
pub(crate) fn is_adaptive(plan: &Plan<'_>, output: usize) -> bool {
    !matches!(plan.outputs[output].kind, Kind::Layers(_))
}

/// What adaptive sampling keeps from tile to tile.
#[derive(Default)]
pub(super) struct Adaptive {
    contrast: Contrast,
    /// First samples by channel, over the pixels around a tile.
    first: Vec<Vec<f32>>,
    /// By output, where samples differ; by pixel of the tile.
    differs: Vec<Vec<bool>>,
    /// Indices in the tile and positions of the pixels at which those of any output do.
    indices: Vec<usize>,
    pixels: Vec<[i64; 2]>,
    /// Sums of the samples at these pixels, by channel.
    sums: Vec<Vec<f64>>,
}

/// Returns the bytes that adaptive sampling keeps for each pixel of a tile.
pub(crate) fn bytes_of_pixel(pass: &Pass) -> u64 {
    let channels = channel_count(pass);
    let outputs = pass.roots.iter().map(|(output, _)| output + 1).max().unwrap_or(0);
    let values = channels * (size_of::<f32>() + size_of::<f64>()) + 2 * size_of::<f32>();
    let listed = size_of::<usize>() + size_of::<[i64; 2]>();
    (values + listed + outputs * size_of::<bool>()) as u64
}

impl Adaptive {
    /// Finds the pixels at which further samples are taken, given the first ones; returns the smallest window around them.
    fn look(
        &mut self,
        plan: &Plan<'_>,
        pass: &Pass,
        around: Window,
        tile: Window,
        tolerance: f32,
        level: Level,
    ) -> Window {
        let Self { contrast, first, differs, indices, pixels, .. } = self;
        differs.resize_with(pass.roots.iter().map(|(output, _)| output + 1).max().unwrap_or(0), Vec::new);
        for differs in differs.iter_mut() {
            differs.clear();
            differs.resize(tile.area(), false);
        }
        for (output, samples) in outputs(pass).zip(first.iter()) {
            if !is_adaptive(plan, output) {
                differs[output].fill(true);
                continue;
            }
            contrast.mark(samples, around, tile, tolerance, &mut differs[output], level);
        }
        indices.clear();
        pixels.clear();
        make_room(indices, tile.area());
        make_room(pixels, tile.area());
        let mut window = Window::default();
        let width = tile.width();
        for (y, start) in (tile.y0..tile.y1).zip((0..).step_by(width)) {
            let before = pixels.len();
            let is_marked = |x: &usize| differs.iter().any(|differs| differs[start + x]);
            for x in (0..width).filter(is_marked) {
                indices.push(start + x);
                pixels.push([tile.x0 + x as i64, y]);
            }
            if let (Some([first, _]), Some([last, _])) =
                (pixels.get(before), pixels.last().filter(|[_, row]| *row == y))
            {
                window = window.union(Window::new(*first, y, last + 1, y + 1));
            }
        }
        window
    }
}

/// Lists the output of each channel of a pass's roots.
pub(crate) fn outputs(pass: &Pass) -> impl Iterator<Item = usize> {
    let roots = pass.roots.iter().zip(&pass.program.roots);
    roots.flat_map(|((output, _), channels)| std::iter::repeat_n(*output, *channels))
}

impl<'p> Worker<'p> {
    /// Takes the first sample everywhere, and averages all samples where the first ones differ.
    pub(super) fn adaptive(
        &mut self,
        index: usize,
        tile: Window,
        rows: &mut Rows<'_>,
        tolerance: f32,
    ) -> Result<Scratch<Audit>, EvalError> {
        let (plan, level) = (self.plan, self.level);
        let state = &mut self.passes[index];
        let pass = state.pass;
        let around = around(plan, tile);
        let first = Sample { index: 0, offset: pass.offsets[0] };
        state.fills.fill(around, first, &mut self.fill_seconds)?;
        let started = Instant::now();
        let adaptive = &mut state.adaptive;
        adaptive.first.resize_with(state.rows.len(), Vec::new);
        for first in &mut adaptive.first {
            first.clear();
            make_room(first, around.area());
        }
        run_samples(plan, self.buffers, pass, &mut state.machine, &state.fills, around, &mut state.rows, |_, rows| {
            adaptive.first.iter_mut().zip(rows).for_each(|(first, row)| first.extend_from_slice(row));
        })?;
        let window = adaptive.look(plan, pass, around, tile, tolerance, level);
        let (width, stride) = (tile.width(), around.width());
        let start = (tile.y0 - around.y0) as usize * stride + (tile.x0 - around.x0) as usize;
        for (slice, first) in slices(pass, rows).iter_mut().zip(&adaptive.first) {
            for (slice, first) in slice.chunks_exact_mut(width).zip(first[start..].chunks(stride)) {
                // Like sums, without −0.
                slice.iter_mut().zip(first).for_each(|(to, first)| *to = first + 0.0);
            }
        }
        let count = adaptive.indices.len();
        adaptive.sums.resize_with(state.rows.len(), Vec::new);
        for (sums, first) in adaptive.sums.iter_mut().zip(&adaptive.first) {
            sums.clear();
            make_room(sums, tile.area());
            let place = |[x, y]: &[i64; 2]| (y - around.y0) as usize * stride + (x - around.x0) as usize;
            sums.extend(adaptive.pixels.iter().map(|pixel| f64::from(first[place(pixel)])));
        }
        self.program_seconds += started.elapsed().as_secs_f64();
        let is_sparse = state.fills.is_sparse();
        let is_single = is_sparse && count as f64 <= MOST * tile.area() as f64;
        for sample in pass.samples().skip(1) {
            if count == 0 && is_sparse {
                state.fills.leave_out(tile.area());
                continue;
            }
            if is_single && let (Some(program), Some(machine)) = (&pass.scattered, &mut state.scattered) {
                state.fills.leave_out(tile.area() - count);
                state.fills.fill_at(&state.adaptive.pixels, window, tile, sample, &mut self.fill_seconds)?;
                let started = Instant::now();
                let planes = state.fills.planes_at(program);
                run_row(machine, &planes, count, &mut state.rows);
                let sums = &mut state.adaptive.sums;
                dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                    for (sums, row) in sums.iter_mut().zip(&state.rows) {
                        for (sum, value) in sums.iter_mut().zip(row) {
                            *sum += f64::from(*value);
                        }
                    }
                }));
                self.program_seconds += started.elapsed().as_secs_f64();
                continue;
            }
            state.fills.fill(tile, sample, &mut self.fill_seconds)?;
            let started = Instant::now();
            let Adaptive { indices, sums, .. } = &mut state.adaptive;
            let mut done = 0;
            run_samples(
                plan,
                self.buffers,
                pass,
                &mut state.machine,
                &state.fills,
                tile,
                &mut state.rows,
                |y, rows| {
                    let here = indices[done..].partition_point(|index| *index < (y + 1) * width);
                    for (sums, row) in sums.iter_mut().zip(rows) {
                        for (sum, index) in sums[done..done + here].iter_mut().zip(&indices[done..]) {
                            *sum += f64::from(row[index - y * width]);
                        }
                    }
                    done += here;
                },
            )?;
            self.program_seconds += started.elapsed().as_secs_f64();
        }
        // As for averages of every pixel.
        let scale = 1.0 / pass.offsets.len() as f64;
        let Adaptive { differs, indices, sums, .. } = &state.adaptive;
        for ((slice, output), sums) in slices(pass, rows).iter_mut().zip(outputs(pass)).zip(sums) {
            for (index, sum) in indices.iter().zip(sums).filter(|(index, _)| differs[output][**index]) {
                slice[*index] = (sum * scale) as f32;
            }
        }
        let mut seen = Scratch::of(Audit::default(), self.judges.len());
        for &(output, _) in pass.roots.iter().filter(|(_, first)| *first == 0) {
            seen[output] = audit_tile(self.judges[output].as_deref(), &rows[output], tile);
        }
        Ok(seen)
    }
}

/// Runs a program over single pixels, into rows by channel.
fn run_row(machine: &mut Machine<'_>, planes: &[trochoid_kernel::Plane<'_>], count: usize, rows: &mut [Vec<f32>]) {
    rows.iter_mut().for_each(|row| row.resize(count, 0.0));
    let mut views = machine.begin(planes, count);
    let mut out: Scratch<Target<'_>> = rows.iter_mut().map(|row| Target::new(row)).collect();
    machine.row(&mut views, 0, &mut out, 0, None);
}
