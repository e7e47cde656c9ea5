use super::{Driver, GRAPH, click, drag, nowhere, open, place, press, stroke};
use crate::actions::{Action, Line};
use crate::canvas::menu::lined_up;
use crate::canvas::place::size;
use crate::canvas::{arrange, freezing, placed};
use crate::document::{Session, edit};
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Rect, TouchPhase, Vec2, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::collections::BTreeSet;

#[test]
fn an_area_chooses_what_it_touches() {
    let mut harness = open(GRAPH);
    let (down, sky) = (place(&harness, "Node down, ScreenY"), place(&harness, "Node sky, Ramp"));
    drag(&mut harness, down.min - vec2(30.0, 30.0), pos2(down.right() + 10.0, sky.center().y));
    assert_eq!(harness.state().chosen(), ["down", "sky"]);
    let across = place(&harness, "Node across, ScreenX");
    let from = across.min - vec2(20.0, 30.0);
    stroke(&mut harness, &[from, across.center()], Modifiers::SHIFT);
    assert_eq!(harness.state().chosen(), ["across", "down", "sky"]);
    click(&mut harness, down.center(), PointerButton::Primary, Modifiers::COMMAND | Modifiers::CTRL);
    assert_eq!(harness.state().chosen(), ["across", "sky"]);
    let empty = nowhere(&harness);
    click(&mut harness, empty, PointerButton::Primary, Modifiers::NONE);
    assert!(harness.state().chosen().is_empty());
}

#[test]
fn nodes_that_are_chosen_move_together_in_one_step_of_undo() {
    let mut harness = open(GRAPH);
    harness.state_mut().state.selection = ["down".to_string(), "sky".into()].into();
    let from = place(&harness, "Node down, ScreenY").center();
    let zoom = harness.state().canvas.view.zoom;
    stroke(&mut harness, &[from, from + vec2(83.0, 11.0)], Modifiers::NONE);
    let [moved, also] = [harness.state().at("down"), harness.state().at("sky")];
    assert!((moved[0] - 83.0 / zoom).abs() < 7.0 / zoom && moved[1].abs() < 18.0 / zoom, "{moved:?}");
    assert!((also[0] - moved[0]).abs() < 1.1 && (also[1] - moved[1] - 360.0).abs() < 1.1, "{also:?}");
    assert_eq!(harness.state().at("across"), [260.0, 0.0]);
    assert_eq!(harness.state_mut().state.session.undo().as_deref(), Some("Move 2 nodes"));
    assert_eq!(harness.state().state.session.text(), GRAPH);
}

#[test]
fn a_node_that_is_nearly_aligned_snaps() {
    let mut harness = open(GRAPH);
    let from = place(&harness, "Node other, Invert").center();
    let zoom = harness.state().canvas.view.zoom;
    // Nearly below "twice", but level with no node, so that only the horizontal position snaps.
    drag(&mut harness, from, from + vec2(-157.0 * zoom, -60.0 * zoom));
    assert_eq!(harness.state().at("other")[0], 260.0);
    harness.state_mut().state.session.undo();
    harness.run_ok();
    stroke(&mut harness, &[from, from + vec2(-157.0 * zoom, -60.0 * zoom)], Modifiers::COMMAND | Modifiers::CTRL);
    assert!((harness.state().at("other")[0] - 263.0).abs() < 1.6, "{:?}", harness.state().at("other"));
}

#[test]
fn a_backdrop_moves_the_nodes_on_it_and_its_text_can_be_edited() {
    let mut harness = open(GRAPH);
    harness.state_mut().state.selection = ["across".to_string(), "twice".into()].into();
    harness.state_mut().act(Action::Backdrop);
    harness.run_ok();
    harness.key_press(Key::Escape);
    harness.run_ok();
    let from = place(&harness, "Backdrop Backdrop").left_center() + vec2(12.0, 0.0);
    let zoom = harness.state().canvas.view.zoom;
    drag(&mut harness, from, from + vec2(40.0, 20.0) * zoom);
    assert_eq!([harness.state().at("across"), harness.state().at("twice")], [[300.0, 20.0], [300.0, 190.0]]);
    assert_eq!(harness.state().at("down"), [0.0, 0.0]);
    let extent = |harness: &Harness<'_, Driver>| harness.state().state.sheet().backdrops["backdrop1"].size;
    let before = extent(&harness);
    let corner = place(&harness, "Size of backdrop Backdrop").center();
    drag(&mut harness, corner, corner + vec2(30.0, 40.0) * zoom);
    assert!(
        (extent(&harness)[0] - before[0] - 30.0).abs() < 1.1 && (extent(&harness)[1] - before[1] - 40.0).abs() < 1.1
    );
    let title = place(&harness, "Backdrop Backdrop").left_center() + vec2(12.0, 0.0);
    for _ in 0..2 {
        press(&harness, title, true, PointerButton::Primary, Modifiers::NONE);
        press(&harness, title, false, PointerButton::Primary, Modifiers::NONE);
    }
    harness.run_ok();
    harness.get_by_label("Text of the backdrop").type_text(" of the sky");
    harness.run_ok();
    harness.key_press_modifiers(Modifiers::SHIFT, Key::Enter);
    harness.run_ok();
    harness.get_by_label("Text of the backdrop").type_text("and air");
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
    assert_eq!(harness.state().text("/ui/backdrops/backdrop1/text"), r#""Backdrop of the sky\nand air""#);
}

#[test]
fn a_new_backdrop_is_named_at_once_also_where_nodes_lie_below_the_field() {
    let mut harness = open(GRAPH);
    harness.state_mut().state.selection = ["down".to_string(), "across".into(), "sky".into()].into();
    // So small that the field reaches over the nodes.
    harness.state_mut().canvas.view.zoom = 0.25;
    harness.run_ok();
    harness.state_mut().act(Action::Backdrop);
    harness.run_ok();
    let field = place(&harness, "Text of the backdrop");
    let node = place(&harness, "Node down, ScreenY");
    assert!(field.intersects(node), "{field:?} {node:?}");
    // The click must reach the field and not the node below it.
    click(&mut harness, field.intersect(node).center(), PointerButton::Primary, Modifiers::NONE);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::CTRL, Key::A);
    harness.get_by_label("Text of the backdrop").type_text("Far");
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
    assert_eq!(harness.state().text("/ui/backdrops/backdrop1/text"), r#""Far""#);
    assert!(harness.query_by_label("Text of the backdrop").is_none());
}

#[test]
fn the_menu_aligns_replaces_and_disables() {
    let mut harness = open(GRAPH);
    harness.state_mut().state.selection = ["across".to_string(), "other".into()].into();
    harness.run_ok();
    let node = place(&harness, "Node other, Invert").center();
    click(&mut harness, node, PointerButton::Secondary, Modifiers::NONE);
    harness.get_by_label("Align left").click();
    harness.run_ok();
    assert_eq!(harness.state().at("other"), [260.0, 360.0]);
    let node = place(&harness, "Node sky, Ramp").center();
    click(&mut harness, node, PointerButton::Secondary, Modifiers::NONE);
    assert_eq!(harness.state().chosen(), ["sky"]);
    harness.get_by_label("Replace with …").click();
    harness.run_ok();
    harness.get_by_label("Node type").type_text("Mix");
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
    assert_eq!(harness.state().text("/nodes/sky/type"), "\"Mix\"");
    assert_eq!(harness.state().text("/nodes/sky/weight"), "\"down\"");
    let node = place(&harness, "Node sky, Mix").center();
    click(&mut harness, node, PointerButton::Secondary, Modifiers::NONE);
    harness.get_by_label("Disable").click();
    harness.run_ok();
    assert_eq!(harness.state().text("/nodes/sky/disabled"), "true");
}

#[test]
fn nodes_without_places_are_laid_out_and_keep_their_places_once_one_is_moved() {
    let text = &GRAPH[..GRAPH.find("  \"ui\"").unwrap()];
    let text = format!("{}\n}}\n", text.trim_end().trim_end_matches(','));
    let mut harness = open(&text);
    assert_eq!(harness.state().state.session.text(), text, "drawing changes nothing");
    let before = place(&harness, "Node sky, Ramp");
    let down = place(&harness, "Node down, ScreenY");
    assert!(down.bottom() < before.top(), "wires run from the top down");
    drag(&mut harness, down.center(), down.center() + vec2(37.0, -29.0));
    assert!(harness.state().state.sheet().nodes.iter().all(|node| node.placed));
    assert!(place(&harness, "Node sky, Ramp").center().distance(before.center()) < 1.5);
    harness.state_mut().state.session.undo();
    assert_eq!(harness.state().state.session.text(), text);
}

#[test]
fn what_is_pasted_into_a_document_without_places_moves_nothing_else() {
    let text = format!("{}\n}}\n", GRAPH[..GRAPH.find("  \"ui\"").unwrap()].trim_end().trim_end_matches(','));
    let session = Session::new(text.clone(), None);
    let seen = placed(session.sheet());
    let (edit, _) = edit::pasted(session.sheet(), &edit::copied(&seen, &["sky".into()]), [500.0, 10.0]).unwrap();
    let mut session = session;
    session.edit(freezing(&seen, edit)).unwrap();
    assert!(session.sheet().nodes.iter().all(|node| node.placed));
    for node in &seen.nodes {
        let now = session.sheet().node(&node.name).unwrap().at;
        assert!((now[0] - node.at[0]).abs() < 1.0 && (now[1] - node.at[1]).abs() < 1.0, "{}", node.name);
    }
    assert_eq!(session.sheet().node("sky2").unwrap().at, [500.0, 10.0]);
    // A node that has a place keeps it, even if no other node has one.
    let mut session = Session::new(text, None);
    session.edit(edit::moved(&[("down".into(), [-400.0, 0.0])])).unwrap();
    let now = placed(session.sheet());
    assert_eq!(now.node("down").unwrap().at, [-400.0, 0.0]);
    assert_eq!(now.node("sky").unwrap().at, seen.node("sky").unwrap().at);
}

#[test]
fn a_laid_out_graph_has_no_overlaps() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../graphs");
    for name in ["toon_sea.json", "great_wave.json", "glow.json"] {
        let session = Session::open(&root.join(name)).unwrap();
        let sheet = session.sheet();
        let places = arrange(sheet, &BTreeSet::new());
        assert_eq!(places.len(), sheet.nodes.len());
        let boxes: Vec<Rect> = places
            .iter()
            .map(|(name, at)| Rect::from_min_size((*at).into(), size(sheet.node(name).unwrap())))
            .collect();
        for (index, own) in boxes.iter().enumerate() {
            for other in &boxes[..index] {
                assert!(!own.expand(4.0).intersects(*other), "{name}");
            }
        }
        for wire in &sheet.wires {
            assert!(boxes[wire.from.0].bottom() < boxes[wire.to.0].top(), "{name}: wires run down");
        }
    }
}

#[test]
fn a_part_that_is_arranged_stays_about_where_it_was() {
    let session = Session::new(GRAPH.into(), None);
    let places = arrange(session.sheet(), &["across".to_string(), "twice".into()].into());
    let names: Vec<&str> = places.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["across", "twice"]);
    assert_eq!(places[0].1, [260.0, 0.0]);
    assert!(places[1].1[1] > 90.0);
}

#[test]
fn a_document_that_is_not_valid_is_drawn_and_marks_the_faulty_node() {
    let text = GRAPH.replace("ScreenY", "ScreenZ").replace(r#""a": "across""#, r#""a": "twice""#);
    let mut harness = open(&text);
    assert!(harness.query_by_label("Node down, ScreenZ").is_some());
    assert!(harness.query_by_label("Error in down").is_some());
    assert!(harness.query_by_label("Error above sky").is_some());
    // A graph with a cycle and without places is drawn, too.
    let cut = text.find("  \"ui\"").unwrap();
    let text = format!("{}\n}}\n", text[..cut].trim_end().trim_end_matches(','));
    *harness.state_mut() = Driver::new(&text);
    harness.run_ok();
    assert!(harness.query_by_label("Node twice, FieldMath").is_some());
    *harness.state_mut() = Driver::new("[");
    harness.run_ok();
    assert!(harness.query_by_label("Node twice, FieldMath").is_none());
}

#[test]
fn a_click_on_the_sign_of_an_error_leads_to_the_faulty_node() {
    let mut harness = open(&GRAPH.replace("ScreenY", "ScreenZ"));
    let sign = place(&harness, "Error above sky").center();
    click(&mut harness, sign, PointerButton::Primary, Modifiers::NONE);
    assert_eq!(harness.state().done, [Action::Visit("down".into())], "the node below the sign is not chosen");
    harness.get_by_label("Error in down").click();
    harness.run_ok();
    assert_eq!(harness.state().done.last(), Some(&Action::Visit("down".into())));
    assert_eq!(harness.state().done.len(), 2);
}

#[test]
fn the_remaining_nodes_stay_where_they_are_when_others_are_deleted() {
    let text = &GRAPH[..GRAPH.find("  \"ui\"").unwrap()];
    let text = format!("{}\n}}\n", text.trim_end().trim_end_matches(','));
    let mut harness = open(&text);
    let rest = ["Node across, ScreenX", "Node sky, Ramp", "Node other, Invert"];
    let before = rest.map(|name| place(&harness, name));
    harness.state_mut().state.selection = ["twice".to_string(), "down".into()].into();
    harness.state_mut().act(Action::Delete);
    harness.run_ok();
    assert!(harness.query_by_label("Node down, ScreenY").is_none());
    for (name, before) in rest.into_iter().zip(before) {
        let now = place(&harness, name);
        assert!(now.center().distance(before.center()) < 1.5, "{name}: {before} {now}");
    }
    assert_eq!(harness.state().text("/ui/positions").matches(':').count(), 3, "no place of a deleted node");
    assert_eq!(harness.state_mut().state.session.undo().as_deref(), Some("Delete 2 nodes"));
    assert_eq!(harness.state().state.session.text(), text);
    // If all nodes are deleted, no places are written.
    harness.state_mut().state.selection =
        harness.state().state.sheet().nodes.iter().map(|node| node.name.clone()).collect();
    harness.state_mut().act(Action::Delete);
    assert!(!harness.state().state.session.text().contains("positions"));
}

#[test]
fn a_drag_with_the_space_bar_held_moves_the_view() {
    let mut harness = open(GRAPH);
    let before = place(&harness, "Node across, ScreenX");
    harness.key_down(Key::Space);
    drag(&mut harness, before.center(), before.center() + vec2(40.0, 30.0));
    harness.key_up(Key::Space);
    harness.run_ok();
    let moved = place(&harness, "Node across, ScreenX").center() - before.center();
    assert!((moved - vec2(40.0, 30.0)).length() < 1.0, "{moved:?}");
    assert!(harness.state().done.iter().all(|action| !matches!(action, Action::Edit(_) | Action::Select(_))));
}

#[test]
fn the_wheel_zooms_at_the_pointer_and_the_middle_button_moves_the_view() {
    let mut harness = open(GRAPH);
    let before = place(&harness, "Node across, ScreenX");
    harness.hover_at(before.center());
    harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Line,
        delta: Vec2::new(0.0, 2.0),
        phase: TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    harness.run_ok();
    let after = place(&harness, "Node across, ScreenX");
    assert!(after.width() > 1.1 * before.width(), "{} {}", after.width(), before.width());
    assert!(after.center().distance(before.center()) < 2.0, "the node under the pointer stays there");
    let at = after.center();
    press(&harness, at, true, PointerButton::Middle, Modifiers::NONE);
    harness.hover_at(at + vec2(20.0, 10.0));
    harness.hover_at(at + vec2(40.0, 30.0));
    press(&harness, at + vec2(40.0, 30.0), false, PointerButton::Middle, Modifiers::NONE);
    harness.run_ok();
    let moved = place(&harness, "Node across, ScreenX").center() - after.center();
    assert!((moved - vec2(40.0, 30.0)).length() < 1.0, "{moved:?}");
    assert!(harness.state().done.iter().all(|action| !matches!(action, Action::Edit(_))));
}

#[test]
fn a_click_chooses_and_a_double_click_looks() {
    let mut harness = open(GRAPH);
    let at = place(&harness, "Node twice, FieldMath").center();
    harness.hover_at(at);
    for _ in 0..2 {
        press(&harness, at, true, PointerButton::Primary, Modifiers::NONE);
        press(&harness, at, false, PointerButton::Primary, Modifiers::NONE);
    }
    harness.run_ok();
    assert_eq!(harness.state().chosen(), ["twice"]);
    assert_eq!(harness.state().state.look.node, Some(("twice".into(), 0)));
    harness.key_press_modifiers(Modifiers::ALT, Key::ArrowUp);
    harness.run_ok();
    assert_eq!(harness.state().chosen(), ["across"]);
    harness.key_press_modifiers(Modifiers::ALT, Key::ArrowDown);
    harness.run_ok();
    assert_eq!(harness.state().chosen(), ["twice"]);
}

#[test]
fn what_is_pasted_over_the_canvas_lands_at_the_pointer() {
    let mut harness = open(GRAPH);
    let text = edit::copied(harness.state().state.sheet(), &["other".into()]);
    let at = nowhere(&harness);
    harness.hover_at(at);
    harness.event(Event::Paste(text));
    harness.run_ok();
    assert_eq!(harness.state().chosen(), ["other2"]);
    assert!(place(&harness, "Node other2, Invert").min.distance(at) < 1.5);
}

#[test]
fn boxes_are_lined_up() {
    let boxes = [[0.0, 0.0, 10.0], [5.0, 90.0, 20.0], [2.0, 20.0, 10.0]]
        .map(|[x, y, side]| Rect::from_min_size(pos2(x, y), vec2(side, side)));
    assert_eq!(lined_up(&boxes, Line::Left), [[0.0, 0.0], [0.0, 90.0], [0.0, 20.0]]);
    assert_eq!(lined_up(&boxes, Line::Top), [[0.0, 0.0], [5.0, 0.0], [2.0, 0.0]]);
    let spread = lined_up(&boxes, Line::Distances);
    assert_eq!(spread.map_y(), [0.0, 90.0, 45.0]);
    let centers = lined_up(&boxes, Line::Centers);
    assert!(centers.iter().zip(&boxes).all(|(at, own)| at[0] + own.width() / 2.0 == centers[0][0] + 5.0));
}

trait Heights {
    fn map_y(&self) -> Vec<f32>;
}

impl Heights for Vec<[f32; 2]> {
    fn map_y(&self) -> Vec<f32> {
        self.iter().map(|at| at[1]).collect()
    }
}

#[test]
fn a_large_graph_opens_at_the_viewed_node_with_readable_names() {
    let nodes: Vec<String> = (0..200).map(|index| format!(r#""down_{index}": {{ "type": "ScreenY" }}"#)).collect();
    let places: Vec<String> =
        (0..200).map(|index| format!(r#""down_{index}": [{}, {}]"#, 300 * (index % 20), 300 * (index / 20))).collect();
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 16, "height": 9 }}, "nodes": {{ {} }},
        "outputs": {{ "o": {{ "field": "down_199" }} }}, "ui": {{ "positions": {{ {} }} }} }}"#,
        nodes.join(","),
        places.join(",")
    );
    let mut harness = open(&text);
    let looked = place(&harness, "Node down_199, ScreenY");
    assert!(looked.width() >= 55.0 && harness.state().canvas.view.rect.contains_rect(looked), "{looked:?}");
    assert!(harness.query_by_label("Node down_0, ScreenY").is_none());
    // Framing shows all nodes.
    harness.state_mut().canvas.frame();
    harness.run_steps(3);
    place(&harness, "Node down_0, ScreenY");
}
