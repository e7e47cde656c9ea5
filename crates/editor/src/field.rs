//! Widgets of values. What changes the document comes from a gesture of the user's and from nothing else: a widget says by
//! [`FieldResponse`] what a gesture made of its value, and only a [`Gesture`] asks for an edit. Drawing makes neither.

use crate::actions::{Action, Tint};
use crate::document::Edit;
use crate::refusal::{self, NoNumber, quoted, refusal_ui};

use egui::{DragValue, Id, Key, Pos2, Response, Slider, TextEdit, Ui};
use serde_json::Value;
use std::cell::Cell;
use std::fmt::Display;
use std::ops::RangeInclusive;

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

    /// Returns the gesture of a press on a widget, from its first moment on, with the pointer's position.
    pub(crate) fn press(response: &Response) -> Option<(Self, Pos2)> {
        response.interact_pointer_pos().map(|at| (Self(None), at))
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

/// Maximum length of a displayed number, in characters.
const LONG: usize = 12;

/// Removes superfluous zeros from scientific notation: `1.5e20` for `1.5000e20`.
fn in_powers(text: &str) -> String {
    match text.split_once('e') {
        Some((digits, power)) => format!("{}e{power}", digits.trim_end_matches('0').trim_end_matches('.')),
        None => text.into(),
    }
}

/// Number field: the value is dragged within its range, or typed.
#[derive(Clone)]
pub(crate) struct Number<'n> {
    value: f64,
    range: (f64, f64),
    whole: bool,
    decimals: usize,
    /// Whether all decimals are always shown, so that the width of the number stays constant.
    fixed: bool,
    speed: f64,
    prefix: &'n str,
    suffix: &'n str,
    /// Range of a slider before the field, and whether the slider is logarithmic.
    slider: Option<(RangeInclusive<f64>, bool)>,
}

impl<'n> Number<'n> {
    /// Creates an unlimited number field.
    pub(crate) fn new(value: f64) -> Self {
        let speed = (value.abs() * 0.005).max(0.01);
        let range = (f64::NEG_INFINITY, f64::INFINITY);
        Self { value, range, whole: false, decimals: 4, fixed: false, speed, prefix: "", suffix: "", slider: None }
    }

    /// Creates a field for frames per second.
    pub(crate) fn rate(fps: f64) -> Self {
        Self::new(fps).decimals(3).speed(0.1).range(1.0, 240.0)
    }

    /// Sets the valid range.
    pub(crate) fn range(self, min: f64, max: f64) -> Self {
        Self { range: (min, max), ..self }
    }

    /// Restricts the field to whole numbers.
    pub(crate) fn whole(self) -> Self {
        let speed = (self.value.abs() * 0.01).max(0.1);
        Self { whole: true, decimals: 0, speed, ..self }
    }

    /// Sets the number of decimals to show, without trailing zeros.
    pub(crate) fn decimals(self, decimals: usize) -> Self {
        Self { decimals, ..self }
    }

    /// Sets the number of decimals to show always, including trailing zeros.
    pub(crate) fn fixed(self, decimals: usize) -> Self {
        Self { decimals, fixed: true, ..self }
    }

    /// Sets the change per dragged point.
    pub(crate) fn speed(self, speed: f64) -> Self {
        Self { speed, ..self }
    }

    pub(crate) fn prefix(self, prefix: &'n str) -> Self {
        Self { prefix, ..self }
    }

    pub(crate) fn suffix(self, suffix: &'n str) -> Self {
        Self { suffix, ..self }
    }

    /// Adds a slider before the field.
    pub(crate) fn slider(self, covers: RangeInclusive<f64>, logarithmic: bool) -> Self {
        Self { slider: Some((covers, logarithmic)), ..self }
    }

    /// Returns the displayed text: short, unless that would misstate the value, and never longer than [`LONG`] unless
    /// in scientific notation.
    fn text(&self) -> String {
        let short = format!("{:.*}", self.decimals, self.value);
        let read: f64 = short.parse().unwrap_or(f64::NAN);
        let text = match (read - self.value).abs() > 1e-3 * self.value.abs() {
            true => self.value.to_string(),
            false if short.contains('.') && !self.fixed => short.trim_end_matches('0').trim_end_matches('.').into(),
            false => short,
        };
        if text.len() <= LONG { text } else { in_powers(&format!("{:.4e}", self.value)) }
    }

    /// Returns the text for editing, with all digits if the displayed text omits some.
    fn whole_text(&self) -> String {
        let text = self.text();
        if !text.contains('e') {
            return text;
        }
        let digits = self.value.to_string();
        if digits.len() <= 2 * LONG { digits } else { format!("{:e}", self.value) }
    }

    /// Parses a typed number.
    ///
    /// # Errors
    /// Fails if the text is not a valid number; the message has the form "found X; expected Y".
    fn read(&self, text: &str) -> Result<f64, NoNumber> {
        let bare: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let bare = bare.replace('−', "-");
        let bare = bare.strip_suffix(self.suffix.trim()).unwrap_or(&bare);
        let wanted = || NoNumber { found: text.into(), whole: self.whole, range: self.ends() };
        let number: f64 = bare.parse().map_err(|_| wanted())?;
        let fits = number.is_finite() && number >= self.range.0 && number <= self.range.1;
        let whole = !self.whole || number.fract() == 0.0;
        (fits && whole).then_some(number).ok_or_else(wanted)
    }

    /// The ends of its range as it shows them.
    fn ends(&self) -> [Option<String>; 2] {
        let show = |end: f64| end.is_finite().then(|| Number { value: end, ..self.clone() }.text());
        [show(self.range.0), show(self.range.1)]
    }

    /// Returns the value from a drag: clamped to the range, and without superfluous digits.
    fn tidy(&self, number: f64) -> f64 {
        let number = if self.whole { number.round() } else { rounded(number) };
        number.max(self.range.0).min(self.range.1)
    }

    /// Draws the field.
    pub(crate) fn ui(self, ui: &mut Ui) -> FieldResponse<f64> {
        let mut slid = None;
        if let Some((covers, logarithmic)) = self.slider.clone() {
            let mut value = self.value;
            let slider = Slider::new(&mut value, covers).show_value(false).logarithmic(logarithmic);
            // A value beyond the ends of the slider is kept.
            let rail = ui.add(slider.clamping(egui::SliderClamping::Never));
            let gesture = Gesture::of(ui, &rail).filter(|_| value != self.value).map(|gesture| gesture.tried(&rail));
            refusal_ui(ui, &rail);
            slid = Some(FieldResponse { given: gesture.map(|gesture| (self.tidy(value), gesture)), response: rail });
        }
        let told = self.field_ui(ui);
        match slid {
            Some(slid) => {
                let given = slid.given.or(told.given);
                FieldResponse { response: joined(slid.response, told.response), given }
            }
            None => told,
        }
    }

    fn field_ui(&self, ui: &mut Ui) -> FieldResponse<f64> {
        let mut value = self.value;
        let whole = self.whole_text();
        let is_edited = ui.memory(|memory| memory.has_focus(ui.next_auto_id()));
        let shown = if is_edited { whole.clone() } else { self.text() };
        let typed: Cell<Option<Result<f64, NoNumber>>> = Cell::new(None);
        let parse = |text: &str| {
            // Unedited text keeps the exact value, including digits not shown.
            let read = if text == whole { Ok(self.value) } else { self.read(text) };
            typed.set(Some(read.clone()));
            read.ok()
        };
        let field = DragValue::new(&mut value)
            .clamp_existing_to_range(false)
            .speed(self.speed)
            .prefix(self.prefix)
            .suffix(self.suffix)
            .custom_formatter(|_, _| shown.clone())
            .custom_parser(parse)
            // Typed text takes effect on Enter or when the field loses the focus: a partial number may mean something
            // else.
            .update_while_editing(false);
        let field = if self.range.0.is_finite() || self.range.1.is_finite() {
            field.range(self.range.0..=self.range.1)
        } else {
            field
        };
        let mut response = ui.add(field);
        if shown != whole {
            response = response.on_hover_text(&whole);
        }
        let gesture = Gesture::of(ui, &response).filter(|_| value != self.value);
        let gesture = gesture.map(|gesture| gesture.tried(&response));
        let given = match typed.into_inner() {
            _ if escaped(ui, &response) => None,
            Some(Err(why)) => {
                refusal::refuse(ui.ctx(), response.id, &why);
                None
            }
            Some(Ok(number)) if gesture.is_some() => Some(number),
            _ => gesture.map(|_| self.tidy(value)),
        };
        refusal_ui(ui, &response);
        FieldResponse { given: given.filter(|number| *number != self.value).zip(gesture), response }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_shown_as_what_it_is() {
        let text = |value: f64| Number::new(value).text();
        assert_eq!(text(0.25), "0.25");
        assert_eq!(text(-3.0), "-3");
        assert_eq!(text(0.123_456), "0.1235");
        assert_eq!(text(0.000_001), "0.000001", "not 0");
        for (value, short, whole) in [
            (1e300, "1e300", "1e300"),
            (-1.5e20, "-1.5e20", "-150000000000000000000"),
            (1_234_567_890_123.0, "1.2346e12", "1234567890123"),
            (1.234_567_890_123e-40, "1.2346e-40", "1.234567890123e-40"),
        ] {
            assert_eq!(text(value), short);
            assert_eq!(Number::new(value).whole_text(), whole);
            assert_eq!(whole.parse(), Ok(value));
        }
        let whole = |value: f64| Number::new(value).whole().text();
        assert_eq!(whole(4.0), "4");
        assert_eq!(whole(4.5), "4.5", "also where it should be whole");
        assert_eq!(whole(40.0), "40");
    }

    #[test]
    fn what_is_typed_is_taken_as_it_is_or_refused_with_a_message() {
        let number = Number::new(0.5).range(0.0, 1.0).suffix(" m");
        assert_eq!(number.read(" 0.75 "), Ok(0.75));
        assert_eq!(number.read("0.75 m"), Ok(0.75));
        assert_eq!(number.read("−0"), Ok(0.0));
        let wrong = "found \"1.5\"; expected a number from 0 to 1";
        assert_eq!(number.read("1.5").map_err(|why| why.to_string()), Err(wrong.into()));
        for text in ["", "abc", "inf", "nan", "1e999", "0,5", "--1"] {
            assert!(number.read(text).is_err(), "{text}");
        }
        let whole = Number::new(4.0).whole().range(1.0, f64::INFINITY);
        let wrong = "found \"2.5\"; expected a whole number of at least 1";
        assert_eq!(whole.read("2.5").map_err(|why| why.to_string()), Err(wrong.into()));
        assert_eq!(whole.read("1e3"), Ok(1000.0));
    }
}
