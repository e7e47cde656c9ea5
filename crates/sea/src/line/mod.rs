//! Sums of waves along straight lines.

pub(crate) mod spreader;

use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use rustfft::num_traits::Zero;

use crate::fields::{FieldSet, Fields, Points, SUMS};
use crate::frame::{SeaFrame, Term};
use crate::kernel::{LANES, exp_neg, sincos_turns};
use crate::lanes;
use crate::transforms::Transform;
use spreader::{BEFORE, Spreader, WIDTH};

/// Evenly spaced rest points on a straight line: a row of a grid that is projected onto the sea.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// First rest point, x and z, in meters.
    pub origin: [f64; 2],
    /// Step from one point to the next, x and z, in meters.
    pub step: [f64; 2],
    /// Footprint of all points in meters.
    pub footprint: f64,
}

/// A sea along lines with equal numbers of points.
///
/// On a line each wave is a sinusoid, so the sum over all waves is a Fourier sum with arbitrary frequencies: each is
/// spread over eight neighbors of a fine regular grid of frequencies, which a fast transform converts to the points
/// (non-uniform FFT of type 1, Dutt and Rokhlin 1993; kernel after Barnett, Magland and af Klinteberg 2019). A wave
/// then costs the same for any number of points. Short lines and few waves are summed directly instead; the choice
/// depends only on the two counts.
///
/// Results agree with [`SeaFrame::evaluate`] to about 2e-6 of each quantity's root mean square.
pub struct Lines<'s> {
    frame: &'s SeaFrame,
    count: usize,
    transform: Transform<lanes::Lanes<f32>>,
    spreader: Spreader,
    /// By sum: a power of two near its root mean square. Two sums of one sequence share its rounding, so both must be
    /// scaled to about 1.
    scales: [f32; ROOM],
    /// By group of sums that are transformed at once, and by wave.
    factors: [Vec<Factors>; ROOM / TOGETHER],
}

/// Factors of a wave's sine and cosine in some sums, divided by the scales of these: of the even sums and of the odd ones,
/// which are the real and imaginary parts of one sequence.
#[derive(Clone, Copy)]
struct Factors {
    sines: [[f32; lanes::WIDTH]; 2],
    cosines: [[f32; lanes::WIDTH]; 2],
}

/// Scratch buffers of one thread, reused from line to line.
#[derive(Default)]
pub struct LineScratch {
    /// Phases in turns at the line's middle, and the shares that the footprint leaves.
    phases: Vec<f32>,
    sines: Vec<f32>,
    cosines: Vec<f32>,
    cells: Vec<lanes::Line<f32>>,
    work: Vec<lanes::Line<f32>>,
    points: [Vec<f64>; 3],
}

/// Measured times in nanoseconds by which the methods are compared: per wave and point of the direct sum, per wave
/// that is spread, and per value and logarithmic step of the transform.
const DIRECT: f64 = 0.8;
const SPREAD: f64 = 60.0;
const TRANSFORM: f64 = 1.6;

/// Number of sums that are transformed at once: two in each of four complex sequences.
const TOGETHER: usize = 2 * lanes::WIDTH;
/// Number of sums, padded to whole groups.
const ROOM: usize = SUMS.next_multiple_of(TOGETHER);

impl<'s> Lines<'s> {
    /// Prepares lines of `count` points.
    pub fn new(frame: &'s SeaFrame, count: usize) -> Self {
        let spreader = Spreader::new(count);
        let transform = Transform::new(spreader.cells());
        let mut squares = [0.0; ROOM];
        for term in &frame.terms {
            for (square, [sine, cosine]) in squares.iter_mut().zip(factors(term)) {
                *square += f64::from(sine) * f64::from(sine) + f64::from(cosine) * f64::from(cosine);
            }
        }
        let scales = squares.map(|square| {
            let power = libm::round(libm::log2(square) / 2.0).clamp(-100.0, 100.0);
            if square > 0.0 { libm::exp2(power) as f32 } else { 1.0 }
        });
        let factors = std::array::from_fn(|group| {
            let inverse = std::array::from_fn(|sum| 1.0 / scales[group * TOGETHER + sum]);
            frame.terms.iter().map(|term| Factors::new(term, group * TOGETHER, &inverse)).collect()
        });
        Self { frame, count, transform, spreader, scales, factors }
    }

    /// Computes the wanted quantities at all points of a line.
    pub fn evaluate(&self, line: &Line, wanted: FieldSet, scratch: &mut LineScratch, out: &mut Fields) {
        let waves = self.waves(line);
        let cells = self.spreader.cells() as f64;
        let direct = DIRECT * waves as f64 * self.count as f64;
        if direct < SPREAD * waves as f64 + TRANSFORM * cells * libm::log2(cells) {
            self.sum(line, wanted, scratch, out);
        } else {
            self.transform(line, waves, wanted, scratch, out);
        }
    }

    /// Returns how many of the leading waves the footprint leaves.
    pub(crate) fn waves(&self, line: &Line) -> usize {
        self.frame.resolved(line.footprint)
    }

    pub(crate) fn sum(&self, line: &Line, wanted: FieldSet, scratch: &mut LineScratch, out: &mut Fields) {
        let [x, z, footprint] = &mut scratch.points;
        for (axis, values) in [&mut *x, &mut *z].into_iter().enumerate() {
            values.clear();
            values.extend((0..self.count).map(|index| line.origin[axis] + index as f64 * line.step[axis]));
        }
        footprint.clear();
        footprint.resize(self.count, line.footprint);
        self.frame.direct(Points { x, z, footprint }, wanted, out);
    }

    pub(crate) fn transform(
        &self,
        line: &Line,
        waves: usize,
        wanted: FieldSet,
        scratch: &mut LineScratch,
        out: &mut Fields,
    ) {
        out.reset(wanted, self.count);
        if wanted.slope_variance {
            out.slope_variance.fill(self.lost_variance(line, waves));
        }
        self.prepare(line, waves, scratch);
        for first in (0..SUMS).step_by(TOGETHER) {
            if wanted.sums()[first..].iter().take(TOGETHER).any(|wanted| *wanted) {
                self.sums(first, line, waves, scratch, out);
            }
        }
    }

    /// Computes sines and cosines of all phases at the line's middle, times the share that the footprint leaves.
    fn prepare(&self, line: &Line, waves: usize, scratch: &mut LineScratch) {
        let LineScratch { phases, sines, cosines, .. } = scratch;
        let padded = waves.next_multiple_of(LANES);
        for values in [&mut *phases, &mut *sines, &mut *cosines] {
            values.clear();
            values.resize(padded, 0.0);
        }
        let middle = (self.count / 2) as f64;
        let [x, z] = [0, 1].map(|axis| line.origin[axis] + middle * line.step[axis]);
        let print = (line.footprint as f32).min(1e15);
        let frame = self.frame;
        frame.phases.at(x, z, &mut phases[..waves]);
        let blocks = phases.chunks(LANES).zip(sines.chunks_mut(LANES)).zip(cosines.chunks_mut(LANES));
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            for (((phases, sines), cosines), filters) in blocks.zip(frame.filters.chunks(LANES)) {
                let mut exponents = [0.0; LANES];
                exponents[..filters.len()].copy_from_slice(filters);
                let share = exp_neg(simd, f32x16::from_slice(simd, &exponents) * (print * print));
                let (sin, cos) = sincos_turns(f32x16::from_slice(simd, phases));
                (sin * share).store_slice(sines);
                (cos * share).store_slice(cosines);
            }
        }));
    }

    /// Computes the sums from `first` on.
    fn sums(&self, first: usize, line: &Line, waves: usize, scratch: &mut LineScratch, out: &mut Fields) {
        let LineScratch { sines, cosines, cells, work, .. } = scratch;
        let count = self.spreader.cells();
        let factors = &self.factors[first / TOGETHER];
        cells.clear();
        cells.resize(count + WIDTH, lanes::splat(Zero::zero()));
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            for wave in 0..waves {
                let [x, z] = self.frame.phases.turns(wave);
                let (place, weights) = self.spreader.place(x * line.step[0] + z * line.step[1]);
                let [plus, minus] = factors[wave].amplitudes(sines[wave], cosines[wave]);
                // The negative frequency is mirrored about cell 0, which is `BEFORE` cells from the start.
                let mirrored = count - place + 2 * BEFORE;
                for (neighbor, weight) in weights.iter().enumerate() {
                    add(&mut cells[place + neighbor], &plus, *weight);
                    add(&mut cells[mirrored - neighbor], &minus, *weight);
                }
            }
        }));
        // The grid is circular: cells before its start or beyond its end belong to the other end.
        for cell in 0..WIDTH {
            let (from, to) = if cell < BEFORE { (cell, cell + count) } else { (cell + count, cell) };
            cells[to] = cells[to] + cells[from];
        }
        let circle = &mut cells[BEFORE..BEFORE + count];
        work.resize(self.transform.scratch_len(), lanes::splat(Zero::zero()));
        self.transform.process(circle, work);
        let middle = self.count / 2;
        let sums = out.sums_mut().into_iter().skip(first);
        // Sums that are not wanted are empty.
        for (index, sum) in sums.enumerate().take(TOGETHER) {
            // Points before the middle are at the end of the circle.
            let points = circle[count - middle..].iter().chain(&circle[..self.count - middle]);
            let (lane, scale) = (index / 2, self.scales[first + index]);
            for ((sum, value), correction) in sum.iter_mut().zip(points).zip(self.spreader.corrections()) {
                let part = if index % 2 == 0 { &value.re } else { &value.im };
                *sum = part.0[lane] * correction * scale;
            }
        }
    }

    /// Returns ½(a·k)²(1 − share²) over all waves; waves that are cut count as lost completely.
    fn lost_variance(&self, line: &Line, waves: usize) -> f32 {
        let square = line.footprint.min(1e15) * line.footprint.min(1e15);
        let frame = self.frame;
        let kept = frame.terms[..waves].iter().zip(&frame.filters);
        let lost = kept.fold(frame.variance_from[waves], |sum, (term, &filter)| {
            let share = libm::exp(-f64::from(filter) * square);
            sum + f64::from(term.variance) * (1.0 - share * share)
        });
        lost as f32
    }
}

/// Returns the factors of a wave's sine and cosine in each sum.
#[inline(always)]
fn factors(term: &Term) -> [[f32; 2]; ROOM] {
    let ([dx, dz, yx, yz, vy], [dy, xx, xz, zz, vx, vz]) = (term.sines, term.cosines);
    let (sine, cosine) = (|factor| [factor, 0.0], |factor| [0.0, factor]);
    let mut factors = [[0.0; 2]; ROOM];
    factors[..SUMS].copy_from_slice(&[
        sine(dx),
        cosine(dy),
        sine(dz),
        sine(yx),
        sine(yz),
        cosine(xx),
        cosine(xz),
        cosine(zz),
        cosine(vx),
        sine(vy),
        cosine(vz),
    ]);
    factors
}

/// Real and imaginary parts of four numbers.
type Parts = [[f32; lanes::WIDTH]; 2];

impl Factors {
    /// Multiplies the factors in the sums from `first` on by the inverses of their scales.
    fn new(term: &Term, first: usize, inverse: &[f32; TOGETHER]) -> Self {
        let factors = factors(term);
        let of = |part: usize| {
            [0, 1]
                .map(|odd| std::array::from_fn(|lane| factors[first + 2 * lane + odd][part] * inverse[2 * lane + odd]))
        };
        Self { sines: of(0), cosines: of(1) }
    }

    /// Returns what a wave adds to the cells at its frequency and at its negative: for two real sums Re(A·e^{iθ}) and
    /// Re(B·e^{iθ}) in one complex sequence, these are ½(A + iB) and ½(Ā + iB̄).
    #[inline(always)]
    fn amplitudes(&self, sin: f32, cos: f32) -> [Parts; 2] {
        // s·sin θ + c·cos θ is the real part of (c − is)·e^{iθ}.
        let amplitude = |odd: usize, lane: usize| {
            let (s, c) = (self.sines[odd][lane], self.cosines[odd][lane]);
            [c * cos + s * sin, c * sin - s * cos]
        };
        let (mut plus, mut minus) = (Parts::default(), Parts::default());
        for lane in 0..lanes::WIDTH {
            let ([a, ai], [b, bi]) = (amplitude(0, lane), amplitude(1, lane));
            (plus[0][lane], plus[1][lane]) = (0.5 * (a - bi), 0.5 * (ai + b));
            (minus[0][lane], minus[1][lane]) = (0.5 * (a + bi), 0.5 * (b - ai));
        }
        [plus, minus]
    }
}

#[inline(always)]
fn add(cell: &mut lanes::Line<f32>, [real, imaginary]: &Parts, weight: f32) {
    for (cell, part) in cell.re.0.iter_mut().zip(real) {
        *cell += part * weight;
    }
    for (cell, part) in cell.im.0.iter_mut().zip(imaginary) {
        *cell += part * weight;
    }
}
