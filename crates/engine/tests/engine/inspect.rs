//! Tests of a pixel's blame: shares sum to 1 and mix to the color that the picture shows.

use crate::{filters, nodes as types};
use proptest::prelude::*;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use trochoid_engine::{Blame, Buffers, Cache, InspectedPixel, Monitor, Plan, Settings, Silent};
use trochoid_graph::*;
use trochoid_image::Window;

const COLORS: [[f64; 3]; 4] = [[0.0, 0.5, 1.0], [1.0, 0.25, 0.0], [0.125, 0.75, 0.5], [0.5, 0.5, 0.5]];

/// Makes a graph of 31 by 5 pixels with these nodes beside a slope and its mask, and an output of the last node.
fn graph(samples: u32, nodes: &[(String, String)]) -> CheckedGraph {
    let body: Vec<String> = nodes.iter().map(|(name, body)| format!("\"{name}\": {body}")).collect();
    let text = format!(
        r##"{{ "trochoid": 1, "format": {{ "width": 31, "height": 5, "samples": {samples} }},
        "nodes": {{ "slope": {{ "type": "Slope" }}, "gate": {{ "type": "Gate", "field": "slope" }}, {} }},
        "outputs": {{ "last": {{ "color": "{}" }}, "mask": {{ "weights": "gate" }}, "field": {{ "field": "slope" }} }} }}"##,
        body.join(", "),
        nodes.last().unwrap().0
    );
    let document = Document::parse("test", &text).unwrap();
    let (graph, diagnostics) =
        check(&document, &Registry::new(types::TYPES.iter().chain(&filters::TYPES)), Path::new("."));
    graph.unwrap_or_else(|| panic!("{diagnostics:?}"))
}

/// Makes nodes from random numbers: mixes, blends of three and filters, each of colors and of earlier nodes.
fn nodes(dice: &[(u8, usize, usize)]) -> Vec<(String, String)> {
    let mut nodes: Vec<(String, String)> = Vec::new();
    for (index, &(kind, a, b)) in dice.iter().enumerate() {
        let source = |at: usize| match at % (COLORS.len() + index) {
            color if color < COLORS.len() => format!("{:?}", COLORS[color]),
            node => format!("\"n{}\"", node - COLORS.len()),
        };
        let (a, b) = (source(a), source(b));
        let body = match kind % 5 {
            0 | 1 => format!(r#"{{ "type": "Mix", "a": {a}, "b": {b}, "weight": "gate" }}"#),
            // Constants are folded, and inputs without weight are left out.
            2 => format!(r#"{{ "type": "Mix", "a": {a}, "b": {b}, "weight": {} }}"#, f64::from(kind % 3) / 2.0),
            3 => format!(r#"{{ "type": "Thirds", "colors": [{a}, {b}, [0.25, 0, 0.125]], "weight": "gate" }}"#),
            _ => format!(r#"{{ "type": "Smear", "image": {a} }}"#),
        };
        nodes.push((format!("n{index}"), body));
    }
    nodes
}

fn inspect(plan: &Plan<'_>, output: usize, pixel: [i64; 2]) -> InspectedPixel {
    plan.inspect(output, pixel, &Buffers::new(), &mut Cache::new(), &Silent).unwrap().unwrap()
}

fn mixed(blame: &[Blame]) -> [f64; 3] {
    [0, 1, 2].map(|c| blame.iter().map(|share| share.weight * share.color[c]).sum())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn shares_sum_to_one_and_mix_to_the_picture(
        dice in prop::collection::vec((0u8..30, 0usize..1000, 0usize..1000), 1..9),
        samples in prop::sample::select(vec![1u32, 4]),
        region in prop::sample::select(vec![None, Some(Window::new(9, 1, 22, 4))]),
    ) {
        let graph = graph(samples, &nodes(&dice));
        let mut settings = Settings::default();
        settings.region = region;
        let plan = Plan::new(&graph, &[], 1, &[], &settings).unwrap();
        let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
        for [x, y] in [[9, 1], [13, 2], [15, 3], [21, 3]] {
            for picture in &frame.pictures {
                let found = inspect(&plan, picture.output, [x, y]);
                prop_assert_eq!(found.value.len(), picture.planes.len());
                for (plane, value) in picture.planes.iter().zip(&found.value) {
                    prop_assert!((f64::from(plane.nearest(x, y)) - value).abs() < 1e-5);
                }
                if picture.kind != Kind::Color {
                    prop_assert_eq!(&found.blame, &[]);
                    continue;
                }
                let sum: f64 = found.blame.iter().map(|share| share.weight).sum();
                prop_assert!((sum - 1.0).abs() < 1e-12, "{}", sum);
                prop_assert!(found.blame.iter().all(|share| share.weight > 0.0));
                prop_assert!(found.blame.is_sorted_by(|a, b| a.weight >= b.weight));
                for (value, mixed) in found.value.iter().zip(mixed(&found.blame)) {
                    prop_assert!((value - mixed).abs() < 1e-12);
                }
            }
        }
    }
}

#[test]
fn shares_name_nodes_and_colors_once() {
    let nodes = [
        ("first", r#"{ "type": "Mix", "a": [0, 0, 0], "b": [1, 0, 0], "weight": 0.25 }"#),
        ("again", r#"{ "type": "Mix", "a": "first", "b": [1, 0, 0], "weight": 0.5 }"#),
        ("last", r#"{ "type": "Mix", "a": "again", "b": "first", "weight": 0.5 }"#),
    ];
    let graph = graph(4, &nodes.map(|(name, body)| (name.into(), body.into())));
    let plan = Plan::new(&graph, &["last"], 1, &[], &Settings::default()).unwrap();
    let found = inspect(&plan, 0, [3, 3]);
    let named: Vec<_> = found.blame.iter().map(|b| (graph.node(b.node).name.as_str(), b.color[0], b.weight)).collect();
    // Optimizations fold all of this into one constant; the document has three controls.
    assert_eq!(named, [("first", 0.0, 0.5625), ("again", 1.0, 0.25), ("first", 1.0, 0.1875)]);
}

#[test]
fn a_filter_is_a_control_of_its_own() {
    let nodes = nodes(&[(0, 0, 1), (4, 4, 0), (0, 5, 2)]);
    let graph = graph(1, &nodes);
    let plan = Plan::new(&graph, &["last"], 1, &[], &Settings::default()).unwrap();
    let found = inspect(&plan, 0, [14, 2]);
    let names: Vec<&str> = found.blame.iter().map(|share| graph.node(share.node).name.as_str()).collect();
    assert_eq!((names.len(), names.contains(&"n1"), names.contains(&"n2")), (2, true, true), "{names:?}");
}

#[test]
fn only_pixels_of_planned_pictures_are_inspected() {
    let graph = graph(1, &nodes(&[(0, 0, 1)]));
    let plan = Plan::new(&graph, &["last"], 1, &[], &Settings::default()).unwrap();
    let at = |output, pixel| plan.inspect(output, pixel, &Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    assert!(at(0, [30, 4]).is_some());
    for (output, pixel) in [(1, [0, 0]), (0, [31, 4]), (0, [-1, 0]), (0, [i64::MAX, 0])] {
        assert_eq!(at(output, pixel), None);
    }
}

#[test]
fn what_the_cache_holds_is_not_prepared_again() {
    #[derive(Default)]
    struct Counting(AtomicUsize);
    impl Monitor for Counting {
        fn preparing(&self, _node: &str) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }
    let graph = graph(4, &nodes(&[(0, 0, 1), (4, 4, 0), (0, 5, 2)]));
    let plan = Plan::new(&graph, &["last"], 1, &[], &Settings::default()).unwrap();
    let (mut cache, counting) = (Cache::new(), Counting::default());
    plan.evaluate(&Buffers::new(), &mut cache, &counting).unwrap();
    let prepared = counting.0.load(Ordering::Relaxed);
    assert_eq!(prepared, 2);
    plan.inspect(0, [4, 4], &Buffers::new(), &mut cache, &counting).unwrap();
    assert_eq!(counting.0.load(Ordering::Relaxed), prepared);
}

#[test]
fn bound_colors_are_controls_of_their_nodes() {
    let graph = graph(1, &nodes(&[(0, 0, 1), (0, 4, 2)]));
    let plan = Plan::new(&graph, &["last"], 1, &["n0"], &Settings::default()).unwrap();
    let planes: Vec<Vec<f32>> = (0..3).map(|c| vec![0.25 * c as f32; 31 * 5]).collect();
    let buffers = Buffers::new().with("n0", &[&planes[0], &planes[1], &planes[2]]);
    let found = plan.inspect(0, [12, 2], &buffers, &mut Cache::new(), &Silent).unwrap().unwrap();
    let own = found.blame.iter().find(|share| graph.node(share.node).name == "n0").unwrap();
    assert_eq!(own.color, [0.0, 0.25, 0.5]);
}
