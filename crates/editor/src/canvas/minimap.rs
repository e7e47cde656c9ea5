//! Overview map in the corner of the canvas, shown while part of the graph is out of view.

use super::Canvas;
use super::plan::Plan;
use super::wire::faded;
use crate::theme;
use egui::{Color32, Pos2, Rect, Sense, Stroke, StrokeKind, Ui, WidgetInfo, WidgetType, pos2, vec2};

/// Maximum width and height.
const SIZE: [f32; 2] = [150.0, 120.0];

impl Canvas {
    /// Draws the overview map; pressing on it centers the view there.
    pub(super) fn minimap_ui(&mut self, plan: &Plan, ui: &Ui) {
        let seen = self.view.seen();
        let room = self.view.rect.size();
        if !plan.bounds.is_finite()
            || seen.expand(50.0 / self.view.zoom).contains_rect(plan.bounds)
            || room.x < 420.0
            || room.y < 260.0
        {
            return;
        }
        let all = plan.bounds.union(seen).expand(20.0);
        let scale = (SIZE[0] / all.width()).min(SIZE[1] / all.height());
        let place = Rect::from_min_max(
            self.view.rect.max - all.size() * scale - vec2(10.0, 10.0),
            self.view.rect.max - vec2(10.0, 10.0),
        );
        let small = |at: Pos2| place.min + (at - all.min) * scale;
        let area = |area: Rect| Rect::from_min_max(small(area.min), small(area.max));
        let painter = ui.painter().with_clip_rect(place.expand(1.0));
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
