//! Expensive branches behind a mask are skipped where the mask is 0 or 1; the pictures stay bit-identical.

use crate::support::{bits, evaluate, graph, settings, under_all_settings};
use trochoid::Buffers;

/// Wide enough for chunks without weight, chunks with weight, and an incomplete chunk.
const FORMAT: &str = r#""width": 700, "height": 3"#;

/// A chain of `count` mixes from `first` to the node `{name}{count - 1}`; its masks vary over all pixels.
fn chain(name: &str, first: &str, count: usize) -> String {
    let mut nodes = Vec::new();
    let mut before = first.to_string();
    for i in 0..count {
        let weight = if i % 2 == 0 { "slope" } else { "down" };
        let color = format!("#{:06x}", (i * 0x3a_51f7 + 0x11_2233) & 0xff_ffff);
        nodes.push(format!(
            r#""{name}{i}": {{ "type": "Mix", "a": "{before}", "b": "{color}", "weight": "{weight}" }}"#
        ));
        before = format!("{name}{i}");
    }
    nodes.join(",\n")
}

const MASKS: &str = r#""across": { "type": "ScreenX" }, "down": { "type": "ScreenY" },
    "slope": { "type": "Multiply", "weights": ["across", "down"] },
    "tall": { "type": "Invert", "weight": "slope" },
    "right": { "type": "Clamp", "field": "slope", "min": 0.45, "max": 0.55 },
    "left": { "type": "Clamp", "field": "tall", "min": 0.2, "max": 0.3 }"#;

#[test]
fn skipped_branches_change_no_bit() {
    let cases = [
        // Skipped where the mask is 0, and where it is 1.
        r#""out": { "type": "Mix", "a": "base0", "b": "far39", "weight": "right" }"#,
        r#""out": { "type": "Mix", "a": "far39", "b": "base0", "weight": "left" }"#,
        // One branch within the other.
        r#""inner": { "type": "Mix", "a": "far39", "b": "near29", "weight": "left" },
           "out": { "type": "Mix", "a": "base0", "b": "inner", "weight": "right" }"#,
        // Part of the branch is needed outside of it as well, before and after.
        r##""first": { "type": "Mix", "a": "far9", "b": "#fff", "weight": "down" },
           "gated": { "type": "Mix", "a": "first", "b": "far39", "weight": "right" },
           "out": { "type": "Mix", "a": "gated", "b": "far5", "weight": "left" }"##,
        // The other side is a constant.
        r##""out": { "type": "Mix", "a": "#884422", "b": "far39", "weight": "right" }"##,
    ];
    for case in cases {
        let nodes =
            [MASKS, &chain("base", "#102030", 1), &chain("far", "#405060", 40), &chain("near", "#708090", 30), case];
        let graph = graph(FORMAT, &nodes.join(",\n"), r#""out": { "color": "out" }"#);
        let frame = under_all_settings(&graph, 1, &Buffers::new(), case);
        assert_eq!(frame.pictures[0].audit.hull_exits, 0);
    }
}

#[test]
fn a_branch_that_is_an_output_too_is_computed_everywhere() {
    let nodes = [
        MASKS,
        &chain("base", "#102030", 1),
        &chain("far", "#405060", 40),
        r#""out": { "type": "Mix", "a": "base0", "b": "far39", "weight": "right" }"#,
    ];
    let both = graph(FORMAT, &nodes.join(",\n"), r#""out": { "color": "out" }, "far": { "color": "far39" }"#);
    let frame = under_all_settings(&both, 1, &Buffers::new(), "both");
    let alone = graph(FORMAT, &nodes.join(",\n"), r#""far": { "color": "far39" }"#);
    let far = evaluate(&alone, 1, &Buffers::new(), &settings(|_| ()));
    assert!(bits(&frame.pictures[1]) == bits(&far.pictures[0]));
}
