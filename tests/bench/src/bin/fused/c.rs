//! C code of a graph as written by hand: all nodes in one loop, in local variables.

use crate::graph::{Graph, HEIGHT, Node, PASSES, Paint, WIDTH};
use std::fmt::Write as _;

/// C code around the function, which answers requests.
const MAIN: &str = include_str!("main.c");

/// Rate at which a value is computed.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Rate {
    /// Once per column: the value depends only on x.
    Column,
    Pixel,
}

/// A mask or field: a variable.
#[derive(Clone)]
struct Scalar {
    name: String,
    rate: Rate,
}

/// A color.
#[derive(Clone)]
enum Color {
    Constant([f32; 3]),
    /// Three variables: the name, and r, g or b.
    Variables(String, Rate),
}

impl Color {
    fn rate(&self) -> Rate {
        if let Self::Variables(_, rate) = self { *rate } else { Rate::Column }
    }
}

/// C code, and the number of mixes in it.
pub(crate) struct Code {
    pub(crate) text: String,
    pub(crate) mixes: usize,
}

/// Function being written.
#[derive(Default)]
struct Writer {
    columns: Vec<String>,
    pixels: Vec<String>,
    /// The variables of columns that pixels read, in the order of their tables.
    tables: Vec<String>,
    mixes: usize,
}

/// Returns the C of a graph.
pub(crate) fn code(graph: &Graph) -> Code {
    let mut writer = Writer::default();
    let result = writer.nodes(graph);
    let mut text =
        String::from("// Written by the example fused of Trochoid; main below only calls and times the function.\n\n");
    text.push_str("#define _GNU_SOURCE\n");
    let _ = write!(text, "#define WIDTH {WIDTH}\n#define HEIGHT {HEIGHT}\n\n");
    text.push_str("static inline float limited(float x) {\n    x = x > 0.0f ? x : 0.0f;\n");
    text.push_str("    return x < 1.0f ? x : 1.0f;\n}\n\n");
    text.push_str("__attribute__((noinline)) static void picture(\n");
    for name in PASSES {
        let _ = writeln!(text, "    const float *restrict {name}_,");
    }
    text.push_str("    float *restrict r_, float *restrict g_, float *restrict b_) {\n");
    if !writer.tables.is_empty() {
        let _ = writeln!(text, "    static float columns[{}][WIDTH];", writer.tables.len());
    }
    if !writer.columns.is_empty() {
        text.push_str("    for (int x = 0; x < WIDTH; x++) {\n");
        lines(&mut text, "        ", &writer.columns);
        for (at, name) in writer.tables.iter().enumerate() {
            let _ = writeln!(text, "        columns[{at}][x] = {name};");
        }
        text.push_str("    }\n");
    }
    text.push_str("    for (int y = 0; y < HEIGHT; y++) {\n        for (int x = 0; x < WIDTH; x++) {\n");
    text.push_str("            const long i = (long)y * WIDTH + x;\n");
    for name in PASSES {
        let _ = writeln!(text, "            const float {name} = {name}_[i];");
    }
    for (at, name) in writer.tables.iter().enumerate() {
        let _ = writeln!(text, "            const float {name} = columns[{at}][x];");
    }
    lines(&mut text, "            ", &writer.pixels);
    for (channel, letter) in ["r", "g", "b"].into_iter().enumerate() {
        let _ = writeln!(text, "            {letter}_[i] = {};", writer.channel(&result, channel, Rate::Pixel));
    }
    text.push_str("        }\n    }\n}\n\n");
    text.push_str(MAIN);
    Code { text, mixes: writer.mixes }
}

fn lines(text: &mut String, indent: &str, lines: &[String]) {
    for line in lines {
        let _ = writeln!(text, "{indent}{line}");
    }
}

/// Returns a number in C.
fn number(value: f32) -> String {
    format!("{value:?}f")
}

impl Writer {
    fn line(&mut self, rate: Rate, line: String) {
        if rate == Rate::Column { self.columns.push(line) } else { self.pixels.push(line) }
    }

    /// Returns a variable for use at a rate; a variable of columns that pixels read gets a table.
    fn read(&mut self, name: &str, from: Rate, at: Rate) -> String {
        if from < at && !self.tables.iter().any(|table| table == name) {
            self.tables.push(name.into());
        }
        name.into()
    }

    fn scalar(&mut self, scalar: &Scalar, at: Rate) -> String {
        self.read(&scalar.name, scalar.rate, at)
    }

    fn channel(&mut self, color: &Color, channel: usize, at: Rate) -> String {
        match color {
            Color::Constant(values) => number(values[channel]),
            Color::Variables(name, rate) => self.read(&format!("{name}{}", ["r", "g", "b"][channel]), *rate, at),
        }
    }

    /// Writes a new variable, after its operands.
    fn define(&mut self, name: String, of: &[&Scalar], text: impl Fn(&[String]) -> String) -> Scalar {
        let rate = if of.iter().any(|scalar| scalar.rate == Rate::Pixel) { Rate::Pixel } else { Rate::Column };
        let operands: Vec<String> = of.iter().map(|scalar| self.scalar(scalar, rate)).collect();
        self.line(rate, format!("const float {name} = {};", text(&operands)));
        Scalar { name, rate }
    }

    /// 0 below `min`, 1 above `max`.
    fn clamp(&mut self, name: String, x: &Scalar, min: f64, max: f64) -> Scalar {
        let (slope, offset) = ((1.0 / (max - min)) as f32, (min / (max - min)) as f32);
        self.define(name, &[x], |x| match offset {
            0.0 => format!("limited({} * {})", x[0], number(slope)),
            _ => format!("limited({} * {} - {})", x[0], number(slope), number(offset)),
        })
    }

    /// (1 − t)·a + t·b.
    fn mix(&mut self, name: String, a: &Color, b: &Color, t: &Scalar) -> Color {
        self.mixes += 1;
        let ends = if a.rate() < b.rate() { b.rate() } else { a.rate() };
        let rate = if ends < t.rate { t.rate } else { ends };
        let weight = self.scalar(t, rate);
        for (channel, letter) in ["r", "g", "b"].into_iter().enumerate() {
            let from = self.channel(a, channel, rate);
            let mut sign = '+';
            let by = match (a, b) {
                (Color::Constant(a), Color::Constant(b)) => {
                    let difference = b[channel] - a[channel];
                    sign = if difference < 0.0 { '-' } else { '+' };
                    number(difference.abs())
                }
                // A difference of columns is a column too.
                _ if ends < rate => {
                    let (from, to) = (self.channel(a, channel, ends), self.channel(b, channel, ends));
                    self.line(ends, format!("const float {name}{letter}d = {to} - {from};"));
                    self.read(&format!("{name}{letter}d"), ends, rate)
                }
                _ => format!("({} - {from})", self.channel(b, channel, rate)),
            };
            self.line(rate, format!("const float {name}{letter} = {from} {sign} {by} * {weight};"));
        }
        Color::Variables(name, rate)
    }

    /// Mixes colors one after the other, by masks each of which rises only when the one before has reached 1.
    fn stairs(&mut self, name: &str, colors: &[Color], masks: &[Scalar]) -> Color {
        let constants: Vec<[f32; 3]> =
            colors.iter().filter_map(|color| if let Color::Constant(c) = color { Some(*c) } else { None }).collect();
        if constants.len() < colors.len() {
            let mut color = colors[0].clone();
            for (at, (next, mask)) in colors[1..].iter().zip(masks).enumerate() {
                let last = at + 2 == colors.len();
                color = self.mix(if last { name.into() } else { format!("{name}_{at}") }, &color, next, mask);
            }
            return color;
        }
        // Between constants, the steps can be added up.
        self.mixes += masks.len();
        let rate = masks[0].rate;
        for (channel, letter) in ["r", "g", "b"].into_iter().enumerate() {
            let mut text = number(constants[0][channel]);
            for (pair, mask) in constants.windows(2).zip(masks) {
                let step = pair[1][channel] - pair[0][channel];
                let sign = if step < 0.0 { '-' } else { '+' };
                let _ = write!(text, " {sign} {} * {}", number(step.abs()), mask.name);
            }
            self.line(rate, format!("const float {name}{letter} = {text};"));
        }
        Color::Variables(name.into(), rate)
    }

    /// Writes all nodes; returns the color of the last.
    fn nodes(&mut self, graph: &Graph) -> Color {
        let mut scalars: Vec<Option<Scalar>> = Vec::new();
        let mut colors: Vec<Color> = Vec::new();
        let mut bands: Vec<Vec<Scalar>> = Vec::new();
        let none = Color::Constant([0.0; 3]);
        for (index, node) in graph.nodes.iter().enumerate() {
            let name = graph.name(index);
            let mask = |node: &usize| {
                let missing = || Scalar { name: "0.0f".into(), rate: Rate::Column };
                scalars[*node].clone().unwrap_or_else(missing)
            };
            let paint = |paint: &Paint| match paint {
                Paint::Node(node) => colors[*node].clone(),
                Paint::Constant(color) => Color::Constant(color.map(|v| v as f32)),
            };
            let (mut scalar, mut color, mut masks) = (None, none.clone(), Vec::new());
            match node {
                Node::Read => scalar = Some(Scalar { name, rate: Rate::Pixel }),
                Node::ScreenX => {
                    scalar = Some(self.define(name, &[], |_| format!("(float)x / {}", number((WIDTH - 1) as f32))));
                }
                Node::Clamp { of, min, max } => scalar = Some(self.clamp(name, &mask(of), *min, *max)),
                Node::Multiply(t, u) => {
                    scalar = Some(self.define(name, &[&mask(t), &mask(u)], |m| format!("{} * {}", m[0], m[1])));
                }
                Node::Screen(t, u) => {
                    let either = |m: &[String]| format!("{} + {} * (1.0f - {})", m[0], m[1], m[0]);
                    scalar = Some(self.define(name, &[&mask(t), &mask(u)], either));
                }
                Node::Invert(t) => scalar = Some(self.define(name, &[&mask(t)], |m| format!("1.0f - {}", m[0]))),
                Node::Bands { of, thresholds, width } => {
                    for (band, at) in thresholds.iter().enumerate() {
                        let (min, max) = (at - width / 2.0, at + width / 2.0);
                        masks.push(self.clamp(format!("{name}_{band}"), &mask(of), min, max));
                    }
                }
                Node::Mix { a, b, weight } => color = self.mix(name, &paint(a), &paint(b), &mask(weight)),
                Node::Patch { u, v, colors } => {
                    let rows = [0, 2].map(|at| {
                        self.mix(format!("{name}_{}", at / 2), &paint(&colors[at]), &paint(&colors[at + 1]), &mask(u))
                    });
                    color = self.mix(name, &rows[0], &rows[1], &mask(v));
                }
                Node::Ramp { weight, at, colors } => {
                    let mut steps = Vec::new();
                    for (step, pair) in at.windows(2).enumerate() {
                        steps.push(self.clamp(format!("{name}_t{step}"), &mask(weight), pair[0], pair[1]));
                    }
                    color = self.stairs(&name, &colors.each_ref().map(paint), &steps);
                }
                Node::Blend { colors, bands: of } => {
                    color = self.stairs(&name, &colors.each_ref().map(paint), &bands[*of]);
                }
            }
            scalars.push(scalar);
            colors.push(color);
            bands.push(masks);
        }
        colors.pop().unwrap_or(none)
    }
}
