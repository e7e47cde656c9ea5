use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};

use crate::fields::{FieldSet, Fields, Points, SUMS};
use crate::frame::{SeaFrame, Term};
use crate::kernel::{LANES, exp_neg, sincos_turns};

/// Most turns that the f32 offsets of a block may span to each side: phases then stay within 1e-6 rad of their f64
/// values. For waves of which a block spans more turns, offsets are reduced in f64, point by point.
const MAX_TURNS: f64 = 8.0;

/// Number of waves that are summed before their sum is added to the total, so that rounding grows with the root of
/// the longer of two short sums instead of one long one.
const RUN: usize = 64;

/// 1.5·2⁵²: adding and subtracting it rounds |v| < 2⁵¹ to the nearest integer, ties to even, exactly.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Points that share one f64 origin.
struct Block {
    x: [f32; LANES],
    z: [f32; LANES],
    /// Squared footprints: that of the origin, those of all points, and their excess over the origin's.
    base2: f32,
    footprint2: [f32; LANES],
    excess2: [f32; LANES],
    sharing: Sharing,
    origin: [f64; 2],
    /// Number of leading waves that the footprint does not filter out.
    waves: usize,
    /// Number of these whose phases are accurate enough with f32 offsets.
    near: usize,
    /// Offsets in f64, for the remaining waves.
    x_exact: [f64; LANES],
    z_exact: [f64; LANES],
}

/// How the attenuation exp(−f·footprint²) varies over a block, f = k²/8.
#[derive(Clone, Copy, PartialEq)]
enum Sharing {
    /// Constant: one number for each wave.
    Equal,
    /// By exp(−u), u = f·excess, |u| ≤ [`NEAR`]: a cubic in u.
    Near,
    /// By more: one exponential for each point and wave.
    Any,
}

/// Largest |u| for which 1 − u + u²/2 − u³/6 equals exp(−u) to u⁴/24 < 3e-7.
const NEAR: f32 = 0.05;

/// Scratch buffers of one evaluation.
struct Scratch {
    phases: Vec<f32>,
    shares: Vec<f32>,
}

impl Block {
    /// Returns the turns from the origin to each point, reduced in f64 to −½…½.
    #[inline(always)]
    fn exact_turns<S: Simd>(&self, simd: S, [turns_x, turns_z]: [f64; 2]) -> f32x16<S> {
        let mut reduced = [0.0; LANES];
        for ((out, &x), &z) in reduced.iter_mut().zip(&self.x_exact).zip(&self.z_exact) {
            let turns = x * turns_x + z * turns_z;
            *out = (turns - ((turns + ROUNDER) - ROUNDER)) as f32;
        }
        f32x16::from_slice(simd, &reduced)
    }

    /// Returns the share of a wave that the footprints of the block's points leave, given the share at the origin.
    #[inline(always)]
    fn share<S: Simd>(&self, simd: S, filter: f32, at_origin: f32) -> f32x16<S> {
        match self.sharing {
            Sharing::Equal => f32x16::splat(simd, at_origin),
            Sharing::Near => {
                let u = f32x16::from_slice(simd, &self.excess2) * filter;
                let cubic = ((u * (-1.0 / 6.0) + 0.5) * u - 1.0) * u + 1.0;
                cubic * at_origin
            }
            Sharing::Any => exp_neg(simd, f32x16::from_slice(simd, &self.footprint2) * filter),
        }
    }
}

type Sums = [[f32; LANES]; SUMS];

impl SeaFrame {
    /// Computes displacements, derivatives and lost variance at any rest points, in f32.
    ///
    /// Sixteen neighbors in the slices share an origin at which phases are reduced in f64; offsets from it are f32.
    /// Results agree with [`evaluate`](Self::evaluate) to about 2e-6 of each quantity's root mean square, however
    /// distant the points and the time are; beyond 1e9 turns f64 itself loses that accuracy. If sixteen points lie
    /// many wavelengths apart, they are evaluated one by one, which is equally exact but slower.
    ///
    /// # Panics
    /// The slices of `points` differ in length.
    pub fn direct(&self, points: Points<'_>, wanted: FieldSet, out: &mut Fields) {
        let len = points.x.len();
        assert!(points.z.len() == len && points.footprint.len() == len, "x, z and footprint are of one length");
        out.reset(wanted, len);
        if self.terms.is_empty() {
            return;
        }
        let level = Level::new();
        let mut scratch = Scratch { phases: vec![0.0; self.terms.len()], shares: vec![0.0; self.terms.len()] };
        for start in (0..len).step_by(LANES) {
            let end = (start + LANES).min(len);
            let part =
                Points { x: &points.x[start..end], z: &points.z[start..end], footprint: &points.footprint[start..end] };
            let block = self.block(part);
            self.fill(level, &block, start, end - start, wanted, &mut scratch, out);
        }
    }

    fn block(&self, points: Points<'_>) -> Block {
        let len = points.x.len();
        let origin = [points.x[len / 2], points.z[len / 2]];
        // Lanes past the last point repeat the origin; their results are not stored.
        let lane = |index: usize, values: &[f64], otherwise: f64| values.get(index).copied().unwrap_or(otherwise);
        let footprint = points.footprint[len / 2];
        let footprint2: [f32; LANES] = std::array::from_fn(|index| {
            let value = lane(index, points.footprint, footprint) as f32;
            // Keep squares finite: no wave remains for footprints above 1e15 m either.
            value.min(1e15) * value.min(1e15)
        });
        let least = footprint2.iter().copied().fold(f32::INFINITY, f32::min);
        let waves = self.left(least);
        let base2 = footprint2[len / 2];
        let excess2 = footprint2.map(|value| value - base2);
        let widest = excess2.iter().copied().fold(0.0, |widest: f32, value| widest.max(value.abs()));
        let sharing = if widest == 0.0 {
            Sharing::Equal
        } else if waves == 0 || widest * self.filters[waves - 1] <= NEAR {
            Sharing::Near
        } else {
            Sharing::Any
        };
        let offset =
            |index: usize| [lane(index, points.x, origin[0]) - origin[0], lane(index, points.z, origin[1]) - origin[1]];
        let reach = (0..LANES).map(offset).map(|[x, z]| libm::sqrt(x * x + z * z)).fold(0.0, |a: f64, b| a.max(b));
        // Waves are sorted by falling wavelength.
        let near = self.phases.leading(waves, |[x, z]| reach * libm::sqrt(x * x + z * z) <= MAX_TURNS);
        Block {
            x: std::array::from_fn(|index| offset(index)[0] as f32),
            z: std::array::from_fn(|index| offset(index)[1] as f32),
            footprint2,
            base2,
            excess2,
            sharing,
            origin,
            waves,
            near,
            x_exact: std::array::from_fn(|index| offset(index)[0]),
            z_exact: std::array::from_fn(|index| offset(index)[1]),
        }
    }

    #[allow(clippy::too_many_arguments, reason = "one block's inputs, outputs and buffers")]
    fn fill(
        &self,
        level: Level,
        block: &Block,
        start: usize,
        len: usize,
        wanted: FieldSet,
        scratch: &mut Scratch,
        out: &mut Fields,
    ) {
        let mut sums: Sums = [[0.0; LANES]; SUMS];
        let mut variance = [0.0; LANES];
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
            self.prepare(simd, block, scratch);
            match kinds(wanted) {
                0 => {}
                1 => self.sum::<_, 1>(simd, block, scratch, &mut sums),
                2 => self.sum::<_, 2>(simd, block, scratch, &mut sums),
                3 => self.sum::<_, 3>(simd, block, scratch, &mut sums),
                4 => self.sum::<_, 4>(simd, block, scratch, &mut sums),
                5 => self.sum::<_, 5>(simd, block, scratch, &mut sums),
                6 => self.sum::<_, 6>(simd, block, scratch, &mut sums),
                _ => self.sum::<_, 7>(simd, block, scratch, &mut sums),
            }
            if wanted.slope_variance {
                self.lost_variance(simd, block, scratch, &mut variance);
            }
        }));
        for (index, values) in out.sums_mut().into_iter().enumerate() {
            if !values.is_empty() {
                values[start..start + len].copy_from_slice(&sums[index][..len]);
            }
        }
        if wanted.slope_variance {
            out.slope_variance[start..start + len].copy_from_slice(&variance[..len]);
        }
    }

    /// Computes phases and shares at the block's origin.
    #[inline(always)]
    fn prepare<S: Simd>(&self, simd: S, block: &Block, scratch: &mut Scratch) {
        self.phases.at(block.origin[0], block.origin[1], &mut scratch.phases[..block.waves]);
        if block.sharing != Sharing::Any {
            let filters = self.filters[..block.waves].chunks(LANES);
            for (shares, filters) in scratch.shares[..block.waves].chunks_mut(LANES).zip(filters) {
                let mut exponents = [0.0; LANES];
                exponents[..filters.len()].copy_from_slice(filters);
                let share = exp_neg(simd, f32x16::from_slice(simd, &exponents) * block.base2);
                share.store_slice(&mut exponents);
                shares.copy_from_slice(&exponents[..shares.len()]);
            }
        }
    }

    /// Adds all waves of the block to the sums of these kinds.
    #[inline(always)]
    fn sum<S: Simd, const KINDS: u8>(&self, simd: S, block: &Block, scratch: &Scratch, sums: &mut Sums) {
        let x = f32x16::from_slice(simd, &block.x);
        let z = f32x16::from_slice(simd, &block.z);
        let zero = f32x16::splat(simd, 0.0);
        let mut total = [zero; SUMS];
        for first in (0..block.waves).step_by(RUN) {
            let run = first..(first + RUN).min(block.waves);
            let mut part = [zero; SUMS];
            for wave in run {
                let term = &self.terms[wave];
                let offset = if wave < block.near {
                    x * term.turns[0] + z * term.turns[1]
                } else {
                    block.exact_turns(simd, self.phases.turns(wave))
                };
                let (sin, cos) = sincos_turns(offset + scratch.phases[wave]);
                let share = block.share(simd, self.filters[wave], scratch.shares[wave]);
                add::<S, KINDS>(&mut part, term, sin * share, cos * share);
            }
            for (total, part) in total.iter_mut().zip(part) {
                *total += part;
            }
        }
        for (out, total) in sums.iter_mut().zip(total) {
            total.store_slice(out);
        }
    }

    /// Computes ½(a·k)²(1 − share²) over all waves; waves that are cut count as lost completely.
    #[inline(always)]
    fn lost_variance<S: Simd>(&self, simd: S, block: &Block, scratch: &Scratch, out: &mut [f32; LANES]) {
        let cut = self.variance_from[block.waves];
        if block.sharing == Sharing::Equal {
            let lost = self.terms[..block.waves].iter().zip(&scratch.shares).fold(cut, |sum, (term, &share)| {
                let share = f64::from(share);
                sum + f64::from(term.variance) * (1.0 - share * share)
            });
            *out = [lost as f32; LANES];
            return;
        }
        let mut total = f32x16::splat(simd, cut as f32);
        for first in (0..block.waves).step_by(RUN) {
            let run = first..(first + RUN).min(block.waves);
            let mut part = f32x16::splat(simd, 0.0);
            let waves = self.terms[run.clone()].iter().zip(&self.filters[run.clone()]).zip(&scratch.shares[run]);
            for ((term, &filter), &share) in waves {
                let share = block.share(simd, filter, share);
                part += (share * share * -1.0 + 1.0) * term.variance;
            }
            total += part;
        }
        total.store_slice(out);
    }
}

/// Bit for displacements.
const D: u8 = 1;
/// Bit for derivatives.
const J: u8 = 2;
/// Bit for velocities.
const V: u8 = 4;

/// Returns the kinds of sums that are wanted, as bits.
pub(crate) fn kinds(wanted: FieldSet) -> u8 {
    D * u8::from(wanted.displacement) + J * u8::from(wanted.derivatives) + V * u8::from(wanted.velocity)
}

/// Adds one wave to the sums of these kinds, given the sine and cosine of its phase.
#[inline(always)]
pub(crate) fn add<S: Simd, const KINDS: u8>(sums: &mut [f32x16<S>; SUMS], term: &Term, sin: f32x16<S>, cos: f32x16<S>) {
    if KINDS & D != 0 {
        sums[0] += sin * term.sines[0];
        sums[1] += cos * term.cosines[0];
        sums[2] += sin * term.sines[1];
    }
    if KINDS & J != 0 {
        sums[3] += sin * term.sines[2];
        sums[4] += sin * term.sines[3];
        sums[5] += cos * term.cosines[1];
        sums[6] += cos * term.cosines[2];
        sums[7] += cos * term.cosines[3];
    }
    if KINDS & V != 0 {
        sums[8] += cos * term.cosines[4];
        sums[9] += sin * term.sines[4];
        sums[10] += cos * term.cosines[5];
    }
}
