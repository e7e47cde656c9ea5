//! A tree of boxes over triangles, eight in each node.
//!
//! Parts are divided by the surface area heuristic: MacDonald and Booth, *Heuristics for Ray Tracing Using Space
//! Subdivision*, 1990, over bins of middles: Wald, *On Fast Construction of SAH-Based Bounding Volume Hierarchies*, 2007.
//! Wide nodes after Wald, Benthin and Boulos, *Getting Rid of Packets*, 2008, which here hold what a packet of rays may
//! meet. The tree depends neither on the number of threads nor on their timing.

use super::bounds::Bounds;
use super::facets::{Facets, Part};
use super::halves::Group;
use rayon::prelude::*;

/// Number of boxes in a node.
pub(super) const CHILDREN: usize = 8;
/// Bit of a child that is a triangle.
const TRIANGLE: u32 = 1 << 31;
/// Number of triangles of a group from which on its parts are divided on all cores.
const MANY: u32 = 1 << 12;
/// Depth from which on groups are divided evenly, so that no scene makes a tree deep.
const DEEP: usize = 32;

/// Boxes side by side, and what is in them.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(super) struct Node {
    pub(super) low: [[f32; CHILDREN]; 3],
    pub(super) high: [[f32; CHILDREN]; 3],
    child: [u32; CHILDREN],
}

/// What is in a box.
pub(super) enum Child {
    Node(u32),
    Triangle(u32),
}

/// A tree; its first node, if there is one, is its root.
#[derive(Debug)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
}

impl Node {
    /// No ray enters a box whose ends are exchanged.
    const EMPTY: Self = Self {
        low: [[f32::INFINITY; CHILDREN]; 3],
        high: [[f32::NEG_INFINITY; CHILDREN]; 3],
        child: [TRIANGLE; CHILDREN],
    };

    #[inline(always)]
    pub(super) fn child(&self, lane: usize) -> Child {
        match self.child[lane] {
            child if child & TRIANGLE == 0 => Child::Node(child),
            child => Child::Triangle(child & !TRIANGLE),
        }
    }

    fn set(&mut self, lane: usize, bounds: Bounds, child: u32) {
        for axis in 0..3 {
            self.low[axis][lane] = bounds.low[axis];
            self.high[axis][lane] = bounds.high[axis];
        }
        self.child[lane] = child;
    }
}

impl Tree {
    /// # Panics
    /// There are 2²⁹ nodes or more.
    pub(super) fn new(facets: &Facets, mut parts: Vec<Part>) -> Self {
        let mut nodes = Vec::new();
        if !parts.is_empty() {
            let whole = Group::of(&parts);
            node(facets, &mut parts, whole, 0, &mut nodes);
        }
        assert!(nodes.len() < 1 << 29, "fewer than 2²⁹ nodes");
        Self { nodes }
    }
}

/// Adds the node of some parts and those below it, and returns its index.
fn node(facets: &Facets, parts: &mut [Part], whole: Group, depth: usize, nodes: &mut Vec<Node>) -> u32 {
    let index = nodes.len();
    nodes.push(Node::EMPTY);
    if whole.count <= CHILDREN as u32 {
        let triangles = parts.iter().flat_map(|part| part.first..part.first + part.count);
        for (lane, triangle) in triangles.enumerate() {
            nodes[index].set(lane, facets.bounds(triangle), triangle | TRIANGLE);
        }
        return index as u32;
    }
    let mut rest = parts;
    let groups = divided(rest, whole, depth).into_iter().map(|group| {
        let (own, after) = std::mem::take(&mut rest).split_at_mut(group.end - group.start);
        rest = after;
        (Group { start: 0, end: own.len(), ..group }, own)
    });
    if whole.count < MANY {
        for (lane, (group, own)) in groups.enumerate() {
            let child = child(facets, own, group, depth + 1, nodes);
            nodes[index].set(lane, group.bounds, child);
        }
        return index as u32;
    }
    let groups: Vec<(Group, &mut [Part])> = groups.collect();
    let trees: Vec<(Bounds, u32, Vec<Node>)> = groups
        .into_par_iter()
        .map(|(group, own)| {
            let mut nodes = Vec::new();
            let child = child(facets, own, group, depth + 1, &mut nodes);
            (group.bounds, child, nodes)
        })
        .collect();
    for (lane, (bounds, child, mut below)) in trees.into_iter().enumerate() {
        let by = nodes.len() as u32;
        below.iter_mut().for_each(|node| node.child = node.child.map(|child| shifted(child, by)));
        nodes[index].set(lane, bounds, shifted(child, by));
        nodes.append(&mut below);
    }
    index as u32
}

/// Returns what stands for some parts in the node above, and adds the nodes that it needs.
fn child(facets: &Facets, parts: &mut [Part], whole: Group, depth: usize, nodes: &mut Vec<Node>) -> u32 {
    if whole.count == 1 { parts[0].first | TRIANGLE } else { node(facets, parts, whole, depth, nodes) }
}

fn shifted(child: u32, by: u32) -> u32 {
    if child & TRIANGLE == 0 { child + by } else { child }
}

/// Sorts parts into as many groups as a node has boxes, or fewer if each fits in one node.
fn divided(parts: &mut [Part], whole: Group, depth: usize) -> Vec<Group> {
    let evenly = depth >= DEEP;
    let mut groups = Vec::with_capacity(CHILDREN);
    groups.push(whole);
    while groups.len() < CHILDREN {
        let size = |group: &Group| if evenly { f64::from(group.count) } else { group.bounds.area() };
        let large = (0..groups.len()).filter(|index| groups[*index].count > CHILDREN as u32);
        let Some(index) = large.max_by(|a, b| size(&groups[*a]).total_cmp(&size(&groups[*b]))) else { break };
        let [first, second] = groups[index].halves(parts, evenly);
        groups[index] = first;
        groups.insert(index + 1, second);
    }
    groups
}
