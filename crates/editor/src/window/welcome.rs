//! The welcome: a new document, recent ones, and the scenes that are templates.

use crate::actions::Action;
use crate::prompts::Prompt;
use crate::welcome::templates::Template;
use crate::welcome::{Choice, Seen, Welcome};
use egui::{
    Align, Align2, ColorImage, Context, CursorIcon, FontId, Key, Layout, Modal, Rect, Response, RichText, ScrollArea,
    Sense, Stroke, StrokeKind, TextStyle, TextureId, TextureOptions, Ui, Vec2, WidgetInfo, WidgetType, vec2,
};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Width of the list of documents, and size of a picture, in points; in large windows they grow.
const LEFT: f32 = 250.0;
const PICTURE: Vec2 = vec2(176.0, 99.0);
/// All of a texture.
const WHOLE: Rect = Rect { min: egui::pos2(0.0, 0.0), max: egui::pos2(1.0, 1.0) };
/// Least size of the welcome where the window has room for it, in points; in large windows it covers three quarters.
const LEAST: Vec2 = vec2(900.0, 520.0);

/// Sizes of its parts in a window.
#[derive(Clone, Copy)]
struct Sizes {
    left: f32,
    picture: Vec2,
    right: f32,
    height: f32,
}

impl Sizes {
    fn new(window: Vec2, scenes: usize) -> Self {
        let room = window - vec2(80.0, 120.0);
        let [width, height] = (0.75 * room).max(LEAST).min(room).into();
        let grown = (width / LEAST.x).clamp(1.0, 2.0);
        let (left, picture) = (LEFT * grown.min(1.3), PICTURE * grown);
        let columns = ((width - left - 30.0) / (picture.x + 10.0)).floor().max(1.0);
        // No higher than the scenes need.
        let rows = (scenes as f32 / columns).ceil();
        let height = height.min((rows * (picture.y + 28.0) + 30.0).max(LEAST.y));
        Self { left, picture, right: columns * (picture.x + 10.0) + 14.0, height }
    }
}

/// Draws the welcome, and does what is chosen.
pub(super) fn welcome_ui(context: &Context, mut shown: Welcome, actions: &mut Vec<Action>) -> Option<Prompt> {
    for (key, towards) in
        [(Key::ArrowLeft, -Vec2::X), (Key::ArrowRight, Vec2::X), (Key::ArrowUp, -Vec2::Y), (Key::ArrowDown, Vec2::Y)]
    {
        if context.input_mut(|input| input.consume_key(egui::Modifiers::NONE, key)) {
            shown.step(towards);
        }
    }
    let moved = context.input(|input| input.events.iter().any(|event| matches!(event, egui::Event::Key { .. })));
    let mut taken = None;
    let scenes = shown.choices.iter().filter(|choice| matches!(choice, Choice::Template(_))).count();
    let sizes = Sizes::new(context.content_rect().size(), scenes);
    let Sizes { left, right, height, .. } = sizes;
    let modal = Modal::new("welcome".into()).show(context, |ui| {
        ui.set_width(left + 18.0 + right);
        ui.label(RichText::new("Trochoid").heading());
        ui.add_space(6.0);
        let mut places = vec![Rect::NOTHING; shown.choices.len()];
        ui.horizontal_top(|ui| {
            ui.allocate_ui_with_layout(vec2(left, height), Layout::top_down(Align::Min), |ui| {
                ui.set_width(left);
                list_ui(ui, &mut shown, sizes, &mut places, &mut taken, actions);
            });
            ui.add_space(8.0);
            ui.allocate_ui_with_layout(vec2(right, height), Layout::top_down(Align::Min), |ui| {
                ui.set_width(right);
                ui.strong("Begin with a scene");
                ui.add_space(4.0);
                let area = ScrollArea::vertical().id_salt("templates").max_height(height - 30.0).auto_shrink(false);
                area.show(ui, |ui| templates_ui(ui, &mut shown, (sizes.picture, moved), &mut places, &mut taken));
            });
        });
        shown.places = places;
        ui.separator();
        ui.weak("Arrow keys and Enter choose; Esc closes this window.");
    });
    if context.input(|input| input.key_pressed(Key::Enter)) {
        taken = taken.or(Some(shown.chosen));
    }
    if let Some(index) = taken {
        actions.push(match &shown.choices[index] {
            Choice::New => Action::New,
            Choice::Open => Action::Open,
            Choice::Recent(file) => Action::OpenFile(file.clone()),
            Choice::Template(scene) => Action::Template(scene.name),
        });
        return None;
    }
    (!modal.should_close()).then_some(Prompt::Welcome(shown))
}

/// Draws what begins without a template, and the recent documents.
fn list_ui(
    ui: &mut Ui,
    shown: &mut Welcome,
    sizes: Sizes,
    places: &mut [Rect],
    taken: &mut Option<usize>,
    actions: &mut Vec<Action>,
) {
    let chosen = shown.chosen;
    let mut row = |ui: &mut Ui, index: usize, name: &str, told: &str, picture: Option<(TextureId, Vec2)>| {
        let response = row_ui(ui, name, told, index == chosen, picture);
        places[index] = response.rect;
        if response.clicked() {
            *taken = Some(index);
        }
        response
    };
    row(ui, 0, "New", "A sea to start from", None);
    row(ui, 1, "Open …", "A document on disk", None);
    ui.add_space(8.0);
    ui.strong("Recent documents");
    ui.add_space(4.0);
    let area = ScrollArea::vertical().id_salt("recent").max_height(sizes.height - 150.0).auto_shrink(false);
    area.show(ui, |ui| {
        let recent = shown.choices.iter().enumerate().filter_map(|(index, choice)| match choice {
            Choice::Recent(file) => Some((index, file.as_path())),
            _ => None,
        });
        for (index, file) in recent {
            let picture = seen(ui, &mut shown.seen, file);
            row(ui, index, &name(file), &folder(file), picture).on_hover_text(file.display().to_string());
        }
        let mut forgotten = None;
        for (index, file) in shown.gone.iter().enumerate() {
            ui.horizontal(|ui| {
                let text = RichText::new(format!("{} is gone", name(file))).weak().italics();
                let room = vec2(sizes.left - 80.0, ui.spacing().interact_size.y);
                let label = ui.allocate_ui_with_layout(room, Layout::left_to_right(Align::Center), |ui| {
                    ui.set_min_width(room.x);
                    ui.add_space(8.0);
                    ui.add(egui::Label::new(text).truncate())
                });
                let label = label.inner;
                label.on_hover_text(file.display().to_string());
                let remove = ui.small_button("Remove").on_hover_text("Remove it from this list");
                remove.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Remove {}", name(file))));
                if remove.clicked() {
                    forgotten = Some(index);
                }
            });
        }
        if let Some(index) = forgotten {
            actions.push(Action::ForgetRecent(shown.gone.remove(index)));
        }
        if shown.gone.is_empty() && !shown.choices.iter().any(|choice| matches!(choice, Choice::Recent(_))) {
            ui.weak("None so far.");
        }
    });
}

/// Returns the texture of a recent document's picture and its size, uploading it when it is first drawn.
fn seen(ui: &Ui, all: &mut HashMap<PathBuf, Seen>, file: &Path) -> Option<(TextureId, Vec2)> {
    let seen = all.get_mut(file)?;
    if let Seen::Read(screen) = seen {
        let picture = ColorImage::from_rgba_unmultiplied(screen.size, &screen.pixels);
        let name = file.display().to_string();
        *seen = Seen::Shown(ui.ctx().load_texture(name, picture, TextureOptions::LINEAR));
    }
    match seen {
        Seen::Shown(texture) => Some((texture.id(), texture.size_vec2())),
        Seen::Read(_) => None,
    }
}

/// Draws a row with a name, and a line about it.
fn row_ui(ui: &mut Ui, name: &str, told: &str, chosen: bool, picture: Option<(TextureId, Vec2)>) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 38.0), Sense::click());
    response.widget_info(|| WidgetInfo::selected(WidgetType::Button, true, chosen, name));
    mark(ui, rect, chosen, &response);
    let left = match picture {
        Some((texture, size)) => {
            let room = Rect::from_min_size(rect.min + vec2(4.0, 2.0), vec2(60.0, 34.0));
            let place = Rect::from_center_size(room.center(), size * (room.size() / size).min_elem());
            ui.painter().image(texture, place, WHOLE, egui::Color32::WHITE);
            72.0
        }
        None => 8.0,
    };
    let visuals = ui.visuals();
    let [color, weak] = match chosen {
        true => [visuals.selection.stroke.color; 2],
        false => [visuals.text_color(), visuals.weak_text_color()],
    };
    for (text, style, color, above) in [(name, TextStyle::Body, color, 3.0), (told, TextStyle::Small, weak, 21.0)] {
        let text = egui::WidgetText::from(text);
        let galley = text.into_galley(ui, Some(egui::TextWrapMode::Truncate), rect.width() - left - 8.0, style);
        ui.painter().galley(rect.min + vec2(left, above), galley, color);
    }
    response.on_hover_cursor(CursorIcon::PointingHand)
}

/// Draws the pictures of the templates.
fn templates_ui(
    ui: &mut Ui,
    shown: &mut Welcome,
    (size, moved): (Vec2, bool),
    places: &mut [Rect],
    taken: &mut Option<usize>,
) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(10.0, 8.0);
        for (index, place) in places.iter_mut().enumerate() {
            let Choice::Template(scene) = shown.choices[index] else { continue };
            let (rect, response) = ui.allocate_exact_size(size + vec2(0.0, 20.0), Sense::click());
            let chosen = index == shown.chosen;
            response.widget_info(|| WidgetInfo::selected(WidgetType::Button, true, chosen, scene.name));
            *place = rect;
            if chosen && moved {
                response.scroll_to_me(None);
            }
            if ui.is_rect_visible(rect) {
                let picture = Rect::from_min_size(rect.min, size);
                if let Some(texture) = picture_of(ui, shown, scene) {
                    ui.painter().image(texture, picture.shrink(2.0), WHOLE, egui::Color32::WHITE);
                }
                mark_edge(ui, picture, chosen, &response);
                let font = FontId::new(TextStyle::Small.resolve(ui.style()).size + 1.0, egui::FontFamily::Proportional);
                let at = picture.left_bottom() + vec2(4.0, 3.0);
                ui.painter().text(at, Align2::LEFT_TOP, scene.name, font, ui.visuals().text_color());
            }
            if response.on_hover_cursor(CursorIcon::PointingHand).clicked() {
                *taken = Some(index);
            }
        }
    });
}

fn mark(ui: &Ui, rect: Rect, chosen: bool, response: &Response) {
    let visuals = ui.visuals();
    if chosen {
        ui.painter().rect_filled(rect, 4.0, visuals.selection.bg_fill);
    } else if response.hovered() {
        ui.painter().rect_filled(rect, 4.0, visuals.widgets.hovered.weak_bg_fill);
    }
}

fn mark_edge(ui: &Ui, rect: Rect, chosen: bool, response: &Response) {
    let visuals = ui.visuals();
    let stroke = match (chosen, response.hovered()) {
        (true, _) => Stroke::new(2.5, visuals.selection.stroke.color),
        (_, true) => Stroke::new(1.5, visuals.widgets.hovered.fg_stroke.color),
        _ => Stroke::new(1.0, visuals.widgets.noninteractive.bg_stroke.color),
    };
    ui.painter().rect_stroke(rect.shrink(1.0), 3.0, stroke, StrokeKind::Inside);
}

/// Returns the texture of a template's picture, uploading it when it is first drawn.
fn picture_of(ui: &Ui, shown: &mut Welcome, scene: &'static Template) -> Option<TextureId> {
    if !shown.pictures.contains_key(scene.file) {
        let picture = image::load_from_memory(scene.picture).ok()?.to_rgb8();
        let size = [picture.width() as usize, picture.height() as usize];
        let texture = ColorImage::from_rgb(size, picture.as_raw());
        shown.pictures.insert(scene.file, ui.ctx().load_texture(scene.file, texture, TextureOptions::LINEAR));
    }
    shown.pictures.get(scene.file).map(egui::TextureHandle::id)
}

fn name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn folder(file: &Path) -> String {
    file.parent().unwrap_or(file).display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_welcome_fills_large_windows_and_fits_small_ones() {
        for (window, columns) in
            [([700.0, 500.0], 1.0), ([1280.0, 800.0], 3.0), ([1920.0, 1080.0], 3.0), ([2560.0, 1440.0], 4.0)]
        {
            let sizes = Sizes::new(window.into(), 15);
            assert_eq!(((sizes.right - 14.0) / (sizes.picture.x + 10.0)).round(), columns, "{window:?}");
            assert!(sizes.left + 18.0 + sizes.right <= window[0] - 60.0, "{window:?}");
            assert!(sizes.height <= window[1] - 120.0, "{window:?}");
        }
        assert_eq!(Sizes::new(vec2(1280.0, 800.0), 15).picture, PICTURE);
        let large = Sizes::new(vec2(2560.0, 1440.0), 15);
        assert!(large.height > 900.0 && large.left + large.right > 1500.0);
    }
}
