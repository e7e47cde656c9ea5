use super::{Driver, GRAPH, click, drag, nowhere, open, place, press};
use crate::actions::Action;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

fn beauty(harness: &Harness<'_, Driver>) -> String {
    harness.state().text("/outputs/beauty")
}

#[test]
fn a_wire_that_is_dropped_on_a_mark_leads_the_output_there() {
    let mut harness = open(GRAPH);
    let mark = place(&harness, "Output beauty").center();
    let pin = place(&harness, "Output of twice").center();
    drag(&mut harness, pin, mark);
    assert_eq!(beauty(&harness), r#"{ "field": "twice", "file": "beauty.####.exr" }"#);
    assert_eq!(harness.state().state.sheet().wires.len(), 2, "no wire was added");
    // The mark now stands below the other node; dragging the mark moves the output back.
    let mark = place(&harness, "Output beauty").center();
    assert!(mark.y > place(&harness, "Node twice, FieldMath").bottom());
    let sky = place(&harness, "Node sky, Ramp").center();
    drag(&mut harness, mark, sky);
    assert_eq!(beauty(&harness), r#"{ "color": "sky", "file": "beauty.####.exr" }"#);
    for label in ["Connect sky to output beauty", "Connect twice to output beauty"] {
        assert_eq!(harness.state_mut().state.session.undo().as_deref(), Some(label));
    }
    assert_eq!(harness.state().state.session.text(), GRAPH);
}

#[test]
fn what_no_file_holds_is_refused_with_the_reason() {
    let text = GRAPH.replace("\"down\": {", "\"camera\": { \"type\": \"Camera\" },\n    \"down\": {");
    let text = text.replace("\"down\": [0, 0]", "\"camera\": [-260, 360], \"down\": [0, 0]");
    let mut harness = open(&text);
    let mark = place(&harness, "Output beauty").center();
    let camera = place(&harness, "Node camera, Camera").center();
    drag(&mut harness, mark, camera);
    let why = harness.state().done.iter().find_map(|action| match action {
        Action::Notice(why) => Some(why.clone()),
        _ => None,
    });
    assert!(why.unwrap().contains("which no file can hold"));
    assert_eq!(harness.state().state.session.text(), text);
}

#[test]
fn a_mark_is_chosen_renamed_and_removed() {
    let mut harness = open(GRAPH);
    let mark = place(&harness, "Output beauty").center();
    click(&mut harness, mark, PointerButton::Primary, Modifiers::NONE);
    assert_eq!(harness.state().state.output.as_deref(), Some("beauty"));
    click(&mut harness, mark, PointerButton::Secondary, Modifiers::NONE);
    harness.get_by_label("Rename …").click();
    harness.run_ok();
    // Typing replaces the old name.
    harness.get_by_label("Name of the output").type_text("dawn");
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
    assert_eq!(harness.state().text("/outputs"), r#"{ "dawn": { "color": "sky", "file": "beauty.####.png" } }"#);
    let mark = place(&harness, "Output dawn").center();
    click(&mut harness, mark, PointerButton::Secondary, Modifiers::NONE);
    harness.get_by_label("Remove output").click();
    harness.run_ok();
    assert_eq!(harness.state().text("/outputs"), "{}");
}

#[test]
fn nodes_that_no_output_needs_are_known() {
    let harness = open(GRAPH);
    let plan = harness.state().canvas.plan.as_ref().unwrap();
    let idle: Vec<&str> = plan.idle.iter().map(|node| plan.sheet.nodes[*node].name.as_str()).collect();
    assert_eq!(idle, ["across", "twice", "other"]);
}

fn add(harness: &mut Harness<'_, Driver>, ty: &str) {
    harness.state_mut().canvas.search();
    harness.run_ok();
    harness.get_by_label("Node type").type_text(ty);
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
}

fn boxes(harness: &Harness<'_, Driver>) -> Vec<Rect> {
    harness.state().canvas.plan.as_ref().unwrap().boxes.clone()
}

#[test]
fn a_new_node_stands_on_no_other() {
    let mut harness = open(GRAPH);
    let at = nowhere(&harness);
    harness.hover_at(at);
    for _ in 0..2 {
        harness.state_mut().state.selection.clear();
        add(&mut harness, "Constant");
    }
    harness.state_mut().state.selection = ["sky".to_string()].into();
    for _ in 0..2 {
        add(&mut harness, "Invert");
    }
    let boxes = boxes(&harness);
    assert_eq!(boxes.len(), 9);
    for (index, own) in boxes.iter().enumerate() {
        assert!(boxes[..index].iter().all(|other| !own.intersects(*other)), "{index}");
    }
    let sky = harness.state().state.sheet().find("sky").unwrap();
    assert!(boxes[7].top() > boxes[sky].bottom() && boxes[8].top() > boxes[7].bottom(), "each below the one before");
}

#[test]
fn a_very_fast_click_opens_a_chooser() {
    let mut harness = open(GRAPH);
    let node = place(&harness, "Node sky, Ramp").center();
    click(&mut harness, node, PointerButton::Secondary, Modifiers::NONE);
    let entry: Pos2 = place(&harness, "Replace with …").center();
    harness.hover_at(entry);
    harness.run_ok();
    // Press and release arrive in one frame.
    for pressed in [true, false] {
        let button = PointerButton::Primary;
        let event = Event::PointerButton { pos: entry, button, pressed, modifiers: Modifiers::NONE };
        harness.input_mut().events.push(event);
    }
    harness.run_ok();
    harness.get_by_label("Node type");
    // A click elsewhere closes it, whether it takes one frame or two.
    let empty = place(&harness, "Node down, ScreenY").left_bottom() + egui::vec2(-15.0, 60.0);
    press(&harness, empty, true, PointerButton::Primary, Modifiers::NONE);
    press(&harness, empty, false, PointerButton::Primary, Modifiers::NONE);
    harness.run_ok();
    assert!(harness.query_by_label("Node type").is_none());
}

#[test]
fn each_menu_is_as_large_as_it_needs() {
    let mut harness = open(GRAPH);
    let empty = nowhere(&harness);
    let height = |harness: &Harness<'_, Driver>| place(harness, "Copy").height();
    let node = place(&harness, "Node sky, Ramp").center();
    click(&mut harness, node, PointerButton::Secondary, Modifiers::NONE);
    let first = height(&harness);
    harness.key_press(Key::Escape);
    harness.run_ok();
    click(&mut harness, empty, PointerButton::Secondary, Modifiers::NONE);
    harness.key_press(Key::Escape);
    harness.run_ok();
    click(&mut harness, node, PointerButton::Secondary, Modifiers::NONE);
    for label in ["Assign to viewer key", "Replace with …", "Copy"] {
        let entry = harness.get_by_label_contains(label).rect();
        assert!(entry.height() <= first + 1.0, "{label} stands on one line: {entry:?}");
    }
}
