//! Buffers that break the contract of their kind are refused by name, channel and sample.

use super::pixels::{HEIGHT, WIDTH};
use crate::support::{graph, settings};
use trochoid::{Buffers, Cache, EvalError, Plan, PlanError, Silent};

const NODES: &str = r##"
    "c": { "type": "Constant", "color": "#fff" },
    "m": { "type": "ScreenX" },
    "w": { "type": "Stack", "weights": ["m", 0.5] },
    "f": { "type": "ScreenY" },
    "t": { "type": "Clamp", "field": "f" },
    "mixed": { "type": "Mix", "a": "c", "b": "#000", "weight": "t" },
    "out": { "type": "Blend", "colors": ["c", "mixed", "#123456"], "weights": "w" },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
    "camera": { "type": "Camera" }, "sea": { "type": "GerstnerSea", "count": 0 },
    "depth": { "type": "Depth", "view": "view" }, "far": { "type": "Clamp", "field": "depth" }"##;
const OUTPUTS: &str = r#""out": { "color": "out" }, "far": { "weights": "far" }"#;

fn message(node: &str, planes: &[&[f32]]) -> String {
    let graph = graph(&format!(r#""width": {WIDTH}, "height": {HEIGHT}"#), NODES, OUTPUTS);
    let buffers = Buffers::new().with(node, planes);
    let plan = Plan::new(&graph, &[], 1, &[node], &settings(|_| ())).unwrap();
    match plan.evaluate(&buffers, &mut Cache::new(), &Silent) {
        Err(error @ EvalError::Buffer { .. }) => error.to_string(),
        other => panic!("accepted: {:?}", other.map(|_| ())),
    }
}

#[test]
fn illegal_values_are_refused_with_their_place() {
    let fine = [0.25f32; WIDTH * HEIGHT];
    let with = |at: usize, value: f32| {
        let mut plane = fine;
        plane[at] = value;
        plane
    };
    let cases: &[(&str, usize, usize, f32)] = &[
        ("c", 0, 7, f32::NAN),
        ("c", 1, 0, -1e-45),
        ("c", 2, 47, f32::INFINITY),
        ("m", 0, 13, f32::NAN),
        ("m", 0, 5, 1.0f32.next_up()),
        ("m", 0, 6, -f32::MIN_POSITIVE),
        ("w", 2, 9, f32::NAN),
        ("w", 0, 10, -0.5),
        ("depth", 0, 31, f32::NAN),
    ];
    for &(node, channel, at, value) in cases {
        let count = match node {
            "c" | "w" => 3,
            _ => 1,
        };
        let bad = with(at, value);
        let planes: Vec<&[f32]> = (0..count).map(|c| if c == channel { &bad[..] } else { &fine[..] }).collect();
        let text = message(node, &planes);
        let place = [format!("\"{node}\""), format!("channel {channel}"), format!("sample {at}")];
        assert!(place.iter().all(|part| text.contains(part)), "{node}: {text}");
    }
}

#[test]
fn weights_that_do_not_sum_to_one_are_refused() {
    let (third, quarter) = ([1.0f32 / 3.0; WIDTH * HEIGHT], [0.25f32; WIDTH * HEIGHT]);
    let mut short = third;
    short[17] = 0.25;
    assert!(message("w", &[&third, &short, &third]).contains("sample 17 sum to"), "one sample is short");
    assert!(message("w", &[&quarter, &quarter, &quarter]).contains("sample 0 sum to 0.75"));
}

#[test]
fn buffers_of_another_shape_are_refused() {
    let plane = [0.5f32; WIDTH * HEIGHT];
    assert!(message("c", &[&plane]).contains("found 1 channels; a Color has 3"));
    assert!(message("m", &[&plane[1..]]).contains("channel 0 has 47 samples; expected 48"));
}

#[test]
fn only_pictures_of_the_graph_are_bound() {
    let graph = graph(r#""width": 2, "height": 2"#, NODES, OUTPUTS);
    for (name, reason) in [("nobody", "no node has that name"), ("view", "bind the passes instead"), ("sea", "bind")] {
        match Plan::new(&graph, &[], 1, &[name], &settings(|_| ())) {
            Err(error @ PlanError::Binding { .. }) => {
                let text = error.to_string();
                assert!(text.contains(name) && text.contains(reason), "{text}");
            }
            other => panic!("{name}: {:?}", other.map(|_| ())),
        }
    }
    let plan = Plan::new(&graph, &[], 1, &["m"], &settings(|_| ())).unwrap();
    let error = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).err().unwrap();
    assert!(error.to_string().contains("\"m\": no buffer is given"), "{error}");
}
