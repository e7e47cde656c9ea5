//! Largest distance between the vertices of a sea.

use crate::ChannelSet;
use trochoid_sea::Sea;

/// Largest chord error of the tessellation, in pixels, at a root-mean-square crest times [`CREST`].
const CHORD_PX: f64 = 0.2;
/// Largest error of normals at such a crest, in radians.
const NORMAL_RAD: f64 = 0.01;
/// Sharpest curvature that matters, in multiples of its root mean square.
const CREST: f64 = 3.0;
/// Spacing over footprint: with σ = footprint/2 the Gaussian leaves exp(−(π/1.2)²/2) = 3 % of a wave at the sampling
/// limit of two vertices per wave, and less of anything that could alias.
const PER_FOOTPRINT: f64 = 0.6;

/// Inverse of the largest slope error of a cubic Hermite curve over h, in h³ times its fourth derivative: 216/√3.
const HERMITE: f64 = 124.7;

/// What lies between vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Facets {
    /// Triangles, with normals interpolated linearly if at all.
    Flat,
    /// Bicubic patches.
    Curved,
}

impl Facets {
    /// Returns those of a mesh for these channels: one without any is for rays that meet its triangles.
    pub(crate) fn of(wanted: ChannelSet) -> Self {
        if wanted == ChannelSet::EMPTY { Self::Flat } else { Self::Curved }
    }
}

/// Spacing of vertices as a function of footprint and pixel size.
///
/// A chord of length h misses a curve of curvature κ by κh²/8, and this error should stay below a fifth of a pixel: the
/// triangles decide what is seen at contours, whatever lies between the vertices. A normal that is interpolated over h
/// has an error of h²/8 times the derivative of the curvature, and that of a patch one of h³·√3/216 times the second
/// derivative; it should stay below [`NORMAL_RAD`]. Finally, a surface smoothed by a Gaussian of σ = footprint/2 has no
/// detail finer than about that: vertices that the first two rules would set closer would be wasted.
#[derive(Clone, Debug)]
pub(crate) struct Spacing {
    /// Curvature in 1/m and its first two derivatives, at logarithmically spaced footprints from `first` on.
    bends: Vec<[f64; 3]>,
    first: f64,
    /// Factor on all spacings: above 1 if vertices must be saved.
    pub(crate) coarseness: f64,
}

/// Entries per octave of the footprint.
const PER_OCTAVE: f64 = 4.0;

impl Spacing {
    pub(crate) fn new(sea: &Sea) -> Self {
        let lengths = || sea.waves().iter().map(|wave| wave.wavelength);
        let shortest = lengths().fold(f64::INFINITY, f64::min);
        let longest = lengths().fold(0.0, f64::max);
        if longest == 0.0 {
            return Self { bends: vec![[0.0; 3]], first: 1.0, coarseness: 1.0 };
        }
        // A footprint below a twentieth of a wavelength keeps the wave; one of two wavelengths removes it.
        let first = shortest / 20.0;
        let octaves = libm::log2(longest * 2.0 / first);
        // Crests are sharper than the sum of sinusoids by 1/(1 − compression).
        let compressions = sea.waves().iter().map(|wave| wave.compression() * wave.compression() / 2.0);
        let sharp = 1.0 / (1.0 - libm::sqrt(compressions.sum::<f64>()).min(0.75));
        let footprints = (0..(octaves * PER_OCTAVE).ceil() as usize)
            .map(|index| first * libm::exp2(index as f64 / PER_OCTAVE))
            .collect::<Vec<f64>>();
        let mut bends = sea.derivatives_rms([2, 3, 4], &footprints);
        bends.iter_mut().flatten().for_each(|bend| *bend = *bend * CREST * sharp);
        bends.push([0.0; 3]);
        Self { bends, first, coarseness: 1.0 }
    }

    /// Returns the spacing in meters for a footprint and the size of a pixel, both in meters; infinite on a flat sea.
    pub(crate) fn at(&self, facets: Facets, footprint: f64, pixel: f64) -> f64 {
        let octave = libm::log2((footprint / self.first).max(1.0)) * PER_OCTAVE;
        // The previous entry has the larger curvature.
        let [curvature, slope, turn] = self.bends[(octave as usize).min(self.bends.len() - 1)];
        if curvature == 0.0 {
            return f64::INFINITY;
        }
        let chord = libm::sqrt(8.0 * CHORD_PX * pixel / curvature);
        let normal = match facets {
            Facets::Flat => libm::sqrt(8.0 * NORMAL_RAD / slope),
            Facets::Curved => libm::cbrt(HERMITE * NORMAL_RAD / turn),
        };
        self.coarseness * chord.min(normal).max(PER_FOOTPRINT * footprint)
    }
}
