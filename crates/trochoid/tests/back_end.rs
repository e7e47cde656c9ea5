//! The library without any feature: `cargo test -p trochoid --no-default-features`.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;
use trochoid::{
    Buffers, Cache, CheckedGraph, Kind, LookBuilder, Plan, ReferenceFrame, Samples, SamplesMut, Settings, Silent, parse,
};

const WIDTH: usize = 7;
const HEIGHT: usize = 3;

/// Two passes that a renderer binds, and a picture that they mix.
const LOOK: &str = r##"{
  "trochoid": 1,
  "format": { "width": 7, "height": 3 },
  "working_space": "srgb",
  "nodes": {
    "light": { "type": "ScreenX" },
    "depth": { "type": "FieldMath", "expression": "100 * a", "a": "light" },
    "haze": { "type": "Clamp", "field": "depth", "min": 20, "max": 80 },
    "sea": { "type": "Mix", "a": "#14262e", "b": "#e0b981", "weight": "light" },
    "beauty": { "type": "Mix", "a": "sea", "b": "#f0cf8e", "weight": "haze" }
  },
  "outputs": { "beauty": { "color": "beauty" } }
}"##;

fn look() -> CheckedGraph {
    parse("look", LOOK, Path::new("."), &[]).unwrap().graph
}

/// Returns a pass whose values cover [0, `most`], including both ends.
fn pass(step: usize, most: f32) -> Vec<f32> {
    (0..WIDTH * HEIGHT).map(|at| (at * step % (WIDTH * HEIGHT)) as f32 / (WIDTH * HEIGHT - 1) as f32 * most).collect()
}

/// Returns the value of the picture by its formula in f64.
fn truth(light: f32, depth: f32) -> [f64; 3] {
    let color = |hex: u32| [16, 8, 0].map(|shift| f64::from(hex >> shift & 255) / 255.0);
    let mix = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|c| (1.0 - t) * a[c] + t * b[c]);
    let sea = mix(color(0x14262e), color(0xe0b981), f64::from(light));
    mix(sea, color(0xf0cf8e), ((f64::from(depth) - 20.0) / 60.0).clamp(0.0, 1.0))
}

#[test]
fn bound_passes_are_mixed_in_their_palette() {
    let (graph, light, depth) = (look(), pass(5, 1.0), pass(8, 100.0));
    let plan = Plan::new(&graph, &["beauty"], 1, &["light", "depth"], &Settings::default()).unwrap();
    let buffers = Buffers::new().with("light", &[&light]).with("depth", &[&depth]);
    let frame = plan.evaluate(&buffers, &mut Cache::new(), &Silent).unwrap();
    let picture = &frame.pictures[0];
    assert_eq!((picture.kind, picture.control_count), (Kind::Color, 3));
    assert_eq!((picture.audit.hull_exits, picture.audit.nan_count), (0, 0));
    for at in 0..WIDTH * HEIGHT {
        for (channel, truth) in truth(light[at], depth[at]).into_iter().enumerate() {
            let found = f64::from(picture.planes[channel].samples()[at]);
            assert!((found - truth).abs() < 1e-6, "pixel {at}, channel {channel}: {found}, not {truth}");
        }
    }
    // Single samples, for renderers without images.
    let look = LookBuilder::new(LOOK).bind("light").bind("depth").build().unwrap();
    let mut out = [0; 3].map(|_| vec![0.0; WIDTH * HEIGHT]);
    let mut channels = out.each_mut().map(|channel| SamplesMut::new(channel));
    let passes = [Samples::new(&light), Samples::new(&depth)];
    look.shader().unwrap().shade(WIDTH * HEIGHT, &passes, &mut channels).unwrap();
    for (channel, plane) in out.iter().zip(&picture.planes) {
        assert_eq!(channel, plane.samples());
    }
}

#[test]
fn without_buffers_its_own_passes_agree_with_the_reference() {
    let graph = look();
    let plan = Plan::new(&graph, &["beauty"], 1, &[], &Settings::default()).unwrap();
    let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    let reference = ReferenceFrame::new(&graph, "beauty", 1).unwrap();
    for (at, (x, y)) in (0..HEIGHT as i64).flat_map(|y| (0..WIDTH as i64).map(move |x| (x, y))).enumerate() {
        let light = x as f32 / (WIDTH - 1) as f32;
        let formula = truth(light, 100.0 * light);
        for (channel, truth) in reference.pixel(x, y).unwrap().into_iter().enumerate() {
            let found = f64::from(frame.pictures[0].planes[channel].samples()[at]);
            assert!((found - truth).abs() < 1e-6 && (truth - formula[channel]).abs() < 1e-5, "({x}, {y}): {found}");
        }
    }
}

#[test]
fn batches_allocate_nothing() {
    const MOST: usize = 1030;
    let [light, depth] = [pass(5, 1.0), pass(8, 100.0)].map(|pass| [&pass[..]; MOST / (WIDTH * HEIGHT) + 1].concat());
    for expecting in [0, usize::MAX] {
        let look = LookBuilder::new(LOOK).bind("light").bind("depth").expecting(expecting).build().unwrap();
        let mut shader = look.shader().unwrap();
        let mut shade = |count: usize| {
            let mut out = [[0.0; MOST]; 3];
            let mut channels = out.each_mut().map(|channel| SamplesMut::new(channel));
            shader.shade(count, &[Samples::new(&light), Samples::new(&depth)], &mut channels).unwrap();
        };
        shade(1);
        let counted = allocation_counter::measure(|| (1..=MOST).for_each(&mut shade));
        assert_eq!(counted.count_total, 0, "{expecting} samples expected");
        assert!(allocation_counter::measure(|| drop(vec![0; 9])).count_total > 0, "they are counted");
    }
}

#[test]
fn what_is_left_out_is_refused_by_name() {
    for (ty, compiled) in [
        ("Mix", true),
        ("Strokes", true),
        ("Noise", true),
        ("Render", cfg!(feature = "scene")),
        ("GerstnerSea", cfg!(feature = "sea")),
        ("Read", cfg!(feature = "io")),
    ] {
        assert_eq!(trochoid::registry().get(ty).is_some(), compiled, "{ty}");
    }
    let document = LOOK.replace("\"ScreenX\"", "\"NoSuchPass\"");
    assert!(parse("look", &document, Path::new("."), &[]).is_err());
}
