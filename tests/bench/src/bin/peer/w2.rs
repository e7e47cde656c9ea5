//! W2: displacement by 1000 trochoidal waves of the thesis on 1024 × 1024 points, one frame at a time.

use super::{Result, serve};
use std::f64::consts::TAU;
use std::path::Path;
use trochoid_sea::{FieldSet, Fields, Grid, GridPlan, Sea, Wave};

const SIZE: usize = 1024;
const TIME: f64 = 12.5;

fn hash(x: u32, y: u32, seed: u32) -> u32 {
    let h = x.wrapping_mul(0x8DA6_B343) ^ y.wrapping_mul(0xD816_3841) ^ seed.wrapping_mul(0xCB1A_B31F);
    let h = (h ^ (h >> 16)).wrapping_mul(0x7FEB_352D);
    let h = (h ^ (h >> 15)).wrapping_mul(0x846C_A68B);
    h ^ (h >> 16)
}

fn wave(n: u32) -> Wave {
    let unit = |k: u32, seed: u32| (f64::from(hash(n, k, seed)) + 0.5) / 4_294_967_296.0;
    let normal = |seed: u32| (-2.0 * unit(0, seed).ln()).sqrt() * (TAU * unit(1, seed)).cos();
    let wavelength = (20f64.ln() - 0.125 + 0.5 * normal(101)).exp();
    let azimuth = 30f64.to_radians() * normal(102);
    // Sharpness 0.7 and weight 1/1000 scale both displacements. The signs printed in the thesis make the horizontal one
    // negative.
    let amplitude = 0.7 * wavelength / 40.0 / 1000.0;
    let period = (TAU * wavelength / 9.81).sqrt();
    Wave {
        wavelength,
        direction: [azimuth.cos(), azimuth.sin()],
        amplitude,
        horizontal: -amplitude,
        angular_frequency: TAU / period,
        phase: 0.0,
    }
}

/// Returns the f64 numbers of a NumPy file.
pub(crate) fn numbers(path: &Path) -> Result<Vec<f64>> {
    let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let number = |b: &[u8]| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]);
    Ok(bytes[header..].chunks_exact(8).map(number).collect())
}

/// Times one frame of the sea, at an error of at most `tolerance` of the root mean square.
pub(crate) fn run(work: &Path, tolerance: &str) -> Result<()> {
    let sea = Sea::new((0..1000).map(wave).collect());
    let step = 500.0 / SIZE as f64;
    let grid = Grid { origin: [0.0; 2], step: [step; 2], columns: SIZE, rows: SIZE, footprint: 0.0 };
    let wanted = FieldSet { displacement: true, ..FieldSet::default() };
    let mut plan = GridPlan::new(grid, wanted, sea.waves().len(), tolerance.parse()?)?;
    let mut fields = Fields::default();
    plan.evaluate(&sea.at(TIME), &mut fields);
    let expected = numbers(&work.join("w2_ref.npy"))?;
    let (mut error, mut squares) = (0.0f64, 0.0);
    for (axis, found) in fields.displacement.iter().enumerate() {
        for (&found, &expected) in found.iter().zip(expected[axis..].iter().step_by(3)) {
            let off = (f64::from(found) - expected).abs();
            // NaN counts as an error.
            error = if off <= error { error } else { off };
            squares += expected * expected;
        }
    }
    let rms = (squares / expected.len() as f64).sqrt();
    let note = format!("planar, {:?}", plan.method());
    serve(Some(error / rms), &note, || {
        plan.evaluate(&sea.at(TIME), &mut fields);
        Ok(())
    })
}
