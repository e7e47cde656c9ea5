//! Boxes around the parts of surfaces, as a tree, for rays in f64.

use glam::{DVec3, Vec3};

/// A box: a leaf with the index of a part, or two boxes.
#[derive(Clone, Copy, Debug)]
struct Branch {
    low: Vec3,
    high: Vec3,
    /// Index of the first of two branches that follow one another; for a leaf, that of its part.
    next: u32,
    is_leaf: bool,
}

/// A binary tree of boxes.
#[derive(Debug)]
pub(crate) struct Tree {
    branches: Vec<Branch>,
}

/// A ray for boxes.
#[derive(Clone, Copy)]
pub(crate) struct Line {
    origin: DVec3,
    inverse: DVec3,
}

/// Share by which the ends of a ray's part within a box are widened for rounding.
const SLACK: f64 = 1e-12;

impl Line {
    pub(crate) fn new(origin: DVec3, direction: DVec3) -> Self {
        // A component of 0 would compute 0·∞ for a box that starts at the ray's origin.
        let inverse = |part: f64| if part.abs() < 1e-200 { 1e200_f64.copysign(part) } else { 1.0 / part };
        Self { origin, inverse: DVec3::new(inverse(direction.x), inverse(direction.y), inverse(direction.z)) }
    }

    /// Returns the distance at which the ray enters a box before `end`.
    #[inline(always)]
    fn enters(&self, branch: &Branch, end: f64) -> Option<f64> {
        let a = (branch.low.as_dvec3() - self.origin) * self.inverse;
        let b = (branch.high.as_dvec3() - self.origin) * self.inverse;
        let (near, far) = (a.min(b), a.max(b));
        let near = near.max_element().max(0.0);
        let far = far.min_element().min(end);
        (near * (1.0 - SLACK) <= far * (1.0 + SLACK)).then_some(near * (1.0 - SLACK))
    }
}

impl Tree {
    /// Makes the tree of these boxes; `None` if there are none.
    pub(crate) fn new(boxes: &[[DVec3; 2]]) -> Option<Self> {
        let below = |value: f64| (value as f32).next_down();
        let above = |value: f64| (value as f32).next_up();
        let leaf = |(index, [low, high]): (usize, &[DVec3; 2])| Branch {
            low: Vec3::new(below(low.x), below(low.y), below(low.z)),
            high: Vec3::new(above(high.x), above(high.y), above(high.z)),
            next: index as u32,
            is_leaf: true,
        };
        let mut leaves: Vec<Branch> = boxes.iter().enumerate().map(leaf).collect();
        if leaves.is_empty() {
            return None;
        }
        let mut branches = vec![leaves[0]];
        // Parts of the leaves that still need branches, with the branch that stands for each.
        let mut open = vec![(0, leaves.len(), 0)];
        while let Some((from, to, at)) = open.pop() {
            let part = &mut leaves[from..to];
            if let [leaf] = part {
                branches[at] = *leaf;
                continue;
            }
            let low = part.iter().fold(Vec3::INFINITY, |low, leaf| low.min(leaf.low));
            let high = part.iter().fold(Vec3::NEG_INFINITY, |high, leaf| high.max(leaf.high));
            let axis = if high.z - low.z > high.x - low.x { 2 } else { 0 };
            let half = part.len() / 2;
            part.select_nth_unstable_by(half, |a, b| {
                (a.low[axis] + a.high[axis]).total_cmp(&(b.low[axis] + b.high[axis])).then(a.next.cmp(&b.next))
            });
            let next = branches.len();
            branches[at] = Branch { low, high, next: next as u32, is_leaf: false };
            branches.extend([*branches.first()?; 2]);
            open.push((from, from + half, next));
            open.push((from + half, to, next + 1));
        }
        Some(Self { branches })
    }

    /// Hands over the parts whose boxes a ray meets, roughly from near to far. `take` returns the distance beyond which
    /// nothing matters any more; negative to stop.
    pub(crate) fn visit(&self, line: &Line, end: f64, mut take: impl FnMut(usize) -> f64) {
        let mut end = end;
        let mut open: Vec<(f64, u32)> = Vec::with_capacity(64);
        open.extend(line.enters(&self.branches[0], end).map(|near| (near, 0)));
        while let Some((near, index)) = open.pop() {
            if near > end {
                continue;
            }
            let branch = &self.branches[index as usize];
            if branch.is_leaf {
                end = take(branch.next as usize);
                if end < 0.0 {
                    return;
                }
                continue;
            }
            // No closure of an array: that is a function of its own.
            let (first, second) = (branch.next, branch.next + 1);
            let enters = |next: u32| line.enters(&self.branches[next as usize], end);
            match [(enters(first), first), (enters(second), second)] {
                [(Some(a), first), (Some(b), second)] if a <= b => open.extend([(b, second), (a, first)]),
                [(Some(a), first), (Some(b), second)] => open.extend([(a, first), (b, second)]),
                [(Some(a), first), (None, _)] => open.push((a, first)),
                [(None, _), (Some(b), second)] => open.push((b, second)),
                _ => {}
            }
        }
    }
}
