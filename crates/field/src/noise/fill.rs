//! Noise at many points: in blocks of points side by side in lanes.

use super::cells::Cells;
use super::features::{Nearest, Neighborhood, nearest, nearest_of_one};
use super::gradients::{Corners, gradient_noise, gradient_noises};
use super::{LANES, Noise, NoiseKind, Octave, split};
use fearless_simd::{Level, Simd, dispatch, f32x16, f64x8, prelude::*};

/// Number of points whose coordinates are collected before their noise is computed: a vector that is read right after
/// its parts were written has to wait.
const CHUNK: usize = 128;

/// Points: their coordinates along the axes of space, and their footprints.
struct Chunk {
    places: [[f64; CHUNK]; 3],
    prints: [f32; CHUNK],
}

impl Chunk {
    fn new() -> Self {
        Self { places: [[0.0; CHUNK]; 3], prints: [0.0; CHUNK] }
    }
}

impl Noise {
    /// Fills `out` with the noise at points of `S` axes, 2 or 3. Octaves whose cells are smaller than a point's
    /// footprint (in the unit of the coordinates) are replaced by their mean there. No footprints mean footprints of 0.
    pub fn fill<const S: usize>(
        &self,
        mut points: impl Iterator<Item = [f64; S]>,
        footprints: &[f32],
        out: &mut [f32],
    ) {
        const { assert!(S == 2 || S == 3) };
        let mut chunk = Chunk::new();
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
        let is_gradient = matches!(self.kind, NoiseKind::Fbm | NoiseKind::Ridged);
        for octave in &self.octaves {
            if is_gradient {
                let mut corners = Corners::default();
                self.add::<V, S, D>(
                    simd,
                    octave,
                    chunk,
                    sums,
                    #[inline(always)]
                    |cells| self.gradients(simd, octave.seed, cells, &mut corners),
                );
            } else {
                let mut around = Neighborhood::default();
                self.add::<V, S, D>(
                    simd,
                    octave,
                    chunk,
                    sums,
                    #[inline(always)]
                    |cells| self.features(simd, octave.seed, cells, &mut around),
                );
            }
        }
        let (low, high) = self.kind.range();
        for sums in sums.chunks_exact_mut(LANES) {
            clamped(simd, f32x16::from_slice(simd, sums), low as f32, high as f32).store_slice(sums);
        }
        out.copy_from_slice(&sums[..out.len()]);
    }

    /// Adds an octave to the sums at blocks of points, whose noise `values` returns.
    #[inline(always)]
    fn add<V: Simd, const S: usize, const D: usize>(
        &self,
        simd: V,
        octave: &Octave,
        chunk: &Chunk,
        sums: &mut [f32],
        mut values: impl FnMut(&Cells<V, D>) -> f32x16<V>,
    ) {
        let (weight, mean) = (octave.weight as f32, self.kind.mean(D) as f32);
        for (start, sums) in (0..).step_by(LANES).zip(sums.chunks_exact_mut(LANES)) {
            let prints = f32x16::from_slice(simd, &chunk.prints[start..][..LANES]);
            let kept = kept(simd, prints * octave.frequency as f32);
            let mut added = f32x16::splat(simd, mean);
            if !kept.simd_eq(0.0).all_true() {
                let along = octave.along::<V, S, D>(simd, chunk, start, self.evolution.unwrap_or(0.0));
                let values = match Cells::of(simd, &along) {
                    Some(cells) => values(&cells),
                    None => self.far_octave(simd, octave.seed, &along),
                };
                added = kept * values + (f32x16::splat(simd, 1.0) - kept) * mean;
            }
            (f32x16::from_slice(simd, sums) + added * weight).store_slice(sums);
        }
    }

    /// Returns an octave of gradient noise at a block of points.
    #[inline(always)]
    fn gradients<V: Simd, const D: usize>(
        &self,
        simd: V,
        seed: u32,
        cells: &Cells<V, D>,
        corners: &mut Corners<D>,
    ) -> f32x16<V> {
        let noises = gradient_noises(simd, seed, cells, corners);
        if self.kind == NoiseKind::Fbm {
            return noises;
        }
        let valleys = f32x16::splat(simd, 1.0) - noises.abs();
        valleys * valleys
    }

    /// Returns an octave of noise from feature points at a block of points.
    #[inline(always)]
    fn features<V: Simd, const D: usize>(
        &self,
        simd: V,
        seed: u32,
        cells: &Cells<V, D>,
        around: &mut Neighborhood<D>,
    ) -> f32x16<V> {
        if self.kind == NoiseKind::Cellular {
            nearest::<V, D, false, false>(simd, seed, cells, around).distances[0]
        } else {
            nearest::<V, D, true, false>(simd, seed, cells, around).edges()
        }
    }

    /// Returns an octave at a block of points of which some are far from the origin.
    #[inline(never)]
    fn far_octave<V: Simd, const D: usize>(&self, simd: V, seed: u32, along: &[[f64x8<V>; 2]; D]) -> f32x16<V> {
        f32x16::from_fn(simd, |lane| {
            let (cell, fraction) = split_lane(along, lane);
            self.of_one(seed, cell, fraction)
        })
    }

    /// Returns an octave at a point: blocks of points have the same bits.
    fn of_one<const D: usize>(&self, seed: u32, cell: [i64; D], fraction: [f32; D]) -> f32 {
        match self.kind {
            NoiseKind::Fbm => gradient_noise(seed, cell, fraction),
            NoiseKind::Ridged => {
                let valley = 1.0 - gradient_noise(seed, cell, fraction).abs();
                valley * valley
            }
            NoiseKind::Cellular => nearest_of_one(seed, cell, fraction)[0].0,
            NoiseKind::Edges => {
                let [(first, _), (second, _)] = nearest_of_one(seed, cell, fraction);
                second - first
            }
        }
    }

    /// Fills `out` with noise of kind [`NoiseKind::Edges`] at points of the plane, without footprints and without
    /// evolution, and `slopes` with its derivatives along both axes, per unit of the coordinates.
    pub fn fill_edges(&self, points: &[[f64; 2]], out: &mut [f32], slopes: &mut [[f32; 2]]) {
        debug_assert!(self.kind == NoiseKind::Edges && self.evolution.is_none());
        let level = Level::new();
        let mut chunk = Chunk::new();
        for ((points, out), slopes) in points.chunks(CHUNK).zip(out.chunks_mut(CHUNK)).zip(slopes.chunks_mut(CHUNK)) {
            for (lane, point) in points.iter().enumerate() {
                chunk.places.iter_mut().zip(point).for_each(|(along, coordinate)| along[lane] = *coordinate);
            }
            let mut sums = [[0.0; CHUNK]; 3];
            dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                for octave in &self.octaves {
                    octave.add_edges(simd, &chunk, &mut sums, points.len());
                }
            }));
            let [values, across, along] = &sums;
            out.iter_mut().zip(values).for_each(|(out, sum)| *out = sum.clamp(0.0, 1.0));
            slopes.iter_mut().zip(across).zip(along).for_each(|((slope, x), y)| *slope = [*x, *y]);
        }
    }
}

impl Octave {
    /// Returns the positions, in cells, of a block of points.
    #[inline(always)]
    fn along<V: Simd, const S: usize, const D: usize>(
        &self,
        simd: V,
        chunk: &Chunk,
        start: usize,
        evolution: f64,
    ) -> [[f64x8<V>; 2]; D] {
        let mut along = [[f64x8::splat(simd, evolution + self.shift[D - 1]); 2]; D];
        for (axis, halves) in along.iter_mut().enumerate().take(S) {
            for (half, along) in halves.iter_mut().enumerate() {
                let places = &chunk.places[axis][start + half * (LANES / 2)..][..LANES / 2];
                *along = f64x8::from_slice(simd, places) * self.frequency + self.shift[axis];
            }
        }
        along
    }

    /// Adds edges and their slopes to the sums at the first `count` points.
    #[inline(always)]
    fn add_edges<V: Simd>(&self, simd: V, chunk: &Chunk, sums: &mut [[f32; CHUNK]; 3], count: usize) {
        let (weight, steepness) = (self.weight as f32, (self.weight * self.frequency) as f32);
        let mut around = Neighborhood::default();
        for start in (0..count).step_by(LANES) {
            let along = self.along::<V, 2, 2>(simd, chunk, start, 0.0);
            let found = match Cells::of(simd, &along) {
                Some(cells) => nearest::<V, 2, true, true>(simd, self.seed, &cells, &mut around),
                None => far_nearest(simd, self.seed, &along),
            };
            let added = [found.edges() * weight, found.slopes(simd, 0) * steepness, found.slopes(simd, 1) * steepness];
            for (sums, added) in sums.iter_mut().zip(added) {
                let sums = &mut sums[start..][..LANES];
                (f32x16::from_slice(simd, sums) + added).store_slice(sums);
            }
        }
    }
}

/// Returns the cell of a lane and the fraction within it.
fn split_lane<V: Simd, const D: usize>(along: &[[f64x8<V>; 2]; D], lane: usize) -> ([i64; D], [f32; D]) {
    let parts = along.each_ref().map(|along| split(along[lane / (LANES / 2)].as_slice()[lane % (LANES / 2)]));
    (parts.map(|part| part.0), parts.map(|part| part.1))
}

/// Returns the nearest feature points of a block of points of which some are far from the origin.
#[inline(never)]
fn far_nearest<V: Simd>(simd: V, seed: u32, along: &[[f64x8<V>; 2]; 2]) -> Nearest<V, 2> {
    let found: [_; LANES] = std::array::from_fn(|lane| {
        let (cell, fraction) = split_lane(along, lane);
        nearest_of_one(seed, cell, fraction)
    });
    Nearest {
        distances: [0, 1].map(|rank| f32x16::from_fn(simd, |lane| found[lane][rank].0)),
        ways: [0, 1].map(|rank| [0, 1].map(|axis| f32x16::from_fn(simd, |lane| found[lane][rank].1[axis]))),
    }
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

#[cfg(test)]
mod tests {
    use super::super::tests::{KINDS, parameters, points};
    use super::*;
    use crate::NoiseParameters;

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
        fn check<const S: usize, const D: usize>(kind: NoiseKind, evolution: Option<f64>) {
            let noise = Noise::new(kind, NoiseParameters { octaves: 1, ..parameters(77) }, evolution);
            let octave = &noise.octaves[0];
            let points: Vec<[f64; S]> = rows().iter().map(|point| std::array::from_fn(|axis| point[axis])).collect();
            for first in [0, 1, 5] {
                let points = &points[first..];
                let mut out = vec![f32::NAN; points.len()];
                noise.fill(points.iter().copied(), &[], &mut out);
                for (point, found) in points.iter().zip(out) {
                    let parts: [_; D] = std::array::from_fn(|axis| match point.get(axis) {
                        Some(along) => split(along * octave.frequency + octave.shift[axis]),
                        None => split(evolution.unwrap() + octave.shift[axis]),
                    });
                    let truth = noise.of_one(octave.seed, parts.map(|part| part.0), parts.map(|part| part.1));
                    // The sum of octaves has no negative zeros.
                    assert_eq!(found.to_bits(), (truth + 0.0).to_bits(), "{point:?}: {found}, expected {truth}");
                }
            }
        }
        for kind in KINDS {
            check::<2, 2>(kind, None);
            check::<2, 3>(kind, Some(0.3));
            check::<3, 3>(kind, None);
            check::<3, 4>(kind, Some(-7.6));
            check::<3, 4>(kind, Some(1e15));
        }
    }

    #[test]
    fn slopes_in_blocks_have_the_bits_of_single_points() {
        let noise = Noise::new(NoiseKind::Edges, NoiseParameters { octaves: 1, ..parameters(5) }, None);
        let octave = &noise.octaves[0];
        let points: Vec<[f64; 2]> = rows().iter().map(|[x, y, _]| [*x, *y]).collect();
        let (mut out, mut slopes) = (vec![f32::NAN; points.len()], vec![[f32::NAN; 2]; points.len()]);
        noise.fill_edges(&points, &mut out, &mut slopes);
        for (point, slopes) in points.iter().zip(slopes) {
            let parts = [0, 1].map(|axis| split(point[axis] * octave.frequency + octave.shift[axis]));
            let found = nearest_of_one(octave.seed, parts.map(|part| part.0), parts.map(|part| part.1));
            for (axis, slope) in slopes.into_iter().enumerate() {
                let [first, second] =
                    found.map(|(distance, way)| if distance > 0.0 { way[axis] / distance } else { 0.0 });
                let truth = octave.frequency as f32 * (first - second) + 0.0;
                assert_eq!(slope.to_bits(), truth.to_bits(), "{point:?}: {slope}, expected {truth}");
            }
        }
    }
}
