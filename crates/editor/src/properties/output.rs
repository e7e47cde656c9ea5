//! The outputs of the document, and the settings of the selected output.

use super::context::Properties;
use crate::actions::Action;
use crate::document::{Sheet, output};
use crate::field::{self, Gesture};
use crate::state::State;
use egui::{ComboBox, RichText, ScrollArea, TextEdit, TextWrapMode, Ui, WidgetInfo, WidgetType};
use serde_json::{Value, json};
use trochoid::{Guarantee, Precision};

/// Draws the list of outputs; clicking a name shows its settings.
pub(super) fn outputs_ui(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    ui.label(RichText::new("Outputs").strong());
    for output in &sheet.outputs {
        ui.horizontal_wrapped(|ui| {
            if ui.link(&output.name).on_hover_text("Show its settings, and view it").clicked() {
                actions.push(Action::Output(Some(output.name.clone())));
                look(sheet, &output.source, actions);
            }
            ui.weak(format!("from {}", output.source));
            let remove = ui.small_button("×").on_hover_text("Remove the output and keep its node");
            remove.widget_info(|| {
                WidgetInfo::labeled(WidgetType::Button, true, format!("Remove output {}", output.name))
            });
            if let Some(gesture) = Gesture::click(&remove) {
                gesture.edit(output::removed(&output.name), actions);
                actions.push(Action::Seal);
            }
        });
    }
    ui.menu_button("Add output", |ui| {
        ui.style_mut().wrap_mode = Some(TextWrapMode::Extend);
        ScrollArea::vertical().max_height(300.0).show(ui, |ui| {
            for from in sources(sheet) {
                if let Some(gesture) = Gesture::click(&ui.button(sheet.reference(from.0, from.1)))
                    && let Some((edit, name)) = output::made(sheet, from)
                {
                    gesture.edit(edit, actions);
                    actions.extend([Action::Seal, Action::Output(Some(name))]);
                }
            }
        });
    });
}

/// Draws the settings of one output.
pub(super) fn output_ui(panel: &Properties, ui: &mut Ui, state: &State, name: &str, actions: &mut Vec<Action>) {
    let sheet = state.sheet();
    let Some(known) = output::find(sheet, name) else { return };
    ui.horizontal_wrapped(|ui| {
        let read = |typed: &str| match output::wrong_name(sheet, typed.trim()) {
            Some(why) => Err(why),
            None => Ok(typed.trim().to_string()),
        };
        let named = field::draft_ui(ui, "name", name, read, |text| {
            TextEdit::singleline(text).desired_width(150.0).font(egui::TextStyle::Heading)
        });
        named.response.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Name of the output"));
        if let Some((typed, gesture)) = named.given {
            gesture.edit(output::renamed(name, &typed), actions);
            actions.push(Action::Seal);
        }
        ui.label(RichText::new("Output").strong());
        if ui.button("View").clicked() {
            look(sheet, &known.source, actions);
        }
        if let Some(gesture) = Gesture::click(&ui.button("Remove").on_hover_text("Remove the output and keep its node"))
        {
            gesture.edit(output::removed(name), actions);
            actions.extend([Action::Seal, Action::Output(None)]);
        }
        if ui.button("All outputs").clicked() {
            actions.push(Action::Output(None));
        }
    });
    ui.separator();
    egui::Grid::new(("output", name)).num_columns(2).show(ui, |ui| {
        ui.label("Source");
        ComboBox::from_id_salt("source").selected_text(&known.source).show_ui(ui, |ui| {
            for from in sources(sheet) {
                let source = sheet.reference(from.0, from.1);
                if let Some(gesture) = Gesture::click(&ui.selectable_label(source == known.source, source))
                    && let Some(edit) = output::redirected(sheet, name, from)
                {
                    gesture.edit(edit, actions);
                    actions.push(Action::Seal);
                }
            }
        });
        ui.end_row();
        let help = "Path ending in .exr or .png, relative to the document; #### is the frame, {output} the name.";
        text_ui(ui, sheet, name, "file", "File", help, actions);
        let help = "Layer in the EXR file; by default the output's name. Outputs with the same file share it.";
        text_ui(ui, sheet, name, "layer", "Layer", help, actions);
        let body = sheet.get(&output::path(name));
        let precision = body.and_then(|body| body.get("precision")).and_then(Value::as_str);
        let set = |(word, gesture): (Option<&str>, Gesture), key: &str, value: fn(&str) -> Value, actions: &mut _| {
            if let Some(edit) = output::set(sheet, name, key, word.map(value)) {
                gesture.edit(edit, actions);
                actions.push(Action::Seal);
            }
        };
        if let Some(chosen) = choice_ui(ui, "Precision", "default", &Precision::NAMES, precision) {
            set(chosen, "precision", |word| word.into(), actions);
        }
        // Only color outputs have a palette guarantee.
        if body.is_some_and(|body| body.get("color").is_some()) {
            let required = body.and_then(|body| body.get("require")?.get("guarantee")?.as_str());
            let words = [Guarantee::Hull, Guarantee::Box].map(Guarantee::name);
            if let Some(chosen) = choice_ui(ui, "Require", "nothing", &words, required) {
                set(chosen, "require", |word| json!({ "guarantee": word }), actions);
            }
        }
    });
    ui.separator();
    super::notes::notes_ui(panel, ui, state, &output::path(name), actions);
}

/// Returns all results that can be rendered.
fn sources(sheet: &Sheet) -> impl Iterator<Item = (usize, usize)> {
    (0..sheet.nodes.len())
        .flat_map(|node| (0..sheet.nodes[node].makes.len()).map(move |output| (node, output)))
        .filter(|from| output::is_renderable(sheet, *from))
}

fn look(sheet: &Sheet, source: &str, actions: &mut Vec<Action>) {
    if let Some((node, index)) = sheet.source(source) {
        actions.push(Action::Look(sheet.nodes[node].name.clone(), index));
    }
}

/// Draws a text setting; an empty field removes it.
fn text_ui(ui: &mut Ui, sheet: &Sheet, name: &str, key: &str, label: &str, help: &str, actions: &mut Vec<Action>) {
    ui.label(label).on_hover_text(help);
    let path = output::path(name).to(key);
    let text = sheet.get(&path).and_then(Value::as_str).unwrap_or_default();
    let width = ui.available_width();
    let told = field::text_ui(ui, text, |text| TextEdit::singleline(text).desired_width(width));
    let field = told.response.on_hover_text(help);
    field.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, format!("{label} of the output")));
    if let Some((text, gesture)) = told.given {
        let value = (!text.is_empty()).then(|| Value::from(text));
        if let Some(edit) = output::set(sheet, name, key, value) {
            gesture.edit(edit, actions);
        }
    }
    if field.lost_focus() {
        actions.push(Action::Seal);
    }
    ui.end_row();
}

/// Draws a choice between some words and a default.
fn choice_ui<'w>(
    ui: &mut Ui,
    label: &str,
    none: &str,
    words: &[&'w str],
    chosen: Option<&str>,
) -> Option<(Option<&'w str>, Gesture)> {
    let mut given = None;
    ui.label(label);
    ComboBox::from_id_salt(label).selected_text(chosen.unwrap_or(none)).show_ui(ui, |ui| {
        given = Gesture::click(&ui.selectable_label(chosen.is_none(), none)).map(|gesture| (None, gesture));
        for word in words {
            let entry = ui.selectable_label(chosen == Some(*word), *word);
            given = given.or(Gesture::click(&entry).map(|gesture| (Some(*word), gesture)));
        }
    });
    ui.end_row();
    given
}
