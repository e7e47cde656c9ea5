//! Looks: an output of a graph whose passes come from another renderer.
//!
//! A [`Look`] is planned once and shared by all threads. Renderers that shade points take a [`Shader`] for each thread,
//! which runs batches without allocating; a [`Batch`] says where a batch's samples are, and [`Samples`] are those of
//! slices with strides. Renderers that make images hand them to [`Look::picture`].

mod batch;
mod error;
mod illegal;
mod picture;
mod points;
mod samples;
mod shader;

pub use batch::Batch;
pub use error::{NotPointwise, ShadeError};
pub use picture::PictureError;
pub use samples::{Samples, SamplesMut};
pub use shader::Shader;

use crate::{Plan, PlanError, Settings};
use points::Points;
use std::sync::Arc;
use trochoid_graph::{CheckedGraph, Kind};

/// An input of a look, for which the caller supplies samples.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Slot {
    /// Name of the node that is bound.
    pub name: String,
    /// Kind of its first output, which decides the channels and which samples are legal: finite numbers ≥ 0 in a Color,
    /// numbers in [0, 1] in a mask, weights in [0, 1] that sum to 1 within 0.001 in Weights, anything but NaN in a Field.
    pub kind: Kind,
    /// Index of its first channel among the inputs of a batch.
    pub first: usize,
    /// Whether the output depends on it. What it does not depend on is never read.
    pub is_used: bool,
}

impl Slot {
    /// Returns the number of channels: 3 for a Color, 1 for a mask, n for Weights(n) and for a Field of n components.
    pub fn channels(&self) -> usize {
        self.kind.channels()
    }

    /// Whether an input of a batch, counted over all slots, is one of its channels.
    pub fn has(&self, input: usize) -> bool {
        (self.first..self.first + self.channels()).contains(&input)
    }
}

/// What happens to illegal samples of inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Illegal {
    /// The batch or picture is refused, with the slot and the sample.
    #[default]
    Refuse,
    /// They become the nearest legal number, and NaN becomes 0. Weights are divided by their sum whatever it is; if all are
    /// 0, they become equal.
    Clamp,
}

/// One output of a checked graph at one frame, with inputs of the caller. Cheap to clone, and shared by any threads.
#[derive(Clone, Debug)]
pub struct Look {
    inner: Arc<Inner>,
    illegal: Illegal,
}

#[derive(Debug)]
struct Inner {
    graph: CheckedGraph,
    settings: Settings,
    output: String,
    kind: Kind,
    frame: i64,
    slots: Vec<Slot>,
    /// The program over single samples, or the nodes that need a picture.
    points: Result<Points, NotPointwise>,
}

impl Look {
    /// Makes a look of an output, whose inputs are the nodes named by `bound`, in this order. The graph may have any
    /// format: single samples have none, and pictures get their own.
    ///
    /// # Errors
    /// As [`Plan::new`].
    pub fn new(
        graph: CheckedGraph,
        output: &str,
        frame: i64,
        bound: &[&str],
        settings: &Settings,
    ) -> Result<Self, PlanError> {
        let mut settings = settings.clone();
        settings.region = None;
        let plan_with = |merge: bool| {
            let mut settings = settings.clone();
            // A sample has no row and no column.
            settings.switches.hoist = false;
            // Nor does a batch have a report.
            settings.audits = false;
            settings.switches.merge &= merge;
            Plan::new(&graph, &[output], frame, bound, &settings)
        };
        let plan = plan_with(true)?;
        let mut slots: Vec<Slot> = Vec::with_capacity(bound.len());
        let mut first = 0;
        for name in bound {
            // The plan has found all of them.
            let Some(id) = graph.find(name) else { continue };
            let kind = graph.node(id).kinds[0];
            let is_used = plan.passes.iter().flat_map(|pass| &pass.fills).any(|fill| fill.node == id);
            slots.push(Slot { name: (*name).into(), kind, first, is_used });
            first += kind.channels();
        }
        let points = match Points::new(&plan, &slots) {
            // Equal nodes are planned as one, but each of them has to be an input.
            Err(_) => Points::new(&plan_with(false)?, &slots),
            points => points,
        };
        let kind = plan.outputs[0].kind;
        drop(plan);
        let inner = Inner { graph, settings, output: output.into(), kind, frame, slots, points };
        Ok(Self { inner: Arc::new(inner), illegal: Illegal::Refuse })
    }

    /// Sets what happens to illegal samples; at first, they are refused.
    #[must_use]
    pub fn with_illegal(self, illegal: Illegal) -> Self {
        Self { illegal, ..self }
    }

    /// Returns the graph.
    pub fn graph(&self) -> &CheckedGraph {
        &self.inner.graph
    }

    /// Returns the name of the output.
    pub fn output(&self) -> &str {
        &self.inner.output
    }

    /// Returns the frame.
    pub fn frame(&self) -> i64 {
        self.inner.frame
    }

    /// Returns the kind of the output.
    pub fn kind(&self) -> Kind {
        self.inner.kind
    }

    /// Returns the number of channels of the output: 3 for a Color.
    pub fn channels(&self) -> usize {
        self.inner.kind.channels()
    }

    /// Returns the inputs, in the order in which they were named.
    pub fn slots(&self) -> &[Slot] {
        &self.inner.slots
    }

    /// Returns the input with a name.
    pub fn slot(&self, name: &str) -> Option<&Slot> {
        self.slots().iter().find(|slot| slot.name == name)
    }

    /// Returns the number of channels of all inputs together.
    pub fn inputs(&self) -> usize {
        self.slots().iter().map(Slot::channels).sum()
    }

    /// Returns what one thread needs to shade samples.
    ///
    /// # Errors
    /// The output needs nodes that are neither bound nor pointwise, such as a Blur or a Render.
    pub fn shader(&self) -> Result<Shader, NotPointwise> {
        self.inner.points.as_ref().map_err(NotPointwise::clone)?;
        Ok(Shader::new(self.clone()))
    }
}
