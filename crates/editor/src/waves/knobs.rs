//! Knobs that shape a sea: sliders, choices, and the dial of its direction.

use super::sea::Sea;
use crate::actions::Action;
use crate::document::link::is_link;
use crate::document::{Edit, Path};
use crate::field::{Gesture, Number};
use crate::format::{measure, unit};
use crate::prose::explained;
use crate::state::State;
use egui::{Align, Align2, Color32, ComboBox, FontId, Label, Layout, Sense, Stroke, Ui, Vec2, WidgetInfo, pos2, vec2};
use serde_json::{Value, json};
use trochoid::{Declaration, Item, Knob, KnobDefault, KnobType, Settled};

/// Knobs that shape a sea, in display order.
const KNOBS: [&str; 20] = [
    "direction",
    "height",
    "wavelength",
    "spread",
    "along",
    "across",
    "sharpness",
    "count",
    "direction_spread",
    "convention",
    "dispersion",
    "mode",
    "speed",
    "period",
    "c1",
    "c2",
    "damping",
    "frequency",
    "phase",
    "burst",
];

/// Knobs that count only if a choice has one of these words.
const ONLY: [(&str, &str, &[&str]); 7] = [
    ("speed", "dispersion", &["speed"]),
    ("period", "dispersion", &["period"]),
    ("speed", "mode", &["physical"]),
    ("damping", "mode", &["physical"]),
    ("frequency", "mode", &["physical"]),
    ("c1", "mode", &["resampled", "literal"]),
    ("c2", "mode", &["resampled", "literal"]),
];

/// What stands in the place of a knob's value.
enum Given {
    Plain(f64),
    /// Not set: the node decides.
    Unset,
    /// Keyed or linked: what is said of it.
    Follows(&'static str),
    /// The knob cannot be changed from here.
    Elsewhere,
}

/// Side of the dial of the direction, and width of the names of knobs, in points.
const DIAL: f32 = 92.0;
const NAME: f32 = 104.0;

pub(super) fn knobs_ui(ui: &mut Ui, state: &State, sea: &Sea<'_>, actions: &mut Vec<Action>) {
    let items = sea.declaration.items.iter();
    let knobs: Vec<&Knob> =
        items.filter_map(|item| if let Item::Knob(knob) = item { Some(knob) } else { None }).collect();
    let knob = |name: &str| knobs.iter().copied().find(|knob| knob.name == name);
    ui.horizontal_top(|ui| {
        if let Some(direction) = knob("direction") {
            dial_ui(ui, state, sea, direction, actions);
        }
        ui.vertical(|ui| {
            // A name stands before each slider, and its number behind it.
            ui.spacing_mut().slider_width = (ui.available_width() - NAME - 92.0).clamp(84.0, 300.0);
            for knob in KNOBS.into_iter().filter(|name| *name != "direction").filter_map(knob) {
                let counts = ONLY.iter().filter(|(name, ..)| *name == knob.name).all(|(_, choice, words)| {
                    let choice = knobs.iter().find(|knob| knob.name == *choice);
                    choice.is_none_or(|choice| words.contains(&word(state, sea, choice).as_str()))
                });
                if counts {
                    knob_ui(ui, state, sea, knob, actions);
                }
            }
        });
    });
}

/// Returns the direction of travel of a sea, in degrees; `None` if it has none.
pub(super) fn direction(settled: &Settled, declaration: &Declaration) -> Option<f64> {
    let has_one = declaration.items.iter().any(|item| item.name() == "direction");
    has_one.then(|| settled.number("direction"))
}

/// Returns the path of a knob of a sea that can be changed from here.
fn path(sea: &Sea<'_>, knob: &Knob) -> Option<Path> {
    Some(Path::node(&sea.node?.name).to(knob.name))
}

fn value<'s>(state: &'s State, sea: &Sea<'_>, knob: &Knob) -> Option<&'s Value> {
    state.sheet().get(&path(sea, knob)?)
}

fn given(state: &State, sea: &Sea<'_>, knob: &Knob) -> Given {
    if sea.node.is_none() {
        return Given::Elsewhere;
    }
    match (value(state, sea, knob), knob.default) {
        (Some(Value::String(text)), _) if is_link(text) => Given::Follows("linked"),
        (Some(value), _) => value.as_f64().map_or(Given::Follows("animated"), Given::Plain),
        (None, Some(KnobDefault::Number(default))) => Given::Plain(default),
        (None, _) => Given::Unset,
    }
}

/// Returns the word of a choice.
fn word(state: &State, sea: &Sea<'_>, knob: &Knob) -> String {
    if let Some(settled) = &sea.settled {
        return settled.text(knob.name).into();
    }
    let own = value(state, sea, knob).cloned().unwrap_or_else(|| knob.default_value());
    own.as_str().unwrap_or_default().into()
}

fn set(path: &Path, value: f64) -> Edit {
    Edit::set(path.clone(), &json!(value)).merging(path.to_string())
}

fn named(knob: &Knob) -> String {
    knob.name.replace('_', " ")
}

/// Returns the present value of a number in words, where there is one.
fn present(sea: &Sea<'_>, knob: &Knob) -> Option<String> {
    let settled = sea.settled.as_ref()?;
    let value = match knob.takes {
        KnobType::Integer { .. } => settled.integer(knob.name) as f64,
        _ => settled.number(knob.name),
    };
    value.is_finite().then(|| format!("{}{}", measure(value), unit(knob.unit)))
}

/// Draws the name of a knob, before its value as in the properties.
fn name_ui(ui: &mut Ui, knob: &Knob) {
    let size = vec2(NAME, ui.spacing().interact_size.y);
    let label = ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_width(NAME);
        ui.add(Label::new(named(knob)).truncate())
    });
    explained(label.inner, knob.help);
}

fn knob_ui(ui: &mut Ui, state: &State, sea: &Sea<'_>, knob: &Knob, actions: &mut Vec<Action>) {
    if let KnobType::Choice(words) = knob.takes {
        return choice_ui(ui, state, sea, knob, words, actions);
    }
    match given(state, sea, knob) {
        Given::Plain(value) => {
            let Some(path) = path(sea, knob) else { return };
            slider_ui(ui, &path, knob, value, actions);
        }
        Given::Unset => {}
        Given::Follows(how) => {
            let text = present(sea, knob).map_or(String::new(), |value| format!(", now {value}"));
            let text = format!("{} is {how}{text}: see Properties", named(knob));
            explained(ui.weak(text), knob.help);
        }
        Given::Elsewhere => {
            let Some(value) = present(sea, knob) else { return };
            ui.horizontal(|ui| {
                name_ui(ui, knob);
                ui.label(value);
            });
        }
    }
}

fn choice_ui(ui: &mut Ui, state: &State, sea: &Sea<'_>, knob: &Knob, words: &[&str], actions: &mut Vec<Action>) {
    let chosen = word(state, sea, knob);
    ui.horizontal(|ui| {
        name_ui(ui, knob);
        let follows = value(state, sea, knob).and_then(Value::as_str).is_some_and(is_link);
        match path(sea, knob).filter(|_| !follows) {
            Some(path) => {
                let combo = ComboBox::from_id_salt(path.to_string()).width(104.0).selected_text(&chosen);
                let shown = combo.show_ui(ui, |ui| {
                    for word in words {
                        let entry = ui.selectable_label(*word == chosen, *word);
                        if let Some(gesture) = Gesture::click(&entry) {
                            gesture.edit(Edit::set(path.clone(), &json!(word)), actions);
                            actions.push(Action::Seal);
                        }
                    }
                });
                shown.response.widget_info(|| WidgetInfo::labeled(egui::WidgetType::ComboBox, true, named(knob)));
            }
            None => drop(ui.label(&chosen)),
        }
    });
}

fn slider_ui(ui: &mut Ui, path: &Path, knob: &Knob, value: f64, actions: &mut Vec<Action>) {
    // Practical slider ranges; the field beside the slider accepts every valid value.
    let (low, high) = match knob.name {
        "height" => (0.0, 20.0),
        "wavelength" => (0.5, 300.0),
        "along" | "across" => (0.1, 100.0),
        "sharpness" | "spread" => (0.0, 2.0),
        "count" => (0.0, 20_000.0),
        "direction_spread" => (0.0, 180.0),
        "speed" => (0.0, 40.0),
        "period" => (0.1, 30.0),
        "phase" => (-180.0, 180.0),
        "c1" | "c2" => (-1.2, 1.2),
        "damping" => (0.0, 10.0),
        "frequency" => (0.0, 20.0),
        _ => (0.0, 1.0),
    };
    let whole = matches!(knob.takes, KnobType::Integer { .. });
    ui.horizontal(|ui| {
        name_ui(ui, knob);
        let logarithmic = matches!(knob.name, "wavelength" | "along" | "across" | "count");
        let (min, max) = match knob.takes {
            KnobType::Number { min, max } => (min, max),
            KnobType::Integer { min, max } => (min as f64, max as f64),
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        };
        let number = Number::new(value).range(min, max).decimals(2);
        let number = if whole { number.whole() } else { number };
        let told = number.suffix(&unit(knob.unit)).slider(low..=high, logarithmic).ui(ui);
        told.edit(actions, |value| set(path, value));
    });
}

/// Draws a compass as seen from above: +X to the right, +Z down.
fn dial_ui(ui: &mut Ui, state: &State, sea: &Sea<'_>, knob: &Knob, actions: &mut Vec<Action>) {
    let given = given(state, sea, knob);
    let present = sea.settled.as_ref().map(|settled| settled.number(knob.name));
    let (path, degrees, follows) = match given {
        Given::Plain(value) => (path(sea, knob), Some(value), None),
        Given::Follows(how) => (None, present, Some(how)),
        Given::Unset | Given::Elsewhere => (None, present, None),
    };
    let sense = if path.is_some() { Sense::click_and_drag() } else { Sense::hover() };
    let (rect, response) = ui.allocate_exact_size(vec2(DIAL, DIAL), sense);
    let (center, radius) = (rect.center(), 40.0);
    let visuals = ui.visuals();
    let painter = ui.painter_at(rect);
    painter.circle(center, radius, visuals.extreme_bg_color, Stroke::new(1.0, visuals.weak_text_color()));
    for (text, at) in [("X", pos2(center.x + radius - 8.0, center.y)), ("Z", pos2(center.x, center.y + radius - 8.0))] {
        painter.text(at, Align2::CENTER_CENTER, text, FontId::proportional(10.0), visuals.weak_text_color());
    }
    let Some(degrees) = degrees else {
        let text = follows.unwrap_or_default();
        painter.text(center, Align2::CENTER_CENTER, text, FontId::proportional(11.0), visuals.text_color());
        return;
    };
    response.widget_info(|| WidgetInfo::slider(path.is_some(), degrees, "Direction"));
    let (sin, cos) = (degrees.to_radians() as f32).sin_cos();
    let along = vec2(cos, sin);
    let stroke = Stroke::new(2.0, Color32::from_rgb(0x3f, 0xb5, 0xb0));
    painter.arrow(center - along * radius * 0.8, along * radius * 1.6, stroke);
    let says = format!("Waves travel toward {degrees:.0}°, seen from above.");
    let Some(path) = path else {
        let why = follows.map_or(String::new(), |how| format!(" The direction is {how}: see Properties."));
        response.on_hover_text(says + &why);
        return;
    };
    if let Some((gesture, pointer)) = Gesture::press(&response) {
        let to: Vec2 = pointer - center;
        if to.length() > 4.0 {
            let angle = f64::from(to.y.atan2(to.x).to_degrees());
            // Shift snaps to steps of 15°.
            let angle =
                if ui.input(|input| input.modifiers.shift) { (angle / 15.0).round() * 15.0 } else { angle.round() };
            gesture.edit(set(&path, angle), actions);
        }
    }
    if response.drag_stopped() || response.clicked() {
        actions.push(Action::Seal);
    }
    response.on_hover_text(says + " Shift: steps of 15°.");
}
