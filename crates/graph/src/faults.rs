//! What a node's own checks find.

use crate::{Declaration, ItemName, Kind, Offer, Registry, Settled, Source};

/// Collects what [`Node::check`](crate::Node::check) finds.
pub struct Check<'a> {
    around: &'a dyn Around,
    faults: Vec<Fault>,
}

/// The graph around a node that is checked.
pub trait Around {
    /// The kind of a connection or literal, where known.
    fn kind(&self, source: &Source<Vec<f64>>) -> Option<Kind>;

    /// The node that a connection comes from, as it is at the frame, where it has no faults.
    fn upstream(&self, source: &Source<Vec<f64>>) -> Option<Upstream>;

    /// What takes the node's outputs.
    fn users(&self) -> Vec<User>;

    /// All node types.
    fn registry(&self) -> &Registry;
}

/// "a Mesh, Render or Sky"; "another node" where there is none.
pub fn one_of(types: impl Iterator<Item = &'static Declaration>) -> String {
    let names: Vec<&str> = types.map(|declaration| declaration.name).collect();
    match names.as_slice() {
        [] => "another node".into(),
        [name] => format!("a {name}"),
        [names @ .., last] => format!("a {} or {last}", names.join(", ")),
    }
}

/// A node that another one takes something from.
#[derive(Clone)]
pub struct Upstream {
    /// Its name in the document.
    pub name: String,
    /// Its ports and knobs.
    pub node: Settled,
}

impl Upstream {
    /// The name of its type.
    pub fn ty(&self) -> &'static str {
        self.node.ty().declaration().name
    }

    /// Whether what it hands on has something beside its kind.
    pub fn offers(&self, what: Offer) -> bool {
        self.node.ty().declaration().offers.contains(&what)
    }
}

/// A port that takes an output, or a view of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct User {
    /// What the port makes use of beside the kind.
    pub wants: &'static [Offer],
}

/// A fault or warning within one node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The port or knob.
    pub item: ItemName,
    /// What was found.
    pub found: String,
    /// What was expected.
    pub expected: String,
    /// What to do.
    pub remedy: String,
    /// Whether it is only a warning.
    pub warning: bool,
}

impl<'a> Check<'a> {
    /// Made by validation.
    pub fn new(around: &'a dyn Around) -> Self {
        Self { around, faults: Vec::new() }
    }

    /// The kind of a connection or literal, where known.
    pub fn kind(&self, source: &Source<Vec<f64>>) -> Option<Kind> {
        self.around.kind(source)
    }

    /// All node types.
    pub fn types(&self) -> impl Iterator<Item = &'static Declaration> {
        self.around.registry().iter().map(|ty| ty.declaration())
    }

    /// The names of the node types that offer something, as in "a Mesh, Render or Sky".
    pub fn offering(&self, what: Offer) -> String {
        one_of(self.types().filter(|declaration| declaration.offers.contains(&what)))
    }

    /// The node that a connection comes from, where it has no faults of its own.
    pub fn upstream(&self, source: &Source<Vec<f64>>) -> Option<Upstream> {
        self.around.upstream(source)
    }

    /// What takes the node's outputs, and what takes the views of them.
    pub fn users(&self) -> Vec<User> {
        self.around.users()
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

    /// Everything reported.
    pub fn into_faults(self) -> Vec<Fault> {
        self.faults
    }
}
