//! The waves panel: direction and size of a sea's waves, their spectrum, and whether crests fold or waves grow.

use crate::actions::Action;
use crate::document::{Edit, Node, Path};
use crate::field::{Gesture, Number};
use crate::format::number;
use crate::state::State;
use egui::{Color32, RichText, ScrollArea, Sense, Stroke, Ui, pos2, vec2};
use egui_plot::{Line, Plot, PlotPoints, Points, Polygon};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use trochoid::{CheckedGraph, Item, Knob, KnobDefault, KnobType, Role, Spectrum, Stability, stability_of};

/// State of the panel that no other panel shares.
#[derive(Default)]
pub(crate) struct Waves {
    /// Spectrum of this sea at this revision and frame.
    spectrum: Option<(String, u64, i64, Option<Spectrum>)>,
    stability: Option<(String, u64, StabilityResult)>,
}

enum StabilityResult {
    Waiting(Receiver<Option<Box<Stability>>>),
    Here(Option<Box<Stability>>),
}

/// Draws the panel for the selected sea, or the document's first.
pub(crate) fn waves_ui(waves: &mut Waves, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let is_sea = |node: &&Node| node.is(Role::Sea);
    let sheet = state.sheet();
    let chosen = state.chosen().and_then(|name| sheet.node(name)).filter(is_sea);
    // For another selected node: the sea that it depends on.
    let above = || {
        let start = sheet.find(state.chosen()?)?;
        let mut above: Vec<usize> = sheet.upstream([start]).into_iter().collect();
        above.sort_unstable();
        above.into_iter().map(|index| &sheet.nodes[index]).find(is_sea)
    };
    let Some(sea) = chosen.or_else(above).or_else(|| sheet.nodes.iter().find(is_sea)) else {
        ui.weak("The document has no sea. Add a GerstnerSea or a ToonSea (Tab in the graph).");
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.horizontal(|ui| {
            if ui.link(RichText::new(&sea.name).heading()).on_hover_text("Select this node").clicked() {
                actions.push(Action::Select([sea.name.clone()].into()));
            }
            ui.weak(&sea.ty);
        });
        let width = ui.available_width();
        knobs_ui(ui, state, sea, actions);
        // Sliders wider than the panel must not widen the content below.
        ui.set_max_width(width);
        let Some(graph) = &state.session.meaning().graph else {
            ui.weak("The document has errors: correct them to see its waves.");
            return;
        };
        if !spectrum_ui(waves, ui, state, sea, graph) {
            stability_ui(waves, ui, state, sea, graph, actions);
        }
    });
}

/// Knobs that shape a sea, in display order.
const KNOBS: [&str; 12] = [
    "direction",
    "height",
    "wavelength",
    "sharpness",
    "count",
    "direction_spread",
    "speed",
    "period",
    "c1",
    "c2",
    "damping",
    "frequency",
];

fn knobs_ui(ui: &mut Ui, state: &State, sea: &Node, actions: &mut Vec<Action>) {
    let Some(declaration) = sea.declaration else { return };
    let path = Path::node(&sea.name);
    let knob = |name: &str| {
        declaration.items.iter().find_map(|item| match item {
            Item::Knob(knob) if knob.name == name => Some(*knob),
            _ => None,
        })
    };
    // Leaves room for a name beside each slider.
    ui.spacing_mut().slider_width = 84.0;
    ui.horizontal_top(|ui| {
        if let Some(direction) = knob("direction") {
            dial_ui(ui, &path.to("direction"), value_of(state, &path, &direction), actions);
        }
        ui.vertical(|ui| {
            for name in KNOBS.into_iter().filter(|name| *name != "direction") {
                let Some(knob) = knob(name) else { continue };
                // A knob named like a word of a choice applies only if that word is chosen.
                let mut choices = declaration.items.iter().filter_map(|item| match item {
                    Item::Knob(Knob { name: choice, takes: KnobType::Choice(words), .. }) if words.contains(&name) => {
                        Some(choice)
                    }
                    _ => None,
                });
                if choices.all(|choice| text_of(state, &path, choice) == name) {
                    slider_ui(ui, state, &path, &knob, actions);
                }
            }
        });
    });
}

fn text_of<'s>(state: &'s State, path: &Path, name: &str) -> &'s str {
    state.sheet().get(&path.to(name)).and_then(Value::as_str).unwrap_or_default()
}

/// Returns a knob's plain value; `None` if it is keyframed.
fn value_of(state: &State, path: &Path, knob: &Knob) -> Option<f64> {
    match (state.sheet().get(&path.to(knob.name)), knob.default) {
        (Some(value), _) => value.as_f64(),
        (None, Some(KnobDefault::Number(default))) => Some(default),
        _ => None,
    }
}

fn set(path: &Path, value: f64) -> Edit {
    Edit::set(path.clone(), &json!(value)).merging(path.to_string())
}

fn slider_ui(ui: &mut Ui, state: &State, path: &Path, knob: &Knob, actions: &mut Vec<Action>) {
    let Some(value) = value_of(state, path, knob) else {
        ui.weak(format!("{} is animated: see Properties", knob.name.replace('_', " ")));
        return;
    };
    // Practical slider ranges; the field beside the slider accepts every valid value.
    let (low, high) = match knob.name {
        "height" => (0.0, 20.0),
        "wavelength" => (0.5, 300.0),
        "sharpness" => (0.0, 2.0),
        "count" => (0.0, 20_000.0),
        "direction_spread" => (0.0, 180.0),
        "speed" => (0.0, 40.0),
        "period" => (0.1, 30.0),
        "c1" | "c2" => (-1.2, 1.2),
        "damping" => (0.0, 10.0),
        "frequency" => (0.0, 20.0),
        _ => (0.0, 1.0),
    };
    let whole = matches!(knob.takes, KnobType::Integer { .. });
    ui.horizontal(|ui| {
        let logarithmic = matches!(knob.name, "wavelength" | "count");
        let unit = if knob.unit == "degrees" { "°".into() } else { format!(" {}", knob.unit) };
        let (min, max) = match knob.takes {
            KnobType::Number { min, max } => (min, max),
            KnobType::Integer { min, max } => (min as f64, max as f64),
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        };
        let number = Number::new(value).range(min, max).decimals(3);
        let number = if whole { number.whole() } else { number };
        let told = number.suffix(&unit).slider(low..=high, logarithmic).ui(ui);
        crate::prose::explained(ui.label(knob.name.replace('_', " ")), knob.help);
        told.edit(actions, |value| set(&path.to(knob.name), value));
    });
}

/// Draws a compass as seen from above: +X to the right, +Z down.
fn dial_ui(ui: &mut Ui, path: &Path, value: Option<f64>, actions: &mut Vec<Action>) {
    let (rect, response) = ui.allocate_exact_size(vec2(92.0, 92.0), Sense::click_and_drag());
    let (center, radius) = (rect.center(), 40.0);
    let visuals = ui.visuals();
    let painter = ui.painter_at(rect);
    painter.circle(center, radius, visuals.extreme_bg_color, Stroke::new(1.0, visuals.weak_text_color()));
    for (text, at) in [("X", pos2(center.x + radius - 8.0, center.y)), ("Z", pos2(center.x, center.y + radius - 8.0))] {
        painter.text(
            at,
            egui::Align2::CENTER_CENTER,
            text,
            egui::FontId::proportional(10.0),
            visuals.weak_text_color(),
        );
    }
    let Some(degrees) = value else {
        painter.text(
            center,
            egui::Align2::CENTER_CENTER,
            "animated",
            egui::FontId::proportional(11.0),
            visuals.text_color(),
        );
        return;
    };
    response.widget_info(|| egui::WidgetInfo::slider(true, degrees, "Direction"));
    let (sin, cos) = (degrees.to_radians() as f32).sin_cos();
    let along = vec2(cos, sin);
    painter.arrow(
        center - along * radius * 0.8,
        along * radius * 1.6,
        Stroke::new(2.0, Color32::from_rgb(0x3f, 0xb5, 0xb0)),
    );
    if let Some((gesture, pointer)) = Gesture::press(&response) {
        let to: egui::Vec2 = pointer - center;
        if to.length() > 4.0 {
            let angle = f64::from(to.y.atan2(to.x).to_degrees());
            // Shift snaps to steps of 15°.
            let angle =
                if ui.input(|input| input.modifiers.shift) { (angle / 15.0).round() * 15.0 } else { angle.round() };
            gesture.edit(set(path, angle), actions);
        }
    }
    if response.drag_stopped() || response.clicked() {
        actions.push(Action::Seal);
    }
    response.on_hover_text(format!("Waves travel toward {degrees:.0}°, seen from above. Shift: steps of 15°."));
}

/// Draws the waves of a sea; returns whether the sea has a spectrum of waves.
fn spectrum_ui(waves: &mut Waves, ui: &mut Ui, state: &State, sea: &Node, graph: &Arc<CheckedGraph>) -> bool {
    let (revision, frame) = (state.session.revision(), state.frame);
    let current = |known: &(String, u64, i64, Option<Spectrum>)| {
        (known.0.as_str(), known.1, known.2) == (&sea.name, revision, frame)
    };
    if !waves.spectrum.as_ref().is_some_and(current) {
        let found = graph.find(&sea.name).and_then(|id| graph.settle(id, frame).node().dynamics()?.spectrum());
        waves.spectrum = Some((sea.name.clone(), revision, frame, found));
    }
    let Some((.., Some(spectrum))) = &waves.spectrum else { return false };
    ui.separator();
    let (text, color) = match spectrum.unfolded {
        margin if margin.is_infinite() => ("Crests never fold over.".into(), ui.visuals().text_color()),
        margin if margin >= 1.0 => (
            format!("Crests do not fold over, up to {margin:.2} times the current sharpness."),
            ui.visuals().text_color(),
        ),
        margin => (
            format!("Crests fold over: they would not at {margin:.2} times the sharpness."),
            ui.visuals().warn_fg_color,
        ),
    };
    ui.label(RichText::new(text).color(color));
    ui.label(RichText::new(format!("{}: amplitude over length", counted(spectrum.waves.len()))).strong());
    let body = state.sheet().get(&Path::node(&sea.name));
    let by_hand = body.and_then(|body| body.get("waves")).and_then(Value::as_array).map_or(0, Vec::len);
    let groups = body.and_then(|body| body.get("groups")).and_then(Value::as_array).map_or(0, Vec::len);
    let random = graph.find(&sea.name).map_or(0, |id| graph.settle(id, frame).number("count") as usize);
    if let Some(text) = parts(spectrum.waves.len(), random, by_hand, groups) {
        ui.weak(text);
    }
    // If there are very many waves, only as many as can be told apart.
    let step = spectrum.waves.len().div_ceil(2000).max(1);
    let stems: Vec<[f64; 2]> =
        spectrum.waves.iter().step_by(step).map(|wave| [wave.wavelength.log10(), wave.amplitude.abs()]).collect();
    let plot = Plot::new("spectrum").height(150.0).include_y(0.0);
    crate::plots::logarithmic(plot, "m, crest to crest", "m").show(ui, |plot| {
        let stems = Points::new("", PlotPoints::from(stems)).stems(0.0).radius(1.5);
        plot.points(stems.color(Color32::from_rgb(0x3f, 0xb5, 0xb0)));
    });
    ui.label(RichText::new("Directions of travel").strong());
    let rose: Vec<[f64; 2]> = spectrum
        .waves
        .iter()
        .step_by(step)
        .map(|wave| {
            let (sin, cos) = wave.direction.to_radians().sin_cos();
            [cos * wave.amplitude.abs(), -sin * wave.amplitude.abs()]
        })
        .collect();
    let reach = rose.iter().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
    let plot = Plot::new("rose").height(180.0).data_aspect(1.0);
    crate::plots::above(plot, "along X: amplitude in m", "along Z, m")
        .include_x(-reach)
        .include_x(reach)
        .include_y(-reach)
        .include_y(reach)
        .show(ui, |plot| {
            plot.points(Points::new("", PlotPoints::from(rose)).radius(1.5).color(Color32::from_rgb(0x5c, 0x9d, 0xdc)));
        });
    true
}

fn counted(waves: usize) -> String {
    let noun = if waves == 1 { "wave" } else { "waves" };
    format!("{} {noun}", crate::format::thousands(waves as u64))
}

/// Describes the sources of a sea's waves, unless all are random.
fn parts(all: usize, random: usize, by_hand: usize, groups: usize) -> Option<String> {
    let of_groups = all.checked_sub(random + by_hand)?;
    let mut parts = vec![format!("{} random", crate::format::thousands(random as u64))];
    if by_hand > 0 {
        parts.push(format!("{} set by hand", crate::format::thousands(by_hand as u64)));
    }
    if of_groups > 0 {
        let groups = crate::document::edit::count(groups, "group");
        parts.push(format!("{} of {groups}", crate::format::thousands(of_groups as u64)));
    }
    (parts.len() > 1).then(|| parts.join(", "))
}

/// Draws the verdict on a toon sea, its figures, and its point on the stability map.
fn stability_ui(
    waves: &mut Waves,
    ui: &mut Ui,
    state: &State,
    sea: &Node,
    graph: &Arc<CheckedGraph>,
    actions: &mut Vec<Action>,
) {
    let revision = state.session.revision();
    ui.separator();
    if let Some((_, _, found @ StabilityResult::Waiting(_))) = &mut waves.stability
        && let StabilityResult::Waiting(inbox) = found
    {
        match inbox.try_recv() {
            Ok(stability) => *found = StabilityResult::Here(stability),
            Err(TryRecvError::Disconnected) => *found = StabilityResult::Here(None),
            Err(TryRecvError::Empty) => {}
        }
    }
    let current = matches!(&waves.stability, Some((name, known, _)) if (name, *known) == (&sea.name, revision));
    let busy = matches!(&waves.stability, Some((.., StabilityResult::Waiting(_))));
    let button = egui::Button::new(if current { "Analyze again" } else { "Analyze stability" });
    let help = "Predict and measure the long-term behavior of the sea (takes a few seconds)";
    ui.horizontal(|ui| {
        if ui.add_enabled(!busy, button).on_hover_text(help).clicked()
            && let Some(id) = graph.find(&sea.name)
        {
            let (sender, inbox) = channel();
            let (graph, frame, context) = (graph.clone(), state.frame, ui.ctx().clone());
            std::thread::spawn(move || {
                // The panel may be gone by then.
                let _ = sender.send(stability_of(&graph, id, frame).map(Box::new));
                context.request_repaint();
            });
            waves.stability = Some((sea.name.clone(), revision, StabilityResult::Waiting(inbox)));
        }
        if busy {
            ui.spinner();
        }
    });
    let Some((.., StabilityResult::Here(Some(stability)))) = &waves.stability else { return };
    if !current {
        ui.weak("Analyzed before the last change of the document:");
    }
    ui.label(RichText::new(format!("Verdict: {}", stability.verdict.name())).strong());
    for sentence in &stability.explanation {
        ui.add(egui::Label::new(sentence).wrap());
    }
    if let Some(map) = &stability.map {
        let region: Vec<[f64; 2]> = map.region.clone();
        let [across, up] = map.axes;
        let plot = Plot::new("stability").height(200.0).data_aspect(1.0);
        let shown = crate::plots::even(plot, across, up).show(ui, |plot| {
            plot.polygon(
                Polygon::new("stable", PlotPoints::from(region))
                    .fill_color(Color32::from_rgb(0x5f, 0xb8, 0x72).gamma_multiply(0.35)),
            );
            let axes = [
                [[map.ranges[0][0], 0.0], [map.ranges[0][1], 0.0]],
                [[0.0, map.ranges[1][0]], [0.0, map.ranges[1][1]]],
            ];
            for axis in axes {
                plot.line(Line::new("", PlotPoints::from(axis.to_vec())).color(Color32::from_gray(0x70)));
            }
            plot.points(
                Points::new("this sea", PlotPoints::from(vec![map.point]))
                    .radius(5.0)
                    .color(Color32::from_rgb(0xe8, 0xb0, 0x4a)),
            );
            plot.pointer_coordinate()
        });
        if let (Some(gesture), Some(at)) = (Gesture::double_click(&shown.response), shown.inner) {
            let path = Path::node(&sea.name);
            let round = |value: f64| json!((value * 1e4).round() / 1e4);
            let edit = Edit::set(path.to(across), &round(at.x)).then(Edit::set(path.to(up), &round(at.y)));
            gesture.edit(edit, actions);
        }
        ui.weak(format!("{} Double-click to move the sea there.", map.note));
    }
    egui::Grid::new("figures").num_columns(3).striped(true).show(ui, |ui| {
        ui.strong("");
        ui.strong("predicted");
        ui.strong("measured");
        ui.end_row();
        for figure in &stability.figures {
            let unit = if figure.unit.is_empty() { String::new() } else { format!(", {}", figure.unit) };
            ui.label(format!("{}{unit}", figure.name)).on_hover_text(&figure.note);
            let cell = |value: Option<f64>| value.map_or_else(|| "—".into(), number);
            ui.label(cell(figure.predicted));
            let color = match figure.holds() {
                Some(false) => crate::theme::error(ui.visuals()),
                _ => ui.visuals().text_color(),
            };
            ui.label(RichText::new(cell(figure.measured)).color(color));
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_count_names_waves_that_are_not_random() {
        assert_eq!(parts(300, 300, 0, 0), None);
        assert_eq!(parts(754, 300, 4, 1).as_deref(), Some("300 random, 4 set by hand, 450 of 1 group"));
        assert_eq!(parts(750, 300, 0, 2).as_deref(), Some("300 random, 450 of 2 groups"));
    }
}
