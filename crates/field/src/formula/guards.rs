//! Which steps of a program matter for a run of samples.

use super::Function;
use super::program::Step;
use std::collections::HashMap;
use trochoid_memory::Scratch;

/// A condition under which steps matter, within another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Guard {
    /// Step whose value decides.
    condition: usize,
    /// Whether the steps matter where the condition is not 0, rather than where it is.
    holds: bool,
    within: usize,
}

/// The guard that always holds.
const ALWAYS: usize = 0;

/// A step that is not a constant, and when it matters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub(super) step: usize,
    guard: usize,
    /// The next turn if the guard does not hold: the first whose guard is not within it.
    pub(super) next: usize,
}

/// The steps of a program in their order, with the guards under which their values matter. Where a step does not matter,
/// its value is arbitrary: what it was for earlier samples, or 0.
///
/// Of `if(condition, a, b)`, what only `a` needs does not matter where the condition is 0, and what only `b` needs where
/// it is not 0. Of a product of numbers that are always 0 or 1, the second does not matter where the first is 0.
#[derive(Clone, Debug)]
pub(super) struct Guards {
    guards: Vec<Guard>,
    pub(super) turns: Vec<Turn>,
}

impl Guards {
    pub(super) fn new(steps: &[Step], results: &[usize]) -> Self {
        let is_truth = truths(steps);
        let always = Guard { condition: 0, holds: true, within: ALWAYS };
        let mut this = Self { guards: vec![always], turns: Vec::new() };
        let mut places = HashMap::new();
        // Guards of the steps; `None` if a step never matters.
        let mut of_steps = vec![None; steps.len()];
        for result in results {
            of_steps[*result] = Some(ALWAYS);
        }
        // Steps stand behind those that they need.
        for place in (0..steps.len()).rev() {
            let (Some(within), Step::Apply(function, arguments)) = (of_steps[place], &steps[place]) else { continue };
            for (index, argument) in arguments[..function.arguments()].iter().enumerate() {
                let condition = arguments[0];
                let holds = match (function, index) {
                    (Function::If, 1 | 2) => Some(index == 1),
                    (Function::Multiply, 1) if is_truth[condition] && is_truth[*argument] => Some(true),
                    _ => None,
                };
                let guard = holds.map_or(within, |holds| {
                    let guard = Guard { condition, holds, within };
                    *places.entry(guard).or_insert_with(|| {
                        this.guards.push(guard);
                        this.guards.len() - 1
                    })
                });
                of_steps[*argument] = Some(of_steps[*argument].map_or(guard, |other| this.common(guard, other)));
            }
        }
        for (step, guard) in of_steps.into_iter().enumerate() {
            let Some(mut guard) = guard.filter(|_| !matches!(steps[step], Step::Constant(_))) else { continue };
            // A step that stands before a condition cannot wait for it.
            let mut outer = guard;
            while outer != ALWAYS {
                let Guard { condition, within, .. } = this.guards[outer];
                if condition >= step {
                    guard = within;
                }
                outer = within;
            }
            this.turns.push(Turn { step, guard, next: 0 });
        }
        for index in (0..this.turns.len()).rev() {
            let (guard, mut next) = (this.turns[index].guard, index + 1);
            while let Some(turn) = this.turns.get(next)
                && this.common(turn.guard, guard) == guard
            {
                next = turn.next;
            }
            this.turns[index].next = next;
        }
        this
    }

    /// Returns the innermost guard that holds wherever one of two does.
    fn common(&self, a: usize, b: usize) -> usize {
        // Guards stand behind those that they are within.
        let (mut a, mut b) = (a, b);
        while a != b {
            (a, b) = (a.min(b), self.guards[a.max(b)].within);
        }
        a
    }

    /// Returns which guards are known to hold for a run of samples: only that which always does.
    pub(super) fn unknown(&self) -> Scratch<Option<bool>> {
        let mut known = Scratch::of(None, self.guards.len());
        known[ALWAYS] = Some(true);
        known
    }

    /// Returns whether a step matters for a run of samples, from the values of the steps before it.
    #[inline(always)]
    pub(super) fn matters<const N: usize>(
        &self,
        turn: Turn,
        before: &[[f64; N]],
        length: usize,
        known: &mut [Option<bool>],
    ) -> bool {
        known[turn.guard].unwrap_or_else(|| self.holds(turn.guard, before, length, known))
    }

    fn holds<const N: usize>(
        &self,
        guard: usize,
        before: &[[f64; N]],
        length: usize,
        known: &mut [Option<bool>],
    ) -> bool {
        let Guard { condition, holds, within } = self.guards[guard];
        let mut found = known[within].unwrap_or_else(|| self.holds(within, before, length, known));
        if found {
            // Without an early end, this is vector code.
            let values = &before[condition][..length];
            found = values.iter().fold(false, |found, value| found | ((*value != 0.0) == holds));
        }
        known[guard] = Some(found);
        found
    }
}

/// Returns which steps are always 0 or 1.
fn truths(steps: &[Step]) -> Vec<bool> {
    let mut truths: Vec<bool> = Vec::with_capacity(steps.len());
    for step in steps {
        truths.push(match step {
            Step::Constant(bits) => [0.0, 1.0].map(f64::to_bits).contains(bits),
            Step::Input { .. } => false,
            Step::Apply(function, [a, b, c]) => match function {
                Function::Less
                | Function::LessOrEqual
                | Function::Greater
                | Function::GreaterOrEqual
                | Function::Equal
                | Function::Unequal => true,
                Function::Multiply | Function::Least | Function::Most => truths[*a] && truths[*b],
                Function::If => truths[*b] && truths[*c],
                _ => false,
            },
        });
    }
    truths
}
