//! Screenshots of the canvas, drawn by wgpu; they need a graphics driver, so they run only on request.

use super::{Driver, GRAPH, click, drag, nowhere, place, press};
use crate::actions::Action;
use crate::canvas::{Canvas, canvas_ui};
use crate::document::Session;
use crate::editor::Editor;
use crate::testing::{ask, finished, sized, until};
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, TouchPhase, Vec2, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::path::{Path, PathBuf};

/// The editor of a scene, with pictures of all nodes.
fn seen(scene: &str) -> Editor {
    crate::tests::shots::at_root();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../graphs").join(format!("{scene}.json"));
    let mut window = sized(Session::open(&file).unwrap(), None, [400.0, 300.0]);
    ask(&mut window, Action::Proxy(4));
    finished(&mut window);
    until(&mut window, "thumbnails", |editor| !editor.state().evaluated.thumbnails.is_empty());
    window.into_state().unwrap()
}

/// Writes pictures of the canvas into the folder that `TROCHOID_SHOTS` names.
#[test]
#[ignore = "needs a graphics driver, and a minute"]
fn screenshots_of_the_canvas() {
    let Some(folder) = std::env::var_os("TROCHOID_SHOTS").map(PathBuf::from) else { return };
    for (scene, chosen, slot) in [("toon_sea", "level", 1), ("glow", "", 0)] {
        for theme in [egui::Theme::Dark, egui::Theme::Light] {
            let mut editor = seen(scene);
            editor.select(&[chosen]);
            editor.state.look.slots[slot] = Some("water_1".into());
            let draw = |ui: &mut egui::Ui, (editor, canvas): &mut (Editor, Canvas)| {
                canvas_ui(canvas, ui, &editor.state, &mut Vec::new());
            };
            let builder = Harness::builder().with_size(vec2(1600.0, 1000.0)).with_step_dt(0.1).with_theme(theme).wgpu();
            let mut harness = builder.build_ui_state(draw, (editor, Canvas::default()));
            crate::theme::install(&harness.ctx);
            let name = |what: &str| folder.join(format!("canvas_{scene}_{theme:?}_{what}.png").to_lowercase());
            harness.run_steps(4);
            harness.render().unwrap().save(name("all")).unwrap();
            harness.hover_at(pos2(800.0, 500.0));
            for (lines, what) in [(1.6, "near"), (1.4, "nearer"), (1.4, "nearest")] {
                for _ in 0..4 {
                    harness.event(Event::MouseWheel {
                        unit: MouseWheelUnit::Line,
                        delta: Vec2::new(0.0, lines),
                        phase: TouchPhase::Move,
                        modifiers: Modifiers::NONE,
                    });
                }
                harness.run_steps(12);
                harness.render().unwrap().save(name(what)).unwrap();
            }
        }
    }
}

/// Writes pictures of what appears over the canvas into the folder that `TROCHOID_SHOTS` names.
#[test]
#[ignore = "needs a graphics driver"]
fn screenshots_of_what_appears() {
    let Some(folder) = std::env::var_os("TROCHOID_SHOTS").map(PathBuf::from) else { return };
    let text = GRAPH.replace(
        r#""sky": { "#,
        r#""bad": { "type": "Mix", "a": "nothing", "weight": "other" },
    "under": { "type": "Mix", "a": "bad", "b": [0.4, 0.1, 0.1], "weight": 0.25 },
    "off": { "type": "Invert", "weight": "down", "disabled": true },
    "sky": { "#,
    );
    let text =
        text.replace(r#""other": ["#, r#""bad": [560, 520], "under": [560, 690], "off": [-170, 170], "other": ["#);
    let builder = Harness::builder().with_size(vec2(1200.0, 900.0)).with_step_dt(0.1).wgpu();
    let mut harness = builder.build_ui_state(|ui, driver: &mut Driver| driver.ui(ui), Driver::new(&text));
    crate::theme::install(&harness.ctx);
    harness.state_mut().state.selection = ["across".to_string(), "twice".into()].into();
    harness.state_mut().act(Action::Backdrop);
    harness.run_steps(4);
    let shoot = |harness: &mut Harness<'_, Driver>, name: &str| {
        harness.run_steps(10);
        harness.render().unwrap().save(folder.join(format!("over_{name}.png"))).unwrap();
    };
    let at = place(&harness, "Node bad, Mix").center();
    harness.hover_at(at);
    shoot(&mut harness, "error");
    let at = place(&harness, "Node twice, FieldMath").center();
    click(&mut harness, at, PointerButton::Secondary, Modifiers::NONE);
    shoot(&mut harness, "menu");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    let (from, to) = (place(&harness, "Output of twice"), place(&harness, "Input weight of other"));
    drag(&mut harness, from.center(), to.center());
    shoot(&mut harness, "refusal");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    let empty = nowhere(&harness);
    drag(&mut harness, from.center(), empty);
    harness.get_by_label("Node type").type_text("m");
    shoot(&mut harness, "search");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    // While a wire is drawn.
    harness.hover_at(from.center());
    press(&harness, from.center(), true, PointerButton::Primary, Modifiers::NONE);
    harness.hover_at(empty + vec2(-30.0, 200.0));
    harness.hover_at(empty + vec2(-20.0, 210.0));
    shoot(&mut harness, "wire");
}
