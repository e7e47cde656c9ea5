use super::{GRAPH, click, drag, nowhere, open, place, press, stroke};
use egui::{Key, Modifiers, PointerButton, vec2};
use egui_kittest::kittest::Queryable;

#[test]
fn a_wire_is_drawn_from_an_output_to_a_pin_and_back() {
    let mut harness = open(GRAPH);
    let (from, to) = (place(&harness, "Output of down"), place(&harness, "Input weight of other"));
    drag(&mut harness, from.center(), to.center());
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"down\"");
    assert!(harness.query_by_label("Wire from down to other weight").is_some());
    // From the pin to the output.
    let (from, to) = (place(&harness, "Input b of twice"), place(&harness, "Output of down"));
    drag(&mut harness, from.center(), to.center());
    assert_eq!(harness.state().text("/nodes/twice/b"), "\"down\"");
    // Undo takes back only the last wire.
    harness.state_mut().state.session.undo();
    assert_eq!(harness.state().text("/nodes/twice/b"), "");
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"down\"");
}

#[test]
fn a_wire_that_is_let_go_on_a_node_goes_to_the_pin_that_fits() {
    let mut harness = open(GRAPH);
    let (from, to) = (place(&harness, "Output of down"), place(&harness, "Node twice, FieldMath"));
    drag(&mut harness, from.center(), to.center());
    assert_eq!(harness.state().text("/nodes/twice/b"), "\"down\"");
    assert_eq!(harness.state().text("/nodes/twice/a"), "\"across\"");
}

#[test]
fn a_wire_is_taken_off_its_pin_and_plugged_elsewhere_or_nowhere() {
    let mut harness = open(GRAPH);
    let (from, to) = (place(&harness, "Input weight of sky"), place(&harness, "Input weight of other"));
    drag(&mut harness, from.center(), to.center());
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"down\"");
    // A required input gets a constant instead.
    assert_eq!(harness.state().text("/nodes/sky/weight"), "0.5");
    let (from, to) = (place(&harness, "Input a of twice"), nowhere(&harness));
    drag(&mut harness, from.center(), to);
    assert_eq!(harness.state().text("/nodes/twice/a"), "");
    assert!(harness.query_by_label_contains("Node type").is_none(), "only a new wire opens the search");
}

#[test]
fn a_wire_is_grasped_at_the_end_that_is_nearer() {
    let mut harness = open(GRAPH);
    let (above, below) = (place(&harness, "Output of down"), place(&harness, "Input weight of sky"));
    let at = above.center().lerp(below.center(), 0.8);
    let to = place(&harness, "Input weight of other").center();
    drag(&mut harness, at, to);
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"down\"");
    let upper = place(&harness, "Output of down").center() + vec2(0.0, 14.0);
    let to = place(&harness, "Output of across").center();
    drag(&mut harness, upper, to);
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"across\"");
}

#[test]
fn an_illegal_wire_is_refused_with_a_reason_and_a_clamp_makes_it_legal() {
    let mut harness = open(GRAPH);
    let (from, to) = (place(&harness, "Output of twice"), place(&harness, "Input weight of other"));
    drag(&mut harness, from.center(), to.center());
    assert_eq!(harness.state().text("/nodes/other/weight"), "0.5");
    assert!(harness.query_by_label("twice cannot go to other.weight").is_some());
    assert!(harness.query_by_label_contains("maps the field to weights").is_some());
    harness.get_by_label("Insert a Clamp").click();
    harness.run_ok();
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"clamp\"");
    assert_eq!(harness.state().text("/nodes/clamp/field"), "\"twice\"");
    assert_eq!(harness.state().chosen(), ["clamp"]);
    assert_eq!(harness.state().state.session.meaning().errors().count(), 0);
    assert_eq!(harness.state_mut().state.session.undo().as_deref(), Some("Insert Clamp"));
    assert_eq!(harness.state().state.session.text(), GRAPH);
}

#[test]
fn a_cycle_is_refused_and_esc_closes_the_reason() {
    let other = r#""other": { "type": "Invert", "weight": "#;
    let text = GRAPH.replace(
        &format!("{other}0.5"),
        &format!("\"half\": {{ \"type\": \"Invert\", \"weight\": 0.5 }},\n    {other}\"half\""),
    );
    let mut harness = open(&text.replace(r#""other": ["#, r#""half": [420, 170], "other": ["#));
    let (from, to) = (place(&harness, "Output of other"), place(&harness, "Input weight of half"));
    drag(&mut harness, from.center(), to.center());
    assert_eq!(harness.state().text("/nodes/half/weight"), "0.5");
    assert!(harness.query_by_label_contains("would close a cycle").is_some());
    harness.key_press(Key::Escape);
    harness.run_ok();
    assert!(harness.query_by_label_contains("would close a cycle").is_none());
}

#[test]
fn a_wire_that_is_let_go_in_space_asks_for_what_fits() {
    let mut harness = open(GRAPH);
    let (from, to) = (place(&harness, "Output of sky"), nowhere(&harness));
    drag(&mut harness, from.center(), to);
    assert!(harness.query_by_label("Mix").is_some());
    assert!(harness.query_by_label("Invert").is_none(), "no node makes a mask of a color");
    harness.get_by_label("Node type").type_text("mix");
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
    assert_eq!(harness.state().text("/nodes/mix/a"), "\"sky\"");
    assert_eq!(harness.state().chosen(), ["mix"]);
}

#[test]
fn tab_finds_a_node_and_puts_it_below_the_chosen_one() {
    let mut harness = open(GRAPH);
    let at = place(&harness, "Node down, ScreenY").center();
    click(&mut harness, at, PointerButton::Primary, Modifiers::NONE);
    assert_eq!(harness.state().chosen(), ["down"]);
    harness.hover_at(nowhere(&harness));
    harness.run_ok();
    harness.state_mut().canvas.search();
    harness.run_ok();
    harness.get_by_label("Node type").type_text("invrt");
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
    assert_eq!(harness.state().text("/nodes/invert/weight"), "\"down\"");
    assert_eq!(harness.state().text("/nodes/sky/weight"), "\"invert\"", "sky, which read down, now reads the new node");
    assert_eq!(harness.state().chosen(), ["invert"]);
    harness.state_mut().state.session.undo();
    assert_eq!(harness.state().state.session.text(), GRAPH);
}

#[test]
fn a_field_goes_to_what_takes_a_mask_by_the_standard_conversion() {
    // "curved" is a Field, which a Ramp takes only as a mask.
    let text = GRAPH.replace(
        r#""other": { "type""#,
        r#""curved": { "type": "FieldMath", "expression": "a*a", "a": "down" },
    "other": { "type""#,
    );
    let text = text.replace(r#""other": ["#, r#""curved": [420, 170], "other": ["#);
    let is_made = |harness: &egui_kittest::Harness<'_, super::Driver>| {
        let driver = harness.state();
        assert_eq!(driver.text("/nodes/clamp/field"), "\"curved\"");
        assert_eq!(driver.text("/nodes/ramp/weight"), "\"clamp\"");
        assert_eq!(driver.chosen(), ["ramp"]);
        assert!(driver.state.session.meaning().graph.is_some());
        let [between, below] = ["clamp", "ramp"].map(|name| driver.at(name));
        assert!(between[1] + 60.0 < below[1], "{between:?} {below:?}");
        let boxes = &driver.canvas.plan.as_ref().unwrap().boxes;
        for (index, own) in boxes.iter().enumerate() {
            assert!(boxes[..index].iter().all(|other| !own.intersects(*other)), "{index} stands on another node");
        }
    };
    // By a wire that is let go in space: what takes the Field itself comes first.
    let mut harness = open(&text);
    let (from, to) = (place(&harness, "Output of curved"), nowhere(&harness));
    drag(&mut harness, from.center(), to);
    let rows = ["Clamp", "Ramp"].map(|name| harness.query_all_by_label(name).next().map(|row| row.rect()));
    assert!(rows[0].unwrap().top() < rows[1].unwrap().top(), "{rows:?}");
    harness.get_by_label("Node type").type_text("ramp");
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
    is_made(&harness);
    harness.state_mut().state.session.undo();
    assert_eq!(harness.state().state.session.text(), text);
    // By Tab with the node selected.
    let mut harness = open(&text);
    let at = place(&harness, "Node curved, FieldMath").center();
    click(&mut harness, at, PointerButton::Primary, Modifiers::NONE);
    harness.state_mut().canvas.search();
    harness.run_ok();
    harness.get_by_label("Node type").type_text("ramp");
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
    is_made(&harness);
}

#[test]
fn esc_closes_the_search_and_arrows_choose_in_it() {
    let mut harness = open(GRAPH);
    harness.state_mut().canvas.search();
    harness.run_ok();
    harness.get_by_label("Node type").type_text("screen");
    harness.run_ok();
    harness.key_press(Key::ArrowDown);
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
    assert_eq!(harness.state().state.sheet().nodes.len(), 6);
    let name = harness.state().chosen()[0].to_string();
    assert!(name.starts_with("screen_") && name != "screen", "{name}");
    harness.state_mut().canvas.search();
    harness.run_ok();
    harness.key_press(Key::Escape);
    harness.run_ok();
    assert!(harness.query_by_label("Node type").is_none());
}

#[test]
fn a_free_node_goes_into_the_wire_on_which_it_is_let_go() {
    let mut harness = open(GRAPH);
    let wire = place(&harness, "Wire from down to sky weight").center();
    let from = place(&harness, "Node other, Invert").center();
    drag(&mut harness, from, wire);
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"down\"");
    assert_eq!(harness.state().text("/nodes/sky/weight"), "\"other\"");
    assert_eq!(harness.state_mut().state.session.undo().as_deref(), Some("Insert other"));
    assert_eq!(harness.state().state.session.text(), GRAPH);
}

#[test]
fn shaking_a_node_takes_it_out_of_its_wires() {
    let text = GRAPH.replace(r#""weight": "down", "stops""#, r#""weight": "other", "stops""#);
    let text = text.replace(r#""weight": 0.5"#, r#""weight": "down""#);
    let mut harness = open(&text);
    let from = place(&harness, "Node other, Invert").center();
    let (left, right) = (from - vec2(60.0, 0.0), from + vec2(60.0, 0.0));
    stroke(&mut harness, &[from, right, left, right, left, right + vec2(0.0, 40.0)], Modifiers::NONE);
    assert_eq!(harness.state().text("/nodes/sky/weight"), "\"down\"");
    assert_eq!(harness.state().text("/nodes/other/weight"), "0.5");
    assert!(harness.state().at("other")[0] > 440.0, "it is still dragged: {:?}", harness.state().at("other"));
    harness.state_mut().state.session.undo();
    assert_eq!(harness.state().state.session.text(), text, "one step of undo");
}

#[test]
fn a_wire_gets_a_dot_that_can_be_moved_and_removed() {
    let mut harness = open(GRAPH);
    let wire = place(&harness, "Wire from down to sky weight").center();
    stroke(&mut harness, &[wire, wire + vec2(50.0, 0.0)], Modifiers::COMMAND | Modifiers::CTRL);
    assert_ne!(harness.state().text("/ui/wires/sky.weight"), "");
    let dot = place(&harness, "Dot 1 of sky.weight").center();
    assert!(dot.distance(wire + vec2(50.0, 0.0)) < 2.0);
    drag(&mut harness, dot, dot + vec2(0.0, 30.0));
    assert!(place(&harness, "Dot 1 of sky.weight").center().distance(dot + vec2(0.0, 30.0)) < 2.0);
    let dot = place(&harness, "Dot 1 of sky.weight").center();
    for _ in 0..2 {
        press(&harness, dot, true, PointerButton::Primary, Modifiers::NONE);
        press(&harness, dot, false, PointerButton::Primary, Modifiers::NONE);
    }
    harness.run_ok();
    assert_eq!(harness.state().text("/ui/wires/sky.weight"), "");
}

#[test]
fn wires_can_be_drawn_without_dragging() {
    let mut harness = open(GRAPH);
    harness.get_by_label("Output of down").click_accesskit();
    harness.run_ok();
    harness.get_by_label("Input weight of other").click_accesskit();
    harness.run_ok();
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"down\"");
}

#[test]
fn a_clamp_is_offered_also_while_something_else_is_wrong() {
    let mut harness = open(&GRAPH.replace(r#""color": "sky""#, r#""color": "nothing""#));
    let (from, to) = (place(&harness, "Output of twice"), place(&harness, "Input weight of other"));
    drag(&mut harness, from.center(), to.center());
    harness.get_by_label("Insert a Clamp").click();
    harness.run_ok();
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"clamp\"");
    assert_eq!(harness.state().text("/nodes/clamp/field"), "\"twice\"");
}
