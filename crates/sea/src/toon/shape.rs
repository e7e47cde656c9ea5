/// The profile of bursts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// (p·H/2)·(cos(min(π·|(u−x)/r|/p, π)) + 1): 2 × half its height at the center, 0 beyond its radius, smooth. Scaled
    /// so that a burst that rests reaches its own height.
    #[default]
    Intended,
    /// H·cos(min(p·|(u−x)/r|, π) + 1) as printed, at every step: a cusp in the center, −0.54·H everywhere far away.
    Literal,
}
