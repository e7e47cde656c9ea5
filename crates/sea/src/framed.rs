//! Sums of waves in f64 over squares of points in the axes of a frame, whose rows lie under one footprint each.

use crate::frame::SeaFrame;
use crate::precise::{CUT, MOST, exp_neg, sincos};
use fearless_simd::{Level, Simd, dispatch};
use std::f64::consts::TAU;

/// Number of points of a column that are summed side by side.
const LANES: usize = 8;
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
/// sea.square(&sea.rows(&[(u, footprint)]), &sea.columns(&[0.0]), v, &mut points);
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
        TAU * TURN_ROUNDING * (self.sizes[0] * away + self.sizes[1] + 1.0)
    }
}

/// Factors of waves for rows.
#[derive(Clone, Debug)]
pub struct RowFactors {
    /// Number of waves that are left at the row with the least footprint.
    left: usize,
    /// By row and wave: factors of cos and sin of the column's phase for each component.
    factors: Vec<[f64; 6]>,
    rows: usize,
}

/// Factors of waves for columns at offsets from a middle.
#[derive(Clone, Debug)]
pub struct ColumnFactors {
    /// By wave: cos, then sin, of each column's phase.
    factors: Vec<f64>,
    columns: usize,
    padded: usize,
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

    /// Returns the factors of rows, given their u and footprint in meters.
    pub fn rows(&self, rows: &[(f64, f64)]) -> RowFactors {
        let least = rows.iter().map(|(_, footprint)| footprint * footprint / 8.0).fold(f64::INFINITY, f64::min);
        let left = self.waves.partition_point(|wave| wave.number * wave.number * least <= CUT);
        let mut factors = vec![[0.0; 6]; rows.len() * left];
        for ((u, footprint), factors) in rows.iter().zip(factors.chunks_exact_mut(left.max(1))) {
            let filter = footprint * footprint / 8.0;
            let waves = &self.waves[..left];
            dispatch!(self.level, simd => simd.vectorize(
                #[inline(always)]
                || row(waves, *u, filter, factors)
            ));
        }
        RowFactors { left, factors, rows: rows.len() }
    }

    /// Returns the factors of columns at offsets in meters from the middle that [`FramedSea::square`] is given.
    pub fn columns(&self, offsets: &[f64]) -> ColumnFactors {
        let padded = offsets.len().next_multiple_of(LANES);
        let mut factors = vec![0.0; self.waves.len() * 2 * padded];
        for (wave, factors) in self.waves.iter().zip(factors.chunks_exact_mut(2 * padded)) {
            for (column, offset) in offsets.iter().enumerate() {
                let (sin, cos) = sincos(reduced(wave.turns[1] * offset));
                (factors[column], factors[padded + column]) = (cos, sin);
            }
        }
        ColumnFactors { factors, columns: offsets.len(), padded }
    }

    /// Writes the displacements along u, up and along v at the points of rows and columns, row by row, with the
    /// columns' offsets from `middle`.
    ///
    /// # Panics
    /// `out` does not have one entry for each point.
    pub fn square(&self, rows: &RowFactors, columns: &ColumnFactors, middle: f64, out: &mut [[f64; 3]]) {
        assert_eq!(out.len(), rows.rows * columns.columns, "one entry for each point");
        let mut middles = vec![[0.0; 2]; rows.left];
        for (wave, middle_factor) in self.waves.iter().zip(&mut middles) {
            let (sin, cos) = sincos(reduced(wave.turns[1] * middle));
            *middle_factor = [cos, sin];
        }
        let mut turned = vec![0.0; rows.left * 2 * columns.padded];
        dispatch!(self.level, simd => simd.vectorize(
            #[inline(always)]
            || {
                turn(columns, &middles, &mut turned);
                add(rows, columns, &turned, out);
            }
        ));
    }
}

/// Returns turns reduced to −½…½.
fn reduced(turns: f64) -> f64 {
    turns - turns.round_ties_even()
}

/// Computes the factors of one row.
#[inline(always)]
fn row(waves: &[FramedWave], u: f64, filter: f64, factors: &mut [[f64; 6]]) {
    for (wave, factors) in waves.iter().zip(factors) {
        let turns = wave.turns[0] * u + wave.origin;
        let (sin, cos) = sincos(reduced(turns));
        let share = exp_neg((wave.number * wave.number * filter).min(MOST));
        let (sin, cos) = (sin * share, cos * share);
        let [along, up, across] = wave.amplitudes;
        *factors = [-along * sin, -along * cos, up * cos, -up * sin, -across * sin, -across * cos];
    }
}

/// Moves the factors of columns to a middle.
#[inline(always)]
fn turn(columns: &ColumnFactors, middles: &[[f64; 2]], turned: &mut [f64]) {
    let padded = columns.padded;
    let pairs = columns.factors.chunks_exact(2 * padded).zip(turned.chunks_exact_mut(2 * padded));
    for ((factors, turned), [cos, sin]) in pairs.zip(middles) {
        let ((c, s), (out_c, out_s)) = (factors.split_at(padded), turned.split_at_mut(padded));
        for lane in 0..padded {
            out_c[lane] = c[lane] * cos - s[lane] * sin;
            out_s[lane] = s[lane] * cos + c[lane] * sin;
        }
    }
}

/// Adds the products of all rows and columns, wave by wave.
#[inline(always)]
fn add(rows: &RowFactors, columns: &ColumnFactors, turned: &[f64], out: &mut [[f64; 3]]) {
    let padded = columns.padded;
    for row in 0..rows.rows {
        let factors = &rows.factors[row * rows.left..][..rows.left];
        for start in (0..columns.columns).step_by(LANES) {
            let mut sums = [[0.0; LANES]; 3];
            for (factors, turned) in factors.iter().zip(turned.chunks_exact(2 * padded)) {
                let (cos, sin) = (&turned[start..start + LANES], &turned[padded + start..padded + start + LANES]);
                for axis in 0..3 {
                    for lane in 0..LANES {
                        sums[axis][lane] += factors[2 * axis] * cos[lane] + factors[2 * axis + 1] * sin[lane];
                    }
                }
            }
            for lane in 0..LANES.min(columns.columns - start) {
                out[row * columns.columns + start + lane] = [sums[0][lane], sums[1][lane], sums[2][lane]];
            }
        }
    }
}
