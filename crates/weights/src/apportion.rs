//! Weights of many pixels, apportioned as [`Storing::apportion`] does those of one, in vectors.

use crate::Storing;
use crate::stored::{key, whole};
use fearless_simd::{Level, Simd, dispatch};
use trochoid_memory::Scratch;

/// Pixels that are apportioned together.
pub const BLOCK: usize = 64;

/// What is known of the weights of one color.
#[derive(Clone, Copy, Debug)]
struct Column {
    /// Whole units.
    wholes: [f64; BLOCK],
    remainders: [f64; BLOCK],
    /// Orders remainders; 0 where the weight is 0.
    keys: [u32; BLOCK],
    /// Number of remainders that go before this color's.
    before: [i32; BLOCK],
}

const COLUMN: Column = Column { wholes: [0.0; BLOCK], remainders: [0.0; BLOCK], keys: [0; BLOCK], before: [0; BLOCK] };

/// Stores the weights of pixels, block by block; its memory is used again.
///
/// ```
/// use trochoid_weights::{Apportioner, Storing};
/// let mut stored = [vec![0.0; 2], vec![0.0; 2]];
/// let moved = Apportioner::new(Storing::Half).rows(&[&[0.25, 1.0], &[0.75, 0.0]], &mut stored);
/// assert_eq!((stored, moved), ([vec![0.25, 1.0], vec![0.75, 0.0]], 0.0));
/// ```
#[derive(Debug)]
pub struct Apportioner {
    storing: Storing,
    level: Level,
    columns: Scratch<Column>,
}

impl Apportioner {
    /// Creates one that stores weights this way.
    #[must_use]
    pub fn new(storing: Storing) -> Self {
        Self { storing, level: Level::new(), columns: Scratch::new() }
    }

    /// Apportions the weights of a block of pixels, one array for each color, and returns the largest weight that moved at
    /// a pixel. Pixels without any weight stay so.
    pub fn block(&mut self, weights: &mut [[f64; BLOCK]]) -> f64 {
        let room = weights.len().max(self.columns.len());
        self.columns.resize(room, COLUMN);
        let columns = &mut self.columns[..weights.len()];
        let units = f64::from(self.storing.units());
        dispatch!(self.level, simd => simd.vectorize(#[inline(always)] || apportion(weights, columns, units)))
    }

    /// Apportions the weights of pixels, one row for each color, into `stored`, and returns the largest weight that moved
    /// at a pixel. Weights that are not above 0 are stored as 0.
    ///
    /// # Panics
    /// Rows differ in number or length.
    pub fn rows(&mut self, rows: &[&[f32]], stored: &mut [Vec<f32>]) -> f64 {
        assert_eq!(rows.len(), stored.len(), "a row for each color");
        let count = rows.first().map_or(0, |row| row.len());
        let (mut weights, mut used) = (Scratch::new(), Scratch::new());
        let mut most = 0.0_f64;
        for start in (0..count).step_by(BLOCK) {
            let pixels = start..count.min(start + BLOCK);
            weights.clear();
            used.clear();
            for (color, (row, stored)) in rows.iter().zip(&mut *stored).enumerate() {
                let row = &row[pixels.clone()];
                // Most colors are in few pixels. Without leaving early, weights are compared as vectors.
                if row.iter().fold(false, |is_used, weight| is_used | (*weight > 0.0)) {
                    let mut column = [0.0; BLOCK];
                    column.iter_mut().zip(row).for_each(|(own, weight)| *own = f64::from(weight.max(0.0)));
                    weights.push(column);
                    used.push(color);
                } else {
                    stored[pixels.clone()].fill(0.0);
                }
            }
            most = most.max(self.block(&mut weights));
            for (color, column) in used.iter().zip(&weights) {
                let own = stored[*color][pixels.clone()].iter_mut().zip(column);
                own.for_each(|(stored, weight)| *stored = *weight as f32);
            }
        }
        most
    }
}

/// Each color counts, pixel by pixel, the remainders that go before its own: all pairs are compared, without a branch,
/// which is several times as fast as sorting so few.
#[inline(always)]
fn apportion(weights: &mut [[f64; BLOCK]], columns: &mut [Column], units: f64) -> f64 {
    let mut scale = [0.0; BLOCK];
    for column in &*weights {
        scale.iter_mut().zip(column).for_each(|(sum, weight)| *sum += weight);
    }
    scale.iter_mut().for_each(|sum| *sum = units / *sum);
    let mut rest = [units; BLOCK];
    for (weights, column) in weights.iter().zip(&mut *columns) {
        let (mut wholes, mut remainders, mut keys) = ([0.0; BLOCK], [0.0; BLOCK], [0; BLOCK]);
        for x in 0..BLOCK {
            let scaled = weights[x] * scale[x];
            wholes[x] = whole(scaled);
            remainders[x] = scaled - wholes[x];
            keys[x] = if weights[x] > 0.0 { 1 + key(remainders[x]) } else { 0 };
            rest[x] -= wholes[x];
        }
        *column = Column { wholes, remainders, keys, before: [0; BLOCK] };
    }
    for own in 0..columns.len() {
        let (others, rest) = columns.split_at_mut(own);
        let own = &mut rest[0];
        let (keys, mut before) = (own.keys, [0; BLOCK]);
        for other in others {
            let (theirs, counts) = (&other.keys, &mut other.before);
            for x in 0..BLOCK {
                let is_first = i32::from(theirs[x] >= keys[x]);
                before[x] += is_first;
                counts[x] += 1 - is_first;
            }
        }
        own.before = before;
    }
    // A pixel without any weight has no rest either.
    let rest = rest.map(|rest| rest as i32);
    let mut moved = [0.0_f64; BLOCK];
    for (weights, column) in weights.iter_mut().zip(columns) {
        for x in 0..BLOCK {
            let is_used = column.keys[x] > 0;
            let gets_one = is_used & (column.before[x] < rest[x]);
            let stored = (column.wholes[x] + if gets_one { 1.0 } else { 0.0 }) * (1.0 / units);
            weights[x] = if is_used { stored } else { 0.0 };
            moved[x] += if gets_one { 1.0 - column.remainders[x] } else { 0.0 };
        }
    }
    moved.into_iter().fold(0.0, f64::max) / units
}
