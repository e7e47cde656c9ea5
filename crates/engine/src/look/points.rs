//! The program of a look over single samples.

use super::Slot;
use super::error::NotPointwise;
use crate::Plan;
use std::collections::BTreeMap;
use trochoid_graph::{Diagnostic, Kind, NodeId, Severity};
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
    pub(super) fn new(plan: &Plan<'_>, slots: &[Slot]) -> Result<Self, NotPointwise> {
        let graph = plan.graph;
        let faults = in_the_way(plan);
        if !faults.is_empty() {
            return Err(NotPointwise { faults });
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

/// Returns a fault for each node whose planes the pixels are computed from, and which is no input. What these nodes need
/// themselves is not needed once they are inputs.
fn in_the_way(plan: &Plan<'_>) -> Vec<Diagnostic> {
    let graph = plan.graph;
    let read = plan.passes.iter().flat_map(|pass| &pass.program.planes).filter(|plane| !plan.bound[plane.node.0]);
    let mut nodes: BTreeMap<NodeId, bool> = BTreeMap::new();
    for plane in read {
        *nodes.entry(plane.node).or_insert(true) &= plane.output == 0;
    }
    let fault = |(id, is_first): (NodeId, bool)| {
        let node = graph.node(id);
        let place = &node.place;
        let way = if is_first { format!("bind \"{}\"", node.name) } else { "bind the nodes that take it".into() };
        Diagnostic {
            severity: Severity::Error,
            file: place.document.to_string(),
            is_assigned: false,
            line: place.line,
            column: place.column,
            node: Some(node.name.clone()),
            port: None,
            found: format!("a {}, which needs more than one sample of what it takes", node.ty.declaration().name),
            expected: format!(
                "pointwise nodes and inputs alone on the way to \"{}\"",
                graph.outputs()[plan.outputs[0].index].name
            ),
            remedy: format!("{way} as an input, or make a picture"),
            means: None,
            used: None,
        }
    };
    nodes.into_iter().map(fault).collect()
}
