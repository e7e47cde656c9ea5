//! The popup below a field that explains why its value was refused; it does not affect the layout. Only one is shown at
//! a time.

use egui::{Area, Context, Id, Key, Order, Rect, Response, RichText, Ui, pos2, vec2};
use std::fmt::Display;

/// The refusal shown, and its field.
#[derive(Clone)]
struct Refusal {
    field: Id,
    why: String,
    /// Pass in which the value was refused.
    pass: u64,
}

/// Maximum width of the popup, in points.
const WIDTH: f32 = 280.0;

fn known(context: &Context) -> Option<Refusal> {
    context.data(|data| data.get_temp(Id::NULL))
}

/// Shows why a field's value is refused, replacing any earlier refusal.
pub(crate) fn refuse(context: &Context, field: Id, why: &dyn Display) {
    let why = why.to_string();
    let pass = context.cumulative_pass_nr();
    context.data_mut(|data| data.insert_temp(Id::NULL, Refusal { field, why, pass }));
    context.request_repaint();
}

/// Removes the refusal, because the typed value is no longer relevant.
pub(crate) fn forget(context: &Context) {
    context.data_mut(|data| data.remove::<Refusal>(Id::NULL));
}

/// Returns whether a value was refused in this pass or the previous one.
pub(crate) fn is_fresh(context: &Context) -> bool {
    known(context).is_some_and(|refusal| refusal.pass + 1 >= context.cumulative_pass_nr())
}

/// Returns whether a refusal is shown for a field.
pub(crate) fn stands(context: &Context, field: Id) -> bool {
    known(context).is_some_and(|refusal| refusal.field == field)
}

/// Draws the refusal of a field, until the field is used again or Esc is pressed.
pub(crate) fn refusal_ui(ui: &Ui, field: &Response) {
    let Some(Refusal { why, .. }) = known(ui.ctx()).filter(|refusal| refusal.field == field.id) else { return };
    let again = field.gained_focus() || field.drag_started() || (field.changed() && field.has_focus());
    if again || ui.input(|input| input.key_pressed(Key::Escape)) {
        return forget(ui.ctx());
    }
    if !ui.is_rect_visible(field.rect) {
        return;
    }
    let frame = egui::Frame::popup(ui.style());
    let margin = frame.total_margin().sum();
    // Inside its panel, unless the panel is a strip such as the timeline, which is too small.
    let seen = ui.clip_rect();
    let room = if seen.height() < 120.0 { ui.ctx().content_rect() } else { seen };
    let width = (room.width() - margin.x).clamp(40.0, WIDTH);
    let text = RichText::new(&why).color(crate::theme::error(ui.visuals()));
    let font = egui::TextStyle::Body.resolve(ui.style());
    let lines = ui.painter().layout(why.clone(), font, ui.visuals().text_color(), width);
    let size = lines.size() + margin;
    let below = Rect::from_min_size(field.rect.left_bottom() + vec2(0.0, 3.0), size);
    let top = match below.bottom() <= room.bottom() {
        true => below.top(),
        false => field.rect.top() - 3.0 - size.y,
    };
    let left = below.left().min(room.right() - size.x).max(room.left());
    let area = Area::new(field.id.with("refusal")).order(Order::Foreground).interactable(false);
    area.fixed_pos(pos2(left, top)).constrain_to(room).show(ui.ctx(), |ui| {
        frame.show(ui, |ui| {
            ui.set_max_width(width);
            ui.add(egui::Label::new(text).wrap());
        });
    });
}

/// A text as a message quotes it: not all of a long one.
pub(crate) fn quoted(text: &str) -> String {
    let text = text.trim();
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("\"{} …\"", &text[..end]),
        None => format!("\"{text}\""),
    }
}
