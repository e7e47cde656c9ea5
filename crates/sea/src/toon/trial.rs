//! Measures a motion by running the f32 code that makes pictures.

use super::field::moved;
use super::modes::Modes;
use super::propagator::Propagator;
use super::reference::{Advance, mean};
use super::{Basin, Field, Forecast, Mixing, Motion, Physics, Probe};

/// Most cells along each side of a grid that is run.
const SIDE: usize = 256;
/// Most steps of a run.
const STEPS: u64 = 4000;
/// Shares of its initial size between which the half-life is measured: so late that other modes are gone, and that a
/// double root, whose decay includes a factor of the number of steps, is distinguished from a slower one.
const DECAY: [f64; 2] = [1e-8, 1e-26];
/// Number of cells along each side of the grid on which a single cell is raised.
const PEAK_SIDE: usize = 65;

/// A sea that was left to itself, starting from a level, the checkerboard and noise, in the f32 code that makes
/// pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Grid that was run: at most 256 cells along each side.
    pub basin: Basin,
    /// Number of steps after which half is left, from the late part of the run; infinite if it did not fall.
    pub half_life: f64,
    /// Number of steps that were taken.
    pub steps: u64,
    /// Share of subnormal numbers among all numbers that were stored.
    pub subnormal_share: f64,
    /// The same for the recurrence as printed, h' = c₁(2·Lm(h) − h₋) + c₂·h in f32 without flushing, over twice as
    /// many steps; `None` for other motions.
    pub printed_subnormal_share: Option<f64>,
}

/// A sea that a constant force finally holds level, after many steps in f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelDrift {
    /// Number of steps that were taken.
    pub steps: u64,
    /// Largest difference from powers of the f64 step, relative to their result.
    pub drift: f64,
}

/// Largest height that a sea reaches over some steps if it starts within ±1 m: the norm of the step's powers. The
/// heights before the start may also be anything within ±1 m; velocities are 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transient {
    /// Factor relative to the start.
    pub gain: f64,
    /// Step at which it is reached.
    pub step: u64,
    /// Number of steps that were examined.
    pub steps: u64,
}

/// The product's step on either kind of state.
pub(super) enum Stepper {
    Cells { mixing: Mixing, field: Field },
    Modes { modes: Modes, propagator: Box<Propagator>, a: Vec<f32>, b: Vec<f32>, weight: Vec<f64> },
}

impl Stepper {
    /// Starts from heights without velocities.
    pub(super) fn new(motion: &Motion, basin: &Basin, height: Vec<f32>) -> Self {
        let velocity = vec![0.0; height.len()];
        match motion {
            Motion::Literal(mixing) => Self::Cells { mixing: *mixing, field: Field { height, velocity } },
            _ => {
                let modes = Modes::new(basin);
                let propagator = Box::new(Propagator::new(motion, basin, &modes, 1.0 / motion.rate()));
                let [a, b] = [height, velocity].map(|mut field| {
                    let mut coefficients = Vec::new();
                    modes.forward(&mut field, &mut coefficients);
                    coefficients
                });
                // Twice the energy of an oscillating mode is ω²h² + v².
                let gap = modes.gap();
                let weight = |mode: usize| match motion {
                    Motion::Physical { physics: Physics { speed, frequency, .. }, .. } => {
                        let stiffness = speed / basin.spacing;
                        (frequency * frequency + 4.0 * stiffness * stiffness * gap(mode)).max(1.0)
                    }
                    _ => 1.0,
                };
                let weight = (0..basin.cells()).map(weight).collect();
                Self::Modes { modes, propagator, a, b, weight }
            }
        }
    }

    pub(super) fn step(&mut self, basin: &Basin, force: Option<&[f32]>) {
        match self {
            Self::Cells { mixing, field } => {
                let Some(force) = force else { return field.step(*mixing, basin) };
                field.accelerate(*mixing, basin);
                for ((height, velocity), force) in field.height.iter_mut().zip(&mut field.velocity).zip(force) {
                    *velocity += force;
                    *height = moved(*height, *velocity);
                }
            }
            Self::Modes { propagator, a, b, .. } => propagator.apply(a, b, force),
        }
    }

    fn numbers(&self) -> [&[f32]; 2] {
        match self {
            Self::Cells { field, .. } => [&field.height, &field.velocity],
            Self::Modes { a, b, .. } => [a, b],
        }
    }

    /// Returns the size of the state, as the root of a sum of squares.
    pub(super) fn size(&self) -> f64 {
        let [first, second] = self.numbers();
        let square = |value: f32| f64::from(value) * f64::from(value);
        let first: f64 = match self {
            Self::Modes { weight, .. } => first.iter().zip(weight).map(|(value, weight)| weight * square(*value)).sum(),
            Self::Cells { .. } => first.iter().map(|value| square(*value)).sum(),
        };
        libm::sqrt(first + second.iter().map(|value| square(*value)).sum::<f64>())
    }

    /// Multiplies the state by a power of 2.
    pub(super) fn scale(&mut self, by: f32) {
        let (first, second) = match self {
            Self::Cells { field, .. } => (&mut field.height, &mut field.velocity),
            Self::Modes { a, b, .. } => (a, b),
        };
        first.iter_mut().chain(second).for_each(|value| *value *= by);
    }

    fn heights(&mut self) -> Vec<f32> {
        match self {
            Self::Cells { field, .. } => field.height.clone(),
            Self::Modes { modes, a, .. } => {
                let mut height = Vec::new();
                modes.backward(&mut a.clone(), &mut height);
                height
            }
        }
    }
}

/// Returns the motion as the product steps it: by the recurrence itself if that is a literal step.
pub(super) fn stepped(motion: &Motion) -> Motion {
    match *motion {
        Motion::Resampled { mixing, rate } if rate == super::LITERAL_HZ => Motion::Literal(mixing),
        other => other,
    }
}

impl Trial {
    /// Runs a motion until nothing is left, for at most 4000 steps.
    pub fn new(motion: &Motion, basin: &Basin) -> Self {
        let basin = Basin { columns: basin.columns.min(SIDE), rows: basin.rows.min(SIDE), ..*basin };
        let start: Vec<f32> = (0..basin.cells()).map(|cell| noisy(&basin, cell)).collect();
        let motion = stepped(motion);
        let mut stepper = Stepper::new(&motion, &basin, start.clone());
        let mut sizes = vec![stepper.size()];
        let mut subnormal = 0;
        let steps = rayon::scope(|_| {
            for step in 1..=STEPS {
                stepper.step(&basin, None);
                subnormal += count_subnormal(stepper.numbers()[0]);
                sizes.push(stepper.size());
                if sizes[step as usize] == 0.0 || !sizes[step as usize].is_finite() {
                    return step;
                }
            }
            STEPS
        });
        let stored = basin.cells() as f64 * steps as f64;
        let printed = match motion {
            Motion::Literal(mixing) => Some(printed_subnormals(mixing, &basin, &start, 2 * steps)),
            _ => None,
        };
        Self {
            basin,
            half_life: half_life(&sizes),
            steps,
            subnormal_share: subnormal as f64 / stored,
            printed_subnormal_share: printed,
        }
    }
}

/// Returns the level, the checkerboard and a little noise, by a hash of the cell.
pub(super) fn noisy(basin: &Basin, cell: usize) -> f32 {
    let (x, z) = (cell % basin.columns, cell / basin.columns);
    let mut hash = (cell as u32).wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x2c1b_3c6d);
    hash = (hash ^ (hash >> 12)).wrapping_mul(0x297a_2d39);
    let noise = f64::from(hash ^ (hash >> 15)) / f64::from(u32::MAX) - 0.5;
    (1.0 + if (x + z) % 2 == 0 { 1.0 } else { -1.0 } + 0.2 * noise) as f32
}

fn count_subnormal(values: &[f32]) -> u64 {
    values.iter().filter(|value| value.is_subnormal()).count() as u64
}

/// Returns ln 2 over the mean decrease of the logarithm, where the run is late and still far from the smallest
/// numbers.
fn half_life(sizes: &[f64]) -> f64 {
    let at = |share: f64| sizes.iter().position(|&size| size < share * sizes[0]);
    let (first, last) = match (at(DECAY[0]), at(DECAY[1])) {
        (Some(first), Some(last)) if last > first + 4 => (first, last),
        // The run was too short for a late part, or too slow to reach it.
        (_, Some(last)) => (0, last),
        _ => (sizes.len() / 2, sizes.len() - 1),
    };
    if sizes[last] == 0.0 {
        return std::f64::consts::LN_2 / 30.0;
    }
    let fall = libm::log(sizes[first] / sizes[last]) / (last - first) as f64;
    if fall > 1e-7 { std::f64::consts::LN_2 / fall } else { f64::INFINITY }
}

/// The recurrence as printed, in f32 and without flushing.
struct PrintedRecurrence {
    mixing: Mixing,
    basin: Basin,
    height: Vec<f64>,
    before: Vec<f64>,
}

impl PrintedRecurrence {
    fn new(mixing: Mixing, basin: &Basin, start: &[f32]) -> Self {
        let wide: Vec<f64> = start.iter().map(|&value| f64::from(value)).collect();
        Self { mixing, basin: *basin, height: wide.clone(), before: wide }
    }

    fn step(&mut self) {
        // The mean in f64, everything else rounded to f32 as printed.
        let means: Vec<f64> = (0..self.height.len()).map(|cell| mean(&self.basin, &self.height, cell)).collect();
        let (c1, c2) = (self.mixing.c1 as f32, self.mixing.c2 as f32);
        for (cell, mean) in means.into_iter().enumerate() {
            let (h, before, mean) = (self.height[cell] as f32, self.before[cell] as f32, mean as f32);
            let next = c1 * (2.0 * mean - before) + c2 * h;
            (self.before[cell], self.height[cell]) = (f64::from(h), f64::from(next));
        }
    }
}

fn printed_subnormals(mixing: Mixing, basin: &Basin, start: &[f32], steps: u64) -> f64 {
    // A part of the grid is sufficient, since decay does not depend on its size.
    let part = Basin { columns: basin.columns.min(32), rows: basin.rows.min(32), ..*basin };
    let start: Vec<f32> = (0..part.cells()).map(|cell| start[cell % start.len()]).collect();
    let mut printed = PrintedRecurrence::new(mixing, &part, &start);
    let mut subnormal = 0;
    for _ in 0..steps {
        printed.step();
        subnormal += printed.height.iter().filter(|&&value| (value as f32).is_subnormal()).count();
    }
    subnormal as f64 / (part.cells() as f64 * steps as f64)
}

impl LevelDrift {
    /// Holds a sea by a level force, or by none if nothing is lost, on the grid of a [`Probe`] of the same motion.
    pub fn new(motion: &Motion, probe: &Probe, steps: u64) -> Self {
        let (basin, motion) = (*probe.basin(), stepped(motion));
        // A level with few digits could hide rounding errors.
        const LEVEL: f64 = 0.7;
        let force = match motion {
            Motion::Literal(mixing) | Motion::Resampled { mixing, .. } => LEVEL * mixing.loss(),
            Motion::Physical { physics, .. } if physics.push.is_none() && physics.frequency > 0.0 => LEVEL,
            Motion::Physical { .. } => 0.0,
        };
        let start: Vec<f32> = (0..basin.cells()).map(|cell| (LEVEL * f64::from(noisy(&basin, cell))) as f32).collect();
        let wide: Vec<f64> = start.iter().map(|&value| f64::from(value)).collect();
        let exact = probe.heights_after(steps, &wide, &vec![0.0; basin.cells()], force);
        let mut stepper = Stepper::new(&motion, &basin, start);
        let mut forces = vec![force as f32; basin.cells()];
        if let Stepper::Modes { modes, .. } = &stepper {
            let mut coefficients = Vec::new();
            modes.forward(&mut forces, &mut coefficients);
            forces = coefficients;
        }
        // Within a pool, a step of few cells costs no hand-over.
        rayon::scope(|_| (0..steps).for_each(|_| stepper.step(&basin, Some(&forces))));
        let found: Vec<f64> = stepper.heights().into_iter().map(f64::from).collect();
        Self { steps, drift: off(&found, &exact) }
    }
}

/// Returns the largest difference, relative to the largest expected value.
fn off(found: &[f64], expected: &[f64]) -> f64 {
    let largest = expected.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let difference = found.iter().zip(expected).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    if difference == 0.0 { 0.0 } else { difference / largest }
}

impl Transient {
    /// Raises one cell in the middle of a grid by 1 m and sums the responses of all cells: by symmetry this is the
    /// most that any start within ±1 m gives to this cell.
    pub fn new(motion: &Motion, basin: &Basin) -> Self {
        let side = |cells: usize| if cells > PEAK_SIDE { PEAK_SIDE - 1 + cells % 2 } else { cells };
        let basin = Basin { columns: side(basin.columns), rows: side(basin.rows), ..*basin };
        let forecast = Forecast::new(motion, &basin);
        // Until hardly anything is left; modes take one transform per step.
        let most = if matches!(stepped(motion), Motion::Literal(_)) { 400.0 } else { 60.0 };
        let steps = if forecast.half_life < 1e6 { (12.0 * forecast.half_life).ceil().min(most) } else { most };
        let advance = Advance::new(&stepped(motion), &basin, 1.0 / motion.rate());
        let middle = basin.rows / 2 * basin.columns + basin.columns / 2;
        let unit: Vec<f64> = (0..basin.cells()).map(|cell| f64::from(cell == middle)).collect();
        let none = vec![0.0; basin.cells()];
        let negative = unit.iter().map(|value| -value).collect();
        let mut states = match motion {
            Motion::Physical { .. } => vec![(unit, none.clone())],
            // A height of 1 m after 0, and a height of 0 after 1 m.
            _ => vec![(unit.clone(), unit), (none.clone(), negative)],
        };
        let mut transient = Self { gain: 1.0, step: 0, steps: steps as u64 };
        for step in 1..=transient.steps {
            let mut gain = 0.0;
            for (height, other) in &mut states {
                advance.step(&none, height, other);
                gain += height.iter().map(|value| value.abs()).sum::<f64>();
            }
            if gain > transient.gain {
                (transient.gain, transient.step) = (gain, step);
            }
        }
        transient
    }
}
