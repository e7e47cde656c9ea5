//! Large pictures of which only some pixels are held have the same values and colors as the whole pictures.

use crate::testing::{Frame, graph};
use std::collections::BTreeSet;
use std::path::Path;
use trochoid_graph::{MemoryContext, MemoryUse};
use trochoid_io::{PngImage, Samples, write_png8};
use trochoid_nodes::inside::{Holding, memory_of_read};

const WIDTH: usize = 1300;
const HEIGHT: usize = 40;

/// Pictures of more than a kilobyte are held in part.
const HOLDING: Holding = Holding { on_demand: None, whole: 1 << 10 };

/// Returns the bytes of a pixel.
fn pixel(x: usize, y: usize) -> [u8; 3] {
    [(x * 7 + y * 13) % 251, x % 256, y * 5].map(|v| v as u8)
}

/// Returns a frame of a document of 4 × 3 pixels.
fn frame(folder: &Path, key: &str, knobs: &str) -> Frame {
    let pixels: Vec<[f32; 3]> =
        (0..WIDTH * HEIGHT).map(|at| pixel(at % WIDTH, at / WIDTH).map(|v| f32::from(v) / 255.0)).collect();
    let image = PngImage::new(WIDTH as u32, HEIGHT as u32, Samples::rgb(&pixels));
    write_png8(folder.join("a.png"), &image).unwrap();
    let node = format!(r#""out": {{ "type": "Read", "file": "a.png", {knobs} }}"#);
    Frame::held(graph(key, &node, folder).unwrap(), HOLDING).unwrap()
}

/// Returns the value by reference and by fill, which must agree.
fn value(frame: &Frame, x: i64, y: i64) -> f64 {
    let at = [x as f64 + 0.5, y as f64 + 0.5];
    let (truth, found) = (frame.truth(at)[0], frame.lowered(at)[0]);
    assert!((truth - f64::from(found)).abs() < 1e-6, "{truth} and {found} at {x}, {y}");
    truth
}

fn red(x: i64, y: i64) -> f64 {
    let (x, y) = (x.clamp(0, WIDTH as i64 - 1), y.clamp(0, HEIGHT as i64 - 1));
    f64::from(pixel(x as usize, y as usize)[0]) / 255.0
}

const RED: &str = r#""as": "field", "channels": ["R"]"#;
const WHOLE: usize = WIDTH * HEIGHT * size_of::<f32>();

#[test]
fn samples_fall_on_what_is_held() {
    let folder = tempfile::tempdir().unwrap();
    let nearest = frame(folder.path(), "field", &format!(r#"{RED}, "fit": "nearest""#));
    let bilinear = frame(folder.path(), "field", &format!(r#"{RED}, "fit": "bilinear""#));
    let crop = frame(folder.path(), "field", &format!(r#"{RED}, "fit": "crop""#));
    let (across, down) = (WIDTH as f64 / 4.0, HEIGHT as f64 / 3.0);
    for y in 0..3 {
        for x in 0..4 {
            let (u, v) = ((x as f64 + 0.5) * across, (y as f64 + 0.5) * down);
            assert!((value(&nearest, x, y) - red(u.floor() as i64, v.floor() as i64)).abs() < 1e-6);
            let (u, v) = (u - 0.5, v - 0.5);
            let (low, top, s, t) = (u.floor() as i64, v.floor() as i64, u - u.floor(), v - v.floor());
            let row = |y: i64| (1.0 - s) * red(low, y) + s * red(low + 1, y);
            let expected = (1.0 - t) * row(top) + t * row(top + 1);
            assert!((value(&bilinear, x, y) - expected).abs() < 1e-6, "{x}, {y}");
            assert!((value(&crop, x, y) - red(x, y)).abs() < 1e-6);
        }
    }
    for frame in [&nearest, &bilinear, &crop] {
        let held = frame.node("out").bytes();
        assert!(2 * held < WHOLE, "{held} bytes of {WHOLE}");
    }
}

#[test]
fn who_asks_for_more_gets_it() {
    let folder = tempfile::tempdir().unwrap();
    let crop = frame(folder.path(), "field", &format!(r#"{RED}, "fit": "crop""#));
    assert!((value(&crop, 250, 39) - red(250, 39)).abs() < 1e-6);
    assert!(2 * crop.node("out").bytes() < WHOLE);
    for (x, y) in [(1299, 0), (700, 20), (5000, 20), (-3, 60)] {
        assert!((value(&crop, x, y) - red(x, y)).abs() < 1e-6, "{x}, {y}");
    }
    assert!(crop.node("out").bytes() > WHOLE);
}

#[test]
fn every_color_is_a_control_color() {
    let folder = tempfile::tempdir().unwrap();
    let color = frame(folder.path(), "color", r#""as": "color", "encoding": "linear", "fit": "nearest""#);
    assert!(2 * color.node("out").bytes() < 3 * WHOLE);
    let bits = |color: &[f32; 3]| color.map(|v| (v * 255.0).round() as u8);
    let found: BTreeSet<[u8; 3]> = color.node("out").controls().iter().map(bits).collect();
    let all: BTreeSet<[u8; 3]> = (0..WIDTH * HEIGHT).map(|at| pixel(at % WIDTH, at / WIDTH)).collect();
    assert_eq!(found, all);
}

#[test]
fn what_is_repaired_counts_in_equal_rows_too() {
    let folder = tempfile::tempdir().unwrap();
    // Half of the rows sum to 0.7, in consecutive or in alternate rows.
    for is_off in [|y: usize| y < HEIGHT / 2, |y: usize| y.is_multiple_of(2)] {
        let rows = (0..HEIGHT).flat_map(|y| [if is_off(y) { [0.2, 0.5, 0.0] } else { [0.6, 0.4, 0.0] }; WIDTH]);
        let pixels: Vec<[f32; 3]> = rows.collect();
        let image = PngImage::new(WIDTH as u32, HEIGHT as u32, Samples::rgb(&pixels));
        write_png8(folder.path().join("a.png"), &image).unwrap();
        let knobs = r#""as": "weights", "channels": ["R", "G"], "repair": true, "fit": "crop""#;
        let node = format!(r#""out": {{ "type": "Read", "file": "a.png", {knobs} }}"#);
        let frame = Frame::held(graph("weights", &node, folder.path()).unwrap(), HOLDING).unwrap();
        assert_eq!(frame.node("out").repaired(), (WIDTH * HEIGHT / 2) as u64);
        for y in 0..3 {
            let expected = if is_off(y as usize) { 2.0 / 7.0 } else { 0.6 };
            assert!((value(&frame, 2, y) - expected).abs() < 3e-3, "row {y}");
        }
    }
}

#[test]
fn weights_are_parts_of_their_sum_before_they_are_rounded() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |x: usize| [x % 100, (3 * x) % 90, 65 + x % 3];
    let pixels: Vec<[f32; 3]> =
        (0..WIDTH * HEIGHT).map(|at| bytes(at % WIDTH).map(|byte| byte as f32 / 255.0)).collect();
    let image = PngImage::new(WIDTH as u32, HEIGHT as u32, Samples::rgb(&pixels));
    write_png8(folder.path().join("a.png"), &image).unwrap();
    for fit in ["nearest", "crop", "bilinear"] {
        let knobs = format!(r#""as": "weights", "channels": ["R", "G", "B"], "repair": true, "fit": "{fit}""#);
        let node = format!(r#""out": {{ "type": "Read", "file": "a.png", {knobs} }}"#);
        let frame = Frame::held(graph("weights", &node, folder.path()).unwrap(), HOLDING).unwrap();
        assert!(2 * frame.node("out").bytes() < 9 * WHOLE, "{fit}: not all is held");
        for x in 0..4 {
            let (truth, found) = (frame.truth([x as f64 + 0.5, 0.5]), frame.lowered([x as f64 + 0.5, 0.5]));
            assert!((truth.iter().sum::<f64>() - 1.0).abs() < 1e-15, "{fit}: {truth:?}");
            assert!(truth.iter().zip(&found).all(|(truth, found)| (truth - f64::from(*found)).abs() < 2e-7));
            let at = match fit {
                "nearest" => ((x as f64 + 0.5) * WIDTH as f64 / 4.0) as usize,
                _ => x as usize,
            };
            let stored = bytes(at).map(|byte| f64::from(byte as f32 / 255.0));
            let parts = stored.map(|weight| weight / stored.iter().sum::<f64>());
            assert!(fit == "bilinear" || truth.iter().zip(parts).all(|(truth, part)| (truth - part).abs() < 1e-15));
        }
    }
}

#[test]
fn what_will_be_held_is_told_beforehand() {
    let folder = tempfile::tempdir().unwrap();
    for knobs in [
        format!(r#"{RED}, "fit": "nearest""#),
        format!(r#"{RED}, "fit": "crop""#),
        r#""as": "color", "fit": "bilinear""#.into(),
        r#""as": "weights", "channels": ["R", "G", "B"], "repair": true, "fit": "nearest""#.into(),
        r#""as": "weights", "channels": ["R", "G"], "repair": true, "fit": "crop""#.into(),
    ] {
        let key = ["color", "weights", "field"].into_iter().find(|key| knobs.contains(key)).unwrap();
        let frame = frame(folder.path(), key, &knobs);
        let id = frame.graph.find("out").unwrap();
        let (node, wanted) = (frame.graph.settle(id, 1), [vec![true; frame.graph.node(id).kinds[0].channels()]]);
        let of = |_| MemoryUse::default();
        let taken = memory_of_read(&node, &MemoryContext::new(&frame.context, &wanted, &of), HOLDING).unwrap();
        assert_eq!(taken.held as usize, frame.node("out").bytes(), "{knobs}");
        assert!(taken.working < 2 << 20, "{taken:?}");
    }
}
