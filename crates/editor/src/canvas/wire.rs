//! Drawing of wires, their accessible names, and their dots.

use super::Canvas;
use super::curve::{Curve, WireShape};
use super::drag::Gesture;
use super::plan::{End, Plan};
use crate::actions::Action;
use crate::document::{Node, Point, Wire, decor};
use crate::state::State;
use crate::theme;
use egui::{Color32, PointerButton, Rect, Sense, Shape, Stroke, Ui, WidgetInfo, WidgetType, vec2};
use trochoid::State as Fate;

/// Distance at which the pointer picks a wire, in screen points.
pub(super) const REACH: f32 = 6.0;
/// Radius of a dot.
const DOT: f32 = 4.5;

impl Canvas {
    /// Returns the wire under the pointer.
    pub(super) fn wire_hovered(&self, plan: &Plan, ui: &Ui, background: bool) -> Option<usize> {
        let at = ui.input(|input| input.pointer.hover_pos()).filter(|_| background)?;
        matches!(self.gesture, Gesture::Idle)
            .then(|| plan.nearest_wire(self.view.canvas(at), REACH / self.view.zoom))?
    }

    /// Draws all wires.
    pub(super) fn wires_ui(&self, plan: &Plan, ui: &Ui, state: &State, hovered: Option<usize>) {
        let seen = self.view.seen();
        let (taken, into) = match &self.gesture {
            Gesture::Pull(pull) => (pull.old.and_then(|old| plan.wire_at(old)), None),
            Gesture::Move(held) => (None, held.into),
            _ => (None, None),
        };
        let width = (1.7 * self.view.zoom).clamp(1.0, 3.0);
        let labels = self.view.zoom > 0.3;
        let ground = ui.visuals().panel_fill;
        for (index, curve) in plan.curves.iter().enumerate() {
            if !curve.bounds.expand(4.0).intersects(seen) {
                continue;
            }
            let wire = &plan.sheet.wires[index];
            let ends = [wire.from.0, wire.to.0].map(|node| &plan.sheet.nodes[node]);
            let names = ends.map(|node| node.name.as_str());
            let chosen = names.iter().any(|name| state.selection.contains(*name));
            // Blended with the background instead of transparent, so that overlapping wires look like one.
            let mut color = theme::kind(plan.sheet.kind(wire));
            let muted = |color: Color32, share: f32| faded(color, ground, share);
            let mut width = width;
            if taken == Some(index) {
                color = muted(color, 0.8);
            } else if hovered == Some(index) || into == Some(index) {
                color = color.lerp_to_gamma(ui.visuals().strong_text_color(), 0.35);
                width += 1.5;
            } else if left_out(state, ends[0]) || left_out(state, ends[1]) {
                color = muted(color, 0.75);
            } else if !chosen {
                color = muted(color, if ui.visuals().dark_mode { 0.34 } else { 0.08 });
            }
            self.draw(ui, curve, Stroke::new(width, color));
            if labels {
                // An area for the accessible name only; the pointer picks a wire by its curve.
                let place = Rect::from_center_size(self.view.screen(curve.middle()), vec2(8.0, 8.0));
                let (from, pin) =
                    (plan.sheet.reference(wire.from.0, wire.from.1), &plan.sheet.nodes[wire.to.0].pins[wire.to.1]);
                let response = ui.interact(place, ui.id().with(("wire", wire)), Sense::hover());
                response.widget_info(|| {
                    WidgetInfo::labeled(
                        WidgetType::Other,
                        true,
                        format!("Wire from {from} to {} {}", ends[1].called(), pin.label),
                    )
                });
            }
        }
    }

    /// Draws the visible part of a curve with no more points than can be told apart.
    fn draw(&self, ui: &Ui, curve: &Curve, stroke: Stroke) {
        for line in curve.seen(&self.view) {
            ui.painter().add(Shape::line(line, stroke));
        }
    }

    /// Draws the dots of wires and handles their input.
    pub(super) fn dots_ui(&mut self, plan: &Plan, ui: &Ui, actions: &mut Vec<Action>) {
        for wire in 0..plan.dots.len() {
            let Wire { to, .. } = plan.sheet.wires[wire];
            for (index, dot) in plan.dots[wire].iter().enumerate() {
                let at = self.view.screen(*dot);
                if !self.view.rect.expand(10.0).contains(at) {
                    continue;
                }
                let radius = (DOT * self.view.zoom).max(2.5);
                let place = Rect::from_center_size(at, vec2(1.0, 1.0) * (2.0 * radius + 6.0));
                let id = ui.id().with(("dot", to, index));
                let response = ui.interact(place, id, Sense::click_and_drag());
                let key = || decor::key(&plan.sheet, to);
                response.widget_info(|| {
                    WidgetInfo::labeled(WidgetType::Button, true, format!("Dot {} of {}", index + 1, key()))
                });
                let color = theme::kind(plan.sheet.kind(&plan.sheet.wires[wire]));
                let ring = if response.hovered() { ui.visuals().strong_text_color() } else { ui.visuals().window_fill };
                ui.painter().circle(at, radius, color, Stroke::new(1.5, ring));
                if response.drag_started_by(PointerButton::Primary) && matches!(self.gesture, Gesture::Idle) {
                    self.gesture = Gesture::Dot(wire, index, plan.dots[wire].clone());
                }
                if response.double_clicked() {
                    let mut dots: Vec<Point> = plan.dots[wire].iter().map(|at| (*at).into()).collect();
                    dots.remove(index);
                    actions.extend([Action::Edit(decor::dotted(&plan.sheet, to, &dots)), Action::Seal]);
                } else if response.hovered() {
                    response.on_hover_text("Drag to move. Double-click to remove.");
                }
            }
        }
    }

    /// Draws the wire that is being connected.
    pub(super) fn pull_ui(&self, plan: &Plan, ui: &Ui) {
        let Gesture::Pull(pull) = &self.gesture else { return };
        let Some(at) = ui.input(|input| input.pointer.latest_pos()) else { return };
        let loose = pull.target.map_or(self.view.canvas(at), |target| plan.end(target));
        let held = plan.end(pull.held);
        let points = if matches!(pull.held, End::Output(..)) { [held, loose] } else { [loose, held] };
        let fits = pull.target.is_none_or(|target| super::connect::fits(&plan.sheet, pull.held, target, &pull.barred));
        let color = match (fits, pull.held) {
            (false, _) => theme::error(ui.visuals()),
            (true, End::Output(node, output)) => theme::kind(super::connect::kind(&plan.sheet, (node, output))),
            (true, End::Pin(node, pin)) => theme::accepts(plan.sheet.nodes[node].pins[pin].accepts),
        };
        self.draw(ui, &Curve::new(&points, WireShape::Down), Stroke::new(2.5, color));
        if let Some(target) = pull.target {
            ui.painter().circle_stroke(self.view.screen(plan.end(target)), 8.0, Stroke::new(2.0, color));
        }
    }
}

/// Returns whether the last evaluation left a node out.
pub(super) fn left_out(state: &State, node: &Node) -> bool {
    state.report(node).is_some_and(|node| matches!(node.state, Fate::LeftOut(_)))
}

/// Blends a color with its background by a share.
pub(super) fn faded(color: Color32, behind: Color32, share: f32) -> Color32 {
    color.lerp_to_gamma(behind, share)
}
