//! A drawn graph at one pixel: its value in f64, how far f32 may be off, and the box of its controls.
//!
//! The bound follows NUMERICS §3 with u = 2⁻²⁴ and η = 2⁻¹⁴⁹, the smallest positive f32: errors of operands propagate
//! as described there, and each operation adds its own rounding.
//!
//! | operation | passes on | adds |
//! |---|---|---|
//! | Clamp | e/(max − min); 1 where the side of a step is not certain | 4u·t + η |
//! | smooth, power p | 1.5·e; p·(t + e)ᵖ⁻¹·e | 2u·t + η |
//! | complement, product | e; t·e′ + t′·e + e·e′ | u; u·t·t′ + η |
//! | Normalize | (e + w·Σe)/max(S − Σe, τ) | (n + 1)·2⁻²⁵ |
//! | Mix | (1 − t)·eₐ + t·e_b + eₜ·(\|b − a\| + eₐ + e_b) | 1.5 ulp of the larger operand |
//! | Blend | Σ(w + e)·eᵢ + ½·diameter·Σe | 1 ulp of the largest operand, weights (n + 1)·2⁻²⁵ |
//!
//! The error of a color is at most the width of its box, because value and result both lie in the box.

use super::draw::{Arg, Drawn, Op};
use super::pixels::Pixels;

const U: f64 = 5.960_464_477_539_063e-8;
const TINY: f64 = 1.401_298_464_324_817e-45;

/// Number with the error bound of its computed value.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Scalar {
    pub(crate) value: f64,
    pub(crate) error: f64,
    /// Largest possible value of the number, which is the scale of its rounding.
    pub(crate) high: f64,
}

/// Color with its error bound, and the bounding box of its control colors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Color {
    value: [f64; 3],
    error: [f64; 3],
    pub(crate) low: [f32; 3],
    pub(crate) high: [f32; 3],
}

/// Value of a node at a pixel.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Color(Color),
    /// A mask or a field.
    Number(Scalar),
    /// Masks laid over each other, the first on top; the flag says whether the weight of the bottom comes first.
    Masks(Vec<Scalar>, bool),
    /// Explicit weights.
    Weights(Vec<Scalar>),
}

impl Value {
    /// Returns the value of an output of the node.
    pub(crate) fn channels(&self) -> Vec<Scalar> {
        match self {
            Self::Color(color) => (0..3)
                .map(|c| Scalar { value: color.value[c], error: color.error[c], high: f64::from(color.high[c]) })
                .collect(),
            Self::Number(number) => vec![*number],
            Self::Weights(weights) => weights.clone(),
            Self::Masks(masks, rising) => {
                let mut left = number(1.0);
                let mut weights = Vec::new();
                for mask in masks {
                    weights.push(product(left, *mask));
                    left = product(left, complement(*mask));
                }
                weights.push(left);
                if *rising {
                    weights.reverse();
                }
                weights
            }
        }
    }
}

fn number(value: f64) -> Scalar {
    mask(value, 0.0)
}

fn mask(value: f64, error: f64) -> Scalar {
    Scalar { value, error, high: 1.0 }
}

fn complement(t: Scalar) -> Scalar {
    mask(1.0 - t.value, t.error + U)
}

fn product(t: Scalar, u: Scalar) -> Scalar {
    let value = t.value * u.value;
    mask(value, t.value * u.error + u.value * t.error + t.error * u.error + U * value + TINY)
}

fn smooth(t: Scalar) -> Scalar {
    let value = t.value * t.value * (3.0 - 2.0 * t.value);
    mask(value, (1.5 * t.error).min(1.0) + 2.0 * U * value + TINY)
}

fn power(t: Scalar, p: f64) -> Scalar {
    if p == 1.0 {
        return t;
    }
    let value = t.value.powf(p);
    let slope = p * (t.value + t.error).min(1.0).powf(p - 1.0);
    mask(value, (slope * t.error).min(1.0) + 2.0 * U * value + TINY)
}

fn clamp(x: Scalar, min: f64, max: f64) -> Scalar {
    let certain = x.error == 0.0 || x.value - x.error >= max || x.value + x.error < min;
    if x.value >= max || x.value < min || min == max {
        let value = if x.value >= max { 1.0 } else { 0.0 };
        let passed = if max == min { 1.0 } else { x.error / (max - min) };
        return mask(value, if certain { 0.0 } else { passed.min(1.0) + TINY });
    }
    let value = (x.value - min) / (max - min);
    mask(value, (x.error / (max - min)).min(1.0) + 4.0 * U * value + TINY)
}

/// ulp(x) ≤ 2u·x, and at least the spacing of subnormals.
fn ulps(count: f64, largest: f64) -> f64 {
    count * (2.0 * U * largest + TINY)
}

fn capped(mut color: Color) -> Color {
    for c in 0..3 {
        color.error[c] = color.error[c].min(f64::from(color.high[c]) - f64::from(color.low[c]));
    }
    color
}

fn union(colors: &[Color]) -> ([f32; 3], [f32; 3]) {
    let low = |c: usize| colors.iter().fold(f32::INFINITY, |low, color| low.min(color.low[c]));
    let high = |c: usize| colors.iter().fold(f32::NEG_INFINITY, |high, color| high.max(color.high[c]));
    (std::array::from_fn(low), std::array::from_fn(high))
}

fn mix(a: Color, b: Color, t: Scalar) -> Color {
    let (low, high) = union(&[a, b]);
    let mut mixed = Color { value: [0.0; 3], error: [0.0; 3], low, high };
    for c in 0..3 {
        let (t, dt) = (t.value, t.error.min(1.0));
        mixed.value[c] = (1.0 - t) * a.value[c] + t * b.value[c];
        let apart = (b.value[c] - a.value[c]).abs() + a.error[c] + b.error[c];
        let largest = (a.value[c] + a.error[c]).max(b.value[c] + b.error[c]);
        mixed.error[c] = (1.0 - t) * a.error[c] + t * b.error[c] + dt * apart + ulps(1.5, largest);
    }
    capped(mixed)
}

fn blend(colors: &[Color], weights: &[Scalar]) -> Color {
    let (low, high) = union(colors);
    let mut blended = Color { value: [0.0; 3], error: [0.0; 3], low, high };
    let rounding = (weights.len() + 1) as f64 * U / 2.0;
    let apart: f64 = weights.iter().map(|w| w.error + rounding).sum();
    for c in 0..3 {
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        for (color, weight) in colors.iter().zip(weights) {
            blended.value[c] += weight.value * color.value[c];
            blended.error[c] += (weight.value + weight.error + rounding) * color.error[c];
            least = least.min(color.value[c] - color.error[c]);
            most = most.max(color.value[c] + color.error[c]);
        }
        blended.error[c] += 0.5 * (most - least) * apart + ulps(1.0, most);
    }
    capped(blended)
}

fn normalize(fields: &[Scalar], floor: f64) -> Vec<Scalar> {
    let values: Vec<f64> = fields.iter().map(|v| v.value.clamp(0.0, f64::from(f32::MAX))).collect();
    let (sum, apart): (f64, f64) = (values.iter().sum(), fields.iter().map(|v| v.error).sum());
    let (divisor, least) = (sum.max(floor), (sum - apart).max(floor));
    let rounding = (fields.len() + 2) as f64 * U / 2.0;
    let mut weights: Vec<Scalar> = values
        .iter()
        .zip(fields)
        .map(|(v, field)| mask(v / divisor, (field.error + v / divisor * apart) / least + rounding))
        .collect();
    weights.push(mask((divisor - sum) / divisor, apart / least + rounding));
    weights
}

/// Every node of a graph at a pixel.
pub(crate) fn evaluate(drawn: &Drawn, pixels: &Pixels, at: usize) -> Vec<Value> {
    let mut values: Vec<Value> = Vec::with_capacity(drawn.nodes.len());
    for (index, (op, _)) in drawn.nodes.iter().enumerate() {
        let value = match (op, drawn.disabled[index]) {
            (Op::Mix { a: Arg::Node(first), .. } | Op::Invert(Arg::Node(first)), true) => values[*first].clone(),
            _ => At { values: &values, pixels, at }.node(op),
        };
        values.push(value);
    }
    values
}

struct At<'a> {
    values: &'a [Value],
    pixels: &'a Pixels,
    at: usize,
}

impl At<'_> {
    fn number(&self, arg: &Arg) -> Scalar {
        match arg {
            Arg::Number(value) => number(*value),
            Arg::Node(node) => match &self.values[*node] {
                Value::Number(number) => *number,
                other => unreachable!("{other:?} is no number"),
            },
            Arg::Color(_) => unreachable!("a color is no number"),
        }
    }

    fn numbers(&self, args: &[Arg]) -> Vec<Scalar> {
        args.iter().map(|arg| self.number(arg)).collect()
    }

    fn color(&self, arg: &Arg) -> Color {
        match arg {
            Arg::Color(color) => control(*color),
            Arg::Node(node) => match &self.values[*node] {
                Value::Color(color) => *color,
                other => unreachable!("{other:?} is no color"),
            },
            Arg::Number(_) => unreachable!("a number is no color"),
        }
    }

    fn colors(&self, args: &[Arg]) -> Vec<Color> {
        args.iter().map(|arg| self.color(arg)).collect()
    }

    fn node(&self, op: &Op) -> Value {
        match op {
            Op::Input(name) => match self.pixels.at(name, self.at)[..] {
                [value] => Value::Number(Scalar { value: f64::from(value), error: 0.0, high: f64::from(value) }),
                [r, g, b] if name.starts_with('c') => Value::Color(control([r, g, b])),
                ref weights => Value::Weights(weights.iter().map(|w| number(f64::from(*w))).collect()),
            },
            Op::Mix { a, b, t } => Value::Color(mix(self.color(a), self.color(b), self.number(t))),
            Op::Blend { colors, weights } => Value::Color(self.blend(&self.colors(colors), weights)),
            Op::Clamp { x, min, max, smooth: eased, power: p } => {
                let t = clamp(self.number(x), *min, *max);
                Value::Number(power(if *eased { smooth(t) } else { t }, *p))
            }
            Op::Ramp { t, stops, interpolation } => {
                let t = self.number(t);
                let mut color = self.color(&stops[0].1);
                for pair in stops.windows(2) {
                    let (min, max) = (pair[0].0, pair[1].0);
                    let reached = clamp(t, if *interpolation == "step" { max } else { min }, max);
                    let reached = if *interpolation == "smooth" { smooth(reached) } else { reached };
                    color = mix(color, self.color(&pair[1].1), reached);
                }
                Value::Color(color)
            }
            Op::Bands { x, thresholds, width } => {
                let half = width / 2.0;
                let x = self.number(x);
                let masks: Vec<Scalar> = thresholds.iter().rev().map(|at| clamp(x, at - half, at + half)).collect();
                if let [only] = masks[..] { Value::Number(only) } else { Value::Masks(masks, true) }
            }
            Op::Patch { u, v, colors } => {
                let (u, v) = (self.number(u), self.number(v));
                let side = if colors.len() == 4 { 2 } else { 4 };
                let rows = self.colors(colors).chunks(side).map(|row| casteljau(row.to_vec(), u)).collect();
                Value::Color(casteljau(rows, v))
            }
            Op::Normalize { fields, floor } => {
                let weights = normalize(&self.numbers(fields), *floor);
                if let [_, rest] = weights[..] { Value::Number(rest) } else { Value::Weights(weights) }
            }
            Op::Stack(masks) => {
                let masks = self.numbers(masks);
                if let [only] = masks[..] { Value::Number(complement(only)) } else { Value::Masks(masks, false) }
            }
            Op::Other(..) => unreachable!("drawn only where bounds are certified"),
            Op::Invert(t) => Value::Number(complement(self.number(t))),
            Op::Multiply(masks) => Value::Number(self.numbers(masks).into_iter().fold(number(1.0), product)),
            Op::Screen(masks) => {
                let open = self.numbers(masks).into_iter().map(complement);
                Value::Number(complement(open.fold(number(1.0), product)))
            }
        }
    }

    fn blend(&self, colors: &[Color], weights: &Result<Vec<f64>, usize>) -> Color {
        let node = match weights {
            Ok(numbers) => return blend(colors, &numbers.iter().map(|w| number(*w)).collect::<Vec<_>>()),
            Err(node) => *node,
        };
        match &self.values[node] {
            Value::Number(t) => mix(colors[0], colors[1], *t),
            Value::Weights(weights) => blend(colors, weights),
            Value::Masks(masks, rising) => {
                // Laid from the bottom up, with one Mix per mask.
                let mut layers = colors.to_vec();
                if *rising {
                    layers.reverse();
                }
                let bottom = layers[masks.len()];
                masks.iter().zip(&layers).rev().fold(bottom, |below, (mask, color)| mix(below, *color, *mask))
            }
            Value::Color(_) => unreachable!("colors are no weights"),
        }
    }
}

fn control(color: [f32; 3]) -> Color {
    Color { value: color.map(f64::from), error: [0.0; 3], low: color, high: color }
}

fn casteljau(mut colors: Vec<Color>, t: Scalar) -> Color {
    while colors.len() > 1 {
        colors = colors.windows(2).map(|pair| mix(pair[0], pair[1], t)).collect();
    }
    colors[0]
}
