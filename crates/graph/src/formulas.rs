//! Formulas in links, whose grammar another crate has.

use std::ops::Range;

/// A parsed formula.
pub trait Formula {
    /// Returns the components of its value, from those of its names.
    fn value(&self, inputs: &[Vec<f64>]) -> Vec<f64>;

    /// Returns the innermost part, as characters of the text, whose value is no finite number although its own parts are.
    fn origin(&self, inputs: &[Vec<f64>]) -> Option<Range<usize>>;
}

/// Parser of the formulas in links.
pub trait Formulas: std::fmt::Debug + Sync {
    /// Parses a formula of these names, which have these numbers of components.
    ///
    /// # Errors
    /// The text is not a formula, or combines values whose numbers of components do not fit.
    fn parse(&self, text: &str, names: &[(String, usize)]) -> Result<Box<dyn Formula>, FormulaFault>;
}

/// Fault of a formula.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormulaFault {
    /// What was found, with its column.
    pub found: String,
    /// What was expected.
    pub expected: String,
    /// What to do; empty if that is clear.
    pub remedy: String,
}
