//! The sea that the panel shows.

use crate::document::Node;
use crate::state::State;
use std::ops::Deref;
use std::sync::Arc;
use trochoid::{CheckedGraph, Declaration, NodeId, Role, Settled};

/// A sea of the document, perhaps inside of a group.
pub(super) struct Sea<'s> {
    /// Name in the expanded document.
    pub(super) name: String,
    pub(super) declaration: &'static Declaration,
    /// The node, if the canvas draws it; otherwise its knobs cannot be changed from here.
    pub(super) node: Option<&'s Node>,
    /// The sea at the current frame; `None` if the document has errors.
    pub(super) settled: Option<Held>,
}

/// A sea at a frame. It may have thousands of waves, so it is shared, and compared only if it was made anew.
#[derive(Clone, Debug)]
pub(super) struct Held(Arc<Settled>);

impl Deref for Held {
    type Target = Settled;

    fn deref(&self) -> &Settled {
        &self.0
    }
}

impl PartialEq for Held {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

/// The sea that was shown last: its revision, frame and name.
pub(super) type LastSea = Option<((u64, i64, String), Held)>;

/// Returns the names of all seas in the expanded document; without a graph, of those that the canvas draws.
pub(super) fn names(state: &State) -> Vec<String> {
    match &state.session.meaning().graph {
        Some(graph) => seas(graph).map(|id| graph.node(id).name.clone()).collect(),
        None => drawn(state).map(|node| state.whole_name(&node.name)).collect(),
    }
}

fn seas(graph: &CheckedGraph) -> impl Iterator<Item = NodeId> {
    let is_sea = |node: &trochoid::CheckedNode| node.ty.declaration().role == Some(Role::Sea);
    (0..graph.nodes().len()).map(NodeId).filter(move |id| is_sea(graph.node(*id)))
}

fn drawn(state: &State) -> impl Iterator<Item = &Node> {
    state.sheet().nodes.iter().filter(|node| node.is(Role::Sea))
}

/// Returns the sea that is meant: the selected one, the one that the selected node depends on, the one of the viewed
/// node, or the first one.
pub(super) fn chosen<'s>(last: &mut LastSea, state: &'s State) -> Option<Sea<'s>> {
    let Some(graph) = &state.session.meaning().graph else {
        let chosen = state.chosen().and_then(|name| drawn(state).find(|node| node.name == name));
        let node = chosen.or_else(|| drawn(state).next())?;
        let declaration = node.declaration?;
        return Some(Sea { name: state.whole_name(&node.name), declaration, node: Some(node), settled: None });
    };
    let selected = state.chosen().map(|name| state.whole_name(name));
    let viewed = state.look.node.as_ref().map(|(name, _)| name.clone());
    let entered = Some(state.sheet().prefix()).filter(|prefix| !prefix.is_empty());
    let found = selected.and_then(|name| below(graph, &name)).or_else(|| {
        let inside = |prefix: String| seas(graph).find(|id| graph.node(*id).name.starts_with(&prefix));
        entered.and_then(inside)
    });
    let id = found.or_else(|| below(graph, &viewed?)).or_else(|| seas(graph).next())?;
    let name = graph.node(id).name.clone();
    let own = state.own_name(&name).filter(|own| state.whole_name(own) == name);
    let node = own.and_then(|own| state.sheet().node(own));
    let declaration = graph.node(id).ty.declaration();
    let key = (state.session.revision(), state.frame, name.clone());
    let held = match last.take() {
        Some((known, held)) if known == key => held,
        _ => Held(Arc::new(graph.settle(id, state.frame))),
    };
    *last = Some((key, held.clone()));
    Some(Sea { name, declaration, node, settled: Some(held) })
}

/// Returns the sea that a node is, or depends on; of a use of a group, that of its nodes.
fn below(graph: &CheckedGraph, name: &str) -> Option<NodeId> {
    let inside = format!("{name}/");
    let is_meant = |id: &NodeId| graph.node(*id).name == name || graph.node(*id).name.starts_with(&inside);
    let roots: Vec<NodeId> = (0..graph.nodes().len()).map(NodeId).filter(is_meant).collect();
    let own = seas(graph).find(|id| roots.contains(id));
    own.or_else(|| {
        let above = graph.upstream(roots);
        seas(graph).find(|id| above[id.0])
    })
}
