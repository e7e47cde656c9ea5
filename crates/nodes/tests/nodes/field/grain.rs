//! Tests of Grain.

use crate::testing::{Frame, graph};
use std::path::Path;
use trochoid_image::Window;

/// All masks of a picture of 4 × 3 pixels, at many positions within its pixels.
fn masks(knobs: &str) -> Vec<(f32, f64)> {
    let nodes = format!(r#""out": {{ "type": "Grain", {knobs} }}"#);
    let frame = Frame::new(graph("weights", &nodes, Path::new(".")).unwrap()).unwrap();
    let id = frame.graph.find("out").unwrap();
    let places = (0..90).flat_map(|y| (0..120).map(move |x| [f64::from(x) / 30.0, f64::from(y) / 30.0]));
    places.map(|at| (frame.filled(id, 0, 0, at), frame.truth(at)[1])).collect()
}

#[test]
fn agrees_with_the_reference_and_lies_about_one_half() {
    for knobs in [
        r#""threads": 1.4"#,
        r#""threads": 1.2, "turn": 33, "slub": 1, "seed": 8"#,
        r#""kind": "paper", "threads": 1.4, "turn": -20"#,
    ] {
        let masks = masks(knobs);
        assert!(masks.iter().all(|(found, truth)| (f64::from(*found) - truth).abs() < 3e-6), "{knobs}");
        let mean = masks.iter().map(|(found, _)| f64::from(*found)).sum::<f64>() / masks.len() as f64;
        assert!((mean - 0.5).abs() < 0.08, "{knobs}: {mean}");
        let (low, high) = masks.iter().fold((1.0f32, 0.0f32), |(l, h), (m, _)| (l.min(*m), h.max(*m)));
        assert!(high - low > 0.25, "{knobs}: from {low} to {high}");
    }
}

#[test]
fn samples_side_by_side_have_the_bits_of_single_ones() {
    for knobs in [
        r#""threads": 1.31"#,
        r#""threads": 1.4, "slub": 0"#,
        r#""threads": 1, "turn": 90"#,
        r#""threads": 1.2, "turn": 33, "slub": 1"#,
        r#""kind": "paper", "threads": 1.1, "turn": -20"#,
    ] {
        let nodes = format!(r#""out": {{ "type": "Grain", {knobs} }}"#);
        let frame = Frame::new(graph("weights", &nodes, Path::new(".")).unwrap()).unwrap();
        let id = frame.graph.find("out").unwrap();
        let (window, offset) = (Window::new(3, 0, 70, 45), [0.375, 0.75]);
        let found = frame.filled_window(id, window, offset);
        for (index, found) in found.into_iter().enumerate() {
            let (x, y) = (3 + index % window.width(), index / window.width());
            let at = [x as f64 + offset[0], y as f64 + offset[1]];
            let single = frame.filled(id, 0, 0, at);
            assert_eq!(found.to_bits(), single.to_bits(), "{knobs} at {at:?}: {found}, not {single}");
        }
    }
}

#[test]
fn threads_finer_than_pixels_leave_nothing() {
    assert!(masks(r#""threads": 3"#).iter().all(|(found, truth)| *found == 0.5 && *truth == 0.5));
}
