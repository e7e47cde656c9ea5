//! The same sums on a grid, from factors of its columns and rows.

use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use rayon::prelude::*;

use crate::direct::{add, kinds};
use crate::fields::{FieldSet, Fields, SUMS};
use crate::frame::SeaFrame;
use crate::grid::Grid;
use crate::kernel::{LANES, sincos_turns};

impl SeaFrame {
    /// Adds the first waves, each attenuated by its share, to the sums that have room in `out`.
    ///
    /// exp(iθ) is a factor per column times a factor per row, so that a sine and cosine for each column and wave, and
    /// for each row and wave, replace those of every point: each point and wave costs one complex product. The column
    /// factors take 128 bytes per sixteen columns and wave.
    pub(crate) fn separable(
        &self,
        grid: Grid,
        shares: &[f32],
        wanted: FieldSet,
        out: &mut Fields,
        stop: &(dyn Fn() -> bool + Sync),
    ) {
        let level = Level::new();
        let factors = self.factors(level, grid, shares.len());
        let mut rows: Vec<[&mut [f32]; SUMS]> = (0..grid.rows).map(|_| std::array::from_fn(|_| &mut [][..])).collect();
        for (sum, values) in out.sums_mut().into_iter().enumerate() {
            for (row, values) in rows.iter_mut().zip(values.chunks_exact_mut(grid.columns)) {
                row[sum] = values;
            }
        }
        let kinds = kinds(wanted);
        rows.into_par_iter().enumerate().for_each(|(row, mut out)| {
            if stop() {
                return;
            }
            let z = grid.origin[1] + row as f64 * grid.step[1];
            let mut origins = vec![0.0; shares.len()];
            self.phases.at(grid.origin[0], z, &mut origins);
            for (chunk, factors) in factors.chunks_exact(shares.len()).enumerate() {
                let mut sums = [[0.0; LANES]; SUMS];
                let origins = &origins[..];
                dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                    match kinds {
                        0 => {}
                        1 => self.row::<_, 1>(simd, origins, shares, factors, &mut sums),
                        2 => self.row::<_, 2>(simd, origins, shares, factors, &mut sums),
                        3 => self.row::<_, 3>(simd, origins, shares, factors, &mut sums),
                        4 => self.row::<_, 4>(simd, origins, shares, factors, &mut sums),
                        5 => self.row::<_, 5>(simd, origins, shares, factors, &mut sums),
                        6 => self.row::<_, 6>(simd, origins, shares, factors, &mut sums),
                        _ => self.row::<_, 7>(simd, origins, shares, factors, &mut sums),
                    }
                }));
                let start = chunk * LANES;
                let len = LANES.min(grid.columns - start);
                for (values, sums) in out.iter_mut().zip(&sums) {
                    if !values.is_empty() {
                        values[start..start + len].copy_from_slice(&sums[..len]);
                    }
                }
            }
        });
    }

    fn factors(&self, level: Level, grid: Grid, waves: usize) -> Vec<Factor> {
        let chunks = grid.columns.div_ceil(LANES);
        let factor = |index: usize| {
            let (chunk, wave) = (index / waves, index % waves);
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
            factor
        };
        (0..chunks * waves).into_par_iter().map(factor).collect()
    }

    /// Computes sixteen columns of one row: (cos + i sin)(column) × (cos + i sin)(row), times the share.
    #[inline(always)]
    fn row<S: Simd, const KINDS: u8>(
        &self,
        simd: S,
        origins: &[f32],
        shares: &[f32],
        factors: &[Factor],
        out: &mut [[f32; LANES]; SUMS],
    ) {
        let zero = f32x16::splat(simd, 0.0);
        let mut total = [zero; SUMS];
        // Sixteen waves at once for the row's own factors, which are scalars for the points.
        for (run, origins) in origins.chunks(LANES).enumerate() {
            let first = run * LANES;
            let mut lanes = [0.0; LANES];
            lanes[..origins.len()].copy_from_slice(origins);
            let (row_sin, row_cos) = sincos_turns(f32x16::from_slice(simd, &lanes));
            let mut part = [zero; SUMS];
            for wave in 0..origins.len() {
                let index = first + wave;
                let (rs, rc) = (row_sin[wave] * shares[index], row_cos[wave] * shares[index]);
                let cs = f32x16::from_slice(simd, &factors[index].sin);
                let cc = f32x16::from_slice(simd, &factors[index].cos);
                let (sin, cos) = (cs * rc + cc * rs, cc * rc - cs * rs);
                add::<S, KINDS>(&mut part, &self.terms[index], sin, cos);
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
