//! Color fields: swatch, text, dropper, and a reference painting to pick colors from.

use super::context::{Properties, WidgetContext};
use crate::actions::{Action, Pane, Tint};
use crate::document::color::{hex, is_name, rgb};
use crate::document::link;
use crate::document::swatches::{SwatchKey, space};
use crate::document::{Edit, spoken};
use crate::evaluate::Screen;
use crate::field::{self, FieldResponse, Gesture};
use crate::picker::{self, Picked};
use crate::state::State;
use egui::{
    Button, Color32, ColorImage, Popup, PopupCloseBehavior, Sense, TextEdit, TextureOptions, Ui, WidgetInfo,
    WidgetType, vec2,
};
use egui_file_dialog::{DialogState, Filter};
use serde_json::{Value, json};

/// Returns a document color as sRGB values from 0 to 1. Number triples are in the working space.
pub(super) fn display(value: &Value, state: &State) -> Option<[f32; 3]> {
    let space = space(state.sheet());
    match value {
        Value::String(text) if is_name(text) => state.sheet().named(text),
        Value::String(text) => rgb(text),
        Value::Array(items) => match items.as_slice() {
            [r, g, b] => {
                let color = [r.as_f64()?, g.as_f64()?, b.as_f64()?];
                Some(space.to_display(color).map(|value| value.clamp(0.0, 1.0) as f32))
            }
            _ => None,
        },
        _ => None,
    }
}

/// Draws a color field: a swatch that opens a picker, the color's text, and the dropper.
pub(super) fn color_ui(
    ui: &mut Ui,
    value: &Value,
    place: &WidgetContext<'_>,
    actions: &mut Vec<Action>,
) -> FieldResponse<Value> {
    let swatch = swatch_ui(ui, value, place, 36.0, actions);
    let written = match value {
        Value::String(text) => text.clone(),
        other => crate::document::change::style(other),
    };
    let salt = place.path.to_string();
    // The dropper and the key button follow; names and triples are longer than #rrggbb.
    let width = (ui.available_size_before_wrap().x - 84.0).clamp(72.0, 180.0);
    let text = field::draft_ui(ui, &salt, &written, read_color, |text| {
        TextEdit::singleline(text).desired_width(width).font(egui::TextStyle::Monospace)
    });
    let given = swatch.given.or(text.given);
    let response = field::joined(swatch.response, text.response);
    // One place takes the color that is picked.
    if !place.also.is_empty() {
        return FieldResponse { response, given };
    }
    let mut taking = place.state.dropper.as_ref() == Some(&place.path);
    let dropper = ui.toggle_value(&mut taking, "Pick");
    if dropper.on_hover_text("Pick the next color clicked in the picture or the reference painting").clicked() {
        actions.push(Action::Dropper(taking.then(|| place.path.clone())));
    }
    FieldResponse { response, given }
}

/// Draws the color as a button that opens a picker, with the document's other colors. The color of a name is changed in
/// the palette, for all its uses. `width` is that of the button, in points.
pub(super) fn swatch_ui(
    ui: &mut Ui,
    value: &Value,
    place: &WidgetContext<'_>,
    width: f32,
    actions: &mut Vec<Action>,
) -> FieldResponse<Value> {
    let state = place.state;
    let controls: Vec<String> = place.places().map(spoken).collect();
    let tint = state.colors.tint.as_ref().filter(|tint| tint.controls == controls);
    let shown = tint.map(|tint| tint.color).or_else(|| display(value, state)).unwrap_or_default();
    // A color picked here would be a color without the name.
    let name = value.as_str().filter(|text| is_name(text)).and_then(|text| text.strip_prefix("palette."));
    let [r, g, b] = shown.map(|channel| (255.0 * channel).round() as u8);
    let button = Button::new("").fill(Color32::from_rgb(r, g, b)).min_size(vec2(width, ui.spacing().interact_size.y));
    let button = ui.add(button);
    button.widget_info(|| WidgetInfo::labeled(WidgetType::ColorButton, true, format!("Swatch of {}", controls[0])));
    if let Some(name) = name {
        if button.clicked() {
            actions.extend([Action::Panel(Pane::Palette), Action::Swatch(Some(SwatchKey::Named(name.into())))]);
        }
        let button = button.on_hover_text(format!("Show {name} in the palette, where it is changed for all its uses"));
        return FieldResponse::nothing(button);
    }
    let is_keyed = place.value.is_some_and(|value| value.get("keys").is_some());
    let mut given = None;
    let popup = Popup::from_toggle_button_response(&button).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    popup.width(280.0).show(|ui| {
        actions.push(Action::Weigh);
        let others = state.swatches().into_iter().filter_map(|other| Some((other.called(), other.color?)));
        let others: Vec<(String, [f32; 3])> = others.collect();
        let picked = picker::picker_ui(ui, ui.id().with(&controls[0]), shown);
        let picked = picked.or(picker::swatches_ui(ui, &others));
        let edit = |color| place.set(&json!(hex(color)));
        match picked {
            // Of keyed colors, the key at this frame is given.
            Some(Picked::Moved(color, gesture) | Picked::Settled(color, gesture)) if is_keyed => {
                given = Some((json!(hex(color)), gesture));
            }
            Some(Picked::Moved(color, gesture)) => {
                gesture.tint(Tint { controls, color, edit: edit(color) }, actions);
            }
            Some(Picked::Settled(color, _)) if tint.is_none() && display(value, state).map(hex) == Some(hex(color)) => {
            }
            Some(Picked::Settled(color, gesture)) => gesture.settle(edit(color), actions),
            Some(Picked::Cancelled) => actions.push(Action::Tint(None)),
            None => {}
        }
    });
    FieldResponse { response: button, given }
}

/// Error in a typed color: what was expected.
#[derive(Debug, thiserror::Error)]
#[error("a color as #rrggbb, [r, g, b] in the working space, or palette.NAME; or a link, such as = sky.a")]
pub(super) struct NoColor;

/// Parses a typed color, or a link to one.
pub(super) fn read_color(text: &str) -> Result<Value, NoColor> {
    if let Some(link) = link::written(text) {
        return Ok(link.into());
    }
    let text = text.trim();
    if is_name(text) {
        return Ok(text.into());
    }
    let bare = if text.starts_with('#') { text.into() } else { format!("#{text}") };
    if rgb(&bare).is_some() {
        return Ok(bare.into());
    }
    let numbers = serde_json::from_str::<[f64; 3]>(text).ok().filter(|all| all.iter().all(|value| value.is_finite()));
    numbers.map(|numbers| json!(numbers)).ok_or(NoColor)
}

/// Draws the reference painting, which is opened from a file and clicked to pick colors.
pub(super) fn reference_ui(panel: &mut Properties, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    if let Some(dialog) = &mut panel.dialog {
        crate::dialogs::show(dialog, ui.ctx());
        if let Some(file) = dialog.take_picked() {
            panel.dialog = None;
            match read(&file) {
                Ok(picture) => {
                    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    panel.reference = Some((name, picture));
                    panel.texture = None;
                }
                Err(error) => actions.push(Action::Notice(format!("{}: {error}", file.display()))),
            }
        } else if !matches!(dialog.state(), DialogState::Open) {
            panel.dialog = None;
        }
    }
    let title = panel.reference.as_ref().map_or("Reference painting", |(name, _)| name);
    egui::CollapsingHeader::new(title).id_salt("reference").show(ui, |ui| {
        ui.horizontal(|ui| {
            if ui.button("Open …").on_hover_text("Open a painting or print to pick colors from").clicked() {
                let pictures = Filter::new(|path: &std::path::Path| {
                    let end = path.extension().map(|end| end.to_string_lossy().to_lowercase());
                    end.is_some_and(|end| ["png", "jpg", "jpeg", "tif", "tiff"].contains(&end.as_str()))
                });
                let mut dialog =
                    crate::dialogs::dialog().add_file_filter("Pictures", pictures).default_file_filter("Pictures");
                dialog.config_mut().initial_directory = state.session.folder();
                dialog.pick_file();
                panel.dialog = Some(dialog);
            }
            if panel.reference.is_some() && ui.button("Close").clicked() {
                panel.reference = None;
                panel.texture = None;
            }
        });
        let Some((_, picture)) = &panel.reference else { return };
        let texture = panel.texture.get_or_insert_with(|| {
            let image = ColorImage::from_rgba_unmultiplied(picture.size, &picture.pixels);
            ui.ctx().load_texture("reference", image, TextureOptions::LINEAR)
        });
        let width = ui.available_width();
        let size = texture.size_vec2() * (width / texture.size_vec2().x).min(260.0 / texture.size_vec2().y);
        let response = ui.add(egui::Image::new((texture.id(), size)).sense(Sense::click()));
        let Some(at) = response.hover_pos() else { return };
        let share = (at - response.rect.min) / response.rect.size();
        let color = picture_at(picture, share);
        response.clone().on_hover_text(match &state.dropper {
            Some(place) => format!("{}: click to set {place}", hex(color)),
            None => format!("{}: click to copy", hex(color)),
        });
        if let Some(gesture) = Gesture::click(&response) {
            match &state.dropper {
                Some(place) => {
                    gesture.edit(Edit::set(place.clone(), &json!(hex(color))), actions);
                    actions.push(Action::Dropper(None));
                }
                None => ui.ctx().copy_text(hex(color)),
            }
        }
    });
}

fn picture_at(picture: &Screen, share: egui::Vec2) -> [f32; 3] {
    let pixel = |share: f32, count: usize| ((share * count as f32) as usize).min(count.saturating_sub(1));
    let at = 4 * (pixel(share.y, picture.size[1]) * picture.size[0] + pixel(share.x, picture.size[0]));
    [0, 1, 2].map(|channel| f32::from(picture.pixels[at + channel]) / 255.0)
}

/// Maximum side length of the displayed painting, in pixels; larger ones are scaled down.
const MOST: u32 = 2048;

/// Why a painting cannot be shown.
#[derive(Debug, thiserror::Error)]
enum Unreadable {
    #[error(transparent)]
    File(#[from] std::io::Error),
    #[error(transparent)]
    Picture(#[from] image::ImageError),
}

fn read(file: &std::path::Path) -> Result<Screen, Unreadable> {
    let mut reader = image::ImageReader::open(file)?.with_guessed_format()?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(32_768);
    limits.max_image_height = Some(32_768);
    limits.max_alloc = Some(1 << 30);
    reader.limits(limits);
    let mut picture = reader.decode()?;
    if picture.width().max(picture.height()) > MOST {
        picture = picture.thumbnail(MOST, MOST);
    }
    let picture = picture.to_rgba8();
    Ok(Screen { size: [picture.width() as usize, picture.height() as usize], pixels: picture.into_raw() })
}
