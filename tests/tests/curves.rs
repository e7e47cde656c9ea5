//! Curves with handles: links follow them, at another size they keep within ranges, and faults name the frame.

use crate::support::graph_in;
use std::path::Path;
use trochoid::{CheckedGraph, LoadError, parse};

/// A cut that rises late, goes beyond its second key, and falls in an arc.
const CURVE: &str = r#"{ "keys": [[1, 0, { "out": [6, 0] }], [9, 1, { "in": [-2, 0.4], "out": [2, -0.4] }], [20, -0.5]],
    "interpolation": "monotone" }"#;

/// Returns a graph of clamps with these values of `min`, below a value of `max` that is far.
fn graph(more: &str, values: &[&str]) -> CheckedGraph {
    let clamp = |(index, value): (usize, &&str)| {
        format!(r#""n{index}": {{ "type": "Clamp", "field": "x", "min": {value}, "max": 9 }}"#)
    };
    let nodes: Vec<String> = values.iter().enumerate().map(clamp).collect();
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 4 }}, "frames": {{ "first": 1, "last": 24 }}, {more}
            "nodes": {{ "x": {{ "type": "ScreenX" }}, {} }}, "outputs": {{ "out": {{ "weights": "n0" }} }} }}"#,
        nodes.join(", ")
    );
    graph_in(Path::new("."), &text)
}

fn value(graph: &CheckedGraph, node: &str, frame: i64) -> f64 {
    graph.settle(graph.find(node).unwrap(), frame).number("min")
}

#[test]
fn links_and_formulas_follow_a_curve() {
    let knobs = format!(r#""knobs": {{ "cut": {{ "value": {CURVE}, "min": -1, "max": 2 }} }},"#);
    let graph = graph(&knobs, &[CURVE, r#""= n0.min""#, r#""= knobs.cut""#, r#""= 2 * n0.min""#]);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for frame in 0..=24 {
        let [own, linked, knob, doubled] = ["n0", "n1", "n2", "n3"].map(|node| value(&graph, node, frame));
        assert_eq!([own, own], [linked, knob], "frame {frame}");
        assert_eq!(doubled, 2.0 * value(&graph, "n0", frame.clamp(1, 24)), "frame {frame}");
        (least, most) = (least.min(own), most.max(own));
    }
    assert!(most > 1.02, "it goes beyond its keys: {most}");
    assert_eq!([0, 1, 9, 20, 24].map(|frame| value(&graph, "n0", frame)), [0.0, 0.0, 1.0, -0.5, -0.5]);
}

#[test]
fn a_curve_keeps_its_shape_at_another_size_and_stays_within_the_range() {
    let text = r##"{ "trochoid": 1, "format": { "width": 64, "height": 32 }, "frames": { "first": 1, "last": 24 },
        "nodes": { "c": { "type": "Constant", "color": "#fff" },
            "b": { "type": "Blur", "image": "c", "size": { "keys": [[1, 1, { "out": [8, -1] }], [24, 4, { "in": [-9, 6] }]] } } },
        "outputs": { "out": { "color": "b" } } }"##;
    let whole = graph_in(Path::new("."), text);
    let half = whole.clone().with_scaled_format(trochoid::Format::new(32, 16, 1).unwrap());
    let radius = |graph: &CheckedGraph, frame: i64| graph.settle(graph.find("b").unwrap(), frame).number("size");
    for frame in 1..=24 {
        let [a, b] = [&whole, &half].map(|graph| radius(graph, frame));
        assert!((a - 2.0 * b).abs() < 1e-9, "{a} and {b} at frame {frame}");
        assert!(b >= 0.0);
    }
}

#[test]
fn a_curve_beyond_the_range_of_a_knob_of_a_group_is_told() {
    let text = |keys: &str| {
        format!(
            r##"{{ "trochoid": 1, "format": {{ "width": 4, "height": 4 }}, "frames": {{ "first": 1, "last": 24 }},
                "groups": {{ "G": {{ "knobs": {{ "k": {{ "default": 0.5, "min": 0, "max": 1 }} }},
                    "nodes": {{ "x": {{ "type": "ScreenX" }}, "c": {{ "type": "Clamp", "field": "x", "min": "= knobs.k", "max": 9 }} }},
                    "outputs": {{ "o": "c" }} }} }},
                "nodes": {{ "g": {{ "type": "G", "k": {{ "keys": {keys} }} }} }}, "outputs": {{ "out": {{ "weights": "g" }} }} }}"##
        )
    };
    let found = |keys: &str| match parse("a.json", &text(keys), Path::new("."), &[]) {
        Err(LoadError::Invalid(faults)) => faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"),
        Ok(_) => String::new(),
        Err(other) => panic!("{other}"),
    };
    assert_eq!(found(r#"[[1, 0], [9, 1, { "in": [-4, 0] }]]"#), "");
    let told = found(r#"[[1, 0], [9, 1, { "in": [-4, 1] }]]"#);
    assert!(told.contains("between keys; expected a number from 0 to 1") && told.contains("at frame"), "{told}");
}
