//! A headless editor for tests.

use crate::actions::Action;
use crate::document::{Path, Session};
use crate::editor::Editor;
use egui_kittest::Harness;
use serde_json::Value;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A vertical color ramp.
pub(crate) const RAMP: &str = r##"{
  "trochoid": 1,
  "format": { "width": 1280, "height": 720, "samples": 1 },
  "working_space": "srgb",
  "frames": { "first": 1, "last": 96, "fps": 24 },
  "nodes": {
    "down": { "type": "ScreenY" },
    "sky": { "type": "Ramp", "weight": "down", "stops": [
      { "at": 0, "color": "#2d3f52" }, { "at": 0.6, "color": "#b98a63" }, { "at": 1, "color": "#f0cf8e" }
    ] }
  },
  "outputs": {
    "beauty": { "color": "sky", "file": "beauty.####.png", "require": { "guarantee": "hull" } }
  }
}
"##;

/// A headless window with an editor.
pub(crate) type Window = Harness<'static, Option<Editor>>;

/// Opens a document in an editor, 1280 × 800.
pub(crate) fn window(session: Session, data: Option<PathBuf>) -> Window {
    sized(session, data, [1280.0, 800.0])
}

/// Opens a document in an editor window of a given size, in points.
pub(crate) fn sized(session: Session, data: Option<PathBuf>, size: [f32; 2]) -> Window {
    let mut session = Some(session);
    let draw = move |ui: &mut egui::Ui, editor: &mut Option<Editor>| {
        if let Some(session) = session.take() {
            *editor = Some(Editor::new(ui.ctx(), session, data.as_deref()).unwrap());
        }
        editor.as_mut().unwrap().ui(ui);
    };
    let mut window = Harness::builder().with_size(size).with_step_dt(0.02).build_ui_state(draw, None);
    window.step();
    window
}

/// Returns the editor.
pub(crate) fn editor(window: &Window) -> &Editor {
    window.state().as_ref().unwrap()
}

/// Performs an action without drawing.
pub(crate) fn ask(window: &mut Window, action: Action) {
    let context = window.ctx.clone();
    window.state_mut().as_mut().unwrap().act(action, &context);
}

/// Performs an action and draws the result.
pub(crate) fn act(window: &mut Window, action: Action) {
    ask(window, action);
    window.run_steps(3);
}

/// Selects a node.
pub(crate) fn choose(window: &mut Window, node: &str) {
    act(window, Action::Select([node.to_string()].into()));
}

/// Returns the value of a knob of a node, as the document has it.
pub(crate) fn value(window: &Window, node: &str, knob: &str) -> Option<Value> {
    editor(window).state().sheet().get(&Path::node(node).to(knob)).cloned()
}

/// Returns the document.
pub(crate) fn text(window: &Window) -> &str {
    editor(window).state().session.text()
}

/// Draws until a condition holds, at the frame rate of a window.
pub(crate) fn until(window: &mut Window, what: &str, holds: impl Fn(&Editor) -> bool) {
    let started = Instant::now();
    while !holds(editor(window)) {
        assert!(started.elapsed() < Duration::from_secs(120), "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(2));
        window.step();
    }
}

/// Draws until the picture is finished or has failed.
pub(crate) fn finished(window: &mut Window) {
    window.step();
    until(window, "the picture", |editor| {
        let seen = &editor.state().evaluated;
        seen.progress.is_none() && (seen.failed.is_some() || seen.result.as_ref().is_some_and(|result| result.finished))
    });
}

/// Opens a document in an editor whose viewer shows nothing, so that nothing is evaluated.
pub(crate) fn unseen(session: Session) -> Window {
    unseen_in(session, [1280.0, 800.0])
}

/// Like [`unseen`], in a window of a given size, in points.
pub(crate) fn unseen_in(session: Session, size: [f32; 2]) -> Window {
    let mut session = Some(session);
    let draw = move |ui: &mut egui::Ui, editor: &mut Option<Editor>| {
        if let Some(session) = session.take() {
            let mut new = Editor::new(ui.ctx(), session, None).unwrap();
            new.state.look.node = None;
            *editor = Some(new);
        }
        editor.as_mut().unwrap().ui(ui);
    };
    let mut window = Harness::builder().with_size(size).with_step_dt(0.02).build_ui_state(draw, None);
    window.step();
    window
}

/// Returns the place of the graph, whose menu and tab are called so, too.
pub(crate) fn graph(window: &Window) -> egui::Rect {
    use egui_kittest::kittest::Queryable;
    let all = window.query_all_by_label("Graph").map(|node| node.rect());
    all.max_by(|a, b| a.area().total_cmp(&b.area())).unwrap()
}
