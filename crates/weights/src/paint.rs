//! Pictures from stored weights: checks rows of weights, and mixes colors with them.

use fearless_simd::{Level, Simd, dispatch};
use half::f16;
use std::ops::{Add, Mul};

/// Pixels that are mixed at once, so that their sums stay in the cache.
const CHUNK: usize = 512;
/// Colors that are added at once, so that sums are loaded and stored less often.
const GROUP: usize = 8;

/// A sample as a recipe stores it.
pub trait StoredSample: Copy + Sync {
    /// Number in which sums of weights are exact.
    type Sum: Copy + PartialEq + Add<Output = Self::Sum> + Mul<Output = Self::Sum>;
    /// Bits of a sample.
    type Bits: Copy + Default + PartialEq;

    /// Converts samples, as many as `out` has.
    fn widen(samples: &[Self], out: &mut [f32]);
    /// Returns the sample nearest to a number.
    fn store(value: f32) -> Self;
    /// Returns all bits that are set in any sample.
    fn bits(samples: &[Self]) -> Self::Bits;
    /// Returns whether the bit of the sign is set.
    fn is_signed(bits: Self::Bits) -> bool;
    /// Returns whether the sample is below 0.
    fn is_negative(self) -> bool;
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
    type Bits = Self;

    #[inline(always)]
    fn widen(samples: &[Self], out: &mut [f32]) {
        out.iter_mut().zip(samples).for_each(|(out, bits)| *out = from_half(*bits));
    }

    #[inline(always)]
    fn store(value: f32) -> Self {
        f16::from_f32(value).to_bits()
    }

    #[inline(always)]
    fn bits(samples: &[Self]) -> Self {
        samples.iter().fold(0, |all, bits| all | bits)
    }

    #[inline(always)]
    fn is_signed(bits: Self) -> bool {
        bits & 0x8000 != 0
    }

    #[inline(always)]
    fn is_negative(self) -> bool {
        f16::from_bits(self) < f16::ZERO
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

/// Converts a half by shifts, which compilers turn into vectors; crate `half` calls a function for eight numbers.
///
/// Source: F. Giesen, "Half to float done quick" (2012): exponents are moved from one bias to the other, and what has the
/// smallest exponent has no leading 1.
#[inline(always)]
fn from_half(bits: u16) -> f32 {
    /// Biases of the exponents are 15 and 127.
    const BIAS: u32 = 112 << 23;
    const LEAST: u32 = 1 << 23;
    let moved = (u32::from(bits & 0x7fff) << 13) + BIAS;
    let subnormal = f32::from_bits(moved + LEAST) - f32::from_bits(BIAS + LEAST);
    // Infinity and what is no number have the largest exponent of both.
    let normal = if bits & 0x7c00 == 0x7c00 { moved + BIAS } else { moved };
    let size = if bits & 0x7c00 == 0 { subnormal.to_bits() } else { normal };
    f32::from_bits(size | (u32::from(bits & 0x8000) << 16))
}

impl StoredSample for f32 {
    type Sum = f64;
    type Bits = u32;

    #[inline(always)]
    fn widen(samples: &[Self], out: &mut [f32]) {
        out.copy_from_slice(&samples[..out.len()]);
    }

    #[inline(always)]
    fn store(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn bits(samples: &[Self]) -> u32 {
        samples.iter().fold(0, |all, sample| all | sample.to_bits())
    }

    #[inline(always)]
    fn is_signed(bits: u32) -> bool {
        bits & 0x8000_0000 != 0
    }

    #[inline(always)]
    fn is_negative(self) -> bool {
        self < 0.0
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
    let mut wide = [[0.0; CHUNK]; GROUP];
    for start in (0..count).step_by(CHUNK) {
        let pixels = start..count.min(start + CHUNK);
        let parts = out.each_mut().map(|channel| &mut channel[pixels.clone()]);
        let images = images.map(|rows| rows.map(|row| &row[pixels.clone()]));
        let rows = weights.iter().map(|row| &row[pixels.clone()]);
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || chunk(rows, colors, images, parts, &mut wide)))
            .map_err(|pixel| start + pixel)?;
    }
    Ok(())
}

#[inline(always)]
fn chunk<'a, S: StoredSample + 'a>(
    rows: impl Iterator<Item = &'a [S]> + Clone,
    colors: &[[f64; 3]],
    images: Option<[&[S]; 3]>,
    out: [&mut [f32]; 3],
    wide: &mut [[f32; CHUNK]; GROUP],
) -> Result<(), usize> {
    let count = out[0].len();
    // Red, green, blue, and the sum of the weights.
    let mut sums = [[S::sum(0.0); CHUNK]; 4];
    if let Some(images) = images {
        for (sums, image) in sums.iter_mut().zip(images) {
            S::widen(image, &mut wide[0][..count]);
            sums.iter_mut().zip(&wide[0]).for_each(|(sum, value)| *sum = S::of(*value));
        }
    }
    let mut factors = [[S::sum(0.0); GROUP]; 3];
    let mut used = 0;
    let mut are_signed = false;
    for (row, color) in rows.clone().zip(colors) {
        let bits = S::bits(row);
        // A weight that is 0 everywhere adds nothing.
        if bits == S::Bits::default() {
            continue;
        }
        are_signed |= S::is_signed(bits);
        S::widen(row, &mut wide[used][..count]);
        factors.iter_mut().zip(color).for_each(|(factors, value)| factors[used] = S::sum(*value));
        used += 1;
        if used == GROUP {
            add::<S>(wide, &factors, &mut sums);
            used = 0;
        }
    }
    if used > 0 {
        wide[used..].iter_mut().for_each(|row| row.fill(0.0));
        add::<S>(wide, &factors, &mut sums);
    }
    let [r, g, b, all] = &sums;
    let one = S::sum(1.0);
    // −0 has a sign too, and is a weight.
    let is_negative = |pixel: usize| rows.clone().any(|row| S::is_negative(row[pixel]));
    if are_signed || !all[..count].iter().fold(true, |are_one, sum| are_one & (*sum == one)) {
        let wrong = (0..count).find(|pixel| all[*pixel] != one || is_negative(*pixel));
        wrong.map_or(Ok(()), Err)?;
    }
    for (out, sums) in out.into_iter().zip([r, g, b]) {
        out.iter_mut().zip(sums).for_each(|(out, sum)| *out = S::narrow(*sum));
    }
    Ok(())
}

/// Adds the colors of a group of rows in their order.
#[inline(always)]
fn add<S: StoredSample>(rows: &[[f32; CHUNK]; GROUP], factors: &[[S::Sum; GROUP]; 3], sums: &mut [[S::Sum; CHUNK]; 4]) {
    let [r, g, b, all] = sums;
    for x in 0..CHUNK {
        let mut sum = [r[x], g[x], b[x], all[x]];
        for (index, row) in rows.iter().enumerate() {
            let weight = S::of(row[x]);
            (0..3).for_each(|channel| sum[channel] = sum[channel] + weight * factors[channel][index]);
            sum[3] = sum[3] + weight;
        }
        [r[x], g[x], b[x], all[x]] = sum;
    }
}
