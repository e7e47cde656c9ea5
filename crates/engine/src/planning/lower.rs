//! Lowers checked nodes to one pointwise program and the stages around it.

use trochoid_graph::{Builder, CheckedGraph, Key, Lowering, NodeId, Program, Settled, Source, Value, load};

/// All pointwise nodes as one program, with the value of every node output.
pub(crate) struct LoweredGraph {
    pub(crate) program: Program,
    /// Values by node and output; `None` for handles, views, and nodes that are not needed.
    pub(crate) values: Vec<Vec<Option<Value>>>,
    /// Knobs at the frame; `None` for nodes that are not needed.
    pub(crate) settled: Vec<Option<Settled>>,
    /// Node that computes in a node's place: the first with the same content key, or the node itself.
    pub(crate) stands_in: Vec<NodeId>,
}

/// Lowers the nodes that have their knobs in `settled`. A node in `bound` is filled from outside and needs no inputs.
///
/// `keys` are content keys: nodes with equal keys are computed once; an empty slice computes every node. Content keys
/// do not include what is bound, so nodes that depend on a bound node are never merged.
pub(crate) fn lower(
    graph: &CheckedGraph,
    mut settled: Vec<Option<Settled>>,
    bound: &[bool],
    keys: &[Key],
) -> LoweredGraph {
    let count = graph.nodes().len();
    let mut lowered = LoweredGraph {
        program: Program::default(),
        values: vec![Vec::new(); count],
        settled: Vec::new(),
        stands_in: (0..count).map(NodeId).collect(),
    };
    let mut first_of = std::collections::HashMap::new();
    let mut apart = bound.to_vec();
    for &id in graph.order() {
        let Some(settled) = &mut settled[id.0] else { continue };
        let node = graph.node(id);
        node.record.each_node(|input| apart[id.0] |= apart[input.0]);
        if let Some(key) = keys.get(id.0).filter(|_| !apart[id.0]) {
            lowered.stands_in[id.0] = *first_of.entry(*key).or_insert(id);
        }
        settled.redirect(&|node| lowered.stands_in[node.0]);
        if lowered.stands_in[id.0] != id {
            lowered.values[id.0] = lowered.values[lowered.stands_in[id.0].0].clone();
            continue;
        }
        let values = match settled.pointwise() {
            Some(pointwise) if !bound[id.0] => {
                let values = &lowered.values;
                let inputs = |source: &Source<Vec<f64>>| match source {
                    Source::Output { node, output } => match &values[node.0][*output] {
                        Some(value) => value.clone(),
                        None => unreachable!("checked to be an image"),
                    },
                    _ => unreachable!("literals are lowered where they stand"),
                };
                let mut lowering = Lowering::new(Builder::new(&mut lowered.program, id), &inputs);
                vec![Some(pointwise.lower(&mut lowering))]
            }
            _ => node
                .kinds
                .iter()
                .enumerate()
                .map(|(output, kind)| load(&mut lowered.program, id, output, *kind))
                .collect(),
        };
        lowered.values[id.0] = values;
    }
    LoweredGraph { settled, ..lowered }
}

/// Returns the program positions that hold a value's channels, in the order of its kind's planes. Appends the
/// operations that make weights explicit.
pub(crate) fn positions(program: &mut Program, origin: NodeId, value: &Value) -> Vec<u32> {
    match value {
        Value::Color(color) => vec![color.0],
        Value::Field(components) => components.iter().map(|component| component.0).collect(),
        Value::Weights(weights) if weights.ways() == 2 => {
            vec![Builder::new(program, origin).weight(weights, 1).field().0]
        }
        Value::Weights(weights) => {
            (0..weights.ways()).map(|i| Builder::new(program, origin).weight(weights, i).field().0).collect()
        }
    }
}
