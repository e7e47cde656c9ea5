//! Pictures from stored weights: checks rows of weights, and mixes colors with them.

use fearless_simd::{Level, Simd, dispatch};
use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};
use std::ops::{Add, Mul};

/// Pixels that are mixed at once, so that their sums stay in the cache.
const CHUNK: usize = 512;
/// Colors that are added at once, so that sums are loaded and stored less often.
const GROUP: usize = 4;

/// A sample as a recipe stores it.
pub trait StoredSample: Copy + Sync {
    /// Number in which sums of weights are exact.
    type Sum: Copy + Default + PartialEq + Add<Output = Self::Sum> + Mul<Output = Self::Sum>;

    /// Converts samples, as many as `out` has.
    fn widen(samples: &[Self], out: &mut [f32]);
    /// Returns whether all samples are 0.
    fn are_zero(samples: &[Self]) -> bool;
    /// Converts a number.
    fn sum(value: f64) -> Self::Sum;
    /// Converts a sample.
    fn of(value: f32) -> Self::Sum;
    /// Converts a sum.
    fn narrow(sum: Self::Sum) -> f32;
}

/// A half, by its bits.
impl StoredSample for u16 {
    type Sum = f32;

    #[inline(always)]
    fn widen(samples: &[Self], out: &mut [f32]) {
        samples[..out.len()].reinterpret_cast::<f16>().convert_to_f32_slice(out);
    }

    #[inline(always)]
    fn are_zero(samples: &[Self]) -> bool {
        samples.iter().fold(0, |all, bits| all | bits) == 0
    }

    #[inline(always)]
    fn sum(value: f64) -> f32 {
        value as f32
    }

    #[inline(always)]
    fn of(value: f32) -> f32 {
        value
    }

    #[inline(always)]
    fn narrow(sum: f32) -> f32 {
        sum
    }
}

impl StoredSample for f32 {
    type Sum = f64;

    #[inline(always)]
    fn widen(samples: &[Self], out: &mut [f32]) {
        out.copy_from_slice(&samples[..out.len()]);
    }

    #[inline(always)]
    fn are_zero(samples: &[Self]) -> bool {
        samples.iter().fold(0, |all, sample| all | sample.to_bits()) == 0
    }

    #[inline(always)]
    fn sum(value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn of(value: f32) -> f64 {
        f64::from(value)
    }

    #[inline(always)]
    fn narrow(sum: f64) -> f32 {
        sum as f32
    }
}

/// Mixes colors with rows of weights, one row for each color, and adds what images contribute. Returns the first pixel
/// whose weights are not ≥ 0 with the sum exactly 1; then `out` is of no use.
///
/// Colors are added in their order, so no bit depends on which weights are 0 or on where rows begin.
///
/// ```
/// let weights = [&[0.25_f32, 1.0][..], &[0.75, 0.0]];
/// let (mut r, mut g, mut b) = ([0.0; 2], [0.0; 2], [0.0; 2]);
/// let colors = [[1.0, 0.0, 0.5], [0.0, 1.0, 0.5]];
/// trochoid_weights::paint(&weights, &colors, None, [&mut r, &mut g, &mut b])?;
/// assert_eq!((r, g, b), ([0.25, 1.0], [0.75, 0.0], [0.5, 0.5]));
/// assert_eq!(trochoid_weights::paint(&weights[..1], &colors, None, [&mut r, &mut g, &mut b]), Err(0));
/// # Ok::<(), usize>(())
/// ```
///
/// # Errors
/// The index of that pixel.
///
/// # Panics
/// Rows differ in length, or there are fewer colors than rows.
pub fn paint<S: StoredSample>(
    weights: &[&[S]],
    colors: &[[f64; 3]],
    images: Option<[&[S]; 3]>,
    mut out: [&mut [f32]; 3],
) -> Result<(), usize> {
    let level = Level::new();
    let count = out[0].len();
    for start in (0..count).step_by(CHUNK) {
        let pixels = start..count.min(start + CHUNK);
        let parts = out.each_mut().map(|channel| &mut channel[pixels.clone()]);
        let images = images.map(|rows| rows.map(|row| &row[pixels.clone()]));
        // A weight that is 0 everywhere adds nothing.
        let used = weights.iter().zip(colors).map(|(row, color)| (&row[pixels.clone()], color));
        let used: Vec<(&[S], &[f64; 3])> = used.filter(|(row, _)| !S::are_zero(row)).collect();
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || chunk(&used, images, parts)))
            .map_err(|pixel| start + pixel)?;
    }
    Ok(())
}

#[inline(always)]
fn chunk<S: StoredSample>(
    used: &[(&[S], &[f64; 3])],
    images: Option<[&[S]; 3]>,
    out: [&mut [f32]; 3],
) -> Result<(), usize> {
    let count = out[0].len();
    let mut rows = [[0.0_f32; CHUNK]; GROUP];
    let zero = S::sum(0.0);
    // Red, green, blue, and the sum of the weights.
    let mut sums = [[zero; CHUNK]; 4];
    let mut is_negative = [false; CHUNK];
    if let Some(images) = images {
        for (sums, image) in sums.iter_mut().zip(images) {
            S::widen(image, &mut rows[0][..count]);
            sums.iter_mut().zip(&rows[0]).for_each(|(sum, value)| *sum = S::of(*value));
        }
    }
    for group in used.chunks(GROUP) {
        let mut factors = [[zero; GROUP]; 4];
        for (index, row) in rows.iter_mut().enumerate() {
            match group.get(index) {
                Some((weights, color)) => {
                    S::widen(weights, &mut row[..count]);
                    (0..3).for_each(|channel| factors[channel][index] = S::sum(color[channel]));
                    factors[3][index] = S::sum(1.0);
                }
                None => row.fill(0.0),
            }
        }
        let [a, b, c, d] = &rows;
        for x in 0..CHUNK {
            is_negative[x] |= (a[x] < 0.0) | (b[x] < 0.0) | (c[x] < 0.0) | (d[x] < 0.0);
        }
        for (sums, by) in sums.iter_mut().zip(factors) {
            for x in 0..CHUNK {
                let sum = sums[x] + S::of(a[x]) * by[0];
                sums[x] = sum + S::of(b[x]) * by[1] + S::of(c[x]) * by[2] + S::of(d[x]) * by[3];
            }
        }
    }
    let [r, g, b, all] = &sums;
    let one = S::sum(1.0);
    if let Some(pixel) = (0..count).find(|x| all[*x] != one || is_negative[*x]) {
        return Err(pixel);
    }
    for (out, sums) in out.into_iter().zip([r, g, b]) {
        out.iter_mut().zip(sums).for_each(|(out, sum)| *out = S::narrow(*sum));
    }
    Ok(())
}
