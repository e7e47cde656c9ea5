/// Numbers that are no partition of unity, or no knob of one.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WeightsError {
    /// A mask outside [0, 1].
    #[error("a mask is a number from 0 to 1, found {value}")]
    Mask {
        /// What was found.
        value: f32,
    },
    /// A power below 1.
    #[error("a power is at least 1, found {value}: below 1 its slope at 0 is infinite")]
    Power {
        /// What was found.
        value: f32,
    },
    /// A negative or non-finite weight.
    #[error("weight {index} is {value}: weights are finite and at least 0")]
    Weight {
        /// Its position, from 0.
        index: usize,
        /// What was found.
        value: f64,
    },
    /// Weights that do not sum to 1.
    #[error("the weights sum to {sum}: they must sum to 1 (within 1e-6)")]
    Sum {
        /// What they sum to.
        sum: f64,
    },
    /// No weights, or too many.
    #[error("{count} weights: a partition has 1 to {}", crate::arithmetic::MAX_WEIGHTS)]
    Count {
        /// How many were asked for.
        count: usize,
    },
    /// A value or threshold that is not finite.
    #[error("value {index} is {value}: only finite values can be used here")]
    Value {
        /// Its position, from 0.
        index: usize,
        /// What was found.
        value: f32,
    },
    /// A floor that does not keep the quotient finite.
    #[error("the floor is {value}: it must be finite and greater than 0")]
    Floor {
        /// What was found.
        value: f32,
    },
    /// A band width that is no width.
    #[error("the width is {value}: it must be finite and at least 0")]
    Width {
        /// What was found.
        value: f32,
    },
    /// Thresholds out of order.
    #[error("threshold {index} is below the one before it: thresholds ascend")]
    Order {
        /// Position of the smaller one, from 0.
        index: usize,
    },
}
