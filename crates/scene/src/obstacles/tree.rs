//! A tree of boxes over triangles, eight in each node.
//!
//! A part of many triangles has a tree in the order of its triangles. Parts are divided by the surface area heuristic:
//! MacDonald and Booth, *Heuristics for Ray Tracing Using Space Subdivision*, 1990, over bins of middles: Wald, *On Fast
//! Construction of SAH-Based Bounding Volume Hierarchies*, 2007. Wide nodes after Wald, Benthin and Boulos, *Getting Rid of
//! Packets*, 2008, which here hold what a packet of rays may meet. The tree depends neither on the number of threads nor on
//! their timing.

use super::bounds::Bounds;
use super::facets::{Facets, Part};
use super::halves::Group;
use rayon::prelude::*;

/// Number of boxes in a node.
pub(super) const CHILDREN: usize = 8;
/// Bit of a child that is a triangle.
const TRIANGLE: u32 = 1 << 31;
/// Bit of a child that is a part with a tree of its own, until that is made; the others are its first triangle.
const RUN: u32 = 1 << 30;
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

    /// Returns the ends of a box.
    #[inline(always)]
    pub(super) fn bounds(&self, lane: usize) -> ([f32; 3], [f32; 3]) {
        let ([a, b, c], [d, e, f]) = (&self.low, &self.high);
        ([a[lane], b[lane], c[lane]], [d[lane], e[lane], f[lane]])
    }

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

/// A part with more triangles than fit in a node.
struct Run {
    first: u32,
    count: usize,
    /// Index of its first node.
    root: usize,
}

impl Tree {
    /// # Panics
    /// There are 2²⁹ nodes or more.
    pub(super) fn new(facets: &Facets, mut parts: Vec<Part>) -> Self {
        let mut nodes = Vec::new();
        if parts.is_empty() {
            return Self { nodes };
        }
        let large = parts.iter().filter(|part| part.count > CHILDREN as u32);
        let mut runs: Vec<Run> =
            large.map(|part| Run { first: part.first, count: part.count as usize, root: 0 }).collect();
        let whole = Group::of(&parts);
        node(facets, &mut parts, whole, 0, &mut nodes);
        let top = nodes.len();
        let mut end = top;
        for run in &mut runs {
            run.root = end;
            end += size_of_run(run.count);
        }
        assert!(end < 1 << 29, "fewer than 2²⁹ nodes");
        for child in nodes.iter_mut().flat_map(|node| &mut node.child) {
            if *child & TRIANGLE == 0 && *child & RUN != 0 {
                let run = runs.binary_search_by_key(&(*child & !RUN), |run| run.first).expect("a run");
                *child = runs[run].root as u32;
            }
        }
        nodes.resize(end, Node::EMPTY);
        let mut rest = &mut nodes[top..];
        let own = runs.iter().map(|run| {
            let (own, after) = std::mem::take(&mut rest).split_at_mut(size_of_run(run.count));
            rest = after;
            (run, own)
        });
        let own: Vec<(&Run, &mut [Node])> = own.collect();
        own.into_par_iter().for_each(|(run, own)| {
            fill_run(facets, run, own);
        });
        Self { nodes }
    }
}

/// Returns how many triangles of a run each child of its root has: a power of the number of children.
fn stride(count: usize) -> usize {
    let mut stride = CHILDREN;
    while stride * CHILDREN < count {
        stride *= CHILDREN;
    }
    stride
}

/// Returns the number of nodes of a run of triangles.
fn size_of_run(count: usize) -> usize {
    if count <= CHILDREN {
        return 1;
    }
    let stride = stride(count);
    let rest = count % stride;
    1 + count / stride * size_of_run(stride) + if rest > 0 { size_of_run(rest) } else { 0 }
}

/// Makes the nodes of a run in the order of its triangles, and returns its box.
fn fill_run(facets: &Facets, run: &Run, own: &mut [Node]) -> Bounds {
    let mut all = Bounds::NOTHING;
    if run.count <= CHILDREN {
        for (lane, triangle) in (run.first..run.first + run.count as u32).enumerate() {
            let bounds = facets.bounds(triangle);
            own[0].set(lane, bounds, triangle | TRIANGLE);
            all = all.union(bounds);
        }
        return all;
    }
    let stride = stride(run.count);
    let mut at = 1;
    for (lane, start) in (0..run.count).step_by(stride).enumerate() {
        let child = Run { first: run.first + start as u32, count: stride.min(run.count - start), root: run.root + at };
        let size = size_of_run(child.count);
        let bounds = fill_run(facets, &child, &mut own[at..at + size]);
        own[0].set(lane, bounds, child.root as u32);
        all = all.union(bounds);
        at += size;
    }
    all
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
    match parts {
        [part] if part.count == 1 => part.first | TRIANGLE,
        [part] if part.count > CHILDREN as u32 => part.first | RUN,
        _ => node(facets, parts, whole, depth, nodes),
    }
}

fn shifted(child: u32, by: u32) -> u32 {
    if child & (TRIANGLE | RUN) == 0 { child + by } else { child }
}

/// Sorts parts into as many groups as a node has boxes, or fewer if each fits in one node.
fn divided(parts: &mut [Part], whole: Group, depth: usize) -> Vec<Group> {
    let evenly = depth >= DEEP;
    let mut groups = Vec::with_capacity(CHILDREN);
    groups.push(whole);
    while groups.len() < CHILDREN {
        let size = |group: &Group| if evenly { f64::from(group.count) } else { group.bounds.area() };
        let large = |group: &Group| group.end - group.start > 1 && group.count > CHILDREN as u32;
        let large = (0..groups.len()).filter(|index| large(&groups[*index]));
        let Some(index) = large.max_by(|a, b| size(&groups[*a]).total_cmp(&size(&groups[*b]))) else { break };
        let [first, second] = groups[index].halves(parts, evenly);
        groups[index] = first;
        groups.insert(index + 1, second);
    }
    groups
}
