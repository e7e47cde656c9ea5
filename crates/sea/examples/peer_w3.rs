//! Steps a toon sea as other programs do, so that they can be timed side by side.
//!
//! `peer_w3 W3:100` or `W3:10000` (the number of bursts) prepares itself, takes 32 steps, prints one line of JSON with
//! the error of heights and rift against `w3_ref_N.npy` in the folder `PEER_WORK`, and then, for each line `run N` on
//! stdin, takes N steps and prints how long each took; `quit` ends it. After 32 steps the sea begins anew.

use std::error::Error;
use std::io::{BufRead, Write};
use std::time::Instant;

use trochoid_sea::toon::{Basin, Behavior, Boundary, Burst, Combine, Field, Mixing, Motion, Rift, Scratch, ToonSea};

const SIDE: usize = 512;
const STEPS: usize = 32;

/// Steps and what they leave.
struct Run {
    sea: ToonSea,
    mixing: Mixing,
    field: Field,
    rift: Vec<f32>,
    scratch: Scratch,
    step: usize,
}

impl Run {
    fn new(count: u32) -> Result<Self, Box<dyn Error>> {
        let basin = Basin { columns: SIDE, rows: SIDE, spacing: 1.0, boundary: Boundary::Replicate };
        let mixing = Mixing { c1: 0.3, c2: 0.65 };
        let rift = Rift { distance: 8.0, gain: 0.02, decay: 0.03, combine: Combine::Nearest };
        let behavior = Behavior { injection: Some(0.05), rift, ..Behavior::default() };
        let sea = ToonSea::new(basin, Motion::Literal(mixing), behavior, (0..count).map(burst).collect())?;
        let field = Field::at_rest(&basin);
        Ok(Self { sea, mixing, field, rift: vec![0.0; SIDE * SIDE], scratch: Scratch::default(), step: 0 })
    }

    /// Bursts, then the recurrence. Paths are timed in steps.
    fn step(&mut self) {
        if self.step == STEPS {
            self.field.height.fill(0.0);
            self.field.before.fill(0.0);
            self.rift.fill(0.0);
            self.step = 0;
        }
        self.sea.inject(self.step as f64, &mut self.field, &mut self.rift, &mut self.scratch);
        self.field.step(self.mixing, self.sea.basin());
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

/// Greatest error of heights and rift over the greatest value.
fn error(run: &Run, count: u32) -> Result<f64, Box<dyn Error>> {
    let folder = std::env::var("PEER_WORK").map_err(|_| "PEER_WORK is not set: name the folder of the inputs")?;
    let path = std::path::Path::new(&folder).join(format!("w3_ref_{count}.npy"));
    let bytes = std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let expected: Vec<f64> =
        bytes[header..].as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let mut worst = 0.0f64;
    for (channel, found) in [&run.field.height, &run.rift].into_iter().enumerate() {
        let expected = || expected[channel..].iter().step_by(2);
        let size = expected().fold(0.0, |size: f64, value| size.max(value.abs()));
        for (&found, expected) in found.iter().zip(expected()) {
            let off = (f64::from(found) - expected).abs() / size;
            // NaN must count.
            worst = if off <= worst { worst } else { off };
        }
    }
    Ok(worst)
}

fn main() -> Result<(), Box<dyn Error>> {
    let case = std::env::args().nth(1).unwrap_or_default();
    let count: u32 = case
        .strip_prefix("W3:")
        .and_then(|count| count.parse().ok())
        .ok_or_else(|| format!("found the case \"{case}\"; expected W3:100 or W3:10000"))?;
    let started = Instant::now();
    let mut run = Run::new(count)?;
    (0..STEPS).for_each(|_| run.step());
    let setup = started.elapsed().as_secs_f64();
    let error = error(&run, count)?;
    let note =
        format!("tiles of 64 x 32 cells, {} threads", std::thread::available_parallelism().map_or(1, usize::from));
    println!("{}", serde_json::json!({ "ready": true, "setup_s": setup, "error": error, "note": note }));
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let mut words = line.split_whitespace();
        let (Some("run"), Some(steps)) = (words.next(), words.next()) else { break };
        let mut times = Vec::new();
        for _ in 0..steps.parse::<usize>()? {
            let started = Instant::now();
            run.step();
            times.push(started.elapsed().as_secs_f64());
        }
        println!("{}", serde_json::json!({ "times": times }));
        std::io::stdout().flush()?;
    }
    Ok(())
}
