//! The search in the document.

use crate::actions::Action;
use crate::choice::moved;
use crate::document::find::{Entry, matching};
use crate::prompts::{Prompt, Search};
use crate::theme;
use egui::{Align, Color32, Context, Key, Layout, Modal, Rect, RichText, ScrollArea, Sense, TextEdit, TextStyle, Ui};
use egui::{WidgetInfo, WidgetType, vec2};
use trochoid::Kind;

/// Width of the list, in points.
const WIDTH: f32 = 560.0;
/// Height of the list, in points.
const HEIGHT: f32 = 380.0;
/// Width of the words that say what something is.
const KINDS: f32 = 74.0;

/// Draws the search, and goes to what is chosen.
pub(super) fn find_ui(context: &Context, mut search: Search, actions: &mut Vec<Action>) -> Option<Prompt> {
    let mut taken = None;
    let modal = Modal::new("find".into()).show(context, |ui| {
        ui.set_width(WIDTH.min(context.content_rect().width() - 60.0));
        // Read the arrow keys before the text field sees them.
        search.chosen = moved(ui, search.chosen, search.found.len());
        let hint = "Find nodes, knobs, colors, notes …";
        let field = ui.add(TextEdit::singleline(&mut search.text).hint_text(hint).desired_width(f32::INFINITY));
        field.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Find"));
        let enter = ui.input(|input| input.key_pressed(Key::Enter));
        field.request_focus();
        if field.changed() {
            search.found = matching(&search.entries, &search.text);
            search.chosen = 0;
        }
        taken = list_ui(ui, &search, field.changed());
        ui.separator();
        ui.label(RichText::new(told(&search)).weak());
        if enter {
            taken = search.found.get(search.chosen).copied();
        }
    });
    if let Some(index) = taken {
        actions.push(Action::GoTo(search.entries.swap_remove(index).target));
        return None;
    }
    (!modal.should_close()).then_some(Prompt::Find(search))
}

/// Returns the line below the list.
fn told(search: &Search) -> String {
    match search.found.len() {
        0 => "Nothing matches. Nodes are found by name or type, knobs by name or value, colors by name or #rrggbb, notes by \
              their text."
            .into(),
        count => format!("{count} found. Enter goes to the marked one."),
    }
}

/// Draws the part of the list that is seen; returns the index of the entry that was clicked.
fn list_ui(ui: &mut Ui, search: &Search, is_new: bool) -> Option<usize> {
    let mut taken = None;
    let height = ui.spacing().interact_size.y;
    let moves = is_new || ui.input(|input| input.key_pressed(Key::ArrowDown) || input.key_pressed(Key::ArrowUp));
    let mut area = ScrollArea::vertical().max_height(HEIGHT).min_scrolled_height(HEIGHT).auto_shrink(false);
    if moves {
        let row = height + ui.spacing().item_spacing.y;
        // The marked row stays in the middle, as far as there are rows.
        area = area.vertical_scroll_offset((search.chosen as f32 * row - (HEIGHT - row) / 2.0).max(0.0));
    }
    area.show_rows(ui, height, search.found.len(), |ui, seen| {
        for place in seen {
            let index = search.found[place];
            if row_ui(ui, &search.entries[index], place == search.chosen) {
                taken = Some(index);
            }
        }
    });
    taken
}

/// Draws a row; returns whether it was clicked.
fn row_ui(ui: &mut Ui, entry: &Entry, chosen: bool) -> bool {
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let kind = entry.target.kind();
    let called = format!("{kind} {}, {}", entry.name, entry.detail);
    response.widget_info(|| WidgetInfo::selected(WidgetType::Button, true, chosen, called.clone()));
    let visuals = ui.visuals();
    if chosen {
        ui.painter().rect_filled(rect, 3.0, visuals.selection.bg_fill);
    } else if response.hovered() {
        ui.painter().rect_filled(rect, 3.0, visuals.widgets.hovered.weak_bg_fill);
    }
    let mut words = ui.new_child(egui::UiBuilder::new().max_rect(rect.shrink2(vec2(6.0, 0.0))).layout(row()));
    let weak = words.visuals().weak_text_color();
    words.allocate_ui_with_layout(vec2(KINDS, rect.height()), row(), |ui| {
        ui.set_min_width(KINDS);
        still(ui, RichText::new(kind).color(weak));
    });
    if let Some(color) = entry.color {
        let [r, g, b] = color.map(|channel| (255.0 * channel).round() as u8);
        let (spot, _) = words.allocate_exact_size(vec2(12.0, 12.0), Sense::hover());
        words.painter().rect_filled(
            Rect::from_center_size(spot.center(), vec2(12.0, 12.0)),
            2.0,
            Color32::from_rgb(r, g, b),
        );
    } else {
        let dot = if kind == "Node" { theme::kind(node_kind(entry)) } else { Color32::TRANSPARENT };
        let (spot, _) = words.allocate_exact_size(vec2(12.0, 12.0), Sense::hover());
        words.painter().circle_filled(spot.center(), 3.5, dot);
    }
    still(&mut words, RichText::new(&entry.name));
    still(&mut words, RichText::new(&entry.detail).color(weak));
    response.on_hover_text_at_pointer(called).clicked()
}

fn row() -> Layout {
    Layout::left_to_right(Align::Center)
}

/// Draws a text that takes no clicks and is cut off at the end of its row.
fn still(ui: &mut Ui, text: RichText) {
    ui.add(egui::Label::new(text.text_style(TextStyle::Body)).selectable(false).truncate());
}

/// Returns the kind that a node of the type makes.
fn node_kind(entry: &Entry) -> Option<Kind> {
    Some(trochoid::registry().get(&entry.detail)?.declaration().outputs.first()?.kind)
}
