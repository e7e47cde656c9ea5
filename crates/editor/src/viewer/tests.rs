//! Tests of the viewer, driven by simulated clicks and keys.

mod boxes;

use super::scene::{Eye, Pose};
use crate::actions::{Action, Switch};
use crate::commands::{Command, commands};
use crate::document::swatches::SwatchKey;
use crate::document::{Path, Session};
use crate::evaluate::{Channel, Display, Origin};
use crate::testing::{Window, ask, editor, sized, until};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, pos2, vec2};
use egui_kittest::kittest::Queryable;

pub(super) const WINDOW: [f32; 2] = [1280.0, 800.0];

/// A picture of three control colors.
const MIXED: &str = r##"{
  "trochoid": 1, "format": { "width": 64, "height": 36 },
  "nodes": {
    "across": { "type": "ScreenX" },
    "first": { "type": "Mix", "a": "#ff0000", "b": "#0000ff", "weight": "across" },
    "last": { "type": "Mix", "a": "first", "b": "#00ff00", "weight": 0.25 },
    "dark": { "type": "Mix", "a": "#000000", "b": "#ffffff", "weight": 0.25 }
  },
  "outputs": { "beauty": { "color": "last" } }
}"##;

/// A sea with one guide.
pub(crate) const SEA: &str = r##"{
  "trochoid": 1, "format": { "width": 64, "height": 36 },
  "nodes": {
    "camera": { "type": "Camera", "position": [5, 8, 16], "target": [5, 0, 5] },
    "waves": {
      "type": "ToonSea", "columns": 40, "rows": 40, "spacing": 0.25, "preroll": 8,
      "guides": [{ "path": [2, 5, 4, 5, 6, 5, 8, 5], "count": 2, "width": 2 }]
    },
    "view": { "type": "Render", "camera": "camera", "surfaces": ["waves"] },
    "sea": { "type": "Mix", "a": "#102030", "b": "#e0e0d0", "weight": "view.coverage" }
  },
  "outputs": { "beauty": { "color": "sea" } }
}"##;

pub(super) fn open(text: &str, size: [f32; 2]) -> Window {
    let mut window = sized(Session::new(text.into(), None), None, size);
    settle(&mut window);
    window
}

pub(super) fn act(window: &mut Window, action: Action) {
    ask(window, action);
    settle(window);
}

/// Draws until all is evaluated.
pub(super) fn settle(window: &mut Window) {
    window.step();
    until(window, "what is evaluated", |editor| {
        let (seen, look) = (&editor.state().evaluated, &editor.state().look);
        let is_color = seen.result.as_ref().is_some_and(|result| result.picture.kind == trochoid::Kind::Color);
        let is_blamed = !is_color || look.pick.is_none() || seen.blame.as_ref().map(|blamed| blamed.at) == look.pick;
        let is_done = seen.result.as_ref().is_some_and(|result| result.finished && result.display == look.display);
        seen.progress.is_none() && (seen.failed.is_some() || (is_done && is_blamed))
    });
    // Draws the latest result.
    window.run_steps(2);
}

pub(super) fn picture(window: &Window) -> Rect {
    window.get_by_label("Picture").rect()
}

pub(super) fn press(window: &mut Window, key: Key) {
    window.key_press(key);
    settle(window);
}

pub(super) fn hover(window: &mut Window, at: Pos2) {
    window.hover_at(at);
    window.step();
}

pub(super) fn button(window: &mut Window, pos: Pos2, pressed: bool, modifiers: Modifiers) {
    window.event(Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers });
    window.step();
}

pub(super) fn click(window: &mut Window, at: Pos2) {
    hover(window, at);
    button(window, at, true, Modifiers::NONE);
    button(window, at, false, Modifiers::NONE);
    settle(window);
}

pub(super) fn drag(window: &mut Window, from: Pos2, to: Pos2, modifiers: Modifiers) {
    window.event(Event::ModifiersChanged(modifiers));
    hover(window, from);
    button(window, from, true, modifiers);
    for step in 1..=4 {
        hover(window, from + (to - from) * (step as f32 / 4.0));
    }
    button(window, to, false, modifiers);
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    settle(window);
}

#[test]
fn a_pixel_is_picked_and_its_colors_listed() {
    let mut window = open(MIXED, WINDOW);
    let center = picture(&window).center() + vec2(3.0, 3.0);
    click(&mut window, center);
    let state = editor(&window).state();
    let blamed = state.evaluated.blame.as_ref().unwrap();
    assert_eq!(blamed.pixel, [32, 18]);
    let sum: f64 = blamed.shares.iter().map(|share| share.weight).sum();
    assert!((sum - 1.0).abs() < 1e-12);
    let origins: Vec<&Origin> = blamed.shares.iter().map(|share| &share.of).collect();
    assert_eq!(origins, [&Origin::Node("first".into()), &Origin::Node("first".into()), &Origin::Node("last".into())]);
    for text in ["Pixel 32, 18", "25.0 %", "Mixed of", "Color in linear-srgb", "first · a", "first · b", "last · b"]
    {
        assert!(window.query_by_label(text).is_some(), "{text}");
    }
    // The pixel is half a pixel right of the middle, so the shares are 38.1, 36.9 and 25 percent.
    assert!(window.query_by_label("38.1 %").is_some() && window.query_by_label("36.9 %").is_some());
    hover(&mut window, center);
    press(&mut window, Key::Escape);
    assert_eq!(editor(&window).state().look.pick, None);
    assert!(window.query_by_label("Mixed of").is_none());
}

/// A blurred picture of a color with a name and one without.
const NAMED: &str = r##"{ "trochoid": 1, "format": { "width": 64, "height": 36 }, "working_space": "srgb",
  "palette": { "ink": "#102030" },
  "nodes": { "across": { "type": "ScreenX" },
             "mix": { "type": "Mix", "a": "palette.ink", "b": "#f0e0d0", "weight": "across" },
             "soft": { "type": "Blur", "image": "mix", "size": 6 } },
  "outputs": { "beauty": { "color": "soft" } } }"##;

#[test]
fn the_colors_of_a_pixel_have_their_names_through_filters() {
    let mut window = open(NAMED, WINDOW);
    let center = picture(&window).center();
    click(&mut window, center);
    let state = editor(&window).state();
    let shares = &state.evaluated.blame.as_ref().unwrap().shares;
    let origins: Vec<&Origin> = shares.iter().map(|share| &share.of).collect();
    assert!(origins.contains(&&Origin::Palette("ink".into())), "{shares:?}");
    assert!(origins.contains(&&Origin::Node("mix".into())), "{shares:?}");
    assert_eq!((shares.len(), shares.iter().map(|share| share.weight).sum::<f64>()), (2, 1.0));
    // A click shows the color in the palette.
    window.get_by_label("ink").click();
    settle(&mut window);
    assert_eq!(editor(&window).state().colors.chosen, Some(SwatchKey::Named("ink".into())));
}

#[test]
fn clicking_a_share_chooses_its_node() {
    let mut window = open(MIXED, WINDOW);
    let center = picture(&window).center();
    click(&mut window, center);
    let row = window.get_by_label("last · b").rect().center();
    click(&mut window, row);
    assert_eq!(editor(&window).state().chosen(), Some("last"));
}

#[test]
fn keys_choose_channels_where_the_pointer_is() {
    let mut window = open(MIXED, WINDOW);
    let channel = |window: &Window| editor(window).state().look.display.channel;
    let center = picture(&window).center();
    hover(&mut window, center);
    for (key, expected) in [
        (Key::R, Channel::One(0)),
        (Key::G, Channel::One(1)),
        (Key::G, Channel::All),
        (Key::B, Channel::One(2)),
        (Key::Y, Channel::Luminance),
        (Key::Y, Channel::All),
    ] {
        press(&mut window, key);
        assert_eq!(channel(&window), expected, "{key:?}");
    }
    hover(&mut window, pos2(1200.0, 400.0));
    press(&mut window, Key::R);
    assert_eq!(channel(&window), Channel::All);
}

#[test]
fn a_region_is_dragged_and_cleared() {
    let mut window = open(MIXED, WINDOW);
    let area = picture(&window);
    let (from, to) = (area.center(), area.center() + vec2(60.0, 40.0));
    drag(&mut window, from, to, Modifiers::SHIFT);
    let state = editor(&window).state();
    let region = state.look.region.unwrap();
    assert!((region[0] - 0.5).abs() < 0.02 && region[2] > 0.52 && region[3] > region[1], "{region:?}");
    assert_eq!(state.look.pick, None);
    let evaluated = state.evaluated.result.as_ref().unwrap().picture.planes[0].window();
    assert!(evaluated.width() < 64 && evaluated.x0 >= 31, "{evaluated:?}");
    window.key_press_modifiers(Modifiers::SHIFT, Key::W);
    settle(&mut window);
    assert_eq!(editor(&window).state().look.region, None);
    // After a click on the button, the next drag draws a region; the one after that does not.
    window.get_by_label("Region").click();
    settle(&mut window);
    drag(&mut window, from, to, Modifiers::NONE);
    assert!(editor(&window).state().look.region.is_some());
    drag(&mut window, from, to, Modifiers::NONE);
    assert_eq!(editor(&window).state().look.region, Some(region));
    window.get_by_label("Region").click();
    settle(&mut window);
    assert_eq!(editor(&window).state().look.region, None);
}

#[test]
fn a_color_taken_from_the_picture_goes_where_it_was_asked_for() {
    let mut window = open(MIXED, WINDOW);
    act(&mut window, Action::Look("dark".into(), 0));
    let place = Path::node("first").to("a");
    act(&mut window, Action::Dropper(Some(place.clone())));
    assert!(window.query_by_label("Click a color for first.a").is_some());
    let center = picture(&window).center();
    click(&mut window, center);
    let state = editor(&window).state();
    assert_eq!(state.dropper, None);
    // 25 % of white in linear light.
    assert_eq!(state.sheet().get(&place).unwrap(), "#898989");
    assert_eq!(state.look.pick, None);
    act(&mut window, Action::Undo);
    assert_eq!(editor(&window).state().sheet().get(&place).unwrap(), "#ff0000");
}

#[test]
fn two_pictures_are_compared() {
    let mut window = open(MIXED, WINDOW);
    window.get_by_label("Hold A").click();
    settle(&mut window);
    act(&mut window, Action::Look("dark".into(), 0));
    let line = window.get_by_label("Wipe line").rect().center();
    let area = picture(&window);
    assert!((line.x - area.center().x).abs() < 2.0);
    drag(&mut window, line, line + vec2(80.0, 0.0), Modifiers::NONE);
    let moved = window.get_by_label("Wipe line").rect().center();
    assert!((moved.x - line.x - 80.0).abs() < 3.0, "{moved:?}");
    assert_eq!(editor(&window).state().look.pick, None);
    window.get_by_label("Diff").click();
    settle(&mut window);
    assert!(window.query_by_label("Wipe line").is_none());
    window.get_by_label("Release A").click();
    settle(&mut window);
    assert!(window.query_by_label("Diff").is_none());
}

#[test]
fn the_held_picture_is_shown_as_the_present_one_is() {
    for (node, display) in [
        ("last", Display { exposure: 2.0, ..Display::default() }),
        ("last", Display { channel: Channel::One(1), gamma: 2.0, ..Display::default() }),
        ("across", Display { false_color: true, range: Some([0.0, 3.0]), ..Display::default() }),
    ] {
        let mut window = open(MIXED, WINDOW);
        act(&mut window, Action::Look(node.into(), 0));
        window.get_by_label("Hold A").click();
        settle(&mut window);
        window.get_by_label("Diff").click();
        settle(&mut window);
        act(&mut window, Action::Display(display.clone()));
        until(&mut window, "the held picture", |editor| {
            editor.panels.viewer.compare.held.as_ref().unwrap().is_shown(&display)
        });
        let editor = window.state_mut().as_mut().unwrap();
        let result = editor.state().evaluated.result.clone().unwrap();
        let shown = editor.panels.viewer.compare.shown(&result);
        assert!(shown.pixels.chunks(4).all(|pixel| pixel == [0, 0, 0, 255]), "{display:?}");
    }
}

#[test]
fn the_hull_opens_and_closes() {
    let mut window = open(MIXED, WINDOW);
    let center = picture(&window).center();
    hover(&mut window, center);
    press(&mut window, Key::H);
    assert!(window.query_by_label("Picture").is_none());
    let space = window.get_by_label("Hull of the palette").rect();
    drag(&mut window, space.center(), space.center() + vec2(50.0, 20.0), Modifiers::NONE);
    assert_eq!(editor(&window).state().look.pick, None);
    hover(&mut window, center);
    press(&mut window, Key::H);
    assert!(window.query_by_label("Picture").is_some());
}

#[test]
fn a_flat_palette_has_no_inside() {
    let mut window = open(MIXED, WINDOW);
    let center = picture(&window).center();
    hover(&mut window, center);
    press(&mut window, Key::N);
    assert!(window.query_by_label("The palette is flat: every color lies on its face.").is_some());
    press(&mut window, Key::N);
    assert!(window.query_by_label("The palette is flat: every color lies on its face.").is_none());
}

#[test]
fn what_is_no_picture_says_so() {
    let mut window = open(SEA, WINDOW);
    act(&mut window, Action::Look("waves".into(), 0));
    assert!(window.query_by_label("Clay shading: a Surface is not a picture").is_some());
    act(&mut window, Action::Look("camera".into(), 0));
    assert!(window.query_by_label_contains("a Camera is not a picture").is_some());
    act(&mut window, Action::Look("view".into(), 1));
    assert!(window.query_by_label_contains("Clay shading").is_none());
}

#[test]
fn the_picture_is_shown_one_to_one_and_fitted() {
    let mut window = open(MIXED, WINDOW);
    let center = picture(&window).center();
    window.get_by_label("1:1").click();
    settle(&mut window);
    assert!(window.query_by_label("100 %").is_some());
    hover(&mut window, center);
    press(&mut window, Key::F);
    assert!(window.query_by_label("100 %").is_none());
}

#[test]
fn a_double_click_takes_numbers_back() {
    let mut window = open(MIXED, WINDOW);
    let display = crate::evaluate::Display { exposure: 2.0, ..Default::default() };
    act(&mut window, Action::Display(display));
    let area = picture(&window);
    let numbers = window.get_all_by_role(Role::SpinButton).map(|node| node.rect().center());
    let exposure = numbers.filter(|at| at.y < area.top() && at.x < area.right()).min_by(|a, b| a.x.total_cmp(&b.x));
    let exposure = exposure.unwrap();
    hover(&mut window, exposure);
    for pressed in [true, false, true, false] {
        button(&mut window, exposure, pressed, Modifiers::NONE);
    }
    settle(&mut window);
    assert_eq!(editor(&window).state().look.display.exposure, 0.0);
    // No field has the focus any more, so keys reach the viewer.
    hover(&mut window, area.center());
    press(&mut window, Key::R);
    assert_eq!(editor(&window).state().look.display.channel, Channel::One(0));
}

#[test]
fn a_path_of_the_chosen_sea_is_moved_in_the_picture() {
    let mut window = open(SEA, WINDOW);
    assert!(window.query_by_label("guides[0], point 1").is_none());
    act(&mut window, Action::Select(["waves".to_string()].into()));
    let path = Path::node("waves").to("guides").to(0).to("path");
    let written = |window: &Window| editor(window).state().sheet().get(&path).unwrap().to_string();
    assert_eq!(written(&window), "[2,5,4,5,6,5,8,5]");
    let grip = window.get_by_label("guides[0], point 1").rect().center();
    drag(&mut window, grip, grip + vec2(30.0, 0.0), Modifiers::NONE);
    let moved = written(&window);
    assert!(moved.ends_with("4,5,6,5,8,5]") && moved != "[2,5,4,5,6,5,8,5]", "{moved}");
    // The handle is where it was dropped, and the drag is undone in one step.
    let now = window.get_by_label("guides[0], point 1").rect().center();
    assert!((now - grip - vec2(30.0, 0.0)).length() < 2.0, "{now:?} {grip:?}");
    act(&mut window, Action::Undo);
    assert_eq!(written(&window), "[2,5,4,5,6,5,8,5]");
    press(&mut window, Key::Q);
    assert!(window.query_by_label("guides[0], point 1").is_none());
}

#[test]
fn projecting_a_point_and_back_gives_the_same_point() {
    let mut window = open(SEA, [800.0, 600.0]);
    act(&mut window, Action::Select(["waves".to_string()].into()));
    for knobs in
        [r#""roll": 30, "fov": 70"#, r#""projection": "orthographic", "height": 12, "roll": -20"#, r#""fov": 20"#]
    {
        let text = SEA.replace(r#""target": [5, 0, 5]"#, &format!(r#""target": [5, 0, 5], {knobs}"#));
        act(&mut window, Action::Rewrite(text));
        let result = editor(&window).state().evaluated.result.clone().unwrap();
        let camera = result.lens.graph.find("camera").unwrap();
        let eye = Eye::new(&Pose::of(&result.lens.graph, camera, result.frame), 64.0 / 36.0);
        assert!((eye.project([5.0, 0.0, 5.0].into()).unwrap() - pos2(0.5, 0.5)).length() < 1e-5);
        for share in [pos2(0.2, 0.7), pos2(0.9, 0.9), pos2(0.5, 0.6)] {
            let world = eye.on_level(share, 0.5).unwrap();
            assert!((world.y - 0.5).abs() < 1e-9);
            assert!((eye.project(world).unwrap() - share).length() < 1e-4, "{knobs} {share:?}");
        }
    }
}

#[test]
fn every_switch_of_the_viewer_is_a_command() {
    let run = |window: &mut Window, switch: Switch| {
        let state = editor(window).state();
        let does = |command: &&'static Command| (command.action)(state) == Action::Viewer(switch);
        let command = commands().find(does).unwrap_or_else(|| panic!("{switch:?} is no command"));
        assert!((command.enabled)(state), "{}", command.name);
        crate::testing::act(window, Action::Viewer(switch));
    };
    let shows = |window: &Window, label: &str| window.query_by_label(label).is_some();
    let mut next = Some(Switch::Hold);
    while let Some(switch) = next {
        let mut window = open(MIXED, WINDOW);
        run(&mut window, switch);
        let is_held = shows(&window, "Release A");
        next = match switch {
            Switch::Hold => {
                assert!(is_held);
                Some(Switch::LetGo)
            }
            Switch::LetGo => {
                run(&mut window, Switch::Hold);
                run(&mut window, Switch::LetGo);
                assert!(!shows(&window, "Release A"));
                Some(Switch::Wipe)
            }
            Switch::Wipe => {
                assert!(is_held && shows(&window, "Wipe line"), "the current picture is held if none was");
                Some(Switch::Difference)
            }
            Switch::Difference => {
                assert!(is_held && !shows(&window, "Wipe line"), "the current picture is held if none was");
                run(&mut window, Switch::Wipe);
                assert!(shows(&window, "Release A") && shows(&window, "Wipe line"));
                Some(Switch::Region)
            }
            Switch::Region => {
                let place = picture(&window);
                drag(&mut window, place.center(), place.center() + vec2(40.0, 20.0), Modifiers::NONE);
                assert!(editor(&window).state().look.region.is_some());
                Some(Switch::Hull)
            }
            Switch::Hull => {
                assert!(shows(&window, "Hull of the palette") && !shows(&window, "Picture"));
                run(&mut window, switch);
                assert!(!shows(&window, "Hull of the palette") && shows(&window, "Picture"));
                Some(Switch::Near)
            }
            Switch::Near => {
                assert!(shows(&window, "The palette is flat: every color lies on its face."));
                run(&mut window, switch);
                assert!(!shows(&window, "The palette is flat: every color lies on its face."));
                Some(Switch::Orbit)
            }
            Switch::Orbit => {
                let notice = "What is viewed has no camera: view a picture of a scene, then choose Orbit";
                assert!(shows(&window, notice));
                Some(Switch::Scopes)
            }
            Switch::Scopes => {
                assert!(shows(&window, "Vectorscope"));
                run(&mut window, switch);
                assert!(!shows(&window, "Vectorscope"));
                None
            }
        };
    }
}

#[test]
fn scopes_stand_beside_the_picture_and_follow_it() {
    let mut window = open(MIXED, WINDOW);
    let before = picture(&window);
    hover(&mut window, before.center());
    press(&mut window, Key::S);
    let beside = picture(&window);
    for name in ["Histogram", "Waveform", "Vectorscope"] {
        let scope = window.get_by_label(name).rect();
        assert!(scope.right() <= beside.left() && scope.left() >= before.left(), "{name}: {scope:?} {beside:?}");
        assert!(scope.top() >= before.top() && scope.bottom() <= before.bottom() + 1.0, "{name}: {scope:?}");
        assert!(scope.width() > 100.0 && scope.height() > 60.0, "{name}: {scope:?}");
    }
    // A click in a scope picks no pixel.
    let scope = window.get_by_label("Histogram").rect().center();
    click(&mut window, scope);
    assert_eq!(editor(&window).state().look.pick, None);
    hover(&mut window, beside.center());
    press(&mut window, Key::S);
    assert_eq!(picture(&window), before);
    // A panel that is too narrow keeps its picture.
    let mut window = open(MIXED, [480.0, 640.0]);
    let before = picture(&window);
    hover(&mut window, before.center());
    press(&mut window, Key::S);
    assert!(window.query_by_label("Histogram").is_none() && picture(&window) == before);
}
