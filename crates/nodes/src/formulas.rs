//! The formulas of links: the grammar of FieldMath, over named numbers.

use std::ops::Range;
use trochoid_field::{Expression, parse_named};
use trochoid_graph::{Formula, FormulaFault, Formulas};

/// Parser of the formulas in links.
#[derive(Debug)]
pub struct LinkFormulas;

impl Formulas for LinkFormulas {
    fn parse(&self, text: &str, names: &[(String, usize)]) -> Result<Box<dyn Formula>, FormulaFault> {
        let formula = parse_named(text, names).map_err(|fault| FormulaFault {
            found: format!("{} at column {}", fault.found, fault.column),
            expected: fault.expected.to_string(),
            remedy: fault.remedy.map_or_else(String::new, |remedy| remedy.to_string()),
        })?;
        Ok(Box::new(LinkFormula(formula)))
    }
}

struct LinkFormula(Expression);

impl Formula for LinkFormula {
    fn value(&self, inputs: &[Vec<f64>]) -> Vec<f64> {
        self.0.value(inputs)
    }

    fn origin(&self, inputs: &[Vec<f64>]) -> Option<Range<usize>> {
        self.0.origin(inputs, |value| !value.is_finite()).map(|part| part.text.clone())
    }
}
