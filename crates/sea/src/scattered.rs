//! The sum in f32 at single points: sixteen side by side, none of which changes a bit of another.

use crate::direct::add;
use crate::fields::{FieldSet, Fields, Points, SUMS};
use crate::frame::{CUT, SeaFrame};
use crate::kernel::{LANES, exp_neg, sincos_turns};
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};

/// Number of waves that are summed before their sum is added to the total, as in [`SeaFrame::direct`].
const RUN: usize = 64;

/// 1.5·2⁵²: adding and subtracting it rounds |v| < 2⁵¹ to the nearest integer, ties to even, exactly.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Kinds of sums: displacements and derivatives, and these with velocities.
const STILL: u8 = 3;
const WHOLE: u8 = 7;

/// Points side by side; lanes past the last point repeat it.
struct Lanes {
    x: [f64; LANES],
    z: [f64; LANES],
    /// Squared footprints.
    footprint2: [f32; LANES],
    /// Number of leading waves that the least footprint leaves.
    waves: usize,
}

impl SeaFrame {
    /// Computes displacements, derivatives, lost variance and velocities at any rest points, in f32.
    ///
    /// Agrees with [`evaluate`](Self::evaluate) like [`direct`](Self::direct). The result at a point depends only on
    /// that point, since every phase is reduced in f64 at every point. This takes twice as long as `direct`, whose
    /// neighbors share an origin, and half as long if the points lie many wavelengths apart.
    ///
    /// # Panics
    /// The slices of `points` differ in length.
    pub fn scattered(&self, points: Points<'_>, wanted: FieldSet, out: &mut Fields) {
        let len = points.x.len();
        assert!(points.z.len() == len && points.footprint.len() == len, "x, z and footprint are of one length");
        out.reset(wanted, len);
        let level = Level::new();
        for start in (0..len).step_by(LANES) {
            let count = LANES.min(len - start);
            let lane = |values: &[f64]| std::array::from_fn(|lane| values[start + lane.min(count - 1)]);
            // Keep squares finite: no wave remains for footprints above 1e15 m either.
            let footprint2 =
                lane(points.footprint).map(|print: f64| (print as f32).min(1e15) * (print as f32).min(1e15));
            let waves = self.left(footprint2.iter().copied().fold(f32::INFINITY, f32::min));
            let lanes = Lanes { x: lane(points.x), z: lane(points.z), footprint2, waves };
            let mut sums = [[0.0; LANES]; SUMS];
            let mut kept = [0.0; LANES];
            dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                if wanted.velocity {
                    self.sum_lanes::<_, WHOLE>(simd, &lanes, &mut sums, &mut kept);
                } else {
                    self.sum_lanes::<_, STILL>(simd, &lanes, &mut sums, &mut kept);
                }
            }));
            for (values, sums) in out.sums_mut().into_iter().zip(&sums).filter(|(values, _)| !values.is_empty()) {
                values[start..start + count].copy_from_slice(&sums[..count]);
            }
            if wanted.slope_variance {
                let whole = self.variance_from[0] as f32;
                for (lost, kept) in out.slope_variance[start..start + count].iter_mut().zip(kept) {
                    *lost = (whole - kept).max(0.0);
                }
            }
        }
    }

    /// Returns the sums of these kinds, and the slope variance that footprints leave.
    #[inline(always)]
    fn sum_lanes<S: Simd, const KINDS: u8>(
        &self,
        simd: S,
        lanes: &Lanes,
        sums: &mut [[f32; LANES]; SUMS],
        kept: &mut [f32; LANES],
    ) {
        let footprint2 = f32x16::from_slice(simd, &lanes.footprint2);
        let zero = f32x16::splat(simd, 0.0);
        let (mut total, mut total_kept) = ([zero; SUMS], zero);
        for first in (0..lanes.waves).step_by(RUN) {
            let (mut part, mut part_kept) = ([zero; SUMS], zero);
            for wave in first..(first + RUN).min(lanes.waves) {
                let term = &self.terms[wave];
                let (sin, cos) = sincos_turns(self.turns(simd, lanes, wave));
                let exponent = footprint2 * self.filters[wave];
                // A wave that only another point resolves counts for nothing here: adding 0 changes no bit.
                let is_left = exponent.simd_le(f32x16::splat(simd, CUT as f32));
                let share = is_left.select(exp_neg(simd, exponent), zero);
                part_kept += share * share * term.variance;
                add::<S, KINDS>(&mut part, term, sin * share, cos * share);
            }
            for (total, part) in total.iter_mut().zip(part) {
                *total += part;
            }
            total_kept += part_kept;
        }
        for (out, total) in sums.iter_mut().zip(total) {
            total.store_slice(out);
        }
        total_kept.store_slice(kept);
    }

    /// Returns the phases of a wave, reduced in f64 to −½…½ turn.
    #[inline(always)]
    fn turns<S: Simd>(&self, simd: S, lanes: &Lanes, wave: usize) -> f32x16<S> {
        let ([by_x, by_z], origin) = (self.phases.turns(wave), self.phases.origin(wave));
        let mut reduced = [0.0; LANES];
        for ((out, &x), &z) in reduced.iter_mut().zip(&lanes.x).zip(&lanes.z) {
            let turns = x * by_x + z * by_z + origin;
            *out = (turns - ((turns + ROUNDER) - ROUNDER)) as f32;
        }
        f32x16::from_slice(simd, &reduced)
    }
}
