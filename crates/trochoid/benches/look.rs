//! Cost of shading samples: batches of a look, as a thesis on painted oceans layers it, against the same colors in Rust
//! written by hand, sample by sample.

#![allow(clippy::unwrap_used, missing_docs, reason = "a benchmark may panic")]

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use trochoid::{LookBuilder, Samples, SamplesMut, Shader};

fn main() {
    divan::main();
}

/// Water by its light, its rim, the glitter of the sun, and the haze of the distance.
const LOOK: &str = include_str!("look.json");

const PASSES: [&str; 4] = ["light", "rim", "depth", "glint"];
const COUNTS: [usize; 3] = [16, 256, 4096];

/// Returns pseudorandom passes: three masks, and the depth in meters.
fn passes(count: usize) -> [Vec<f32>; 4] {
    [0, 1, 2, 3].map(|pass: u32| {
        let number = |i: usize| {
            let mixed = (i as u32).wrapping_mul(0x9E37_79B9).wrapping_add(pass.wrapping_mul(0x85EB_CA6B));
            ((mixed ^ (mixed >> 15)).wrapping_mul(0x2C1B_3C6D) >> 8) as f32 / (1 << 24) as f32
        };
        (0..count).map(|i| if pass == 2 { 90.0 * number(i) } else { number(i) }).collect()
    })
}

fn shader() -> Shader {
    let builder = PASSES.iter().fold(LookBuilder::new(LOOK), |builder, pass| builder.bind(pass));
    builder.build().unwrap().shader().unwrap()
}

#[divan::bench(args = COUNTS)]
fn batch(bencher: Bencher<'_, '_>, count: usize) {
    let (mut shader, passes, mut rgb) = (shader(), passes(count), [0, 1, 2].map(|_| vec![0.0_f32; count]));
    bencher.counter(ItemsCount::new(count)).bench_local(|| {
        let inputs = passes.each_ref().map(|pass| Samples::new(pass));
        let mut outputs = rgb.each_mut().map(|channel| SamplesMut::new(channel));
        shader.shade(count, black_box(&inputs), &mut outputs).unwrap();
    });
}

/// The same with all passes and colors of a sample side by side.
#[divan::bench(args = COUNTS)]
fn strided(bencher: Bencher<'_, '_>, count: usize) {
    let (mut shader, passes) = (shader(), passes(count));
    let points: Vec<f32> = (0..count).flat_map(|i| passes.each_ref().map(|pass| pass[i])).collect();
    let mut rgb = vec![0.0; 3 * count];
    bencher.counter(ItemsCount::new(count)).bench_local(|| {
        let inputs = [0, 1, 2, 3].map(|pass| Samples::strided(&points[pass..], 4));
        shader.shade_pixels(count, black_box(&inputs), &mut rgb, 3).unwrap();
    });
}

fn mix(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    [0, 1, 2].map(|c| a[c] * (1.0 - t) + b[c] * t)
}

fn by_hand(light: f32, rim: f32, depth: f32, glint: f32) -> [f32; 3] {
    let color = |hex: u32| [16, 8, 0].map(|shift| (hex >> shift & 255) as f32 / 255.0);
    let lit = ((light - 0.1) / 0.8).clamp(0.0, 1.0);
    let lit = lit * lit * (3.0 - 2.0 * lit);
    let (dark, middle, bright) = (color(0x1f4a52), color(0x7f8f90), color(0xe8e2bf));
    let water = if lit < 0.6 { mix(dark, middle, lit / 0.6) } else { mix(middle, bright, (lit - 0.6) / 0.4) };
    let rimmed = mix(water, color(0x8a9aa4), rim);
    let shining = mix(rimmed, color(0xfff2d0), glint * lit * 0.8);
    mix(shining, color(0x909fa2), ((depth - 3.0) / 57.0).clamp(0.0, 1.0))
}

/// Rust as one writes it for single samples.
#[divan::bench(args = COUNTS)]
fn scalar(bencher: Bencher<'_, '_>, count: usize) {
    let (passes, mut rgb) = (passes(count), [0, 1, 2].map(|_| vec![0.0_f32; count]));
    bencher.counter(ItemsCount::new(count)).bench_local(|| {
        for i in 0..count {
            let [light, rim, depth, glint] = passes.each_ref().map(|pass| pass[i]);
            let color = by_hand(light, rim, depth, glint);
            rgb.iter_mut().zip(color).for_each(|(channel, value)| channel[i] = value);
        }
    });
    // Both compute the same.
    let mut shaded = [0, 1, 2].map(|_| vec![0.0_f32; count]);
    let inputs = passes.each_ref().map(|pass| Samples::new(pass));
    shader().shade(count, &inputs, &mut shaded.each_mut().map(|channel| SamplesMut::new(channel))).unwrap();
    for (channel, by_hand) in shaded.iter().zip(&rgb) {
        assert!(channel.iter().zip(by_hand).all(|(a, b)| (a - b).abs() < 1e-5));
    }
}
