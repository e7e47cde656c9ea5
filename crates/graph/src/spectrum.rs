//! Wave spectra of seas, for plots.

/// A wave of a sea.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// Wavelength from crest to crest, m.
    pub wavelength: f64,
    /// Vertical amplitude, m.
    pub amplitude: f64,
    /// Direction of travel, degrees: 0 is +X, 90 is +Z.
    pub direction: f64,
    /// Sharpness of the crest of this wave alone: 1 is the sharpest crest that does not fold.
    pub sharpness: f64,
}

/// Result of [`Dynamics::spectrum`](crate::Dynamics::spectrum).
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Waves, in no particular order.
    pub waves: Vec<Harmonic>,
    /// Largest factor on all sharpnesses without crests that fold over: below 1, some crests fold; infinite if none
    /// ever do.
    pub unfolded: f64,
    /// How the lengths of the random waves are drawn, which come first; `None` if no waves are random.
    pub lengths: Option<LengthDistribution>,
}

/// A log-normal distribution of wavelengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthDistribution {
    /// Number of waves.
    pub count: usize,
    /// Mean wavelength, m.
    pub mean: f64,
    /// Standard deviation of the logarithm of the wavelength.
    pub spread: f64,
}
