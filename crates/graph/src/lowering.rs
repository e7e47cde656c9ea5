//! Lowering: access of pointwise nodes to their inputs and to the builder.

use crate::{Builder, Source, Value};

/// Arguments of [`Pointwise::lower`](crate::Pointwise::lower).
pub struct Lowering<'a> {
    /// Builder that appends operations.
    pub build: Builder<'a>,
    inputs: &'a dyn Fn(&Source<Vec<f64>>) -> Value,
}

impl<'a> Lowering<'a> {
    /// Makes the arguments; called by the engine. `inputs` returns the values of everything connected to the node.
    pub fn new(build: Builder<'a>, inputs: &'a dyn Fn(&Source<Vec<f64>>) -> Value) -> Self {
        Self { build, inputs }
    }

    /// Returns a connected or literal value of any kind; a literal number counts as a mask.
    pub fn value(&mut self, source: &Source<Vec<f64>>) -> Value {
        match source {
            Source::Output { .. } => (self.inputs)(source),
            Source::Number(_) => Value::Weights(crate::Weights::mask(self.mask(source))),
            Source::Color(_) => Value::Color(self.color(source)),
            Source::Numbers(_) => Value::Weights(self.weights(source)),
        }
    }

    /// Returns a connected or literal color.
    pub fn color(&mut self, source: &Source<Vec<f64>>) -> crate::Color {
        if let Some([r, g, b]) = source.color() {
            return self.build.control([r, g, b]);
        }
        match (self.inputs)(source) {
            Value::Color(color) => color,
            other => unreachable!("checked to be a Color: {other:?}"),
        }
    }

    /// Returns a connected or literal mask.
    pub fn mask(&mut self, source: &Source<Vec<f64>>) -> crate::Mask {
        if let Some(number) = source.number() {
            return self.build.constant_mask(number);
        }
        match (self.inputs)(source) {
            Value::Weights(weights) if weights.ways() == 2 => self.build.weight(&weights, 1),
            other => unreachable!("checked to be a mask: {other:?}"),
        }
    }

    /// Returns a connected or literal field of one component; a mask is converted to a field.
    pub fn scalar(&mut self, source: &Source<Vec<f64>>) -> crate::Scalar {
        if let Some(number) = source.number() {
            return self.build.constant(number);
        }
        match (self.inputs)(source) {
            Value::Field(components) if components.len() == 1 => components[0],
            Value::Weights(weights) if weights.ways() == 2 => self.build.weight(&weights, 1).field(),
            other => unreachable!("checked to be one number: {other:?}"),
        }
    }

    /// Returns connected or literal weights.
    pub fn weights(&mut self, source: &Source<Vec<f64>>) -> crate::Weights {
        if let Source::Numbers(numbers) = source {
            return self.build.literal_weights(numbers);
        }
        match (self.inputs)(source) {
            Value::Weights(weights) => weights,
            other => unreachable!("checked to be Weights: {other:?}"),
        }
    }
}
