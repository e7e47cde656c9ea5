//! Number fields: numbers are dragged within their range, or typed, as formulas too.

use super::typed::{self, NoNumber, Wanted};
use super::{FieldResponse, Gesture, escaped, joined, rounded};
use crate::refusal::{self, refusal_ui};
use egui::{Atom, DragValue, Slider, Ui};
use serde_json::{Value, json};
use std::cell::Cell;
use std::ops::RangeInclusive;

/// What a number field gives.
#[derive(Clone, Debug, PartialEq)]
enum Typed {
    Number(f64),
    /// A link in place of the number, as documents have it.
    Link(String),
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
    pub(crate) fn read(&self, text: &str) -> Result<f64, NoNumber> {
        let bare = text.replace('−', "-");
        let bare = bare.trim();
        let bare = bare.strip_suffix(self.suffix.trim()).unwrap_or(bare).trim();
        let wanted = Wanted { whole: self.whole, range: self.ends() };
        let number = typed::number(bare, &wanted)?;
        let fits = number.is_finite() && number >= self.range.0 && number <= self.range.1;
        let whole = !self.whole || number.fract() == 0.0;
        (fits && whole).then_some(number).ok_or_else(|| NoNumber::unfit(bare, number, wanted))
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

    /// Draws the field of a number of the document, in which a link may be typed instead.
    pub(crate) fn value_ui(self, ui: &mut Ui) -> FieldResponse<Value> {
        self.any_ui(ui, true).map(|typed| match typed {
            Typed::Number(number) => json!(number),
            Typed::Link(link) => link.into(),
        })
    }

    /// Draws the field.
    pub(crate) fn ui(self, ui: &mut Ui) -> FieldResponse<f64> {
        let FieldResponse { response, given } = self.any_ui(ui, false);
        let number = |(typed, gesture)| match typed {
            Typed::Number(number) => Some((number, gesture)),
            Typed::Link(_) => None,
        };
        FieldResponse { response, given: given.and_then(number) }
    }

    fn any_ui(self, ui: &mut Ui, links: bool) -> FieldResponse<Typed> {
        let mut slid = None;
        if let Some((covers, logarithmic)) = self.slider.clone() {
            let mut value = self.value;
            let slider = Slider::new(&mut value, covers).show_value(false).logarithmic(logarithmic);
            // A value beyond the ends of the slider is kept.
            let rail = ui.add(slider.clamping(egui::SliderClamping::Never));
            let gesture = Gesture::of(ui, &rail).filter(|_| value != self.value).map(|gesture| gesture.tried(&rail));
            refusal_ui(ui, &rail);
            slid = Some(FieldResponse {
                given: gesture.map(|gesture| (Typed::Number(self.tidy(value)), gesture)),
                response: rail,
            });
        }
        let told = self.field_ui(ui, links);
        match slid {
            Some(slid) => {
                let given = slid.given.or(told.given);
                FieldResponse { response: joined(slid.response, told.response), given }
            }
            None => told,
        }
    }

    fn field_ui(&self, ui: &mut Ui, links: bool) -> FieldResponse<Typed> {
        let mut value = self.value;
        let whole = self.whole_text();
        let is_edited = ui.memory(|memory| memory.has_focus(ui.next_auto_id()));
        let shown = if is_edited { whole.clone() } else { self.text() };
        let typed: Cell<Option<Result<Typed, NoNumber>>> = Cell::new(None);
        let parse = |text: &str| {
            let link = crate::document::link::written(text).filter(|_| links);
            let read = match link {
                Some(link) => Ok(Typed::Link(link)),
                // Unedited text keeps the exact value, including digits not shown.
                None if text == whole => Ok(Typed::Number(self.value)),
                None => self.read(text).map(Typed::Number),
            };
            let number = if let Ok(Typed::Number(number)) = read { Some(number) } else { None };
            typed.set(Some(read));
            number
        };
        let field = DragValue::new(&mut value)
            .clamp_existing_to_range(false)
            .speed(self.speed)
            // Numbers below each other align at their ends.
            .prefix((Atom::grow(), self.prefix))
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
            // The number of the field has not changed.
            Some(Ok(Typed::Link(link))) => Some((Typed::Link(link), Gesture(None).tried(&response))),
            Some(Ok(Typed::Number(number))) => gesture.map(|gesture| (Typed::Number(number), gesture)),
            None => gesture.map(|gesture| (Typed::Number(self.tidy(value)), gesture)),
        };
        refusal_ui(ui, &response);
        FieldResponse { given: given.filter(|(typed, _)| *typed != Typed::Number(self.value)), response }
    }
}

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
        for text in ["", "abc", "inf", "nan", "1e999", "0,5", "1/0", "[0, 1]"] {
            assert!(number.read(text).is_err(), "{text}");
        }
        let whole = Number::new(4.0).whole().range(1.0, f64::INFINITY);
        let wrong = "found \"2.5\"; expected a whole number of at least 1";
        assert_eq!(whole.read("2.5").map_err(|why| why.to_string()), Err(wrong.into()));
        assert_eq!(whole.read("1e3"), Ok(1000.0));
        assert_eq!(whole.read("1 000"), Ok(1000.0));
    }

    #[test]
    fn formulas_are_evaluated_or_refused_where_they_are_wrong() {
        let number = Number::new(0.5).range(0.0, 1000.0).suffix(" px");
        assert_eq!(number.read("1280/2"), Ok(640.0));
        assert_eq!(number.read("1280 / 2 px"), Ok(640.0));
        assert_eq!(number.read("2*pi"), Ok(2.0 * std::f64::consts::PI));
        assert_eq!(number.read("pi"), Ok(std::f64::consts::PI));
        assert_eq!(number.read("max(3, 2^4) − 1"), Ok(15.0));
        let wrong = |number: &Number<'_>, text: &str| number.read(text).map_err(|why| why.to_string()).unwrap_err();
        assert_eq!(wrong(&number, "1280*2"), "found 2560, the value of \"1280*2\"; expected a number from 0 to 1000");
        assert_eq!(
            wrong(&number.clone().whole(), "5/2"),
            "found 2.5, the value of \"5/2\"; expected a whole number from 0 to 1000"
        );
        assert_eq!(wrong(&number, "2*(3"), "found the end at column 5 of \"2*(3\"; expected ')'");
        assert_eq!(wrong(&number, "1/0"), "found inf, the value of \"1/0\"; expected a number from 0 to 1000");
        assert_eq!(wrong(&number, "1 + [2, 3]"), "found 2 numbers, the value of \"1 + [2, 3]\"; expected one");
        let named = "found \"storm\" at column 3 of \"2*storm.height\"; expected numbers; to follow other knobs, frame or \
                     time, begin with =, as in \"= 2*storm.height\"";
        assert_eq!(wrong(&number, "2*storm.height"), named);
    }
}
