use super::DUSK;
use crate::actions::{Action, Pane};
use crate::document::{Path, Session};
use crate::testing::{Window, act, editor, unseen};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};

/// The dusk with a keyed number, a keyed list and a keyed color.
fn keyed() -> String {
    DUSK.replace("\"weight\": 0.25", "\"weight\": { \"keys\": [[1, 0.25],  [4, 0.75], [8, 0.5]] }").replace(
        "\"down\":",
        r##""disc": { "type": "Shape", "shapes": [{ "form": "disc", "center": { "keys": [[2, [0.5, 0.25]], [6, [1, 0.5]]] }, "radius": 0.25 }] },
    "paint": { "type": "Constant", "color": { "keys": [[1, "#102030"], [7, "#405060"]] } },
    "down":"##,
    )
}

/// Opens it with the curves of some nodes.
fn curves(nodes: &[&str]) -> Window {
    let mut window = unseen(Session::new(keyed(), None));
    act(&mut window, Action::Panel(Pane::Curves));
    act(&mut window, Action::Select(nodes.iter().map(|name| (*name).to_string()).collect()));
    window.run_steps(3);
    window
}

fn keys(window: &Window, path: &Path) -> Value {
    editor(window).state().sheet().get(&path.to("keys")).cloned().unwrap_or_default()
}

fn weight() -> Path {
    Path::node("dusk").to("weight")
}

fn center() -> Path {
    Path::node("disc").to("shapes").to(0).to("center")
}

fn place(window: &Window, name: &str) -> Pos2 {
    window.get_by_label(name).rect().center()
}

fn plot(window: &Window) -> egui::Rect {
    window.get_by_label("Curves of keys").rect()
}

fn button(window: &mut Window, pos: Pos2, pressed: bool, modifiers: Modifiers) {
    window.event(Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers });
    window.run_steps(2);
}

/// Presses at a place and drags, without letting go.
fn pull(window: &mut Window, from: Pos2, by: egui::Vec2, modifiers: Modifiers) {
    window.hover_at(from);
    window.run_steps(1);
    window.event(Event::ModifiersChanged(modifiers));
    button(window, from, true, modifiers);
    for step in 1..=4 {
        window.event(Event::PointerMoved(from + by * (step as f32 / 4.0)));
        window.run_steps(1);
    }
}

fn drag(window: &mut Window, from: Pos2, by: egui::Vec2, modifiers: Modifiers) {
    pull(window, from, by, modifiers);
    button(window, from + by, false, modifiers);
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    window.run_steps(2);
}

/// Points on the screen for a frame.
fn frame_width(window: &Window) -> f32 {
    (place(window, "Key 4 of dusk.weight").x - place(window, "Key 1 of dusk.weight").x) / 3.0
}

fn undo(window: &mut Window) {
    act(window, Action::Undo);
}

#[test]
fn a_key_is_dragged_in_one_step_of_undo() {
    let mut window = curves(&["dusk"]);
    let (from, wide) = (place(&window, "Key 4 of dusk.weight"), frame_width(&window));
    drag(&mut window, from, vec2(2.0 * wide, 0.0), Modifiers::SHIFT);
    assert_eq!(keys(&window, &weight()), json!([[1, 0.25], [6, 0.75], [8, 0.5]]));
    let from = place(&window, "Key 6 of dusk.weight");
    // The distance of the two other keys in value is known.
    let tall = place(&window, "Key 1 of dusk.weight").y - from.y;
    drag(&mut window, from, vec2(0.0, 0.5 * tall), Modifiers::SHIFT);
    let moved = keys(&window, &weight())[1][1].as_f64().unwrap();
    assert!((moved - 0.5).abs() < 0.01, "{moved}");
    undo(&mut window);
    undo(&mut window);
    assert_eq!(editor(&window).state().session.text(), keyed());
}

#[test]
fn keys_pass_each_other_and_never_fall_on_one() {
    let mut window = curves(&["dusk"]);
    let wide = frame_width(&window);
    let from = place(&window, "Key 1 of dusk.weight");
    drag(&mut window, from, vec2(3.0 * wide, 0.0), Modifiers::SHIFT);
    assert_eq!(keys(&window, &weight()), json!([[3, 0.25], [4, 0.75], [8, 0.5]]), "it stops beside the key");
    let from = place(&window, "Key 3 of dusk.weight");
    drag(&mut window, from, vec2(2.0 * wide, 0.0), Modifiers::SHIFT);
    assert_eq!(keys(&window, &weight()), json!([[4, 0.75], [5, 0.25], [8, 0.5]]));
}

#[test]
fn esc_in_a_drag_puts_everything_back() {
    let mut window = curves(&["dusk"]);
    let from = place(&window, "Key 4 of dusk.weight");
    pull(&mut window, from, vec2(30.0, 20.0), Modifiers::NONE);
    assert_ne!(editor(&window).state().session.text(), keyed(), "the value follows while it is dragged");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert_eq!(editor(&window).state().session.text(), keyed());
    window.hover_at(from + vec2(60.0, 0.0));
    window.run_steps(2);
    button(&mut window, from + vec2(60.0, 0.0), false, Modifiers::NONE);
    assert_eq!(editor(&window).state().session.text(), keyed(), "the drag has ended");
    assert_eq!(editor(&window).state().session.history().undoes(), None);
}

#[test]
fn keys_in_an_area_are_moved_and_scaled_together() {
    let mut window = curves(&["dusk", "disc"]);
    let inside = plot(&window);
    drag(&mut window, inside.left_top() + vec2(4.0, 26.0), inside.size() - vec2(8.0, 32.0), Modifiers::NONE);
    window.get_by_label("5 keys picked");
    let (from, wide) = (place(&window, "Key 4 of dusk.weight"), frame_width(&window));
    drag(&mut window, from, vec2(wide, 0.0), Modifiers::SHIFT);
    assert_eq!(keys(&window, &weight()), json!([[2, 0.25], [5, 0.75], [9, 0.5]]));
    assert_eq!(keys(&window, &center()), json!([[3, [0.5, 0.25]], [7, [1, 0.5]]]));
    // All in view, the right edge of their frame, around the first key at 2.
    window.key_press(Key::F);
    window.run_steps(3);
    let wide = (place(&window, "Key 5 of dusk.weight").x - place(&window, "Key 2 of dusk.weight").x) / 3.0;
    let right = pos(place(&window, "Key 9 of dusk.weight").x + 11.0, plot(&window).center().y);
    drag(&mut window, right, vec2(7.0 * wide, 0.0), Modifiers::NONE);
    assert_eq!(keys(&window, &weight()), json!([[2, 0.25], [8, 0.75], [16, 0.5]]));
    assert_eq!(keys(&window, &center()), json!([[4, [0.5, 0.25]], [12, [1, 0.5]]]));
    undo(&mut window);
    undo(&mut window);
    assert_eq!(editor(&window).state().session.text(), keyed());
}

fn pos(x: f32, y: f32) -> Pos2 {
    egui::pos2(x, y)
}

#[test]
fn handles_are_dragged_together_and_alone_and_ranges_hold() {
    let mut window = curves(&["dusk"]);
    let (at, wide) = (place(&window, "Key 4 of dusk.weight"), frame_width(&window));
    drag(&mut window, at, vec2(0.0, 0.0), Modifiers::NONE);
    let end = place(&window, "Handle after key 4 of dusk.weight");
    drag(&mut window, end, pos(at.x + 2.0 * wide, at.y) - end, Modifiers::NONE);
    let key = keys(&window, &weight())[1].clone();
    let out = &key[2]["out"];
    assert!((out[0].as_f64().unwrap() - 2.0).abs() < 0.1 && out[1].as_f64().unwrap().abs() < 0.01, "{key}");
    assert!(key[2]["in"][1].as_f64().unwrap().abs() < 0.02, "the other handle turns with it: {key}");
    // Alone, with Alt.
    let end = place(&window, "Handle after key 4 of dusk.weight");
    drag(&mut window, end, vec2(0.0, 25.0), Modifiers::ALT);
    let corner = keys(&window, &weight())[1].clone();
    assert_eq!(corner[2]["in"], key[2]["in"]);
    assert!(corner[2]["out"][1].as_f64().unwrap() < -0.05, "{corner}");
    // V turns both onto one line again; after another V, they are moved one by one.
    let slope = |handle: &Value| handle[1].as_f64().unwrap() / handle[0].as_f64().unwrap();
    window.key_press(Key::V);
    window.run_steps(3);
    let smooth = keys(&window, &weight())[1].clone();
    assert!((slope(&smooth[2]["in"]) - slope(&smooth[2]["out"])).abs() < 1e-3, "{smooth}");
    window.key_press(Key::V);
    window.run_steps(3);
    let end = place(&window, "Handle after key 4 of dusk.weight");
    drag(&mut window, end, vec2(0.0, 25.0), Modifiers::NONE);
    assert_eq!(keys(&window, &weight())[1][2]["in"], smooth[2]["in"]);
    // A mask cannot leave [0, 1].
    let end = place(&window, "Handle after key 4 of dusk.weight");
    pull(&mut window, end, vec2(0.0, -4000.0), Modifiers::ALT);
    window.run_steps(2);
    window.get_by_label_contains("between keys; expected at most 1 at every frame");
    assert!(editor(&window).state().session.meaning().graph.is_some(), "the last legal curve stays");
}

#[test]
fn keys_are_set_and_deleted_without_a_change_of_shape() {
    let mut window = curves(&["dusk"]);
    act(&mut window, Action::Frame(6));
    window.hover_at(plot(&window).center());
    window.run_steps(2);
    window.key_press(Key::K);
    window.run_steps(3);
    assert_eq!(keys(&window, &weight()), json!([[1, 0.25], [4, 0.75], [6, 0.625], [8, 0.5]]));
    let at = place(&window, "Key 6 of dusk.weight");
    drag(&mut window, at, vec2(0.0, 0.0), Modifiers::NONE);
    window.key_press(Key::Delete);
    window.run_steps(3);
    assert_eq!(keys(&window, &weight()), json!([[1, 0.25], [4, 0.75], [8, 0.5]]));
    assert!(editor(&window).state().sheet().find("dusk").is_some(), "the node stays");
    // A double click sets a key where it is.
    let (wide, at) = (frame_width(&window), place(&window, "Key 4 of dusk.weight"));
    let there = pos(at.x + wide, at.y + 40.0);
    window.hover_at(there);
    // Long after the last click.
    window.run_steps(40);
    for pressed in [true, false, true, false] {
        window.event(Event::PointerButton {
            pos: there,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
        window.run_steps(1);
    }
    window.run_steps(2);
    assert_eq!(keys(&window, &weight())[2][0], 5);
    // All keys: the value stays as it is at this frame.
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.run_steps(2);
    window.key_press(Key::Delete);
    window.run_steps(3);
    assert_eq!(editor(&window).state().sheet().get(&weight()), Some(&json!(0.625)));
}

#[test]
fn interpolation_and_handles_come_from_menus() {
    let mut window = curves(&["dusk"]);
    let at = place(&window, "Key 1 of dusk.weight");
    drag(&mut window, at, vec2(0.0, 0.0), Modifiers::NONE);
    window.get_by_label("Interpolation").click();
    window.run_steps(3);
    window.get_by_label("hold").click();
    window.run_steps(3);
    assert_eq!(keys(&window, &weight())[0], json!([1, 0.25, { "interpolation": "hold" }]));
    let at = place(&window, "Key 8 of dusk.weight");
    drag(&mut window, at, vec2(0.0, 0.0), Modifiers::NONE);
    window.get_by_label("Handles").click();
    window.run_steps(3);
    window.get_by_label("Level handles").click();
    window.run_steps(3);
    let key = keys(&window, &weight())[2].clone();
    assert_eq!(key[2]["in"][1], 0, "{key}");
    assert!(editor(&window).state().session.meaning().graph.is_some());
}

#[test]
fn keys_are_copied_as_text_and_pasted_at_the_frame() {
    let mut window = curves(&["dusk"]);
    let from = place(&window, "Key 1 of dusk.weight");
    drag(&mut window, from, vec2(0.0, 0.0), Modifiers::NONE);
    let second = place(&window, "Key 4 of dusk.weight");
    drag(&mut window, second, vec2(0.0, 0.0), Modifiers::SHIFT);
    window.get_by_label("2 keys picked");
    window.event(Event::Copy);
    window.run_steps(1);
    let copied = window.output().platform_output.commands.iter().find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    });
    assert_eq!(copied.as_deref(), Some(r#"{ "keys": [[1, 0.25], [4, 0.75]] }"#));
    act(&mut window, Action::Frame(10));
    window.event(Event::Paste(copied.unwrap()));
    window.run_steps(3);
    assert_eq!(keys(&window, &weight()), json!([[1, 0.25], [4, 0.75], [8, 0.5], [10, 0.25], [13, 0.75]]));
    window.event(Event::Paste("hello".into()));
    window.run_steps(3);
    window.get_by_label_contains("The clipboard contains no keys");
}

#[test]
fn frame_and_value_of_a_key_are_typed() {
    let mut window = curves(&["dusk"]);
    let at = place(&window, "Key 4 of dusk.weight");
    drag(&mut window, at, vec2(0.0, 0.0), Modifiers::NONE);
    let typed = |window: &mut Window, number: f64, text: &str| {
        let below = plot(window).bottom();
        let fields = window.get_all_by_role(egui::accesskit::Role::SpinButton);
        let field = fields
            .filter(|field| field.rect().top() >= below && field.accesskit_node().numeric_value() == Some(number));
        let at = field.map(|field| field.rect().center()).next().unwrap();
        drag(window, at, vec2(0.0, 0.0), Modifiers::NONE);
        window.event(Event::Text(text.into()));
        window.run_steps(2);
        window.key_press(Key::Enter);
        window.run_steps(3);
    };
    typed(&mut window, 4.0, "6");
    assert_eq!(keys(&window, &weight()), json!([[1, 0.25], [6, 0.75], [8, 0.5]]));
    typed(&mut window, 0.75, "1/2");
    assert_eq!(keys(&window, &weight()), json!([[1, 0.25], [6, 0.5], [8, 0.5]]));
    typed(&mut window, 6.0, "8");
    window.get_by_label_contains("expected a frame without another key");
    assert_eq!(keys(&window, &weight()), json!([[1, 0.25], [6, 0.5], [8, 0.5]]));
}

#[test]
fn rows_of_the_dope_sheet_are_moved_with_the_keys_of_colors() {
    let mut window = curves(&[]);
    window.get_by_label("Dope sheet").click();
    window.run_steps(3);
    let wide = frame_width(&window);
    let color = Path::node("paint").to("color");
    let from = place(&window, "Key 7 of paint.color");
    drag(&mut window, from, vec2(-2.0 * wide, 0.0), Modifiers::NONE);
    assert_eq!(keys(&window, &color), json!([[1, "#102030"], [5, "#405060"]]));
    window.get_by_label("All keys").click();
    window.run_steps(3);
    window.get_by_label("7 keys picked");
    let from = place(&window, "Key 5 of paint.color");
    drag(&mut window, from, vec2(3.0 * wide, 30.0), Modifiers::NONE);
    assert_eq!(keys(&window, &color), json!([[4, "#102030"], [8, "#405060"]]));
    assert_eq!(keys(&window, &weight()), json!([[4, 0.25], [7, 0.75], [11, 0.5]]), "values stay");
    assert_eq!(keys(&window, &center()), json!([[5, [0.5, 0.25]], [9, [1, 0.5]]]));
    undo(&mut window);
    undo(&mut window);
    assert_eq!(editor(&window).state().session.text(), keyed());
    // A key set in a color has the color of its frame.
    let at = place(&window, "Key 7 of paint.color");
    drag(&mut window, at, vec2(0.0, 0.0), Modifiers::NONE);
    act(&mut window, Action::Frame(4));
    window.key_press(Key::K);
    window.run_steps(3);
    assert_eq!(keys(&window, &color), json!([[1, "#102030"], [4, "#283848"], [7, "#405060"]]));
}

#[test]
fn a_tick_hides_a_curve_and_brackets_go_from_key_to_key() {
    let mut window = curves(&["dusk", "disc"]);
    window.get_by_label("Key 2 of disc.shapes[0].center[1]");
    window.get_by_role_and_label(egui::accesskit::Role::CheckBox, "disc.shapes[0].center").click();
    window.run_steps(3);
    assert!(window.query_by_label("Key 2 of disc.shapes[0].center[1]").is_none());
    window.get_by_label("Key 4 of dusk.weight");
    let mut seen = Vec::new();
    for key in [Key::CloseBracket, Key::CloseBracket, Key::CloseBracket, Key::OpenBracket] {
        window.key_press(key);
        window.run_steps(2);
        seen.push(editor(&window).state().frame);
    }
    assert_eq!(seen, [2, 4, 6, 4], "frames with keys of what is selected");
}

#[test]
fn whatever_is_dragged_undo_takes_back_byte_by_byte() {
    let mut random = Pcg64Mcg::seed_from_u64(26);
    let mut all = 0;
    for round in 0..6 {
        let mut window = curves(&["dusk", "disc", "paint"]);
        if round % 2 == 1 {
            window.get_by_label("Dope sheet").click();
            window.run_steps(3);
        }
        let mut changes = 0;
        for _ in 0..12 {
            let names: Vec<Pos2> = window.get_all_by_label_contains(" of ").map(|mark| mark.rect().center()).collect();
            let from = names[random.random_range(0..names.len())];
            let by = vec2(random.random_range(-90.0..90.0), random.random_range(-60.0..60.0));
            let modifiers = [Modifiers::NONE, Modifiers::SHIFT, Modifiers::ALT][random.random_range(0..3)];
            let before = editor(&window).state().session.text().to_string();
            drag(&mut window, from, by, modifiers);
            changes += usize::from(editor(&window).state().session.text() != before);
            for (path, count) in [(weight(), 3), (center(), 2), (Path::node("paint").to("color"), 2)] {
                let keys = keys(&window, &path);
                let frames: Vec<f64> = keys.as_array().unwrap().iter().map(|key| key[0].as_f64().unwrap()).collect();
                assert!(frames.len() == count && frames.windows(2).all(|pair| pair[0] < pair[1]), "{keys}");
                assert!(frames.iter().all(|frame| frame.fract() == 0.0), "{keys}");
            }
            assert!(editor(&window).state().session.meaning().graph.is_some(), "no gesture makes an error");
        }
        all += changes;
        for _ in 0..changes {
            undo(&mut window);
        }
        assert_eq!(editor(&window).state().session.text(), keyed());
        assert_eq!(editor(&window).state().session.history().undoes(), None, "a drag is one step");
    }
    assert!(all > 20, "{all} changes");
}

#[test]
fn many_curves_are_shown_as_they_are_chosen() {
    let node = |index: usize| {
        let keys = |low: f64| json!({ "keys": [[1, low], [8, low + 0.1]] });
        let body = json!({ "type": "Clamp", "field": "down", "min": keys(0.0), "max": keys(0.5) });
        format!("\"edge{index}\": {body}, \"down\":")
    };
    let text = (0..13).fold(DUSK.to_string(), |text, index| text.replacen("\"down\":", &node(index), 1));
    let mut window = unseen(Session::new(text, None));
    act(&mut window, Action::Panel(Pane::Curves));
    window.run_steps(3);
    let shown = |window: &Window, name: &str| window.query_by_label(&format!("Key 1 of {name}")).is_some();
    let tick = |window: &mut Window, name: &str| {
        window.get_by_role_and_label(egui::accesskit::Role::CheckBox, name).click();
        window.run_steps(3);
    };
    assert!(!shown(&window, "edge1.min") && !shown(&window, "edge0.max"));
    tick(&mut window, "edge1.min");
    assert!(shown(&window, "edge1.min") && !shown(&window, "edge1.max"));
    tick(&mut window, "Curves of edge1");
    assert!(shown(&window, "edge1.min") && shown(&window, "edge1.max"));
    tick(&mut window, "Curves of edge1");
    assert!(!shown(&window, "edge1.min") && !shown(&window, "edge1.max"));
    // What is selected is shown without being chosen.
    act(&mut window, Action::Select(["edge3".to_string()].into()));
    assert!(shown(&window, "edge3.min") && shown(&window, "edge3.max"));
}

#[test]
fn a_keyed_color_is_three_curves_whose_keys_move_in_time() {
    let mut window = curves(&["paint"]);
    let key = |window: &Window, frame: i64, part: usize| place(window, &format!("Key {frame} of paint.color[{part}]"));
    let [red, green, blue] = [0, 1, 2].map(|part| key(&window, 1, part));
    assert!(red.y > green.y && green.y > blue.y && red.x == blue.x, "#102030 is bluer than red");
    let wide = (key(&window, 7, 1).x - green.x) / 6.0;
    drag(&mut window, green, vec2(2.0 * wide, -40.0), Modifiers::NONE);
    let path = Path::node("paint").to("color");
    assert_eq!(keys(&window, &path), json!([[3, "#102030"], [7, "#405060"]]));
    undo(&mut window);
    window.get_by_label("Handles").click();
    window.run_steps(3);
    window.get_by_label("Smooth handles").click();
    window.run_steps(3);
    assert_eq!(editor(&window).state().session.text(), keyed(), "colors have no handles here");
}
