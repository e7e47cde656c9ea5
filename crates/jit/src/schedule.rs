//! Order of the items. Processors look ahead only a limited distance for instructions that can start, so dependent
//! items should not follow each other directly. No bit of the result depends on the order.

use crate::program::{Item, Op, Program, Value};
use std::collections::{BTreeSet, VecDeque};
use std::ops::Range;

/// Number of items that are considered for the next position, in wide and narrow code. A larger window keeps more
/// values alive at once, for which narrow code has too few registers.
const WINDOW: [usize; 2] = [48, 2];
/// Time of values that are not scheduled yet.
const LATER: u64 = u64::MAX;

/// Reorders a program for more parallelism, for a number of vectors processed side by side.
pub(crate) fn scheduled(program: &Program, wide: bool, parts: u32) -> Program {
    let mut program = program.clone();
    split(&mut program);
    let count = program.values as usize;
    let mut scheduler = Scheduler {
        items: &program.items,
        window: WINDOW[usize::from(!wide)],
        parts: parts.into(),
        now: 0,
        values: vec![LATER; count],
        masks: vec![0; count],
        ordered: Vec::with_capacity(program.items.len()),
    };
    scheduler.order(0..program.items.len());
    program.items = scheduler.ordered;
    program
}

/// Splits slow items into a part that can start early, and the rest.
fn split(program: &mut Program) {
    // Prepared masks, by open branch: the order of a branch and the items around it is not known yet.
    let mut ready = vec![BTreeSet::new()];
    for item in std::mem::take(&mut program.items) {
        match &item {
            Item::Compute { op: Op::Clamp { x, min, width }, to } => {
                let over = Value(program.values);
                program.values += 1;
                program.items.push(Item::Over { x: *x, min: *min, width: *width, to: over });
                program.items.push(Item::Within { x: over, to: *to });
                continue;
            }
            Item::Compute { op: Op::Mix { t, .. }, .. } if ready.last_mut().is_some_and(|masks| masks.insert(*t)) => {
                program.items.push(Item::Ready(*t));
            }
            Item::Gate { .. } => ready.push(BTreeSet::new()),
            Item::Join { .. } => drop(ready.pop()),
            _ => {}
        }
        program.items.push(item);
    }
}

/// One item, or a branch from its gate to its join.
struct Unit {
    items: Range<usize>,
    /// Values from outside of the unit.
    needs: Vec<Value>,
}

struct Scheduler<'p> {
    items: &'p [Item],
    window: usize,
    parts: u64,
    /// Current time, like all times in quarters of a cycle.
    now: u64,
    /// Time at which each value is available.
    values: Vec<u64>,
    /// Time at which each mask is prepared for mixing.
    masks: Vec<u64>,
    ordered: Vec<Item>,
}

impl Scheduler<'_> {
    fn order(&mut self, range: Range<usize>) {
        let mut waiting = self.units(range);
        while !waiting.is_empty() {
            // Choose the first unit that can start now, or else the one that can start first.
            let mut best = (LATER, 0);
            for (place, unit) in waiting.iter().enumerate().take(self.window) {
                let from = self.from(unit);
                if from < best.0 {
                    best = (from, place);
                }
                if from <= self.now {
                    break;
                }
            }
            debug_assert!(best.0 < LATER, "the first of all waits for nothing");
            let Some(unit) = waiting.remove(best.1) else { unreachable!("places are counted") };
            self.now = self.now.max(best.0);
            self.place(unit.items);
        }
    }

    fn units(&mut self, range: Range<usize>) -> VecDeque<Unit> {
        let mut units = VecDeque::new();
        let mut at = range.start;
        while at < range.end {
            let items = at..self.end(at);
            let mut made = BTreeSet::new();
            let mut needs = BTreeSet::new();
            for item in &self.items[items.clone()] {
                item.operands(|value| {
                    if !made.contains(&value) {
                        needs.insert(value);
                    }
                });
                item.results(|value| {
                    made.insert(value);
                });
            }
            if let Item::Ready(t) = &self.items[at] {
                self.masks[t.0 as usize] = LATER;
            }
            at = items.end;
            units.push_back(Unit { items, needs: needs.into_iter().collect() });
        }
        units
    }

    /// Returns the end of the unit that starts with an item.
    fn end(&self, start: usize) -> usize {
        let mut depth = 0;
        for (at, item) in self.items.iter().enumerate().skip(start) {
            match item {
                Item::Gate { .. } => depth += 1,
                Item::Join { .. } => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                return at + 1;
            }
        }
        unreachable!("gates are joined")
    }

    /// Returns the time from which on a unit can start.
    fn from(&self, unit: &Unit) -> u64 {
        let known = unit.needs.iter().map(|value| self.values[value.0 as usize]).fold(0, u64::max);
        match &self.items[unit.items.start] {
            // The other values are only needed inside of the branch.
            Item::Gate { t, .. } if known != LATER => self.values[t.0 as usize],
            Item::Compute { op: Op::Mix { t, .. }, .. } => known.max(self.masks[t.0 as usize]),
            _ => known,
        }
    }

    fn place(&mut self, items: Range<usize>) {
        let gate = self.ordered.len();
        self.put(self.items[items.start].clone());
        if items.len() == 1 {
            return;
        }
        self.order(items.start + 1..items.end - 1);
        let end = self.ordered.len();
        self.put(self.items[items.end - 1].clone());
        if let Item::Gate { join, .. } = &mut self.ordered[gate] {
            *join = end;
        }
    }

    fn put(&mut self, item: Item) {
        let (slots, latency) = weight(&item);
        let done = self.now + latency;
        item.results(|value| self.values[value.0 as usize] = done);
        if let Item::Ready(t) = &item {
            self.masks[t.0 as usize] = done;
        }
        self.now += slots * self.parts;
        self.ordered.push(item);
    }
}

/// Returns the throughput time and the latency of an item, in quarters of a cycle; measured on one processor (Zen 5),
/// rounded.
fn weight(item: &Item) -> (u64, u64) {
    match item {
        Item::Compute { op, .. } => match op {
            Op::Input(_) | Op::Line(_) | Op::Constant(_) => (0, 0),
            Op::Mix { .. } => (4, 28),
            Op::Clamp { .. } => unreachable!("clamps are split"),
            Op::Step { .. } => (3, 30),
            Op::Smooth(_) => (16, 100),
            Op::Power { n, .. } => (12 + 4 * u64::from(n.ilog2()), 60 + 32 * u64::from(n.ilog2())),
            Op::Complement(_) => (1, 8),
            Op::Product(..) => (1, 16),
        },
        Item::Over { .. } => (2, 72),
        Item::Within { .. } => (2, 16),
        Item::Ready(_) => (3, 32),
        Item::Blend { weights, .. } => (12 * weights.len() as u64, 60 + 32 * weights.len() as u64),
        Item::Partition { weights, .. } => (16 * weights.len() as u64, 160),
        Item::See { least, .. } => (1 + u64::from(least.is_some()), 0),
        Item::SeeSum { weights, .. } => (6 * weights.len() as u64, 0),
        Item::Fetch(_) | Item::Output { .. } => (1, 0),
        Item::Gate { .. } | Item::Join { .. } => (2, 0),
    }
}
