//! Formulas in links, whose grammar another crate has.

/// Value of a formula, from those of its names.
pub type FormulaValue = Box<dyn Fn(&[Vec<f64>]) -> Vec<f64>>;

/// Parser of the formulas in links.
pub trait Formulas: std::fmt::Debug + Sync {
    /// Parses a formula of these names, which have these numbers of components.
    ///
    /// # Errors
    /// The text is not a formula, or combines values whose numbers of components do not fit.
    fn parse(&self, text: &str, names: &[(String, usize)]) -> Result<FormulaValue, FormulaFault>;
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
