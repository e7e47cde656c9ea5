//! Wave models on plain slices: sums of trochoidal waves, their footprint filter and their folds.
//!
//! # The model
//! A point of the resting sea p₀ = (x₀, z₀) is carried to
//!
//! ```text
//! x = x₀ − Σ hᵢ dᵢ.x sin θᵢ      θᵢ = kᵢ (dᵢ · p₀) − ωᵢ t + φᵢ
//! y =      Σ aᵢ cos θᵢ
//! z = z₀ − Σ hᵢ dᵢ.z sin θᵢ
//! ```
//!
//! with amplitude aᵢ, horizontal amplitude hᵢ, unit direction of travel dᵢ and k = 2π/L. Crests are sharp and troughs
//! flat if h > 0. A single wave reaches its cusp at q = h·k = 1 (Gerstner 1802; Hinsinger, Neyret and Cani,
//! *Interactive Animation of Ocean Waves*, 2002).
//!
//! # Conventions
//! Meters, seconds, radians. Y is up. A direction is an azimuth of travel: 0 is +X, and it grows toward +Z.
//!
//! # The footprint filter
//! Waves that a pixel cannot resolve are attenuated by exp(−(k·σ)²/2), σ = footprint/2, and the slope variance that
//! they lose is reported, so that shading can widen its highlights instead. The filter is part of the sea's
//! definition: the f64 reference includes it too.
//!
//! # Evaluation
//! [`SeaFrame::evaluate`] is the plain f64 sum. [`SeaFrame::direct`] computes the same in f32 at any points, and
//! [`SeaFrame::scattered`] at points that do not affect a bit of one another. [`GridPlan`] evaluates on a regular
//! grid, by the cheapest [`Method`] for its size: from about fifty waves on, that is a non-uniform Fourier transform,
//! whose cost hardly depends on their number. All methods reduce every phase to one turn in f64 first. Results do not
//! depend on the processor or the number of threads: additions, multiplications and exact roundings are done in a
//! fixed order and never fused.

#[macro_use]
mod parameters;

mod direct;
mod fields;
mod folding;
mod frame;
mod framed;
mod grid;
mod grid_plan;
mod group;
mod kernel;
pub mod kernel64;
mod lanes;
mod line;
mod method;
mod nufft;
mod phase;
mod precise;
mod ripple;
mod scattered;
mod separable;
mod spectrum;
pub mod spray;
mod spread;
pub mod toon;
mod transforms;
mod wave;

pub use fields::{FieldSet, Fields, Points, Sample};
pub use folding::{FoldOptions, Folding};
pub use frame::{Sea, SeaFrame};
pub use framed::{ColumnFactors, FramedSea, FramedWave, RowFactors};
pub use grid::{Grid, GridError, MAX_POINTS, MAX_SIDE};
pub use grid_plan::GridPlan;
pub use group::{MAX_GROUP, WaveGroup};
pub use line::{Line, LineScratch, Lines};
pub use method::Method;
pub use precise::{Precise, PreciseSea};
pub use ripple::Ripple;
pub use spectrum::{Convention, Dispersion, GerstnerSpectrum, MAX_WAVES, SpectrumError};
pub use wave::{ExplicitWave, GRAVITY, Wave, WaveError, WaveParameter, attenuation};

/// What the tests of this crate see beside its interface. They stand outside, in `tests/sea`, so that the crate is not
/// compiled a second time for them. Nothing of it is part of the interface.
#[doc(hidden)]
pub mod inside {
    use crate::lanes::{self, Lanes};
    use crate::line::spreader::{self, Spreader};
    use crate::spray::functions;
    use crate::transforms::Transform;
    use crate::{FieldSet, Fields, Line, LineScratch, Lines};
    use fearless_simd::{Level, dispatch, f64x8, prelude::*};
    use rustfft::num_traits::Zero;

    /// Number of cells over which a frequency is spread, before the one that contains it.
    pub const BEFORE: usize = spreader::BEFORE;

    /// Returns (1 − e^−s)/s and (s − 1 + e^−s)/s².
    pub fn decays(s: f64) -> (f64, f64) {
        crate::spray::flight::decays(s)
    }

    /// Returns position and velocity of a drop after `time` seconds.
    pub fn fly(position: [f64; 3], velocity: [f64; 3], wind: [f64; 3], drag: f64, time: f64) -> ([f64; 3], [f64; 3]) {
        crate::spray::flight::fly(position, velocity, wind, drag, time)
    }

    /// Returns sines and cosines of angles in half turns, as precise sums compute them.
    pub fn sincos_half_turns(angles: [f64; 8]) -> [[f64; 8]; 2] {
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            crate::kernel64::sincos(simd, f64x8::load_array(simd, angles)).map(|found| found.to_array())
        }))
    }

    /// Returns sines and cosines of angles in radians, as the water below drops is summed.
    pub fn sincos_lanes(angles: [f64; 8]) -> [[f64; 8]; 2] {
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            functions::sincos(simd, f64x8::load_array(simd, angles)).map(|found| found.to_array())
        }))
    }

    /// Returns powers 2^−n, as precise sums compute them.
    pub fn halved(halvings: [f64; 8]) -> [f64; 8] {
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            crate::kernel64::halved(simd, f64x8::load_array(simd, halvings)).to_array()
        }))
    }

    /// Returns eˣ, as bounds of sums are computed.
    pub fn exp(x: [f64; 8]) -> [f64; 8] {
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            crate::kernel64::exp(simd, f64x8::load_array(simd, x)).to_array()
        }))
    }

    /// Spreads a frequency for lines of `count` points: returns the number of cells of the grid, the first cell, and
    /// the weight of each.
    pub fn spread(count: usize, turns: f64) -> (usize, usize, [f32; spreader::WIDTH]) {
        let spreader = Spreader::new(count);
        let (cell, weights) = spreader.place(turns);
        (spreader.cells(), cell, weights)
    }

    /// Returns the kernel by which frequencies are spread, at a distance in cells.
    pub fn spread_kernel(offset: f64) -> f64 {
        spreader::kernel().value(offset)
    }

    /// Returns the length of a fast transform, of at least `length` cells.
    pub fn fast_length(length: usize) -> usize {
        spreader::fast_length(length)
    }

    /// Returns the inverse Fourier transform of complex numbers, without the factor 1/length.
    pub fn inverse_transform(values: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let lane = |value: f64| Lanes([value, 0.0, 1.0, -value]);
        let mut lines: Vec<lanes::Line<f64>> =
            values.iter().map(|&[re, im]| lanes::Line { re: lane(re), im: lane(im) }).collect();
        let transform = Transform::new(lines.len());
        let mut scratch = vec![lines.first().copied().unwrap_or_else(Zero::zero); transform.scratch_len()];
        transform.process(&mut lines, &mut scratch);
        lines.iter().map(|line| [line.re.0[0], line.im.0[0]]).collect()
    }

    /// Sums the waves along a line by a transform, however short the line is.
    pub fn transform(lines: &Lines<'_>, line: &Line, wanted: FieldSet, scratch: &mut LineScratch, out: &mut Fields) {
        lines.transform(line, lines.waves(line), wanted, scratch, out);
    }

    /// Sums the waves along a line one by one, however long the line is.
    pub fn sum(lines: &Lines<'_>, line: &Line, wanted: FieldSet, scratch: &mut LineScratch, out: &mut Fields) {
        lines.sum(line, wanted, scratch, out);
    }
}
