//! Checks whether a document would accept an edited value.

use super::change::Edit;
use super::json::{Op, Path, Step};
use super::meaning::Meaning;
use trochoid::Diagnostic;

/// Returns the new fault that an edit causes in the edited nodes, or in the edited entry outside of nodes; if it makes a
/// link, anywhere, for a circle of links is told where it is met first. Returns none
/// if that place already had a fault, or if the edit fixes another fault: then it may be a step toward a valid
/// document.
pub(super) fn fault(edit: &Edit, before: &Meaning, after: &Meaning) -> Option<Diagnostic> {
    let [Op::Set(..), ..] = edit.ops.as_slice() else { return None };
    // An edit of several nodes sets a value in each.
    let sets = edit.ops.iter().filter_map(|op| if let Op::Set(path, _) = op { Part::of(path) } else { None });
    let places: Vec<Part<'_>> = sets.collect();
    let holds = |fault: &Diagnostic| places.iter().any(|place| place.holds(fault));
    let is_known = |fault: &Diagnostic| before.errors().any(|known| is_same(known, fault));
    let stays = |known: &Diagnostic| after.errors().any(|fault| is_same(known, fault));
    if before.errors().any(holds) || !before.errors().all(stays) {
        return None;
    }
    let is_link = edit.ops.iter().any(|op| matches!(op, Op::Set(_, text) if text.starts_with("\"=")));
    after.errors().find(|fault| (holds(fault) || is_link) && !is_known(fault)).cloned()
}

/// Part of the document that an edit concerns.
enum Part<'p> {
    Node(&'p str),
    /// A node of a group, which each use of the group has.
    Inner(&'p str),
    /// Entry outside of nodes, such as `format`.
    Top(&'p [Step]),
}

impl<'p> Part<'p> {
    fn of(path: &'p Path) -> Option<Self> {
        match path.0.as_slice() {
            [Step::Key(nodes), Step::Key(name), ..] if nodes == "nodes" => Some(Self::Node(name)),
            [Step::Key(groups), _, Step::Key(nodes), Step::Key(name), ..] if groups == "groups" && nodes == "nodes" => {
                Some(Self::Inner(name))
            }
            [] => None,
            steps => Some(Self::Top(steps)),
        }
    }

    fn holds(&self, fault: &Diagnostic) -> bool {
        match self {
            Self::Node(name) => fault.node.as_deref() == Some(name),
            Self::Inner(name) => {
                fault.node.as_deref().and_then(|node| node.rsplit_once('/')).is_some_and(|(_, own)| own == *name)
            }
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
