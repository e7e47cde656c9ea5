//! Drawing of nodes, and their input.

use super::Canvas;
use super::drag::{Gesture, Move};
use super::menu::MenuTarget;
use super::place::{HEAD, has_picture};
use super::plan::Plan;
use super::wire::{faded, left_out};
use crate::actions::Action;
use crate::document::Node;
use crate::document::sheet::Side;
use crate::state::State;
use crate::{format, theme};
use egui::epaint::RectShape;
use egui::text::{LayoutJob, TextFormat, TextWrapping};
use egui::{Align2, Color32, CornerRadius, FontId, PointerButton, Pos2, Rect, RichText, Sense, Stroke, StrokeKind};
use egui::{Ui, WidgetInfo, WidgetType, pos2, vec2};
use std::collections::BTreeSet;
use trochoid::{End, State as Fate};

/// Share of the total time above which a node displays its time.
const COSTLY: f64 = 0.02;

/// Minimum legible font size, in points.
pub(super) const LEGIBLE: f32 = 9.0;

/// Minimum width of a node on the screen for its name to be drawn, in points.
const NAMED: f32 = 30.0;

/// Colors of the parts of a node.
struct Paint {
    fill: Color32,
    edge: Color32,
    text: Color32,
    weak: Color32,
    chosen: Color32,
}

impl Paint {
    fn of(ui: &Ui) -> Self {
        let visuals = ui.visuals();
        let dark = visuals.dark_mode;
        Self {
            fill: if dark { Color32::from_gray(0x38) } else { Color32::from_gray(0xf8) },
            edge: if dark { Color32::from_gray(0x12) } else { Color32::from_gray(0xa0) },
            text: if dark { Color32::from_gray(0xf0) } else { Color32::from_gray(0x18) },
            weak: if dark { Color32::from_gray(0xb8) } else { Color32::from_gray(0x58) },
            chosen: if dark { Color32::from_rgb(0x6c, 0xb8, 0xff) } else { Color32::from_rgb(0x1c, 0x6f, 0xc4) },
        }
    }
}

/// Returns the names of the nodes that use the color selected in the palette, and that color.
fn users(state: &State) -> (Vec<String>, Color32) {
    let Some(chosen) = &state.colors.chosen else { return (Vec::new(), Color32::WHITE) };
    let swatch = state.swatches().into_iter().find(|swatch| swatch.key == *chosen);
    let color = swatch.as_ref().and_then(|swatch| swatch.color).unwrap_or([1.0; 3]);
    let [r, g, b] = color.map(|channel| (255.0 * channel).round() as u8);
    (swatch.map(|swatch| swatch.nodes()).unwrap_or_default(), Color32::from_rgb(r, g, b))
}

impl Canvas {
    /// Draws all nodes and handles their input.
    pub(super) fn nodes_ui(&mut self, plan: &Plan, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
        let paint = Paint::of(ui);
        self.marks.clear();
        let total: f64 = state.evaluated.nodes.values().map(|node| node.seconds).sum();
        let (users, ink) = users(state);
        for index in 0..plan.boxes.len() {
            if !plan.is_seen(index, &self.view) {
                continue;
            }
            let node = &plan.sheet.nodes[index];
            let seen = self.view.area(plan.boxes[index]);
            let id = ui.id().with(("node", &node.name));
            let response = ui.interact(seen, id, Sense::click_and_drag());
            let chosen = state.selection.contains(&node.name);
            response.widget_info(|| {
                let label = match node.side {
                    Some(Side::Input) => format!("Input {} of the group", node.name),
                    Some(Side::Output) => format!("Output {} of the group", node.called()),
                    None => format!("Node {}, {}", node.name, node.ty),
                };
                WidgetInfo::selected(WidgetType::Button, true, chosen, label)
            });
            self.draw_node(plan, ui, state, index, &paint, total);
            if users.contains(&node.name) {
                // Nodes that use the color selected in the palette.
                let round = CornerRadius::same((8.0 * self.view.zoom).clamp(2.0, 14.0) as u8);
                for (width, color) in [(5.0, Color32::BLACK), (3.0, ink)] {
                    let stroke = Stroke::new(width, color);
                    ui.painter().rect_stroke(seen.expand(2.0), round, stroke, StrokeKind::Outside);
                }
            }
            self.marks_ui(plan, ui, state, index, actions);
            self.fault_ui(plan, ui, state, index, actions);
            let on_pin = self.pins_ui(plan, ui, index, response.hovered());
            if response.clicked() {
                actions.push(Action::Select(picked(ui, state, &node.name)));
            }
            if response.double_clicked() {
                actions.push(match node.is_use {
                    true => Action::Enter(state.scope.iter().cloned().chain([node.name.clone()]).collect()),
                    false => Action::Look(state.whole_name(&node.name), 0),
                });
            }
            if response.secondary_clicked() || on_pin {
                if !chosen {
                    actions.push(Action::Select([node.name.clone()].into()));
                }
                self.open_menu(ui, MenuTarget::Nodes);
            }
            if response.drag_started_by(PointerButton::Primary) && matches!(self.gesture, Gesture::Idle) {
                self.grab(plan, ui, state, index, actions);
            }
            if response.hovered() && self.explains() {
                response.on_hover_ui(|ui| about_ui(plan, ui, state, index, total));
            }
        }
    }

    /// Starts moving a node together with the selection.
    fn grab(&mut self, plan: &Plan, ui: &Ui, state: &State, index: usize, actions: &mut Vec<Action>) {
        let Some(origin) = ui.input(|input| input.pointer.press_origin()) else { return };
        let name = &plan.sheet.nodes[index].name;
        let mut names = state.selection.clone();
        if !names.contains(name) {
            if !ui.input(|input| input.modifiers.shift) {
                names.clear();
            }
            names.insert(name.clone());
            actions.push(Action::Select(names.clone()));
        }
        let nodes = names.iter().filter_map(|name| plan.sheet.find(name)).collect();
        self.gesture = Gesture::Move(Move::new(nodes, index, self.view.canvas(origin)));
    }

    fn draw_node(&mut self, plan: &Plan, ui: &Ui, state: &State, index: usize, paint: &Paint, total: f64) {
        let node = &plan.sheet.nodes[index];
        let zoom = self.view.zoom;
        let seen = self.view.area(plan.boxes[index]);
        let painter = ui.painter();
        let kind = theme::kind(node.makes.first().and_then(|(_, kind)| *kind));
        let out = node.disabled || left_out(state, node);
        let dim = out || plan.idle.contains(&index);
        // Dimmed nodes keep their place and let the others stand out.
        let tone = |color: Color32| if dim { faded(color, ui.visuals().panel_fill, 0.55) } else { color };
        let ink = |color: Color32| if dim { faded(color, ui.visuals().panel_fill, 0.3) } else { color };
        let chosen = state.selection.contains(&node.name);
        // The boxes of a group's inputs and outputs are round at their outer ends.
        let (soft, plain) = ((16.0 * zoom).clamp(2.0, 30.0) as u8, (5.0 * zoom).clamp(1.0, 12.0) as u8);
        let round = match node.side {
            Some(Side::Input) => CornerRadius { nw: soft, ne: soft, ..CornerRadius::same(plain) },
            Some(Side::Output) => CornerRadius { sw: soft, se: soft, ..CornerRadius::same(plain) },
            None => CornerRadius::same(plain),
        };
        let head = Rect::from_min_size(seen.min, vec2(seen.width(), HEAD * zoom));
        let front = node.declaration.is_some_and(|known| known.end == End::Front);
        let family = faded(kind, paint.fill, if front { 0.82 } else { 0.55 });
        if zoom < 0.25 {
            painter.rect_filled(seen, 0.0, tone(faded(kind, paint.fill, 0.4)));
        } else {
            if zoom > 0.4 && !dim {
                let shadow = egui::Shadow { offset: [0, 2], blur: 6, spread: 0, color: Color32::from_black_alpha(60) };
                painter.add(shadow.as_shape(seen, round));
            }
            if node.is_use {
                // Like a pile, of which the upper one is seen.
                for by in [6.0, 3.0] {
                    let behind = seen.translate(vec2(by * zoom, by * zoom));
                    painter.rect_filled(behind, round, tone(paint.fill));
                    painter.rect_stroke(behind, round, Stroke::new(1.0, tone(paint.edge)), StrokeKind::Outside);
                }
            }
            painter.rect_filled(seen, round, tone(paint.fill));
            let top = if has_picture(node) { CornerRadius { sw: 0, se: 0, ..round } } else { round };
            painter.rect_filled(head, top, tone(family));
            // Stripe in the color of the kind: the head itself may be almost gray.
            let stripe = Rect::from_min_size(head.min, vec2((4.0 * zoom).max(2.0), head.height()));
            if node.side.is_none() {
                painter.rect_filled(stripe, CornerRadius { ne: 0, se: 0, ..top }, tone(kind));
            }
            if has_picture(node) {
                self.draw_picture(
                    ui,
                    state,
                    &state.whole_name(&node.name),
                    Rect::from_min_max(head.left_bottom(), seen.max),
                    out,
                );
            }
        }
        let fault = plan.faults.get(&index);
        let own = fault.is_some_and(|fault| fault.culprit == node.name);
        let edge = match (chosen, own) {
            (true, _) => Stroke::new(2.0, paint.chosen),
            (false, true) => Stroke::new(1.5, theme::error(ui.visuals())),
            (false, false) => Stroke::new(1.0, tone(paint.edge)),
        };
        if zoom >= 0.25 || chosen || own {
            painter.rect_stroke(seen, round, edge, StrokeKind::Outside);
        }
        if seen.width() >= NAMED {
            draw_text(ui, node, head, zoom, [ink(paint.text), ink(paint.weak)], state, total);
        }
        self.draw_keys(ui, state, node, seen);
    }

    /// Draws the error badge for a fault in this node or above it; clicking it goes to the node at fault.
    fn fault_ui(&self, plan: &Plan, ui: &Ui, state: &State, index: usize, actions: &mut Vec<Action>) {
        let Some(fault) = plan.faults.get(&index) else { return };
        let name = &plan.sheet.nodes[index].name;
        let own = fault.culprit == *name;
        let zoom = self.view.zoom;
        let seen = self.view.area(plan.boxes[index]);
        let at = seen.left_top() + vec2(0.0, HEAD * zoom / 2.0);
        let place = Rect::from_center_size(at, vec2(18.0, 18.0));
        let response = ui.interact(place, ui.id().with(("fault", name)), Sense::click());
        response.widget_info(|| {
            let what = if own { "Error in" } else { "Error above" };
            WidgetInfo::labeled(WidgetType::Button, true, format!("{what} {name}"))
        });
        let color = if own { theme::error(ui.visuals()) } else { Color32::from_rgb(0xe0, 0x92, 0x3c) };
        badge(ui, at, own, color, if response.hovered() { 1.25 * zoom } else { zoom });
        if response.clicked() {
            actions.push(Action::Visit(state.whole_name(&fault.culprit)));
        }
        let text = match own {
            true => fault.text.clone(),
            false => format!("{}: {}\n\nClick to go to that node.", fault.culprit, fault.text),
        };
        response.on_hover_text(text).on_hover_cursor(egui::CursorIcon::PointingHand);
    }

    /// Draws the number keys that show a node, and the outline of the viewed node.
    fn draw_keys(&self, ui: &Ui, state: &State, node: &Node, seen: Rect) {
        let zoom = self.view.zoom;
        let whole = state.whole_name(&node.name);
        let looked = state.look.node.as_ref().is_some_and(|(name, _)| *name == whole);
        let is_it = |name: &Option<String>| name.as_deref() == Some(whole.as_str());
        let slots: Vec<usize> =
            state.look.slots.iter().enumerate().filter(|(_, name)| is_it(name)).map(|(i, _)| i + 1).collect();
        let gold = Color32::from_rgb(0xf2, 0xc1, 0x4e);
        if looked {
            ui.painter().rect_stroke(
                seen.expand(2.5),
                7.0 * zoom.min(1.5),
                Stroke::new(1.5, gold),
                StrokeKind::Outside,
            );
        }
        if zoom < 0.3 {
            return;
        }
        for (nth, slot) in slots.iter().enumerate() {
            let size = (15.0 * zoom).clamp(12.0, 20.0);
            // Beside the node, because pins stand on its top edge.
            let at = seen.right_top() + vec2(size * 0.75, size * (nth as f32 * 1.15 + 0.5));
            let place = Rect::from_center_size(at, vec2(size, size));
            let (fill, text) =
                if looked { (gold, Color32::BLACK) } else { (Color32::from_gray(0x58), Color32::from_gray(0xe8)) };
            ui.painter().rect_filled(place, 3.0, fill);
            ui.painter().text(at, Align2::CENTER_CENTER, slot, FontId::proportional(size * 0.75), text);
        }
    }

    fn draw_picture(&mut self, ui: &Ui, state: &State, name: &str, place: Rect, dim: bool) {
        let round = ((5.0 * self.view.zoom).clamp(1.0, 12.0) - 1.0) as u8;
        let round = CornerRadius { nw: 0, ne: 0, sw: round, se: round };
        let place = place.shrink(1.0_f32.min(self.view.zoom));
        let bare = if ui.visuals().dark_mode { Color32::from_gray(0x2a) } else { Color32::from_gray(0xe4) };
        let Some(texture) = self.pictures.of(ui.ctx(), state, name) else {
            ui.painter().rect_filled(place, round, bare);
            return;
        };
        // Crops to the middle part with the aspect ratio of the place.
        let size = texture.size_vec2();
        let share = (place.size() / size).max_elem();
        let part = place.size() / (size * share);
        let uv = Rect::from_center_size(pos2(0.5, 0.5), part);
        let tint = if dim { Color32::from_gray(0x58) } else { Color32::WHITE };
        ui.painter().add(RectShape::filled(place, round, tint).with_texture(texture.id(), uv));
    }
}

/// Returns the selection after a click on a node.
fn picked(ui: &Ui, state: &State, name: &str) -> BTreeSet<String> {
    let modifiers = ui.input(|input| input.modifiers);
    let mut names = state.selection.clone();
    if modifiers.command && names.remove(name) {
        return names;
    }
    if !(modifiers.shift || modifiers.command) {
        names.clear();
    }
    names.insert(name.into());
    names
}

fn draw_text(ui: &Ui, node: &Node, head: Rect, zoom: f32, colors: [Color32; 2], state: &State, total: f64) {
    let painter = ui.painter();
    // Rounded to half points, so that zooming does not rasterize glyphs at every size.
    let size = |points: f32| FontId::proportional((points * zoom * 2.0).round() / 2.0);
    let left = head.left() + (10.0 * zoom).max(4.0);
    let width = head.right() - (6.0 * zoom).max(1.0) - left;
    let elided = |text: &str, format: TextFormat, width: f32| {
        let mut job = LayoutJob::single_section(text.into(), format);
        job.wrap = TextWrapping { max_width: width, max_rows: 1, break_anywhere: true, ..TextWrapping::default() };
        painter.layout_job(job)
    };
    let strike = if node.disabled { Stroke::new(1.2, colors[0]) } else { Stroke::NONE };
    let name =
        TextFormat { strikethrough: strike, ..TextFormat::simple(size(12.5_f32.max(LEGIBLE / zoom)), colors[0]) };
    let text = elided(node.called(), name, width);
    // Two lines of legible text do not fit into a small head.
    let is_small = zoom < 0.65;
    // Below the pins, which reach into the head; centered if the name stands alone.
    let top = match is_small {
        true => head.center().y - text.size().y / 2.0,
        false => head.top() + 6.0 * zoom,
    };
    painter.galley(pos2(left, top), text, colors[0]);
    if is_small {
        return;
    }
    let line = pos2(left, head.top() + 20.5 * zoom);
    let about = size(10.0_f32.max(LEGIBLE / zoom));
    let mut width = width;
    let seconds = state.report(node).map_or(0.0, |node| node.seconds);
    if total > 0.0 && seconds > COSTLY * total {
        let text = format::seconds(seconds);
        let at = pos2(head.right() - 6.0 * zoom, line.y);
        let place = painter.text(at, Align2::RIGHT_TOP, text, about.clone(), colors[0]);
        width -= place.width() + 4.0 * zoom;
    }
    let text = elided(&node.ty, TextFormat::simple(about, colors[1]), width.max(1.0));
    painter.galley(line, text, colors[1]);
}

/// Draws a small round badge: `!` for a fault here, an arrow for one above.
fn badge(ui: &Ui, at: Pos2, own: bool, color: Color32, zoom: f32) {
    let radius = (8.0 * zoom).clamp(5.0, 10.0);
    let painter = ui.painter();
    painter.circle_filled(at, radius, color);
    if own {
        painter.text(at, Align2::CENTER_CENTER, "!", FontId::proportional(radius * 1.5), Color32::WHITE);
    } else {
        let line = Stroke::new(radius * 0.2, Color32::WHITE);
        let [tip, foot] = [-0.55, 0.55].map(|y| at + vec2(0.0, y * radius));
        painter.line_segment([tip, foot], line);
        for side in [-0.42, 0.42] {
            painter.line_segment([tip, tip + vec2(side, 0.45) * radius], line);
        }
    }
}

/// Draws the tooltip of a node.
fn about_ui(plan: &Plan, ui: &mut Ui, state: &State, index: usize, total: f64) {
    ui.set_max_width(320.0);
    let node = &plan.sheet.nodes[index];
    ui.label(RichText::new(format!("{} — {}", node.called(), node.ty)).strong());
    match (node.declaration, node.side) {
        (Some(known), _) => ui.label(known.summary),
        (None, Some(Side::Input)) => ui.label("An input of the group: what a use connects here."),
        (None, Some(Side::Output)) => ui.label("An output of the group: what its uses make."),
        (None, None) => ui.colored_label(theme::error(ui.visuals()), format!("Unknown node type \"{}\".", node.ty)),
    };
    if node.is_use {
        ui.weak("Double-click to enter the group.");
    }
    if let Some(seen) = state.report(node) {
        match &seen.state {
            Fate::Evaluated => {
                let share = if total > 0.0 { 100.0 * seen.seconds / total } else { 0.0 };
                let about = if seen.estimated { "about " } else { "" };
                ui.weak(format!("Evaluated in {about}{} ({share:.1} %)", format::seconds(seen.seconds)));
            }
            Fate::Cached => drop(ui.weak("Reused from the cache")),
            Fate::LeftOut(why) => drop(ui.weak(format!("Left out: {why}"))),
        }
    } else if node.disabled {
        ui.weak("Disabled");
    }
    if plan.idle.contains(&index) {
        ui.weak("Not rendered: no output needs it. Drop a wire from it on an output's mark, or choose Make output.");
    }
    if let Some(fault) = plan.faults.get(&index) {
        let color = theme::error(ui.visuals());
        let text =
            if fault.culprit == node.name { fault.text.clone() } else { format!("{}: {}", fault.culprit, fault.text) };
        ui.colored_label(color, text);
    }
    let notes = plan.sheet.get(&crate::document::Path::node(&node.name).to("notes")).and_then(|notes| notes.as_str());
    if let Some(notes) = notes {
        ui.label(RichText::new(notes).italics());
    }
}
