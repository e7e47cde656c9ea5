use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};

use crate::direct::add;
use crate::fields::{Fields, Points, Wanted};
use crate::frame::SeaFrame;
use crate::kernel::{LANES, sincos_turns};

/// A regular grid of rest points along the world's axes, row by row: x grows fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// First rest point, x and z in meters.
    pub origin: [f64; 2],
    /// Distance of neighbors along x and z in meters.
    pub step: [f64; 2],
    /// Number of points along x.
    pub columns: usize,
    /// Number of points along z.
    pub rows: usize,
    /// Footprint of all points in meters.
    pub footprint: f64,
}

impl SeaFrame {
    /// The same as [`direct`](Self::direct) on a regular grid, about four times as fast.
    ///
    /// exp(iθ) is a factor of the column times one of the row, so that a sine and cosine for each column and wave,
    /// and one for each row and wave, replace those of every point: a point and wave costs one complex product. The
    /// column factors take 8 bytes for each column and wave.
    pub fn grid(&self, grid: Grid, wanted: Wanted, out: &mut Fields) {
        out.reset(wanted, grid.columns * grid.rows);
        if self.terms.is_empty() || grid.columns * grid.rows == 0 {
            return;
        }
        let level = Level::new();
        let footprint = [grid.footprint];
        let mut lost = Fields::default();
        if wanted.slope_variance {
            let point = Points { x: &[0.0], z: &[0.0], footprint: &footprint };
            self.direct(point, Wanted { slope_variance: true, ..Wanted::default() }, &mut lost);
            out.slope_variance.fill(lost.slope_variance[0]);
        }
        let table = self.table(level, grid);
        if !(wanted.displacement || wanted.derivatives) {
            return;
        }
        let mut origins = vec![0.0; table.shares.len()];
        for row in 0..grid.rows {
            let z = grid.origin[1] + row as f64 * grid.step[1];
            self.phases.at(grid.origin[0], z, &mut origins);
            for (chunk, factors) in table.factors.chunks_exact(table.shares.len().max(1)).enumerate() {
                let mut sums = [[0.0; LANES]; 8];
                let (origins, shares) = (&origins[..], &table.shares[..]);
                dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                    match (wanted.displacement, wanted.derivatives) {
                        (true, true) => self.row::<_, true, true>(simd, origins, shares, factors, &mut sums),
                        (true, false) => self.row::<_, true, false>(simd, origins, shares, factors, &mut sums),
                        _ => self.row::<_, false, true>(simd, origins, shares, factors, &mut sums),
                    }
                }));
                let start = chunk * LANES;
                let len = LANES.min(grid.columns - start);
                let at = row * grid.columns + start;
                for (values, sums) in out.sums_mut().into_iter().zip(&sums) {
                    if !values.is_empty() {
                        values[at..at + len].copy_from_slice(&sums[..len]);
                    }
                }
            }
        }
    }

    fn table(&self, level: Level, grid: Grid) -> Table {
        let footprint2 = grid.footprint * grid.footprint;
        // As in `direct`: what keeps less than 1e-6 is not added.
        let shares: Vec<f32> = self
            .filters
            .iter()
            .map(|&filter| f64::from(filter) * footprint2)
            .take_while(|&exponent| exponent <= 13.8)
            .map(|exponent| libm::exp(-exponent) as f32)
            .collect();
        let chunks = grid.columns.div_ceil(LANES);
        let mut factors = Vec::with_capacity(chunks * shares.len());
        for chunk in 0..chunks {
            for wave in 0..shares.len() {
                let step = self.phases.turns(wave)[0] * grid.step[0];
                let turns: [f32; LANES] = std::array::from_fn(|lane| {
                    let turns = step * (chunk * LANES + lane) as f64;
                    (turns - turns.round_ties_even()) as f32
                });
                let mut factor = Factor { sin: [0.0; LANES], cos: [0.0; LANES] };
                dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                    let (sin, cos) = sincos_turns(f32x16::from_slice(simd, &turns));
                    sin.store_slice(&mut factor.sin);
                    cos.store_slice(&mut factor.cos);
                }));
                factors.push(factor);
            }
        }
        Table { shares, factors }
    }

    /// Sixteen columns of one row: (cos + i sin)(column) × (cos + i sin)(row), times the share.
    #[inline(always)]
    fn row<S: Simd, const D: bool, const J: bool>(
        &self,
        simd: S,
        origins: &[f32],
        shares: &[f32],
        factors: &[Factor],
        out: &mut [[f32; LANES]; 8],
    ) {
        let zero = f32x16::splat(simd, 0.0);
        let mut total = [zero; 8];
        // Sixteen waves at once for the row's own factors, which are scalars to the points.
        for (run, origins) in origins.chunks(LANES).enumerate() {
            let first = run * LANES;
            let mut lanes = [0.0; LANES];
            lanes[..origins.len()].copy_from_slice(origins);
            let (row_sin, row_cos) = sincos_turns(f32x16::from_slice(simd, &lanes));
            let mut part = [zero; 8];
            for wave in 0..origins.len() {
                let index = first + wave;
                let (rs, rc) = (row_sin[wave] * shares[index], row_cos[wave] * shares[index]);
                let cs = f32x16::from_slice(simd, &factors[index].sin);
                let cc = f32x16::from_slice(simd, &factors[index].cos);
                let (sin, cos) = (cs * rc + cc * rs, cc * rc - cs * rs);
                add::<S, D, J>(&mut part, &self.terms[index], sin, cos);
            }
            for (total, part) in total.iter_mut().zip(part) {
                *total += part;
            }
        }
        for (out, total) in out.iter_mut().zip(total) {
            total.store_slice(out);
        }
    }
}

/// exp(i·kx·x) for sixteen columns and one wave.
struct Factor {
    sin: [f32; LANES],
    cos: [f32; LANES],
}

/// Column factors, sixteen columns at a time and within them wave by wave, and what the footprint leaves of each
/// wave.
struct Table {
    shares: Vec<f32>,
    factors: Vec<Factor>,
}
