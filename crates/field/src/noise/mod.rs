//! Procedural noise on lattices of two to four dimensions: gradient noise and feature points.
//!
//! All random numbers are computed from integers, so they are the same on every machine. Coordinates are split in f64
//! into a cell and a fraction, and only the fraction is rounded to f32. Noise is therefore as precise far from the
//! origin as near it.

mod cells;
mod features;
mod gradients;
mod reference;
mod span;

use cells::Cells;
use fearless_simd::{Level, Simd, dispatch, f32x16, f64x8, prelude::*, u32x16};
use features::{feature, nearest};
use gradients::{AMPLITUDE, Corners, gradient, gradient_noise, gradient_noises};
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

    /// Fills `out` with the noise at points of `S` axes, 2 or 3. Octaves whose cells are smaller than a point's
    /// footprint (in the unit of the coordinates) are replaced by their mean there. No footprints mean footprints of 0.
    pub fn fill<const S: usize>(
        &self,
        mut points: impl Iterator<Item = [f64; S]>,
        footprints: &[f32],
        out: &mut [f32],
    ) {
        const { assert!(S == 2 || S == 3) };
        let mut chunk = Chunk { places: [[0.0; CHUNK]; 3], prints: [0.0; CHUNK] };
        for (index, out) in out.chunks_mut(CHUNK).enumerate() {
            for (lane, point) in points.by_ref().take(out.len()).enumerate() {
                chunk.places.iter_mut().zip(point).for_each(|(along, coordinate)| along[lane] = coordinate);
            }
            if let Some(found) = footprints.get(index * CHUNK..) {
                chunk.prints.iter_mut().zip(found).for_each(|(print, found)| *print = *found);
            }
            self.fill_chunk(S, &chunk, out);
        }
    }

    /// Fills `out` with the noise at points of `space` axes. It is not generic, so that this long code is compiled once,
    /// and not with each iterator of points.
    fn fill_chunk(&self, space: usize, chunk: &Chunk, out: &mut [f32]) {
        let level = Level::new();
        macro_rules! sum {
            ($space:literal, $axes:literal) => {
                dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                    self.sum::<_, $space, $axes>(simd, chunk, out);
                }))
            };
        }
        match (space, self.evolution) {
            (2, None) => sum!(2, 2),
            (2, Some(_)) => sum!(2, 3),
            (_, None) => sum!(3, 3),
            (_, Some(_)) => sum!(3, 4),
        }
    }

    /// Fills `out` with the noise, octave by octave. Every lane performs the same operations in the same order on every
    /// processor.
    #[inline(always)]
    fn sum<V: Simd, const S: usize, const D: usize>(&self, simd: V, chunk: &Chunk, out: &mut [f32]) {
        let mut sums = [0.0; CHUNK];
        let sums = &mut sums[..out.len().next_multiple_of(LANES)];
        for octave in &self.octaves {
            self.add::<V, S, D>(simd, octave, chunk, sums);
        }
        let (low, high) = self.kind.range();
        for sums in sums.chunks_exact_mut(LANES) {
            clamped(simd, f32x16::from_slice(simd, sums), low as f32, high as f32).store_slice(sums);
        }
        out.copy_from_slice(&sums[..out.len()]);
    }

    /// Adds an octave to the sums at blocks of points.
    #[inline(always)]
    fn add<V: Simd, const S: usize, const D: usize>(&self, simd: V, octave: &Octave, chunk: &Chunk, sums: &mut [f32]) {
        let (weight, mean) = (octave.weight as f32, self.kind.mean(D) as f32);
        let mut corners = Corners::default();
        for (start, sums) in (0..).step_by(LANES).zip(sums.chunks_exact_mut(LANES)) {
            let prints = f32x16::from_slice(simd, &chunk.prints[start..][..LANES]);
            let kept = kept(simd, prints * octave.frequency as f32);
            let mut added = f32x16::splat(simd, mean);
            if !kept.simd_eq(0.0).all_true() {
                let mut along = [[f64x8::splat(simd, self.evolution.unwrap_or(0.0) + octave.shift[D - 1]); 2]; D];
                for axis in 0..S {
                    for (half, along) in along[axis].iter_mut().enumerate() {
                        let place =
                            f64x8::from_slice(simd, &chunk.places[axis][start + half * (LANES / 2)..][..LANES / 2]);
                        *along = place * octave.frequency + octave.shift[axis];
                    }
                }
                let values = self.octave(simd, octave.seed, &along, &mut corners);
                added = kept * values + (f32x16::splat(simd, 1.0) - kept) * mean;
            }
            (f32x16::from_slice(simd, sums) + added * weight).store_slice(sums);
        }
    }

    #[inline(always)]
    fn octave<V: Simd, const D: usize>(
        &self,
        simd: V,
        seed: u32,
        along: &[[f64x8<V>; 2]; D],
        corners: &mut Corners<D>,
    ) -> f32x16<V> {
        if self.kind == NoiseKind::Fbm || self.kind == NoiseKind::Ridged {
            let noises = match Cells::of(simd, along) {
                Some(cells) => gradient_noises(simd, seed, &cells, corners),
                None => far_gradient_noises(simd, seed, along),
            };
            if self.kind == NoiseKind::Fbm {
                return noises;
            }
            let valleys = f32x16::splat(simd, 1.0) - noises.abs();
            return valleys * valleys;
        }
        let (mut cells, mut fractions) = ([[0; LANES]; D], [[0.0; LANES]; D]);
        for axis in 0..D {
            for lane in 0..LANES {
                let along = along[axis][lane / (LANES / 2)].as_slice()[lane % (LANES / 2)];
                (cells[axis][lane], fractions[axis][lane]) = split(along);
            }
        }
        let values = if self.kind == NoiseKind::Cellular {
            nearest::<D, false, false>(seed, &cells, &fractions).distances[0]
        } else {
            nearest::<D, true, false>(seed, &cells, &fractions).edges()
        };
        f32x16::from_slice(simd, &values)
    }

    /// Fills `out` with noise of kind [`NoiseKind::Edges`] at points of the plane, without footprints and without
    /// evolution, and `slopes` with its derivatives along both axes, per unit of the coordinates.
    pub fn fill_edges(&self, points: &[[f64; 2]], out: &mut [f32], slopes: &mut [[f32; 2]]) {
        debug_assert!(self.kind == NoiseKind::Edges && self.evolution.is_none());
        let level = Level::new();
        let blocks = points.chunks(LANES).zip(out.chunks_mut(LANES)).zip(slopes.chunks_mut(LANES));
        for ((points, out), slopes) in blocks {
            let mut places = [[0.0; LANES]; 2];
            for (lane, point) in points.iter().enumerate() {
                places.iter_mut().zip(point).for_each(|(along, coordinate)| along[lane] = *coordinate);
            }
            let [sums, across, along] = dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                self.edges(&places)
            }));
            out.copy_from_slice(&sums[..out.len()]);
            slopes.iter_mut().zip(across).zip(along).for_each(|((slope, x), y)| *slope = [x, y]);
        }
    }

    #[inline(always)]
    fn edges(&self, places: &[[f64; LANES]; 2]) -> [Lanes; 3] {
        let mut sums = [[0.0; LANES]; 3];
        for octave in &self.octaves {
            let (cells, fractions) = octave.cells::<2, 2>(places);
            let (weight, steepness) = (octave.weight as f32, (octave.weight * octave.frequency) as f32);
            let found = nearest::<2, true, true>(octave.seed, &cells, &fractions);
            let [values, across, along] = [found.edges(), found.slopes(0), found.slopes(1)];
            for lane in 0..LANES {
                sums[0][lane] += weight * values[lane];
                sums[1][lane] += steepness * across[lane];
                sums[2][lane] += steepness * along[lane];
            }
        }
        sums[0] = sums[0].map(|sum| sum.clamp(0.0, 1.0));
        sums
    }
}

/// Returns gradient noise at a block of points of which some are far from the origin.
#[inline(never)]
fn far_gradient_noises<V: Simd, const D: usize>(simd: V, seed: u32, along: &[[f64x8<V>; 2]; D]) -> f32x16<V> {
    f32x16::from_fn(simd, |lane| {
        let parts = along.each_ref().map(|[low, high]| {
            let half = if lane < LANES / 2 { low } else { high };
            split(half.as_slice()[lane % (LANES / 2)])
        });
        gradient_noise(seed, parts.map(|(cell, _)| cell), parts.map(|(_, fraction)| fraction))
    })
}

impl Octave {
    /// Splits positions, whose first `S` axes are those of space, into cells and fractions within them.
    #[inline(always)]
    fn cells<const S: usize, const D: usize>(&self, places: &[[f64; LANES]; D]) -> ([[i64; LANES]; D], [Lanes; D]) {
        let (mut cells, mut fractions) = ([[0; LANES]; D], [[0.0; LANES]; D]);
        for axis in 0..D {
            let frequency = if axis < S { self.frequency } else { 1.0 };
            for lane in 0..LANES {
                let along = places[axis][lane] * frequency + self.shift[axis];
                (cells[axis][lane], fractions[axis][lane]) = split(along);
            }
        }
        (cells, fractions)
    }
}

/// Number of points computed at once, and a value for each of them.
const LANES: usize = 16;
type Lanes = [f32; LANES];

/// Number of points whose coordinates are collected before their noise is computed: a vector that is read right after
/// its parts were written has to wait.
const CHUNK: usize = 128;

/// Points: their coordinates along the axes of space, and their footprints.
struct Chunk {
    places: [[f64; CHUNK]; 3],
    prints: [f32; CHUNK],
}

/// Returns the fraction of an octave that a footprint of `cells` cells leaves: 1 up to half a cell, 0 from one cell on.
#[inline(always)]
fn kept<S: Simd>(simd: S, cells: f32x16<S>) -> f32x16<S> {
    let t = clamped(simd, f32x16::splat(simd, 2.0) - cells * 2.0, 0.0, 1.0);
    t * t * (f32x16::splat(simd, 3.0) - t * 2.0)
}

/// Limits numbers to a range; what is not a number stays so.
#[inline(always)]
fn clamped<S: Simd>(simd: S, numbers: f32x16<S>, low: f32, high: f32) -> f32x16<S> {
    let (low, high) = (f32x16::splat(simd, low), f32x16::splat(simd, high));
    let numbers = numbers.simd_lt(low).select(low, numbers);
    numbers.simd_gt(high).select(high, numbers)
}

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

    const KINDS: [NoiseKind; 4] = [NoiseKind::Fbm, NoiseKind::Ridged, NoiseKind::Cellular, NoiseKind::Edges];

    fn parameters(seed: u32) -> NoiseParameters {
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

    /// Passes points to `check` in blocks of `LANES`, as vector code.
    pub(super) fn in_lanes<const D: usize>(points: &[[f64; D]], check: impl Fn(&[[i64; LANES]; D], &[Lanes; D])) {
        for lanes in points.chunks_exact(LANES) {
            let (mut cells, mut fractions) = ([[0; LANES]; D], [[0.0; LANES]; D]);
            for (lane, point) in lanes.iter().enumerate() {
                for axis in 0..D {
                    (cells[axis][lane], fractions[axis][lane]) = split(point[axis]);
                }
            }
            dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || check(&cells, &fractions)));
        }
    }

    /// Points in rows, near each other and in cells of their own, with some that are hostile.
    fn rows() -> Vec<[f64; 3]> {
        let edge = (1u64 << 30) as f64;
        let hostile = [f64::NAN, f64::INFINITY, -f64::INFINITY, 5e-324, -0.0, 1e17, -edge, edge - 0.25, 0.5 - edge];
        let mut rows = points();
        for (row, step) in [0.0, 1e-3, 0.02, 0.11, 0.3, 0.9, 7.0, 0.05].into_iter().enumerate() {
            for index in 0..150 {
                let along = (f64::from(index) - 70.0) * step;
                let mut point = [along, 0.3 * along - 5.0, 2.0 - along];
                if row == 7 && index % 15 == 14 {
                    point[index as usize % 3] = hostile[index as usize / 15 % hostile.len()];
                }
                rows.push(point);
            }
        }
        rows.extend(hostile.map(|hostile| [hostile; 3]));
        rows
    }

    #[test]
    fn blocks_have_the_bits_of_single_points() {
        fn check<const S: usize, const D: usize>(evolution: Option<f64>) {
            let noise = Noise::new(NoiseKind::Fbm, NoiseParameters { octaves: 1, ..parameters(77) }, evolution);
            let octave = &noise.octaves[0];
            let points: Vec<[f64; S]> = rows()
                .iter()
                .map(|point| [0, 1, 2][..S].iter().map(|axis| point[*axis]))
                .map(|point| point.collect::<Vec<_>>().try_into().unwrap())
                .collect();
            for first in [0, 1, 5] {
                let points = &points[first..];
                let mut out = vec![f32::NAN; points.len()];
                noise.fill(points.iter().copied(), &[], &mut out);
                for (point, found) in points.iter().zip(out) {
                    let parts: [(i64, f32); D] = std::array::from_fn(|axis| match point.get(axis) {
                        Some(along) => split(along * octave.frequency + octave.shift[axis]),
                        None => split(evolution.unwrap() + octave.shift[axis]),
                    });
                    let truth = gradient_noise(octave.seed, parts.map(|part| part.0), parts.map(|part| part.1));
                    // The sum of octaves has no negative zeros.
                    assert_eq!(found.to_bits(), (truth + 0.0).to_bits(), "{point:?}: {found}, expected {truth}");
                }
            }
        }
        check::<2, 2>(None);
        check::<2, 3>(Some(0.3));
        check::<3, 3>(None);
        check::<3, 4>(Some(-7.6));
        check::<3, 4>(Some(1e15));
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
