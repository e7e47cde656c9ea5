//! The syntax tree of FieldMath's formulas, and their value at one sample.

use super::Function;

/// Formula of the inputs, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// Root of its syntax tree.
    pub(super) tree: Tree,
    /// Number of components of its value.
    pub width: usize,
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
