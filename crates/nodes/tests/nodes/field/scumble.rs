//! Tests of Scumble.

use crate::testing::{frame, refused};
use trochoid_graph::Reference;

#[test]
fn paint_needs_density_and_closes_with_it() {
    let nodes = r#""density": { "type": "ScreenX" }, "noise": { "type": "FieldMath", "expression": "0" },
        "out": { "type": "Scumble", "density": "density", "noise": "noise" }"#;
    let frame = frame("weights", nodes);
    let paint = |density: f64, noise: f64| {
        frame.mask_of(&|name| match name {
            "density" => Reference::Mask(density),
            _ => Reference::Field(vec![noise]),
        })
    };
    for noise in [-1e30, -1.0, 0.0, 0.3, 0.58, 1.0, 1e30, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(paint(0.0, noise), 0.0);
        let mut last = 0.0;
        for density in 0..=100 {
            let mask = paint(f64::from(density) / 100.0, noise);
            assert!((0.0..=1.0).contains(&mask) && mask >= last, "{mask} after {last} at {density} of {noise}");
            last = mask;
        }
    }
    assert_eq!(paint(1.0, 0.58), 1.0, "dense paint is closed at the grain's middle");
    assert!(paint(0.3, 0.9) > 0.2 && paint(0.3, 0.4) == 0.0, "thin paint is in flecks");
}

#[test]
fn edges_run_upward() {
    let nodes = r#""out": { "type": "Scumble", "density": 0.5, "noise": 0.5, "from": 1, "to": 0 }"#;
    assert!(refused("weights", nodes).contains("0 below from"));
}
