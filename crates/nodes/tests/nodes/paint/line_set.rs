//! Tests of LineSet.

use crate::testing::{frame, refused};
use trochoid_nodes::inside::LineDrawing;

const LEAN: f64 = 0.1;
const LAG: f64 = 0.02;

fn drawing(widths: &[f64]) -> LineDrawing {
    let nodes = format!(
        r#""place": {{ "type": "FieldMath", "components": 2, "expression": "[0, 0]" }},
        "out": {{ "type": "LineSet", "place": "place", "widths": {widths:?}, "begin": [0, 0.3], "end": [0.6, 1.4],
            "head": 0.1, "tail": 0.8, "vary": 0.6, "jitter": 1, "lean": {LEAN}, "lag": {LAG}, "finest": 3, "seed": 3 }}"#
    );
    let frame = frame("weights", &nodes);
    LineDrawing::of(&frame.graph.settle(frame.graph.find("out").unwrap(), 1)).unwrap()
}

#[test]
fn hostile_places_have_masks_too() {
    let mut drawing = drawing(&[1.9, 1.0, 0.5, 0.1]);
    let hostile = [0.0, -0.0, 0.5, 1e-30, -3.7, 1e6, -1e18, f64::MAX, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for q in hostile {
        for v in hostile {
            for change in hostile.map(f64::abs) {
                for thickness in [0.0, 1e-30, 0.3, 1.0] {
                    drawing.forget();
                    let masks = drawing.masks([q, v], change, thickness);
                    assert!(masks.iter().all(|mask| (0.0..=1.0).contains(mask)), "{masks:?} at {q}, {v}, {change}");
                    assert!(thickness > 0.0 || masks == [0.0; 4]);
                }
            }
        }
    }
}

#[test]
fn no_line_is_missed_and_what_is_kept_of_neighbors_changes_nothing() {
    let widths = [1.6, 0.7];
    let [mut drawing, mut forgetful] = [(); 2].map(|()| drawing(&widths));
    let mut most: f64 = 0.0;
    for step in 0..12_000 {
        let place = [f64::from(step) * 0.00457 - 20.0, f64::from(step % 37) / 30.0];
        let (change, thickness) = ([0.02, 0.11, 1e-4][step as usize % 3], [1.0, 0.37, 1e-6][step as usize / 3 % 3]);
        let masks = drawing.masks(place, change, thickness);
        forgetful.forget();
        assert_eq!(masks, forgetful.masks(place, change, thickness));
        // Compare with all lines in a wide neighborhood, one by one.
        for (k, width) in widths.iter().enumerate() {
            let all = (-40..60).map(|index| {
                let [middle, factor, taper] = drawing.line(index, place[1] - k as f64 * LAG);
                let wide = width * factor * taper * thickness;
                let distance = (place[0] - k as f64 * LEAN - middle).abs();
                let drawn = wide.max(change);
                if wide > 0.0 { wide / drawn * (0.5 + (0.5 * drawn - distance) / change).clamp(0.0, 1.0) } else { 0.0 }
            });
            assert_eq!(masks[k], all.fold(0.0, f64::max), "{place:?}");
            most = most.max(masks[k]);
        }
    }
    assert_eq!(most, 1.0);
}

#[test]
fn places_have_two_components_and_widths_are_shares() {
    let nodes = r#""x": { "type": "ScreenX" }, "out": { "type": "LineSet", "place": "x", "widths": [0.5] }"#;
    assert!(refused("weights", nodes).contains("2 components"));
    let nodes = r#""x": { "type": "ScreenX" }, "p": { "type": "FieldMath", "a": "x", "components": 2,
        "expression": "[a, a]" }, "out": { "type": "LineSet", "place": "p", "widths": [0.5, 3] }"#;
    assert!(refused("weights", nodes).contains("from 0 to 2"));
}
