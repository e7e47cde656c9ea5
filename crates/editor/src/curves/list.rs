//! The list of keyed values beside the curves, with a tick for each, grouped by what they belong to.

use super::{COLORS, Curves, components, is_color, is_drawn, whole};
use crate::document::keyed::Channel;
use egui::{Checkbox, Label, Response, RichText, ScrollArea, Sense, TextStyle, Ui, WidgetInfo, WidgetType, vec2};

/// Indentation of the values of an owner, in points.
const INDENT: f32 = 14.0;

/// Draws the list.
pub(super) fn list_ui(panel: &mut Curves, ui: &mut Ui, channels: &[Channel]) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let mut color = 0;
        for own in channels.chunk_by(|a, b| a.owner == b.owner) {
            owner_ui(panel, ui, own);
            for channel in own {
                channel_ui(panel, ui, channel, color);
                color += if is_color(channel) { 0 } else { components(channel) };
            }
        }
    });
}

/// Draws the line of what has some values: its tick is for all of them.
fn owner_ui(panel: &mut Curves, ui: &mut Ui, own: &[Channel]) {
    let owner = &own[0].owner;
    let ticked = own.iter().filter(|channel| is_drawn(channel) && panel.is_ticked(channel)).count();
    let count = own.iter().filter(|channel| is_drawn(channel)).count();
    ui.horizontal(|ui| {
        let mut on = count > 0 && ticked == count;
        let tick = Checkbox::new(&mut on, "").indeterminate(ticked > 0 && ticked < count);
        let tick = ui.add_enabled(count > 0, tick);
        let name = format!("Curves of {owner}");
        tick.widget_info(|| WidgetInfo::selected(WidgetType::Checkbox, count > 0, on, &name));
        if tick.changed() {
            own.iter().filter(|channel| is_drawn(channel)).for_each(|channel| panel.tick(channel, on));
        }
        let label = name_ui(ui, owner, true).on_hover_text(format!("{owner}\nClick to pick all its keys."));
        if label.clicked() {
            pick(panel, own.iter());
        }
    });
}

/// Draws the line of a value. `color` is the number of its first curve.
fn channel_ui(panel: &mut Curves, ui: &mut Ui, channel: &Channel, color: usize) {
    let is_drawn = is_drawn(channel);
    ui.horizontal(|ui| {
        ui.add_space(INDENT);
        let name = format!("{}.{}", channel.owner, channel.name);
        let mut on = is_drawn && panel.is_ticked(channel);
        let tick = ui.add_enabled(is_drawn, Checkbox::new(&mut on, ""));
        tick.widget_info(|| WidgetInfo::selected(WidgetType::Checkbox, is_drawn, on, &name));
        if tick.changed() {
            panel.tick(channel, on);
        }
        for component in 0..components(channel) {
            let (dot, _) = ui.allocate_exact_size(vec2(6.0, 6.0), Sense::hover());
            ui.painter().circle_filled(dot.center(), 3.0, ink(ui, channel, color, component));
        }
        let help = match (is_drawn, is_color(channel)) {
            (true, false) => "Click to pick all its keys.",
            (true, true) => {
                "Red, green and blue. Click to pick all its keys; Properties and the palette set the color."
            }
            (false, _) => "Its keys have names or words: they are in the dope sheet.",
        };
        if name_ui(ui, &channel.name, false).on_hover_text(format!("{name}\n{help}")).clicked() {
            pick(panel, std::iter::once(channel));
        }
    });
}

/// Ticks values, and picks all their keys.
fn pick<'c>(panel: &mut Curves, channels: impl Iterator<Item = &'c Channel>) {
    let drawn: Vec<&Channel> = channels.filter(|channel| is_drawn(channel)).collect();
    drawn.iter().for_each(|channel| panel.tick(channel, true));
    let keys =
        |channel: &&Channel| channel.curve.keys.iter().flat_map(|key| whole(channel, key.frame)).collect::<Vec<_>>();
    panel.picks = drawn.iter().flat_map(keys).collect();
}

/// Returns the color of a curve of a value; those of colors are red, green and blue.
pub(super) fn ink(ui: &Ui, channel: &Channel, color: usize, component: usize) -> egui::Color32 {
    let index = if is_color(channel) { component } else { color + component };
    crate::theme::line(COLORS[index % COLORS.len()], ui.visuals())
}

/// Draws a name. One that is too long loses its start: names differ at their ends.
fn name_ui(ui: &mut Ui, name: &str, is_strong: bool) -> Response {
    let font = TextStyle::Body.resolve(ui.style());
    let room = ui.available_width();
    let width = |text: String| ui.painter().layout_no_wrap(text, font.clone(), egui::Color32::WHITE).size().x;
    let mut text = name.to_string();
    let mut rest = name.char_indices().skip(1).map(|(at, _)| &name[at..]);
    while width(text.clone()) > room
        && let Some(end) = rest.next()
    {
        text = format!("…{end}");
    }
    let text = if is_strong { RichText::new(text).strong() } else { RichText::new(text) };
    let label = ui.add(Label::new(text).extend().sense(Sense::click()));
    label.widget_info(|| WidgetInfo::labeled(WidgetType::Label, true, name));
    label
}
