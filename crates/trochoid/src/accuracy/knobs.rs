//! Knobs that control the accuracy of nodes.

use trochoid_graph::{CheckedGraph, Item, Knob, KnobType, NodeId};

/// Knob of a node that chooses among methods with the same reference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AccuracyKnob {
    /// Node with the knob.
    pub node: NodeId,
    /// Name of the node.
    pub name: String,
    /// Name of the knob.
    pub knob: &'static str,
    /// Words that the knob accepts, from the coarsest to the most accurate method.
    pub words: &'static [&'static str],
}

impl AccuracyKnob {
    /// Returns the assignment `NODE.KNOB=VALUE` of one of its words.
    pub fn assignment(&self, level: usize) -> String {
        format!("{}.{}={}", self.name, self.knob, self.words[level])
    }
}

/// Returns the accuracy knobs of all nodes that these outputs need at a frame, in document order.
pub(super) fn find(graph: &CheckedGraph, outputs: &[&str], frame: i64) -> Vec<AccuracyKnob> {
    let of = reached(graph, outputs, frame).flat_map(|id| {
        let node = graph.node(id);
        node.ty.declaration().items.iter().filter_map(move |item| match item {
            Item::Knob(Knob { name: knob, takes: KnobType::Choice(words), accuracy: true, .. }) => {
                Some(AccuracyKnob { node: id, name: node.name.clone(), knob, words })
            }
            _ => None,
        })
    });
    of.collect()
}

/// Returns the wanted number knobs of all nodes that these outputs need at a frame.
pub(super) fn numbers(
    graph: &CheckedGraph,
    outputs: &[&str],
    frame: i64,
    wanted: impl Fn(&Knob) -> bool,
) -> Vec<Number> {
    let mut numbers = Vec::new();
    for node in reached(graph, outputs, frame) {
        let settled = graph.settle(node, frame);
        let node = graph.node(node);
        let items = node.ty.declaration().items.iter();
        numbers.extend(items.filter_map(|item| Number::of(&node.name, item, |knob| settled.number(knob), &wanted)));
    }
    numbers
}

/// Returns the nodes that these outputs need at a frame; those of all outputs if none is named.
fn reached(graph: &CheckedGraph, outputs: &[&str], frame: i64) -> impl Iterator<Item = NodeId> {
    let named = graph.outputs().iter().filter(|output| outputs.is_empty() || outputs.contains(&output.name.as_str()));
    let reached = graph.dependencies(named.map(|output| output.node), frame);
    (0..graph.nodes().len()).filter(move |id| reached[*id]).map(NodeId)
}

/// Raises the accuracy of the pass that limits a picture to the next word, or of all passes upstream of it; `false` if
/// there are no further words.
pub(super) fn raise(
    knobs: &[AccuracyKnob],
    levels: &mut [usize],
    graph: &CheckedGraph,
    limiting: Option<NodeId>,
    frame: i64,
) -> bool {
    let open = |index: usize, levels: &[usize]| levels[index] + 1 < knobs[index].words.len();
    let own = (0..knobs.len()).filter(|index| Some(knobs[*index].node) == limiting && open(*index, levels));
    let own: Vec<usize> = own.collect();
    let chosen = if own.is_empty() {
        let seen = limiting.map(|limiting| graph.dependencies([limiting], frame));
        let sees = |index: &usize| seen.as_ref().is_none_or(|seen| seen[knobs[*index].node.0]);
        (0..knobs.len()).filter(|index| sees(index) && open(*index, levels)).collect()
    } else {
        own
    };
    chosen.iter().for_each(|index| levels[*index] += 1);
    !chosen.is_empty()
}

/// Number knob of a node.
pub(super) struct Number {
    node: String,
    knob: &'static str,
    /// Value in the document.
    at: f64,
    takes: KnobType,
}

impl Number {
    fn of(node: &str, item: &Item, at: impl Fn(&str) -> f64, wanted: &dyn Fn(&Knob) -> bool) -> Option<Self> {
        match item {
            Item::Knob(knob @ Knob { takes: KnobType::Number { .. } | KnobType::Integer { .. }, .. })
                if wanted(knob) =>
            {
                Some(Self { node: node.to_owned(), knob: knob.name, at: at(knob.name), takes: knob.takes })
            }
            _ => None,
        }
    }

    pub(super) fn path(&self) -> String {
        format!("{}.{}", self.node, self.knob)
    }

    /// Returns a multiple of the value, clamped to the knob's range.
    pub(super) fn value(&self, factor: f64) -> f64 {
        match self.takes {
            KnobType::Number { min, max } => (self.at * factor).clamp(min, max),
            KnobType::Integer { min, max } => (self.at * factor).round().clamp(min as f64, max as f64),
            _ => self.at,
        }
    }

    pub(super) fn assignment(&self, factor: f64) -> String {
        format!("{}={}", self.path(), self.value(factor))
    }
}
