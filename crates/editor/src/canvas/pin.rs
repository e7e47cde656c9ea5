//! Pins: the inputs and outputs of nodes, where wires begin and end.

use super::Canvas;
use super::connect;
use super::drag::Gesture;
use super::plan::{End, Plan};
use crate::document::{Pin, Sheet};
use crate::{format, theme};
use egui::epaint::TextShape;
use egui::vec2;
use egui::{
    Color32, FontId, PointerButton, Pos2, Rect, RichText, Sense, Stroke, StrokeKind, Ui, WidgetInfo, WidgetType,
};
use serde_json::Value;

/// Radius of a pin.
const RADIUS: f32 = 4.2;
/// Minimum zoom at which there are pins: below it, they would stand on names, and be too small to be pulled.
pub(super) const SHOWN: f32 = 0.45;
/// Zoom from which on the names of all pins of a node under the pointer are legible.
const NAMED: f32 = 0.9;
/// Distance at which the pointer takes a pin, in points.
const REACH: f32 = 8.0;
/// Angle of the labels above pins, in radians.
const SLANT: f32 = -0.66;

impl Canvas {
    /// Draws the pins of a node and handles their input. Returns whether one was right-clicked, which asks for the node's
    /// menu.
    pub(super) fn pins_ui(&mut self, plan: &Plan, ui: &Ui, node: usize, hovered: bool) -> bool {
        if self.view.zoom < SHOWN {
            return false;
        }
        let about = &plan.sheet.nodes[node];
        let outputs = (0..about.makes.len()).map(|output| End::Output(node, output));
        let pins = (0..about.pins.len()).map(|pin| End::Pin(node, pin));
        outputs.chain(pins).fold(false, |asked, end| self.pin_ui(plan, ui, end, hovered) | asked)
    }

    fn pin_ui(&mut self, plan: &Plan, ui: &Ui, end: End, hovered: bool) -> bool {
        let zoom = self.view.zoom;
        let at = self.view.screen(plan.end(end));
        let radius = (RADIUS * zoom).clamp(1.8, 8.0);
        let reach = REACH.max(radius + 2.5);
        // Halfway to the next pin, the other one is meant.
        let side = |next: Option<End>| {
            next.map_or(reach, |next| reach.min(zoom * plan.end(next).distance(plan.end(end)) / 2.0))
        };
        let [before, after] = beside(plan, end);
        let place = Rect::from_min_max(at - vec2(side(before), reach), at + vec2(side(after), reach));
        // The node's name is part of the id: otherwise another pin would inherit it when a node is deleted.
        let name = &plan.sheet.nodes[end.node()].name;
        let response = ui.interact(place, ui.id().with((name, index_of(end))), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, plan.spoken(end)));
        let idle = matches!(self.gesture, Gesture::Idle);
        if idle && response.drag_started_by(PointerButton::Primary) {
            self.pull(plan, end, at, false);
        } else if response.clicked() {
            self.clicked = Some(end);
        }
        let mut strength = 1.0;
        if let Gesture::Pull(pull) = &self.gesture {
            let may = end == pull.held || connect::fits(&plan.sheet, pull.held, end, &pull.barred);
            strength = if may { 1.0 } else { 0.15 };
        }
        let behind = ui.visuals().panel_fill;
        let large = radius * if response.hovered() && idle { 1.35 } else { 1.0 };
        match end {
            End::Output(node, output) => {
                let color = theme::kind(connect::kind(&plan.sheet, (node, output))).gamma_multiply(strength);
                ui.painter().circle(at, large, color, Stroke::new(1.0, behind));
            }
            End::Pin(node, index) => {
                let pin = &plan.sheet.nodes[node].pins[index];
                let wire = plan.wire_at((node, index));
                let wired = wire.is_some();
                let swatch = if wired { None } else { swatch(&plan.sheet, pin) };
                // What flows through a wire has its color up to the end of it.
                let flows = wire.and_then(|wire| plan.sheet.kind(&plan.sheet.wires[wire]));
                let color = match flows {
                    None if pin.takes_all => theme::kind(None),
                    None => theme::accepts(pin.accepts),
                    kind => theme::kind(kind),
                };
                draw_pin(ui, at, large, pin, (wired, swatch), color.gamma_multiply(strength), strength);
                let close = zoom >= 1.5;
                if let Some(text) = constant(pin).filter(|_| close && !wired) {
                    label(ui, at, radius, &text, 9.0 * zoom.min(1.6), ui.visuals().text_color(), hovered);
                }
                // Where names would lie over each other, only that of the pin under the pointer is there.
                let has_room = hovered && zoom >= NAMED;
                if has_room || response.hovered() || close && !pin.more && constant(pin).is_none() {
                    let size = (9.5 * zoom).clamp(9.0, 15.0);
                    label(ui, at, radius, &pin.label, size, ui.visuals().strong_text_color(), hovered);
                }
            }
        }
        let asks = response.secondary_clicked();
        if self.explains() && response.hovered() {
            response.on_hover_ui(|ui| about_ui(plan, ui, end));
        }
        asks
    }

    /// Handles a click on a pin: a wire follows the pointer until another pin is clicked.
    pub(super) fn click_pin(
        &mut self,
        plan: &Plan,
        ui: &Ui,
        state: &crate::state::State,
        actions: &mut Vec<crate::actions::Action>,
    ) {
        let Some(end) = self.clicked.take().filter(|_| !self.has_plugged) else { return };
        let at = self.view.screen(plan.end(end));
        match std::mem::take(&mut self.gesture) {
            Gesture::Pull(pull) if pull.sticky => {
                let opposite = matches!(pull.held, End::Output(..)) != matches!(end, End::Output(..));
                if opposite {
                    self.plug(plan, state, pull.held, end, pull.old, at, actions);
                }
            }
            Gesture::Idle => {
                // A click on a connected pin keeps its wire; only a free pin starts a new one.
                let empty = !matches!(end, End::Pin(node, pin) if plan.wire_at((node, pin)).is_some());
                if empty {
                    self.pull(plan, end, at, true);
                    ui.ctx().request_repaint();
                }
            }
            other => self.gesture = other,
        }
    }
}

/// Returns the pins before and after a pin on the same edge of its node.
fn beside(plan: &Plan, end: End) -> [Option<End>; 2] {
    let node = &plan.sheet.nodes[end.node()];
    let (index, count) = match end {
        End::Output(_, output) => (output, node.makes.len()),
        End::Pin(_, pin) => (pin, node.pins.len()),
    };
    let other = |index: usize| match end {
        End::Output(node, _) => End::Output(node, index),
        End::Pin(node, _) => End::Pin(node, index),
    };
    [index.checked_sub(1).map(other), Some(index + 1).filter(|next| *next < count).map(other)]
}

fn index_of(end: End) -> (bool, usize) {
    match end {
        End::Output(_, output) => (true, output),
        End::Pin(_, pin) => (false, pin),
    }
}

fn draw_pin(
    ui: &Ui,
    at: Pos2,
    radius: f32,
    pin: &Pin,
    (wired, swatch): (bool, Option<Color32>),
    color: Color32,
    strength: f32,
) {
    let painter = ui.painter();
    let behind = ui.visuals().panel_fill;
    let missing = pin.required && pin.value.is_none();
    if let Some(swatch) = swatch {
        let place = Rect::from_center_size(at, vec2(2.1, 2.1) * radius);
        painter.rect_filled(place, 1.5, swatch.gamma_multiply(strength));
        painter.rect_stroke(place, 1.5, Stroke::new(1.0, color), StrokeKind::Outside);
    } else if missing {
        painter.circle(at, radius, behind, Stroke::new(1.8, theme::error(ui.visuals()).gamma_multiply(strength)));
    } else if wired {
        painter.circle(at, radius, color, Stroke::new(1.0, behind));
    } else {
        painter.circle(at, radius * 0.85, behind, Stroke::new(1.3, color));
    }
}

/// Draws a label that slants up from a pin.
fn label(ui: &Ui, at: Pos2, radius: f32, text: &str, size: f32, color: Color32, plate: bool) {
    let galley = ui.painter().layout_no_wrap(text.into(), FontId::proportional((2.0 * size).round() / 2.0), color);
    let up = vec2(SLANT.cos(), SLANT.sin());
    let across = vec2(-up.y, up.x);
    let height = galley.size().y;
    let start = at + up * (radius + 3.0) - across * (height / 2.0);
    if plate {
        // A background, because wires run here.
        let along = up * galley.size().x;
        // No taller than necessary: the next label is close.
        let (near, far) = (start + across * (0.22 * height), start + across * (0.82 * height));
        let corners = [near, near + along, far + along, far];
        let fill = ui.visuals().panel_fill.gamma_multiply(0.85);
        ui.painter().add(egui::Shape::convex_polygon(corners.to_vec(), fill, Stroke::NONE));
    }
    ui.painter().add(TextShape::new(start, galley, color).with_angle(SLANT));
}

/// Returns the color value of an unconnected pin.
fn swatch(sheet: &Sheet, pin: &Pin) -> Option<Color32> {
    match pin.value.as_ref()? {
        Value::String(text) if text.starts_with('#') => Color32::from_hex(text).ok(),
        Value::String(text) => {
            let [r, g, b] = sheet.named(text)?.map(|channel| (channel * 255.0).round() as u8);
            Some(Color32::from_rgb(r, g, b))
        }
        Value::Array(parts) if parts.len() == 3 && pin.accepts.takes_color() => {
            let [r, g, b] = [0, 1, 2].map(|index| {
                let linear = parts[index].as_f64().unwrap_or_default();
                (trochoid::srgb_encode(linear.clamp(0.0, 1.0)) * 255.0).round() as u8
            });
            Some(Color32::from_rgb(r, g, b))
        }
        _ => None,
    }
}

/// Returns the number value of an unconnected pin.
fn constant(pin: &Pin) -> Option<String> {
    let number = pin.value.as_ref()?.as_f64()?;
    let text = format::number(number);
    Some(if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        text
    })
}

fn about_ui(plan: &Plan, ui: &mut Ui, end: End) {
    ui.set_max_width(280.0);
    let node = &plan.sheet.nodes[end.node()];
    match end {
        End::Output(_, output) => {
            let (name, kind) = node.makes[output];
            let kind = kind.map_or_else(|| "unknown kind".to_string(), |kind| kind.to_string());
            ui.label(RichText::new(format!("{}.{name}", node.name)).strong());
            ui.weak(format!("Output: {kind}"));
            if let Some(known) = node.declaration.and_then(|known| known.outputs.get(output)) {
                ui.label(known.help);
            }
        }
        End::Pin(_, index) => {
            let pin = &node.pins[index];
            ui.label(RichText::new(format!("{}.{}", node.called(), pin.label)).strong());
            let accepts = if pin.takes_all { "anything".to_string() } else { pin.accepts.to_string() };
            ui.weak(format!("Accepts: {accepts}{}", if pin.required { ", required" } else { "" }));
            ui.label(pin.help);
            if let Some(text) = pin.value.as_ref().filter(|_| plan.wire_at((end.node(), index)).is_none()) {
                ui.weak(format!("Value: {}", crate::document::change::style(text)));
            }
        }
    }
}
