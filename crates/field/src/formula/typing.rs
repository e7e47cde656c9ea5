//! Names in formulas, and checks of the numbers of components that are combined.

use super::grammar::{Names, Parsed, Parser, fault_at};
use super::{Expected, Expression, Fault, Found, Function, MAX_WIDTH, Remedy, Tree};
use std::ops::Range;
use trochoid_graph::nearest;

const INPUTS: [&str; 4] = ["a", "b", "c", "d"];
/// Names beside these, whose values have the indices after theirs.
const OWN: [&str; 2] = ["frame", "time"];

impl Fault {
    fn with_remedy(self, remedy: Remedy) -> Self {
        Self { remedy: Some(remedy), ..self }
    }
}

impl Parser<'_> {
    /// Resolves a name without arguments: a constant or an input.
    pub(super) fn name(&mut self, at: usize, name: &str) -> Parsed {
        let whole = |tree: Tree, width: usize| Ok(Expression { tree, width, text: at..at + name.chars().count() });
        if name == "pi" {
            return whole(Tree::Number(std::f64::consts::PI), 1);
        }
        let inputs = match self.names {
            Names::Letters(inputs) => inputs,
            Names::Named(known) => match known.iter().position(|(known, _)| known == name) {
                Some(index) => return whole(Tree::Input(index), known[index].1),
                None => [None; 4],
            },
        };
        let is_letters = matches!(self.names, Names::Letters(_));
        if let Some(index) = OWN.iter().position(|own| *own == name && is_letters) {
            return whole(Tree::Input(INPUTS.len() + index), 1);
        }
        match INPUTS.iter().position(|input| *input == name && is_letters) {
            Some(index) => match inputs[index] {
                Some(width) => whole(Tree::Input(index), width),
                None => {
                    let fault = fault_at(at, Found::Unconnected(INPUTS[index]), Expected::ConnectedInput);
                    Err(fault.with_remedy(Remedy::Connect(INPUTS[index])))
                }
            },
            None if Function::named(name).is_some() || matches!(name, "dot" | "length") => {
                self.at = at + name.len();
                Err(self.fault(Expected::ArgumentsOf(name.into())))
            }
            None => {
                let fault = fault_at(at, Found::Name(name.into()), Expected::KnownName);
                Err(if is_letters { fault.with_remedy(Remedy::NameInput) } else { fault })
            }
        }
    }

    /// Resolves a name with arguments.
    pub(super) fn call(&mut self, at: usize, name: &str) -> Parsed {
        let arguments = self.list(")")?;
        let text = at..self.at;
        let function = Function::named(name);
        let count = match (name, function) {
            ("dot", _) => 2,
            ("length", _) => 1,
            (_, Some(function)) => function.arguments(),
            _ => {
                let fault = fault_at(at, Found::Name(name.into()), Expected::FunctionName);
                let names = Function::names().into_iter().chain(["dot", "length"]);
                return Err(match nearest(name, names) {
                    Some(near) => fault.with_remedy(Remedy::Nearest(near)),
                    None => fault,
                });
            }
        };
        if count != arguments.len() {
            let found = Found::Arguments(arguments.len(), name.into());
            return Err(fault_at(at, found, Expected::Arguments(count)));
        }
        match function {
            Some(function) => Ok(Expression { text, ..each(at, function, arguments)? }),
            None if name == "dot" => {
                let mut arguments = arguments.into_iter();
                match (arguments.next(), arguments.next()) {
                    (Some(a), Some(b)) if a.width == b.width => {
                        Ok(Expression { tree: Tree::Dot(Box::new(a), Box::new(b)), width: 1, text })
                    }
                    (Some(a), Some(b)) => Err(fault_at(at, Found::Widths(a.width, b.width), Expected::SameWidths)),
                    _ => unreachable!("two arguments were counted"),
                }
            }
            None => {
                let argument = arguments.into_iter().next();
                let tree = argument.map_or(Tree::Number(0.0), |a| Tree::Length(Box::new(a)));
                Ok(Expression { tree, width: 1, text })
            }
        }
    }
}

/// Joins several values into one, whose characters are given.
pub(super) fn join(text: Range<usize>, values: Vec<Expression>) -> Parsed {
    let width = values.iter().map(|value| value.width).sum();
    if width > MAX_WIDTH {
        return Err(fault_at(text.start, Found::Width(width), Expected::Width));
    }
    Ok(Expression { tree: Tree::Join(values), width, text })
}

/// Applies a function, whose sign is at a character, component by component.
pub(super) fn each(at: usize, function: Function, arguments: Vec<Expression>) -> Parsed {
    let width = arguments.iter().map(|argument| argument.width).max().unwrap_or(1);
    match arguments.iter().find(|argument| argument.width != 1 && argument.width != width) {
        Some(other) => Err(unlike(at, width, other.width)),
        None => {
            let start = arguments.iter().map(|argument| argument.text.start).min();
            let end = arguments.iter().map(|argument| argument.text.end).max();
            let text = at.min(start.unwrap_or(at))..end.unwrap_or(at);
            Ok(Expression { tree: Tree::Each(function, arguments), width, text })
        }
    }
}

fn unlike(at: usize, a: usize, b: usize) -> Fault {
    fault_at(at, Found::Widths(a, b), Expected::EqualWidths)
}
