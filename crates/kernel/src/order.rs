//! Order in which operations run: depth first, so that a color is mixed right after it was made, and expensive
//! branches behind a mask last, so that they can be jumped over.

use trochoid_graph::{NodeId, Op};

/// Cost, in the units of [`cost`], from which a branch is worth a test of its mask: twenty mixes.
const DEAR: f64 = 60.0;
/// Deepest nesting of gates; bounds the work of finding what a branch shares with others.
const NESTED: usize = 4;
/// Marker for no operation: the end of every path.
const END: u32 = u32::MAX;

/// One step of the order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    Run(u32),
    /// The steps up to the matching `Run` of the Mix at `mix` are only needed if its mask is not all `closed`.
    Open {
        mix: u32,
        closed: f32,
    },
}

/// Program to order, with its uses and branches.
pub(crate) struct Order<'a> {
    ops: &'a [(Op, NodeId)],
    /// Whether a value is already computed.
    given: &'a dyn Fn(u32) -> bool,
    /// Mixes of two constants, computed where they are used.
    pub(crate) inline: Vec<bool>,
    /// Number of operand slots that refer to each operation.
    pub(crate) uses: Vec<u32>,
    /// Operation that all paths from each one to the roots pass next.
    next: Vec<u32>,
    /// Cost of everything that passes through each operation, including the operation itself.
    costs: Vec<f64>,
    branches: Branches,
}

/// For each operation, the list of operations that pass through it next.
struct Branches {
    first: Vec<u32>,
    sibling: Vec<u32>,
}

enum Task {
    Visit(u32),
    Run(u32),
    Open { mix: u32, closed: f32 },
    Close,
}

impl<'a> Order<'a> {
    /// Analyzes what `roots` need from a program.
    pub(crate) fn new(ops: &'a [(Op, NodeId)], roots: &[u32], given: &'a dyn Fn(u32) -> bool, fuse: bool) -> Self {
        let count = ops.len();
        let mut needed = vec![false; count];
        let mut uses = vec![0u32; count];
        let mut mixed_only = vec![true; count];
        for &root in roots {
            needed[root as usize] = true;
            mixed_only[root as usize] = false;
        }
        for at in (0..count).rev().filter(|&at| !given(at as u32)) {
            if !needed[at] {
                continue;
            }
            let is_mix = matches!(ops[at].0, Op::Mix { .. });
            ops[at].0.operands(|operand| {
                needed[operand as usize] = true;
                uses[operand as usize] += 1;
                mixed_only[operand as usize] &= is_mix;
            });
        }
        let is_constant = |color: u32| matches!(ops[color as usize].0, Op::ConstantColor(_));
        let inline = (0..count)
            .map(|at| match &ops[at].0 {
                Op::Mix { a, b, .. } => {
                    fuse && needed[at]
                        && !given(at as u32)
                        && mixed_only[at]
                        && uses[at] <= 2
                        && is_constant(a.0)
                        && is_constant(b.0)
                }
                _ => false,
            })
            .collect();
        let branches = Branches { first: Vec::new(), sibling: Vec::new() };
        let mut order = Self { ops, given, inline, uses, next: Vec::new(), costs: Vec::new(), branches };
        if fuse {
            order.find_branches(roots, &needed);
        }
        order
    }

    /// Builds the tree of operations that everything passes on its way to the roots (immediate postdominators), and
    /// its costs.
    fn find_branches(&mut self, roots: &[u32], needed: &[bool]) {
        let count = self.ops.len();
        let mut next: Vec<Option<u32>> = vec![None; count];
        let mut depth = vec![0u32; count];
        for &root in roots {
            next[root as usize] = Some(END);
        }
        for at in (0..count).rev().filter(|&at| needed[at]) {
            let mine = *next[at].get_or_insert(END);
            depth[at] = if mine == END { 1 } else { depth[mine as usize] + 1 };
            if (self.given)(at as u32) {
                continue;
            }
            self.ops[at].0.operands(|operand| {
                let known = next[operand as usize];
                next[operand as usize] = Some(match known {
                    None => at as u32,
                    Some(known) => meet(&next, &depth, known, at as u32),
                });
            });
        }
        let own = |(at, (op, _)): (usize, &(Op, NodeId))| if (self.given)(at as u32) { 0.0 } else { cost(op) };
        self.costs = self.ops.iter().enumerate().map(own).collect();
        self.branches = Branches { first: vec![END; count], sibling: vec![END; count] };
        for at in (0..count).filter(|&at| needed[at]) {
            if let Some(into) = next[at].filter(|&into| into != END) {
                self.costs[into as usize] += self.costs[at];
                self.branches.sibling[at] = self.branches.first[into as usize];
                self.branches.first[into as usize] = at as u32;
            }
        }
        self.next = next.into_iter().map(|next| next.unwrap_or(END)).collect();
    }

    /// Returns the steps that compute `roots`.
    pub(crate) fn steps(&self, roots: &[u32]) -> Vec<Step> {
        let mut steps = Vec::new();
        let mut done = vec![false; self.ops.len()];
        let mut nested = 0;
        let mut tasks: Vec<Task> = roots.iter().rev().map(|&root| Task::Visit(root)).collect();
        while let Some(task) = tasks.pop() {
            match task {
                Task::Run(at) => steps.push(Step::Run(at)),
                Task::Open { mix, closed } => {
                    nested += 1;
                    steps.push(Step::Open { mix, closed });
                }
                Task::Close => nested -= 1,
                Task::Visit(at) => {
                    if (self.given)(at) || std::mem::replace(&mut done[at as usize], true) {
                        continue;
                    }
                    self.visit(at, nested < NESTED, &done, &mut tasks);
                }
            }
        }
        steps
    }

    /// Plans one operation: its operands, then itself. Tasks are taken from the end.
    fn visit(&self, at: u32, may_gate: bool, done: &[bool], tasks: &mut Vec<Task>) {
        let Op::Mix { a, b, t } = &self.ops[at as usize].0 else {
            tasks.push(Task::Run(at));
            let start = tasks.len();
            self.ops[at as usize].0.operands(|operand| tasks.push(Task::Visit(operand)));
            tasks[start..].reverse();
            return;
        };
        if self.inline[at as usize] {
            tasks.push(Task::Visit(t.0));
            return;
        }
        if let Some((branch, other, closed)) = self.gate(at, a.0, b.0).filter(|_| may_gate) {
            tasks.extend([Task::Close, Task::Run(at), Task::Visit(branch), Task::Open { mix: at, closed }]);
            tasks.push(Task::Visit(other));
            self.shared(branch, |operand| tasks.push(Task::Visit(operand)));
            tasks.push(Task::Visit(t.0));
            return;
        }
        // The last color made is still in the accumulator.
        let ready = |color: u32| done[color as usize] || (self.given)(color) || self.inline[color as usize];
        let (first, last) = if ready(a.0) { (a.0, b.0) } else { (b.0, a.0) };
        tasks.extend([Task::Run(at), Task::Visit(last), Task::Visit(t.0), Task::Visit(first)]);
    }

    /// Returns the more expensive branch of a mix that nothing else needs, if it is expensive enough; the other
    /// branch; and the mask value that closes it.
    fn gate(&self, at: u32, a: u32, b: u32) -> Option<(u32, u32, f32)> {
        let own = |branch: u32| {
            let at_once = self.next.get(branch as usize) == Some(&at) && self.uses[branch as usize] == 1;
            (at_once && !(self.given)(branch) && self.costs[branch as usize] >= DEAR)
                .then(|| self.costs[branch as usize])
        };
        match (own(a), own(b)) {
            (Some(cost_a), Some(cost_b)) if cost_a > cost_b => Some((a, b, 1.0)),
            (_, Some(_)) => Some((b, a, 0.0)),
            (Some(_), None) => Some((a, b, 1.0)),
            (None, None) => None,
        }
    }

    /// Calls `f` with everything that a branch takes from outside itself.
    fn shared(&self, branch: u32, mut f: impl FnMut(u32)) {
        let mut inside = vec![branch];
        let mut index = 0;
        while let Some(&at) = inside.get(index) {
            let mut child = self.branches.first[at as usize];
            while child != END {
                inside.push(child);
                child = self.branches.sibling[child as usize];
            }
            index += 1;
        }
        inside.sort_unstable();
        for &at in inside.iter().filter(|&&at| !(self.given)(at)) {
            self.ops[at as usize].0.operands(|operand| {
                if inside.binary_search(&operand).is_err() {
                    f(operand);
                }
            });
        }
    }
}

/// Returns where two paths to the roots meet: goes up from the deeper one until they are the same.
fn meet(next: &[Option<u32>], depth: &[u32], mut a: u32, mut b: u32) -> u32 {
    let deep = |at: u32| if at == END { 0 } else { depth[at as usize] };
    while a != b {
        if deep(a) < deep(b) {
            std::mem::swap(&mut a, &mut b);
        }
        a = next[a as usize].unwrap_or(END);
    }
    a
}

/// Returns the relative cost of an operation per pixel, to divide a program's time among its nodes and to find
/// expensive branches; measured and rounded.
pub(crate) fn cost(op: &Op) -> f64 {
    match op {
        Op::Power { .. } => 20.0,
        Op::Clamp { .. } => 4.0,
        Op::Mix { .. } => 3.0,
        Op::Partition(weights) => 3.0 * weights.len() as f64,
        Op::Normalize { values, .. } => 4.0 * values.len() as f64,
        Op::Blend { colors, .. } => 3.0 * colors.len() as f64,
        Op::Constant(_) | Op::ConstantColor(_) | Op::Load(_) | Op::LoadColor(_) | Op::Weight(..) => 0.0,
        _ => 1.0,
    }
}
