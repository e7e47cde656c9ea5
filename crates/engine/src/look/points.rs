//! The program of a look over single samples.

use super::Slot;
use crate::{Plan, PlanError};
use std::collections::BTreeMap;
use trochoid_graph::{Kind, NodeId};
use trochoid_kernel::CompiledProgram;

/// An output as a program over samples, and where its planes come from and go to.
#[derive(Debug)]
pub(super) struct Points {
    pub(super) program: CompiledProgram,
    /// Input channel of each plane, and the kind of its slot.
    pub(super) inputs: Vec<(usize, Kind)>,
    /// Output channel of each channel of the program.
    pub(super) outputs: Vec<usize>,
    /// Planes of weights, which are divided by their sum, by slot.
    pub(super) partitions: Vec<(usize, Vec<usize>)>,
}

impl Points {
    /// Takes the program of a plan that computes nothing apart from its pixels.
    pub(super) fn new(plan: &Plan<'_>, slots: &[Slot]) -> Result<Self, PlanError> {
        let graph = plan.graph;
        let mut fills = plan.passes.iter().flat_map(|pass| &pass.fills);
        if let Some(fill) = fills.find(|fill| !plan.bound[fill.node.0]) {
            let node = graph.node(fill.node);
            return Err(PlanError::Unbound { name: node.name.clone(), ty: node.ty.declaration().name.into() });
        }
        let pass = &plan.passes[0];
        let slot_of = |node: NodeId| {
            let name = &graph.node(node).name;
            slots.iter().position(|slot| slot.name == *name).unwrap_or_else(|| unreachable!("only slots are filled"))
        };
        let mut inputs = Vec::with_capacity(pass.program.planes.len());
        let mut partitions: BTreeMap<usize, BTreeMap<usize, usize>> = BTreeMap::new();
        for (index, plane) in pass.program.planes.iter().enumerate() {
            let number = slot_of(plane.node);
            let slot = &slots[number];
            inputs.push((slot.first + plane.channel, slot.kind));
            if matches!(slot.kind, Kind::Weights(n) if n > 2) {
                partitions.entry(number).or_default().insert(plane.channel, index);
            }
        }
        let roots = pass.roots.iter().zip(&pass.program.roots);
        let outputs = roots.flat_map(|((_, first), count)| *first..first + count).collect();
        let partitions = partitions.into_iter().map(|(slot, planes)| (slot, planes.into_values().collect())).collect();
        let program = pass.program.clone();
        program.make_ready();
        Ok(Self { program, inputs, outputs, partitions })
    }

    /// Whether the program reads an input channel.
    pub(super) fn reads(&self, channel: usize) -> bool {
        self.inputs.iter().any(|(input, _)| *input == channel)
    }
}
