//! Operations of other compositors that leave the hull.

use super::{Bad, nodes};

pub(super) fn table() -> Vec<Bad> {
    let refused = |name: &'static str, ty: &str, faults| nodes(name, &format!(r#""a": {{ "type": "{ty}" }}"#), faults);
    vec![
        refused(
            "Plus",
            "Plus",
            &[&["bad.json:6:16: node \"a\", type", "the operation Plus", "sum to 2", "1.2", "remedy: Mix"]],
        ),
        refused("Minus", "Minus", &[&["the operation Minus", "−1", "darker control color"]]),
        refused("Gain", "Gain", &[&["the operation Gain", "leaves the palette", "brighter control color"]]),
        refused("Grade", "Grade", &[&["the operation Grade", "without limits", "other control colors"]]),
        refused("Over", "Over", &[&["the operation Over", "2 − α", "Stack for several layers"]]),
        refused("Merge", "merge", &[&["the operation merge", "Mix with `a` the background"]]),
        refused("Sharpen", "Sharpen", &[&["negative weights", "non-negative weights that sum to 1"]]),
        refused("Max", "Max", &[&["off the segment", "Mix with a mask"]]),
        refused("LumaKey", "LumaKey", &[&["more than linearly", "Clamp it to a mask"]]),
    ]
}
