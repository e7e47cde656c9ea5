//! What a sea is made of, for plots.

/// A wave of a sea.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// Crest to crest, m.
    pub wavelength: f64,
    /// Vertical amplitude, m.
    pub amplitude: f64,
    /// Where it travels, degrees: 0 is +X, 90 is +Z.
    pub direction: f64,
    /// Share of the cusp that it takes alone: 1 is the sharpest crest that does not fold.
    pub sharpness: f64,
}

/// What a node answers to [`Dynamics::spectrum`](crate::Dynamics::spectrum).
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Its waves, in no order.
    pub waves: Vec<Harmonic>,
    /// By how much all sharpness may be multiplied until crests fold over: below 1 some do; infinite where none ever will.
    pub unfolded: f64,
}
