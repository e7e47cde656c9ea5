//! Overview map in the corner of the canvas, shown while part of the graph is out of view. Over nodes it is faint.

use super::Canvas;
use super::plan::Plan;
use super::wire::faded;
use crate::theme;
use egui::{Color32, Pos2, Rect, Sense, Stroke, StrokeKind, Ui, WidgetInfo, WidgetType, pos2, vec2};

/// Maximum width and height.
const SIZE: [f32; 2] = [150.0, 120.0];
/// Distance from the edges of the panel.
const MARGIN: f32 = 10.0;
/// Width of the strip at the right that has room for the map.
pub(super) const STRIP: f32 = SIZE[0] + 2.0 * MARGIN;
/// Opacity of the map where it lies over nodes and the pointer is elsewhere.
const FAINT: f32 = 0.3;

impl Canvas {
    /// Returns the place of the overview map on the screen, if it is shown.
    pub(super) fn map_place(&self, plan: &Plan) -> Option<Rect> {
        let seen = self.view.seen();
        let room = self.view.rect.size();
        let is_needed = plan.bounds.is_finite() && !seen.expand(50.0 / self.view.zoom).contains_rect(plan.bounds);
        if !is_needed || room.x < 420.0 || room.y < 260.0 {
            return None;
        }
        let all = mapped(plan, seen);
        let corner = self.view.rect.max - vec2(MARGIN, MARGIN);
        Some(Rect::from_min_max(corner - all.size() * scale(all), corner))
    }

    /// Draws the overview map; pressing on it centers the view there.
    pub(super) fn minimap_ui(&mut self, plan: &Plan, ui: &Ui) {
        let Some(place) = self.map_place(plan) else { return };
        let seen = self.view.seen();
        let all = mapped(plan, seen);
        let scale = scale(all);
        let small = |at: Pos2| place.min + (at - all.min) * scale;
        let area = |area: Rect| Rect::from_min_max(small(area.min), small(area.max));
        let mut painter = ui.painter().with_clip_rect(place.expand(1.0));
        let below = Rect::from_min_max(self.view.canvas(place.min), self.view.canvas(place.max));
        if plan.boxes.iter().any(|own| own.intersects(below)) && !ui.rect_contains_pointer(place) {
            painter.set_opacity(FAINT * painter.opacity());
        }
        let dark = ui.visuals().dark_mode;
        let ground = if dark { Color32::from_gray(0x18) } else { Color32::from_gray(0xf4) };
        painter.rect_filled(place, 4.0, ground.gamma_multiply(0.93));
        for body in plan.sheet.backdrops.values() {
            let [r, g, b] = theme::TINTS[body.tint % theme::TINTS.len()];
            let tint = Color32::from_rgb(r, g, b).gamma_multiply(0.5);
            painter.rect_filled(area(super::backdrop::area(body)), 1.0, tint);
        }
        for (node, own) in plan.sheet.nodes.iter().zip(&plan.boxes) {
            let kind = theme::kind(node.makes.first().and_then(|(_, kind)| *kind));
            let least = area(*own);
            let least = Rect::from_center_size(least.center(), least.size().max(vec2(2.0, 2.0)));
            painter.rect_filled(least, 0.0, faded(kind, ground, 0.35));
        }
        let line = ui.visuals().strong_text_color().gamma_multiply(0.7);
        painter.rect_stroke(area(seen).intersect(place), 1.0, Stroke::new(1.0, line), StrokeKind::Inside);
        let edge = ui.visuals().widgets.noninteractive.bg_stroke;
        painter.rect_stroke(place, 4.0, edge, StrokeKind::Inside);
        let response = ui.interact(place, ui.id().with("minimap"), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, "Map of the graph"));
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.is_pointer_button_down_on()) {
            let on = (at - place.min) / scale;
            self.view.center(pos2(all.left() + on.x, all.top() + on.y));
        }
    }
}

/// Returns the part of the canvas that the map shows.
fn mapped(plan: &Plan, seen: Rect) -> Rect {
    plan.bounds.union(seen).expand(20.0)
}

/// Returns the scale at which the map shows a part of the canvas.
fn scale(all: Rect) -> f32 {
    (SIZE[0] / all.width()).min(SIZE[1] / all.height())
}
