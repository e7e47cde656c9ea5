//! Nodes that literals become.

use crate::*;

/// Color that was a literal.
///
/// # Formula
/// C
///
/// # Edge cases
/// Unless samples are supplied, the literal.
///
/// # Source
/// A control color, as of a Constant.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(color: Kind::Color = "The color."))]
struct OpenColor {
    /// The literal.
    #[knob(color)]
    value: [f64; 3],
}

impl Node for OpenColor {}

impl Pointwise for OpenColor {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        Value::Color(lowering.build.control(self.value))
    }

    fn reference(&self, _inputs: &References<'_>) -> Reference {
        Reference::Color(self.value)
    }
}

/// Weight that was a literal.
///
/// # Formula
/// t
///
/// # Edge cases
/// Unless samples are supplied, the literal.
///
/// # Source
/// A constant mask.
#[derive(Clone, Node)]
#[node(pointwise, end = Front, revision = 1, output(mask: Kind::MASK = "The weight."))]
struct OpenMask {
    /// The literal.
    #[knob(range = 0.0..=1.0, required)]
    value: f64,
}

impl Node for OpenMask {}

impl Pointwise for OpenMask {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        Value::Weights(Weights::mask(lowering.build.constant_mask(self.value)))
    }

    fn reference(&self, _inputs: &References<'_>) -> Reference {
        Reference::Mask(self.value)
    }
}

/// Number that was a literal.
///
/// # Formula
/// x
///
/// # Edge cases
/// Unless samples are supplied, the literal.
///
/// # Source
/// A constant field.
#[derive(Clone, Node)]
#[node(pointwise, end = Front, revision = 1, output(field: Kind::Field(1) = "The number."))]
struct OpenNumber {
    /// The literal.
    #[knob(range = f64::MIN..=f64::MAX, required)]
    value: f64,
}

impl Node for OpenNumber {}

impl Pointwise for OpenNumber {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        Value::Field(vec![lowering.build.constant(self.value)])
    }

    fn reference(&self, _inputs: &References<'_>) -> Reference {
        Reference::Field(vec![self.value])
    }
}

pub(super) static COLOR: NodeType = NodeType::of::<OpenColor>();
pub(super) static MASK: NodeType = NodeType::of::<OpenMask>();
pub(super) static NUMBER: NodeType = NodeType::of::<OpenNumber>();
