//! Keyframed values: keys, interpolation, and the curve editor.

use super::context::{Properties, WidgetContext};
use crate::actions::Action;
use crate::document::curve::{Curve, Key};
use crate::field::{FieldResponse, Gesture};
use crate::refusal::refusal_ui;
use egui::{Color32, Sense, Shape, Stroke, Ui, vec2};
use egui_plot::{Line, Plot, PlotPoint, PlotPoints, Points, VLine};
use serde_json::Value;
use trochoid::Interpolation;

/// Draws a field for the value at a frame, and returns the result together with that frame: the current frame, or the
/// frame at which typing began, however far playback has moved since.
pub(super) fn typed_ui(
    ui: &mut Ui,
    place: &WidgetContext<'_>,
    content: impl FnOnce(&mut Ui, f64) -> FieldResponse<Value>,
) -> (FieldResponse<Value>, f64) {
    let id = ui.id().with(("typed since", place.path.to_string()));
    let since = ui.data(|data| data.get_temp::<f64>(id));
    let frame = since.unwrap_or(place.state.frame as f64);
    let told = content(ui, frame);
    let focused = ui.memory(|memory| memory.focused()).filter(|_| ui.ctx().text_edit_focused());
    let focused = focused.and_then(|id| ui.ctx().read_response(id));
    if focused.is_some_and(|focused| told.response.rect.contains(focused.rect.center())) {
        ui.data_mut(|data| data.insert_temp(id, frame));
    } else if since.is_some() {
        ui.data_mut(|data| data.remove_temp::<f64>(id));
    }
    (told, frame)
}

/// Requests the edit of a given value: as a key at the frame if the value is keyframed.
pub(super) fn tell(
    told: FieldResponse<Value>,
    keyed: Option<&Curve>,
    frame: f64,
    place: &WidgetContext<'_>,
    actions: &mut Vec<Action>,
) {
    told.edit(actions, |value| match keyed {
        Some(keyed) => place.set(&keyed.keyed(frame, &value).write()),
        None => place.set(&value),
    });
}

/// Draws the buttons that set or remove a key and show the curve.
pub(super) fn button_ui(
    panel: &mut Properties,
    ui: &mut Ui,
    keyed: Option<&Curve>,
    shown: &Value,
    place: &WidgetContext<'_>,
    actions: &mut Vec<Action>,
) {
    let frame = place.state.frame as f64;
    let help = match keyed {
        Some(keyed) if keyed.find(frame).is_some() => "Remove the key at this frame",
        Some(_) => "Set a key at this frame",
        None => "Animate this value with keys",
    };
    let filled = keyed.is_some_and(|keyed| keyed.find(frame).is_some());
    let diamond = diamond_ui(ui, filled, keyed.is_some()).on_hover_text(help);
    diamond.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, help));
    if let Some(gesture) = Gesture::click(&diamond) {
        switch(gesture, keyed, shown, place, actions);
    }
    if keyed.is_some() {
        let mut open = panel.curves.contains(&place.path);
        if ui.toggle_value(&mut open, "Curve").on_hover_text("Show the curve").clicked() {
            if open {
                panel.curves.insert(place.path.clone())
            } else {
                panel.curves.remove(&place.path)
            };
        }
    }
}

/// Draws the entry of a knob's menu that sets or removes a key at this frame.
pub(super) fn menu_ui(ui: &mut Ui, shown: &Value, place: &WidgetContext<'_>, actions: &mut Vec<Action>) {
    let keyed = place.value.and_then(Curve::read);
    let frame = place.state.frame as f64;
    let has_key = keyed.as_ref().is_some_and(|keyed| keyed.find(frame).is_some());
    let entry = ui.button(if has_key { "Remove key" } else { "Set key" });
    if let Some(gesture) = Gesture::click(&entry) {
        switch(gesture, keyed.as_ref(), shown, place, actions);
        ui.close();
    }
}

/// Sets a key at this frame, or removes it.
fn switch(
    gesture: Gesture,
    keyed: Option<&Curve>,
    shown: &Value,
    place: &WidgetContext<'_>,
    actions: &mut Vec<Action>,
) {
    let frame = place.state.frame as f64;
    let value = match keyed {
        Some(keyed) if keyed.find(frame).is_some() => {
            keyed.without(&[frame]).map_or_else(|| shown.clone(), |keyed| keyed.write())
        }
        Some(keyed) => keyed.keyed(frame, shown).write(),
        None => Curve { keys: Vec::new(), interpolation: Interpolation::Linear }.with(frame, shown).write(),
    };
    gesture.edit(place.set(&value), actions);
    actions.push(Action::Seal);
}

/// Draws a keyframe diamond, filled if there is a key at the current frame.
fn diamond_ui(ui: &mut Ui, filled: bool, keyed: bool) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(vec2(14.0, ui.spacing().interact_size.y), Sense::CLICK);
    let color = match (response.hovered(), keyed) {
        (true, _) => ui.visuals().strong_text_color(),
        (false, true) => Color32::from_rgb(0xe8, 0xb0, 0x4a),
        (false, false) => ui.visuals().weak_text_color(),
    };
    let corners = [vec2(0.0, -4.5), vec2(4.5, 0.0), vec2(0.0, 4.5), vec2(-4.5, 0.0)].map(|to| rect.center() + to);
    let fill = if filled { color } else { Color32::TRANSPARENT };
    ui.painter().add(Shape::convex_polygon(corners.to_vec(), fill, Stroke::new(1.2, color)));
    response
}

/// Colors of vector components.
const COMPONENTS: [Color32; 4] = [
    Color32::from_rgb(0xe0, 0x6a, 0x6a),
    Color32::from_rgb(0x6a, 0xc4, 0x7e),
    Color32::from_rgb(0x6a, 0x9c, 0xe0),
    Color32::from_rgb(0xd0, 0xa0, 0x50),
];

/// The key being dragged.
#[derive(Clone, Copy)]
struct DraggedKey {
    key: usize,
    component: usize,
    /// Bounds of the plot during the drag.
    bounds: egui_plot::PlotBounds,
    /// Whether the plot's bounds followed the curve before, in x and y; `None` until it is drawn.
    auto: Option<egui::Vec2b>,
}

/// Returns where the pointer was pressed since the last frame.
fn pressed(input: &egui::InputState) -> Option<egui::Pos2> {
    input.pointer.press_origin().filter(|_| input.pointer.primary_pressed())
}

/// Draws the curve editor: keys can be dragged, and a double-click sets a new key.
pub(super) fn curve_ui(ui: &mut Ui, keyed: &Curve, unit: &str, place: &WidgetContext<'_>, actions: &mut Vec<Action>) {
    let Some(animated) = keyed.animated() else { return };
    let (first, last) = (place.state.range.0 as f64, place.state.range.1 as f64);
    let first = first.min(keyed.keys.first().map_or(first, |key| key.frame));
    let last = last.max(keyed.keys.last().map_or(last, |key| key.frame)).max(first + 1.0);
    let count = animated.at(first).len().min(COMPONENTS.len());
    let lines: Vec<Vec<[f64; 2]>> = (0..count)
        .map(|component| {
            let frames = (0..=200).map(|step| first + (last - first) * f64::from(step) / 200.0);
            frames.map(|frame| [frame, animated.at(frame)[component]]).collect()
        })
        .collect();
    let id = ui.id().with(("dragged key", place.path.to_string()));
    let mut held = ui.data_mut(|data| data.get_temp::<Option<DraggedKey>>(id)).flatten();
    // A press is resolved against the plot as last drawn, so movement before the next frame does not matter.
    let before = ui.data(|data| data.get_temp::<egui_plot::PlotTransform>(id));
    if let (Some(before), Some(at)) = (before, ui.input(pressed)) {
        let near = |(key, component): &(usize, usize)| {
            let value = keyed.keys[*key].numbers().get(*component).copied().unwrap_or(f64::INFINITY);
            before.position_from_point(&PlotPoint::new(keyed.keys[*key].frame, value)).distance(at)
        };
        let all = (0..keyed.keys.len()).flat_map(|key| (0..count).map(move |component| (key, component)));
        let nearest = all.min_by(|a, b| near(a).total_cmp(&near(b))).filter(|key| near(key) < 9.0);
        held = nearest.map(|(key, component)| DraggedKey { key, component, bounds: *before.bounds(), auto: None });
    }
    let plot = Plot::new("curve").id(id.with("plot")).height(150.0);
    let plot = crate::plots::even(plot, "frame", unit).allow_drag(held.is_none()).allow_boxed_zoom(false);
    let shown = plot.show(ui, |plot| {
        if let Some(held) = &mut held {
            // The plot does not scroll during the drag.
            held.auto.get_or_insert(plot.auto_bounds());
            plot.set_plot_bounds(held.bounds);
        }
        plot.vline(VLine::new("frame", place.state.frame as f64).color(Color32::from_gray(0x90)));
        for (component, line) in lines.iter().enumerate() {
            plot.line(Line::new("", PlotPoints::from(line.clone())).color(COMPONENTS[component]));
            let keys: Vec<[f64; 2]> =
                keyed.keys.iter().filter_map(|key: &Key| Some([key.frame, *key.numbers().get(component)?])).collect();
            plot.points(Points::new("", PlotPoints::from(keys)).radius(5.0).color(COMPONENTS[component]));
        }
    });
    let response = shown.response;
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Other, true, "Keys over frames"));
    let pointer = ui.input(|input| input.pointer.latest_pos()).map(|at| shown.transform.value_from_position(at));
    if let (Some(DraggedKey { key, component, .. }), Some(at), Some(gesture)) =
        (held, pointer, Gesture::dragged(&response))
        && key < keyed.keys.len()
    {
        let mut moved = keyed.clone();
        let below = key.checked_sub(1).map_or(f64::NEG_INFINITY, |before| keyed.keys[before].frame + 1.0);
        let above = keyed.keys.get(key + 1).map_or(f64::INFINITY, |after| after.frame - 1.0);
        // A key between keys less than two frames apart keeps its frame.
        if below <= above {
            moved.keys[key].frame = at.x.round().clamp(below, above);
        }
        moved.keys[key].set(component, at.y);
        if moved != *keyed {
            gesture.tried(&response).edit(place.set(&moved.write()), actions);
        }
    }
    refusal_ui(ui, &response);
    if response.drag_stopped() {
        actions.push(Action::Seal);
    }
    let let_go = held.take_if(|_| !ui.input(|input| input.pointer.primary_down()));
    let auto = let_go.and_then(|held| held.auto);
    if let (Some(auto), Some(mut memory)) = (auto, egui_plot::PlotMemory::load(ui.ctx(), id.with("plot"))) {
        memory.auto_bounds = auto;
        memory.store(ui.ctx(), id.with("plot"));
    }
    if let (Some(gesture), Some(at)) = (Gesture::double_click(&response), pointer) {
        let gesture = gesture.tried(&response);
        gesture.edit(place.set(&keyed.inserted(at.x.round()).write()), actions);
        actions.push(Action::Seal);
    }
    ui.data_mut(|data| {
        data.insert_temp(id, held);
        data.insert_temp(id, shown.transform);
    });
    ui.horizontal_wrapped(|ui| {
        for word in Interpolation::NAMES {
            let is_present = keyed.interpolation.name() == word;
            if let Some(gesture) = Gesture::click(&ui.selectable_label(is_present, word)) {
                let all: Vec<f64> = keyed.keys.iter().map(|key| key.frame).collect();
                let keyed = keyed.interpolated(&all, Interpolation::from_name(word).unwrap_or_default());
                gesture.edit(place.set(&keyed.write()), actions);
                actions.push(Action::Seal);
            }
        }
    });
}
