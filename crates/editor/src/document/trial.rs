//! Whether a document bears a value that is given to it.

use super::change::Edit;
use super::json::{Op, Path, Step};
use super::meaning::Meaning;
use trochoid::Diagnostic;

/// The fault that a change brings to the node that it changes, or to the entry of the document where that is no node's. None
/// where there was one before, or where another goes away: then the change is a step on a way out.
pub(super) fn fault(edit: &Edit, before: &Meaning, after: &Meaning) -> Option<Diagnostic> {
    let [Op::Set(path, _), ..] = edit.ops.as_slice() else { return None };
    let place = Part::of(path)?;
    let is_known = |fault: &Diagnostic| before.errors().any(|known| is_same(known, fault));
    let stays = |known: &Diagnostic| after.errors().any(|fault| is_same(known, fault));
    if before.errors().any(|fault| place.holds(fault)) || !before.errors().all(stays) {
        return None;
    }
    after.errors().find(|fault| place.holds(fault) && !is_known(fault)).cloned()
}

/// What a change is of.
enum Part<'p> {
    Node(&'p str),
    /// An entry of the document itself, such as its format.
    Top(&'p [Step]),
}

impl<'p> Part<'p> {
    fn of(path: &'p Path) -> Option<Self> {
        match path.0.as_slice() {
            [Step::Key(nodes), Step::Key(name), ..] if nodes == "nodes" => Some(Self::Node(name)),
            [] => None,
            steps => Some(Self::Top(steps)),
        }
    }

    fn holds(&self, fault: &Diagnostic) -> bool {
        match self {
            Self::Node(name) => fault.node.as_deref() == Some(name),
            Self::Top(steps) => {
                let named = |port: &str| steps.iter().any(|step| *step == Step::from(port));
                fault.node.is_none() && fault.port.as_deref().is_some_and(named)
            }
        }
    }
}

/// Whether two faults are one, wherever in the text it stands by now.
fn is_same(a: &Diagnostic, b: &Diagnostic) -> bool {
    (&a.node, &a.port, &a.found, &a.expected) == (&b.node, &b.port, &b.found, &b.expected)
}
