//! The builder, with which nodes append operations to the pointwise program. Its types make sure that colors are only
//! blended.
//!
//! Only the builder's operations, which all keep weights ≥ 0 with sum 1, can make a [`Mask`] or [`Weights`]. Having
//! one therefore proves that no color of the program leaves the convex hull of its controls. That rounding preserves
//! this is proved with the definitions of the operations, in `trochoid_weights::arithmetic`. None of these programs
//! compile:
//!
//! ```compile_fail
//! # use trochoid_graph::{Mask, Scalar};
//! let forged = Mask(Scalar(0));
//! ```
//!
//! ```compile_fail
//! # use trochoid_graph::{Builder, Color, Scalar};
//! fn unclamped(build: &mut Builder<'_>, a: Color, b: Color, field: Scalar) -> Color {
//!     build.mix(a, b, field)
//! }
//! ```
//!
//! ```compile_fail
//! # use trochoid_graph::{Builder, Color, Op};
//! fn anything(build: &mut Builder<'_>, op: Op) -> Color {
//!     build.push(op)
//! }
//! ```

use crate::literal::parts;
use crate::program::{Color, Op, Partition, Program, Scalar, Slot};
use crate::{Kind, NodeId, literal};

/// A scalar that is proved to be in [0, 1]: a two-way partition of unity.
///
/// ```compile_fail
/// # use trochoid_graph::{Mask, Scalar};
/// fn forged(field: Scalar) -> Mask {
///     field.into()
/// }
/// ```
///
/// ```compile_fail
/// # use trochoid_graph::{Mask, Scalar};
/// fn forged(mut mask: Mask, field: Scalar) -> Mask {
///     mask.0 = field;
///     mask
/// }
/// ```
///
/// ```compile_fail
/// // Operators could leave [0, 1].
/// # use trochoid_graph::Mask;
/// fn forged(a: Mask, b: Mask) -> Mask {
///     a + b
/// }
/// ```
///
/// ```compile_fail
/// let forged = trochoid_graph::Mask::default();
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mask(Scalar);

impl Mask {
    /// Converts the mask to a field. Only a clamp converts it back.
    pub fn field(self) -> Scalar {
        self.0
    }
}

/// Weights that are proved to be ≥ 0 and to sum to 1.
///
/// ```compile_fail
/// # use trochoid_graph::{Partition, Weights};
/// fn forged(raw: Partition) -> Weights {
///     Weights(raw)
/// }
/// ```
///
/// ```compile_fail
/// # use trochoid_graph::{Scalar, Weights};
/// fn forged(fields: Vec<Scalar>) -> Weights {
///     fields.into()
/// }
/// ```
///
/// ```compile_fail
/// // Only the builder makes weights from numbers, after checking them.
/// # use trochoid_graph::Weights;
/// let forged: Weights = [0.7, 0.7].into_iter().collect();
/// ```
///
/// ```compile_fail
/// let forged: trochoid_graph::Weights = "[0.7, 0.7]".parse().unwrap();
/// ```
///
/// ```compile_fail
/// let forged = trochoid_graph::Weights::default();
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Weights(Form);

#[derive(Clone, Debug, PartialEq)]
enum Form {
    /// Weight 1 − t for the first control, t for the second.
    Mask(Mask),
    /// n masks, the first on top: n + 1 weights, the last for the remainder under all masks.
    Stack(Vec<Mask>),
    /// n masks, the last on top: n + 1 weights, the first for the remainder under all masks.
    Ladder(Vec<Mask>),
    /// An explicit partition.
    Partition(Partition, usize),
}

impl Weights {
    /// Makes a two-way partition: 1 − t, t.
    pub fn mask(t: Mask) -> Self {
        Self(Form::Mask(t))
    }

    /// Makes n + 1 weights from n masks, the last on top: weight 0 is the remainder under all masks, weight k + 1
    /// belongs to mask k.
    pub fn ladder(masks: Vec<Mask>) -> Self {
        Self(if let [only] = masks[..] { Form::Mask(only) } else { Form::Ladder(masks) })
    }

    /// Returns the number of controls.
    pub fn ways(&self) -> usize {
        match &self.0 {
            Form::Mask(_) => 2,
            Form::Stack(masks) | Form::Ladder(masks) => masks.len() + 1,
            Form::Partition(_, n) => *n,
        }
    }
}

/// A value during lowering.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A color.
    Color(Color),
    /// A color in layers; only in graphs with recipes, and never what a node lowers to or takes.
    Layers(Vec<Color>),
    /// Weights.
    Weights(Weights),
    /// The components of a field.
    Field(Vec<Scalar>),
}

/// Appends operations for one node.
#[derive(Debug)]
pub struct Builder<'p> {
    program: &'p mut Program,
    origin: NodeId,
}

impl<'p> Builder<'p> {
    /// Makes a builder that appends to `program` for the node `origin`.
    pub fn new(program: &'p mut Program, origin: NodeId) -> Self {
        Self { program, origin }
    }

    fn push(&mut self, op: Op) -> u32 {
        self.program.push(op, self.origin)
    }

    fn masking(&mut self, op: Op) -> Mask {
        Mask(Scalar(self.push(op)))
    }

    /// Appends a constant number.
    pub fn constant(&mut self, value: f64) -> Scalar {
        Scalar(self.push(Op::Constant(literal(value))))
    }

    /// Appends a constant mask; a value outside of [0, 1] is clamped.
    pub fn constant_mask(&mut self, t: f64) -> Mask {
        self.masking(Op::Constant(literal(t.clamp(0.0, 1.0))))
    }

    /// Appends a control color; −0 counts as 0.
    pub fn control(&mut self, color: [f64; 3]) -> Color {
        Color(self.push(Op::ConstantColor(color.map(|v| literal(v) + 0.0))))
    }

    /// Clamps a field to a mask: 0 below `min`, 1 from `max` on, linear between.
    pub fn clamp(&mut self, x: Scalar, min: f64, max: f64) -> Mask {
        self.masking(Op::Clamp { x, min: literal(min), max: literal(max) })
    }

    /// Makes a hard mask: 1 where x ≥ threshold, else 0.
    pub fn step(&mut self, x: Scalar, threshold: f64) -> Mask {
        self.masking(Op::Step { x, threshold: literal(threshold) })
    }

    /// Smooths a mask: t²(3 − 2t).
    pub fn smooth(&mut self, t: Mask) -> Mask {
        self.masking(Op::Smooth(t.0))
    }

    /// Raises a mask to a power: tᵖ, p ≥ 1; p = 1 does not change the mask.
    pub fn power(&mut self, t: Mask, p: f64) -> Mask {
        if p == 1.0 { t } else { self.masking(Op::Power { t: t.0, p: literal(p.max(1.0)) }) }
    }

    /// Inverts a mask: 1 − t.
    pub fn complement(&mut self, t: Mask) -> Mask {
        self.masking(Op::Complement(t.0))
    }

    /// Multiplies two masks: t·u.
    pub fn product(&mut self, t: Mask, u: Mask) -> Mask {
        self.masking(Op::Product(t.0, u.0))
    }

    /// Makes n + 1 weights from n masks, the first on top: weight n is the remainder under all masks.
    pub fn stack(&mut self, masks: Vec<Mask>) -> Weights {
        // A mask stores the weight of the second control, here the remainder under the only layer.
        if let [only] = masks[..] { Weights::mask(self.complement(only)) } else { Weights(Form::Stack(masks)) }
    }

    /// Normalizes n fields to n + 1 weights: v/max(S, τ), with negative values as 0, their sum S and `floor` = τ;
    /// weight n is the remainder.
    pub fn normalize(&mut self, values: Vec<Scalar>, floor: f64) -> Weights {
        let ways = values.len() + 1;
        let partition = Partition(self.push(Op::Normalize { values, floor: literal(floor) }));
        if ways == 2 {
            return Weights::mask(self.masking(Op::Weight(partition, 1)));
        }
        Weights(Form::Partition(partition, ways))
    }

    /// Appends constant weights, divided by their sum; `None` unless they are ≥ 0 and sum to 1 within
    /// [`LITERAL_SUM_TOLERANCE`](crate::LITERAL_SUM_TOLERANCE).
    pub fn constant_weights(&mut self, numbers: &[f64]) -> Option<Weights> {
        Some(self.literal_weights(&parts(numbers)?))
    }

    /// Appends literal weights, which validation has divided by their sum.
    pub(crate) fn literal_weights(&mut self, numbers: &[f64]) -> Weights {
        let raw = numbers.iter().map(|w| self.constant_mask(*w).0).collect();
        Weights(Form::Partition(Partition(self.push(Op::Partition(raw))), numbers.len()))
    }

    /// Mixes two colors: (1 − t)·a + t·b.
    pub fn mix(&mut self, a: Color, b: Color, t: Mask) -> Color {
        Color(self.push(Op::Mix { a, b, t: t.0 }))
    }

    /// Blends colors: Σ wᵢ·cᵢ. A stack or ladder is composited from the bottom up, with one Mix per mask, so that a
    /// mask of 0 changes no bit.
    pub fn blend(&mut self, colors: &[Color], weights: &Weights) -> Color {
        match &weights.0 {
            Form::Mask(t) => self.mix(colors[0], colors[1], *t),
            Form::Stack(masks) => {
                let bottom = colors[masks.len()];
                masks.iter().zip(colors).rev().fold(bottom, |below, (mask, color)| self.mix(below, *color, *mask))
            }
            Form::Ladder(masks) => {
                masks.iter().zip(&colors[1..]).fold(colors[0], |below, (mask, color)| self.mix(below, *color, *mask))
            }
            Form::Partition(partition, _) => {
                Color(self.push(Op::Blend { colors: colors.to_vec(), weights: *partition }))
            }
        }
    }

    /// Returns weight `index` of any weights, as a mask.
    pub fn weight(&mut self, weights: &Weights, index: usize) -> Mask {
        match &weights.0 {
            Form::Mask(t) if index == 0 => self.complement(*t),
            Form::Mask(t) => *t,
            Form::Partition(partition, _) => self.masking(Op::Weight(*partition, index)),
            Form::Stack(masks) => self.left_by(&masks[..index.min(masks.len())], masks.get(index)),
            // A ladder is a reversed stack: the masks after mask k are above it.
            Form::Ladder(masks) => {
                let above: Vec<Mask> = masks[index..].iter().rev().copied().collect();
                self.left_by(&above, index.checked_sub(1).and_then(|own| masks.get(own)))
            }
        }
    }

    /// Returns the part of a mask, or of everything, that the masks above do not cover.
    fn left_by(&mut self, above: &[Mask], own: Option<&Mask>) -> Mask {
        let mut left: Option<Mask> = None;
        for mask in above {
            let open = self.complement(*mask);
            left = Some(match left {
                Some(left) => self.product(left, open),
                None => open,
            });
        }
        match (left, own) {
            (Some(left), Some(own)) => self.product(left, *own),
            (None, Some(own)) => *own,
            (Some(left), None) => left,
            (None, None) => self.constant_mask(1.0),
        }
    }
}

/// Loads the value of an output, of a checked kind, that is filled outside of the program; `None` for kinds that are
/// not images. For engines: nodes have no access to the program.
pub fn load(program: &mut Program, node: NodeId, output: usize, kind: Kind) -> Option<Value> {
    let mut scalars = |n: usize| -> Vec<Scalar> {
        (0..n).map(|channel| Scalar(program.push(Op::Load(Slot { node, output, channel }), node))).collect()
    };
    match kind {
        Kind::Color => Some(Value::Color(load_color(program, Slot { node, output, channel: 0 }))),
        Kind::Layers(n) => {
            let slots = (0..n).map(|layer| Slot { node, output, channel: 3 * layer });
            Some(Value::Layers(slots.map(|slot| load_color(program, slot)).collect()))
        }
        Kind::Weights(2) => Some(Value::Weights(Weights::mask(Mask(scalars(1)[0])))),
        Kind::Weights(n) => {
            let raw = scalars(n);
            let partition = Partition(program.push(Op::Partition(raw), node));
            Some(Value::Weights(Weights(Form::Partition(partition, n))))
        }
        Kind::Field(n) => Some(Value::Field(scalars(n))),
        Kind::Surface | Kind::Camera | Kind::Light | Kind::View => None,
    }
}

/// Loads a color that is filled outside of the program, from the channel of the slot on. For engines, as [`load`].
pub fn load_color(program: &mut Program, slot: Slot) -> Color {
    Color(program.push(Op::LoadColor(slot), slot.node))
}
