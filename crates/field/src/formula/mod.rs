//! Formulas: their grammar, their value at one sample, and fast evaluation of many samples.

mod expression;
mod fault;
mod function;
mod function_span;
mod grammar;
mod guards;
mod program;
#[cfg(test)]
mod tests;
mod typing;

pub use expression::Expression;
use expression::Tree;
pub use fault::{Expected, Fault, Found, MAX_DEPTH, MAX_LENGTH, MAX_WIDTH, Remedy};
use function::Function;
pub use grammar::{parse, parse_named};
pub use program::Program;
