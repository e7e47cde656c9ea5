//! Expressions for many samples at once: a list of steps, each over a run of samples.

use super::function::{Function, WIDE};
use super::guards::Guards;
use super::{Expression, Tree};
use fearless_simd::{Level, Simd, dispatch};
use std::collections::HashMap;
use trochoid_graph::Span;
use trochoid_memory::Scratch;

/// One step; later steps refer to its result by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Step {
    /// A number, by its bits.
    Constant(u64),
    Input {
        input: usize,
        component: usize,
    },
    /// A function of earlier steps. Unused arguments repeat the first.
    Apply(Function, [usize; 3]),
}

/// An expression as a list of distinct steps.
#[derive(Clone, Debug)]
pub struct Program {
    steps: Vec<Step>,
    /// Steps that compute the components of the result.
    results: Vec<usize>,
    guards: Guards,
}

/// Samples in a run, so few that the results of two dozen steps stay in the level-1 cache.
const RUN: usize = 128;

impl Program {
    /// Compiles an expression.
    pub fn new(expression: &Expression) -> Self {
        let mut building = Building::default();
        let results = building.components(expression);
        let guards = Guards::new(&building.steps, &results);
        Self { steps: building.steps, results, guards }
    }

    /// Returns the number of components of the result.
    pub fn width(&self) -> usize {
        self.results.len()
    }

    /// Computes `count` samples, run by run. `load(first, input, component, run)` loads a run of an input that starts
    /// at sample `first`; `store(first, component, run)` stores a run of the result.
    pub fn run(
        &self,
        count: usize,
        mut load: impl FnMut(usize, usize, usize, &mut [f64]),
        mut store: impl FnMut(usize, usize, &[f64]),
    ) {
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || self.run_here(count, &mut load, &mut store)
        ));
    }

    #[inline(always)]
    fn run_here(
        &self,
        count: usize,
        load: &mut impl FnMut(usize, usize, usize, &mut [f64]),
        store: &mut impl FnMut(usize, usize, &[f64]),
    ) {
        let mut memory = Scratch::of([0.0; RUN], self.steps.len());
        for (place, step) in self.steps.iter().enumerate() {
            if let Step::Constant(bits) = step {
                memory[place] = [f64::from_bits(*bits); RUN];
            }
        }
        let mut known = self.guards.unknown();
        for start in (0..count).step_by(RUN) {
            let length = RUN.min(count - start);
            // Whole vectors: what lies beyond the samples does no harm.
            let wide = length.next_multiple_of(WIDE);
            known[1..].fill(None);
            let mut next = 0;
            while let Some(turn) = self.guards.turns.get(next).copied() {
                let (before, rest) = memory.split_at_mut(turn.step);
                if !self.guards.matters(turn, before, length, &mut known) {
                    next = turn.next;
                    continue;
                }
                next += 1;
                match self.steps[turn.step] {
                    Step::Constant(_) => {}
                    Step::Input { input, component } => load(start, input, component, &mut rest[0][..length]),
                    Step::Apply(function, arguments) => {
                        function.fill(arguments.map(|argument| &before[argument][..wide]), &mut rest[0][..wide]);
                    }
                }
            }
            for (component, place) in self.results.iter().enumerate() {
                store(start, component, &memory[*place][..length]);
            }
        }
    }

    /// Computes the spans of `count` samples, run by run. `load(first, input, component, run)` loads a run of spans of an
    /// input that starts at sample `first`; `store(first, component, run)` stores a run of the result.
    pub fn spans(
        &self,
        count: usize,
        mut load: impl FnMut(usize, usize, usize, &mut [Span]),
        mut store: impl FnMut(usize, usize, &[Span]),
    ) {
        let mut memory: Scratch<[Span; RUN]> = Scratch::new();
        // Steps that depend on inputs.
        let mut varying = Scratch::new();
        for (place, step) in self.steps.iter().enumerate() {
            let fixed = match step {
                Step::Constant(bits) => Some(Span::exactly(f64::from_bits(*bits))),
                Step::Input { .. } => None,
                // Of arguments that no input changes: a result that depends on an input is among `varying`.
                Step::Apply(function, arguments) => {
                    let is_fixed = arguments.iter().all(|argument| varying.binary_search(argument).is_err());
                    is_fixed.then(|| function.span(arguments.map(|argument| memory[argument][0])))
                }
            };
            if fixed.is_none() {
                varying.push(place);
            }
            memory.push([fixed.unwrap_or(Span::ANY); RUN]);
        }
        for start in (0..count).step_by(RUN) {
            let length = RUN.min(count - start);
            for place in &varying {
                let (before, rest) = memory.split_at_mut(*place);
                let out = &mut rest[0][..length];
                match &self.steps[*place] {
                    Step::Constant(bits) => out.fill(Span::exactly(f64::from_bits(*bits))),
                    Step::Input { input, component } => load(start, *input, *component, out),
                    Step::Apply(function, arguments) => {
                        function.fill_spans(arguments.map(|argument| &before[argument][..length]), out);
                    }
                }
            }
            for (component, place) in self.results.iter().enumerate() {
                store(start, component, &memory[*place][..length]);
            }
        }
    }
}

#[derive(Default)]
struct Building {
    steps: Vec<Step>,
    places: HashMap<Step, usize>,
}

impl Building {
    fn step(&mut self, step: Step) -> usize {
        *self.places.entry(step).or_insert_with(|| {
            self.steps.push(step);
            self.steps.len() - 1
        })
    }

    fn apply(&mut self, function: Function, arguments: &[usize]) -> usize {
        let argument = |index: usize| arguments.get(index).copied().unwrap_or(arguments[0]);
        self.step(Step::Apply(function, [argument(0), argument(1), argument(2)]))
    }

    /// Adds the steps of Σ aᵢ·bᵢ.
    fn dot(&mut self, a: &[usize], b: &[usize]) -> usize {
        let products: Vec<usize> = a.iter().zip(b).map(|(a, b)| self.apply(Function::Multiply, &[*a, *b])).collect();
        let mut sum = products[0];
        for product in &products[1..] {
            sum = self.apply(Function::Add, &[sum, *product]);
        }
        sum
    }

    /// Adds the steps of an expression and returns those of its components.
    fn components(&mut self, expression: &Expression) -> Vec<usize> {
        match &expression.tree {
            Tree::Number(number) => vec![self.step(Step::Constant(number.to_bits()))],
            Tree::Input(input) => {
                (0..expression.width).map(|component| self.step(Step::Input { input: *input, component })).collect()
            }
            Tree::Each(function, arguments) => {
                let values: Vec<Vec<usize>> = arguments.iter().map(|argument| self.components(argument)).collect();
                let of_each = |index: usize| -> Vec<usize> {
                    values.iter().map(|steps| steps[if steps.len() == 1 { 0 } else { index }]).collect()
                };
                (0..expression.width).map(|index| self.apply(*function, &of_each(index))).collect()
            }
            Tree::Dot(a, b) => {
                let (a, b) = (self.components(a), self.components(b));
                vec![self.dot(&a, &b)]
            }
            Tree::Length(a) => {
                let a = self.components(a);
                let squared = self.dot(&a, &a);
                vec![self.apply(Function::Sqrt, &[squared])]
            }
            Tree::Pick(a, picked) => {
                let steps = self.components(a);
                picked.iter().map(|index| steps[*index]).collect()
            }
            Tree::Join(values) => values.iter().flat_map(|value| self.components(value)).collect(),
        }
    }
}
