//! How far rounding may have carried a run in f64 from its definition.
//!
//! A run obeys x' = M·x + δ exactly, where δ is what rounding did to that step, bounded by the largest values so far.
//! After n steps it is off by Σ Mʲδ, which the modes of the grid bound: for kicks of at most 1 in every cell, step j
//! back contributes at most the sum of the absolute response of all cells, Σ|r|. The level mode alone contributes its
//! own response, |g|. By the inequality of Cauchy and Schwarz, and because no function of the basis exceeds 2/√N, the
//! other modes contribute at most 2·√(Σ g²). Over the steps j from k to 2k, the sum is at most the root of k times the
//! sum of squares, which follows from powers of M by doubling.

use rayon::prelude::*;

use super::advance::{Modes, recurrence};
use super::trails::Trails;
use super::{ROUNDING, Run};
use crate::toon::propagator::{Scales, scales};
use crate::toon::trail::decayed;
use crate::toon::{Boundary, LITERAL_HZ, ToonSea};

/// Largest distances of fields from those of the definition, wherever on the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Doubt {
    /// Of heights, in meters.
    pub height: f64,
    /// Of the rift.
    pub rift: f64,
    /// Of weights and phases of drift lines.
    pub drift: f64,
}

/// Factor that covers the rounding of these bounds themselves.
const SLACK: f64 = 1.01;

/// Returns the root of the sum of squares.
pub(super) fn norm(values: &[f64]) -> f64 {
    libm::sqrt(values.iter().map(|value| value * value).sum())
}

pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}

/// Largest absolute values in the cells so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CellPeaks {
    pub(super) height: f64,
    pub(super) velocity: f64,
    pub(super) force: f64,
    /// How far rounding may have carried the force.
    pub(super) force_off: f64,
    /// Difference between neighbors.
    pub(super) steepest: f64,
}

impl CellPeaks {
    /// Returns the larger of each.
    pub(super) fn joined(self, other: Self) -> Self {
        Self {
            height: self.height.max(other.height),
            velocity: self.velocity.max(other.velocity),
            force: self.force.max(other.force),
            force_off: self.force_off.max(other.force_off),
            steepest: self.steepest.max(other.steepest),
        }
    }

    /// Returns the bound on heights after a number of steps, and after the part of a step that follows.
    pub(super) fn doubt(&self, sea: &ToonSea, steps: u64, rest: Option<&Modes>) -> f64 {
        let Some(mixing) = recurrence(&sea.motion, 1.0 / sea.motion.rate()) else { return f64::INFINITY };
        let Self { height, velocity, force, force_off, steepest } = *self;
        // ½Σ(neighbor − h) is off by 6 roundings of the largest difference; the rest is off by one rounding or two of
        // each of its terms.
        let lost = mixing.loss().abs() * height;
        let moved = ROUNDING * (12.0 * steepest + 4.0 * velocity + 6.0 * lost + 2.0 * force) + force_off;
        let raised = ROUNDING * height;
        let gap = gaps(sea);
        let energies = |mode: usize, blocks: &mut Blocks| {
            let d = mixing.loss() + 2.0 * mixing.c1 * gap(mode);
            let row = rest.map_or([1.0, 0.0], |rest| [rest.transfers[mode][0], rest.transfers[mode][1]]);
            energies([1.0 - d, mixing.c1, -d, mixing.c1], row, [[1.0, 0.0], [1.0, 1.0], [0.0; 2]], steps, blocks);
        };
        let sums = Sums::new(sea, energies);
        let mut level = Blocks::new();
        if sea.basin.boundary != Boundary::Fixed {
            energies(0, &mut level);
        }
        let of = |kick: usize| {
            let single: f64 = level.iter().enumerate().map(|(block, e)| libm::sqrt(length(block) * e[kick])).sum();
            let others = sums.total.iter().enumerate().map(|(block, e)| {
                let level = level.get(block).map_or(0.0, |level| level[kick]);
                2.0 * libm::sqrt(length(block) * (e[kick] - level).max(0.0))
            });
            single + others.sum::<f64>()
        };
        SLACK * (raised * of(0) + moved * of(1))
    }
}

/// Largest absolute values in each mode so far.
#[derive(Clone, Debug)]
pub(super) struct ModePeaks {
    a: Vec<f64>,
    b: Vec<f64>,
    force: Vec<f64>,
    /// Norm of the force over the cells, and how far rounding may have carried it in any of them.
    force_norm: f64,
    force_off: f64,
}

impl ModePeaks {
    pub(super) fn new(modes: usize) -> Self {
        Self { a: vec![0.0; modes], b: vec![0.0; modes], force: vec![0.0; modes], force_norm: 0.0, force_off: 0.0 }
    }

    pub(super) fn raise(&mut self, force: &[f64], off: f64, coefficients: &[f64], [a, b]: [&[f64]; 2]) {
        self.force_off = self.force_off.max(off);
        self.force_norm = self.force_norm.max(norm(force));
        for (peaks, values) in [(&mut self.a, a), (&mut self.b, b), (&mut self.force, coefficients)] {
            peaks.par_iter_mut().zip(values).for_each(|(peak, value)| *peak = peak.max(value.abs()));
        }
    }

    /// Returns the bound on heights after a number of steps, and after the part of a step that follows.
    pub(super) fn doubt(&self, sea: &ToonSea, steps: u64, whole: &Modes, rest: Option<&Modes>) -> f64 {
        let seconds = 1.0 / sea.motion.rate();
        let gap = gaps(sea);
        let energies = |mode: usize, blocks: &mut Blocks| {
            let m = whole.transfers[mode];
            let row = rest.map_or([1.0, 0.0], |rest| [rest.transfers[mode][0], rest.transfers[mode][1]]);
            energies([m[0], m[1], m[2], m[3]], row, [[1.0, 0.0], [0.0, 1.0], [m[4], m[5]]], steps, blocks);
        };
        let off = |blocks: &mut Blocks, mode: usize| {
            energies(mode, blocks);
            let response = |kick: usize| -> f64 {
                blocks.iter().enumerate().map(|(block, e)| libm::sqrt(length(block) * e[kick])).sum()
            };
            let scales = scales(&sea.motion, sea.basin.spacing, gap(mode), seconds);
            let [a, b] = rounded(&scales, [self.a[mode], self.b[mode], self.force[mode]]);
            response(0) * a + response(1) * b
        };
        let off: Vec<f64> = (0..self.a.len()).into_par_iter().map_init(Blocks::new, off).collect();
        let sums = Sums::new(sea, energies);
        let forced: f64 = sums.most.iter().enumerate().map(|(block, e)| libm::sqrt(length(block) * e[2])).sum();
        let cells = libm::sqrt(self.a.len() as f64);
        let force = whole.basis.rounding() * self.force_norm + cells * self.force_off;
        SLACK * (norm(&off) + forced * force)
    }
}

/// The part of a step, with its coefficients of heights, velocities and force.
pub(super) struct Part<'a> {
    pub(super) modes: &'a Modes,
    pub(super) seconds: f64,
    pub(super) coefficients: [&'a [f64]; 3],
    /// How far rounding may have carried the force in any cell.
    pub(super) force_off: f64,
    /// Whether heights and velocities were transformed for it.
    pub(super) is_cells: bool,
}

impl Part<'_> {
    /// Returns what it adds.
    pub(super) fn doubt(&self, sea: &ToonSea) -> f64 {
        let Self { modes, seconds, coefficients: [a, b, force], force_off, is_cells } = *self;
        let gap = gaps(sea);
        let off = |mode: usize| {
            let scales = scales(&sea.motion, sea.basin.spacing, gap(mode), seconds);
            rounded(&scales, [a[mode], b[mode], force[mode]].map(f64::abs))[0]
        };
        let off: Vec<f64> = (0..a.len()).into_par_iter().map(off).collect();
        let most = |index: usize| modes.transfers.iter().fold(0.0, |most: f64, factors| most.max(factors[index].abs()));
        let transformed = modes.basis.rounding();
        let state = if is_cells { most(0) * norm(a) + most(1) * norm(b) } else { 0.0 };
        let force = most(4) * (transformed * norm(force) + libm::sqrt(a.len() as f64) * force_off);
        SLACK * (norm(&off) + transformed * state + force)
    }
}

/// Returns what rounding does to both numbers of a mode in a step, given the sizes of (a, b) and of the force.
fn rounded(scales: &Scales, [a, b, force]: [f64; 3]) -> [f64; 2] {
    let Scales { factors: [aa, ab, ba, bb, fa, fb], roundings } = *scales;
    [aa * a + ab * b + fa * force, ba * a + bb * b + fb * force].map(|size| ROUNDING * roundings * size)
}

/// Returns 1 − λ by mode.
fn gaps(sea: &ToonSea) -> impl Fn(usize) -> f64 + Sync + use<> {
    let basin = sea.basin;
    let (x, z) = (basin.axis_gaps(basin.columns), basin.axis_gaps(basin.rows));
    move |mode| (x[mode % basin.columns] + z[mode / basin.columns]) / 2.0
}

/// Number of steps in a block: step 0, then from step 2ᵏ⁻¹ until 2ᵏ.
fn length(block: usize) -> f64 {
    if block < 2 { 1.0 } else { libm::exp2((block - 1) as f64) }
}

/// Energies by block and kick.
type Blocks = Vec<[f64; 3]>;

/// Finds Σ (row·Mʲ·kick)² over the steps j of each block, by kick; the blocks cover at least the given steps.
fn energies(m: [f64; 4], row: [f64; 2], kicks: [[f64; 2]; 3], steps: u64, blocks: &mut Blocks) {
    // Quadratic forms p·a² + 2q·a·b + r·b².
    let [mut p, mut q, mut r] = [row[0] * row[0], row[0] * row[1], row[1] * row[1]];
    let [mut a, mut b, mut c, mut d] = m;
    let of = |[p, q, r]: [f64; 3]| kicks.map(|[x, y]| (p * x * x + 2.0 * q * x * y + r * y * y).max(0.0));
    blocks.clear();
    let mut covered = 1;
    if steps > 0 {
        blocks.push(of([p, q, r]));
    }
    while covered < steps {
        let next = [
            p * a * a + 2.0 * q * a * c + r * c * c,
            p * a * b + q * (a * d + b * c) + r * c * d,
            p * b * b + 2.0 * q * b * d + r * d * d,
        ];
        blocks.push(of(next));
        (p, q, r) = (p + next[0], q + next[1], r + next[2]);
        (a, b, c, d) = (a * a + b * c, b * (a + d), c * (a + d), c * b + d * d);
        covered *= 2;
    }
}

/// Energies of all modes: their sum, and the largest, by block and kick.
#[derive(Default)]
struct Sums {
    total: Blocks,
    most: Blocks,
}

impl Sums {
    fn new(sea: &ToonSea, energies: impl Fn(usize, &mut Blocks) + Sync) -> Self {
        let columns = sea.basin.columns;
        // Sums have one order, whatever the number of threads.
        let row = |blocks: &mut Blocks, row: usize| {
            let mut sums = Self::default();
            for mode in row * columns..(row + 1) * columns {
                energies(mode, blocks);
                sums.join(blocks, blocks);
            }
            sums
        };
        let rows: Vec<Self> = (0..sea.basin.rows).into_par_iter().map_init(Blocks::new, row).collect();
        let mut all = Self::default();
        rows.iter().for_each(|row| all.join(&row.total, &row.most));
        all
    }

    fn join(&mut self, total: &Blocks, most: &Blocks) {
        self.total.resize(total.len().max(self.total.len()), [0.0; 3]);
        self.most.resize(self.total.len(), [0.0; 3]);
        for (block, (total, most)) in total.iter().zip(most).enumerate() {
            for kick in 0..3 {
                self.total[block][kick] += total[kick];
                self.most[block][kick] = self.most[block][kick].max(most[kick]);
            }
        }
    }
}

impl Run {
    /// Returns the bounds on rift and drift: trails decay, and so does what rounding does to them.
    ///
    /// Of a step, what is left and what is added take 30 roundings with their factors, each of the largest value, and
    /// what bursts add is off. Where that renews a trail, the share that is kept is off by the same, times the renewal.
    pub(super) fn trail_doubt(&self, trails: &Trails) -> Doubt {
        let steps = LITERAL_HZ / self.sea.motion.rate();
        let ([rift, drift], [rift_off, drift_off]) = (trails.peaks, trails.added_off);
        let behavior = &self.sea.behavior;
        let remembered = |left: f64| (self.step as f64 + 1.0).min(1.0 + 1.0 / (1.0 - left));
        let (left, added) = decayed(behavior.rift.decay, steps);
        let gain = behavior.rift.gain * added;
        let rift = remembered(left) * (gain * rift_off + 30.0 * ROUNDING * rift);
        let (left, added) = decayed(behavior.drift.decay, steps);
        let renewal = behavior.drift.renewal * steps;
        let drift = remembered(left) * ((added + renewal * drift) * drift_off + 30.0 * ROUNDING * drift);
        Doubt { height: 0.0, rift: SLACK * rift, drift: SLACK * drift }
    }
}
