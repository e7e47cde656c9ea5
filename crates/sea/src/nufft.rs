//! Sums waves on a grid by a non-uniform Fourier transform of type 1: from arbitrary wave numbers to a regular grid.

use rayon::prelude::*;
use rustfft::num_complex::Complex;
use rustfft::num_traits::Zero;
use std::f64::consts::TAU;

use crate::fields::Fields;
use crate::frame::{Factor, SeaFrame, factors};
use crate::grid::Grid;
use crate::lanes::{Lanes, Line, Real, WIDTH, splat};
use crate::spread::{Kernel, TransformWave};
use crate::transforms::Transform;

/// Number of lines along z that one thread fills with waves at a time.
const BAND: usize = 16;

/// One side of the grid.
///
/// A transform of length 4Q is computed as four of length Q side by side, which give the outputs of each residue
/// modulo 4: the first step of the transform is done explicitly, and lines without waves cost nothing.
struct Axis<T: Real> {
    count: usize,
    /// Output at which phases are 0.
    center: usize,
    length: usize,
    /// e^{2πij/length}.
    roots: Vec<Complex<T>>,
    /// Inverse of the kernel's transform at each output.
    correction: Vec<T>,
    transform: Transform<Lanes<T>>,
}

/// Returns the least number ≥ `least` without a prime factor greater than 5.
fn smooth(least: usize) -> usize {
    let without = |mut value: usize, factor: usize| {
        while value.is_multiple_of(factor) {
            value /= factor;
        }
        value
    };
    (least.max(1)..).find(|&value| without(without(without(value, 2), 3), 5) == 1).unwrap_or(least)
}

impl<T: Real> Axis<T> {
    fn new(count: usize, kernel: &Kernel) -> Self {
        let least = libm::ceil(kernel.oversampling * count as f64) as usize;
        let size = smooth(least.max(2 * kernel.width).div_ceil(WIDTH));
        let (length, center) = (size * WIDTH, count / 2);
        let root = |index: usize| {
            let (sin, cos) = libm::sincos(TAU * index as f64 / length as f64);
            Complex::new(T::of(cos), T::of(sin))
        };
        let correction = |index: usize| T::of(1.0 / kernel.transform(index as f64 - center as f64, length));
        Self {
            count,
            center,
            length,
            roots: (0..length).map(root).collect(),
            correction: (0..count).into_par_iter().map(correction).collect(),
            transform: Transform::new(size),
        }
    }

    fn size(&self) -> usize {
        self.length / WIDTH
    }

    /// Returns the factor of a line in the outputs of a residue, before the transforms.
    fn root(&self, residue: usize, line: i64) -> Complex<T> {
        let index = (residue as i64 - self.center as i64) * line;
        self.roots[index.rem_euclid(self.length as i64) as usize]
    }

    /// Returns the position of a line in the transforms.
    fn place(&self, line: i64) -> usize {
        line.rem_euclid(self.size() as i64) as usize
    }

    fn scratch(&self) -> (Vec<Line<T>>, Vec<Line<T>>) {
        (vec![Zero::zero(); self.size()], vec![Zero::zero(); self.transform.scratch_len()])
    }
}

/// Range of lines that contains all waves.
#[derive(Clone, Copy)]
struct Extent {
    first: [i64; 2],
    /// Number of blocks of four lines along x.
    blocks: usize,
    /// Number of lines along z.
    lines: usize,
}

/// The transform for one grid, with its buffers.
pub(crate) struct Nufft<T: Real> {
    kernel: Kernel,
    axes: [Axis<T>; 2],
    sources: Vec<TransformWave>,
    /// Kernel values for each source: `width` along x, then along z.
    weights: Vec<T>,
    amplitudes: Vec<Complex<T>>,
    /// Waves on lines of wave numbers: along z, and within it along x.
    spectrum: Vec<Line<T>>,
    /// Transformed along z: by blocks of lines along x, and within them by rows of the grid.
    columns: Vec<Line<T>>,
}

impl<T: Real> Nufft<T> {
    pub(crate) fn new(columns: usize, rows: usize, kernel: Kernel) -> Self {
        Self {
            axes: [Axis::new(columns, &kernel), Axis::new(rows, &kernel)],
            kernel,
            sources: Vec::new(),
            weights: Vec::new(),
            amplitudes: Vec::new(),
            spectrum: Vec::new(),
            columns: Vec::new(),
        }
    }

    /// Adds the first waves of the frame, each attenuated by its share, to the sums that have room in `out`. Ends
    /// within a few lines when told to stop.
    pub(crate) fn evaluate(
        &mut self,
        frame: &SeaFrame,
        grid: Grid,
        shares: &[f32],
        out: &mut Fields,
        stop: &(dyn Fn() -> bool + Sync),
    ) {
        let Some(extent) = self.place(frame, grid, shares) else { return };
        for (sum, values) in out.sums_mut().into_iter().enumerate() {
            if !values.is_empty() && !stop() {
                self.amplify(frame, sum);
                self.spread(extent, stop);
                self.transform_columns(extent, stop);
                self.transform_rows(extent, values, stop);
            }
        }
    }

    /// Finds the lines of every wave.
    ///
    /// Turns from one point of the grid to the next are reduced modulo 1, so that waves shorter than two steps are as
    /// exact as others. A wave that travels to −x is the conjugate of one that travels to +x, so half of the lines
    /// have no waves.
    fn place(&mut self, frame: &SeaFrame, grid: Grid, shares: &[f32]) -> Option<Extent> {
        let [x, z] = &self.axes;
        let lengths = [x.length as f64, z.length as f64];
        let center = [grid.origin[0] + x.center as f64 * grid.step[0], grid.origin[1] + z.center as f64 * grid.step[1]];
        let half = self.kernel.width as f64 / 2.0;
        self.sources.clear();
        self.sources.extend(shares.iter().enumerate().map(|(wave, &share)| {
            let per_meter = frame.phases.turns(wave);
            let turns = [0, 1].map(|axis| {
                let turns = per_meter[axis] * grid.step[axis];
                turns - libm::rint(turns)
            });
            let turned = turns[0] < 0.0;
            let sign = if turned { -1.0 } else { 1.0 };
            let at = [0, 1].map(|axis| sign * turns[axis] * lengths[axis]);
            let (sin, cos) = libm::sincos(TAU * frame.phases.of(wave, center));
            let first = at.map(|at| libm::ceil(at - half) as i64);
            TransformWave { wave, turned, at, first, phase: [cos, sin].map(|part| part * f64::from(share)) }
        }));
        // Sorted by the lines that they reach, so that bands of lines find their waves.
        self.sources.sort_by_key(|source| source.first[1]);
        let width = self.kernel.width;
        self.weights.resize(self.sources.len() * 2 * width, T::zero());
        let kernel = self.kernel;
        self.weights.par_chunks_mut(2 * width).zip(&self.sources).for_each(|(weights, source)| {
            for (axis, weights) in weights.chunks_exact_mut(width).enumerate() {
                kernel.weights(source.first[axis], source.at[axis], weights);
            }
        });
        let range = |axis: usize| {
            let lines = self.sources.iter().map(|source| source.first[axis]);
            Some((lines.clone().min()?, lines.max()? + width as i64))
        };
        let ((x0, x1), (z0, z1)) = (range(0)?, range(1)?);
        Some(Extent { first: [x0, z0], blocks: ((x1 - x0) as usize).div_ceil(WIDTH), lines: (z1 - z0) as usize })
    }

    /// Computes the complex amplitude of every source in one sum: the sum is the real part of Σ amplitude·e^{iθ}.
    fn amplify(&mut self, frame: &SeaFrame, sum: usize) {
        self.amplitudes.clear();
        self.amplitudes.extend(self.sources.iter().map(|source| {
            let [cos, sin] = source.phase;
            // s·sin θ = Re(−i·s·e^{iθ}).
            let [re, im] = match factors(&frame.sorted[source.wave])[sum] {
                Factor::Sine(factor) => [factor * sin, -factor * cos],
                Factor::Cosine(factor) => [factor * cos, factor * sin],
            };
            Complex::new(T::of(re), T::of(if source.turned { -im } else { im }))
        }));
    }

    /// Spreads every source over the lines around it. Each band of lines adds its sources in the same order,
    /// whichever thread fills it.
    fn spread(&mut self, extent: Extent, stop: &(dyn Fn() -> bool + Sync)) {
        let width = self.kernel.width;
        self.spectrum.resize(extent.blocks * extent.lines, Zero::zero());
        let (sources, weights, amplitudes) = (&self.sources, &self.weights, &self.amplitudes);
        self.spectrum.par_chunks_mut(BAND * extent.blocks).enumerate().for_each(|(band, lines)| {
            lines.fill(Zero::zero());
            let from = extent.first[1] + (band * BAND) as i64;
            let to = from + (lines.len() / extent.blocks) as i64;
            let first = sources.partition_point(|source| source.first[1] + width as i64 <= from);
            let last = sources.partition_point(|source| source.first[1] < to);
            for index in first..last {
                if index % 1024 == 0 && stop() {
                    return;
                }
                let source = &sources[index];
                let (along_x, along_z) = weights[index * 2 * width..][..2 * width].split_at(width);
                let start = (source.first[0] - extent.first[0]) as usize;
                for (line, &weight) in (source.first[1]..).zip(along_z) {
                    if line < from || line >= to {
                        continue;
                    }
                    let row = &mut lines[(line - from) as usize * extent.blocks..][..extent.blocks];
                    let (re, im) = (amplitudes[index].re * weight, amplitudes[index].im * weight);
                    for (at, &weight) in (start..).zip(along_x) {
                        let Complex { re: Lanes(block_re), im: Lanes(block_im) } = &mut row[at / WIDTH];
                        block_re[at % WIDTH] = block_re[at % WIDTH] + re * weight;
                        block_im[at % WIDTH] = block_im[at % WIDTH] + im * weight;
                    }
                }
            }
        });
    }

    /// Transforms wave numbers to rows along z, for four lines along x at once.
    fn transform_columns(&mut self, extent: Extent, stop: &(dyn Fn() -> bool + Sync)) {
        let axis = &self.axes[1];
        let roots: Vec<[Complex<T>; WIDTH]> = (0..extent.lines)
            .map(|line| std::array::from_fn(|residue| axis.root(residue, extent.first[1] + line as i64)))
            .collect();
        let places: Vec<usize> = (0..extent.lines).map(|line| axis.place(extent.first[1] + line as i64)).collect();
        self.columns.resize(extent.blocks * axis.count, Zero::zero());
        let spectrum = &self.spectrum;
        let columns = self.columns.par_chunks_mut(axis.count).enumerate();
        columns.for_each_init(
            || axis.scratch(),
            |(buffer, scratch), (block, column)| {
                if stop() {
                    return;
                }
                for residue in 0..WIDTH.min(axis.count) {
                    buffer.fill(Zero::zero());
                    for ((line, &place), roots) in
                        spectrum[block..].iter().step_by(extent.blocks).zip(&places).zip(&roots)
                    {
                        buffer[place] = buffer[place] + *line * splat(roots[residue]);
                    }
                    axis.transform.process(buffer, scratch);
                    for (out, value) in column[residue..].iter_mut().step_by(WIDTH).zip(buffer.iter()) {
                        *out = *value;
                    }
                }
            },
        );
    }

    /// Transforms lines along x to points, two rows at once: one is the real part, the other the imaginary part.
    fn transform_rows(&self, extent: Extent, out: &mut [f32], stop: &(dyn Fn() -> bool + Sync)) {
        let ([axis, rows], columns) = (&self.axes, &self.columns);
        let lines = || (0..extent.blocks * WIDTH).map(|line| extent.first[0] + line as i64);
        let roots: Vec<Line<T>> = lines()
            .map(|line| {
                let roots: [Complex<T>; WIDTH] = std::array::from_fn(|residue| axis.root(residue, line));
                Complex::new(Lanes(roots.map(|root| root.re)), Lanes(roots.map(|root| root.im)))
            })
            .collect();
        let places: Vec<[usize; 2]> = lines().map(|line| [axis.place(line), axis.place(-line)]).collect();
        let half = T::of(0.5);
        let pairs = out.par_chunks_mut(2 * axis.count).enumerate();
        pairs.for_each_init(
            || axis.scratch(),
            |(buffer, scratch), (pair, out)| {
                if stop() {
                    return;
                }
                let row = 2 * pair;
                let two = out.len() > axis.count;
                let scale = half * rows.correction[row];
                let scale_second = if two { half * rows.correction[row + 1] } else { T::zero() };
                buffer.fill(Zero::zero());
                for (block, (roots, places)) in roots.chunks_exact(WIDTH).zip(places.chunks_exact(WIDTH)).enumerate() {
                    let a = columns[block * rows.count + row];
                    let b = if two { columns[block * rows.count + row + 1] } else { a };
                    for lane in 0..WIDTH {
                        let (re, im) = (a.re.0[lane] * scale, a.im.0[lane] * scale);
                        let (re_second, im_second) = (b.re.0[lane] * scale_second, b.im.0[lane] * scale_second);
                        // Re A + i Re B = ½(A + iB) + ½ conj(A − iB).
                        let (root, [place, mirrored]) = (roots[lane], places[lane]);
                        let plus = splat(Complex::new(re - im_second, im + re_second)) * root;
                        buffer[place] = buffer[place] + plus;
                        let minus = splat(Complex::new(re + im_second, im - re_second)) * root;
                        buffer[mirrored] = buffer[mirrored] + minus.conj();
                    }
                }
                axis.transform.process(buffer, scratch);
                let (first, second) = out.split_at_mut(axis.count);
                let corrections = axis.correction.chunks(WIDTH);
                for ((out, value), correction) in first.chunks_mut(WIDTH).zip(buffer.iter()).zip(corrections.clone()) {
                    for ((out, &value), &correction) in out.iter_mut().zip(&value.re.0).zip(correction) {
                        *out = (value * correction).single();
                    }
                }
                for ((out, value), correction) in second.chunks_mut(WIDTH).zip(buffer.iter()).zip(corrections) {
                    for ((out, &value), &correction) in out.iter_mut().zip(&value.im.0).zip(correction) {
                        *out = (value * correction).single();
                    }
                }
            },
        );
    }
}
