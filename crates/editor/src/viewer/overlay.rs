//! The box of the inspector over the picture, at the side where the inspected pixel is not.

use egui::{Pos2, Rect, Sense, Shape, Stroke, StrokeKind, Ui, UiBuilder, vec2};

/// Width of the box, if there is room.
const WIDTH: f32 = 208.0;
/// Distance of the box from the edges of the picture's panel, and of the pixel's mark from the box.
const APART: f32 = 6.0;
const MARK: f32 = 14.0;

/// The box as it was drawn last.
#[derive(Default)]
pub(super) struct Overlay {
    is_left: bool,
    height: f32,
}

impl Overlay {
    /// Draws the box. `spot` is the place of the pixel on the screen.
    pub(super) fn ui(&mut self, ui: &mut Ui, area: Rect, spot: Pos2, content: impl FnOnce(&mut Ui)) {
        let room = area.shrink(APART);
        let size = vec2(WIDTH.min(0.45 * room.width()), room.height());
        let side = |is_left: bool| {
            let corner = if is_left { room.left_top() } else { room.right_top() - vec2(size.x, 0.0) };
            Rect::from_min_size(corner, size)
        };
        // It does not leap away under a pointer that is pressed.
        if side(self.is_left).expand(MARK).contains(spot) && !ui.input(|input| input.pointer.any_down()) {
            self.is_left = !self.is_left;
        }
        let whole = side(self.is_left);
        let back = ui.painter().with_clip_rect(area).add(Shape::Noop);
        // What lies under it is neither clicked nor zoomed.
        let taken = whole.with_max_y((whole.top() + self.height).min(whole.bottom()));
        ui.interact(taken, ui.id().with("inspector"), Sense::click_and_drag());
        let inner = whole.shrink2(vec2(8.0, 4.0));
        let drawn = ui.scope_builder(UiBuilder::new().max_rect(inner).id_salt("inspector"), |ui| {
            ui.set_clip_rect(whole.intersect(ui.clip_rect()));
            ui.set_width(inner.width());
            content(ui);
        });
        self.height = (drawn.response.rect.height() + 8.0).min(whole.height());
        let drawn = whole.with_max_y(whole.top() + self.height);
        let visuals = ui.visuals();
        let rim = Stroke::new(1.0, visuals.window_stroke.color);
        let shapes = vec![
            Shape::rect_filled(drawn, 4.0, visuals.panel_fill.gamma_multiply(0.94)),
            Shape::Rect(egui::epaint::RectShape::stroke(drawn, 4.0, rim, StrokeKind::Inside)),
        ];
        ui.painter().set(back, Shape::Vec(shapes));
    }
}
