//! Parts of the editor as they are drawn, compared with pictures beside this file.
//!
//! wgpu draws them and needs a graphics driver; Mesa's software driver is enough (Debian: mesa-vulkan-drivers). So they
//! run only on request:
//!
//! ```text
//! cargo test -p trochoid-editor --lib -- --ignored snapshots
//! ```
//!
//! If one differs, `snapshots/<name>.diff.png` shows the difference, and `<name>.new.png` what was drawn. The same
//! command with `UPDATE_SNAPSHOTS=1` stores what is drawn; look at the pictures before you commit them.

use super::DUSK;
use crate::actions::Action;
use crate::canvas::{Canvas, canvas_ui};
use crate::document::Session;
use crate::editor::Editor;
use crate::properties::{Properties, properties_ui};
use crate::state::State;
use crate::testing::{finished, sized, until};
use crate::viewer::{Viewer, viewer_ui};
use egui::{Theme, Ui};
use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, SnapshotOptions, SnapshotResults};

/// Nodes of each kind at fixed positions; the output does not need those of the scene.
const KINDS: &str = r##"{
  "trochoid": 1,
  "format": { "width": 48, "height": 27 },
  "working_space": "srgb",
  "frames": { "first": 1, "last": 24, "fps": 24 },
  "nodes": {
    "down": { "type": "ScreenY" },
    "curved": { "type": "FieldMath", "expression": "a*a", "a": "down" },
    "band": { "type": "Clamp", "field": "curved", "min": 0, "max": { "keys": [[1, 1], [9, 2], [24, 1.5]], "interpolation": "monotone" } },
    "sky": { "type": "Ramp", "weight": "band", "stops": [
      { "at": 0, "color": "#2d3f52" }, { "at": 0.4, "color": "#b98a63" }, { "at": 1, "color": "#f0cf8e" }
    ] },
    "dusk": { "type": "Mix", "a": "sky", "b": "#14262e", "weight": 0.25 },
    "eye": { "type": "Camera", "position": [0, 6, 20] },
    "sun": { "type": "Light", "direction": [0.2, 0.5, -1] },
    "storm": { "type": "GerstnerSea", "count": 4 },
    "view": { "type": "Render", "camera": "eye", "surfaces": ["storm"] },
    "lit": { "type": "NonSpecular", "view": "view", "lights": ["sun"] }
  },
  "outputs": { "beauty": { "color": "dusk", "file": "dusk.####.png" } },
  "ui": {
    "positions": {
      "down": [0, 0], "curved": [0, 140], "band": [0, 280], "sky": [150, 280], "dusk": [150, 420], "off": [0, 420],
      "eye": [340, 0], "storm": [480, 0], "sun": [620, 0], "view": [410, 100], "lit": [520, 240],
      "bad": [340, 400], "under": [520, 400]
    },
    "backdrops": { "scene": { "at": [320, -50], "size": [440, 400], "text": "The scene", "tint": 5 } }
  }
}
"##;

/// Returns the state of an open document with its thumbnails, except those of the scene. Every node has taken a
/// millisecond, because measured times differ from run to run.
fn seen(text: &str) -> State {
    let mut window = sized(Session::new(text.into(), None), None, [800.0, 600.0]);
    finished(&mut window);
    until(&mut window, "thumbnails", |editor| !editor.state().evaluated.thumbnails.is_empty());
    let editor: Editor = window.into_state().unwrap();
    let mut state = editor.state;
    let plane = ["down", "curved", "band", "sky", "dusk"];
    state.evaluated.thumbnails.retain(|name, _| plane.contains(&name.as_str()));
    state.evaluated.nodes.values_mut().for_each(|node| node.seconds = 1e-3);
    state
}

/// Draws a part of the editor in both themes, and compares; `before` acts on the part after its first frames.
fn compare<P: 'static>(
    name: &str,
    size: [f32; 2],
    state: impl Fn() -> State,
    part: impl Fn() -> P,
    draw: fn(&mut P, &mut Ui, &State, &mut Vec<Action>),
    before: impl Fn(&mut Harness<'_, (P, State)>),
) {
    let mut results = SnapshotResults::new();
    for theme in [Theme::Dark, Theme::Light] {
        let ui = move |ui: &mut Ui, (part, state): &mut (P, State)| {
            // The background that panels have in the window.
            egui::Frame::new().inner_margin(6).fill(ui.visuals().panel_fill).show(ui, |ui| {
                ui.set_min_size(ui.available_size());
                draw(part, ui, state, &mut Vec::new());
            });
        };
        let builder = Harness::builder().with_size(size).with_step_dt(0.1).with_theme(theme).wgpu();
        let mut harness = builder.build_ui_state(ui, (part(), state()));
        crate::theme::install(&harness.ctx);
        harness.run_steps(4);
        before(&mut harness);
        harness.run_steps(8);
        // Drivers round colors and edges differently: a few 8-bit steps at a few pixels, which nobody sees.
        let options = SnapshotOptions::new().output_path("src/tests/snapshots").threshold(8.0).max_failed_pixels(10);
        harness.snapshot_options(format!("{name}_{theme:?}").to_lowercase(), &options);
        results.extend(harness.take_snapshot_results());
    }
}

#[test]
#[ignore = "needs a graphics driver"]
fn the_graph() {
    let faulty = KINDS.replace(
        r#""eye": {"#,
        r#""off": { "type": "Invert", "weight": "band", "disabled": true },
    "bad": { "type": "Mix", "a": "nothing", "b": "dusk", "weight": "band" },
    "under": { "type": "Mix", "a": "bad", "b": [0.4, 0.1, 0.1], "weight": "lit" },
    "eye": {"#,
    );
    let state = || {
        let mut state = seen(KINDS);
        state.session.replace(&faulty, "Edit the text");
        state.selection = ["curved".to_string()].into();
        state.look.slots[1] = Some("band".into());
        state
    };
    compare("graph", [760.0, 560.0], state, Canvas::default, canvas_ui, |_| {});
}

#[test]
#[ignore = "needs a graphics driver"]
fn a_ramp() {
    let state = || {
        let mut state = seen(KINDS);
        state.selection = ["sky".to_string()].into();
        state
    };
    compare("ramp", [380.0, 480.0], state, Properties::default, properties_ui, |_| {});
}

#[test]
#[ignore = "needs a graphics driver"]
fn a_curve() {
    let state = || {
        let mut state = seen(KINDS);
        state.selection = ["band".to_string()].into();
        state
    };
    compare("curve", [380.0, 420.0], state, Properties::default, properties_ui, |harness| {
        harness.get_by_label("Curve").click();
        harness.run_steps(2);
        harness.remove_cursor();
    });
}

#[test]
#[ignore = "needs a graphics driver"]
fn a_picture() {
    compare("picture", [640.0, 320.0], || seen(DUSK), Viewer::default, viewer_ui, |_| {});
}
