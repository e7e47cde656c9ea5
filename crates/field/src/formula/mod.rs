//! Formulas: their grammar, their value at one sample, and fast evaluation of many samples.

mod expression;
mod fault;
mod function;
mod function_span;
mod grammar;
mod program;
#[cfg(test)]
mod tests;
mod typing;

pub use expression::Expression;
use expression::Tree;
pub use fault::{Expected, Fault, Found, Remedy};
use function::Function;
pub use grammar::{MAX_DEPTH, MAX_LENGTH, parse};
pub use program::Program;
pub use typing::MAX_WIDTH;
