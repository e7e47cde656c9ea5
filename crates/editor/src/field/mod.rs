//! Widgets of values. What changes the document comes from a gesture of the user's and from nothing else: a widget says by
//! [`FieldResponse`] what a gesture made of its value, and only a [`Gesture`] asks for an edit. Drawing makes neither.

mod number;
mod typed;

use crate::actions::{Action, Tint};
use crate::document::Edit;
use crate::refusal::{self, quoted, refusal_ui};
use egui::{Id, Key, Pos2, Response, TextEdit, Ui};
pub(crate) use number::Number;
use serde_json::Value;
use std::fmt::Display;
pub(crate) use typed::NoNumber;

/// Proof of a user's gesture, which only this module can create. Contains the field to show a refusal at, if the
/// document may reject the value.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gesture(Option<Id>);

impl Gesture {
    /// Returns the gesture of a click on a widget.
    pub(crate) fn click(response: &Response) -> Option<Self> {
        response.clicked().then_some(Self(None))
    }

    /// Returns the gesture of a right-click.
    pub(crate) fn secondary_click(response: &Response) -> Option<Self> {
        response.secondary_clicked().then_some(Self(None))
    }

    /// Returns the gesture of a double-click.
    pub(crate) fn double_click(response: &Response) -> Option<Self> {
        response.double_clicked().then_some(Self(None))
    }

    /// Returns the gesture of a drag in progress that moved in this frame.
    pub(crate) fn drag(response: &Response) -> Option<Self> {
        (response.dragged() && response.drag_delta() != egui::Vec2::ZERO).then_some(Self(None))
    }

    /// Returns the gesture of a drag, including its release.
    pub(crate) fn dragged(response: &Response) -> Option<Self> {
        (response.dragged() || response.drag_stopped()).then_some(Self(None))
    }

    /// Returns the gesture that ends a drag by letting go of the pointer.
    pub(crate) fn release(ui: &Ui) -> Option<Self> {
        ui.input(|input| input.pointer.any_released()).then_some(Self(None))
    }

    /// Returns the gesture of a press on a widget, from its first moment on, with the pointer's position.
    pub(crate) fn press(response: &Response) -> Option<(Self, Pos2)> {
        response.interact_pointer_pos().map(|at| (Self(None), at))
    }

    /// Returns the gesture of a wheel that turned over a widget.
    pub(crate) fn wheel(response: &Response, turned: bool) -> Option<Self> {
        (turned && response.hovered()).then_some(Self(None))
    }

    /// Returns the gesture that changed a widget while the pointer, a key, or an accessibility tool was used on it.
    fn of(ui: &Ui, response: &Response) -> Option<Self> {
        let by_hand = response.is_pointer_button_down_on() || response.clicked() || response.drag_stopped();
        let by_keys = response.has_focus() || response.lost_focus();
        let asked = |event: &egui::Event| matches!(event, egui::Event::AccessKitActionRequest(_));
        let by_tool = || ui.input(|input| input.events.iter().any(asked));
        (response.changed() && (by_hand || by_keys || by_tool())).then_some(Self(None))
    }

    /// Marks the value as final: if the document rejects it, this field shows the refusal.
    pub(crate) fn tried(self, field: &Response) -> Self {
        Self(Some(field.id))
    }

    /// Requests an edit of the document.
    pub(crate) fn edit(self, edit: Edit, actions: &mut Vec<Action>) {
        actions.push(match self.0 {
            Some(field) => Action::Give(edit, field),
            None => Action::Edit(edit),
        });
    }

    /// Shows a color while it is dragged.
    pub(crate) fn tint(self, tint: Tint, actions: &mut Vec<Action>) {
        actions.push(Action::Tint(Some(tint)));
    }

    /// Requests the edit with which the drag of a color ends.
    pub(crate) fn settle(self, edit: Edit, actions: &mut Vec<Action>) {
        actions.push(Action::SettleTint(edit));
    }

    /// Requests an edit of the document as a whole, whatever group is entered.
    pub(crate) fn whole(self, edit: Edit, actions: &mut Vec<Action>) {
        actions.push(Action::Whole(edit));
    }

    /// Requests an edit of the document's wires.
    pub(crate) fn rewire(self, edit: Edit, actions: &mut Vec<Action>) {
        actions.push(Action::Rewire(edit));
    }
}

/// Result of a widget: its response, and the value that a gesture produced, if any.
#[must_use]
pub(crate) struct FieldResponse<T> {
    pub(crate) response: Response,
    pub(crate) given: Option<(T, Gesture)>,
}

impl<T> FieldResponse<T> {
    /// Creates a result without a value.
    pub(crate) fn nothing(response: Response) -> Self {
        Self { response, given: None }
    }

    /// Converts the value.
    pub(crate) fn map<U>(self, to: impl FnOnce(T) -> U) -> FieldResponse<U> {
        FieldResponse { response: self.response, given: self.given.map(|(value, gesture)| (to(value), gesture)) }
    }

    /// Returns the value, for fields that do not edit the document.
    pub(crate) fn value(self) -> Option<T> {
        self.given.map(|(value, _)| value)
    }

    /// Requests an edit if a value was given, and ends the undo step with the gesture.
    pub(crate) fn edit(self, actions: &mut Vec<Action>, edit: impl FnOnce(T) -> Edit) {
        if let Some((value, gesture)) = self.given {
            gesture.edit(edit(value), actions);
        }
        if self.response.drag_stopped() || self.response.lost_focus() {
            actions.push(Action::Seal);
        }
    }
}

/// Returns whether typing in a field was cancelled with Esc. A field counts as left for two passes; in the second, Esc
/// is no longer pressed, and the number would be parsed after all.
fn escaped(ui: &Ui, field: &Response) -> bool {
    let (id, pass) = (field.id.with("escaped"), ui.ctx().cumulative_pass_nr());
    if field.lost_focus() && ui.input(|input| input.key_pressed(Key::Escape)) {
        ui.data_mut(|data| data.insert_temp(id, pass));
        return true;
    }
    field.lost_focus() && ui.data(|data| data.get_temp::<u64>(id)).is_some_and(|then| then + 1 == pass)
}

/// Joins the responses of two fields for one value so that the focused field's response comes first.
pub(crate) fn joined(a: Response, b: Response) -> Response {
    if b.has_focus() || b.lost_focus() { b | a } else { a | b }
}

/// Rounds away digits that are only an artifact of dragging.
pub(crate) fn rounded(number: f64) -> f64 {
    let digits = (5.0 - number.abs().max(1e-3).log10().floor()).clamp(0.0, 9.0);
    let scale = 10f64.powf(digits);
    let rounded = (number * scale).round() / scale;
    if rounded.is_finite() { rounded } else { number }
}

/// Draws a text field whose every intermediate text is valid, so that each keystroke takes effect at once; Esc restores
/// the previous text.
pub(crate) fn text_ui(
    ui: &mut Ui,
    text: &str,
    field: impl FnOnce(&mut String) -> TextEdit<'_>,
) -> FieldResponse<String> {
    let mut typed = text.to_string();
    let response = {
        let field = field(&mut typed);
        ui.add(field)
    };
    let before = response.id.with("before");
    if response.gained_focus() {
        ui.data_mut(|data| data.insert_temp(before, text.to_string()));
    }
    if escaped(ui, &response) {
        let given = ui.data_mut(|data| data.remove_temp::<String>(before)).filter(|before| before != text);
        return FieldResponse { given: given.map(|before| (before, Gesture(None))), response };
    }
    let gesture = Gesture::of(ui, &response).filter(|_| typed != text);
    FieldResponse { given: gesture.map(|gesture| (typed, gesture)), response }
}

/// Lets the field of a text that must be parsed begin with a typed text.
pub(crate) fn begin_draft(ui: &Ui, salt: &str, written: &str, typed: String) {
    ui.data_mut(|data| data.insert_temp(ui.id().with(("draft", salt)), (written.to_string(), typed)));
}

/// Draws a field for a text that must be parsed, such as a color or a list; it takes effect on Enter or when the field
/// loses the focus. A refused text can be corrected while the refusal is shown; Esc restores the previous text.
pub(crate) fn draft_ui<T, E: Display>(
    ui: &mut Ui,
    salt: &str,
    written: &str,
    read: impl FnOnce(&str) -> Result<T, E>,
    field: impl FnOnce(&mut String) -> TextEdit<'_>,
) -> FieldResponse<T> {
    let id = ui.id().with(("draft", salt));
    let known = ui.data(|data| data.get_temp::<(String, String)>(id));
    // Something else changed the value: the typed text belonged to the old one.
    let known = known.filter(|(of, _)| of == written).map(|(_, typed)| typed);
    let mut typed = known.unwrap_or_else(|| written.to_string());
    let response = {
        let field = field(&mut typed);
        ui.add(field)
    };
    let escaped = escaped(ui, &response);
    let mut given = None;
    if response.lost_focus() && !escaped && typed != written {
        match read(&typed) {
            Ok(value) => given = Some((value, Gesture(None).tried(&response))),
            Err(expected) => {
                let why = format_args!("found {}; expected {expected}", quoted(&typed));
                refusal::refuse(ui.ctx(), response.id, &why);
            }
        }
    }
    refusal_ui(ui, &response);
    let stays = response.has_focus() || given.is_some() || refusal::stands(ui.ctx(), response.id);
    if stays && !escaped && typed != written {
        ui.data_mut(|data| data.insert_temp(id, (written.to_string(), typed)));
    } else {
        ui.data_mut(|data| data.remove::<(String, String)>(id));
    }
    FieldResponse { response, given }
}

/// Draws a checkbox.
pub(crate) fn switch_ui(ui: &mut Ui, on: bool, text: &str) -> FieldResponse<bool> {
    let mut next = on;
    let response = ui.checkbox(&mut next, text);
    let gesture = Gesture::of(ui, &response).filter(|_| next != on);
    FieldResponse { given: gesture.map(|gesture| (next, gesture)), response }
}

/// Draws a checkbox of several values, which is neither on nor off if they differ; a click then turns all on.
pub(crate) fn mixed_switch_ui(ui: &mut Ui, on: Option<bool>, text: &str) -> FieldResponse<bool> {
    let mut next = on.unwrap_or(false);
    let response = ui.add(egui::Checkbox::new(&mut next, text).indeterminate(on.is_none()));
    let gesture = Gesture::of(ui, &response).filter(|_| Some(next) != on);
    FieldResponse { given: gesture.map(|gesture| (next, gesture)), response }
}

/// Draws a field for a JSON value, shown as JSON (strings without quotes).
pub(crate) fn value_ui<E: Display>(
    ui: &mut Ui,
    salt: &str,
    value: &Value,
    width: f32,
    read: impl FnOnce(&str) -> Result<Value, E>,
) -> FieldResponse<Value> {
    let written = match value {
        Value::String(text) => text.clone(),
        Value::Null => String::new(),
        other => crate::document::change::style(other),
    };
    let mut told = draft_ui(ui, salt, &written, read, |text| TextEdit::singleline(text).desired_width(width));
    if written.len() > SEEN && !told.response.has_focus() {
        told.response = told.response.on_hover_text(written);
    }
    told
}

/// Number of characters that fit in the field.
const SEEN: usize = 24;
