//! The closed pointwise program to which back-end nodes lower.
//!
//! A program is a list of operations in single-assignment form: each refers to its operands by their positions before
//! it. There are three types of value: a *scalar* (a mask or one component of a field), a *color* (three channels
//! that always share their weights), and a *partition* (n weights that sum to exactly 1). No operation takes a color
//! to a scalar or a partition, so weights never depend on control colors; colors are only added with the weights of
//! one partition. Every program is therefore convex, and its output is linear in its control colors.
//!
//! The engine has the kernel of each operation and the rules for its interval, error, blame and variance. Nodes that
//! lower need none of their own.

use crate::NodeId;

/// Position of a scalar in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Scalar(pub u32);
/// Position of a color in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Color(pub u32);
/// Position of a partition in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Partition(pub u32);

/// A plane that is filled outside of the program: one channel of one output of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Slot {
    /// The node.
    pub node: NodeId,
    /// Index of its output.
    pub output: usize,
    /// Index of the channel within the output.
    pub channel: usize,
}

/// One operation. Its numbers are f32, the type that kernels work with.
#[derive(Clone, Debug, PartialEq)]
pub enum Op {
    /// A scalar from outside of the program.
    Load(Slot),
    /// A scalar constant.
    Constant(f32),
    /// 1 where max ≤ x; (x − min)/(max − min) where min ≤ x; else 0. A mask.
    Clamp {
        /// Any field.
        x: Scalar,
        /// Lower limit: below it the mask is 0.
        min: f32,
        /// Upper limit: from it on the mask is 1; `max = min` is a step.
        max: f32,
    },
    /// t²(3 − 2t). A mask.
    Smooth(Scalar),
    /// tᵖ. A mask.
    Power {
        /// A mask.
        t: Scalar,
        /// At least 1.
        p: f32,
    },
    /// 1 where x ≥ threshold, else 0. A mask.
    Step {
        /// Any field.
        x: Scalar,
        /// Smallest value where the mask is 1.
        threshold: f32,
    },
    /// 1 − t. A mask.
    Complement(Scalar),
    /// t·u. A mask.
    Product(Scalar, Scalar),
    /// Weights that sum to 1 up to rounding, corrected to sum to exactly 1.
    Partition(Vec<Scalar>),
    /// v/max(S, τ) over n fields with the sum S (negative values count as 0), and the remainder as weight n + 1.
    Normalize {
        /// Finite fields.
        values: Vec<Scalar>,
        /// τ > 0.
        floor: f32,
    },
    /// One weight of a partition, as a mask.
    Weight(Partition, usize),
    /// A color from outside of the program: three channels of the slot's output, of which `channel` is the first.
    LoadColor(Slot),
    /// A control color.
    ConstantColor([f32; 3]),
    /// (1 − t)·a + t·b, computed so that it never leaves the bounding box of the operands.
    Mix {
        /// Result at t = 0.
        a: Color,
        /// Result at t = 1.
        b: Color,
        /// A mask.
        t: Scalar,
    },
    /// Σ wᵢ·cᵢ.
    Blend {
        /// Colors, one per weight of the partition.
        colors: Vec<Color>,
        /// The weights.
        weights: Partition,
    },
}

/// Type of an operation's result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// One row.
    Scalar,
    /// Three rows.
    Color,
    /// One row per weight.
    Partition(usize),
}

impl Op {
    /// Returns the type of the result.
    pub fn ty(&self) -> Type {
        match self {
            Self::LoadColor(_) | Self::ConstantColor(_) | Self::Mix { .. } | Self::Blend { .. } => Type::Color,
            Self::Partition(weights) => Type::Partition(weights.len()),
            Self::Normalize { values, .. } => Type::Partition(values.len() + 1),
            _ => Type::Scalar,
        }
    }

    /// Calls `f` with the position of every operand.
    pub fn operands(&self, mut f: impl FnMut(u32)) {
        match self {
            Self::Load(_) | Self::Constant(_) | Self::LoadColor(_) | Self::ConstantColor(_) => {}
            Self::Clamp { x, .. } | Self::Step { x, .. } => f(x.0),
            Self::Smooth(t) | Self::Power { t, .. } | Self::Complement(t) => f(t.0),
            Self::Product(t, u) => [t, u].into_iter().for_each(|s| f(s.0)),
            Self::Partition(weights) => weights.iter().for_each(|s| f(s.0)),
            Self::Normalize { values, .. } => values.iter().for_each(|s| f(s.0)),
            Self::Weight(partition, _) => f(partition.0),
            Self::Mix { a, b, t } => [a.0, b.0, t.0].into_iter().for_each(f),
            Self::Blend { colors, weights } => {
                colors.iter().for_each(|c| f(c.0));
                f(weights.0);
            }
        }
    }

    /// Replaces the position of every operand.
    pub fn renumbered(&self, new: impl Fn(u32) -> u32) -> Self {
        let s = |scalar: Scalar| Scalar(new(scalar.0));
        let c = |color: Color| Color(new(color.0));
        match self {
            Self::Load(_) | Self::Constant(_) | Self::LoadColor(_) | Self::ConstantColor(_) => self.clone(),
            Self::Clamp { x, min, max } => Self::Clamp { x: s(*x), min: *min, max: *max },
            Self::Step { x, threshold } => Self::Step { x: s(*x), threshold: *threshold },
            Self::Smooth(t) => Self::Smooth(s(*t)),
            Self::Power { t, p } => Self::Power { t: s(*t), p: *p },
            Self::Complement(t) => Self::Complement(s(*t)),
            Self::Product(t, u) => Self::Product(s(*t), s(*u)),
            Self::Partition(weights) => Self::Partition(weights.iter().map(|w| s(*w)).collect()),
            Self::Normalize { values, floor } => {
                Self::Normalize { values: values.iter().map(|v| s(*v)).collect(), floor: *floor }
            }
            Self::Weight(partition, i) => Self::Weight(Partition(new(partition.0)), *i),
            Self::Mix { a, b, t } => Self::Mix { a: c(*a), b: c(*b), t: s(*t) },
            Self::Blend { colors, weights } => Self::Blend {
                colors: colors.iter().map(|color| c(*color)).collect(),
                weights: Partition(new(weights.0)),
            },
        }
    }
}

/// Operations in order, each with the node that it comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    ops: Vec<(Op, NodeId)>,
}

impl Program {
    /// Returns the operations, each with the node that it comes from.
    pub fn ops(&self) -> &[(Op, NodeId)] {
        &self.ops
    }

    /// Appends an operation and returns its position.
    pub fn push(&mut self, op: Op, origin: NodeId) -> u32 {
        debug_assert!({
            let mut earlier = true;
            op.operands(|operand| earlier &= (operand as usize) < self.ops.len());
            earlier
        });
        self.ops.push((op, origin));
        (self.ops.len() - 1) as u32
    }
}
