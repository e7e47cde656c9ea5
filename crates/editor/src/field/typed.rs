//! Numbers as they are typed: by themselves, or as formulas of numbers.

use crate::refusal::quoted;
use trochoid::registry;

/// Numbers that a field takes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    pub(super) whole: bool,
    /// The ends of the range, as numbers are shown.
    pub(super) range: [Option<String>; 2],
}

impl std::fmt::Display for Wanted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let what = if self.whole { "a whole number" } else { "a number" };
        match &self.range {
            [Some(least), Some(most)] => write!(f, "{what} from {least} to {most}"),
            [Some(least), None] => write!(f, "{what} of at least {least}"),
            [None, Some(most)] => write!(f, "{what} of at most {most}"),
            [None, None] => f.write_str(what),
        }
    }
}

/// A typed text that is no number, or none that is legal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("found {found}; expected {expected}")]
pub(crate) struct NoNumber {
    found: String,
    pub(crate) expected: String,
}

impl NoNumber {
    /// Makes the error that a number, of which this text is the number or its formula, is none of those wanted.
    pub(super) fn unfit(text: &str, number: f64, wanted: Wanted) -> Self {
        let is_plain = plain(text).is_some();
        let found = if is_plain { quoted(text) } else { format!("{number}, the value of {}", quoted(text)) };
        Self { found, expected: wanted.to_string() }
    }
}

/// Returns the number that a text without a formula is.
fn plain(text: &str) -> Option<f64> {
    let bare: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    bare.parse().ok()
}

/// Returns the number that a text is, or that its formula gives.
///
/// # Errors
/// It is neither.
pub(super) fn number(text: &str, wanted: &Wanted) -> Result<f64, NoNumber> {
    if let Some(number) = plain(text) {
        return Ok(number);
    }
    let is_formula = text.contains(['+', '-', '*', '/', '^', '(', '[', '<', '>']);
    let none = || NoNumber { found: quoted(text), expected: wanted.to_string() };
    let formulas = registry().formulas().ok_or_else(none)?;
    let formula = formulas.parse(text, &[]).map_err(|fault| {
        if !is_formula {
            return none();
        }
        // A name, and not the letters after a value.
        let is_name = fault.found.starts_with('"') && !fault.found.starts_with("\".");
        let expected = match is_name {
            true => format!(
                "numbers; to follow other knobs, frame or time, begin with =, as in {}",
                quoted(&format!("= {text}"))
            ),
            false => fault.expected,
        };
        NoNumber { found: format!("{} of {}", fault.found, quoted(text)), expected }
    })?;
    match formula.value(&[]).as_slice() {
        [number] => Ok(*number),
        numbers => {
            let found = format!("{} numbers, the value of {}", numbers.len(), quoted(text));
            Err(NoNumber { found, expected: "one".into() })
        }
    }
}
