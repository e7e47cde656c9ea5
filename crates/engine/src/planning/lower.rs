//! Lowers checked nodes to one pointwise program and the stages around it.

use trochoid_graph::{
    Builder, CheckedGraph, Key, Kind, Lowering, NodeId, OutputSpec, Pointwise, Program, Settled, Slot, Source, Value,
    load, load_color,
};

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
            Some(pointwise) if !bound[id.0] => vec![Some(match node.kinds[..] {
                [Kind::Layers(layers)] => lowered.layers(graph, id, layers, |lowered, layer| {
                    let settled = settled.of_layer(layer);
                    settled.pointwise().map(|pointwise| lowered.value(pointwise, id, layer))
                }),
                _ => lowered.value(pointwise, id, 0),
            })],
            _ => node.kinds.iter().enumerate().map(|(output, kind)| lowered.filled(graph, id, output, *kind)).collect(),
        };
        lowered.values[id.0] = values;
    }
    LoweredGraph { settled, ..lowered }
}

impl LoweredGraph {
    /// Lowers a pointwise node, of whose inputs it takes one layer.
    fn value(&mut self, pointwise: &dyn Pointwise, id: NodeId, layer: usize) -> Value {
        let values = &self.values;
        let inputs = |source: &Source<Vec<f64>>| match source {
            Source::Output { node, output } => match &values[node.0][*output] {
                Some(Value::Layers(colors)) => Value::Color(colors[layer]),
                Some(value) => value.clone(),
                None => unreachable!("checked to be an image"),
            },
            _ => unreachable!("literals are lowered where they stand"),
        };
        pointwise.lower(&mut Lowering::new(Builder::new(&mut self.program, id), &inputs))
    }

    /// Loads an output that is filled outside of the program. In a graph with recipes, an image has layers, too.
    fn filled(&mut self, graph: &CheckedGraph, id: NodeId, output: usize, kind: Kind) -> Option<Value> {
        match (kind, graph.recipes()) {
            (Kind::Layers(layers), _) => Some(self.layers(graph, id, layers, |lowered, layer| {
                let slot = Slot { node: id, output, channel: 3 * layer };
                Some(Value::Color(load_color(&mut lowered.program, slot)))
            })),
            (Kind::Color, Some(recipes)) => Some(self.layers(graph, id, recipes.layers(), |lowered, layer| {
                Some(match recipes.layer_of_image(layer) {
                    Some(color) => Value::Color(Builder::new(&mut lowered.program, id).control(color)),
                    None => load(&mut lowered.program, id, output, kind)?,
                })
            })),
            _ => load(&mut self.program, id, output, kind),
        }
    }

    /// Makes a color of its layers; those that no control reaches are black.
    fn layers(
        &mut self,
        graph: &CheckedGraph,
        id: NodeId,
        layers: usize,
        made: impl Fn(&mut Self, usize) -> Option<Value>,
    ) -> Value {
        let is_reached = |layer: &usize| graph.recipes().is_some_and(|recipes| recipes.is_reached(id, *layer));
        let color = |layer: usize| match Some(layer).filter(is_reached).and_then(|layer| made(self, layer)) {
            Some(Value::Color(color)) => color,
            _ => Builder::new(&mut self.program, id).control([0.0; 3]),
        };
        Value::Layers((0..layers).map(color).collect())
    }
}

/// Returns the program positions that hold the channels of an output of the plan: of a color only the layer of the color
/// itself, of a recipe the others.
pub(crate) fn roots(program: &mut Program, spec: &OutputSpec, value: &Value) -> Vec<u32> {
    let mut all = positions(program, spec.node, value);
    match (value, spec.kind) {
        (Value::Layers(_), Kind::Color) => all.truncate(1),
        (Value::Layers(_), _) => drop(all.drain(..1)),
        _ => {}
    }
    all
}

/// Returns the program positions that hold a value's channels, in the order of its kind's planes. Appends the
/// operations that make weights explicit.
pub(crate) fn positions(program: &mut Program, origin: NodeId, value: &Value) -> Vec<u32> {
    match value {
        Value::Color(color) => vec![color.0],
        Value::Layers(colors) => colors.iter().map(|color| color.0).collect(),
        Value::Field(components) => components.iter().map(|component| component.0).collect(),
        Value::Weights(weights) if weights.ways() == 2 => {
            vec![Builder::new(program, origin).weight(weights, 1).field().0]
        }
        Value::Weights(weights) => {
            (0..weights.ways()).map(|i| Builder::new(program, origin).weight(weights, i).field().0).collect()
        }
    }
}
