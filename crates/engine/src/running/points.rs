//! Evaluates batches of shading samples, for renderers that shade points instead of images.

use super::buffer_fault::BufferFault;
use crate::{Buffers, EvalError, Plan, PlanError, Settings};
use std::collections::BTreeMap;
use trochoid_graph::{CheckedGraph, Kind, NodeId};
use trochoid_kernel::{Chunks, Machine, Plane};
use trochoid_weights::sums;

/// An output's pointwise program with every front-end node bound to a buffer of the caller.
#[derive(Debug)]
pub struct ShadingPlan<'g> {
    plan: Plan<'g>,
}

/// Number of samples that run through the program at once.
const BATCH: usize = 256;

impl<'g> ShadingPlan<'g> {
    /// Plans an output whose front-end inputs the caller supplies: `bound` names the nodes.
    ///
    /// # Errors
    /// Same as [`Plan::new`]; also if the output needs a node that is neither pointwise nor bound.
    pub fn new(
        graph: &'g CheckedGraph,
        output: &str,
        frame: i64,
        bound: &[&str],
        settings: &Settings,
    ) -> Result<Self, PlanError> {
        let plan = Plan::new(graph, &[output], frame, bound, settings)?;
        let mut fills = plan.passes.iter().flat_map(|pass| &pass.fills);
        if let Some(fill) = fills.find(|fill| !plan.bound[fill.node.0]) {
            let node = graph.node(fill.node);
            return Err(PlanError::Unbound { name: node.name.clone(), ty: node.ty.declaration().name.into() });
        }
        Ok(Self { plan })
    }

    /// Returns the number of channels of the output: 3 for a Color.
    pub fn channels(&self) -> usize {
        self.plan.outputs[0].kind.channels()
    }

    /// Evaluates `count` samples, as a structure of arrays in and out: one slice per channel.
    ///
    /// Single-threaded and reentrant: call it from as many threads as there are batches.
    ///
    /// # Errors
    /// A buffer does not fit its node's kind, or an output slice does not have `count` samples.
    pub fn evaluate(&self, buffers: &Buffers<'_>, count: usize, outputs: &mut [&mut [f32]]) -> Result<(), EvalError> {
        let graph = self.plan.graph;
        let name = &graph.outputs()[self.plan.outputs[0].index].name;
        if outputs.len() != self.channels() || outputs.iter().any(|output| output.len() != count) {
            let reason = BufferFault::Outputs { found: outputs.len(), expected: self.channels(), samples: count };
            return Err(EvalError::Buffer { node: name.clone(), reason });
        }
        let pass = &self.plan.passes[0];
        let mut sources = Vec::with_capacity(pass.program.planes.len());
        for slot in &pass.program.planes {
            let node = graph.node(slot.node);
            let kind: Kind = node.kinds[slot.output];
            if slot.channel == 0 {
                buffers.validate(&node.name, kind, count)?;
                buffers.validate_values(&node.name, kind)?;
            }
            let planes = buffers.get(&node.name).unwrap_or_default();
            sources.push(planes.get(slot.channel).copied().unwrap_or_default());
        }
        // Planes of weights, which are divided by their sum, by node.
        let mut partitions: BTreeMap<NodeId, BTreeMap<usize, usize>> = BTreeMap::new();
        for (index, slot) in pass.program.planes.iter().enumerate() {
            if matches!(graph.node(slot.node).kinds[0], Kind::Weights(n) if n > 2) {
                partitions.entry(slot.node).or_default().insert(slot.channel, index);
            }
        }
        let partitions: Vec<Vec<usize>> =
            partitions.into_values().map(|channels| channels.into_values().collect()).collect();
        let mut chunks = Chunks::of([&pass.program]);
        let mut machine = Machine::new(&pass.program, &mut chunks.all());
        let mut batch = vec![[0.0f32; BATCH]; sources.len()];
        let mut start = 0;
        while start < count {
            let length = BATCH.min(count - start);
            for (batch, source) in batch.iter_mut().zip(&sources) {
                for (to, from) in batch.iter_mut().zip(&source[start..start + length]) {
                    // As for pictures, −0 becomes 0, so that no bit depends on pruning.
                    *to = from + 0.0;
                }
            }
            for channels in &partitions {
                divide(&mut batch, channels, length);
            }
            let planes: Vec<Plane<'_>> =
                batch.iter().map(|batch| Plane { samples: &batch[..length], start: 0, stride: length }).collect();
            machine.tile(&planes, length, 1, &mut |root, channel, _, row| {
                let first = pass.roots[root].1;
                outputs[first + channel][start..start + length].copy_from_slice(row);
            });
            start += length;
        }
        Ok(())
    }
}

/// Divides the weights of a node in a batch, all of which are among `channels`, by their sum.
fn divide(batch: &mut [[f32; BATCH]], channels: &[usize], length: usize) {
    let rows: Vec<&[f32]> = channels.iter().map(|channel| &batch[*channel][..length]).collect();
    let sums = sums::sums(&rows);
    for channel in channels {
        for (weight, sum) in batch[*channel].iter_mut().zip(&sums) {
            *weight = sums::part(*weight, *sum, channels.len()) as f32;
        }
    }
}
