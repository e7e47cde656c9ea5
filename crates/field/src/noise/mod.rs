//! Procedural noise on lattices of two to four dimensions: gradient noise and feature points.
//!
//! All random numbers are computed from integers, so they are the same on every machine. Coordinates are split in f64
//! into a cell and a fraction, and only the fraction is rounded to f32. Noise is therefore as precise far from the
//! origin as near it.

mod cells;
mod features;
mod fill;
mod gradients;
mod reference;
mod span;

use fearless_simd::{Simd, u32x16};
use features::feature;
use gradients::{AMPLITUDE, gradient};
use trochoid_graph::Choice;

/// Type of noise in the octaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum NoiseKind {
    /// Gradient noise, in [−1, 1].
    Fbm,
    /// Sharp ridges where gradient noise passes zero, in [0, 1].
    Ridged,
    /// Distance to the nearest feature point in cells, at most 1.
    Cellular,
    /// Distance to the second nearest feature point minus that to the nearest, in [0, 1]: 0 on the borders between
    /// cells.
    Edges,
}

impl NoiseKind {
    /// Returns the range of the noise.
    pub fn range(self) -> (f64, f64) {
        if self == Self::Fbm { (-1.0, 1.0) } else { (0.0, 1.0) }
    }

    /// Returns the measured mean on lattices with this number of axes.
    ///
    /// # Panics
    /// If there are fewer than 2 axes or more than 4.
    pub fn mean(self, axes: usize) -> f64 {
        let by_axes = match self {
            Self::Fbm => [0.0; 3],
            Self::Ridged => [0.65, 0.58, 0.51],
            Self::Cellular => [0.43, 0.52, 0.59],
            Self::Edges => [0.27, 0.2, 0.16],
        };
        by_axes[axes - 2]
    }
}

/// One octave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Octave {
    /// Cells per unit of the coordinates.
    pub frequency: f64,
    /// Weight in the sum; the weights of all octaves sum to 1.
    pub weight: f64,
    /// Seed of its random numbers.
    pub seed: u32,
    /// Offset of its lattice, so that the cells of different octaves do not coincide at the origin.
    pub shift: [f64; 4],
}

/// Largest number of axes.
const MOST: usize = 4;

/// A sum of octaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Type of noise in the octaves.
    pub kind: NoiseKind,
    /// Octaves, largest cells first.
    pub octaves: Vec<Octave>,
    /// Coordinate along an additional last axis, in cells, the same in every octave; `None` if there is no such axis.
    pub evolution: Option<f64>,
}

/// Parameters of the octaves.
#[derive(Clone, Copy, Debug)]
pub struct NoiseParameters {
    /// Size of a cell of the first octave, in the unit of the coordinates.
    pub scale: f64,
    /// Number of octaves.
    pub octaves: usize,
    /// Factor by which the cells of each octave are smaller than those of the one before.
    pub lacunarity: f64,
    /// Factor of each octave's weight relative to the one before.
    pub gain: f64,
    /// Random seed.
    pub seed: u32,
}

/// Mixes the bits of a number: a bijection (Wellons, hash-prospector, "lowbias32").
#[inline(always)]
pub(crate) fn mix(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// The same for a block.
#[inline(always)]
fn mixed<S: Simd>(x: u32x16<S>) -> u32x16<S> {
    let x = x ^ (x >> 16);
    let x = x * 0x7feb_352d;
    let x = x ^ (x >> 15);
    let x = x * 0x846c_a68b;
    x ^ (x >> 16)
}

/// Adds a number to a hash.
#[inline]
pub(crate) fn extend(hash: u32, cell: i64) -> u32 {
    mix((hash ^ key(cell)).wrapping_add(GOLDEN))
}

/// 2³² divided by the golden ratio.
const GOLDEN: u32 = 0x9e37_79b9;

impl Noise {
    /// Makes the octaves for these parameters. Their weights sum to 1.
    pub fn new(kind: NoiseKind, parameters: NoiseParameters, evolution: Option<f64>) -> Self {
        let mut octaves = Vec::with_capacity(parameters.octaves);
        let (mut frequency, mut weight) = (1.0 / parameters.scale, 1.0);
        for index in 0..parameters.octaves {
            let seed = extend(extend(0, i64::from(parameters.seed)), index as i64);
            let shift = [1, 2, 3, 4].map(|axis| f64::from(mix(seed.wrapping_add(axis))) / 4_294_967_296.0);
            octaves.push(Octave { frequency, weight, seed, shift });
            frequency *= parameters.lacunarity;
            weight *= parameters.gain;
        }
        let total: f64 = octaves.iter().map(|octave| octave.weight).sum();
        octaves.iter_mut().for_each(|octave| octave.weight /= total);
        Self { kind, octaves, evolution }
    }
}

/// Number of points computed at once.
const LANES: usize = 16;

/// Splits a coordinate into its cell and the fraction within it, in [0, 1]. A coordinate that is not finite counts as
/// 0.
#[inline(always)]
fn split(coordinate: f64) -> (i64, f32) {
    if coordinate.abs() < 4e18 {
        let toward_zero = coordinate as i64;
        let cell = toward_zero - i64::from(toward_zero as f64 > coordinate);
        (cell, (coordinate - cell as f64) as f32)
    } else {
        // Numbers of this size have no fraction.
        (if coordinate.is_finite() { coordinate as i64 } else { 0 }, 0.0)
    }
}

/// Returns the cell's number folded into 32 bits, for a hash.
#[inline(always)]
fn key(cell: i64) -> u32 {
    cell as u32 ^ ((cell as u64 >> 32) as u32).wrapping_mul(GOLDEN)
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) const KINDS: [NoiseKind; 4] = [NoiseKind::Fbm, NoiseKind::Ridged, NoiseKind::Cellular, NoiseKind::Edges];

    pub(super) fn parameters(seed: u32) -> NoiseParameters {
        NoiseParameters { scale: 0.7, octaves: 5, lacunarity: 2.17, gain: 0.6, seed }
    }

    /// Points that are small, huge, on the lattice, negative, or not finite.
    pub(super) fn points() -> Vec<[f64; 3]> {
        let mut points = vec![[0.0; 3], [f64::INFINITY, 1.0, -2.5], [1e300, -1e300, 3.0], [-0.7, 1.4, 0.7]];
        for index in 0..400u32 {
            let random = |axis: u32| f64::from(mix(index * 3 + axis + 1)) / 4_294_967_296.0 - 0.5;
            let size = [3.0, 1e3, 1e7, 1e9][index as usize % 4];
            points.push([0, 1, 2].map(|axis| size * random(axis)));
        }
        points
    }

    #[test]
    fn edges_come_with_their_slopes() {
        let points: Vec<[f64; 2]> = points().into_iter().map(|[x, y, _]| [x, y]).collect();
        for figures in [parameters(7), NoiseParameters { octaves: 1, scale: 1.0, ..parameters(3) }] {
            let noise = Noise::new(NoiseKind::Edges, figures, None);
            let (mut plain, mut out) = (vec![f32::NAN; points.len()], vec![f32::NAN; points.len()]);
            let mut slopes = vec![[f32::NAN; 2]; points.len()];
            noise.fill(points.iter().copied(), &[], &mut plain);
            noise.fill_edges(&points, &mut out, &mut slopes);
            assert!(plain.iter().zip(&out).all(|(plain, out)| plain.to_bits() == out.to_bits()));
            let (mut smooth, mut off) = (0, 0);
            for (point, slope) in points.iter().zip(&slopes) {
                let (value, truth) = noise.edges_reference(*point);
                assert_eq!(value, noise.reference(point, 0.0));
                // Of two points at nearly the same distance, rounding may pick the other one.
                let distance = (0..2).map(|axis| (f64::from(slope[axis]) - truth[axis]).abs()).fold(0.0, f64::max);
                off += usize::from(distance > 1e-3);
                // Where the differences to both sides agree, they equal the slope.
                for axis in 0..2 {
                    let beside = |step: f64| {
                        let mut beside = *point;
                        beside[axis] += step;
                        (noise.reference(&beside, 0.0) - value) / step
                    };
                    let (before, after) = (beside(-1e-6), beside(1e-6));
                    if point[axis].abs() < 10.0 && (before - after).abs() < 1e-3 {
                        assert!((before - truth[axis]).abs() < 2e-3, "{point:?}: {before}, found {}", truth[axis]);
                        smooth += 1;
                    }
                }
            }
            assert!(off <= 3, "{off} slopes differ from the reference");
            assert!(smooth > 150, "only {smooth} smooth places");
        }
    }

    #[test]
    fn agrees_with_the_reference_far_from_the_origin_too() {
        for kind in KINDS {
            for (seed, evolution) in [(0, None), (7, Some(0.0)), (1_000_000_000, Some(-123.456))] {
                let noise = Noise::new(kind, parameters(seed), evolution);
                let mut out = vec![f32::NAN; points().len()];
                noise.fill(points().into_iter(), &[], &mut out);
                let mut flat = out.clone();
                noise.fill(points().into_iter().map(|[x, y, _]| [x, y]), &[], &mut flat);
                for ([x, y, z], (in_space, in_plane)) in points().into_iter().zip(out.into_iter().zip(flat)) {
                    for (found, truth) in
                        [(in_space, noise.reference(&[x, y, z], 0.0)), (in_plane, noise.reference(&[x, y], 0.0))]
                    {
                        let error = (f64::from(found) - truth).abs();
                        assert!(error < 3e-6, "{kind:?} at {x}, {y}, {z}: {found}, expected {truth}");
                        let (low, high) = kind.range();
                        assert!((low..=high).contains(&truth));
                    }
                }
            }
        }
    }

    #[test]
    fn is_continuous_and_uses_its_range() {
        for kind in KINDS {
            for dimensions in [2, 3] {
                let noise = Noise::new(kind, NoiseParameters { octaves: 1, scale: 1.0, ..parameters(3) }, None);
                let (mut low, mut high, mut last) = (f64::INFINITY, f64::NEG_INFINITY, None::<f64>);
                for step in 0..20_000 {
                    let t = f64::from(step) * 0.003;
                    let point = [t, 0.37 * t - 20.0, -0.21 * t];
                    let value = noise.reference(&point[..dimensions], 0.0);
                    if let Some(last) = last {
                        assert!((value - last).abs() < 0.02, "{kind:?}: a step of {} at {t}", (value - last).abs());
                    }
                    (low, high, last) = (low.min(value), high.max(value), Some(value));
                }
                let (least, most) = kind.range();
                assert!(high - low > 0.55 * (most - least), "{kind:?} spans {low} to {high}");
            }
        }
    }

    #[test]
    fn seeds_and_octaves_are_unlike() {
        let points: Vec<[f64; 2]> = (0..200).map(|i| [f64::from(i) * 0.31, f64::from(i) * 0.17]).collect();
        let of = |seed: u32| {
            let mut out = vec![0.0; points.len()];
            Noise::new(NoiseKind::Fbm, NoiseParameters { octaves: 1, ..parameters(seed) }, None).fill(
                points.iter().copied(),
                &[],
                &mut out,
            );
            out
        };
        let (a, b) = (of(1), of(2));
        let product: f32 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
        let (aa, bb): (f32, f32) = (a.iter().map(|a| a * a).sum(), b.iter().map(|b| b * b).sum());
        assert!(product.abs() < 0.3 * (aa * bb).sqrt(), "correlation {}", product / (aa * bb).sqrt());
    }

    #[test]
    fn footprints_take_what_is_finer_and_leave_the_mean() {
        for kind in KINDS {
            for evolution in [None, Some(0.3)] {
                let noise = Noise::new(kind, parameters(3), evolution);
                let points: Vec<[f64; 3]> = points();
                let prints: Vec<f32> = (0..points.len()).map(|i| [0.0, 0.01, 0.2, 0.5, 9.0, 1e30][i % 6]).collect();
                let mut out = vec![f32::NAN; points.len()];
                noise.fill(points.iter().copied(), &prints, &mut out);
                let mut flat = out.clone();
                noise.fill(points.iter().map(|[x, y, _]| [*x, *y]), &prints, &mut flat);
                for ((point, print), (found, flat)) in points.iter().zip(&prints).zip(out.iter().zip(&flat)) {
                    for (found, truth) in [
                        (found, noise.reference(point, f64::from(*print))),
                        (flat, noise.reference(&point[..2], f64::from(*print))),
                    ] {
                        assert!(
                            (f64::from(*found) - truth).abs() < 3e-6,
                            "{kind:?}, {point:?}, {print}: {found}, {truth}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn means_are_those_of_the_noise() {
        for kind in KINDS {
            for axes in 2..=4 {
                let figures = NoiseParameters { octaves: 1, scale: 1.0, ..self::parameters(5) };
                // Slices through the last axis differ, so average over several of them.
                let (slices, count) = (8, 5_000);
                let mut sum = 0.0;
                for slice in 0..slices {
                    let evolution = (axes == 4).then(|| f64::from(slice) * 3.625);
                    let noise = Noise::new(kind, figures, evolution);
                    let points = (0..count).map(|i| f64::from(i + slice * count));
                    let points = points.map(|i| [i * 0.7548, i * 0.5698, i * 0.3313]);
                    let mut out = vec![0.0; count as usize];
                    if axes == 2 {
                        noise.fill(points.map(|[x, y, _]| [x, y]), &[], &mut out);
                    } else {
                        noise.fill(points, &[], &mut out);
                    }
                    sum += out.iter().map(|value| f64::from(*value)).sum::<f64>();
                }
                let mean = sum / f64::from(slices * count);
                assert!((mean - kind.mean(axes)).abs() < 0.02, "{kind:?} of {axes} axes: {mean}");
            }
        }
    }
}
