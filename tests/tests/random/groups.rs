//! Random documents with nested groups and links, each compared with the same document written out.
//!
//! The written-out form is made by the generator itself, from what it drew: names of its own, values as numbers and keys.
//! It shares nothing with the expansion of documents.

mod written;

use super::count;
use crate::support::{all_bits, evaluate, graph_in};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::path::Path;
use trochoid::{Buffers, Settings};
use written::{Flat, Grouped, Inside, document};

/// Number of documents by default.
const DOCUMENTS: u64 = 1000;
/// Frames of each document, and frames per second.
const FRAMES: usize = 3;
const FPS: f64 = 8.0;

/// What a socket or a node has.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Color,
    Mask,
}

/// A number from 0 to 1 as a document writes it.
#[derive(Clone, Debug)]
enum Number {
    Plain(f64),
    Keys([f64; FRAMES]),
    Curve(Curve),
    /// The value of a name: of a knob by index, or of the number of another node of the scope.
    Of(Name),
    /// A formula with one name, by its number.
    Formula(usize, Name),
}

/// Keys at the first and the last frame with a handle each, both as long. In the middle between them, half of the curve is
/// passed.
#[derive(Clone, Copy, Debug)]
struct Curve {
    /// Values of the first key, of the ends of its handle and of that of the last key, and of the last key.
    points: [f64; 4],
    /// Frames from each key to the end of its handle.
    reach: f64,
}

#[derive(Clone, Copy, Debug)]
enum Name {
    Knob(usize),
    Node(usize),
    Frame,
    Time,
}

/// A color as a document writes it.
#[derive(Clone, Debug)]
enum Paint {
    Hex(String),
    Knob(usize),
}

/// What is connected to a port.
#[derive(Clone, Debug)]
enum Connected {
    Input(usize),
    Node(usize, usize),
    Paint(Paint),
    Number(Number),
}

#[derive(Clone, Debug)]
enum What {
    Mix([Connected; 2], Connected),
    Ramp(Connected, [Paint; 2]),
    Across,
    Down,
    Clamp(Connected, Number),
    Multiply(Connected, Connected),
    Invert(Connected),
    /// A use: of each input and knob what is given, if anything.
    Use {
        group: usize,
        inputs: Vec<Option<Connected>>,
        numbers: Vec<Option<Number>>,
        paints: Vec<Option<Paint>>,
        disabled: bool,
    },
}

/// Nodes that see each other; those of the document or of a group.
#[derive(Clone, Debug, Default)]
struct Scope {
    inputs: Vec<(Kind, Option<Connected>)>,
    numbers: Vec<Number>,
    paints: Vec<String>,
    nodes: Vec<What>,
    outputs: Vec<(Kind, usize, usize)>,
}

/// A formula of x as text, and what it means.
type Formula = (&'static str, fn(f64) -> f64);

/// Formulas of x, from 0 to 1 for x from 0 to 1.
const FORMULAS: [Formula; 5] = [
    ("0.5 * X + 0.25", |x| 0.5 * x + 0.25),
    ("1 - X", |x| 1.0 - x),
    ("X * X", |x| x * x),
    ("(X + 0.125) / 2", |x| (x + 0.125) / 2.0),
    ("min(X, 0.5)", |x| f64::min(x, 0.5)),
];

struct Generator {
    random: Pcg64Mcg,
    groups: Vec<Scope>,
}

impl Generator {
    fn chance(&mut self, share: f64) -> bool {
        self.random.random_bool(share)
    }

    fn below(&mut self, count: usize) -> usize {
        self.random.random_range(0..count)
    }

    fn plain(&mut self) -> f64 {
        f64::from(self.random.random_range(0..=64_u32)) / 64.0
    }

    fn curve(&mut self) -> Curve {
        let points = [self.plain(), self.plain(), self.plain(), self.plain()];
        Curve { points, reach: f64::from(self.random.random_range(1..=16_u32)) / 8.0 }
    }

    fn hex(&mut self) -> String {
        format!("#{:06x}", self.random.random_range(0..1_u32 << 24))
    }

    fn number(&mut self, scope: &Scope) -> Number {
        match self.below(7) {
            0 | 1 => Number::Plain(self.plain()),
            2 if self.chance(0.5) => Number::Curve(self.curve()),
            2 => Number::Keys([self.plain(), self.plain(), self.plain()]),
            choice => {
                let named: Vec<usize> =
                    (0..scope.nodes.len()).filter(|node| self.has_number(&scope.nodes[*node])).collect();
                let name = match self.below(4) {
                    0 if !named.is_empty() => Name::Node(named[self.below(named.len())]),
                    1 => [Name::Frame, Name::Time][self.below(2)],
                    _ if !scope.numbers.is_empty() => Name::Knob(self.below(scope.numbers.len())),
                    _ => return Number::Plain(self.plain()),
                };
                match name {
                    // Frames are numbers from 1 on.
                    Name::Frame | Name::Time => Number::Formula(0, name),
                    name if choice < 5 => Number::Of(name),
                    name => Number::Formula(self.below(FORMULAS.len()), name),
                }
            }
        }
    }

    /// Whether other nodes may name the first number of a node.
    fn has_number(&self, node: &What) -> bool {
        match node {
            What::Clamp(..) => true,
            What::Use { group, .. } => !self.groups[*group].numbers.is_empty(),
            _ => false,
        }
    }

    fn paint(&mut self, scope: &Scope) -> Paint {
        if !scope.paints.is_empty() && self.chance(0.5) {
            Paint::Knob(self.below(scope.paints.len()))
        } else {
            Paint::Hex(self.hex())
        }
    }

    /// Returns all outputs of a node.
    fn outputs(&self, node: &What) -> Vec<Kind> {
        match node {
            What::Mix(..) | What::Ramp(..) => vec![Kind::Color],
            What::Use { group, .. } => self.groups[*group].outputs.iter().map(|output| output.0).collect(),
            _ => vec![Kind::Mask],
        }
    }

    fn connected(&mut self, scope: &Scope, kind: Kind) -> Connected {
        let mut known: Vec<Connected> = Vec::new();
        let inputs = scope.inputs.iter().enumerate().filter(|(_, (taken, _))| *taken == kind);
        known.extend(inputs.map(|(index, _)| Connected::Input(index)));
        for (index, node) in scope.nodes.iter().enumerate() {
            let outputs = self.outputs(node).into_iter().enumerate().filter(|(_, output)| *output == kind);
            known.extend(outputs.map(|(output, _)| Connected::Node(index, output)));
        }
        if !known.is_empty() && self.chance(0.85) {
            // Late nodes first, so that chains get long.
            let from = known.len() - known.len().min(4);
            let index =
                if self.chance(0.6) { self.random.random_range(from..known.len()) } else { self.below(known.len()) };
            return known.swap_remove(index);
        }
        match kind {
            Kind::Color => Connected::Paint(self.paint(scope)),
            Kind::Mask => Connected::Number(self.number(scope)),
        }
    }

    /// Returns a connection that a Field takes: numbers have to be nodes.
    fn field(&mut self, scope: &Scope) -> Option<Connected> {
        (0..8).map(|_| self.connected(scope, Kind::Mask)).find(|found| matches!(found, Connected::Node(..)))
    }

    fn node(&mut self, scope: &Scope) -> What {
        match self.below(10) {
            0 => What::Across,
            1 => What::Down,
            2 => match self.field(scope) {
                Some(field) => What::Clamp(field, self.number(scope)),
                None => What::Across,
            },
            3 => What::Multiply(self.connected(scope, Kind::Mask), self.connected(scope, Kind::Mask)),
            4 => What::Invert(self.connected(scope, Kind::Mask)),
            5 => What::Ramp(self.connected(scope, Kind::Mask), [self.paint(scope), self.paint(scope)]),
            6 | 7 if !self.groups.is_empty() => {
                let group = self.below(self.groups.len());
                let taken = self.groups[group].clone();
                let mut inputs = Vec::new();
                for (kind, default) in &taken.inputs {
                    let is_given = default.is_none() || self.chance(0.7);
                    inputs.push(is_given.then(|| self.connected(scope, *kind)));
                }
                let numbers = taken.numbers.iter().map(|_| self.chance(0.6).then(|| self.number(scope))).collect();
                let paints = taken.paints.iter().map(|_| self.chance(0.5).then(|| self.paint(scope))).collect();
                // It passes on its first input.
                let passes = taken.inputs.first().map(|input| input.0);
                let passes_color =
                    passes == Some(Kind::Color) && taken.outputs.iter().all(|output| output.0 == Kind::Color);
                let disabled = passes_color && self.chance(0.3);
                What::Use { group, inputs, numbers, paints, disabled }
            }
            _ => {
                let colors = [self.connected(scope, Kind::Color), self.connected(scope, Kind::Color)];
                What::Mix(colors, self.connected(scope, Kind::Mask))
            }
        }
    }

    fn scope(&mut self, is_group: bool) -> Scope {
        let mut scope = Scope::default();
        if is_group {
            for _ in 0..self.below(4) {
                let kind = if self.chance(0.6) { Kind::Color } else { Kind::Mask };
                let default = match kind {
                    Kind::Color => Connected::Paint(Paint::Hex(self.hex())),
                    Kind::Mask => Connected::Number(Number::Plain(self.plain())),
                };
                let has_default = self.chance(0.4);
                scope.inputs.push((kind, has_default.then_some(default)));
            }
            scope.paints = (0..self.below(3)).map(|_| self.hex()).collect();
        }
        for _ in 0..self.below(4) {
            let number = match self.below(6) {
                0 => Number::Keys([self.plain(), self.plain(), self.plain()]),
                1 => Number::Curve(self.curve()),
                _ => Number::Plain(self.plain()),
            };
            scope.numbers.push(number);
        }
        for _ in 0..self.random.random_range(3..9) {
            let node = self.node(&scope);
            scope.nodes.push(node);
        }
        if !is_group || self.chance(0.8) {
            let colors = [self.connected(&scope, Kind::Color), self.connected(&scope, Kind::Color)];
            let last = What::Mix(colors, self.connected(&scope, Kind::Mask));
            scope.nodes.push(last);
        }
        let last = scope.nodes.len() - 1;
        let mut ends = vec![last];
        if is_group && self.chance(0.4) {
            ends.push(self.below(scope.nodes.len()));
        }
        for node in ends {
            let kinds = self.outputs(&scope.nodes[node]);
            let output = self.below(kinds.len());
            scope.outputs.push((kinds[output], node, output));
        }
        scope
    }
}

#[test]
fn random_documents_with_groups_are_those_written_out() {
    let (mut uses, mut deepest, mut links, mut keyed, mut curved, mut disabled) = (0, 0, 0, 0, 0, 0);
    for seed in 0..count(DOCUMENTS) {
        let mut generator = Generator { random: Pcg64Mcg::seed_from_u64(seed), groups: Vec::new() };
        for _ in 0..generator.random.random_range(1..5) {
            let group = generator.scope(true);
            generator.groups.push(group);
        }
        let scope = generator.scope(false);
        let grouped = Grouped { groups: &generator.groups }.text(&scope);
        let mut flat = Flat { groups: &generator.groups, nodes: Vec::new(), uses: 0 };
        let nothing = Inside::of(&scope);
        let numbers = scope.numbers.iter().map(|number| Flat::value(number, &nothing)).collect();
        let outputs = flat.scope(Inside { numbers, ..nothing });
        let written_out = document("", &flat.nodes.join(",\n  "), outputs[0].trim_matches('"'));

        let (grouped, by_hand) = (graph_in(Path::new("."), &grouped), (graph_in(Path::new("."), &written_out)));
        assert_eq!(grouped.nodes().len(), by_hand.nodes().len(), "document {seed}");
        for frame in 1..=FRAMES as i64 {
            let picture = |graph| all_bits(&evaluate(graph, frame, &Buffers::new(), &Settings::default()));
            assert_eq!(picture(&grouped), picture(&by_hand), "document {seed}, frame {frame}:\n{written_out}");
        }
        uses += grouped.groups().len();
        deepest = grouped.groups().iter().map(|used| used.path.matches('/').count() + 1).fold(deepest, usize::max);
        assert_eq!(grouped.groups().len(), flat.uses, "document {seed}");
        let text = grouped.canonical();
        links += text.matches("\"= ").count();
        keyed += text.matches("keys").count();
        curved += text.matches("\"out\"").count();
        disabled += text.matches("disabled").count();
    }
    // A generator that produced nothing of interest would prove nothing.
    if count(DOCUMENTS) >= DOCUMENTS {
        assert!(
            uses > 1500 && deepest >= 3 && links > 3000 && keyed > 1000 && curved > 500 && disabled > 50,
            "{uses} {deepest} {links} {keyed} {curved} {disabled}"
        );
    }
}
