/// Profile of bursts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// (p·H/2)·(cos(min(π·|(u−x)/r|/p, π)) + 1): p·H at the center, 0 beyond its radius, smooth. Scaled so that a
    /// resting burst reaches its own height.
    #[default]
    Intended,
    /// H·cos(min(p·|(u−x)/r|, π) + 1) as printed, at every step: a cusp in the center, −0.54·H everywhere far away.
    Literal,
}
