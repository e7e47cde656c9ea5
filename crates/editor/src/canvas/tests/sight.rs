//! What can be seen and reached at each zoom, and where the view stands.

use super::{Driver, GRAPH, drag, open, place};
use egui::vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

/// Zooms, with the middle of the graph in the middle.
fn zoom(harness: &mut Harness<'_, Driver>, zoom: f32) {
    let middle = harness.state().canvas.plan.as_ref().unwrap().bounds.center();
    let view = &mut harness.state_mut().canvas.view;
    view.zoom = zoom;
    view.center(middle);
    harness.run_ok();
}

#[test]
fn a_pin_that_is_drawn_can_be_pulled_from_beside_it() {
    let mut harness = open(GRAPH);
    zoom(&mut harness, 0.46);
    let (from, to) = (place(&harness, "Output of down"), place(&harness, "Input weight of other"));
    // The pin of a small node reaches farther than it is drawn.
    drag(&mut harness, from.center() + vec2(0.0, 7.5), to.center() + vec2(-5.0, -5.0));
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"down\"");
    assert_eq!(harness.state().at("down"), [0.0, 0.0]);
}

#[test]
fn where_pins_would_cover_names_there_are_none() {
    let mut harness = open(GRAPH);
    assert!(harness.query_by_label("Output of down").is_some());
    zoom(&mut harness, 0.44);
    assert!(harness.query_by_label("Output of down").is_none());
    assert!(harness.query_by_label("Output beauty").is_none(), "its name would be too small");
    place(&harness, "Node down, ScreenY");
}

#[test]
fn pins_beside_each_other_share_the_room_between_them() {
    let mut harness = open(GRAPH);
    zoom(&mut harness, 0.46);
    let pins = ["a", "b", "c"].map(|pin| place(&harness, &format!("Input {pin} of twice")));
    for pair in pins.windows(2) {
        assert!(pair[0].right() <= pair[1].left() + 0.01, "{pins:?}");
        assert!(pair[0].height() >= 16.0);
    }
    assert!(pins[0].center().x - pins[0].left() < 8.01 && pins[0].width() > pins[1].width());
}

#[test]
fn what_is_framed_lies_beside_the_map() {
    let mut harness = open(&GRAPH.replace(r#""other": [420, 360]"#, r#""other": [4000, 3000]"#).replace(
        r#""down": [0, 0], "across": [260, 0], "twice": [260, 170]"#,
        r#""down": [0, 0], "across": [1300, 0], "twice": [1300, 900]"#,
    ));
    let chosen = ["down", "across", "twice"];
    harness.state_mut().state.selection = chosen.iter().map(|name| (*name).to_string()).collect();
    harness.state_mut().canvas.frame();
    harness.run_ok();
    let map = place(&harness, "Map of the graph");
    for label in ["Node down, ScreenY", "Node across, ScreenX", "Node twice, FieldMath"] {
        let own = place(&harness, label);
        assert!(!own.intersects(map) && harness.state().canvas.view.rect.contains_rect(own), "{label} {own:?} {map:?}");
    }
    // If everything is in view, there is no map.
    harness.state_mut().state.selection.clear();
    harness.state_mut().canvas.frame();
    harness.run_ok();
    assert!(harness.query_by_label("Map of the graph").is_none());
}
