//! Weights as files store them: rounded so that their sum stays exactly 1.

use fearless_simd::{Level, Simd, dispatch};
use std::ops::Range;

/// Pixels that are looked at together for which colors they are mixed from.
const RUN: usize = 128;

/// How weights are stored: as multiples of a unit whose sums are exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Storing {
    /// 16-bit floats: multiples of 2⁻¹¹.
    #[default]
    Half,
    /// 32-bit floats: multiples of 2⁻²⁴.
    Float,
}

impl Storing {
    /// Returns the number of units in 1.
    #[must_use]
    pub fn units(self) -> u32 {
        match self {
            Self::Half => 1 << 11,
            Self::Float => 1 << 24,
        }
    }

    /// Rounds weights that are ≥ 0 and sum to 1 up to rounding. The results are ≥ 0, and their sum is exactly 1 in any
    /// order, since all partial sums are multiples of the unit.
    ///
    /// ```
    /// use trochoid_weights::Storing;
    /// let stored = Storing::Half.round(&[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0]);
    /// assert_eq!(stored.iter().sum::<f32>(), 1.0);
    /// ```
    #[must_use]
    pub fn round(self, weights: &[f64]) -> Vec<f32> {
        let mut weights = weights.to_vec();
        self.apportion(&mut weights);
        weights.into_iter().map(|weight| weight as f32).collect()
    }

    /// Does the same as [`round`](Self::round) in place, and returns how much weight moved from some colors to others.
    ///
    /// Each weight is rounded down to whole units; the units that are left go to the largest remainders, one each, of
    /// equal ones to the first, so that the same weights are stored the same. No other multiples of the unit with that
    /// sum move less weight, and a weight of 0 stays 0.
    #[inline(always)]
    pub fn apportion(self, weights: &mut [f64]) -> f64 {
        let units = f64::from(self.units());
        match weights.len() {
            0..=4 => among::<4>(weights, units),
            5..=8 => among::<8>(weights, units),
            9..=16 => among::<16>(weights, units),
            17..=32 => among::<32>(weights, units),
            _ => among_many(weights, units),
        }
    }

    /// Apportions the weights of pixels one after another, `colors` of each, and returns the largest weight that moved at
    /// a pixel.
    ///
    /// # Panics
    /// There are no colors.
    pub fn apportion_each(self, weights: &mut [f64], colors: usize) -> f64 {
        let level = Level::new();
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
            weights.chunks_exact_mut(colors).fold(0.0, |most: f64, weights| most.max(self.apportion(weights)))
        }))
    }

    /// Apportions the weights of pixels, one row for each color, and returns the largest weight that moved at a pixel.
    /// `stored` is filled with them; weights that are not above 0 are stored as 0.
    ///
    /// ```
    /// use trochoid_weights::Storing;
    /// let mut stored = [vec![0.0; 2], vec![0.0; 2]];
    /// let moved = Storing::Half.apportion_rows(&[&[0.25, 1.0], &[0.75, 0.0]], &mut stored);
    /// assert_eq!((stored, moved), ([vec![0.25, 1.0], vec![0.75, 0.0]], 0.0));
    /// ```
    ///
    /// # Panics
    /// Rows differ in number or length.
    pub fn apportion_rows(self, rows: &[&[f32]], stored: &mut [Vec<f32>]) -> f64 {
        assert_eq!(rows.len(), stored.len(), "a row for each color");
        let level = Level::new();
        let count = rows.first().map_or(0, |row| row.len());
        let mut most = 0.0_f64;
        for start in (0..count).step_by(RUN) {
            let pixels = start..count.min(start + RUN);
            let moved =
                dispatch!(level, simd => simd.vectorize(#[inline(always)] || self.run(rows, pixels.clone(), stored)));
            most = most.max(moved);
        }
        most
    }

    /// Does so for a few pixels.
    #[inline(always)]
    fn run(self, rows: &[&[f32]], pixels: Range<usize>, stored: &mut [Vec<f32>]) -> f64 {
        // Without leaving early, weights are compared as vectors.
        let is_used = |row: &[f32]| row[pixels.clone()].iter().fold(false, |used, weight| used | (*weight > 0.0));
        let used: Vec<usize> = (0..rows.len()).filter(|place| is_used(rows[*place])).collect();
        stored.iter_mut().for_each(|row| row[pixels.clone()].fill(0.0));
        let (mut weights, mut places) = (Vec::with_capacity(used.len()), Vec::with_capacity(used.len()));
        let mut most = 0.0_f64;
        for pixel in pixels {
            weights.clear();
            places.clear();
            for place in used.iter().filter(|place| rows[**place][pixel] > 0.0) {
                weights.push(f64::from(rows[*place][pixel]));
                places.push(*place);
            }
            most = most.max(self.apportion(&mut weights));
            for (weight, place) in weights.iter().zip(&places) {
                stored[*place][pixel] = *weight as f32;
            }
        }
        most
    }

    /// Bounds how far storing moves a channel of a pixel that `colors` colors mix, given the range of their channel.
    ///
    /// With s units left for m remainders that sum to s, the s largest sum to at least s²/m, so that at most s − s²/m
    /// units move, which is largest for s = m/2.
    #[must_use]
    pub fn error(self, colors: usize, range: f64) -> f64 {
        let most = (colors / 2) * colors.div_ceil(2);
        most as f64 / colors.max(1) as f64 / f64::from(self.units()) * range
    }
}

/// Remainders that differ by less than this part of a unit count as equal, so that they have keys.
const PARTS: f64 = (1_u64 << 46) as f64;

/// Apportions up to `N` weights: each counts the remainders that go before its own. All pairs are compared without a
/// branch, which is several times as fast as sorting so few.
#[inline(always)]
fn among<const N: usize>(weights: &mut [f64], units: f64) -> f64 {
    let scale = units / weights.iter().sum::<f64>();
    let mut given = [0.0; N];
    given[..weights.len()].copy_from_slice(weights);
    let (mut wholes, mut remainders, mut keys) = ([0.0; N], [0.0; N], [0.0; N]);
    for index in 0..N {
        let scaled = given[index] * scale;
        wholes[index] = floor(scaled);
        remainders[index] = scaled - wholes[index];
        // A whole number below 2⁵², which is a remainder and then its place.
        let key = floor(remainders[index] * PARTS) * 64.0 + (N - index) as f64;
        keys[index] = if given[index] > 0.0 { key } else { -1.0 };
    }
    let mut before = [0.0; N];
    for other in keys {
        for (before, key) in before.iter_mut().zip(&keys) {
            *before += if other > *key { 1.0 } else { 0.0 };
        }
    }
    let rest = units - wholes.iter().sum::<f64>();
    let mut moved = [0.0; N];
    for index in 0..N {
        let gets_one = (before[index] < rest) & (keys[index] >= 0.0);
        given[index] = (wholes[index] + if gets_one { 1.0 } else { 0.0 }) * (1.0 / units);
        moved[index] = if gets_one { 1.0 - remainders[index] } else { 0.0 };
    }
    weights.copy_from_slice(&given[..weights.len()]);
    moved.iter().sum::<f64>() / units
}

/// Returns the whole part of a number from 0 to 2⁵¹, without the function of processors that lack the instruction.
#[inline(always)]
fn floor(value: f64) -> f64 {
    // Added to a number that is smaller, 2⁵² rounds it to a whole one.
    const WHOLE: f64 = (1_u64 << 52) as f64;
    let near = (value + WHOLE) - WHOLE;
    near - if near > value { 1.0 } else { 0.0 }
}

/// Apportions any number of weights.
fn among_many(weights: &mut [f64], units: f64) -> f64 {
    let scale = units / weights.iter().sum::<f64>();
    let mut order = Vec::new();
    let mut rest = units;
    for (index, weight) in weights.iter_mut().enumerate().filter(|(_, weight)| **weight > 0.0) {
        let scaled = *weight * scale;
        let whole = scaled.floor();
        order.push((((scaled - whole) * PARTS).floor(), index, scaled - whole));
        rest -= whole;
        *weight = whole / units;
    }
    order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut moved = 0.0;
    for (_, index, remainder) in order.iter().take(rest.max(0.0) as usize) {
        weights[*index] += 1.0 / units;
        moved += 1.0 - remainder;
    }
    moved / units
}
