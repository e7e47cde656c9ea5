//! Any text as a formula of FieldMath: checked, and evaluated if it is accepted.
#![no_main]

use libfuzzer_sys::fuzz_target;
use serde_json::json;

fuzz_target!(|bytes: &[u8]| {
    let Ok(expression) = std::str::from_utf8(bytes) else { return };
    let document = json!({
        "trochoid": 1, "format": { "width": 8, "height": 8 },
        "nodes": {
            "x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
            "out": { "type": "FieldMath", "expression": expression, "a": "x", "b": "y", "c": "x", "d": "y" },
        },
        "outputs": { "out": { "field": "out" } },
    });
    if let Ok(loaded) = trochoid::parse("a.json", &document.to_string(), trochoid_fuzz::folder(), &[]) {
        trochoid_fuzz::evaluate(&loaded.graph);
    }
});
