//! Sums of waves in f64 over squares of points in the axes of a frame, whose rows lie under one footprint each.

use crate::frame::SeaFrame;
use crate::kernel64::{LANES, halved, sincos};
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use std::f64::consts::{LOG2_E, TAU};
use std::ops::Range;

/// Number of points that are summed side by side in registers, and of waves that are added one after another to them: their
/// factors fit in the nearest cache.
const BLOCK: usize = LANES;
const TOGETHER: usize = 64;
/// Most squares that are summed together.
const SQUARES: usize = LANES;
/// Rounding errors of a phase, relative to the turns of its parts: each is a product of rounded factors, and they are
/// added twice, once in the world's axes and once in the frame's.
const TURN_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A sea at one time in the axes of a frame: u along a horizontal heading, v across it, both in meters from an origin.
///
/// Footprints depend on u alone, as those of a camera do. A wave is then the product of a factor of u and a factor of v,
/// which replaces a sine, a cosine and an exponential for each point by one complex product.
///
/// ```
/// use trochoid_sea::{FramedSea, GerstnerSpectrum, Sea};
///
/// let frame = Sea::new(GerstnerSpectrum { count: 50, ..GerstnerSpectrum::default() }.waves()?).at(2.0);
/// let (origin, heading) = ([3.0, -4.0], [0.6, 0.8]);
/// let sea = FramedSea::new(&frame, origin, heading);
/// let (u, v, footprint) = (7.0, -2.0, 0.4);
/// let mut points = vec![[0.0; 3]];
/// let all = 0..sea.waves().len();
/// sea.squares(&sea.rows(&[(u, footprint)], all.clone()), &sea.columns(&[0.0], all), &[v], &mut points);
/// let place = [origin[0] + 0.6 * u - 0.8 * v, origin[1] + 0.8 * u + 0.6 * v];
/// let [x, y, z] = frame.evaluate(place, footprint).displacement;
/// let [along, up, across] = points[0];
/// assert!((along - (0.6 * x + 0.8 * z)).abs() < 1e-12 && (up - y).abs() < 1e-12);
/// assert!((across - (0.6 * z - 0.8 * x)).abs() < 1e-12);
/// # Ok::<(), trochoid_sea::SpectrumError>(())
/// ```
#[derive(Clone, Debug)]
pub struct FramedSea {
    /// By falling wavelength.
    waves: Vec<FramedWave>,
    level: Level,
}

/// A wave in the axes of a frame.
#[derive(Clone, Copy, Debug)]
pub struct FramedWave {
    /// Wave number k, in rad/m.
    pub number: f64,
    /// Its parts along u and v, in rad/m.
    pub numbers: [f64; 2],
    /// Amplitudes along u, up, and along v, in meters.
    pub amplitudes: [f64; 3],
    /// Turns per meter along u and v, and turns at the origin.
    turns: [f64; 2],
    origin: f64,
    /// Turns per meter along the world's axes, by their sizes, and those that the origin takes.
    sizes: [f64; 2],
}

impl FramedWave {
    /// Returns a bound of the difference, in radians, between its phases here and in [`SeaFrame::evaluate`] at places
    /// up to some meters from the frame's origin.
    pub fn phase_error(&self, away: f64) -> f64 {
        let [by_meter, at_origin] = self.phase_errors();
        by_meter * away + at_origin
    }

    /// Returns the parts of that bound: in radians per meter from the origin, and in radians there.
    pub fn phase_errors(&self) -> [f64; 2] {
        [self.sizes[0], self.sizes[1] + 1.0].map(|turns| TAU * TURN_ROUNDING * turns)
    }
}

/// Factors of waves for rows.
#[derive(Clone, Debug)]
pub struct RowFactors {
    waves: Range<usize>,
    /// By row, then for each component the factors of cos and of sin of the column's phase, wave by wave.
    factors: Vec<f64>,
    rows: usize,
}

/// Factors of waves for columns at offsets from a middle.
#[derive(Clone, Debug)]
pub struct ColumnFactors {
    waves: Range<usize>,
    /// By wave: cos, then sin, of the phases of all columns, and of some more up to the width.
    factors: Vec<f64>,
    columns: usize,
    width: usize,
}

impl RowFactors {
    /// Returns the factors for a row of some of its waves, counted from its own first one.
    #[inline(always)]
    fn of(&self, row: usize, own: &Range<usize>) -> [&[f64]; 6] {
        let parts: [usize; 6] = std::array::from_fn(|part| (6 * row + part) * self.waves.len());
        parts.map(|start| &self.factors[start + own.start..start + own.end])
    }
}

impl FramedSea {
    /// Returns the sea in the axes of a frame; `heading` is a horizontal unit vector x, z.
    pub fn new(frame: &SeaFrame, origin: [f64; 2], heading: [f64; 2]) -> Self {
        let [x, z] = heading;
        let turned = |[a, b]: [f64; 2]| [a * x + b * z, b * x - a * z];
        let wave = |index: usize| {
            let (wave, turns) = (&frame.sorted[index], frame.phases.turns(index));
            let [along, across] = turned(wave.direction);
            let reached = turns[0].abs() * origin[0].abs() + turns[1].abs() * origin[1].abs();
            FramedWave {
                number: wave.wave_number(),
                numbers: turned(turns).map(|turns| TAU * turns),
                amplitudes: [wave.horizontal * along, wave.amplitude, wave.horizontal * across],
                turns: turned(turns),
                origin: frame.phases.of(index, origin),
                sizes: [turns[0].abs() + turns[1].abs(), reached],
            }
        };
        Self { waves: (0..frame.len()).map(wave).collect(), level: Level::new() }
    }

    /// Returns the waves by falling wavelength.
    pub fn waves(&self) -> &[FramedWave] {
        &self.waves
    }

    /// Returns a bound of the difference between sums here and in [`SeaFrame::evaluate`] that is not due to phases
    /// ([`FramedWave::phase_error`]), relative to the sum of the waves' sizes.
    ///
    /// Each wave loses less than 64 units of the last place here and there, most of it in the exponential, and each sum
    /// one more for each wave.
    pub fn rounding(&self) -> f64 {
        f64::EPSILON * (64.0 + self.waves.len() as f64)
    }

    /// Returns the factors of some waves for rows, given their u and footprint in meters.
    ///
    /// # Panics
    /// There are fewer waves.
    pub fn rows(&self, rows: &[(f64, f64)], waves: Range<usize>) -> RowFactors {
        let mut factors = vec![0.0; rows.len() * 6 * waves.len()];
        for ((u, footprint), factors) in rows.iter().zip(factors.chunks_exact_mut((6 * waves.len()).max(1))) {
            let filter = footprint * footprint / 8.0;
            let waves = &self.waves[waves.clone()];
            dispatch!(self.level, simd => simd.vectorize(
                #[inline(always)]
                || row(simd, waves, *u, filter * LOG2_E, factors)
            ));
        }
        RowFactors { waves, factors, rows: rows.len() }
    }

    /// Returns the factors of all waves for rows whose squares are to hold derivatives of the displacement by the
    /// rest point instead: ∂Δu/∂u, ∂Δu/∂v = ∂Δv/∂u, and ∂Δv/∂v.
    pub(crate) fn strain_rows(&self, rows: &[(f64, f64)]) -> RowFactors {
        let left = self.waves.len();
        let mut strains = self.rows(rows, 0..left);
        for factors in strains.factors.chunks_exact_mut((6 * left).max(1)) {
            for (index, wave) in self.waves.iter().enumerate() {
                let [a, b] = wave.numbers;
                let [along_sin, along_cos, .., across_sin, across_cos]: [f64; 6] =
                    std::array::from_fn(|part| factors[part * left + index]);
                // −h·sin θ becomes −h·k·cos θ, and −h·cos θ becomes h·k·sin θ.
                let by = |number: f64, sin: f64, cos: f64| [number * cos, -number * sin];
                let [[uu, uu_sin], [uv, uv_sin], [vv, vv_sin]] =
                    [by(a, along_sin, along_cos), by(b, along_sin, along_cos), by(b, across_sin, across_cos)];
                for (part, factor) in [uu, uu_sin, uv, uv_sin, vv, vv_sin].into_iter().enumerate() {
                    factors[part * left + index] = factor;
                }
            }
        }
        strains
    }

    /// Returns the factors of some waves for columns at offsets in meters from the middles that [`FramedSea::squares`] is given, or to
    /// both sides of the one that [`FramedSea::mirrored`] is given.
    ///
    /// # Panics
    /// There are fewer waves.
    pub fn columns(&self, offsets: &[f64], waves: Range<usize>) -> ColumnFactors {
        let columns = offsets.len();
        let width = columns.next_multiple_of(BLOCK);
        let own = &self.waves[waves.clone()];
        let mut factors = vec![0.0; own.len() * 2 * width];
        dispatch!(self.level, simd => simd.vectorize(
            #[inline(always)]
            || {
                for (wave, factors) in own.iter().zip(factors.chunks_exact_mut((2 * width).max(1))) {
                    let (cosines, sines) = factors.split_at_mut(width);
                    let blocks = cosines.chunks_exact_mut(BLOCK).zip(sines.chunks_exact_mut(BLOCK));
                    for ((cosines, sines), offsets) in blocks.zip(offsets.chunks(BLOCK)) {
                        let offsets = lanes(simd, offsets.iter().copied());
                        let [sin, cos] = sincos(simd, offsets * (2.0 * wave.turns[1]));
                        cosines.copy_from_slice(&cos.to_array());
                        sines.copy_from_slice(&sin.to_array());
                    }
                }
            }
        ));
        ColumnFactors { waves, factors, columns, width }
    }

    /// Writes the displacements along u, up and along v at the points of squares, square by square and row by row: the
    /// columns of each stand at their offsets from its middle.
    ///
    /// # Panics
    /// `out` does not have one entry for each point, or rows and columns are of different waves.
    pub fn squares(&self, rows: &RowFactors, columns: &ColumnFactors, middles: &[f64], out: &mut [[f64; 3]]) {
        let points = rows.rows * columns.columns;
        assert_eq!(out.len(), points * middles.len(), "one entry for each point");
        assert_eq!(rows.waves, columns.waves, "rows and columns of the same waves");
        let all = &self.waves[rows.waves.clone()];
        for (middles, out) in middles.chunks(SQUARES).zip(out.chunks_mut((points * SQUARES).max(1))) {
            let width = (middles.len() * columns.columns).next_multiple_of(BLOCK);
            let mut sums = vec![0.0; rows.rows * 3 * width];
            let mut phases = vec![0.0; 2 * TOGETHER * width];
            dispatch!(self.level, simd => simd.vectorize(
                #[inline(always)]
                || {
                    for first in (0..all.len()).step_by(TOGETHER) {
                        let own = first..(first + TOGETHER).min(all.len());
                        turn(simd, &all[own.clone()], columns, first, middles, width, &mut phases);
                        add(rows, own, width, &phases, &mut sums);
                    }
                }
            ));
            for (square, out) in out.chunks_exact_mut(points).enumerate() {
                for (index, out) in out.iter_mut().enumerate() {
                    let (row, column) = (index / columns.columns, index % columns.columns);
                    let at = |axis: usize| sums[(3 * row + axis) * width + square * columns.columns + column];
                    *out = [at(0), at(1), at(2)];
                }
            }
        }
    }

    /// Does the same for one square whose columns stand at both sides of its middle: first those before it, the
    /// farthest first, then those behind it, the nearest first.
    ///
    /// Mirrored phases have the same cosine and opposite sines, so that this takes half the products.
    ///
    /// # Panics
    /// `out` does not have one entry for each point, or rows and columns are of different waves.
    pub fn mirrored(&self, rows: &RowFactors, columns: &ColumnFactors, middle: f64, out: &mut [[f64; 3]]) {
        let (side, width) = (columns.columns, columns.width);
        assert_eq!(out.len(), rows.rows * 2 * side, "one entry for each point");
        assert_eq!(rows.waves, columns.waves, "rows and columns of the same waves");
        let all = &self.waves[rows.waves.clone()];
        // For each row and component the even part, then the odd part.
        let mut sums = vec![0.0; rows.rows * 6 * width];
        dispatch!(self.level, simd => simd.vectorize(
            #[inline(always)]
            || {
                for first in (0..all.len()).step_by(TOGETHER) {
                    let own = first..(first + TOGETHER).min(all.len());
                    let [mut cosines, mut sines] = [[0.0; TOGETHER]; 2];
                    let blocks = cosines.chunks_exact_mut(LANES).zip(sines.chunks_exact_mut(LANES));
                    for ((cosines, sines), waves) in blocks.zip(all[own.clone()].chunks(LANES)) {
                        let turns = lanes(simd, waves.iter().map(|wave| 2.0 * wave.turns[1]));
                        let [sin, cos] = sincos(simd, turns * middle);
                        cosines.copy_from_slice(&cos.to_array());
                        sines.copy_from_slice(&sin.to_array());
                    }
                    for (row, sums) in sums.chunks_exact_mut((6 * width).max(1)).enumerate() {
                        let turned = turned(&rows.of(row, &own), &cosines, &sines);
                        add_mirrored(simd, &turned, columns, &own, sums);
                    }
                }
            }
        ));
        for (sums, out) in sums.chunks_exact((6 * width).max(1)).zip(out.chunks_exact_mut((2 * side).max(1))) {
            let (before, behind) = out.split_at_mut(side);
            for (column, (before, behind)) in before.iter_mut().rev().zip(behind).enumerate() {
                for axis in 0..3 {
                    let (even, odd) = (sums[2 * axis * width + column], sums[(2 * axis + 1) * width + column]);
                    (before[axis], behind[axis]) = (even - odd, even + odd);
                }
            }
        }
    }
}

/// Returns up to eight numbers, and 0 in the lanes that are left.
#[inline(always)]
fn lanes<S: Simd>(simd: S, numbers: impl Iterator<Item = f64>) -> f64x8<S> {
    let mut lanes = [0.0; LANES];
    for (lane, number) in lanes.iter_mut().zip(numbers) {
        *lane = number;
    }
    f64x8::load_array(simd, lanes)
}

/// Computes the factors of one row, whose filter is f²/8 · log₂ e.
#[inline(always)]
fn row<S: Simd>(simd: S, waves: &[FramedWave], u: f64, filter: f64, factors: &mut [f64]) {
    let left = waves.len();
    for (block, waves) in waves.chunks(LANES).enumerate() {
        let turns = lanes(simd, waves.iter().map(|wave| wave.turns[0]));
        let origin = lanes(simd, waves.iter().map(|wave| wave.origin));
        let number = lanes(simd, waves.iter().map(|wave| wave.number));
        let along = lanes(simd, waves.iter().map(|wave| wave.amplitudes[0]));
        let up = lanes(simd, waves.iter().map(|wave| wave.amplitudes[1]));
        let across = lanes(simd, waves.iter().map(|wave| wave.amplitudes[2]));
        let [sin, cos] = sincos(simd, (turns * u + origin) * 2.0);
        let share = halved(simd, number * number * filter);
        let (sin, cos) = (sin * share, cos * share);
        let parts = [
            along * sin * -1.0,
            along * cos * -1.0,
            up * cos,
            up * sin * -1.0,
            across * sin * -1.0,
            across * cos * -1.0,
        ];
        for (part, values) in parts.into_iter().enumerate() {
            factors[part * left + LANES * block..][..waves.len()].copy_from_slice(&values.to_array()[..waves.len()]);
        }
    }
}

/// Turns a row's factors of some waves by the phases of a middle, given their cosines and sines.
#[inline(always)]
fn turned(factors: &[&[f64]; 6], cosines: &[f64; TOGETHER], sines: &[f64; TOGETHER]) -> [[f64; TOGETHER]; 6] {
    let mut turned = [[0.0; TOGETHER]; 6];
    for axis in 0..3 {
        let (even, odd) = (factors[2 * axis], factors[2 * axis + 1]);
        let (evens, odds) = turned[2 * axis..].split_at_mut(1);
        let phases = cosines.iter().zip(sines);
        for ((((to_even, to_odd), even), odd), (cos, sin)) in
            evens[0].iter_mut().zip(&mut odds[0]).zip(even).zip(odd).zip(phases)
        {
            *to_even = even * cos + odd * sin;
            *to_odd = odd * cos - even * sin;
        }
    }
    turned
}

/// Adds some waves at the columns of one row: the parts that are the same at both sides of the middle, and those that
/// are opposite.
#[inline(always)]
fn add_mirrored<S: Simd>(
    simd: S,
    turned: &[[f64; TOGETHER]; 6],
    columns: &ColumnFactors,
    waves: &Range<usize>,
    sums: &mut [f64],
) {
    let width = columns.width;
    let own = &columns.factors[2 * width * waves.start..2 * width * waves.end];
    for start in (0..width).step_by(BLOCK) {
        let at = |part: usize| part * width + start..part * width + start + BLOCK;
        let mut total: [f64x8<S>; 6] = [f64x8::splat(simd, 0.0); 6];
        for (part, total) in total.iter_mut().enumerate() {
            *total = f64x8::from_slice(simd, &sums[at(part)]);
        }
        for (index, factors) in own.chunks_exact(2 * width).enumerate().take(TOGETHER) {
            let cos = f64x8::from_slice(simd, &factors[at(0)]);
            let sin = f64x8::from_slice(simd, &factors[at(1)]);
            for axis in 0..3 {
                total[2 * axis] += cos * turned[2 * axis][index];
                total[2 * axis + 1] += sin * turned[2 * axis + 1][index];
            }
        }
        for (part, total) in total.iter().enumerate() {
            total.store_slice(&mut sums[at(part)]);
        }
    }
}

/// Computes cos, then sin, of the phases of some waves along all columns of some squares, wave by wave.
#[inline(always)]
fn turn<S: Simd>(
    simd: S,
    waves: &[FramedWave],
    columns: &ColumnFactors,
    first: usize,
    middles: &[f64],
    width: usize,
    phases: &mut [f64],
) {
    let at = lanes(simd, middles.iter().copied());
    for (index, wave) in waves.iter().enumerate() {
        let [sines, cosines] = sincos(simd, at * (2.0 * wave.turns[1]));
        let own = &columns.factors[2 * (first + index) * columns.width..][..2 * columns.width];
        let (own_cos, own_sin) = own.split_at(columns.width);
        let (cos, sin) = phases[2 * index * width..][..2 * width].split_at_mut(width);
        for square in 0..middles.len() {
            let columns = square * columns.columns..(square + 1) * columns.columns;
            let places = cos[columns.clone()].iter_mut().zip(&mut sin[columns]);
            for ((cos, sin), (c, s)) in places.zip(own_cos.iter().zip(own_sin)) {
                *cos = c * cosines[square] - s * sines[square];
                *sin = s * cosines[square] + c * sines[square];
            }
        }
    }
}

/// Adds some waves at all points.
#[inline(always)]
fn add(rows: &RowFactors, waves: Range<usize>, width: usize, phases: &[f64], sums: &mut [f64]) {
    for row in 0..rows.rows {
        let factors = rows.of(row, &waves);
        for start in (0..width).step_by(BLOCK) {
            let mut total = [[0.0; BLOCK]; 3];
            for (axis, total) in total.iter_mut().enumerate() {
                total.copy_from_slice(&sums[(3 * row + axis) * width + start..][..BLOCK]);
            }
            for index in 0..waves.len() {
                let cos = &phases[2 * index * width + start..][..BLOCK];
                let sin = &phases[(2 * index + 1) * width + start..][..BLOCK];
                for axis in 0..3 {
                    for lane in 0..BLOCK {
                        total[axis][lane] +=
                            factors[2 * axis][index] * cos[lane] + factors[2 * axis + 1][index] * sin[lane];
                    }
                }
            }
            for (axis, total) in total.iter().enumerate() {
                sums[(3 * row + axis) * width + start..][..BLOCK].copy_from_slice(total);
            }
        }
    }
}
