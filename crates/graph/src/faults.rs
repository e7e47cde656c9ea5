//! Faults and warnings from the nodes' own checks, and the view of the graph that those checks have.

use crate::{Declaration, ItemName, Kind, Offer, Registry, Settled, Source};

/// Collects the faults and warnings that [`Node::check`](crate::Node::check) reports.
pub struct Check<'a> {
    around: &'a dyn GraphContext,
    faults: Vec<Fault>,
}

/// The graph around the node that is being checked.
pub trait GraphContext {
    /// Returns the kind of a connection or literal, if known.
    fn kind(&self, source: &Source<Vec<f64>>) -> Option<Kind>;

    /// Returns the node that a connection comes from, at the current frame; `None` if it has faults.
    fn upstream(&self, source: &Source<Vec<f64>>) -> Option<Upstream>;

    /// Returns the ports that the node's outputs are connected to.
    fn consumers(&self) -> Vec<Consumer>;

    /// Returns all node types.
    fn registry(&self) -> &Registry;
}

/// Returns names of node types in words, such as "a Mesh, Render or Sky"; "another node" if there is none.
pub fn one_of(types: impl Iterator<Item = &'static Declaration>) -> String {
    let names: Vec<&str> = types.map(|declaration| declaration.name).collect();
    match names.as_slice() {
        [] => "another node".into(),
        [name] => format!("a {name}"),
        [names @ .., last] => format!("a {} or {last}", names.join(", ")),
    }
}

/// A node at the start of a connection.
#[derive(Clone)]
pub struct Upstream {
    /// Name in the document.
    pub name: String,
    /// Ports and knobs.
    pub node: Settled,
}

impl Upstream {
    /// Returns the name of the node type.
    pub fn ty(&self) -> &'static str {
        self.node.ty().declaration().name
    }

    /// Whether the outputs have a property beyond their kind.
    pub fn offers(&self, what: Offer) -> bool {
        self.node.ty().declaration().offers.contains(&what)
    }
}

/// A port that takes an output, or a view of that output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Consumer {
    /// Properties that the port uses beyond the kind.
    pub wants: &'static [Offer],
}

/// A fault or warning within one node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Port or knob.
    pub item: ItemName,
    /// Description of the value or situation that was found.
    pub found: String,
    /// Description of what is legal.
    pub expected: String,
    /// Remedy: an instruction to the user.
    pub remedy: String,
    /// Whether this is only a warning.
    pub warning: bool,
}

impl<'a> Check<'a> {
    /// Makes an empty collection; called by validation.
    pub fn new(around: &'a dyn GraphContext) -> Self {
        Self { around, faults: Vec::new() }
    }

    /// Returns the kind of a connection or literal, if known.
    pub fn kind(&self, source: &Source<Vec<f64>>) -> Option<Kind> {
        self.around.kind(source)
    }

    /// Returns all node types.
    pub fn types(&self) -> impl Iterator<Item = &'static Declaration> {
        self.around.registry().iter().map(|ty| ty.declaration())
    }

    /// Returns the names of the node types that offer something, as in "a Mesh, Render or Sky".
    pub fn offering(&self, what: Offer) -> String {
        one_of(self.types().filter(|declaration| declaration.offers.contains(&what)))
    }

    /// Returns the node that a connection comes from; `None` if it has faults of its own.
    pub fn upstream(&self, source: &Source<Vec<f64>>) -> Option<Upstream> {
        self.around.upstream(source)
    }

    /// Returns the ports that the node's outputs, and the views of those outputs, are connected to.
    pub fn consumers(&self) -> Vec<Consumer> {
        self.around.consumers()
    }

    /// Reports an error.
    pub fn error(&mut self, item: ItemName, found: impl ToString, expected: impl ToString, remedy: impl ToString) {
        let (found, expected, remedy) = (found.to_string(), expected.to_string(), remedy.to_string());
        self.faults.push(Fault { item, found, expected, remedy, warning: false });
    }

    /// Reports a warning.
    pub fn warning(&mut self, item: ItemName, found: impl ToString, expected: impl ToString, remedy: impl ToString) {
        let (found, expected, remedy) = (found.to_string(), expected.to_string(), remedy.to_string());
        self.faults.push(Fault { item, found, expected, remedy, warning: true });
    }

    /// Returns everything reported.
    pub fn into_faults(self) -> Vec<Fault> {
        self.faults
    }
}
