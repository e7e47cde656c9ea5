//! W3: steps of a toon sea on 512 × 512 cells, with 100 or 10,000 bursts. After 32 steps the sea starts again at rest.

use super::w2::numbers;
use super::{Result, serve};
use std::path::Path;
use trochoid_sea::toon::{Basin, Behavior, Boundary, Burst, Combine, Field, Mixing, Motion, Rift, Scratch, ToonSea};

const SIDE: usize = 512;
const STEPS: usize = 32;

/// State of the sea between steps.
struct Run {
    sea: ToonSea,
    mixing: Mixing,
    field: Field,
    rift: Vec<f32>,
    scratch: Scratch,
    step: usize,
}

impl Run {
    fn new(count: u32) -> Result<Self> {
        let basin = Basin { columns: SIDE, rows: SIDE, spacing: 1.0, boundary: Boundary::Replicate };
        let mixing = Mixing { c1: 0.3, c2: 0.65 };
        let rift = Rift { distance: 8.0, gain: 0.02, decay: 0.03, combine: Combine::Nearest };
        let behavior = Behavior { injection: Some(0.05), rift, ..Behavior::default() };
        let sea = ToonSea::new(basin, Motion::Literal(mixing), behavior, (0..count).map(burst).collect())?;
        let field = Field::at_rest(&basin);
        Ok(Self { sea, mixing, field, rift: vec![0.0; SIDE * SIDE], scratch: Scratch::default(), step: 0 })
    }

    /// Applies the recurrence, then the bursts. Time on paths is in steps.
    fn step(&mut self) {
        if self.step == STEPS {
            self.field.height.fill(0.0);
            self.field.velocity.fill(0.0);
            self.rift.fill(0.0);
            self.step = 0;
        }
        self.field.accelerate(self.mixing, self.sea.basin());
        self.sea.inject(self.step as f64, &mut self.field, &mut self.rift, &mut self.scratch);
        self.step += 1;
    }
}

fn hash32(x: u32, y: u32, seed: u32) -> u32 {
    let mut h = x.wrapping_mul(0x8DA6_B343) ^ y.wrapping_mul(0xD816_3841) ^ seed.wrapping_mul(0xCB1A_B31F);
    h = (h ^ (h >> 16)).wrapping_mul(0x7FEB_352D);
    h = (h ^ (h >> 15)).wrapping_mul(0x846C_A68B);
    h ^ (h >> 16)
}

/// cos(clamp(π·|u − x|/R, 0, π)) + 1 on a path of 256 steps.
fn burst(n: u32) -> Burst {
    let draw = |k: u32| hash32(n, k, 201);
    let place = |k: u32| f64::from(draw(k) >> 8) * SIDE as f64 / f64::from(1 << 24);
    let radius = 6.0 + f64::from(draw(9) >> 24) / 32.0;
    Burst {
        duration: 256.0,
        offset: f64::from(draw(8) >> 24),
        height: 2.0,
        influence: [radius; 2],
        ..Burst::along([0, 1, 2, 3].map(|k| [place(2 * k), place(2 * k + 1)]))
    }
}

/// Returns the greatest error of heights and rift, each relative to its greatest value.
fn error(run: &Run, expected: &[f64]) -> f64 {
    let mut worst = 0.0f64;
    for (channel, found) in [&run.field.height, &run.rift].into_iter().enumerate() {
        let expected = || expected[channel..].iter().step_by(2);
        let size = expected().fold(0.0, |size: f64, value| size.max(value.abs()));
        for (&found, expected) in found.iter().zip(expected()) {
            let off = (f64::from(found) - expected).abs() / size;
            // NaN counts as an error.
            worst = if off <= worst { worst } else { off };
        }
    }
    worst
}

/// Times a step.
pub(crate) fn run(work: &Path, count: &str) -> Result<()> {
    let mut run = Run::new(count.parse().map_err(|_| format!("found {count} bursts; expected 100 or 10000"))?)?;
    (0..STEPS).for_each(|_| run.step());
    // Elsewhere the recurrence comes after the bursts.
    run.field.step(run.mixing, run.sea.basin());
    let error = error(&run, &numbers(&work.join(format!("w3_ref_{count}.npy")))?);
    run.step = STEPS;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    serve(Some(error), &format!("tiles of 64 x 32 cells, {threads} threads"), || {
        run.step();
        Ok(())
    })
}
