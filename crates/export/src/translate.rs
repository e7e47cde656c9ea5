//! From operations to the parts of a shader: the one place that knows every operation.

use crate::Job;
use crate::input::Parameter;
use trochoid_graph::{Op, Program, Scalar};
use trochoid_weights::arithmetic::{LARGE, round_partition};

/// A language. Each function writes what computes an operation, and returns what refers to the result. `at` is the
/// operation's position in the program, which makes names unique.
pub(crate) trait Target {
    /// Refers to a number or a color.
    type Ref: Clone;

    /// A constant number.
    fn number(&mut self, value: f32) -> Self::Ref;
    /// A constant color.
    fn color(&mut self, color: [f32; 3]) -> Self::Ref;
    /// A field or a color of the shader's inputs, as it is.
    fn input(&mut self, parameter: &Parameter) -> Self::Ref;
    /// A mask or a weight of the shader's inputs, clamped to [0, 1].
    fn mask(&mut self, at: usize, parameter: &Parameter) -> Self::Ref;
    /// (x·scale − low)/(high − low), clamped to [0, 1]; 1 where x·scale ≥ high. low < high.
    fn ramp(&mut self, at: usize, x: &Self::Ref, scale: f32, low: f32, high: f32) -> Self::Ref;
    /// 1 where x ≥ threshold, else 0.
    fn step(&mut self, at: usize, x: &Self::Ref, threshold: f32) -> Self::Ref;
    /// t²(3 − 2t).
    fn smooth(&mut self, at: usize, t: &Self::Ref) -> Self::Ref;
    /// tᵖ, at most t, as the product of a whole power and of a rest.
    fn power(&mut self, at: usize, t: &Self::Ref, power: Power) -> Self::Ref;
    /// 1 − t.
    fn complement(&mut self, at: usize, t: &Self::Ref) -> Self::Ref;
    /// t·u.
    fn product(&mut self, at: usize, t: &Self::Ref, u: &Self::Ref) -> Self::Ref;
    /// Weights divided by their sum; if all are 0, they are equal.
    fn partition(&mut self, at: usize, weights: &[Self::Ref]) -> Vec<Self::Ref>;
    /// v/max(S, floor) of all values v = max(value, 0)·scale with the sum S, and the remainder.
    fn normalize(&mut self, at: usize, values: &[Self::Ref], scale: f32, floor: f32) -> Vec<Self::Ref>;
    /// (1 − t)·a + t·b.
    fn mix(&mut self, at: usize, a: &Self::Ref, b: &Self::Ref, t: &Self::Ref) -> Self::Ref;
    /// Σ wᵢ·cᵢ.
    fn blend(&mut self, at: usize, colors: &[Self::Ref], weights: &[Self::Ref]) -> Self::Ref;
    /// The linear light of a color that is encoded as sRGB.
    fn decode(&mut self, color: &Self::Ref) -> Self::Ref;
}

/// Exponent p ≥ 1 of a mask, taken apart: few functions of other programs are as exact as products.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Power {
    /// Part that products make, from 1 on.
    pub(crate) whole: u32,
    /// The rest, at least 0; 0 for a whole p.
    pub(crate) rest: f32,
}

impl Power {
    /// Largest power that products make: beyond, they would be less exact than `pow`.
    const MOST: f32 = 63.0;
    /// Number of bits of a fraction that square roots make: all that an f32 from 1 on has.
    const ROOTS: i32 = f32::MANTISSA_DIGITS as i32 - 1;

    fn new(p: f32) -> Self {
        let whole = p.trunc().clamp(1.0, Self::MOST);
        Self { whole: whole as u32, rest: (p - whole).max(0.0) }
    }

    /// Returns the powers of two that make up the whole part, in ascending order.
    pub(crate) fn twos(self) -> impl Iterator<Item = u32> {
        (0..u32::BITS).map(|bit| 1 << bit).filter(move |two| self.whole & two != 0)
    }

    /// Takes the rest apart: how often roots are taken of the mask one after another, 1 for √t, 2 for t^(1/4), for those
    /// whose product makes the fraction, and the exponent that is left for `pow`.
    pub(crate) fn roots(self) -> (Vec<i32>, f32) {
        let mut left = self.rest;
        let takes = |depth: &i32| {
            let part = 0.5_f32.powi(*depth);
            let fits = left.fract() >= part;
            left -= if fits { part } else { 0.0 };
            fits
        };
        let roots = (1..=Self::ROOTS).filter(takes).collect();
        (roots, left)
    }

    /// Returns the largest of them.
    pub(crate) fn highest(self) -> u32 {
        1 << self.whole.ilog2()
    }
}

/// A value of the program.
enum Value<R> {
    Single(R),
    Weights(Vec<R>),
}

/// Writes a program in a language, and returns what refers to its results.
pub(crate) fn translate<T: Target>(job: &Job<'_>, target: &mut T) -> Vec<T::Ref> {
    let program = &job.made.program;
    let mut values: Vec<Value<T::Ref>> = Vec::with_capacity(program.ops().len());
    for (at, (op, _)) in program.ops().iter().enumerate() {
        let value = operation(job, target, &values, at, op);
        values.push(value);
    }
    let results = job.made.roots.iter().map(|root| single(&values, *root).clone());
    if job.decodes { results.map(|color| target.decode(&color)).collect() } else { results.collect() }
}

fn single<R>(values: &[Value<R>], position: u32) -> &R {
    match &values[position as usize] {
        Value::Single(single) => single,
        Value::Weights(_) => unreachable!("programs are typed"),
    }
}

fn weights<R>(values: &[Value<R>], position: u32) -> &[R] {
    match &values[position as usize] {
        Value::Weights(weights) => weights,
        Value::Single(_) => unreachable!("programs are typed"),
    }
}

fn operation<T: Target>(job: &Job<'_>, target: &mut T, values: &[Value<T::Ref>], at: usize, op: &Op) -> Value<T::Ref> {
    let of = |position: u32| single(values, position);
    let all = |scalars: &[Scalar]| scalars.iter().map(|scalar| of(scalar.0).clone()).collect::<Vec<_>>();
    Value::Single(match op {
        Op::Load(slot) | Op::LoadColor(slot) => {
            let parameter = job.inputs.parameter(slot);
            if parameter.is_weight { target.mask(at, parameter) } else { target.input(parameter) }
        }
        Op::Constant(value) => target.number(*value),
        Op::ConstantColor(color) => target.color(*color),
        Op::Clamp { x, min, max } if min < max => {
            // As in the definition: the difference of large bounds would be infinite.
            let scale = if min.abs() >= LARGE || max.abs() >= LARGE { 0.5 } else { 1.0 };
            target.ramp(at, of(x.0), scale, min * scale, max * scale)
        }
        Op::Clamp { x, max, .. } => target.step(at, of(x.0), *max),
        Op::Step { x, threshold } => target.step(at, of(x.0), *threshold),
        Op::Smooth(t) => target.smooth(at, of(t.0)),
        Op::Power { t, p } => target.power(at, of(t.0), Power::new(*p)),
        Op::Complement(t) => target.complement(at, of(t.0)),
        Op::Product(t, u) => target.product(at, of(t.0), of(u.0)),
        Op::Weight(partition, index) => weights(values, partition.0)[*index].clone(),
        Op::Partition(raw) => {
            return Value::Weights(match constants(&job.made.program, raw) {
                Some(known) => known.into_iter().map(|weight| target.number(weight)).collect(),
                None => target.partition(at, &all(raw)),
            });
        }
        Op::Normalize { values: raw, floor } => {
            // A power of two, by which the sum of the largest numbers stays finite.
            let scale = 1.0 / raw.len().next_power_of_two() as f32;
            return Value::Weights(target.normalize(at, &all(raw), scale, floor * scale));
        }
        Op::Mix { a, b, t } => target.mix(at, of(a.0), of(b.0), of(t.0)),
        Op::Blend { colors, weights: by } => {
            let colors: Vec<T::Ref> = colors.iter().map(|color| of(color.0).clone()).collect();
            target.blend(at, &colors, weights(values, by.0))
        }
    })
}

/// Returns the weights that kernels would use, if all are constants.
fn constants(program: &Program, raw: &[Scalar]) -> Option<Vec<f32>> {
    let constant = |scalar: &Scalar| match program.ops()[scalar.0 as usize].0 {
        Op::Constant(value) => Some(value),
        _ => None,
    };
    let mut known = raw.iter().map(constant).collect::<Option<Vec<f32>>>()?;
    round_partition(&mut known);
    Some(known)
}

/// Returns a number as a decimal fraction that every language reads as this f32. Infinities, which no language has as a
/// literal, become the largest numbers.
pub(crate) fn literal(value: f32) -> String {
    let value = value.clamp(f32::MIN, f32::MAX) + 0.0;
    // Shortest that is read as the same number, with a point.
    if value != 0.0 && !(1e-5..1e9).contains(&value.abs()) { format!("{value:e}") } else { format!("{value:?}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_products_as_far_as_they_go() {
        for (p, whole, rest) in [(1.5, 1, 0.5), (3.0, 3, 0.0), (63.0, 63, 0.0), (70.25, 63, 7.25)] {
            assert_eq!(Power::new(p), Power { whole, rest });
        }
        assert_eq!(Power::new(13.0).twos().collect::<Vec<_>>(), [1, 4, 8]);
        assert_eq!(Power::new(13.0).highest(), 8);
        assert_eq!(Power::new(2.0).roots(), (vec![], 0.0));
        assert_eq!(Power::new(2.75).roots(), (vec![1, 2], 0.0));
        assert_eq!(Power::new(70.25).roots(), (vec![2], 7.0));
        let (roots, left) = Power::new(1.3).roots();
        let sum: f32 = roots.iter().map(|depth| 0.5_f32.powi(*depth)).sum();
        assert_eq!((1.0 + sum, left), (1.3, 0.0), "{roots:?}");
    }

    #[test]
    fn literals_are_read_as_the_same_number() {
        for value in [0.1_f32, -0.0, 1.0, 1e-40, 16_777_217.0, -3.402_823_5e38, 8.507_059e37, f32::MIN_POSITIVE] {
            let text = literal(value);
            assert_eq!(text.parse::<f32>().map(f32::to_bits), Ok((value + 0.0).to_bits()), "{text}");
            assert!(text.contains(['.', 'e']), "{text} would be a whole number");
        }
        assert_eq!(literal(f32::INFINITY), "3.4028235e38");
    }
}
