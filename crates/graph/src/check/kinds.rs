//! The kinds of nodes' outputs.

use super::Draft;
use crate::{Kind, Source};

/// Sets the kinds of the outputs of each node of known type.
pub(super) fn name_kinds(drafts: &mut [Draft<'_>], first: i64) {
    for draft in drafts.iter_mut() {
        if let Some(ty) = draft.ty {
            let settled = ty.settle(draft.record.settle(first as f64));
            draft.kinds = draft.kinds_of(&settled);
            draft.settled = Some(settled);
        }
    }
    name_passed_kinds(drafts);
}

/// Gives each output of [`Kind::ANY`] the kind of the node's first connection; no kind if that is unknown.
fn name_passed_kinds(drafts: &mut [Draft<'_>]) {
    let mut visited = vec![false; drafts.len()];
    for start in 0..drafts.len() {
        // Follows first connections up to a node of known kind.
        let mut path = Vec::new();
        let mut at = start;
        let kind = loop {
            // A visited node of unknown kind means a loop, which is reported elsewhere.
            if !drafts[at].kinds.contains(&Kind::ANY) || std::mem::replace(&mut visited[at], true) {
                break None;
            }
            path.push(at);
            match drafts[at].record.sources().into_iter().next() {
                Some(Source::Output { node, .. }) if drafts[node.0].kinds.contains(&Kind::ANY) => at = node.0,
                Some(source) => break kind_of(source, drafts),
                None => break None,
            }
        };
        for node in path {
            let kinds = &mut drafts[node].kinds;
            match kind {
                Some(kind) => kinds.iter_mut().filter(|known| **known == Kind::ANY).for_each(|known| *known = kind),
                None => kinds.clear(),
            }
        }
    }
}

/// Returns the kind of a source, if its node has a known type.
pub(super) fn kind_of<N>(source: &Source<N>, drafts: &[Draft<'_>]) -> Option<Kind> {
    match source {
        Source::Output { node, output } => drafts.get(node.0)?.kinds.get(*output).copied(),
        Source::Number(_) => Some(Kind::MASK),
        Source::Color(_) => Some(Kind::Color),
        Source::Numbers(numbers) => Some(Kind::Weights(numbers.len())),
    }
}
