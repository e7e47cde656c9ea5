//! Marks of outputs: arrows out of the graph, with the outputs' names.

use super::Canvas;
use super::backdrop::Subject;
use super::drag::Gesture;
use super::menu::MenuTarget;
use super::node::LEGIBLE;
use super::pin::SHOWN;
use super::plan::{End, Plan};
use crate::actions::Action;
use crate::document::output;
use crate::state::State;
use egui::{Align2, Color32, CursorIcon, FontId, PointerButton, Pos2, Rect, Sense, Shape, Stroke, StrokeKind, Ui};
use egui::{WidgetInfo, WidgetType, vec2};
use std::collections::BTreeSet;

/// Distance that marks extend below their node, on the canvas.
pub(super) const REACH: f32 = 34.0;

impl Canvas {
    /// Draws the marks of a node's outputs and handles their input.
    pub(super) fn marks_ui(&mut self, plan: &Plan, ui: &Ui, state: &State, node: usize, actions: &mut Vec<Action>) {
        let zoom = self.view.zoom;
        let Some(names) = plan.makes.get(&node).filter(|_| zoom >= SHOWN) else { return };
        let tip = self.view.area(plan.boxes[node]).center_bottom() + vec2(0.0, 16.0 * zoom);
        let color = ui.visuals().text_color();
        let arrow = [vec2(-5.0, -7.0), vec2(5.0, -7.0), vec2(0.0, 0.0)].map(|corner| tip + corner * zoom);
        ui.painter().add(Shape::convex_polygon(arrow.to_vec(), color, Stroke::NONE));
        let last = names.len() - 1;
        let texts: Vec<_> = names
            .iter()
            .enumerate()
            .map(|(nth, name)| {
                let text = if nth < last { format!("{name}, ") } else { name.clone() };
                ui.painter().layout_no_wrap(text, FontId::proportional((11.0 * zoom).max(LEGIBLE)), color)
            })
            .collect();
        let width: f32 = texts.iter().map(|text| text.size().x).sum();
        let mut left = tip.x - width / 2.0;
        for (name, text) in names.iter().zip(texts) {
            let size = text.size();
            let own = Rect::from_min_size(egui::pos2(left, tip.y + 2.0 * zoom), size);
            left += size.x;
            // With a single output, the arrow is part of its clickable area.
            let place = if last == 0 { own.union(Rect::from_points(&arrow)) } else { own };
            let response = ui.interact(place, ui.id().with(("output", name)), Sense::click_and_drag());
            let chosen = state.output.as_ref() == Some(name);
            response.widget_info(|| WidgetInfo::selected(WidgetType::Button, true, chosen, format!("Output {name}")));
            let aimed = matches!(&self.gesture, Gesture::Pull(pull) if pull.mark.as_ref() == Some(name));
            if chosen || aimed || response.hovered() {
                let strength = if chosen || aimed { 0.8 } else { 0.35 };
                ui.painter().rect_filled(own.expand(2.0), 3.0, ui.visuals().selection.bg_fill.gamma_multiply(strength));
            }
            ui.painter().galley(own.min, text, color);
            self.marks.push((name.clone(), place.expand(4.0)));
            if response.clicked() {
                actions.extend([Action::Select(BTreeSet::new()), Action::Output(Some(name.clone()))]);
            }
            if response.double_clicked() {
                look(plan, name, actions);
            }
            if response.secondary_clicked() {
                self.open_menu(ui, MenuTarget::Output(name.clone()));
            }
            if response.drag_started_by(PointerButton::Primary) && matches!(self.gesture, Gesture::Idle) {
                self.gesture = Gesture::Output(name.clone());
            }
            if response.hovered() && self.explains() {
                let file = plan.sheet.get(&output::path(name).to("file")).and_then(|file| file.as_str());
                let file = file.map_or_else(|| "no file".to_string(), |file| format!("to {file}"));
                response.on_hover_cursor(CursorIcon::PointingHand).on_hover_text(format!(
                    "Output {name}, {file}\nClick: show settings. Double-click: view. Drag to another node, or drop \
                     a wire here to render something else."
                ));
            }
        }
    }

    /// Returns the output whose mark is at a place on the screen.
    pub(super) fn mark_at(&self, at: Pos2) -> Option<&String> {
        self.marks.iter().find(|(_, place)| place.contains(at)).map(|(name, _)| name)
    }

    /// Returns the result that an output would render if dropped at a place on the screen: the nearby output pin, or
    /// the node's first result that a file can hold.
    pub(super) fn source_at(&self, plan: &Plan, at: Pos2) -> Option<(usize, usize)> {
        let at = self.view.canvas(at);
        match plan.end_at(at, 11.0 / self.view.zoom.min(1.5)) {
            Some(End::Output(node, output)) => Some((node, output)),
            _ => {
                let node = plan.node_at(at)?;
                Some((node, output::renderable(&plan.sheet, node).unwrap_or(0)))
            }
        }
    }

    /// Redirects an output to another result, or notifies the user why it cannot.
    pub(super) fn redirect(plan: &Plan, name: &str, from: (usize, usize), actions: &mut Vec<Action>) {
        let known = output::find(&plan.sheet, name);
        if known.is_some_and(|known| plan.sheet.source(&known.source) == Some(from)) {
            return;
        }
        match output::redirected(&plan.sheet, name, from) {
            Some(edit) => actions.extend([Action::Edit(edit), Action::Seal]),
            None => actions.push(Action::Notice(output::unfit(&plan.sheet, from))),
        }
    }

    /// Draws the line of an output that is being dragged.
    pub(super) fn led_ui(&self, plan: &Plan, ui: &Ui, name: &str) {
        let place = self.marks.iter().find(|(mark, _)| mark == name).map(|(_, place)| *place);
        let (Some(place), Some(at)) = (place, ui.input(|input| input.pointer.latest_pos())) else { return };
        let color = ui.visuals().strong_text_color();
        ui.painter().line_segment([place.center_top(), at], Stroke::new(2.0, color));
        ui.painter().text(at + vec2(10.0, 4.0), Align2::LEFT_TOP, name, FontId::proportional(12.0), color);
        if let Some((node, _)) = self.source_at(plan, at) {
            let area = self.view.area(plan.boxes[node]).expand(3.0);
            ui.painter().rect_stroke(
                area,
                6.0,
                Stroke::new(2.0, Color32::from_rgb(0xf2, 0xc1, 0x4e)),
                StrokeKind::Outside,
            );
        }
    }

    pub(super) fn output_menu(&mut self, plan: &Plan, ui: &mut Ui, name: &str, actions: &mut Vec<Action>) {
        if ui.button("View").clicked() {
            look(plan, name, actions);
        }
        if ui.button("Settings").clicked() {
            actions.extend([Action::Select(BTreeSet::new()), Action::Output(Some(name.into()))]);
        }
        if ui.button("Rename …").clicked() {
            self.write(Subject::Output(name.into()), name, true);
        }
        if ui.button("Remove output").clicked() {
            actions.extend([Action::Edit(output::removed(name)), Action::Seal]);
        }
    }
}

/// Views the result that an output renders.
fn look(plan: &Plan, name: &str, actions: &mut Vec<Action>) {
    let known = output::find(&plan.sheet, name);
    if let Some((node, index)) = known.and_then(|output| plan.sheet.source(&output.source)) {
        // Outputs are at the top of the document, where names are whole.
        actions.push(Action::Look(plan.sheet.nodes[node].name.clone(), index));
    }
}
