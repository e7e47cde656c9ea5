//! Errors of formulas, as data and in words.

use super::Function;
use std::fmt::{Display, Formatter, Result};

/// Maximum depth of nesting, far deeper than formulas written by hand. Deeper nesting could overflow the stack.
pub const MAX_DEPTH: usize = 64;
/// Maximum length in characters, far longer than formulas written by hand. It also bounds the depth to which a chain of
/// operators nests.
pub const MAX_LENGTH: usize = 1000;
/// Maximum number of components of a value.
pub const MAX_WIDTH: usize = 4;

/// Error in a formula.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Column in characters, from 1.
    pub column: usize,
    /// What was found there.
    pub found: Found,
    /// What was expected there.
    pub expected: Expected,
    /// What to do, if known.
    pub remedy: Option<Remedy>,
}

/// What was found instead of something expected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// A formula of this many characters.
    Length(usize),
    /// A character that has no meaning there.
    Character(char),
    /// The end of the formula.
    End,
    /// Brackets and signs nested more deeply than [`MAX_DEPTH`].
    TooDeep,
    /// Letters that do not pick components of a value with this many.
    Letters(String, usize),
    /// A number beyond the range of f64.
    Number(String),
    /// An unconnected input.
    Unconnected(&'static str),
    /// An unknown name, or a name that is not a function.
    Name(String),
    /// A value of this many components.
    Width(usize),
    /// Values of different numbers of components combined.
    Widths(usize, usize),
    /// This many arguments of a function.
    Arguments(usize, String),
}

/// What was expected instead.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Expected {
    /// At most [`MAX_LENGTH`] characters.
    Length,
    /// An operator after a value, or the end.
    Operator,
    /// The start of a value.
    Value,
    /// This character.
    Sign(&'static str),
    /// A comma, or this closing bracket.
    CommaOr(&'static str),
    /// The arguments of this function.
    ArgumentsOf(String),
    /// Fewer levels of brackets.
    FewerLevels,
    /// Letters of a value of this many components.
    Letters(usize),
    /// A number within the range of f64.
    FiniteNumber,
    /// A connected input.
    ConnectedInput,
    /// A known name.
    KnownName,
    /// The name of a function.
    FunctionName,
    /// This many arguments.
    Arguments(usize),
    /// At most [`MAX_WIDTH`] components.
    Width,
    /// Values of equal numbers of components, or a single number combined with others.
    EqualWidths,
    /// Values of equal numbers of components.
    SameWidths,
}

/// What to do about a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// Connect this input, or remove it from the formula.
    Connect(&'static str),
    /// Connect the value to an input, and use the input's name.
    NameInput,
    /// Use this name, which is similar to the one found.
    Nearest(&'static str),
}

/// Returns a count of components in words.
struct Components(usize);

impl Display for Components {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        if self.0 == 1 { f.write_str("a single number") } else { write!(f, "{} components", self.0) }
    }
}

impl Display for Found {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Length(count) => write!(f, "{count} characters"),
            Self::Character(character) => write!(f, "'{character}'"),
            Self::End => f.write_str("the end"),
            Self::TooDeep => write!(f, "more than {MAX_DEPTH} levels"),
            Self::Letters(letters, of) => write!(f, "\".{letters}\" of {}", Components(*of)),
            Self::Number(text) => write!(f, "'{text}'"),
            Self::Unconnected(input) => write!(f, "the unconnected input {input}"),
            Self::Name(name) => write!(f, "\"{name}\""),
            Self::Width(width) => Components(*width).fmt(f),
            Self::Widths(a, b) => write!(f, "{} combined with {}", Components(*a), Components(*b)),
            Self::Arguments(count, function) => write!(f, "{count} arguments of {function}"),
        }
    }
}

impl Display for Expected {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Length => write!(f, "at most {MAX_LENGTH} characters"),
            Self::Operator => f.write_str("an operator or the end"),
            Self::Value => f.write_str("a number, an input, a function or '('"),
            Self::Sign(sign) => write!(f, "'{sign}'"),
            Self::CommaOr(close) => write!(f, "',' or '{close}'"),
            Self::ArgumentsOf(function) => write!(f, "'(' after {function}"),
            Self::FewerLevels => f.write_str("fewer levels of brackets"),
            Self::Letters(width) => write!(f, "1 to 4 of the letters {}", &"xyzw"[..(*width).min(MAX_WIDTH)]),
            Self::FiniteNumber => f.write_str("a finite number, such as 0.5 or 2e3"),
            Self::ConnectedInput => f.write_str("a connected input"),
            Self::KnownName => f.write_str("an input a, b, c or d, frame, time, pi, or a function"),
            Self::FunctionName => write!(f, "a function: {}, dot or length", Function::names().join(", ")),
            Self::Arguments(count) => write!(f, "{count}"),
            Self::Width => write!(f, "at most {MAX_WIDTH} components"),
            Self::SameWidths => f.write_str("the same number of components"),
            Self::EqualWidths => f.write_str("the same number of components, or a single number"),
        }
    }
}

impl Display for Remedy {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Connect(input) => write!(f, "connect \"{input}\", or leave it out of the expression"),
            Self::NameInput => f.write_str("connect the Field to \"a\", \"b\", \"c\" or \"d\", and write that letter"),
            Self::Nearest(name) => write!(f, "did you mean \"{name}\"?"),
        }
    }
}

impl Display for Fault {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Self { column, found, expected, remedy } = self;
        write!(f, "found {found} at column {column}; expected {expected}")?;
        remedy.iter().try_for_each(|remedy| write!(f, "; {remedy}"))
    }
}

impl std::error::Error for Fault {}
