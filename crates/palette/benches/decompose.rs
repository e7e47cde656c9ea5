//! Times how a picture of 1920 × 1080 pixels is taken apart into weights, in memory.

use divan::{Bencher, black_box};
use trochoid_palette::Decomposer;
use trochoid_weights::Storing;

const PALETTE: [[f64; 3]; 8] = [
    [0.04, 0.05, 0.12],
    [0.9, 0.2, 0.15],
    [0.2, 0.55, 0.3],
    [0.1, 0.3, 0.8],
    [0.95, 0.9, 0.4],
    [0.98, 0.97, 0.93],
    [0.45, 0.4, 0.38],
    [0.0, 0.8, 0.9],
];

/// Smooth mixes of four colors with a grain of a step of 8 bits, as a painting has.
fn picture() -> Vec<[f32; 3]> {
    let mut state = 1_u64;
    let mut pixels = Vec::with_capacity(1920 * 1080);
    for y in 0..1080 {
        for x in 0..1920 {
            let (u, v) = (f64::from(x) / 1920.0, f64::from(y) / 1080.0);
            let waves = 0.5 + 0.5 * (9.0 * u + 5.0 * (4.0 * v).sin()).sin();
            let weights = [0.9 * (1.0 - u) * v, 0.9 * u * (1.0 - waves), 0.9 * u * waves, 0.9 * (1.0 - u) * (1.0 - v)];
            let rest = 1.0 - weights.iter().sum::<f64>();
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let grain = ((state >> 40) as f64 / f64::from(1 << 24) - 0.5) / 255.0;
            let channel = |c: usize| {
                let mixed = [0, 3, 4, 5].iter().zip(weights).map(|(color, weight)| PALETTE[*color][c] * weight);
                (mixed.sum::<f64>() + rest * PALETTE[6][c] + grain) as f32
            };
            pixels.push([channel(0), channel(1), channel(2)]);
        }
    }
    pixels
}

#[divan::bench(args = [4, 6, 8], sample_count = 20)]
fn halves(bencher: Bencher<'_, '_>, colors: usize) {
    // Of few colors, those whose hull is largest.
    let order = [0, 5, 3, 4, 6, 1, 2, 7];
    let palette: Vec<[f64; 3]> = order[..colors].iter().map(|index| PALETTE[*index]).collect();
    let Some(decomposer) = Decomposer::new(&palette, 0.2) else { return };
    let pixels = picture();
    bencher.bench_local(|| black_box(&decomposer).planes(black_box(&pixels), Storing::Half));
}

fn main() {
    divan::main();
}
