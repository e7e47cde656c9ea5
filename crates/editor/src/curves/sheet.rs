//! The dope sheet: a row for each keyed value, below the rows of what has them and of all, with a diamond for each key.

use super::view::{RULER, Screen};
use super::{Curves, Picked, Spot, whole};
use crate::document::keyed::{Channel, frames};
use egui::{Align, FontId, Id, Label, Painter, Rect, RichText, Sense, Stroke, Ui, UiBuilder, Vec2, pos2, vec2};

/// Height of a row, in points.
const ROW: f32 = 20.0;

/// A row: its title, how far it is indented, and the values whose keys it shows.
struct Row<'c> {
    title: &'c str,
    depth: usize,
    channels: &'c [Channel],
}

/// Returns the rows of the sheet. Values of one owner stand beside each other.
fn rows(channels: &[Channel]) -> Vec<Row<'_>> {
    let mut rows = vec![Row { title: "All keys", depth: 0, channels }];
    for own in channels.chunk_by(|a, b| a.owner == b.owner) {
        rows.push(Row { title: &own[0].owner, depth: 1, channels: own });
        rows.extend(own.chunks(1).map(|one| Row { title: &one[0].name, depth: 2, channels: one }));
    }
    rows
}

/// Returns the picks of the keys of a row at a frame.
fn picks(channels: &[Channel], frame: f64) -> Vec<Picked> {
    channels.iter().flat_map(|channel| whole(channel, frame)).collect()
}

/// Draws the rows, and returns the marks of keys.
pub(super) fn sheet_ui(
    panel: &mut Curves,
    ui: &mut Ui,
    painter: &Painter,
    screen: &Screen,
    body: Rect,
    channels: &[Channel],
) -> Vec<Spot> {
    let rows = rows(channels);
    let titles =
        Rect::from_min_max(pos2(body.left(), screen.rect.top()), pos2(screen.rect.left() - 4.0, body.bottom()));
    let most = (rows.len() as f32 * ROW - screen.rect.height()).max(0.0);
    if ui.rect_contains_pointer(titles) {
        panel.scrolled -= ui.input(|input| input.smooth_scroll_delta().y);
    }
    panel.scrolled = panel.scrolled.clamp(0.0, most);
    let mut spots = Vec::new();
    let mut painted = painter.with_clip_rect(Rect::from_min_max(titles.min, screen.rect.max));
    painted.set_clip_rect(painted.clip_rect().intersect(body));
    for (index, row) in rows.iter().enumerate() {
        let top = screen.rect.top() + index as f32 * ROW - panel.scrolled;
        let line = Rect::from_min_max(pos2(titles.left(), top), pos2(screen.rect.right(), top + ROW));
        // Half a row is not a target.
        let is_seen = line.center().y > screen.rect.top() && line.center().y < screen.rect.bottom();
        if !is_seen {
            continue;
        }
        if row.depth < 2 {
            painted.rect_filled(line, 0.0, ui.visuals().faint_bg_color);
        }
        let edge = Stroke::new(1.0, ui.visuals().weak_text_color().gamma_multiply(0.2));
        painted.line_segment([line.left_bottom(), line.right_bottom()], edge);
        title_ui(panel, ui, row, index, Rect::from_min_max(line.min, pos2(titles.right(), line.bottom())));
        for frame in frames(row.channels) {
            let place = pos2(screen.x(frame), line.center().y);
            let picks = picks(row.channels, frame);
            if screen.rect.expand2(Vec2::new(6.0, 0.0)).contains(place) {
                spots.push(Spot { picks, place, is_sum: row.depth < 2 });
            }
        }
    }
    let corner = Rect::from_min_size(body.min, vec2(titles.width(), RULER));
    painter.text(
        corner.left_center(),
        egui::Align2::LEFT_CENTER,
        "Keys of",
        FontId::proportional(11.0),
        ui.visuals().weak_text_color(),
    );
    spots
}

/// Draws the title of a row: a click picks all its keys.
fn title_ui(panel: &mut Curves, ui: &mut Ui, row: &Row<'_>, index: usize, rect: Rect) {
    let indented = rect.with_min_x(rect.left() + 4.0 + 12.0 * row.depth as f32);
    let text = RichText::new(row.title);
    let text = if row.depth < 2 { text.strong() } else { text };
    let layout = egui::Layout::left_to_right(Align::Center);
    let builder = UiBuilder::new().max_rect(indented).layout(layout).id(Id::new(("row of keys", index)));
    let label = ui.scope_builder(builder, |ui| ui.add(Label::new(text).truncate().sense(Sense::click()))).inner;
    if label.on_hover_text("Click to pick all keys of this row").clicked() {
        let adds = ui.input(|input| input.modifiers.shift || input.modifiers.command);
        let all = frames(row.channels).into_iter().flat_map(|frame| picks(row.channels, frame));
        if !adds {
            panel.picks.clear();
        }
        for picked in all {
            if !panel.picks.contains(&picked) {
                panel.picks.push(picked);
            }
        }
    }
}

impl Curves {
    /// Returns the values of the row at a place.
    pub(super) fn row_at<'c>(&self, channels: &'c [Channel], screen: &Screen, y: f32) -> &'c [Channel] {
        let index = ((y - screen.rect.top() + self.scrolled) / ROW).floor();
        let rows = rows(channels);
        if index < 0.0 { &[] } else { rows.get(index as usize).map_or(&[][..], |row| row.channels) }
    }
}
