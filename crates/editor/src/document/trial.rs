//! Checks whether a document would accept an edited value.

use super::change::Edit;
use super::json::{Op, Path, Step};
use super::meaning::Meaning;
use trochoid::Diagnostic;

/// Returns the new fault that an edit causes in the edited node, or in the edited entry outside of nodes. Returns none
/// if that place already had a fault, or if the edit fixes another fault: then it may be a step toward a valid
/// document.
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

/// Part of the document that an edit concerns.
enum Part<'p> {
    Node(&'p str),
    /// Entry outside of nodes, such as `format`.
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

/// Returns whether two faults are the same, regardless of their place in the text.
fn is_same(a: &Diagnostic, b: &Diagnostic) -> bool {
    (&a.node, &a.port, &a.found, &a.expected) == (&b.node, &b.port, &b.found, &b.expected)
}
