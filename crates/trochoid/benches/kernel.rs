//! Cost of the fused program: a picture of eight mixes, a purely arithmetic graph on one and two threads, and branches that
//! the output does not need.

#![allow(clippy::unwrap_used, missing_docs, reason = "a benchmark may panic")]

use divan::Bencher;
use std::fmt::Write as _;
use std::path::Path;
use trochoid::{Buffers, Cache, Frame, Judging, Plan, Plane, Settings, Silent, Window};

const SIZE: (u32, u32) = (1920, 1080);

fn main() {
    divan::main();
}

/// Returns five masks of pseudorandom values between 0 and 1.
fn masks() -> Vec<Plane> {
    let window = Window::sized(SIZE.0, SIZE.1);
    (0..5u32)
        .map(|index| {
            let mut plane = Plane::zeroed(window, 4 + index as usize).unwrap();
            for (i, v) in plane.samples_mut().iter_mut().enumerate() {
                let mixed = (i as u32).wrapping_mul(0x9E37_79B9).wrapping_add(index.wrapping_mul(0x85EB_CA6B));
                *v = ((mixed ^ (mixed >> 15)).wrapping_mul(0x2C1B_3C6D) >> 8) as f32 / (1 << 24) as f32;
            }
            plane
        })
        .collect()
}

/// Measures the evaluation of a document over the masks m0 to m4.
fn evaluate(bencher: Bencher<'_, '_>, nodes: &str, out: &str, threads: usize) {
    let mut text =
        format!("{{ \"trochoid\": 1, \"format\": {{ \"width\": {}, \"height\": {} }}, \"nodes\": {{", SIZE.0, SIZE.1);
    for index in 0..5 {
        let _ = write!(
            text,
            "\"m{index}\": {{ \"type\": \"Read\", \"file\": \"m.exr\", \"channels\": [\"m{index}\"], \"as\": \"weights\" }},"
        );
    }
    let _ = write!(text, "{nodes} }}, \"outputs\": {{ \"out\": {{ \"color\": \"{out}\" }} }} }}");
    let graph = trochoid::parse("bench.json", &text, Path::new("."), &[]).unwrap().graph;
    let masks = masks();
    let names = ["m0", "m1", "m2", "m3", "m4"];
    let buffers = names.iter().zip(&masks).fold(Buffers::new(), |all, (name, mask)| all.with(name, &[mask.samples()]));
    let mut settings = Settings::default();
    settings.threads = threads;
    settings.judge = Judging::Sampled;
    let plan = Plan::new(&graph, &["out"], 1, &names, &settings).unwrap();
    let (mut frame, mut cache) = (Frame::default(), Cache::new());
    bencher.bench_local(|| plan.evaluate_into(&mut frame, &buffers, &mut cache, &Silent).unwrap());
}

/// Returns a color for a number.
fn color(number: u32) -> String {
    let channel = |seed: u32| f64::from(number.wrapping_mul(seed) >> 16 & 0xff) / 255.0;
    format!("[{}, {}, {}]", channel(0x9E37_79B9), channel(0x85EB_CA6B), channel(0xC2B2_AE35))
}

/// A mix of ten Ramps of eight colors and ten bicubic Patches.
#[divan::bench(args = [1, 2])]
fn ramps_and_patches(bencher: Bencher<'_, '_>, threads: usize) {
    let mut nodes = String::new();
    let mut last = "[0, 0, 0]".to_string();
    for index in 0..20u32 {
        let colors = |count: u32| (0..count).map(move |i| color(16 * index + i + 1));
        let (u, v) = (index % 5, (index + 1 + index / 5) % 5);
        if index % 2 == 0 {
            let stops: Vec<String> = colors(8)
                .enumerate()
                .map(|(i, c)| format!("{{ \"at\": {}, \"color\": {c} }}", i as f64 / 7.0))
                .collect();
            let _ = write!(
                nodes,
                "\"n{index}\": {{ \"type\": \"Ramp\", \"weight\": \"m{u}\", \"stops\": [{}] }},",
                stops.join(", ")
            );
        } else {
            let colors: Vec<String> = colors(16).collect();
            let _ = write!(
                nodes,
                "\"n{index}\": {{ \"type\": \"Patch\", \"u\": \"m{u}\", \"v\": \"m{v}\", \"colors\": [{}] }},",
                colors.join(", ")
            );
        }
        let _ = write!(
            nodes,
            "\"x{index}\": {{ \"type\": \"Mix\", \"a\": {last}, \"b\": \"n{index}\", \"weight\": \"m{}\" }},",
            (u + 3) % 5
        );
        last = format!("\"x{index}\"");
    }
    nodes.pop();
    evaluate(bencher, &nodes, "x19", threads);
}

/// Eight mixes, and this many unneeded branches of two mixes each.
#[divan::bench(args = [0, 100])]
fn unneeded(bencher: Bencher<'_, '_>, branches: u32) {
    let mut nodes = String::new();
    for index in 0..branches {
        let (a, b) = (color(2 * index), color(2 * index + 1));
        let _ = write!(
            nodes,
            "\"a{index}\": {{ \"type\": \"Mix\", \"a\": {a}, \"b\": {b}, \"weight\": \"m{}\" }}, \"b{index}\": {{ \"type\": \"Mix\", \"a\": \"a{index}\", \"b\": {b}, \"weight\": \"m{}\" }},",
            index % 5,
            (index + 1) % 5
        );
    }
    let mut last = color(1000);
    for index in 0..8 {
        let _ = write!(
            nodes,
            "\"x{index}\": {{ \"type\": \"Mix\", \"a\": {last}, \"b\": {}, \"weight\": \"m{}\" }},",
            color(2000 + index),
            index % 5
        );
        last = format!("\"x{index}\"");
    }
    nodes.pop();
    evaluate(bencher, &nodes, "x7", 0);
}
