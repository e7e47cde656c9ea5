//! Tests of Shape.

use crate::testing::{frame, refused};
use trochoid_graph::{Block, Inputs, Outputs};
use trochoid_image::Window;

#[test]
fn shapes_agree_with_the_reference_wherever_they_lie() {
    let shapes = [
        r#"{ "center": [0.4, 0.5], "radius": 0.3 }"#,
        r#"{ "form": "box", "center": [1.1, 0.4], "size": [0.5, 0.3], "corner": 0.1, "angle": 30 }"#,
        r#"{ "form": "box", "center": [-4, 9], "size": [8, 0.2], "angle": -63 }"#,
        r#"{ "form": "polygon", "center": [0.6, 0.5], "angle": 20,
            "points": [-0.5, -0.4, 0.5, 0.4, 0.5, -0.4, -0.5, 0.4] }"#,
        r#"{ "form": "polygon", "points": [0, 0, 0, 0, 0, 0] }"#,
        r#"{ "center": [3e38, -3e38], "angle": 10, "radius": 1000 }"#,
    ];
    let mut lists: Vec<String> = shapes.iter().map(|shape| (*shape).to_string()).collect();
    lists.push(shapes.join(", "));
    for list in lists {
        for edge in ["0", "0.5", "1", "7"] {
            let frame =
                frame("weights", &format!(r#""out": {{ "type": "Shape", "edge": {edge}, "shapes": [{list}] }}"#));
            let id = frame.graph.find("out").unwrap();
            for (x, y) in (0..24).flat_map(|y| (0..32).map(move |x| (x, y))) {
                let at = [f64::from(x) / 8.0 + 0.07, f64::from(y) / 8.0 + 0.03];
                let (found, truth) = (frame.filled(id, 0, 0, at), frame.truth(at)[1]);
                assert!((f64::from(found) - truth).abs() < 1e-6, "{list} at {at:?}: {found}, expected {truth}");
            }
        }
    }
}

#[test]
fn rows_of_polygons_agree_with_the_reference() {
    let star = "0, -6, 1, 4, -5, -2, 5, -2, -1, 4, 8, 8, -8, 8, 8, 7.9";
    let comb = "-9, 6, -9, -6, -8, 5, -7, -6, -6.9, 5, 0, -5.5, 0.1, 5, 9, -6, 9, -6, 9, 6";
    for (points, angle, edge) in [star, comb]
        .iter()
        .flat_map(|p| [0, 33, 90, 181].map(|a| (p, a)))
        .flat_map(|(p, a)| [0, 1, 9].map(|e| (p, a, e)))
    {
        let shape = format!(
            r#""out": {{ "type": "Shape", "edge": {edge}, "shapes": [{{ "form": "polygon", "center": [9.3, 6.1],
                "angle": {angle}, "points": [{points}] }}] }}"#
        );
        let frame = frame("weights", &shape);
        let block = Block::of(Window::new(-7, -5, 70, 45), [0.27, 0.81]);
        let mut plane = vec![f32::NAN; block.window.area()];
        let outputs = Outputs::new([[Some(&mut plane[..])]]);
        frame.node("out").fill(&block, &Inputs::new(&[]), &mut { outputs }).unwrap();
        let places = (-5..45).flat_map(|y| (-7..70).map(move |x| [f64::from(x) + 0.27, f64::from(y) + 0.81]));
        for (found, at) in plane.iter().zip(places) {
            let truth = frame.truth(at)[1];
            assert!((f64::from(*found) - truth).abs() < 1e-6, "{shape} at {at:?}: {found}, expected {truth}");
        }
    }
}

#[test]
fn bad_corners_are_refused() {
    let of = |shape: &str| refused("weights", &format!(r#""out": {{ "type": "Shape", "shapes": [{shape}] }}"#));
    assert!(of(r#"{ "form": "polygon" }"#).contains("0 numbers as points of shapes[0]"));
    assert!(of(r#"{ "form": "polygon", "points": [0, 0, 1, 0, 1, 1, 0] }"#).contains("7 numbers"));
    assert!(of(r#"{ "form": "box", "size": [1, -1] }"#).contains("negative size"));
}
