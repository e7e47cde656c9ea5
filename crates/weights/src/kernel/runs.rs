//! Values along several rows or columns at once, as sums read them: in f64, lane by lane.

use fearless_simd::{Simd, f32x8, prelude::*};
use std::ops::Range;
use trochoid_memory::Scratch;

/// Number of rows or columns side by side.
pub(super) const LANES: usize = 8;

/// The values of all lanes at one place.
#[derive(Clone, Copy, Default)]
#[repr(align(64))]
pub(super) struct Values(pub(super) [f64; LANES]);

impl Values {
    #[inline(always)]
    fn of(values: &[f32; LANES]) -> Self {
        let mut wide = Self::default();
        for (wide, value) in wide.0.iter_mut().zip(values) {
            *wide = f64::from(*value);
        }
        wide
    }
}

/// What is known of the values of a run.
#[derive(Clone)]
pub(super) struct Known {
    /// The places outside of which all values are 0.
    pub(super) used: Range<usize>,
    /// By lane, the bits of the largest magnitude. That of NaN is above all others.
    magnitudes: [u32; LANES],
    /// By lane, the bits of all values together.
    bits: [u32; LANES],
}

/// All bits of an f32 but its sign.
const MAGNITUDE: u32 = u32::MAX >> 1;

impl Known {
    const NOTHING: Self = Self { used: Range { start: usize::MAX, end: 0 }, magnitudes: [0; LANES], bits: [0; LANES] };

    /// Adds the values at a place after those added before.
    // Plain loops of one operation: others would not be compiled for the vectors of the caller.
    #[inline(always)]
    fn add(&mut self, place: usize, values: &[f32; LANES]) {
        let mut magnitudes = [0; LANES];
        for (magnitude, value) in magnitudes.iter_mut().zip(values) {
            *magnitude = value.to_bits() & MAGNITUDE;
        }
        if is_any(&magnitudes) {
            self.used = self.used.start.min(place)..place + 1;
        }
        for (most, magnitude) in self.magnitudes.iter_mut().zip(&magnitudes) {
            *most = (*most).max(*magnitude);
        }
        for (bits, value) in self.bits.iter_mut().zip(values) {
            *bits |= value.to_bits();
        }
    }

    /// Returns the largest magnitude.
    #[inline(always)]
    pub(super) fn most(&self) -> f32 {
        f32::from_bits(self.magnitudes.iter().fold(0, |most, own| most.max(*own)))
    }

    /// Returns whether any value may be negative.
    #[inline(always)]
    pub(super) fn has_signs(&self) -> bool {
        self.bits.iter().fold(0, |all, own| all | own) > MAGNITUDE
    }
}

/// Returns whether any bit is set.
// A comparison with zeros would call a function.
#[inline(always)]
pub(super) fn is_any(lanes: &[u32; LANES]) -> bool {
    let mut all = 0;
    for lane in lanes {
        all |= lane;
    }
    all != 0
}

/// Returns the transpose of a block.
#[inline(always)]
pub(super) fn transposed<S: Simd>(simd: S, block: &[[f32; LANES]; LANES]) -> [[f32; LANES]; LANES] {
    let mut rows = block.map(|row| f32x8::from_slice(simd, &row));
    // Each step moves one bit of the index of a row into that of a column.
    for _ in 0..LANES.ilog2() {
        let mut next = rows;
        for index in 0..LANES / 2 {
            next[2 * index] = rows[index].zip_low(rows[index + LANES / 2]);
            next[2 * index + 1] = rows[index].zip_high(rows[index + LANES / 2]);
        }
        rows = next;
    }
    let mut all = [[0.0; LANES]; LANES];
    for (all, row) in all.iter_mut().zip(&rows) {
        row.store_slice(all);
    }
    all
}

/// Rows side by side, with a lane for each.
#[derive(Default)]
pub(super) struct Across {
    pub(super) run: Scratch<Values>,
}

impl Across {
    /// Takes `length` values of at most [`LANES`] rows, which are `width` long, from the one at `first` on. Beyond a row, its
    /// first and last values repeat. Lanes without a row repeat the last row.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(&mut self, simd: S, image: &[f32], width: usize, first: i64, length: usize) -> Known {
        let rows: [&[f32]; LANES] =
            std::array::from_fn(|lane| &image[(lane * width).min(image.len() - width)..][..width]);
        let [left, right] = [-first, width as i64 - first].map(|end| end.clamp(0, length as i64) as usize);
        self.run.resize(length, Values::default());
        let mut known = Known::NOTHING;
        self.repeat(0..left, rows.map(|row| row[0]), &mut known);
        for place in (left..right).step_by(LANES) {
            let (x, count) = ((place as i64 + first) as usize, LANES.min(right - place));
            let mut block = [[0.0; LANES]; LANES];
            for (block, row) in block.iter_mut().zip(&rows) {
                *block = if let Some(values) = row[x..].first_chunk() { *values } else { filled(&row[x..]) };
            }
            let block = transposed(simd, &block);
            for (index, values) in block[..count].iter().enumerate() {
                known.add(place + index, values);
                self.run[place + index] = Values::of(values);
            }
        }
        self.repeat(right..length, rows.map(|row| row[width - 1]), &mut known);
        known
    }

    #[inline(always)]
    fn repeat(&mut self, places: Range<usize>, values: [f32; LANES], known: &mut Known) {
        if let Some(last) = places.clone().last() {
            known.add(places.start, &values);
            known.add(last, &values);
            self.run[places].fill(Values::of(&values));
        }
    }
}

/// Bytes of a strip, and most blocks of columns in it.
const CACHE: usize = 192 << 10;
const MOST: usize = 32;

/// Columns side by side, in blocks with a lane for each.
#[derive(Default)]
pub(super) struct Down {
    rows: Scratch<Values>,
    /// Number of rows.
    height: usize,
    blocks: Scratch<Known>,
}

impl Down {
    /// Returns a number of columns that lie side by side in memory, as far as some rows of them stay in the cache.
    pub(super) fn width(rows: &Range<i64>) -> usize {
        let bytes = (rows.end - rows.start) as usize * size_of::<Values>();
        (CACHE / bytes.max(1)).clamp(1, MOST) * LANES
    }

    /// Takes columns of rows of an image that is `width` wide. Above and below it, its first and last rows repeat.
    #[inline(always)]
    pub(super) fn gather(&mut self, image: &[f32], width: usize, columns: Range<usize>, rows: Range<i64>) {
        let last = (image.len() / width) as i64 - 1;
        let count = columns.len().div_ceil(LANES);
        self.height = (rows.end - rows.start) as usize;
        self.rows.resize(count * self.height, Values::default());
        self.blocks.clear();
        self.blocks.resize(count, Known::NOTHING);
        // Plain loops: closures would not be compiled for the vectors of the caller.
        for (index, y) in rows.enumerate() {
            let row = &image[y.clamp(0, last) as usize * width..][columns.clone()];
            for (block, known) in self.blocks.iter_mut().enumerate() {
                let row = &row[block * LANES..];
                let values = if let Some(values) = row.first_chunk() { *values } else { filled(row) };
                known.add(index, &values);
                self.rows[block * self.height + index] = Values::of(&values);
            }
        }
    }

    /// Returns the values of each block.
    pub(super) fn blocks(&self) -> impl Iterator<Item = (&[Values], &Known)> {
        self.rows.chunks(self.height).zip(self.blocks.iter())
    }
}

/// Returns values followed by zeros.
// Not inlined, since all copies would then be of any length.
#[cold]
#[inline(never)]
fn filled(values: &[f32]) -> [f32; LANES] {
    let mut all = [0.0; LANES];
    all[..values.len()].copy_from_slice(values);
    all
}
