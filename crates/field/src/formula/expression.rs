//! The syntax tree of FieldMath's formulas, and their value at one sample.

use super::Function;
use std::ops::Range;

/// Formula of the inputs, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// Root of its syntax tree.
    pub(super) tree: Tree,
    /// Number of components of its value.
    pub width: usize,
    /// Its characters in the formula.
    pub text: Range<usize>,
}

/// Node of the syntax tree.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Tree {
    Number(f64),
    /// An input, counted from 0.
    Input(usize),
    /// A function applied component by component; arguments of one component are used for every component.
    Each(Function, Vec<Expression>),
    Dot(Box<Expression>, Box<Expression>),
    Length(Box<Expression>),
    /// Selected components of a value.
    Pick(Box<Expression>, Vec<usize>),
    /// The components of several values, one after another.
    Join(Vec<Expression>),
}

impl Expression {
    /// Returns the innermost part whose value is wrong at one sample, although those of its own parts are not; `None` if the
    /// formula's value is not wrong.
    pub fn origin(&self, inputs: &[Vec<f64>], is_wrong: fn(f64) -> bool) -> Option<&Self> {
        self.value(inputs).into_iter().any(is_wrong).then(|| {
            let within = self.parts().into_iter().find_map(|part| part.origin(inputs, is_wrong));
            within.unwrap_or(self)
        })
    }

    /// Whether an input is used.
    pub fn uses(&self, input: usize) -> bool {
        self.tree == Tree::Input(input) || self.parts().into_iter().any(|part| part.uses(input))
    }

    fn parts(&self) -> Vec<&Self> {
        match &self.tree {
            Tree::Number(_) | Tree::Input(_) => Vec::new(),
            Tree::Each(_, parts) | Tree::Join(parts) => parts.iter().collect(),
            Tree::Dot(a, b) => vec![a, b],
            Tree::Length(a) | Tree::Pick(a, _) => vec![a],
        }
    }

    /// Returns the components of the value at one sample, from the components of the inputs.
    pub fn value(&self, inputs: &[Vec<f64>]) -> Vec<f64> {
        match &self.tree {
            Tree::Number(number) => vec![*number],
            Tree::Input(index) => inputs[*index].clone(),
            Tree::Each(function, arguments) => {
                let values: Vec<Vec<f64>> = arguments.iter().map(|argument| argument.value(inputs)).collect();
                let component = |index: usize| {
                    let of_each: Vec<f64> = values.iter().map(|v| v[if v.len() == 1 { 0 } else { index }]).collect();
                    function.of(&of_each)
                };
                (0..self.width).map(component).collect()
            }
            Tree::Dot(a, b) => vec![a.value(inputs).iter().zip(b.value(inputs)).map(|(a, b)| a * b).sum()],
            Tree::Length(a) => vec![a.value(inputs).iter().map(|a| a * a).sum::<f64>().sqrt()],
            Tree::Pick(a, picked) => {
                let value = a.value(inputs);
                picked.iter().map(|index| value[*index]).collect()
            }
            Tree::Join(values) => values.iter().flat_map(|value| value.value(inputs)).collect(),
        }
    }
}
