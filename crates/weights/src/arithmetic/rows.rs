//! The partition operations over rows stored as planes: one slice per weight, one entry per pixel.
//!
//! Each operation processes short blocks of pixels, so that its running sums stay in registers or L1 and the inner
//! loops, which run over pixels, vectorize. The results equal those of the one-pixel forms bit for bit.

use super::partition::{divisor, round_f64, round_weight, share};
use super::powers::{LANES, is_ordinary, powers};
use super::{at_most, fractional_power, integer_power};

/// Pixels in a block: three running values of 8 bytes each make 1.5 KiB.
const BLOCK: usize = 64;

/// Raises a row of masks to one power, bit for bit like [`power`](super::power); chooses the method once.
#[inline(always)]
pub fn power_row(row: &mut [f32], p: f32) {
    if p == 1.0 {
        return;
    }
    if p == 2.0 {
        row.iter_mut().for_each(|t| *t = integer_power(*t, 2));
    } else if p == 3.0 {
        row.iter_mut().for_each(|t| *t = integer_power(*t, 3));
    } else if p <= 16.0 && p == p.trunc() {
        row.iter_mut().for_each(|t| *t = integer_power(*t, p as u32));
    } else {
        fractional_power_row(row, p);
    }
}

#[inline(always)]
fn fractional_power_row(row: &mut [f32], p: f32) {
    let mut rest = row;
    if is_ordinary(f64::from(p)) {
        let (groups, last) = rest.as_chunks_mut::<LANES>();
        for group in groups {
            let own = *group;
            *group = match powers(own, f64::from(p)) {
                Some(powers) => std::array::from_fn(|lane| at_most(powers[lane] as f32, own[lane])),
                None => own.map(|t| fractional_power(t, p)),
            };
        }
        rest = last;
    }
    rest.iter_mut().for_each(|t| *t = fractional_power(*t, p));
}

/// State of rounding a partition, per pixel: the largest raw weight, its plane, and the sum of the rounded weights.
struct Residual {
    best: [f64; BLOCK],
    owner: [u32; BLOCK],
    sum: [f64; BLOCK],
}

impl Residual {
    const fn new() -> Self {
        Self { best: [f64::NEG_INFINITY; BLOCK], owner: [0; BLOCK], sum: [0.0; BLOCK] }
    }

    /// Updates the state with the raw weight of one plane at pixel x and its rounded value.
    #[inline(always)]
    fn take(&mut self, x: usize, plane: usize, raw: f64, rounded: f64) {
        let larger = raw > self.best[x];
        self.owner[x] = if larger { plane as u32 } else { self.owner[x] };
        self.best[x] = if larger { raw } else { self.best[x] };
        self.sum[x] += rounded;
    }

    /// Adds the residual to the largest weight of each pixel.
    fn settle(&self, planes: &mut [&mut [f32]], start: usize, count: usize) {
        for x in 0..count {
            if let Some(plane) = planes.get_mut(self.owner[x] as usize) {
                plane[start + x] = (f64::from(plane[start + x]) + (1.0 - self.sum[x])) as f32;
            }
        }
    }
}

/// Applies [`round_partition`](super::round_partition) to planes: `planes[i][x]` is weight i at pixel x.
///
/// # Panics
///
/// If the planes differ in length.
pub fn round_partition_rows(planes: &mut [&mut [f32]]) {
    for (start, count) in blocks(planes, &[]) {
        let mut residual = Residual::new();
        for (index, plane) in planes.iter_mut().enumerate() {
            for (x, weight) in plane[start..start + count].iter_mut().enumerate() {
                let rounded = round_weight(*weight);
                residual.take(x, index, f64::from(*weight), f64::from(rounded));
                *weight = rounded;
            }
        }
        residual.settle(planes, start, count);
    }
}

/// Applies [`normalize`](super::normalize) to planes: from n rows of values to n + 1 rows of weights.
///
/// # Panics
///
/// If `out` does not hold exactly one more row than `values`, or the rows differ in length.
pub fn normalize_rows(values: &[&[f32]], floor: f32, out: &mut [&mut [f32]]) {
    assert_eq!(out.len(), values.len() + 1, "normalize: one weight more than values");
    for (start, count) in blocks(out, values) {
        let mut sum = [0.0_f64; BLOCK];
        for row in values {
            for (sum, &v) in sum.iter_mut().zip(&row[start..start + count]) {
                *sum += share(v);
            }
        }
        let divisor = sum.map(|sum| divisor(sum, floor));
        let mut residual = Residual::new();
        for (index, (plane, row)) in out.iter_mut().zip(values).enumerate() {
            let pixels = plane[start..start + count].iter_mut().zip(&row[start..start + count]);
            for (x, (weight, &v)) in pixels.enumerate() {
                let raw = share(v) / divisor[x];
                let rounded = round_f64(raw);
                residual.take(x, index, raw, rounded);
                *weight = rounded as f32;
            }
        }
        for (x, weight) in out[values.len()][start..start + count].iter_mut().enumerate() {
            let raw = (divisor[x] - sum[x]) / divisor[x];
            let rounded = round_f64(raw);
            residual.take(x, values.len(), raw, rounded);
            *weight = rounded as f32;
        }
        residual.settle(out, start, count);
    }
}

/// Applies [`stack`](super::stack) to planes: from n rows of masks, the first on top, to n + 1 rows of weights.
///
/// # Panics
///
/// If `out` does not hold exactly one more row than `masks`, or the rows differ in length.
pub fn stack_rows(masks: &[&[f32]], out: &mut [&mut [f32]]) {
    assert_eq!(out.len(), masks.len() + 1, "stack: one weight more than masks");
    for (start, count) in blocks(out, masks) {
        let mut rest = [1.0_f64; BLOCK];
        let mut residual = Residual::new();
        for (index, (plane, row)) in out.iter_mut().zip(masks).enumerate() {
            let pixels = plane[start..start + count].iter_mut().zip(&row[start..start + count]);
            for (x, (weight, &t)) in pixels.enumerate() {
                let raw = rest[x] * f64::from(t);
                rest[x] *= 1.0 - f64::from(t);
                let rounded = round_f64(raw);
                residual.take(x, index, raw, rounded);
                *weight = rounded as f32;
            }
        }
        for (x, weight) in out[masks.len()][start..start + count].iter_mut().enumerate() {
            let rounded = round_f64(rest[x]);
            residual.take(x, masks.len(), rest[x], rounded);
            *weight = rounded as f32;
        }
        residual.settle(out, start, count);
    }
}

/// Returns start and length of each block, after a check that all rows have the same length.
fn blocks(planes: &[&mut [f32]], inputs: &[&[f32]]) -> impl Iterator<Item = (usize, usize)> + use<> {
    let width = planes.first().map_or(0, |row| row.len());
    assert!(planes.iter().all(|row| row.len() == width), "rows of equal length");
    assert!(inputs.iter().all(|row| row.len() == width), "rows of equal length");
    (0..width).step_by(BLOCK).map(move |start| (start, BLOCK.min(width - start)))
}
