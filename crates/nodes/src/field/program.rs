//! Expressions of FieldMath for many samples at once: a list of steps, each over a run of samples.

use super::expression::{Expression, Node};
use fearless_simd::{Level, Simd, dispatch};
use std::collections::HashMap;
use trochoid_graph::Span;

macro_rules! functions {
    ($($name:ident $text:literal ($least:literal) $of:expr;)*) => {
        /// What is computed of numbers.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub(crate) enum Function { $($name,)* }

        impl Function {
            const ALL: &[Self] = &[$(Self::$name,)*];

            fn text(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }

            /// Every function.
            #[cfg(test)]
            pub(crate) fn all() -> &'static [Self] {
                Self::ALL
            }

            /// Fewest and most arguments.
            pub(crate) fn arguments(self) -> (usize, usize) {
                match self { $(Self::$name => ($least, $least),)* }
            }

            /// The function over a run of samples.
            #[inline(always)]
            fn fill(self, [a, b, c]: [&[f64]; 3], out: &mut [f64]) {
                match self {
                    $(Self::$name => {
                        let of: fn(f64, f64, f64) -> f64 = $of;
                        for (((out, a), b), c) in out.iter_mut().zip(a).zip(b).zip(c) {
                            *out = of(*a, *b, *c);
                        }
                    })*
                }
            }

            /// The function of one number each.
            pub(crate) fn of(self, arguments: &[f64]) -> f64 {
                let argument = |index: usize| arguments.get(index).copied().unwrap_or(0.0);
                let of: fn(f64, f64, f64) -> f64 = match self { $(Self::$name => $of,)* };
                of(argument(0), argument(1), argument(2))
            }
        }
    };
}

fn truth(holds: bool) -> f64 {
    if holds { 1.0 } else { 0.0 }
}

/// The second of two numbers if so told, else the first; NaN where either is.
fn either(a: f64, b: f64, second: bool) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::NAN
    } else if second {
        b
    } else {
        a
    }
}

fn least(a: f64, b: f64) -> f64 {
    either(a, b, b < a)
}

fn most(a: f64, b: f64) -> f64 {
    either(a, b, b > a)
}

/// t²(3 − 2t) of how far x lies from a to b.
fn smoothstep(a: f64, b: f64, x: f64) -> f64 {
    let t = least(most((x - a) / (b - a), 0.0), 1.0);
    t * t * (3.0 - 2.0 * t)
}

// Names without letters are operators; those of functions are what documents write.
functions! {
    Add "+" (2) |a, b, _| a + b;
    Subtract "-" (2) |a, b, _| a - b;
    Multiply "*" (2) |a, b, _| a * b;
    Divide "/" (2) |a, b, _| a / b;
    Power "^" (2) |a, b, _| libm::pow(a, b);
    Negate "-" (1) |a, _, _| -a;
    Less "<" (2) |a, b, _| truth(a < b);
    LessOrEqual "<=" (2) |a, b, _| truth(a <= b);
    Greater ">" (2) |a, b, _| truth(a > b);
    GreaterOrEqual ">=" (2) |a, b, _| truth(a >= b);
    Equal "==" (2) |a, b, _| truth(a == b);
    Unequal "!=" (2) |a, b, _| truth(a != b);
    Least "min" (2) |a, b, _| least(a, b);
    Most "max" (2) |a, b, _| most(a, b);
    Clamp "clamp" (3) |x, low, high| least(most(x, low), high);
    Abs "abs" (1) |a, _, _| a.abs();
    Sign "sign" (1) |a, _, _| if a.is_nan() { a } else { truth(a > 0.0) - truth(a < 0.0) };
    Floor "floor" (1) |a, _, _| a.floor();
    Ceil "ceil" (1) |a, _, _| a.ceil();
    Fract "fract" (1) |a, _, _| a - a.floor();
    Mod "mod" (2) |a, b, _| a - b * (a / b).floor();
    Sqrt "sqrt" (1) |a, _, _| a.sqrt();
    Exp "exp" (1) |a, _, _| libm::exp(a);
    Log "log" (1) |a, _, _| libm::log(a);
    Sin "sin" (1) |a, _, _| libm::sin(a);
    Cos "cos" (1) |a, _, _| libm::cos(a);
    Atan2 "atan2" (2) |y, x, _| libm::atan2(y, x);
    Smoothstep "smoothstep" (3) |a, b, x| smoothstep(a, b, x);
    Mix "mix" (3) |a, b, t| (1.0 - t) * a + t * b;
    If "if" (3) |condition, a, b| if condition != 0.0 { a } else { b };
}

impl Function {
    /// The function of a name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|function| function.text() == name)
    }

    /// Every name that can be called.
    pub(crate) fn names() -> Vec<&'static str> {
        let texts = Self::ALL.iter().map(|function| function.text());
        texts.filter(|text| text.starts_with(|c: char| c.is_ascii_alphabetic())).collect()
    }
}

/// One step: its result is known by its place in the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Step {
    /// The bits of a number.
    Constant(u64),
    Input {
        input: usize,
        component: usize,
    },
    /// Arguments beyond those of the function repeat the first.
    Apply(Function, [usize; 3]),
}

/// An expression as steps, no two alike.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    steps: Vec<Step>,
    /// The steps of the result's components.
    results: Vec<usize>,
}

/// Samples in a run: the results of a few dozen steps stay in the nearest cache.
const RUN: usize = 64;

impl Program {
    pub(crate) fn new(expression: &Expression) -> Self {
        let mut building = Building::default();
        let results = building.components(expression);
        Self { steps: building.steps, results }
    }

    /// Components of the result.
    pub(crate) fn width(&self) -> usize {
        self.results.len()
    }

    /// Computes `count` samples, run by run. `load(first, input, component, run)` gives a run of an input from sample
    /// `first` on, `store(first, component, run)` takes a run of the result.
    pub(crate) fn run(
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
        let mut memory = vec![[0.0; RUN]; self.steps.len()];
        for (place, step) in self.steps.iter().enumerate() {
            if let Step::Constant(bits) = step {
                memory[place] = [f64::from_bits(*bits); RUN];
            }
        }
        for start in (0..count).step_by(RUN) {
            let length = RUN.min(count - start);
            for (place, step) in self.steps.iter().enumerate() {
                let (before, rest) = memory.split_at_mut(place);
                let out = &mut rest[0][..length];
                match step {
                    Step::Constant(_) => {}
                    Step::Input { input, component } => load(start, *input, *component, out),
                    Step::Apply(function, arguments) => {
                        function.fill(arguments.map(|argument| &before[argument][..length]), out);
                    }
                }
            }
            for (component, place) in self.results.iter().enumerate() {
                store(start, component, &memory[*place][..length]);
            }
        }
    }

    /// The spans of the result's components at one sample, of those of the inputs there.
    pub(crate) fn spans(&self, input: impl Fn(usize, usize) -> Span) -> Vec<Span> {
        let mut spans: Vec<Span> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            spans.push(match step {
                Step::Constant(bits) => Span::exactly(f64::from_bits(*bits)),
                Step::Input { input: port, component } => input(*port, *component),
                Step::Apply(function, arguments) => function.span(arguments.map(|argument| spans[argument])),
            });
        }
        self.results.iter().map(|place| spans[*place]).collect()
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

    /// Σ aᵢ·bᵢ.
    fn dot(&mut self, a: &[usize], b: &[usize]) -> usize {
        let products: Vec<usize> = a.iter().zip(b).map(|(a, b)| self.apply(Function::Multiply, &[*a, *b])).collect();
        let mut sum = products[0];
        for product in &products[1..] {
            sum = self.apply(Function::Add, &[sum, *product]);
        }
        sum
    }

    /// The steps of an expression's components.
    fn components(&mut self, expression: &Expression) -> Vec<usize> {
        match &expression.node {
            Node::Number(number) => vec![self.step(Step::Constant(number.to_bits()))],
            Node::Input(input) => {
                (0..expression.width).map(|component| self.step(Step::Input { input: *input, component })).collect()
            }
            Node::Each(function, arguments) => {
                let values: Vec<Vec<usize>> = arguments.iter().map(|argument| self.components(argument)).collect();
                let of_each = |index: usize| -> Vec<usize> {
                    values.iter().map(|steps| steps[if steps.len() == 1 { 0 } else { index }]).collect()
                };
                (0..expression.width).map(|index| self.apply(*function, &of_each(index))).collect()
            }
            Node::Dot(a, b) => {
                let (a, b) = (self.components(a), self.components(b));
                vec![self.dot(&a, &b)]
            }
            Node::Length(a) => {
                let a = self.components(a);
                let squared = self.dot(&a, &a);
                vec![self.apply(Function::Sqrt, &[squared])]
            }
            Node::Pick(a, picked) => {
                let steps = self.components(a);
                picked.iter().map(|index| steps[*index]).collect()
            }
            Node::Join(values) => values.iter().flat_map(|value| self.components(value)).collect(),
        }
    }
}
