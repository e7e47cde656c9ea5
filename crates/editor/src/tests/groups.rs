//! Groups: their uses on the canvas, entering and leaving, and the commands that make and unpack them.

use super::dusk;
use crate::actions::Action;
use crate::document::tests::groups::{LINKED, bits};
use crate::document::{Edit, Path, Session, edit};
use crate::testing::{Window, act, editor, finished, unseen, unseen_in, window};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton};
use egui_kittest::kittest::{NodeT, Queryable};
use serde_json::{Value, json};

fn open() -> Window {
    // Tall, so that all pins can be clicked.
    unseen_in(Session::new(LINKED.into(), None), [1280.0, 2400.0])
}

fn select(window: &mut Window, names: &[&str]) {
    act(window, Action::Select(names.iter().map(|name| (*name).to_string()).collect()));
}

fn click(window: &mut Window, label: &str, times: usize) {
    let at = window.get_by_label(label).rect().center();
    for _ in 0..times {
        window.hover_at(at);
        for pressed in [true, false] {
            let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
            window.event(Event::PointerButton { pos: at, button, pressed, modifiers });
            window.step();
        }
    }
    window.run_steps(4);
}

fn value(window: &Window, path: &Path) -> Value {
    path.find(&editor(window).state().session.sheet().value).cloned().unwrap_or_default()
}

fn text(window: &Window) -> &str {
    editor(window).state().session.text()
}

fn shows(window: &Window, label: &str) -> bool {
    window.query_by_label(label).is_some()
}

#[test]
fn a_use_is_wired_and_set_like_a_node() {
    let mut window = open();
    act(&mut window, Action::Frames);
    window.get_by_label("Node keyed, Dot");
    window.get_by_label("Wire from keyed.through to last b");
    for pin in ["Input under of keyed", "Input shape of keyed", "Output of keyed", "Output spot of keyed"] {
        window.get_by_label(pin);
    }
    click(&mut window, "Output of sky", 1);
    click(&mut window, "Input over of keyed", 1);
    assert_eq!(value(&window, &Path::node("keyed").to("over")), json!("sky"));
    // What does not fit is refused with a reason.
    click(&mut window, "Output of across", 1);
    click(&mut window, "Input over of keyed", 1);
    window.get_by_label("across cannot go to keyed.over");
    window.get_by_label("Cancel").click();
    window.run_steps(3);
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), LINKED);
    select(&mut window, &["keyed"]);
    for knob in ["x", "size", "ink", "form", "half", "under", "shape", "over"] {
        assert!(window.query_all_by_label(knob).next().is_some(), "{knob} is shown");
    }
    let is_size = |field: &egui_kittest::Node<'_>| field.accesskit_node().numeric_value() == Some(0.15);
    window.get_all_by_role(Role::SpinButton).find(is_size).unwrap().focus();
    window.run_steps(2);
    window.event(Event::Text("0.3".into()));
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert_eq!(value(&window, &Path::node("keyed").to("size")), json!(0.3));
    act(&mut window, Action::Undo);
    // Links are shown as they are written, those of the group, too.
    assert!(window.query_all_by_value("= knobs.size / 2").next().is_some());
    select(&mut window, &["pair"]);
    assert!(window.query_all_by_value("= 0.2 + knobs.gap").next().is_some());
    assert_eq!(text(&window), LINKED);
}

#[test]
fn a_group_is_entered_and_left_and_nothing_is_written() {
    let mut window = open();
    let revision = editor(&window).state().session.revision();
    act(&mut window, Action::Frames);
    click(&mut window, "Node pair, Pair", 2);
    assert_eq!(editor(&window).state().scope, ["pair"]);
    window.get_by_label("Input ground of the group");
    window.get_by_label("Output color of the group");
    window.get_by_label("Wire from ground to one under");
    window.get_by_label("used once");
    select(&mut window, &["two"]);
    window.key_press(Key::Enter);
    window.run_steps(4);
    assert_eq!(editor(&window).state().scope, ["pair", "two"]);
    window.get_by_label("used 3 times");
    window.get_by_label("two: Dot");
    assert!(shows(&window, "Node spot, Shape") && !shows(&window, "Node two, Dot"));
    click(&mut window, "Back to pair: Pair", 1);
    assert_eq!(editor(&window).state().scope, ["pair"]);
    assert!(editor(&window).state().selection.contains("two"), "what was left is selected");
    // Esc first ends what is being done.
    window.key_press(Key::Tab);
    window.run_steps(3);
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert_eq!(editor(&window).state().scope, ["pair"]);
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(editor(&window).state().scope.is_empty());
    assert!(shows(&window, "Node pair, Pair") && !shows(&window, "used once"));
    let state = editor(&window).state();
    assert_eq!((state.session.text(), state.session.revision()), (LINKED, revision));
}

#[test]
fn edits_inside_change_the_definition() {
    let mut window = open();
    act(&mut window, Action::Enter(vec!["keyed".into()]));
    let lit = Path::default().to("groups").to("Dot").to("nodes").to("lit");
    act(&mut window, Action::Edit(Edit::set(Path::node("lit").to("weight"), &json!("spot"))));
    assert_eq!(value(&window, &lit.to("weight")), json!("spot"));
    // Nodes are added, renamed and deleted there, too.
    let declaration = trochoid::registry().get("Invert").unwrap().declaration();
    let (added, name) = edit::added(editor(&window).state().sheet(), declaration, [0.0, 0.0]);
    act(&mut window, Action::Edit(added));
    assert!(value(&window, &Path::default().to("groups").to("Dot").to("nodes")).get(&name).is_some());
    select(&mut window, &[&name]);
    act(&mut window, Action::Delete);
    let renamed = edit::renamed(editor(&window).state().sheet(), "spot", "mark");
    act(&mut window, Action::Edit(renamed));
    assert_eq!(value(&window, &lit.to("weight")), json!("mark"));
    let place = Path::default().to("groups").to("Dot").to("outputs");
    click(&mut window, "Output of mark", 1);
    click(&mut window, "Input spot of spot", 1);
    assert_eq!(value(&window, &place.to("spot")), json!("mark"), "by a wire to the box of the output");
    assert_eq!(editor(&window).state().session.meaning().errors().count(), 0);
    while editor(&window).state().session.history().undoes().is_some() {
        act(&mut window, Action::Undo);
    }
    assert_eq!(text(&window), LINKED);
}

#[test]
fn what_is_viewed_inside_is_as_the_use_makes_it() {
    let mut window = window(Session::new(LINKED.into(), None), None);
    let seen = |window: &mut Window, node: &str| {
        act(window, Action::Look(node.into(), 0));
        finished(window);
        let evaluated = &editor(window).state().evaluated;
        assert_eq!(evaluated.failed, None, "{node}");
        let result = evaluated.result.clone().unwrap();
        result.picture.planes.iter().map(|plane| plane.samples().to_vec()).collect::<Vec<Vec<f32>>>()
    };
    let (one, two) = (seen(&mut window, "pair/one/spot"), seen(&mut window, "pair/two/spot"));
    assert_ne!(one, two);
    // As the group makes it, too.
    act(&mut window, Action::Look("pair".into(), 1));
    finished(&mut window);
    let made = editor(&window).state().evaluated.result.clone().unwrap();
    assert_eq!(made.picture.planes[0].samples(), seen(&mut window, "pair/one/cut")[0]);
    // An input shows what is connected, and a nested use what it makes.
    assert_eq!(seen(&mut window, "pair/ground"), seen(&mut window, "sky"));
    assert_eq!(seen(&mut window, "pair/two"), seen(&mut window, "pair"));
    assert_eq!(seen(&mut window, "pair/outputs.color"), seen(&mut window, "pair"));
    // A number shows what is selected inside, and later from outside.
    act(&mut window, Action::Enter(vec!["pair".into(), "one".into()]));
    select(&mut window, &["cut"]);
    window.key_press(Key::Num5);
    finished(&mut window);
    assert_eq!(editor(&window).state().look.node, Some(("pair/one/cut".into(), 0)));
    act(&mut window, Action::Enter(Vec::new()));
    select(&mut window, &[]);
    act(&mut window, Action::Look("sky".into(), 0));
    window.key_press(Key::Num5);
    finished(&mut window);
    assert_eq!(editor(&window).state().look.node, Some(("pair/one/cut".into(), 0)));
    // The name follows the use, and what is gone is viewed no more.
    let renamed = edit::renamed(editor(&window).state().sheet(), "pair", "both");
    act(&mut window, Action::Edit(renamed));
    assert_eq!(editor(&window).state().look.node, Some(("both/one/cut".into(), 0)));
    select(&mut window, &["both"]);
    act(&mut window, Action::Delete);
    assert_ne!(editor(&window).state().look.node, Some(("both/one/cut".into(), 0)));
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().look.node, Some(("both/one/cut".into(), 0)));
}

#[test]
fn groups_are_made_and_unpacked_by_keys_in_one_step() {
    let mut window = open();
    let whole = bits(LINKED);
    select(&mut window, &["soft", "sky"]);
    window.key_press_modifiers(Modifiers::COMMAND, Key::G);
    window.run_steps(4);
    let state = editor(&window).state();
    assert_eq!(state.selection, ["group".to_string()].into());
    assert!(state.sheet().find("soft").is_none() && state.sheet().node("group").unwrap().is_use);
    assert_eq!(bits(text(&window)), whole);
    window.key_press(Key::Enter);
    window.run_steps(4);
    window.get_by_label("group: Group");
    window.get_by_label("Node soft, Clamp");
    let field = window.get_by_label("Name of the group");
    field.focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(Event::Text("Air".into()));
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(4);
    assert_eq!(value(&window, &Path::node("group").to("type")), json!("Air"));
    window.get_by_label("group: Air");
    act(&mut window, Action::Undo);
    act(&mut window, Action::Enter(Vec::new()));
    select(&mut window, &["group"]);
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::G);
    window.run_steps(4);
    let state = editor(&window).state();
    assert_eq!(state.selection, ["sky", "soft"].map(String::from).into());
    assert_eq!(bits(text(&window)), whole);
    act(&mut window, Action::Undo);
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), LINKED);
    // What cannot be grouped is told.
    select(&mut window, &["soft", "pair"]);
    act(&mut window, Action::Group);
    assert!(editor(&window).notices.texts().iter().any(|told| told.contains("sky lies between")));
    assert_eq!(text(&window), LINKED);
}

#[test]
fn a_knob_of_a_node_becomes_one_of_the_group_by_its_menu() {
    let mut window = open();
    act(&mut window, Action::Enter(vec!["pair".into()]));
    select(&mut window, &["two"]);
    let size = window.get_by_label("size").rect().center();
    window.hover_at(size);
    for pressed in [true, false] {
        let (button, modifiers) = (PointerButton::Secondary, Modifiers::NONE);
        window.event(Event::PointerButton { pos: size, button, pressed, modifiers });
        window.run_steps(2);
    }
    window.get_by_label("Make it a knob of the group").click();
    window.run_steps(4);
    let group = Path::default().to("groups").to("Pair");
    assert_eq!(value(&window, &group.to("knobs").to("size").to("default")), json!(0.1));
    assert_eq!(value(&window, &group.to("nodes").to("two").to("size")), json!("= knobs.size"));
    assert_eq!(bits(text(&window)), bits(LINKED));
    act(&mut window, Action::Enter(Vec::new()));
    select(&mut window, &["pair"]);
    assert!(window.query_all_by_label("size").next().is_some(), "the use has the knob");
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), LINKED);
}

#[test]
fn groups_of_included_files_are_looked_at_and_made_local() {
    let folder = tempfile::tempdir().unwrap();
    let groups = serde_json::from_str::<Value>(LINKED).unwrap()["groups"].clone();
    std::fs::create_dir(folder.path().join("lib")).unwrap();
    let library = json!({ "trochoid": 1, "groups": groups }).to_string();
    std::fs::write(folder.path().join("lib/dots.json"), library).unwrap();
    let mut scene = serde_json::from_str::<Value>(LINKED).unwrap();
    scene["include"] = json!(["lib/dots.json"]);
    scene.as_object_mut().unwrap().remove("groups");
    let file = folder.path().join("scene.json");
    std::fs::write(&file, scene.to_string()).unwrap();
    let mut window = window(Session::open(&file).unwrap(), None);
    finished(&mut window);
    assert_eq!(editor(&window).state().evaluated.failed, None);
    let before = text(&window).to_string();
    act(&mut window, Action::Enter(vec!["pair".into(), "one".into()]));
    window.get_by_label("used 3 times, from lib/dots.json");
    let is_size = |field: &egui_kittest::Node<'_>| field.accesskit_node().numeric_value() == Some(0.2);
    let shown = window.get_all_by_role(egui::accesskit::Role::SpinButton).find(is_size).expect("size");
    assert!(shown.accesskit_node().is_disabled(), "its knobs can be read, not changed");
    act(&mut window, Action::Look("pair/one/spot".into(), 0));
    finished(&mut window);
    assert_eq!(editor(&window).state().evaluated.failed, None);
    act(&mut window, Action::Edit(Edit::set(Path::node("lit").to("b"), &json!("#000"))));
    assert_eq!(text(&window), before);
    assert!(editor(&window).notices.texts().iter().any(|told| told.contains("choose Make local")));
    act(&mut window, Action::Enter(vec!["pair".into()]));
    window.get_by_label("Make local").click();
    window.run_steps(4);
    assert_eq!(value(&window, &Path::node("pair").to("type")), json!("Pair2"));
    window.get_by_label("pair: Pair2");
    assert_eq!(editor(&window).state().session.meaning().errors().count(), 0);
    act(&mut window, Action::Edit(Edit::set(Path::node("two").to("size"), &json!(0.2))));
    let size = Path::default().to("groups").to("Pair2").to("nodes").to("two").to("size");
    assert_eq!(value(&window, &size), json!(0.2));
    act(&mut window, Action::Undo);
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), before);
}

#[test]
fn faults_inside_are_shown_at_the_use_and_at_the_node() {
    let broken = LINKED.replace("\"weights\": [\"spot\", \"shape\"]", "\"weights\": [\"spot\", \"shapes\"]");
    assert_ne!(broken, LINKED);
    let mut window = unseen(Session::new(broken, None));
    act(&mut window, Action::Frames);
    window.get_by_label("Error in keyed");
    act(&mut window, Action::Enter(vec!["keyed".into()]));
    window.get_by_label("Error in cut");
    window.get_by_label("Error above lit");
    act(&mut window, Action::Enter(Vec::new()));
    act(&mut window, Action::Visit("pair/two/cut".into()));
    assert_eq!(editor(&window).state().scope, ["pair", "two"]);
    assert!(editor(&window).state().selection.contains("cut"));
}

#[test]
fn a_scope_that_is_gone_is_left() {
    let mut window = open();
    select(&mut window, &["soft", "sky"]);
    act(&mut window, Action::Group);
    act(&mut window, Action::Enter(vec!["group".into()]));
    assert_eq!(editor(&window).state().scope, ["group"]);
    act(&mut window, Action::Undo);
    assert!(editor(&window).state().scope.is_empty());
    act(&mut window, Action::Enter(vec!["nothing".into(), "there".into()]));
    assert!(editor(&window).state().scope.is_empty());
    assert_eq!(text(&window), LINKED);
}

#[test]
fn a_group_of_the_library_comes_with_what_it_uses_by_one_step() {
    let mut window = unseen(dusk());
    let before = text(&window).to_string();
    select(&mut window, &["dusk"]);
    window.key_press(Key::Tab);
    window.run_steps(3);
    window.get_by_label("Node type").type_text("Flock");
    window.run_steps(3);
    window.key_press(Key::Enter);
    window.run_steps(3);
    let sheet = editor(&window).state().session.sheet().clone();
    assert!(sheet.node("flock").is_some_and(|node| node.is_use), "{}", sheet.text);
    assert!(sheet.get(&Path::default().to("groups").to("Gull")).is_some(), "the group that it uses came along");
    let model = sheet.get(&Path::default().to("groups").to("Gull").to("nodes").to("gull").to("file"));
    let model = editor(&window).state().session.folder().join(model.unwrap().as_str().unwrap());
    assert!(model.is_file(), "{}", model.display());
    assert_eq!(editor(&window).state().session.meaning().errors().count(), 0);
    // The document has them now, and is offered no others.
    assert!(["Flock", "Gull"].iter().all(|name| !crate::shipped::is_offered(&sheet, name)));
    act(&mut window, Action::Undo);
    assert_eq!(text(&window), before);
}

#[test]
fn boxes_of_a_group_selected_together_are_no_unknown_nodes() {
    let mut window = open();
    act(&mut window, Action::Enter(vec!["pair".into()]));
    select(&mut window, &["ground", "outputs.color"]);
    window.get_by_label_contains("Boxes of the group's inputs and outputs");
    select(&mut window, &["ground", "one", "two"]);
    window.get_by_label("2 × Dot");
    assert!(window.query_by_label_contains("unknown type").is_none());
}
