//! The selected color: its name, picking of another color, and what uses it.

use super::recolor;
use crate::actions::Action;
use crate::document::palette;
use crate::document::swatches::{self, Swatch, SwatchKey};
use crate::field::{self, Gesture};
use crate::picker::{self, Picked};
use crate::state::State;
use egui::{Button, TextEdit, Ui};

/// Error in a typed color: what was expected.
#[derive(Debug, thiserror::Error)]
#[error("a color as #rrggbb")]
struct NoColor;

/// Draws the selected color.
pub(super) fn chosen_ui(ui: &mut Ui, state: &State, swatch: &Swatch, all: &[Swatch], actions: &mut Vec<Action>) {
    let is_filed = swatches::file(state.sheet()).is_some();
    let is_fixed = is_filed && matches!(swatch.key, SwatchKey::Named(_));
    let tint = state.colors.tint.as_ref().filter(|tint| tint.controls == swatch.controls());
    let color = tint.map(|tint| tint.color).or(swatch.color);
    name_ui(ui, state, swatch, color, all, actions);
    if swatch.is_keyed() {
        ui.weak(keyed(swatch, state.frame));
    }
    if let Some(color) = color {
        ui.add_enabled_ui(!is_fixed, |ui| {
            let id = ui.id().with(("picker", &swatch.key));
            let picked = picker::picker_ui(ui, id, color);
            let others: Vec<(String, [f32; 3])> = all
                .iter()
                .filter(|other| other.key != swatch.key)
                .filter_map(|other| Some((other.called(), other.color?)))
                .collect();
            let taken = picker::swatches_ui(ui, &others);
            if let Some(picked) = picked.or(taken) {
                recolor(picked, state, swatch, actions);
            }
        });
    }
    ui.horizontal_wrapped(|ui| {
        let nodes = swatch.nodes();
        let select = ui.add_enabled(!nodes.is_empty(), Button::new("Select nodes"));
        if select.on_hover_text("Select the nodes that use this color").clicked() {
            actions.extend([Action::Select(nodes.into_iter().collect()), Action::Frames]);
        }
        let mut spot = state.colors.spot;
        let has_shares = state.evaluated.mixture.is_some();
        let toggle = ui.add_enabled_ui(has_shares, |ui| ui.toggle_value(&mut spot, "Show where")).inner;
        if toggle.on_hover_text("Dim everything in the picture that is not of this color").clicked() {
            actions.push(Action::Spot(spot));
        }
        ui.add_enabled_ui(!is_filed, |ui| {
            merge_ui(ui, swatch, all, actions);
            if let (SwatchKey::Named(name), 0) = (&swatch.key, swatch.count()) {
                let delete = ui.button("Delete").on_hover_text("Remove this color, which nothing uses");
                if let Some(gesture) = Gesture::click(&delete) {
                    gesture.edit(palette::removed(name), actions);
                    actions.push(Action::Seal);
                }
            }
        });
    });
}

/// Draws the fields of the name and of the color as text, and the dropper.
fn name_ui(
    ui: &mut Ui,
    state: &State,
    swatch: &Swatch,
    color: Option<[f32; 3]>,
    all: &[Swatch],
    actions: &mut Vec<Action>,
) {
    let is_filed = swatches::file(state.sheet()).is_some();
    let is_named = matches!(swatch.key, SwatchKey::Named(_));
    ui.horizontal(|ui| {
        ui.add_enabled_ui(!is_filed, |ui| {
            let written = if is_named { swatch.called() } else { String::new() };
            let told = field::draft_ui(
                ui,
                "color name",
                &written,
                |typed| palette::given_up(swatch).and_then(|()| palette::free(typed, all)),
                |text| TextEdit::singleline(text).desired_width(128.0).hint_text("Name this color"),
            );
            let help =
                if is_named { "Name of the color; its uses follow" } else { "Give this color a name in the palette" };
            told.response.on_hover_text(help);
            if let Some((name, gesture)) = told.given {
                let edit = match is_named {
                    true => palette::renamed(swatch, &name),
                    false => palette::named(state.sheet(), swatch, &name),
                };
                gesture.edit(edit, actions);
                actions.extend([Action::Seal, Action::Swatch(Some(SwatchKey::Named(name)))]);
            }
        });
        let is_fixed = is_named && is_filed;
        ui.add_enabled_ui(!is_fixed, |ui| {
            let written = color.map(crate::document::color::hex).unwrap_or_default();
            let read = |typed: &str| {
                let bare = typed.trim().trim_start_matches('#');
                crate::document::color::rgb(&format!("#{bare}")).ok_or(NoColor)
            };
            let told = field::draft_ui(ui, "color text", &written, read, |text| {
                TextEdit::singleline(text).desired_width(66.0).font(egui::TextStyle::Monospace)
            });
            if let Some((color, gesture)) = told.given {
                recolor(Picked::Settled(color, gesture), state, swatch, actions);
            }
            let places = swatch.places();
            let place = places.first().filter(|_| places.len() == 1 && !swatch.is_keyed());
            let mut taking = place.is_some() && state.dropper.as_ref() == place;
            let pick = ui.add_enabled_ui(place.is_some(), |ui| ui.toggle_value(&mut taking, "Pick")).inner;
            let help = "Pick the next color clicked in the picture or the reference painting";
            if pick.on_hover_text(help).clicked() {
                actions.push(Action::Dropper(place.filter(|_| taking).cloned()));
            }
        });
    });
}

/// Draws the menu of colors to merge this one into.
fn merge_ui(ui: &mut Ui, swatch: &Swatch, all: &[Swatch], actions: &mut Vec<Action>) {
    let own = swatch.called();
    let names: Vec<&str> = palette::names(all).filter(|name| *name != own).collect();
    let given_up = palette::given_up(swatch);
    let menu = ui.add_enabled_ui(!names.is_empty() && given_up.is_ok(), |ui| {
        ui.menu_button("Merge into", |ui| {
            egui::ScrollArea::vertical().max_height(260.0).show(ui, |ui| {
                for name in names {
                    if let Some(gesture) = Gesture::click(&ui.button(name)) {
                        gesture.edit(palette::merged(swatch, name), actions);
                        actions.extend([Action::Seal, Action::Swatch(Some(SwatchKey::Named(name.into())))]);
                        ui.close();
                    }
                }
            });
        })
    });
    let help = match given_up {
        Ok(()) => "Let everything that uses this color use another one instead".to_string(),
        Err(why) => format!("Expected {why}"),
    };
    menu.response.on_hover_text(help);
}

/// Says that a color is keyed, and what a change does.
fn keyed(swatch: &Swatch, frame: i64) -> String {
    let keys = swatch.value.as_ref().and_then(|value| value.get("keys")?.as_array().cloned()).unwrap_or_default();
    let has_key = keys.iter().any(|key| key.get(0).and_then(serde_json::Value::as_f64) == Some(frame as f64));
    let count = crate::document::edit::count(keys.len(), "key");
    match has_key {
        true => format!("Keyed ({count}): a change is to the key at frame {frame}."),
        false => format!("Keyed ({count}): a change adds a key at frame {frame}."),
    }
}
