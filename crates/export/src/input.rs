//! Inputs of a shader: the nodes that stand in for what a shader cannot compute.

use crate::{is_value, names};
use trochoid_graph::{CheckedGraph, DocumentPlace, Kind, NodeId, Op, Program, Slot, nearest};

/// Reason that a name is no input.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InputError {
    /// No node has the name.
    #[error("input \"{name}\": found no node of that name; expected a node of the document{}", meant(.near))]
    NoNode {
        /// Name as given.
        name: String,
        /// A node of a similar name.
        near: Option<String>,
    },
    /// A color of the palette or a knob of the document, which a shader has as a constant.
    #[error("input \"{name}\": found a {what}, which a shader cannot take, for it is written into it; expected a node")]
    Constant {
        /// Name as given.
        name: String,
        /// What it is.
        what: &'static str,
    },
    /// The node has no such output.
    #[error("input \"{name}\": found no such output of \"{node}\" (a {ty}); expected one of {known}")]
    NoOutput {
        /// Name as given.
        name: String,
        /// The node.
        node: String,
        /// Its type.
        ty: &'static str,
        /// Outputs that may be inputs, as they are given.
        known: String,
    },
    /// The output is no value at a point.
    #[error("input \"{name}\": found a {kind} of \"{node}\" (a {ty}); expected a Color, a mask, Weights or a Field{}", or(.known))]
    NoValue {
        /// Name as given.
        name: String,
        /// The node.
        node: String,
        /// Its type.
        ty: &'static str,
        /// Kind of the output.
        kind: Kind,
        /// Outputs that may be inputs, as they are given; empty if there are none.
        known: String,
    },
    /// The name was given before.
    #[error("input \"{name}\": found it twice; expected each input once: leave one out")]
    Twice {
        /// Name as given.
        name: String,
    },
}

fn meant(near: &Option<String>) -> String {
    near.as_ref().map_or(String::new(), |near| format!(": did you mean {near}?"))
}

fn or(known: &str) -> String {
    if known.is_empty() { ": name what is made of it".into() } else { format!(": name {known}") }
}

/// A node that a shader cannot compute, on which an exported output depends.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{place}: node \"{node}\" ({ty}): found a node that computes a {kind} from more than the values at one point; expected a \
     pointwise node, or an input of the shader"
)]
pub struct Unbound {
    /// Place of the node in the document.
    pub place: DocumentPlace,
    /// The node.
    pub node: String,
    /// Its type.
    pub ty: &'static str,
    /// Kind of the value that it would supply.
    pub kind: Kind,
    /// Name by which it can be made an input.
    pub input: String,
}

/// One number or color that a shader takes.
#[derive(Clone, Debug)]
pub(crate) struct Parameter {
    /// Name in the shader.
    pub(crate) identifier: String,
    pub(crate) is_color: bool,
    /// Whether it is a mask or one of several weights, and so from 0 to 1.
    pub(crate) is_weight: bool,
    /// What it is, in plain ASCII.
    pub(crate) help: String,
}

/// A bound output.
#[derive(Clone, Debug)]
pub(crate) struct Input {
    node: NodeId,
    output: usize,
    /// Name as given.
    name: String,
    /// One for a color, else one for each channel.
    pub(crate) parameters: Vec<Parameter>,
}

/// All inputs of a shader, in their order.
#[derive(Clone, Debug)]
pub(crate) struct Inputs {
    all: Vec<Input>,
}

impl Inputs {
    /// Finds the inputs with these names; none of them gets the name of the function or of one of its results.
    pub(crate) fn new(
        graph: &CheckedGraph,
        names: &[&str],
        function: &str,
        results: &[String],
    ) -> Result<Self, Vec<InputError>> {
        let (mut all, mut faults): (Vec<Input>, Vec<InputError>) = (Vec::new(), Vec::new());
        let mut taken = names::Taken::new(function, results);
        for name in names {
            match find(graph, name) {
                Ok((node, output)) if all.iter().any(|known| (known.node, known.output) == (node, output)) => {
                    faults.push(InputError::Twice { name: (*name).into() });
                }
                Ok((node, output)) => {
                    let parameters = parameters(graph, name, node, output, &mut taken);
                    all.push(Input { node, output, name: (*name).into(), parameters });
                }
                Err(fault) => faults.push(fault),
            }
        }
        if faults.is_empty() { Ok(Self { all }) } else { Err(faults) }
    }

    /// Returns the nodes of the inputs.
    pub(crate) fn nodes(&self) -> Vec<NodeId> {
        self.all.iter().map(|input| input.node).collect()
    }

    /// Returns everything that the shader takes.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = &Parameter> {
        self.all.iter().flat_map(|input| &input.parameters)
    }

    /// Returns the names of everything that the shader takes.
    pub(crate) fn identifiers(&self) -> impl Iterator<Item = &str> {
        self.parameters().map(|parameter| parameter.identifier.as_str())
    }

    fn of(&self, slot: &Slot) -> Option<&Input> {
        self.all.iter().find(|input| (input.node, input.output) == (slot.node, slot.output))
    }

    /// Returns what is passed for a slot of the program.
    pub(crate) fn parameter(&self, slot: &Slot) -> &Parameter {
        match self.of(slot) {
            Some(input) => &input.parameters[slot.channel],
            None => unreachable!("checked by `missing`"),
        }
    }

    /// Returns the nodes that a program loads and that are no inputs, in the order of the document.
    pub(crate) fn missing(&self, graph: &CheckedGraph, program: &Program) -> Vec<Unbound> {
        let mut slots: Vec<Slot> = loads(program).filter(|slot| self.of(slot).is_none()).collect();
        slots.sort_unstable();
        slots.dedup_by_key(|slot| (slot.node, slot.output));
        let unbound = |slot: Slot| {
            let node = graph.node(slot.node);
            let (ty, kind) = (node.ty.declaration(), kind(node.kinds[slot.output]));
            let input = match slot.output {
                0 => node.name.clone(),
                output => format!("{}.{}", node.name, ty.outputs[output].name),
            };
            Unbound { place: node.place.clone(), node: node.name.clone(), ty: ty.name, kind, input }
        };
        slots.into_iter().map(unbound).collect()
    }

    /// Returns the names of the inputs that a program does not load.
    pub(crate) fn unread(&self, program: &Program) -> Vec<String> {
        let is_read = |input: &Input| loads(program).any(|slot| (slot.node, slot.output) == (input.node, input.output));
        self.all.iter().filter(|input| !is_read(input)).map(|input| input.name.clone()).collect()
    }
}

fn loads(program: &Program) -> impl Iterator<Item = Slot> {
    program.ops().iter().filter_map(|(op, _)| match op {
        Op::Load(slot) | Op::LoadColor(slot) => Some(*slot),
        _ => None,
    })
}

/// Returns a kind as a shader takes it: colors of graphs with recipes have layers, of which the first is the color.
fn kind(kind: Kind) -> Kind {
    if matches!(kind, Kind::Layers(_)) { Kind::Color } else { kind }
}

/// Finds the output that a name means.
fn find(graph: &CheckedGraph, name: &str) -> Result<(NodeId, usize), InputError> {
    let (id, asked) = match graph.find(name) {
        Some(id) => (id, None),
        None => {
            let parts = name.rsplit_once('.').and_then(|(node, output)| Some((graph.find(node)?, Some(output))));
            parts.ok_or_else(|| {
                let constants = [("palette.", "color of the palette"), ("knobs.", "knob of the document")];
                if let Some((_, what)) = constants.into_iter().find(|(prefix, _)| name.starts_with(prefix)) {
                    return InputError::Constant { name: name.into(), what };
                }
                let near = nearest(name, graph.nodes().iter().map(|node| node.name.as_str())).map(String::from);
                InputError::NoNode { name: name.into(), near }
            })?
        }
    };
    let node = graph.node(id);
    let (ty, outputs) = (node.ty.declaration().name, node.ty.declaration().outputs);
    let is_valued = |index: &usize| node.kinds.get(*index).is_some_and(|of| is_value(kind(*of)));
    let known = (0..outputs.len()).filter(is_valued).map(|index| match index {
        0 => node.name.clone(),
        index => format!("{}.{}", node.name, outputs[index].name),
    });
    let known = known.collect::<Vec<_>>().join(" or ");
    let found = match asked {
        None => Some(0),
        Some(asked) => outputs.iter().position(|output| output.name == asked),
    };
    let Some(output) = found.filter(|output| *output < node.kinds.len()) else {
        return Err(InputError::NoOutput { name: name.into(), node: node.name.clone(), ty, known });
    };
    if is_valued(&output) {
        return Ok((id, output));
    }
    Err(InputError::NoValue { name: name.into(), node: node.name.clone(), ty, kind: node.kinds[output], known })
}

/// Makes what a shader takes for an output.
fn parameters(graph: &CheckedGraph, name: &str, id: NodeId, output: usize, taken: &mut names::Taken) -> Vec<Parameter> {
    let node = graph.node(id);
    let of = format!("\"{}\" (a {})", name.escape_default(), node.ty.declaration().name);
    let part = |ending: String, is_color: bool, is_weight: bool, help: String, taken: &mut names::Taken| Parameter {
        identifier: taken.take(&format!("{name}{ending}")),
        is_color,
        is_weight,
        help,
    };
    match kind(node.kinds[output]) {
        Kind::Color => vec![part(String::new(), true, false, format!("the color {of}, at least 0"), taken)],
        Kind::MASK => {
            vec![part(String::new(), false, true, format!("the mask {of}, from 0 to 1, and clamped to that"), taken)]
        }
        Kind::Weights(n) => (0..n)
            .map(|i| {
                let help = format!("weight {i} of the {n} of {of}, from 0 to 1; all are divided by their sum");
                part(format!("_{i}"), false, true, help, taken)
            })
            .collect(),
        Kind::Field(1) => vec![part(String::new(), false, false, format!("the field {of}"), taken)],
        kind => {
            let letter = |i: usize| ["x", "y", "z", "w"].get(i).map_or(i.to_string(), |letter| (*letter).into());
            let help = |i: usize| format!("component {} of the field {of}", letter(i));
            (0..kind.channels()).map(|i| part(format!("_{}", letter(i)), false, false, help(i), taken)).collect()
        }
    }
}
