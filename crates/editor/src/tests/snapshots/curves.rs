//! The curves panel.

use super::{center, compare, seen};
use crate::curves::{Curves, curves_ui};
use crate::state::State;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

/// A mask, a list and a color that are keyed.
const KEYED: &str = r##"{
  "trochoid": 1,
  "format": { "width": 48, "height": 27 },
  "frames": { "first": 1, "last": 24, "fps": 24 },
  "palette": { "glow": { "keys": [[1, "#d8513a"], [12, "#3a51d8"]] } },
  "nodes": {
    "sun": { "type": "Shape", "shapes": [{ "form": "disc", "radius": 0.2,
      "center": { "keys": [[1, [0.2, 0.5], { "out": [6, [0, 0.2]] }], [24, [1.2, 0.4], { "in": [-12, [-0.5, 0]] }]] } }] },
    "dusk": { "type": "Mix", "a": "palette.glow", "b": "#14262e", "weight": {
      "keys": [[1, 0.1], [9, 0.9, { "in": [-4, 0.05], "out": [6, -0.05] }], [20, 0.3, { "in": [-5, 0], "interpolation": "hold" }], [24, 0.6]],
      "interpolation": "monotone" } },
    "all": { "type": "Mix", "a": "dusk", "b": "#fff", "weight": "sun" }
  },
  "outputs": { "beauty": { "color": "all" } }
}"##;

fn state() -> State {
    let mut state = seen(KEYED);
    state.frame = 6;
    state
}

fn click(harness: &mut Harness<'_, (Curves, State)>, label: &str) {
    let at = center(harness, label);
    harness.hover_at(at);
    harness.run_steps(1);
    for pressed in [true, false] {
        let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
        harness.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
        harness.run_steps(1);
    }
}

#[test]
fn curves_with_the_handles_of_a_key() {
    compare("curves", [680.0, 320.0], state, Curves::default, curves_ui, |harness| {
        click(harness, "Key 9 of dusk.weight");
    });
}

#[test]
fn the_dope_sheet() {
    compare("dope_sheet", [680.0, 260.0], state, Curves::default, curves_ui, |harness| {
        harness.get_by_label("Dope sheet").click();
        harness.run_steps(3);
        click(harness, "sun");
    });
}
