use super::{DUSK, dusk};
use crate::actions::{Action, Pane, Switch};
use crate::document::{Path, Session};
use crate::testing::{Window, act, editor, finished, sized, unseen, window};
use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use serde_json::json;

fn choose(window: &mut Window, name: &str) {
    act(window, Action::Select([name.to_string()].into()));
}

#[test]
fn a_picture_comes_and_says_that_nothing_left_the_palette() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    window.run_steps(2);
    window.get_by_label("0 outside the palette");
    window.get_by_label("No errors");
}

#[test]
fn no_count_is_shown_while_the_picture_has_an_error() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    let broken = DUSK.replace("\"dusk\": {", "\"dusk\": { \"unheard\": 1,");
    assert_ne!(broken, DUSK);
    act(&mut window, Action::Rewrite(broken));
    finished(&mut window);
    window.run_steps(2);
    assert!(editor(&window).state().evaluated.failed.is_some());
    assert!(window.query_by_label("0 outside the palette").is_none());
    act(&mut window, Action::Undo);
    finished(&mut window);
    window.run_steps(2);
    window.get_by_label("0 outside the palette");
    act(&mut window, Action::Rewrite("no JSON".into()));
    finished(&mut window);
    window.run_steps(2);
    assert!(window.query_by_label("0 outside the palette").is_none());
    assert!(editor(&window).state().evaluated.last.is_some(), "the last picture stays visible");
    act(&mut window, Action::Undo);
    finished(&mut window);
    window.run_steps(2);
    window.get_by_label("0 outside the palette");
}

#[test]
fn every_type_of_node_has_its_knobs() {
    let mut window = window(dusk(), None);
    for name in trochoid::registry().names() {
        let declaration = trochoid::registry().get(name).unwrap().declaration();
        let (edit, node) = crate::document::edit::added(editor(&window).state().sheet(), declaration, [0.0, 0.0]);
        act(&mut window, Action::Edit(edit));
        choose(&mut window, &node);
        for item in declaration.items.iter().filter(|item| matches!(item, trochoid::Item::Knob(_))) {
            let label = item.name().replace('_', " ");
            assert!(window.query_all_by_label(&label).next().is_some(), "{name} shows {label}");
        }
        act(&mut window, Action::Undo);
    }
}

#[test]
fn a_name_is_typed_and_everything_follows() {
    let mut window = window(dusk(), None);
    choose(&mut window, "sky");
    let field = window.get_all_by_value("sky").next().unwrap();
    field.focus();
    field.type_text("line");
    window.run_steps(2);
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
    let state = editor(&window).state();
    let renamed = state.sheet().nodes[1].name.clone();
    assert!(renamed.contains("line"), "{renamed}");
    assert_eq!(state.sheet().get(&Path::node("dusk").to("a")), Some(&json!(renamed)));
    assert!(state.selection.contains(&renamed));
}

#[test]
fn a_number_can_be_typed_although_its_first_digits_are_a_fault() {
    let text = DUSK.replace(
        r#""down": {"#,
        r#""band": { "type": "Clamp", "field": "down", "min": 0.25, "max": 0.75 },
    "down": {"#,
    );
    let text = text.replace(r#""weight": "down""#, r#""weight": "band""#);
    let mut window = window(Session::new(text, None), None);
    choose(&mut window, "band");
    window.get_by_value("0.75").focus();
    window.run_steps(2);
    let max = |window: &Window| {
        let sheet = editor(window).state().sheet();
        sheet.get(&Path::node("band").to("max")).and_then(serde_json::Value::as_f64)
    };
    for key in ["0", ".", "5"] {
        window.event(egui::Event::Text(key.into()));
        window.run_steps(3);
        assert_eq!(max(&window), Some(0.75), "an incomplete number changes nothing");
    }
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
    assert_eq!(max(&window), Some(0.5));
    act(&mut window, Action::Undo);
    assert_eq!(max(&window), Some(0.75), "undone in one step");
}

#[test]
fn a_faulty_document_says_where() {
    let mut window = window(Session::new(DUSK.replace("\"sky\", \"b\"", "\"skyy\", \"b\""), None), None);
    finished(&mut window);
    window.run_steps(2);
    window.get_by_label("1 error").click();
    window.run_steps(3);
    assert!(editor(&window).state().selection.contains("dusk"), "the faulty node is selected");
    assert!(editor(&window).state().evaluated.failed.is_some());
}

#[test]
fn a_text_that_is_typed_becomes_the_document() {
    let mut window = window(dusk(), None);
    act(&mut window, Action::Panel(Pane::Text));
    act(&mut window, Action::Rewrite(DUSK.replace("0.25", "0.5")));
    assert!(editor(&window).state().session.text().contains("0.5"));
    act(&mut window, Action::Rewrite("{ \"trochoid\": 1, ".into()));
    window.get_by_label("1 error");
    act(&mut window, Action::Undo);
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().session.text(), DUSK);
}

#[test]
fn all_panels_can_be_shown_in_both_themes() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    // What only this panel shows.
    let shows = |window: &Window, pane: Pane| {
        let label = match pane {
            Pane::Viewer => "Picture",
            Pane::Second => "Picture 2",
            Pane::Canvas => "Node dusk, Mix",
            Pane::Properties => "Select a node to see its knobs.",
            Pane::Palette => "0 colors with names, 3 without",
            Pane::Curves => "Nothing here has keys. The diamond beside a knob in Properties sets one.",
            Pane::Waves => "The document has no sea. Add a GerstnerSea or a ToonSea (Tab in the graph).",
            Pane::Report => "Left out",
            Pane::Text => "Revert",
            Pane::Help => "Keys and commands",
        };
        window.query_by_label(label).is_some()
    };
    let mut themes = Vec::new();
    for _ in 0..2 {
        themes.push(window.ctx.theme());
        for pane in Pane::ALL {
            // The user closes its tab.
            let tree = &mut window.state_mut().as_mut().unwrap().tree;
            let tile = tree.tiles.find_pane(&pane).unwrap();
            tree.set_visible(tile, false);
            window.run_steps(3);
            assert!(!shows(&window, pane), "{pane:?} is closed");
            act(&mut window, Action::Panel(pane));
            let shown: Vec<Pane> = Pane::ALL.into_iter().filter(|pane| shows(&window, *pane)).collect();
            // The viewer and the graph lie beside the tabs; the curves take the place of the graph.
            let expected = match pane {
                Pane::Viewer | Pane::Canvas => vec![Pane::Viewer, Pane::Canvas],
                Pane::Curves => vec![Pane::Viewer, Pane::Curves],
                tab => vec![Pane::Viewer, Pane::Canvas, tab],
            };
            let count = if pane == Pane::Second { 4 } else { 3 };
            assert!(expected.iter().all(|pane| shown.contains(pane)) && shown.len() == count, "{pane:?}: {shown:?}");
            if pane == Pane::Second {
                window.get_by_label("Viewer 2");
                window.state_mut().as_mut().unwrap().tree.set_visible(tile, false);
            }
            act(&mut window, Action::Panel(Pane::Canvas));
        }
        act(&mut window, Action::Theme);
    }
    assert_eq!(themes.len(), 2);
    assert_ne!(themes[0], themes[1]);
}

#[test]
fn a_window_at_rest_draws_nothing() {
    let mut window = window(dusk(), None);
    finished(&mut window);
    // Thumbnails and fades still follow the picture for a short time.
    let started = std::time::Instant::now();
    let mut quiet = 0;
    while quiet < 10 {
        window.step();
        quiet = if window.ctx.has_requested_repaint() { 0 } else { quiet + 1 };
        std::thread::sleep(std::time::Duration::from_millis(2));
        let causes = window.ctx.repaint_causes();
        assert!(started.elapsed().as_secs() < 60, "still asked for frames: {causes:?}");
    }
}

#[test]
fn a_narrow_window_cuts_nothing_off() {
    for chosen in [None, Some("sky"), Some("dusk")] {
        let mut window = sized(dusk(), None, [780.0, 640.0]);
        finished(&mut window);
        window.state_mut().as_mut().unwrap().select(chosen.as_slice());
        window.run_steps(3);
        // Tabs may extend beyond the edge, because they scroll.
        let tabs = window.query_all_by_label("Properties").next().unwrap().rect().bottom();
        for role in [Role::SpinButton, Role::Slider, Role::Button, Role::TextInput, Role::ComboBox, Role::CheckBox] {
            for widget in window.query_all_by_role(role) {
                let place = widget.rect();
                assert!(place.right() <= 780.0 || place.top() < tabs, "{chosen:?}: {widget:?}");
            }
        }
    }
}

#[test]
fn the_toolbar_of_a_narrow_viewer_has_a_menu_for_the_rest() {
    let mut wide = window(dusk(), None);
    finished(&mut wide);
    assert!(wide.query_by_label("More").is_none());
    let line = wide.get_by_label("RGB").rect().center().y;
    assert!((wide.get_by_label("Near").rect().center().y - line).abs() < 2.0);
    let mut narrow = sized(dusk(), None, [780.0, 640.0]);
    finished(&mut narrow);
    narrow.run_steps(2);
    assert!(narrow.query_by_label("Near").is_none());
    let line = narrow.get_by_label("RGB").rect().center().y;
    let more = narrow.get_by_label("More");
    assert!((more.rect().center().y - line).abs() < 2.0, "one line");
    more.click();
    narrow.run_steps(3);
    narrow.get_by_label("Hold A").click();
    narrow.run_steps(3);
    // The menu stays open, and now has the controls of the held picture.
    narrow.get_by_label("Diff");
    narrow.get_by_label("Near");
}

#[test]
fn the_toolbar_of_the_viewer_stays_one_line_when_tools_are_added() {
    for width in (840..1280).step_by(20) {
        let mut window = sized(dusk(), None, [width as f32, 640.0]);
        finished(&mut window);
        for switch in [Switch::Hold, Switch::Difference, Switch::Near] {
            act(&mut window, Action::Viewer(switch));
            window.run_steps(3);
            let line = window.get_by_label("RGB").rect().center().y;
            for label in ["1:1", "Region", "Hold A", "Diff", "Hull", "Near", "More", "More •"] {
                for tool in window.query_all_by_label(label).filter(|tool| tool.rect().top() < line + 60.0) {
                    assert!((tool.rect().center().y - line).abs() < 2.0, "{label} at {width}, after {switch:?}");
                }
            }
        }
    }
}

#[test]
fn a_typed_number_is_one_key_at_the_frame_where_typing_began() {
    let text = DUSK.replace("\"weight\": 0.25", "\"weight\": { \"keys\": [[1, 0], [5, 1]] }");
    assert_ne!(text, DUSK);
    let mut window = window(Session::new(text, None), None);
    choose(&mut window, "dusk");
    act(&mut window, Action::Frame(3));
    let keys =
        |window: &Window| editor(window).state().sheet().get(&Path::node("dusk").to("weight").to("keys")).cloned();
    let fields: Vec<egui::Rect> = window
        .get_all_by_role(Role::SpinButton)
        .filter(|node| node.accesskit_node().numeric_value() == Some(0.5))
        .map(|node| node.rect())
        .collect();
    let at = fields.last().unwrap().center();
    window.hover_at(at);
    for pressed in [true, false] {
        let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
        window.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
        window.step();
    }
    window.run_steps(2);
    window.event(egui::Event::Text("0.".into()));
    act(&mut window, Action::Frame(4));
    window.event(egui::Event::Text("75".into()));
    window.run_steps(2);
    assert_eq!(keys(&window), Some(json!([[1, 0], [5, 1]])), "nothing is set while it is typed");
    act(&mut window, Action::Frame(6));
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
    assert_eq!(keys(&window), Some(json!([[1, 0], [3, 0.75], [5, 1]])));
}

#[test]
fn the_timeline_of_a_still_has_its_one_frame() {
    let frames = |text: &str| {
        let window = unseen(Session::new(text.into(), None));
        let strip = window.get_by_label("Timeline");
        let node = strip.accesskit_node();
        (node.min_numeric_value().unwrap(), node.max_numeric_value().unwrap())
    };
    let still = DUSK.replace("  \"frames\": { \"first\": 1, \"last\": 8, \"fps\": 24 },\n", "");
    assert_ne!(still, DUSK);
    assert_eq!(frames(&still), (1.0, 1.0));
    assert_eq!(frames(&DUSK.replace("\"first\": 1, \"last\": 8", "\"first\": 7, \"last\": 7")), (7.0, 7.0));
    assert_eq!(frames(DUSK), (1.0, 8.0));
    // A press anywhere selects that frame.
    let mut window = unseen(Session::new(still, None));
    let strip = window.get_by_label("Timeline").rect();
    for at in [strip.left() + 20.0, strip.right() - 20.0] {
        let at = egui::pos2(at, strip.center().y);
        window.hover_at(at);
        for pressed in [true, false] {
            let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
            window.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
            window.run_steps(2);
        }
        assert_eq!(editor(&window).state().frame, 1);
    }
}

#[test]
fn nothing_moves_under_the_pointer_when_something_is_said_late() {
    // A fault of the selected node.
    let mut window = unseen(dusk());
    choose(&mut window, "dusk");
    let weight = |window: &Window| super::typing::fields(window, "weight");
    let before = weight(&window);
    assert_eq!(before.len(), 1);
    act(&mut window, Action::Rewrite(DUSK.replace("\"a\": \"sky\"", "\"a\": \"skyy\"")));
    window.get_by_label_contains("found a reference to \"skyy\"");
    assert_eq!(weight(&window), before);
    act(&mut window, Action::Undo);
    assert_eq!(weight(&window), before);
    // The weighing of the picture, in a narrow palette.
    let mut window = crate::testing::unseen_in(dusk(), [800.0, 640.0]);
    act(&mut window, Action::Panel(Pane::Palette));
    let color = |window: &Window| window.get_by_label("Swatch #14262e").rect();
    let before = color(&window);
    let say = |window: &mut Window, mixing: Option<f32>, unmixed: Option<&str>| {
        let seen = &mut window.state_mut().as_mut().unwrap().state.evaluated;
        (seen.mixing, seen.unmixed) = (mixing, unmixed.map(String::from));
        window.step();
    };
    say(&mut window, Some(0.25), None);
    window.get_by_label("weighing the picture, 25 %");
    assert_eq!(color(&window), before);
    say(&mut window, None, Some("The picture has no weights."));
    window.get_by_label("no shares");
    assert_eq!(color(&window), before);
}
