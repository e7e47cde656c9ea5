//! Values of formulas that are no numbers: the first of them is told with its pixel and its cause, whatever the tiles.

use crate::support::{graph, settings, variants};
use std::path::Path;
use trochoid::{Buffers, Cache, LoadError, Plan, Repair, Settings, Silent, parse};

#[test]
fn the_first_nan_is_told_with_its_pixel_and_its_cause() {
    let nodes = r#""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
        "low": { "type": "Clamp", "field": "y", "min": 0, "max": 0.5 },
        "bad": { "type": "FieldMath", "a": "x", "b": "low", "expression": "1 + (sqrt(0.9 - a - b) + log(1 + b))*2" },
        "good": { "type": "FieldMath", "a": "x", "expression": "sqrt(a)" }"#;
    let outputs = r#""bad": { "field": "bad" }, "good": { "field": "good" }"#;
    let graph = graph(r#""width": 20, "height": 16"#, nodes, outputs);
    let first = |settings: &Settings| -> Vec<Option<Repair>> {
        let plan = Plan::new(&graph, &[], 1, &[], settings).unwrap();
        let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
        let of = |name: &str| frame.nodes.iter().find(|node| node.name == name).unwrap().first_repaired.clone();
        vec![of("bad"), of("good")]
    };
    let plain = first(&settings(|_| ()));
    let [Some(bad), None] = &plain[..] else { panic!("{plain:?}") };
    // The picture's first row is y = 0, where the formula fails from x = 0.9 on: the 18th of 20 pixels is at 17/19.
    assert_eq!(bad.pixel, [18, 0]);
    assert_eq!(bad.cause, format!("sqrt(0.9 - a - b) with a = {}, b = 0", f64::from(18.0_f32 / 19.0)));
    for (what, settings) in variants() {
        assert_eq!(first(&settings), plain, "{what}");
    }
}

#[test]
fn links_tell_the_part_that_fails() {
    let text = |value: &str| {
        format!(
            r##"{{ "trochoid": 1, "format": {{ "width": 8, "height": 8 }}, "frames": {{ "first": 1, "last": 9 }},
                "nodes": {{ "x": {{ "type": "ScreenX" }},
                            "c": {{ "type": "Clamp", "field": "x", "min": 0.5, "max": "{value}" }},
                            "m": {{ "type": "Mix", "a": "#123", "b": "#fed", "weight": "c" }} }},
                "outputs": {{ "o": {{ "color": "m" }} }} }}"##
        )
    };
    let faults = |value: &str| match parse("a.json", &text(value), Path::new("."), &[]) {
        Err(LoadError::Invalid(faults)) => faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"),
        other => panic!("{other:?}"),
    };
    let found = faults("= 1 + (2/(frame - 3))*c.min");
    assert!(found.contains("inf at frame 3, the value of"), "{found}");
    assert!(found.contains("because of \"(2/(frame - 3))\""), "{found}");
    assert!(found.contains("frame is 3, c.min is 0.5"), "{found}");
    let found = faults("= sqrt(1 - frame)");
    assert!(found.contains("NaN at frame 2") && !found.contains("because of"), "{found}");
}
