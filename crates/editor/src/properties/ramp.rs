//! The ramp editor: a gradient with draggable stops.

use super::color;
use crate::actions::Action;
use crate::document::{Edit, Op, Path};
use crate::field::{self, Gesture};
use crate::state::State;
use egui::{Color32, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2};
use serde_json::{Value, json};
use trochoid::Item;

/// Radius of a stop's handle.
const HANDLE: f32 = 6.0;

/// Returns whether items describe the stops of a color ramp.
pub(super) fn is_ramp(items: &[Item]) -> bool {
    items.iter().any(|item| {
        matches!(item, Item::List(list) if list.name == "stops"
            && list.items.iter().any(|item| item.name() == "at")
            && list.items.iter().any(|item| item.name() == "color"))
    })
}

/// Draws the gradient and its stops: drag to move, double-click to add, right-click to remove.
pub(super) fn ramp_ui(ui: &mut Ui, state: &State, path: &Path, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    let stops_path = path.to("stops");
    let Some(stops) = sheet.get(&stops_path).and_then(Value::as_array) else { return };
    let read = |stop: &Value| {
        let at = stop.get("at")?.as_f64()?;
        // A stop connected to a picture has no single color to show.
        let color = stop.get("color").and_then(|value| color::display(value, state));
        Some((at as f32, color))
    };
    let Some(known) = stops.iter().map(read).collect::<Option<Vec<_>>>() else { return };
    let (first, last) = known.iter().fold((0.0_f32, 1.0_f32), |(low, high), stop| (low.min(stop.0), high.max(stop.0)));
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 44.0), Sense::click_and_drag());
    let bar = Rect::from_min_max(rect.min, pos2(rect.max.x, rect.max.y - 14.0)).shrink2(vec2(HANDLE + 1.5, 0.0));
    let x = |at: f32| bar.left() + bar.width() * (at - first) / (last - first).max(1e-6);
    let at = |x: f32| first + (last - first) * ((x - bar.left()) / bar.width()).clamp(0.0, 1.0);
    let painter = ui.painter_at(rect);
    let gray = [0.5; 3];
    let color_at = |t: f32| {
        let next = known.iter().position(|stop| stop.0 > t).unwrap_or(known.len());
        match (next.checked_sub(1).and_then(|before| known.get(before)), known.get(next)) {
            (Some(a), Some(b)) => {
                let share = (t - a.0) / (b.0 - a.0).max(1e-6);
                let (a, b) = (a.1.unwrap_or(gray), b.1.unwrap_or(gray));
                [0, 1, 2].map(|c| a[c] + share * (b[c] - a[c]))
            }
            (Some(only), None) | (None, Some(only)) => only.1.unwrap_or(gray),
            (None, None) => gray,
        }
    };
    let paint = |color: [f32; 3]| {
        let [r, g, b] = color.map(|value| (value * 255.0).round() as u8);
        Color32::from_rgb(r, g, b)
    };
    let steps = (bar.width() as usize / 2).max(1);
    for step in 0..steps {
        let left = bar.left() + bar.width() * step as f32 / steps as f32;
        let piece =
            Rect::from_min_max(pos2(left, bar.top()), pos2(left + bar.width() / steps as f32 + 0.5, bar.bottom()));
        painter.rect_filled(piece, 0.0, paint(color_at(at(piece.center().x))));
    }
    let handle = |at: f32| pos2(x(at), bar.bottom() + 7.0);
    for (place, own) in &known {
        let center = handle(*place);
        painter.line_segment(
            [pos2(center.x, bar.top()), pos2(center.x, bar.bottom())],
            Stroke::new(1.0, Color32::from_white_alpha(90)),
        );
        painter.circle(center, HANDLE, paint(own.unwrap_or(gray)), Stroke::new(1.5, ui.visuals().text_color()));
    }
    let nearest = |pointer: Pos2| {
        let all = known.iter().enumerate().map(|(index, stop)| (index, (x(stop.0) - pointer.x).abs()));
        all.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|found| found.1 < 9.0).map(|found| found.0)
    };
    let id = response.id.with("stop");
    if response.drag_started()
        && let Some(origin) = ui.input(|input| input.pointer.press_origin())
    {
        ui.data_mut(|data| data.insert_temp(id, nearest(origin)));
    }
    let dragged = ui.data_mut(|data| data.get_temp::<Option<usize>>(id)).flatten();
    let dragged = dragged.filter(|index| *index < known.len());
    let drag = Gesture::drag(&response).zip(response.interact_pointer_pos());
    if let (Some(index), Some((gesture, pointer))) = (dragged, drag) {
        // Stops keep their order, if they have one.
        let below = index.checked_sub(1).map_or(f32::NEG_INFINITY, |before| known[before].0);
        let above = known.get(index + 1).map_or(f32::INFINITY, |after| after.0);
        let value = json!(field::rounded(f64::from(at(pointer.x).min(above).max(below))));
        let edit = Edit::set(stops_path.to(index).to("at"), &value).merging(format!("{stops_path} drag"));
        gesture.edit(edit, actions);
    }
    if response.drag_stopped() {
        ui.data_mut(|data| data.remove::<Option<usize>>(id));
        actions.push(Action::Seal);
    }
    let pointer = response.interact_pointer_pos();
    if let Some((pointer, gesture)) = pointer.zip(Gesture::double_click(&response)) {
        let place = at(pointer.x);
        let stop =
            json!({ "at": field::rounded(f64::from(place)), "color": crate::document::color::hex(color_at(place)) });
        let index = known.iter().position(|stop| stop.0 > place).unwrap_or(known.len());
        let op = if index == known.len() { Op::Set } else { Op::Insert };
        gesture.edit(
            Edit::new("Add a stop", vec![op(stops_path.to(index), crate::document::change::style(&stop))]),
            actions,
        );
    }
    if let (Some(gesture), Some(index)) = (Gesture::secondary_click(&response), pointer.and_then(nearest))
        && known.len() > 2
    {
        gesture.edit(Edit::new("Remove a stop", vec![Op::Remove(stops_path.to(index))]), actions);
    }
    response.on_hover_text("Drag to move a stop. Double-click to add one. Right-click to remove one.");
}
