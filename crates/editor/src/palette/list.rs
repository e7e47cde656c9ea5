//! The list of colors: a row for each, with its share of the picture.

use super::recolor;
use crate::actions::Action;
use crate::document::spoken;
use crate::document::swatches::{self, Swatch, SwatchKey};
use crate::evaluate::blame;
use crate::picker;
use crate::state::State;
use egui::{Align2, Color32, FontId, Rect, Sense, Stroke, StrokeKind, Ui, WidgetInfo, WidgetType, pos2, vec2};
use trochoid::oklab;

/// Order of the colors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Sort {
    /// As in the document.
    #[default]
    Document,
    Name,
    Lightness,
    Share,
}

impl Sort {
    pub(super) const ALL: [Self; 4] = [Self::Document, Self::Name, Self::Lightness, Self::Share];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Document => "As written",
            Self::Name => "By name",
            Self::Lightness => "By lightness",
            Self::Share => "By share",
        }
    }
}

/// Height of a row, and width of a swatch, in points.
const ROW: f32 = 26.0;
const SWATCH: f32 = 40.0;
/// Weight of a color in a pixel below which its row is not marked.
const LEAST: f64 = 5e-4;

/// A color with its share of the picture, and its weight in the pixel under the pointer or the inspected one.
struct Row<'s> {
    swatch: &'s Swatch,
    share: Option<f64>,
    weight: Option<f64>,
}

/// Draws the rows: named colors first.
pub(super) fn list_ui(ui: &mut Ui, state: &State, all: &[Swatch], sort: Sort, actions: &mut Vec<Action>) {
    let mut rows = rows(state, all);
    let is_literal = |row: &Row<'_>| matches!(row.swatch.key, SwatchKey::Literal(_));
    match sort {
        Sort::Document => {}
        Sort::Name => rows.sort_by_key(|row| row.swatch.called()),
        Sort::Lightness => {
            let lightness = |row: &Row<'_>| row.swatch.color.map_or(2.0, |color| oklab(color.map(f64::from))[0]);
            rows.sort_by(|a, b| lightness(a).total_cmp(&lightness(b)));
        }
        Sort::Share => rows.sort_by(|a, b| b.share.unwrap_or(-1.0).total_cmp(&a.share.unwrap_or(-1.0))),
    }
    rows.sort_by_key(is_literal);
    let most = rows.iter().filter_map(|row| row.share).fold(1e-3, f64::max);
    ui.spacing_mut().item_spacing.y = 1.0;
    let first = rows.iter().position(is_literal);
    for (index, row) in rows.iter().enumerate() {
        if Some(index) == first {
            ui.add_space(4.0);
            ui.weak("Without a name");
        }
        row_ui(ui, state, row, most, actions);
    }
    if rows.is_empty() {
        ui.weak("The document has no colors yet.");
    }
}

/// Finds what is known of each color.
fn rows<'s>(state: &State, all: &'s [Swatch]) -> Vec<Row<'s>> {
    let place = state.colors.hover.or(state.look.pick).zip(state.evaluated.shown());
    let pixel = place.map(|(at, result)| blame::pixel(at, [result.format.width(), result.format.height()]));
    let known = state.evaluated.mixture.as_deref().map(|mixture| mixture.weights(pixel)).unwrap_or_default();
    let row = |swatch: &'s Swatch| {
        let controls = swatch.controls();
        let own: Vec<[f64; 2]> = controls.iter().filter_map(|name| known.get(name.as_str()).copied()).collect();
        let sum = |index: usize| own.iter().map(|weights| weights[index]).sum::<f64>();
        let weight = Some(sum(1)).filter(|weight| pixel.is_some() && *weight >= LEAST);
        Row { swatch, share: (!own.is_empty()).then(|| sum(0)), weight }
    };
    all.iter().map(row).collect()
}

fn row_ui(ui: &mut Ui, state: &State, row: &Row<'_>, most: f64, actions: &mut Vec<Action>) {
    let swatch = row.swatch;
    let called = swatch.called();
    let is_chosen = state.colors.chosen.as_ref() == Some(&swatch.key);
    let (area, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    response.widget_info(|| WidgetInfo::selected(WidgetType::Button, true, is_chosen, format!("Color {called}")));
    let square = Rect::from_min_size(area.min + vec2(4.0, 3.0), vec2(SWATCH, ROW - 7.0));
    let id = ui.id().with(("swatch", &swatch.key));
    let handle = ui.interact(square, id, Sense::click_and_drag());
    handle.widget_info(|| WidgetInfo::labeled(WidgetType::ColorButton, true, format!("Swatch {called}")));
    let visuals = ui.visuals();
    let painter = ui.painter();
    if is_chosen {
        painter.rect_filled(area, 3.0, visuals.selection.bg_fill.gamma_multiply(0.55));
    } else if response.hovered() || handle.hovered() {
        painter.rect_filled(area, 3.0, visuals.faint_bg_color);
    }
    let tint = state.colors.tint.as_ref().filter(|tint| tint.controls == swatch.controls());
    let color = tint.map(|tint| tint.color).or(swatch.color);
    square_ui(ui, square, color);
    let start = square.right() + 8.0;
    labels_ui(ui, area, start, row);
    bars_ui(ui, area, start, row, most);
    let help = help(row);
    let clicked = response.clicked() || handle.clicked();
    // Colors without a name are in the document, wherever those with one are.
    let file = swatches::file(state.sheet()).filter(|_| matches!(swatch.key, SwatchKey::Named(_)));
    match (file, swatch.color) {
        (Some(file), _) if handle.drag_started() => {
            let text = format!("{called} is a color of {file}: bring the palette into the document to change it.");
            actions.push(Action::Notice(text));
        }
        (None, Some(color)) => {
            let picked = picker::swatch_drag(ui, ui.id().with(("drag", &swatch.key)), color, &handle);
            picked.into_iter().for_each(|picked| recolor(picked, state, swatch, actions));
        }
        _ => {}
    }
    if clicked {
        actions.push(Action::Swatch((!is_chosen).then(|| swatch.key.clone())));
    } else if handle.drag_started() && !is_chosen {
        // The tracks show the color that one drags.
        actions.push(Action::Swatch(Some(swatch.key.clone())));
    }
    handle.on_hover_text(format!(
        "{help}\n\nDrag up for more lightness, sideways for another hue, with Shift for chroma"
    ));
    response.on_hover_text(help);
}

/// Draws the name of a color and its numbers.
fn labels_ui(ui: &Ui, area: Rect, start: f32, row: &Row<'_>) {
    let (swatch, visuals, painter) = (row.swatch, ui.visuals(), ui.painter());
    let text = visuals.text_color();
    let weak = visuals.weak_text_color();
    let numbers = area.right() - 6.0;
    let share = row.share.map_or_else(|| "–".into(), crate::format::percent);
    painter.text(pos2(numbers, area.center().y - 1.0), Align2::RIGHT_CENTER, share, FontId::monospace(11.5), text);
    // The weight in a pixel takes the place of the number of uses.
    let (count, ink) = match row.weight {
        Some(weight) => (crate::format::percent(weight), visuals.hyperlink_color),
        None => (format!("×{}", swatch.count()), weak),
    };
    let at = pos2(numbers - 58.0, area.center().y - 1.0);
    painter.text(at, Align2::RIGHT_CENTER, count, FontId::proportional(11.0), ink);
    let name =
        painter.with_clip_rect(Rect::from_min_max(pos2(start, area.top()), pos2(numbers - 100.0, area.bottom())));
    let at = pos2(start, area.center().y - 1.0);
    let drawn = name.text(at, Align2::LEFT_CENTER, swatch.called(), FontId::proportional(13.0), text);
    let more = match &swatch.key {
        SwatchKey::Named(_) if swatch.is_keyed() => "keyed".into(),
        SwatchKey::Named(_) => String::new(),
        SwatchKey::Literal(_) => swatch.uses.first().map(spoken).unwrap_or_default(),
    };
    name.text(pos2(drawn.right() + 8.0, at.y), Align2::LEFT_CENTER, more, FontId::proportional(11.0), weak);
}

/// Draws a color, or a cross if it is not known.
fn square_ui(ui: &Ui, square: Rect, color: Option<[f32; 3]>) {
    let painter = ui.painter();
    let rim = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    match color {
        Some(color) => {
            let [r, g, b] = color.map(|channel| (255.0 * channel).round() as u8);
            painter.rect_filled(square, 3.0, Color32::from_rgb(r, g, b));
        }
        None => {
            painter.line_segment([square.left_bottom(), square.right_top()], rim);
        }
    }
    painter.rect_stroke(square, 3.0, rim, StrokeKind::Inside);
}

/// Draws the share of the picture as a bar, and the weight in the inspected pixel over it.
fn bars_ui(ui: &Ui, area: Rect, start: f32, row: &Row<'_>, most: f64) {
    let room = area.right() - 6.0 - start;
    let bar = |share: f64, top: f32, height: f32, color: Color32| {
        let width = (room * share.clamp(0.0, 1.0) as f32).max(1.0);
        ui.painter().rect_filled(Rect::from_min_size(pos2(start, top), vec2(width, height)), 1.0, color);
    };
    if let Some(share) = row.share {
        bar(share / most, area.bottom() - 3.0, 2.0, ui.visuals().weak_text_color().gamma_multiply(0.6));
    }
    if let Some(weight) = row.weight {
        let accent = ui.visuals().hyperlink_color;
        bar(weight, area.bottom() - 4.0, 3.0, accent);
        let edge = Rect::from_min_size(area.min, vec2(2.5, area.height()));
        ui.painter().rect_filled(edge, 1.0, accent);
    }
}

fn help(row: &Row<'_>) -> String {
    let swatch = row.swatch;
    let mut lines = vec![swatch.called()];
    if let Some(color) = swatch.color.filter(|_| matches!(swatch.key, SwatchKey::Named(_))) {
        lines.push(crate::document::color::hex(color));
    }
    if swatch.is_keyed() {
        lines.push("Keyed over frames; this is the color at the current one".into());
    }
    match row.share {
        Some(share) => lines.push(format!("{} of the picture", crate::format::percent(share))),
        None => lines.push("Share of the picture: not known".into()),
    }
    if let Some(weight) = row.weight {
        lines.push(format!("{} of the pixel", crate::format::percent(weight)));
    }
    let mut nodes = swatch.nodes();
    nodes.extend(swatch.around());
    match nodes.len() {
        0 => lines.push("Nothing uses it".into()),
        count if count <= 6 => lines.push(format!("Used by {}", nodes.join(", "))),
        count => lines.push(format!("Used by {} and {} more", nodes[..5].join(", "), count - 5)),
    }
    lines.join("\n")
}
