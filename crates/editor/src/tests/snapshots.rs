//! Parts of the editor as they are drawn, compared with the pictures in `snapshots`.
//!
//! wgpu draws them and needs a graphics driver; Mesa's software driver is enough (Debian: mesa-vulkan-drivers). It takes
//! long to build, too. So they run only on request:
//!
//! ```text
//! cargo test --workspace --lib --features trochoid-editor/snapshots snapshots
//! ```
//!
//! If one differs, `snapshots/<name>.diff.png` shows the difference, and `<name>.new.png` what was drawn. The same
//! command with `UPDATE_SNAPSHOTS=1` stores what is drawn; look at the pictures before you commit them.

#[path = "snapshots/curves.rs"]
mod curves;

use super::DUSK;
use crate::actions::{Action, OtherPalette, Pane, Switch};
use crate::canvas::{Canvas, canvas_ui};
use crate::document::Session;
use crate::document::swatches::SwatchKey;
use crate::editor::Editor;
use crate::evaluate::Display;
use crate::palette::{Palette, palette_ui};
use crate::properties::{Properties, properties_ui};
use crate::state::State;
use crate::testing::{ask, finished, sized, until};
use crate::viewer::tests::SEA;
use crate::viewer::{Viewer, viewer_ui};
use egui::{Event, Modifiers, MouseWheelUnit, Pos2, Theme, TouchPhase, Ui, Vec2, vec2};
use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, SnapshotOptions, SnapshotResults};
use std::sync::Arc;

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

/// A picture whose palette is a tetrahedron.
const SOLID: &str = r##"{
  "trochoid": 1, "format": { "width": 16, "height": 9 },
  "nodes": {
    "across": { "type": "ScreenX" },
    "down": { "type": "ScreenY" },
    "upper": { "type": "Mix", "a": "#d04030", "b": "#3050c0", "weight": "across" },
    "lower": { "type": "Mix", "a": "#30a050", "b": "#101010", "weight": "across" },
    "whole": { "type": "Mix", "a": "upper", "b": "lower", "weight": "down" }
  },
  "outputs": { "beauty": { "color": "whole" } }
}"##;

/// Returns the state of an open document with its thumbnails, except those of the scene.
fn seen(text: &str) -> State {
    seen_after(text, &[])
}

/// Returns the state of an open document after some actions. Every node has taken a millisecond, because measured times
/// differ from run to run.
fn seen_after(text: &str, actions: &[Action]) -> State {
    let mut window = sized(Session::new(text.into(), None), None, [800.0, 600.0]);
    finished(&mut window);
    until(&mut window, "thumbnails", |editor| !editor.state().evaluated.thumbnails.is_empty());
    for action in actions {
        ask(&mut window, action.clone());
        finished(&mut window);
    }
    until(&mut window, "the picture as it is looked at", |editor| {
        let (seen, look) = (&editor.state().evaluated, &editor.state().look);
        let is_displayed = seen.result.as_ref().is_none_or(|result| result.display == look.display);
        is_displayed && seen.blame.as_ref().map(|blamed| blamed.at) == look.pick
    });
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

/// A window with the graph.
type Graph<'h> = Harness<'h, (Canvas, State)>;

/// Compares a graph that has a node with an error, one below it, and one that is disabled.
fn compare_graph(name: &str, before: impl Fn(&mut Graph<'_>)) {
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
    compare(name, [760.0, 560.0], state, Canvas::default, canvas_ui, before);
}

fn center<P>(harness: &Harness<'_, P>, label: &str) -> Pos2 {
    harness.get_by_label(label).rect().center()
}

/// Draws a wire, without letting it go.
fn pull(harness: &mut Graph<'_>, from: &str, to: Pos2) {
    let from = center(harness, from);
    harness.hover_at(from);
    harness.drag_at(from);
    for step in 1..=4 {
        harness.hover_at(from.lerp(to, step as f32 / 4.0));
    }
    harness.run_steps(2);
}

/// Returns a place on the empty canvas.
fn nowhere(harness: &Graph<'_>) -> Pos2 {
    center(harness, "Node lit, NonSpecular") + vec2(110.0, 60.0)
}

#[test]
fn the_graph() {
    compare_graph("graph", |_| {});
}

#[test]
fn the_graph_from_nearby() {
    compare_graph("graph_near", |harness| {
        harness.hover_at(center(harness, "Node sky, Ramp"));
        for _ in 0..8 {
            harness.event(Event::MouseWheel {
                unit: MouseWheelUnit::Line,
                delta: Vec2::new(0.0, 1.4),
                phase: TouchPhase::Move,
                modifiers: Modifiers::NONE,
            });
        }
        harness.run_steps(12);
        harness.remove_cursor();
    });
}

#[test]
fn the_error_of_a_node() {
    compare_graph("graph_error", |harness| harness.hover_at(center(harness, "Node bad, Mix")));
}

#[test]
fn the_menu_of_a_node() {
    compare_graph("graph_menu", |harness| harness.get_by_label("Node curved, FieldMath").click_secondary());
}

#[test]
fn a_wire_that_is_drawn() {
    compare_graph("graph_wire", |harness| pull(harness, "Output of curved", nowhere(harness)));
}

#[test]
fn a_wire_that_is_refused() {
    compare_graph("graph_refusal", |harness| {
        let to = center(harness, "Input weight of dusk");
        pull(harness, "Output of curved", to);
        harness.drop_at(to);
    });
}

#[test]
fn a_ramp() {
    let state = || {
        let mut state = seen(KINDS);
        state.selection = ["sky".to_string()].into();
        state
    };
    compare("ramp", [380.0, 480.0], state, Properties::default, properties_ui, |_| {});
}

/// Returns the state of a document with links, and with nodes selected.
fn linked(chosen: &[&str]) -> State {
    let text = KINDS.replace(
        r#""eye": {"#,
        r#""low": { "type": "Clamp", "field": "curved", "min": "= knobs.depth/4", "max": "= low.min + 0.5" },
    "eye": {"#,
    );
    let text = text.replace(r#""nodes": {"#, r#""knobs": { "depth": 0.5 }, "nodes": {"#);
    let mut state = seen(&text);
    assert!(state.session.meaning().graph.is_some());
    state.selection = chosen.iter().map(|name| (*name).to_string()).collect();
    state
}

#[test]
fn linked_knobs() {
    compare("linked", [380.0, 300.0], || linked(&["low"]), Properties::default, properties_ui, |_| {});
}

#[test]
fn several_nodes() {
    compare("several", [380.0, 200.0], || linked(&["low", "band"]), Properties::default, properties_ui, |_| {});
}

#[test]
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

/// A window with the viewer.
type Picture<'h> = Harness<'h, (Viewer, State)>;

fn compare_viewer(name: &str, state: impl Fn() -> State, before: impl Fn(&mut Picture<'_>)) {
    compare(name, [640.0, 320.0], state, Viewer::default, viewer_ui, before);
}

fn switch(harness: &mut Picture<'_>, switch: Switch) {
    let (viewer, state) = harness.state_mut();
    viewer.switch(switch, state);
}

/// Returns the state of a document that shows another node.
fn looking(text: &str, node: &str) -> State {
    seen_after(text, &[Action::Look(node.into(), 0)])
}

#[test]
fn a_picture() {
    compare_viewer("picture", || seen(DUSK), |_| {});
}

#[test]
fn the_colors_of_a_pixel() {
    compare_viewer("picture_pixel", || seen_after(SOLID, &[Action::Pick(Some([0.3, 0.6]))]), |_| {});
}

/// Compares a picture with another one.
fn compare_two(name: &str, by: Switch) {
    compare_viewer(
        name,
        || seen(SOLID),
        |harness| {
            switch(harness, by);
            harness.state_mut().1 = looking(SOLID, "upper");
        },
    );
}

#[test]
fn two_pictures_beside_each_other() {
    compare_two("picture_wipe", Switch::Wipe);
}

#[test]
fn the_difference_of_two_pictures() {
    compare_two("picture_difference", Switch::Difference);
}

#[test]
fn pixels_near_the_faces_of_the_hull() {
    compare_viewer("picture_near", || seen(SOLID), |harness| switch(harness, Switch::Near));
}

#[test]
fn the_scopes() {
    compare_viewer("picture_scopes", || seen(SOLID), |harness| switch(harness, Switch::Scopes));
}

#[test]
fn the_hull() {
    compare_viewer("picture_hull", || seen(SOLID), |harness| switch(harness, Switch::Hull));
}

#[test]
fn a_field() {
    let display = Display { false_color: true, range: Some([0.0, 1.0]), ..Display::default() };
    let actions = [Action::Look("across".into(), 0), Action::Display(display)];
    compare_viewer("picture_field", || seen_after(SOLID, &actions), |_| {});
}

#[test]
fn a_surface() {
    compare_viewer("picture_clay", || looking(SEA, "waves"), |_| {});
}

#[test]
fn what_is_no_picture() {
    compare_viewer("picture_failed", || looking(SEA, "camera"), |_| {});
}

#[test]
fn the_handles_of_a_sea() {
    let state = || {
        let mut state = seen(SEA);
        state.selection = ["waves".to_string()].into();
        state
    };
    compare_viewer("picture_handles", state, |harness| harness.hover_at(center(harness, "guides[0], point 2")));
}

#[test]
fn the_tools_of_a_narrow_viewer() {
    compare(
        "picture_tools",
        [320.0, 300.0],
        || seen(DUSK),
        Viewer::default,
        viewer_ui,
        |harness| {
            switch(harness, Switch::Hold);
            harness.run_steps(2);
            harness.get_by_label("More •").click();
        },
    );
}

/// Returns the state of a document whose colors are looked at.
fn weighed(chosen: Option<&str>) -> State {
    let mut window = sized(Session::new(super::palette::PAINTED.into(), None), None, [800.0, 600.0]);
    ask(&mut window, Action::Panel(Pane::Palette));
    ask(&mut window, Action::Swatch(chosen.map(|name| SwatchKey::Named(name.into()))));
    ask(&mut window, Action::Pick(chosen.map(|_| [0.75, 0.25])));
    finished(&mut window);
    until(&mut window, "the recipe", |editor| editor.state().evaluated.mixture.is_some());
    let editor: Editor = window.into_state().unwrap();
    editor.state
}

#[test]
fn the_palette() {
    compare("palette", [340.0, 560.0], || weighed(Some("foam")), Palette::default, palette_ui, |_| {});
}

#[test]
fn palettes_beside_each_other() {
    let other = |name: &str, colors: [&str; 3]| {
        let names = ["night", "foam", "glow"].into_iter().zip(colors);
        let entries = names.map(|(name, color)| (name.into(), color.into())).collect();
        Arc::new(OtherPalette { name: name.into(), entries })
    };
    let others = [
        other("painted_autumn_with_a_long_name.json", ["#3a1a10", "#f0d8a0", "#d87020"]),
        other("snow.gpl", ["#304860", "#ffffff", "#a0c0e0"]),
    ];
    let state = || {
        let mut state = weighed(None);
        state.colors.compared = Some(others[0].clone());
        state
    };
    let panel = || Palette::comparing(others.to_vec());
    compare("palettes", [340.0, 360.0], state, panel, palette_ui, |_| {});
}
