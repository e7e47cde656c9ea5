//! What was drawn, written in both ways: with groups and links, and written out.

use super::{Connected, Curve, FORMULAS, FPS, FRAMES, Kind, Name, Number, Paint, Scope, What};
use std::fmt::Write as _;

/// Writes what was drawn with groups and links.
pub(super) struct Grouped<'g> {
    pub(super) groups: &'g [Scope],
}

impl Grouped<'_> {
    fn name(name: Name, scope: &Scope) -> String {
        match name {
            Name::Knob(knob) => format!("knobs.k{knob}"),
            Name::Node(node) => match &scope.nodes[node] {
                What::Use { .. } => format!("n{node}.k0"),
                _ => format!("n{node}.max"),
            },
            Name::Frame => "frame / 8".into(),
            Name::Time => "time".into(),
        }
    }

    fn number(number: &Number, scope: &Scope) -> String {
        match number {
            Number::Plain(value) => value.to_string(),
            Number::Keys(values) => keys(*values),
            Number::Curve(curve) => curve.text(),
            Number::Of(name) => format!("\"= {}\"", Self::name(*name, scope)),
            Number::Formula(formula, name) => {
                let x = format!("({})", Self::name(*name, scope));
                format!("\"= {}\"", FORMULAS[*formula].0.replace('X', &x))
            }
        }
    }

    fn paint(paint: &Paint) -> String {
        match paint {
            Paint::Hex(hex) => format!("\"{hex}\""),
            Paint::Knob(knob) => format!("\"= knobs.p{knob}\""),
        }
    }

    fn connected(&self, connected: &Connected, scope: &Scope) -> String {
        match connected {
            Connected::Input(input) => format!("\"i{input}\""),
            // The first output need not be named.
            Connected::Node(node, 0) => format!("\"n{node}\""),
            Connected::Node(node, output) => format!("\"n{node}.o{output}\""),
            Connected::Paint(paint) => Self::paint(paint),
            Connected::Number(number) => Self::number(number, scope),
        }
    }

    fn node(&self, node: &What, scope: &Scope) -> String {
        let port = |connected: &Connected| self.connected(connected, scope);
        match node {
            What::Mix([a, b], weight) => {
                format!("{{ \"type\": \"Mix\", \"a\": {}, \"b\": {}, \"weight\": {} }}", port(a), port(b), port(weight))
            }
            What::Ramp(weight, [a, b]) => format!(
                "{{ \"type\": \"Ramp\", \"weight\": {}, \"stops\": [{{ \"at\": 0, \"color\": {} }}, {{ \"at\": 1, \"color\": {} }}] }}",
                port(weight),
                Self::paint(a),
                Self::paint(b)
            ),
            What::Across => "{ \"type\": \"ScreenX\" }".into(),
            What::Down => "{ \"type\": \"ScreenY\" }".into(),
            What::Clamp(field, max) => format!(
                "{{ \"type\": \"Clamp\", \"field\": {}, \"min\": -0.25, \"max\": {} }}",
                port(field),
                Self::number(max, scope)
            ),
            What::Multiply(a, b) => format!("{{ \"type\": \"Multiply\", \"weights\": [{}, {}] }}", port(a), port(b)),
            What::Invert(weight) => format!("{{ \"type\": \"Invert\", \"weight\": {} }}", port(weight)),
            What::Use { group, inputs, numbers, paints, disabled } => {
                let mut text = format!("{{ \"type\": \"G{group}\"");
                for (index, input) in inputs.iter().enumerate() {
                    if let Some(input) = input {
                        let _ = write!(text, ", \"i{index}\": {}", port(input));
                    }
                }
                for (index, number) in numbers.iter().enumerate() {
                    if let Some(number) = number {
                        let _ = write!(text, ", \"k{index}\": {}", Self::number(number, scope));
                    }
                }
                for (index, paint) in paints.iter().enumerate() {
                    if let Some(paint) = paint {
                        let _ = write!(text, ", \"p{index}\": {}", Self::paint(paint));
                    }
                }
                if *disabled {
                    text += ", \"disabled\": true";
                }
                text + " }"
            }
        }
    }

    fn nodes(&self, scope: &Scope) -> String {
        let nodes = scope.nodes.iter().enumerate();
        nodes.map(|(index, node)| format!("\"n{index}\": {}", self.node(node, scope))).collect::<Vec<_>>().join(",\n  ")
    }

    pub(super) fn text(&self, scope: &Scope) -> String {
        let mut groups = Vec::new();
        for (index, group) in self.groups.iter().enumerate() {
            let input = |(index, (kind, default)): (usize, &(Kind, Option<Connected>))| match default {
                None => format!("\"i{index}\": \"{kind:?}\""),
                Some(value) => {
                    let value = self.connected(value, group);
                    format!("\"i{index}\": {{ \"kind\": \"{kind:?}\", \"default\": {value} }}")
                }
            };
            let inputs: Vec<String> = group.inputs.iter().enumerate().map(input).collect();
            let numbers = group.numbers.iter().enumerate();
            let numbers = numbers.map(|(index, number)| {
                format!("\"k{index}\": {{ \"default\": {}, \"min\": 0, \"max\": 1 }}", Self::number(number, group))
            });
            let paints = group.paints.iter().enumerate().map(|(index, hex)| format!("\"p{index}\": \"{hex}\""));
            let knobs: Vec<String> = numbers.chain(paints).collect();
            let output = |(index, (_, node, output)): (usize, &(Kind, usize, usize))| {
                format!("\"o{index}\": {}", self.connected(&Connected::Node(*node, *output), group))
            };
            let outputs: Vec<String> = group.outputs.iter().enumerate().map(output).collect();
            groups.push(format!(
                "\"G{index}\": {{ \"inputs\": {{ {} }}, \"knobs\": {{ {} }},\n \"nodes\": {{ {} }},\n \"outputs\": {{ {} }} }}",
                inputs.join(", "),
                knobs.join(", "),
                self.nodes(group),
                outputs.join(", ")
            ));
        }
        let knobs = scope.numbers.iter().enumerate();
        let knobs: Vec<String> = knobs
            .map(|(index, number)| format!("\"k{index}\": {{ \"value\": {} }}", Self::number(number, scope)))
            .collect();
        let last = scope.nodes.len() - 1;
        document(
            &format!("\"knobs\": {{ {} }}, \"groups\": {{ {} }},", knobs.join(", "), groups.join(",\n")),
            &self.nodes(scope),
            &format!("n{last}"),
        )
    }
}

impl Curve {
    fn text(&self) -> String {
        let ([from, out, back, to], reach) = (self.points, self.reach);
        let first = format!("[1, {from}, {{ \"out\": [{reach}, {}] }}]", out - from);
        let last = format!("[{FRAMES}, {to}, {{ \"in\": [-{reach}, {}] }}]", back - to);
        format!("{{ \"keys\": [{first}, {last}] }}")
    }

    /// Returns the values at the frames, of which there are three.
    fn values(&self) -> [f64; FRAMES] {
        let [from, out, back, to] = self.points;
        [from, (from + 3.0 * out + 3.0 * back + to) / 8.0, to]
    }
}

fn keys(values: [f64; FRAMES]) -> String {
    let keys: Vec<String> = values.iter().enumerate().map(|(at, value)| format!("[{}, {value}]", at + 1)).collect();
    format!("{{ \"keys\": [{}] }}", keys.join(", "))
}

pub(super) fn document(more: &str, nodes: &str, output: &str) -> String {
    format!(
        "{{ \"trochoid\": 1, \"format\": {{ \"width\": 7, \"height\": 5 }},\n\"frames\": {{ \"first\": 1, \"last\": {FRAMES}, \
         \"fps\": {FPS} }}, {more}\n\"nodes\": {{ {nodes} }},\n\"outputs\": {{ \"o\": {{ \"color\": \"{output}\" }} }} }}"
    )
}

/// A value at each frame, and whether it is the same by its nature.
#[derive(Clone, Copy)]
pub(super) struct Known {
    values: [f64; FRAMES],
    is_keyed: bool,
}

/// What is known within a scope as it is used: texts of connected inputs, values of knobs.
pub(super) struct Inside<'s> {
    pub(super) scope: &'s Scope,
    pub(super) prefix: String,
    pub(super) inputs: Vec<String>,
    pub(super) numbers: Vec<Known>,
    pub(super) paints: Vec<String>,
    /// Values of each node that may be named, and what its outputs are called.
    pub(super) named: Vec<Option<Known>>,
    pub(super) outputs: Vec<Vec<String>>,
}

impl<'s> Inside<'s> {
    /// Returns a scope of which nothing is known yet.
    pub(super) fn of(scope: &'s Scope) -> Self {
        let (inputs, numbers, paints, named, outputs) = Default::default();
        Self { scope, prefix: String::new(), inputs, numbers, paints, named, outputs }
    }
}

/// Writes everything out.
pub(super) struct Flat<'g> {
    pub(super) groups: &'g [Scope],
    pub(super) nodes: Vec<String>,
    pub(super) uses: usize,
}

impl Flat<'_> {
    pub(super) fn value(number: &Number, inside: &Inside<'_>) -> Known {
        let of = |name: Name| match name {
            Name::Knob(knob) => inside.numbers[knob],
            Name::Node(node) => inside.named[node].unwrap(),
            Name::Frame => Known { values: std::array::from_fn(|at| (at + 1) as f64 / 8.0), is_keyed: true },
            Name::Time => Known { values: std::array::from_fn(|at| at as f64 / FPS), is_keyed: true },
        };
        match number {
            Number::Plain(value) => Known { values: [*value; FRAMES], is_keyed: false },
            Number::Keys(values) => Known { values: *values, is_keyed: true },
            Number::Curve(curve) => Known { values: curve.values(), is_keyed: true },
            Number::Of(name) => of(*name),
            Number::Formula(formula, name) => {
                let known = of(*name);
                Known { values: known.values.map(FORMULAS[*formula].1), ..known }
            }
        }
    }

    fn number(number: &Number, inside: &Inside<'_>) -> String {
        let known = Self::value(number, inside);
        if known.is_keyed { keys(known.values) } else { known.values[0].to_string() }
    }

    fn paint(paint: &Paint, inside: &Inside<'_>) -> String {
        match paint {
            Paint::Hex(hex) => format!("\"{hex}\""),
            Paint::Knob(knob) => inside.paints[*knob].clone(),
        }
    }

    fn connected(connected: &Connected, inside: &Inside<'_>) -> String {
        match connected {
            Connected::Input(input) => inside.inputs[*input].clone(),
            Connected::Node(node, output) => inside.outputs[*node][*output].clone(),
            Connected::Paint(paint) => Self::paint(paint, inside),
            Connected::Number(number) => Self::number(number, inside),
        }
    }

    /// Writes the nodes of a scope; returns what its outputs are called.
    pub(super) fn scope(&mut self, mut inside: Inside<'_>) -> Vec<String> {
        for (index, node) in inside.scope.nodes.iter().enumerate() {
            let name = format!("{}n{index}", inside.prefix);
            let port = |connected: &Connected| Self::connected(connected, &inside);
            let mut named = None;
            let text = match node {
                What::Mix([a, b], weight) => {
                    format!("\"type\": \"Mix\", \"a\": {}, \"b\": {}, \"weight\": {}", port(a), port(b), port(weight))
                }
                What::Ramp(weight, colors) => {
                    let [a, b] = colors.each_ref().map(|color| Self::paint(color, &inside));
                    let stops = format!("{{ \"at\": 0, \"color\": {a} }}, {{ \"at\": 1, \"color\": {b} }}");
                    format!("\"type\": \"Ramp\", \"weight\": {}, \"stops\": [{stops}]", port(weight))
                }
                What::Across => "\"type\": \"ScreenX\"".into(),
                What::Down => "\"type\": \"ScreenY\"".into(),
                What::Clamp(field, max) => {
                    named = Some(Self::value(max, &inside));
                    let max = Self::number(max, &inside);
                    format!("\"type\": \"Clamp\", \"field\": {}, \"min\": -0.25, \"max\": {max}", port(field))
                }
                What::Multiply(a, b) => format!("\"type\": \"Multiply\", \"weights\": [{}, {}]", port(a), port(b)),
                What::Invert(weight) => format!("\"type\": \"Invert\", \"weight\": {}", port(weight)),
                What::Use { group, inputs, numbers, paints, disabled } => {
                    self.uses += 1;
                    let used = &self.groups[*group];
                    let nothing = Inside::of(used);
                    let input = |(given, (_, default)): (&Option<Connected>, &(Kind, Option<Connected>))| match given {
                        Some(given) => port(given),
                        None => Self::connected(default.as_ref().unwrap(), &nothing),
                    };
                    let number = |(given, default): (&Option<Number>, &Number)| match given {
                        Some(given) => Self::value(given, &inside),
                        None => Self::value(default, &nothing),
                    };
                    let paint = |(given, default): (&Option<Paint>, &String)| match given {
                        Some(given) => Self::paint(given, &inside),
                        None => format!("\"{default}\""),
                    };
                    let within = Inside {
                        prefix: format!("{name}_"),
                        inputs: inputs.iter().zip(&used.inputs).map(input).collect(),
                        numbers: numbers.iter().zip(&used.numbers).map(number).collect(),
                        paints: paints.iter().zip(&used.paints).map(paint).collect(),
                        ..nothing
                    };
                    named = within.numbers.first().copied();
                    let outputs =
                        if *disabled { vec![within.inputs[0].clone(); used.outputs.len()] } else { self.scope(within) };
                    inside.named.push(named);
                    inside.outputs.push(outputs);
                    continue;
                }
            };
            self.nodes.push(format!("\"{name}\": {{ {text} }}"));
            inside.named.push(named);
            inside.outputs.push(vec![format!("\"{name}\"")]);
        }
        inside.scope.outputs.iter().map(|(_, node, output)| inside.outputs[*node][*output].clone()).collect()
    }
}
