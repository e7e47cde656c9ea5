//! Procedural noise on lattices of two to four dimensions: gradient noise and feature points.
//!
//! Everything random comes of integers, so that it is the same on every machine. A coordinate is split in f64 into its
//! cell and a fraction; the fraction alone goes on in f32, so that noise far from the origin is as fine as near it.

/// What the octaves are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoiseKind {
    /// Gradient noise, in [−1, 1].
    Fbm,
    /// Sharp ridges where gradient noise passes zero, in [0, 1].
    Ridged,
    /// Distance to the nearest feature point in cells, at most 1.
    Cellular,
    /// By how much the second nearest feature point is farther, in [0, 1]: 0 on the borders between cells.
    Edges,
}

impl NoiseKind {
    /// Between which numbers it lies.
    pub(crate) fn range(self) -> (f64, f64) {
        if self == Self::Fbm { (-1.0, 1.0) } else { (0.0, 1.0) }
    }
}

/// One octave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Octave {
    /// Cells in a unit of the coordinates.
    pub(crate) frequency: f64,
    /// Its share of the sum; all of them sum to 1.
    pub(crate) weight: f64,
    /// What its random numbers are made of.
    pub(crate) seed: u32,
    /// Where its lattice lies, so that the octaves' cells do not begin at one point.
    pub(crate) shift: [f64; 4],
}

/// The most axes.
const MOST: usize = 4;

/// A sum of octaves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Noise {
    pub(crate) kind: NoiseKind,
    pub(crate) octaves: Vec<Octave>,
    /// Place along the last axis in cells, the same in every octave, where the noise has one beside those of space.
    pub(crate) evolution: Option<f64>,
}

/// Figures of the octaves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes {
    /// Size of a cell of the first octave, in the unit of the coordinates.
    pub(crate) scale: f64,
    pub(crate) octaves: usize,
    pub(crate) lacunarity: f64,
    pub(crate) gain: f64,
    pub(crate) seed: u32,
}

/// Spreads the bits of a number over all of its bits: a bijection (Wellons, hash-prospector, "lowbias32").
#[inline]
pub(crate) fn mix(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Takes one more number into a hash.
#[inline]
pub(crate) fn extend(hash: u32, cell: i64) -> u32 {
    let high = ((cell as u64 >> 32) as u32).wrapping_mul(GOLDEN);
    mix((hash ^ cell as u32 ^ high).wrapping_add(GOLDEN))
}

/// 2³² over the golden ratio.
const GOLDEN: u32 = 0x9e37_79b9;

/// The component of a corner's gradient along an axis, in [−1, 1].
#[inline]
pub(crate) fn gradient(hash: u32, axis: usize) -> f32 {
    (2 * ((hash >> (8 * axis)) & 255) as i32 - 255) as f32 / 255.0
}

/// Where a cell's feature point lies along an axis, from 0 to 1.
#[inline]
pub(crate) fn feature(hash: u32, axis: usize) -> f32 {
    let bits = mix(hash.wrapping_add(1 + axis as u32 / 2)) >> (16 * (axis as u32 % 2));
    ((bits & 0xffff) as f32 + 0.5) / 65536.0
}

/// What gradient noise is multiplied by: its standard deviation is then about 0.3 at a cell's center, whatever the
/// number of axes, and fewer than one sample in a thousand is cut.
pub(crate) const AMPLITUDE: [f32; MOST + 1] = [0.0, 0.0, 1.5, 1.7, 2.1];

impl Noise {
    pub(crate) fn new(kind: NoiseKind, axes: Axes, evolution: Option<f64>) -> Self {
        let mut octaves = Vec::with_capacity(axes.octaves);
        let (mut frequency, mut weight) = (1.0 / axes.scale, 1.0);
        for index in 0..axes.octaves {
            let seed = extend(extend(0, i64::from(axes.seed)), index as i64);
            let shift = [1, 2, 3, 4].map(|axis| f64::from(mix(seed.wrapping_add(axis))) / 4_294_967_296.0);
            octaves.push(Octave { frequency, weight, seed, shift });
            frequency *= axes.lacunarity;
            weight *= axes.gain;
        }
        let total: f64 = octaves.iter().map(|octave| octave.weight).sum();
        octaves.iter_mut().for_each(|octave| octave.weight /= total);
        Self { kind, octaves, evolution }
    }

    /// Fills `out` with the noise at points of `S` axes: 2 or 3.
    pub(crate) fn fill<const S: usize>(&self, points: impl Iterator<Item = [f64; S]>, out: &mut [f32]) {
        let kind = self.kind;
        match (S, self.evolution) {
            (2, None) => self.sum::<S, 2>(kind, points, out),
            (2, Some(_)) | (3, None) => self.sum::<S, 3>(kind, points, out),
            _ => self.sum::<S, 4>(kind, points, out),
        }
    }

    fn sum<const S: usize, const D: usize>(
        &self,
        kind: NoiseKind,
        points: impl Iterator<Item = [f64; S]>,
        out: &mut [f32],
    ) {
        match kind {
            NoiseKind::Fbm => self.each::<S, D>(points, out, gradient_noise),
            NoiseKind::Ridged => self.each::<S, D>(points, out, |seed, cell, f| {
                let valley = 1.0 - gradient_noise(seed, cell, f).abs();
                valley * valley
            }),
            NoiseKind::Cellular => {
                self.each::<S, D>(points, out, |seed, cell, f| nearest::<D, false>(seed, cell, f)[0]);
            }
            NoiseKind::Edges => self.each::<S, D>(points, out, |seed, cell, f| {
                let [first, second] = nearest::<D, true>(seed, cell, f);
                second - first
            }),
        }
    }

    #[inline]
    fn each<const S: usize, const D: usize>(
        &self,
        points: impl Iterator<Item = [f64; S]>,
        out: &mut [f32],
        octave_at: impl Fn(u32, [i64; D], [f32; D]) -> f32,
    ) {
        let (low, high) = self.kind.range();
        for (out, point) in out.iter_mut().zip(points) {
            let mut sum = 0.0;
            for octave in &self.octaves {
                let (mut cell, mut fraction) = ([0; D], [0.0; D]);
                for axis in 0..D {
                    let along = if axis < S { point[axis] * octave.frequency } else { self.evolution.unwrap_or(0.0) };
                    (cell[axis], fraction[axis]) = split(along + octave.shift[axis]);
                }
                sum += octave.weight as f32 * octave_at(octave.seed, cell, fraction);
            }
            *out = sum.clamp(low as f32, high as f32);
        }
    }
}

/// The cell of a coordinate, and how far into it the coordinate lies, in [0, 1]. What is not finite counts as 0.
#[inline]
fn split(coordinate: f64) -> (i64, f32) {
    if coordinate.abs() < 4e18 {
        let toward_zero = coordinate as i64;
        let cell = toward_zero - i64::from(toward_zero as f64 > coordinate);
        (cell, (coordinate - cell as f64) as f32)
    } else {
        // No number of this size has a fraction.
        (if coordinate.is_finite() { coordinate as i64 } else { 0 }, 0.0)
    }
}

/// t³(6t² − 15t + 10).
#[inline]
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Gradient noise of one octave, in [−1, 1]. Corners share the hashes of the axes before.
#[inline]
fn gradient_noise<const D: usize>(seed: u32, cell: [i64; D], fraction: [f32; D]) -> f32 {
    let (mut hashes, mut weights) = ([seed; 1 << MOST], [1.0f32; 1 << MOST]);
    for axis in 0..D {
        let (half, s) = (1 << axis, fade(fraction[axis]));
        for corner in 0..half {
            let (hash, weight) = (hashes[corner], weights[corner]);
            hashes[corner] = extend(hash, cell[axis]);
            hashes[corner + half] = extend(hash, cell[axis].wrapping_add(1));
            weights[corner] = weight * (1.0 - s);
            weights[corner + half] = weight * s;
        }
    }
    let mut sum = 0.0;
    for corner in 0..1 << D {
        let mut dot = 0.0;
        for (axis, inside) in fraction.iter().enumerate() {
            dot += gradient(hashes[corner], axis) * (inside - ((corner >> axis) & 1) as f32);
        }
        sum += weights[corner] * dot;
    }
    (AMPLITUDE[D] * sum).clamp(-1.0, 1.0)
}

/// Distances to the nearest and, where asked for, the second nearest feature point, each at most 1: so far the cells
/// around hold every point. A cell that lies farther than what is found is passed over.
#[inline]
fn nearest<const D: usize, const SECOND: bool>(seed: u32, cell: [i64; D], fraction: [f32; D]) -> [f32; 2] {
    let (mut first, mut second) = (1.0f32, 1.0f32);
    for index in 0..3usize.pow(D as u32) {
        let (mut rest, mut steps, mut bound) = (index, [0i64; D], 0.0);
        for (step, inside) in steps.iter_mut().zip(fraction) {
            // The own cell comes first, since most points are found there.
            *step = [0, -1, 1][rest % 3];
            rest /= 3;
            let away = match *step {
                -1 => inside,
                1 => 1.0 - inside,
                _ => 0.0,
            };
            bound += away * away;
        }
        if bound > if SECOND { second } else { first } {
            continue;
        }
        let mut hash = seed;
        for axis in 0..D {
            hash = extend(hash, cell[axis].wrapping_add(steps[axis]));
        }
        let mut squared = 0.0;
        for (axis, (step, inside)) in steps.iter().zip(fraction).enumerate() {
            let away = *step as f32 + feature(hash, axis) - inside;
            squared += away * away;
        }
        if squared < first {
            (first, second) = (squared, first);
        } else if squared < second {
            second = squared;
        }
    }
    [first.sqrt(), second.sqrt()]
}

#[cfg(test)]
mod tests {
    use super::super::noise_reference::reference;
    use super::*;

    const KINDS: [NoiseKind; 4] = [NoiseKind::Fbm, NoiseKind::Ridged, NoiseKind::Cellular, NoiseKind::Edges];

    fn axes(seed: u32) -> Axes {
        Axes { scale: 0.7, octaves: 5, lacunarity: 2.17, gain: 0.6, seed }
    }

    /// Points that are small, huge, on the lattice, negative and not finite.
    fn points() -> Vec<[f64; 3]> {
        let mut points = vec![[0.0; 3], [f64::INFINITY, 1.0, -2.5], [1e300, -1e300, 3.0], [-0.7, 1.4, 0.7]];
        for index in 0..400u32 {
            let random = |axis: u32| f64::from(mix(index * 3 + axis + 1)) / 4_294_967_296.0 - 0.5;
            let size = [3.0, 1e3, 1e7, 1e9][index as usize % 4];
            points.push([0, 1, 2].map(|axis| size * random(axis)));
        }
        points
    }

    #[test]
    fn agrees_with_the_reference_far_from_the_origin_too() {
        for kind in KINDS {
            for (seed, evolution) in [(0, None), (7, Some(0.0)), (1_000_000_000, Some(-123.456))] {
                let noise = Noise::new(kind, axes(seed), evolution);
                let mut out = vec![f32::NAN; points().len()];
                noise.fill(points().into_iter(), &mut out);
                let mut flat = out.clone();
                noise.fill(points().into_iter().map(|[x, y, _]| [x, y]), &mut flat);
                for ([x, y, z], (in_space, in_plane)) in points().into_iter().zip(out.into_iter().zip(flat)) {
                    for (found, truth) in
                        [(in_space, reference(&noise, &[x, y, z])), (in_plane, reference(&noise, &[x, y]))]
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
                let noise = Noise::new(kind, Axes { octaves: 1, scale: 1.0, ..axes(3) }, None);
                let (mut low, mut high, mut last) = (f64::INFINITY, f64::NEG_INFINITY, None::<f64>);
                for step in 0..20_000 {
                    let t = f64::from(step) * 0.003;
                    let point = [t, 0.37 * t - 20.0, -0.21 * t];
                    let value = reference(&noise, &point[..dimensions]);
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
            Noise::new(NoiseKind::Fbm, Axes { octaves: 1, ..axes(seed) }, None).fill(points.iter().copied(), &mut out);
            out
        };
        let (a, b) = (of(1), of(2));
        let product: f32 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
        let (aa, bb): (f32, f32) = (a.iter().map(|a| a * a).sum(), b.iter().map(|b| b * b).sum());
        assert!(product.abs() < 0.3 * (aa * bb).sqrt(), "correlation {}", product / (aa * bb).sqrt());
    }
}
