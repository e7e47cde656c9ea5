//! The slow f64 evaluator: the references of the nodes, sample by sample. The oracle of everything fast.

use crate::prepare::{Ready, prepare};
use crate::{Cache, EvalError, Plan, PlanError, Settings, Silent, Switches};
use std::collections::HashMap;
use trochoid_graph::{Body, CheckedGraph, NodeId, Reference, References, Source};

/// A frame that can be evaluated in f64 at any pixel.
pub struct ReferenceFrame<'g> {
    plan: Plan<'g>,
    ready: HashMap<NodeId, Ready>,
    needed: Vec<bool>,
}

/// Why a reference cannot be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReferenceError {
    /// The plan cannot be made.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A node fails.
    #[error(transparent)]
    Eval(#[from] EvalError),
}

impl<'g> ReferenceFrame<'g> {
    /// Prepares every node that an output needs at a frame.
    ///
    /// # Errors
    /// As planning and evaluation.
    pub fn new(graph: &'g CheckedGraph, output: &str, frame: i64) -> Result<Self, ReferenceError> {
        let settings = Settings { switches: Switches::NONE, ..Settings::default() };
        let plan = Plan::new(graph, &[output], frame, &[], &settings)?;
        let ready = prepare(&plan, &mut Cache::new(), &Silent)?;
        let needed = graph.upstream([graph.outputs()[plan.outputs[0].index].node]);
        Ok(Self { plan, ready, needed })
    }

    /// The output at a place in the picture, in pixels: pixel x has its center at x + ½.
    ///
    /// # Errors
    /// A node's input data are illegal there.
    pub fn sample(&self, x: f64, y: f64) -> Result<Vec<f64>, EvalError> {
        let graph = self.plan.graph;
        let mut values: Vec<Vec<Reference>> = vec![Vec::new(); graph.nodes().len()];
        for &id in graph.order().iter().filter(|id| self.needed[id.0]) {
            let node = graph.node(id);
            let Some(settled) = &self.plan.settled[id.0] else { continue };
            let outputs = {
                let inputs = |source: &Source<Vec<f64>>| match source {
                    Source::Output { node, output } => values[node.0][*output].clone(),
                    _ => unreachable!("literals are read where they stand"),
                };
                let inputs = References::new(&self.plan.context, [x, y], &inputs);
                match node.ty.body() {
                    Body::Pointwise(pointwise) => vec![pointwise.reference(settled, &inputs)],
                    Body::Stage(_) => match self.ready.get(&id) {
                        Some(ready) => ready.prepared.reference(&inputs).map_err(|error| EvalError::Node {
                            node: node.name.clone(),
                            ty: node.ty.declaration().name.into(),
                            message: error.message,
                        })?,
                        None => Vec::new(),
                    },
                }
            };
            values[id.0] = outputs;
        }
        let spec = &graph.outputs()[self.plan.outputs[0].index];
        Ok(match &values[spec.node.0][spec.output] {
            Reference::Color(color) => color.to_vec(),
            Reference::Mask(t) => vec![*t],
            Reference::Weights(numbers) | Reference::Field(numbers) | Reference::View(numbers) => numbers.clone(),
            Reference::Handle(_) => Vec::new(),
        })
    }

    /// The output at a pixel, averaged over the samples that the fast path averages.
    ///
    /// # Errors
    /// As [`ReferenceFrame::sample`].
    pub fn pixel(&self, x: i64, y: i64) -> Result<Vec<f64>, EvalError> {
        let offsets = &self.plan.passes[0].offsets;
        let mut sum: Vec<f64> = Vec::new();
        for offset in offsets {
            let value = self.sample(x as f64 + offset[0], y as f64 + offset[1])?;
            sum.resize(value.len(), 0.0);
            sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += value);
        }
        Ok(sum.into_iter().map(|sum| sum / offsets.len() as f64).collect())
    }
}

impl std::fmt::Debug for ReferenceFrame<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ReferenceFrame of {}", self.plan.graph.name())
    }
}
