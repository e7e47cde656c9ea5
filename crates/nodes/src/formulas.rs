//! The formulas of links: the grammar of FieldMath, over named numbers.

use trochoid_field::parse_named;
use trochoid_graph::{FormulaFault, FormulaValue, Formulas};

/// Parser of the formulas in links.
#[derive(Debug)]
pub struct LinkFormulas;

impl Formulas for LinkFormulas {
    fn parse(&self, text: &str, names: &[(String, usize)]) -> Result<FormulaValue, FormulaFault> {
        let formula = parse_named(text, names).map_err(|fault| FormulaFault {
            found: format!("{} at column {}", fault.found, fault.column),
            expected: fault.expected.to_string(),
            remedy: fault.remedy.map_or_else(String::new, |remedy| remedy.to_string()),
        })?;
        Ok(Box::new(move |inputs| formula.value(inputs)))
    }
}
