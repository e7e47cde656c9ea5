//! Tests of the canvas, driven by simulated input; widgets are found by their labels.

mod nodes;
mod outputs;
mod sight;
mod wires;

use super::{Canvas, arrange, backdrop, canvas_ui, deleting, lined_up};
use crate::actions::Action;
use crate::document::{Session, edit};
use crate::state::State;
use egui::{Event, Modifiers, PointerButton, Pos2, Rect, Ui, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

/// Performs the actions of the canvas as the editor does.
struct Driver {
    state: State,
    canvas: Canvas,
    done: Vec<Action>,
}

impl Driver {
    fn new(text: &str) -> Self {
        let state = State::new(Session::new(text.into(), None), crate::evaluate::Graphics::default());
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
            Action::Delete => self.state.session.edit(deleting(&sheet, &names)).unwrap(),
            Action::Disable => self.state.session.edit(edit::disabled(&sheet, &names)).unwrap(),
            Action::Arrange => {
                let places = arrange(&sheet, &self.state.selection);
                self.state.session.edit(edit::laid_out(&sheet, &places)).unwrap();
            }
            Action::Backdrop => {
                let (edit, name, text) = backdrop(&sheet, &self.state.selection).unwrap();
                self.state.session.edit(edit).unwrap();
                self.canvas.write_on(name, text);
            }
            Action::Line(line) => {
                self.state.session.edit(lined_up(&sheet, &self.state.selection, line)).unwrap();
            }
            Action::Output(name) => self.state.output = name,
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
        value.map(crate::document::change::style).unwrap_or_default()
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

/// Moves the pointer along a path with the button pressed.
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

/// Returns a place on the empty canvas.
fn nowhere(harness: &Harness<'_, Driver>) -> Pos2 {
    let (down, across) = (place(harness, "Node down, ScreenY"), place(harness, "Node across, ScreenX"));
    pos2((down.right() + across.left()) / 2.0, down.center().y - 30.0)
}
