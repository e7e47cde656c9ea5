use super::menu::{Line, lined_up};
use super::{Canvas, arrange, backdrop, canvas_ui};
use crate::actions::Action;
use crate::document::{Session, edit};
use crate::state::State;
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, Rect, TouchPhase, Ui, Vec2, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::collections::BTreeSet;

/// Does what the canvas asks for, as the editor does.
struct Driver {
    state: State,
    canvas: Canvas,
    done: Vec<Action>,
}

impl Driver {
    fn new(text: &str) -> Self {
        let state = State::new(Session::new(text.into(), None));
        Self { state, canvas: Canvas::default(), done: Vec::new() }
    }

    fn ui(&mut self, ui: &mut Ui) {
        let mut actions = Vec::new();
        canvas_ui(&mut self.canvas, ui, &self.state, &mut actions);
        for action in actions {
            self.done.push(action.clone());
            self.act(action);
        }
    }

    fn act(&mut self, action: Action) {
        let sheet = self.state.sheet().clone();
        let names: Vec<String> = self.state.selection.iter().cloned().collect();
        match action {
            Action::Edit(edit) => self.state.session.edit(edit).unwrap(),
            Action::Seal => self.state.session.seal(),
            Action::Select(names) => self.state.selection = names,
            Action::Look(node, output) => self.state.look.node = Some((node, output)),
            Action::Delete => self.state.session.edit(edit::deleted(&sheet, &names)).unwrap(),
            Action::Disable => self.state.session.edit(edit::disabled(&sheet, &names)).unwrap(),
            Action::Arrange => {
                let places = arrange(&sheet, &self.state.selection);
                self.state.session.edit(edit::laid_out(&sheet, &places)).unwrap();
            }
            Action::Backdrop => {
                let edit = backdrop(&sheet, &self.state.selection).unwrap();
                self.state.session.edit(edit).unwrap();
            }
            Action::Paste(text, at) => {
                let (edit, names) = edit::pasted(&sheet, &text, at).unwrap();
                self.state.session.edit(edit).unwrap();
                self.state.selection = names.into_iter().collect();
            }
            _ => {}
        }
        self.state.selection.retain(|name| self.state.session.sheet().find(name).is_some());
    }

    fn text(&self, path: &str) -> String {
        let value = self.state.sheet().value.pointer(path);
        value.map(edit::style).unwrap_or_default()
    }

    fn at(&self, name: &str) -> [f32; 2] {
        self.state.sheet().node(name).unwrap().at
    }

    fn chosen(&self) -> Vec<&str> {
        self.state.selection.iter().map(String::as_str).collect()
    }
}

const GRAPH: &str = r##"{
  "trochoid": 1,
  "format": { "width": 64, "height": 36, "samples": 1 },
  "working_space": "srgb",
  "frames": { "first": 1, "last": 2, "fps": 24 },
  "nodes": {
    "down": { "type": "ScreenY" },
    "across": { "type": "ScreenX" },
    "twice": { "type": "FieldMath", "expression": "2*a", "a": "across" },
    "sky": { "type": "Ramp", "weight": "down", "stops": [
      { "at": 0, "color": "#2d3f52" }, { "at": 1, "color": "#f0cf8e" }
    ] },
    "other": { "type": "Invert", "weight": 0.5 }
  },
  "outputs": { "beauty": { "color": "sky", "file": "beauty.####.png" } },
  "ui": { "positions": {
    "down": [0, 0], "across": [260, 0], "twice": [260, 170], "sky": [0, 360], "other": [420, 360]
  } }
}
"##;

fn open(text: &str) -> Harness<'static, Driver> {
    let builder = Harness::builder().with_size(vec2(1000.0, 800.0)).with_step_dt(1.0 / 60.0).with_max_steps(60);
    let mut harness = builder.build_ui_state(|ui, driver: &mut Driver| driver.ui(ui), Driver::new(text));
    harness.run_ok();
    harness
}

fn place(harness: &Harness<'_, Driver>, label: &str) -> Rect {
    harness.get_by_label(label).rect()
}

fn press(harness: &Harness<'_, Driver>, at: Pos2, pressed: bool, button: PointerButton, modifiers: Modifiers) {
    harness.event_modifiers(Event::PointerButton { pos: at, button, pressed, modifiers }, modifiers);
}

/// Goes along a path with the button pressed.
fn stroke(harness: &mut Harness<'_, Driver>, path: &[Pos2], modifiers: Modifiers) {
    harness.hover_at(path[0]);
    press(harness, path[0], true, PointerButton::Primary, modifiers);
    for ends in path.windows(2) {
        for step in 1..=6 {
            let at = ends[0].lerp(ends[1], step as f32 / 6.0);
            harness.event_modifiers(Event::PointerMoved(at), modifiers);
        }
    }
    let end = path[path.len() - 1];
    press(harness, end, false, PointerButton::Primary, modifiers);
    harness.run_ok();
}

fn drag(harness: &mut Harness<'_, Driver>, from: Pos2, to: Pos2) {
    stroke(harness, &[from, to], Modifiers::NONE);
}

fn click(harness: &mut Harness<'_, Driver>, at: Pos2, button: PointerButton, modifiers: Modifiers) {
    harness.hover_at(at);
    press(harness, at, true, button, modifiers);
    press(harness, at, false, button, modifiers);
    harness.run_ok();
}

/// A place where nothing is.
fn nowhere(harness: &Harness<'_, Driver>) -> Pos2 {
    let (down, across) = (place(harness, "Node down, ScreenY"), place(harness, "Node across, ScreenX"));
    pos2((down.right() + across.left()) / 2.0, down.center().y - 30.0)
}

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
    // Each was a step of its own.
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
    // What needs something keeps a constant.
    assert_eq!(harness.state().text("/nodes/sky/weight"), "0.5");
    let (from, to) = (place(&harness, "Input a of twice"), nowhere(&harness));
    drag(&mut harness, from.center(), to);
    assert_eq!(harness.state().text("/nodes/twice/a"), "");
    assert!(harness.query_by_label_contains("Name of a type").is_none(), "an old wire asks for no node");
}

#[test]
fn a_wire_is_grasped_at_the_end_that_is_nearer() {
    let mut harness = open(GRAPH);
    let (above, below) = (place(&harness, "Output of down"), place(&harness, "Input weight of sky"));
    let at = above.center().lerp(below.center(), 0.8);
    let to = place(&harness, "Input weight of other").center();
    drag(&mut harness, at, to);
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"down\"");
    let (above, below) = (place(&harness, "Output of down"), place(&harness, "Input weight of other"));
    let upper = above.center().lerp(below.center(), 0.02);
    let to = place(&harness, "Output of across").center();
    drag(&mut harness, upper + vec2(0.0, 10.0), to);
    let left = harness.state().text("/nodes/other/weight");
    assert!(left == "\"across\"" || left == "\"down\"", "{left}");
}

#[test]
fn an_illegal_wire_is_refused_with_a_reason_and_a_clamp_makes_it_legal() {
    let mut harness = open(GRAPH);
    let (from, to) = (place(&harness, "Output of twice"), place(&harness, "Input weight of other"));
    drag(&mut harness, from.center(), to.center());
    assert_eq!(harness.state().text("/nodes/other/weight"), "0.5");
    assert!(harness.query_by_label("twice cannot go to other.weight").is_some());
    assert!(harness.query_by_label_contains("maps the field to weights").is_some());
    harness.get_by_label("Put a Clamp between").click();
    harness.run_ok();
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"clamp\"");
    assert_eq!(harness.state().text("/nodes/clamp/field"), "\"twice\"");
    assert_eq!(harness.state().chosen(), ["clamp"]);
    assert_eq!(harness.state().state.session.meaning().errors().count(), 0);
    assert_eq!(harness.state_mut().state.session.undo().as_deref(), Some("Put a Clamp between"));
    assert_eq!(harness.state().state.session.text(), GRAPH);
}

#[test]
fn a_cycle_is_refused_and_esc_closes_the_reason() {
    let text = GRAPH
        .replace(r#""weight": 0.5"#, r#""weight": "half""#)
        .replace(r#""other""#, r#""half": { "type": "Invert", "weight": 0.5 }, "other""#);
    // The replacement above also names the place; that the document has it twice does no harm.
    let mut harness = open(
        &text
            .replace(r#""half": { "type": "Invert", "weight": 0.5 }, "other": ["#, r#""half": [420, 170], "other": ["#),
    );
    let (from, to) = (place(&harness, "Output of other"), place(&harness, "Input weight of half"));
    drag(&mut harness, from.center(), to.center());
    assert_eq!(harness.state().text("/nodes/half/weight"), "0.5");
    assert!(harness.query_by_label_contains("a graph has no cycles").is_some());
    harness.key_press(Key::Escape);
    harness.run_ok();
    assert!(harness.query_by_label_contains("a graph has no cycles").is_none());
}

#[test]
fn a_wire_that_is_let_go_in_space_asks_for_what_fits() {
    let mut harness = open(GRAPH);
    let (from, to) = (place(&harness, "Output of sky"), nowhere(&harness));
    drag(&mut harness, from.center(), to);
    assert!(harness.query_by_label("Mix").is_some());
    assert!(harness.query_by_label("Invert").is_none(), "no node makes a mask of a color");
    harness.get_by_label("Name of a type of node").type_text("mix");
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
    harness.get_by_label("Name of a type of node").type_text("invrt");
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
    assert_eq!(harness.state().text("/nodes/invert/weight"), "\"down\"");
    assert_eq!(harness.state().text("/nodes/sky/weight"), "\"invert\"", "what took the node above takes the new one");
    assert_eq!(harness.state().chosen(), ["invert"]);
    harness.state_mut().state.session.undo();
    assert_eq!(harness.state().state.session.text(), GRAPH);
}

#[test]
fn esc_closes_the_search_and_arrows_choose_in_it() {
    let mut harness = open(GRAPH);
    harness.state_mut().canvas.search();
    harness.run_ok();
    harness.get_by_label("Name of a type of node").type_text("screen");
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
    assert!(harness.query_by_label("Name of a type of node").is_none());
}

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
    // Nearly below "twice", and at another height than all.
    drag(&mut harness, from, from + vec2(-157.0 * zoom, -60.0 * zoom));
    assert_eq!(harness.state().at("other")[0], 260.0);
    harness.state_mut().state.session.undo();
    harness.run_ok();
    stroke(&mut harness, &[from, from + vec2(-157.0 * zoom, -60.0 * zoom)], Modifiers::COMMAND | Modifiers::CTRL);
    assert!((harness.state().at("other")[0] - 263.0).abs() < 1.6, "{:?}", harness.state().at("other"));
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
    assert!(harness.state().at("other")[0] > 440.0, "it stays in the hand: {:?}", harness.state().at("other"));
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
fn a_backdrop_takes_along_what_stands_on_it() {
    let mut harness = open(GRAPH);
    harness.state_mut().state.selection = ["across".to_string(), "twice".into()].into();
    harness.state_mut().act(Action::Backdrop);
    harness.run_ok();
    let from = place(&harness, "Backdrop Backdrop").left_center() + vec2(12.0, 0.0);
    let zoom = harness.state().canvas.view.zoom;
    drag(&mut harness, from, from + vec2(40.0, 20.0) * zoom);
    assert_eq!([harness.state().at("across"), harness.state().at("twice")], [[300.0, 20.0], [300.0, 190.0]]);
    assert_eq!(harness.state().at("down"), [0.0, 0.0]);
    let size = |harness: &Harness<'_, Driver>| harness.state().state.sheet().backdrops["backdrop1"].size;
    let before = size(&harness);
    let corner = place(&harness, "Size of backdrop Backdrop").center();
    drag(&mut harness, corner, corner + vec2(30.0, 40.0) * zoom);
    assert!((size(&harness)[0] - before[0] - 30.0).abs() < 1.1 && (size(&harness)[1] - before[1] - 40.0).abs() < 1.1);
    // Its text.
    let title = place(&harness, "Backdrop Backdrop").left_center() + vec2(12.0, 0.0);
    for _ in 0..2 {
        press(&harness, title, true, PointerButton::Primary, Modifiers::NONE);
        press(&harness, title, false, PointerButton::Primary, Modifiers::NONE);
    }
    harness.run_ok();
    harness.get_by_label("Text of the backdrop").type_text(" of the sky");
    harness.run_ok();
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::CTRL, Key::Enter);
    harness.run_ok();
    assert_eq!(harness.state().text("/ui/backdrops/backdrop1/text"), "\"Backdrop of the sky\"");
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
    harness.get_by_label("Name of a type of node").type_text("Mix");
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
fn a_laid_out_graph_has_no_overlaps() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../graphs");
    for name in ["toon_sea.json", "great_wave.json", "glow.json"] {
        let session = Session::open(&root.join(name)).unwrap();
        let sheet = session.sheet();
        let places = arrange(sheet, &BTreeSet::new());
        assert_eq!(places.len(), sheet.nodes.len());
        let boxes: Vec<Rect> = places
            .iter()
            .map(|(name, at)| Rect::from_min_size((*at).into(), super::place::size(sheet.node(name).unwrap())))
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
fn a_document_that_is_not_valid_is_drawn_and_tells_the_culprit() {
    let text = GRAPH.replace("ScreenY", "ScreenZ").replace(r#""a": "across""#, r#""a": "twice""#);
    let mut harness = open(&text);
    assert!(harness.query_by_label("Node down, ScreenZ").is_some());
    assert!(harness.query_by_label("Error in down").is_some());
    assert!(harness.query_by_label("Error above sky").is_some());
    // Also what has a cycle and no places.
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
fn wires_can_be_drawn_without_dragging() {
    let mut harness = open(GRAPH);
    harness.get_by_label("Output of down").click_accesskit();
    harness.run_ok();
    harness.get_by_label("Input weight of other").click_accesskit();
    harness.run_ok();
    assert_eq!(harness.state().text("/nodes/other/weight"), "\"down\"");
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
