//! Which nodes share a box.

use std::collections::BTreeMap;
use trochoid_graph::{CheckedGraph, NodeId, Source};

/// What is drawn of groups.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Groups<'a> {
    /// Each use of a group is one box, unless its nodes and others lead to each other in turn.
    #[default]
    Closed,
    /// Their nodes are drawn like those of the document.
    Open,
    /// Only the inside of the use with this path, and what leads into it.
    Inside(&'a str),
}

/// The nodes of a box.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Members {
    One(NodeId),
    /// A use of a group: its index, and its nodes.
    Use(usize, Vec<NodeId>),
}

impl Members {
    pub(crate) fn nodes(&self) -> &[NodeId] {
        match self {
            Self::One(node) => std::slice::from_ref(node),
            Self::Use(_, nodes) => nodes,
        }
    }
}

/// Returns the boxes of the shown nodes, in the order of their first nodes.
pub(crate) fn boxes(graph: &CheckedGraph, shown: &[bool], groups: Groups<'_>) -> Vec<Members> {
    let mut opened = vec![false; graph.groups().len()];
    loop {
        let mut boxes: Vec<Members> = Vec::new();
        let mut of_use: BTreeMap<usize, usize> = BTreeMap::new();
        for node in (0..shown.len()).filter(|index| shown[*index]).map(NodeId) {
            let Some(used) = closed(graph, node, groups, &opened) else {
                boxes.push(Members::One(node));
                continue;
            };
            let index = *of_use.entry(used).or_insert(boxes.len());
            match boxes.get_mut(index) {
                Some(Members::Use(_, nodes)) => nodes.push(node),
                _ => boxes.push(Members::Use(used, vec![node])),
            }
        }
        let mut circling = circling(graph, &boxes);
        circling.retain(|index| matches!(boxes[*index], Members::Use(..)));
        if circling.is_empty() {
            return boxes;
        }
        for index in circling {
            if let Members::Use(used, _) = &boxes[index] {
                opened[*used] = true;
            }
        }
    }
}

/// Returns the use whose box a node is in, if it is in one.
fn closed(graph: &CheckedGraph, node: NodeId, groups: Groups<'_>, opened: &[bool]) -> Option<usize> {
    let name = graph.node(node).name.as_str();
    let outside = match groups {
        Groups::Open => return None,
        Groups::Closed => "",
        Groups::Inside(path) => path,
    };
    // Outer uses come before those within them.
    let holds = |path: &str| name.strip_prefix(path).is_some_and(|rest| rest.starts_with('/'));
    let is_around =
        |path: &str| path == outside || outside.strip_prefix(path).is_some_and(|rest| rest.starts_with('/'));
    let uses = graph.groups().iter().enumerate();
    let mut uses = uses.filter(|(index, used)| !opened[*index] && holds(&used.path));
    uses.find(|(_, used)| !is_around(&used.path)).map(|(index, _)| index)
}

/// Returns the boxes on circles, and between them.
fn circling(graph: &CheckedGraph, boxes: &[Members]) -> Vec<usize> {
    let mut box_of = vec![None; graph.nodes().len()];
    for (index, members) in boxes.iter().enumerate() {
        members.nodes().iter().for_each(|node| box_of[node.0] = Some(index));
    }
    let mut above: Vec<Vec<usize>> = boxes
        .iter()
        .enumerate()
        .map(|(index, members)| {
            let sources = members.nodes().iter().flat_map(|node| graph.node(*node).record.sources());
            let from = sources.filter_map(|source| match source {
                Source::Output { node, .. } => box_of[node.0].filter(|other| *other != index),
                _ => None,
            });
            from.collect()
        })
        .collect();
    let mut left: Vec<usize> = (0..boxes.len()).collect();
    loop {
        let before = left.len();
        let leads: Vec<usize> = left.iter().flat_map(|index| above[*index].iter().copied()).collect();
        left.retain(|index| !above[*index].is_empty() && leads.contains(index));
        for index in left.clone() {
            above[index].retain(|other| left.contains(other));
        }
        if left.len() == before {
            return left;
        }
    }
}
