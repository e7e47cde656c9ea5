//! Fast tests that pass most pixels: half-spaces in f32, moved inward by more than the rounding error of f32.

use fearless_simd::prelude::*;

use super::nearness::Nearness;
use super::{BoxHull, EVALUATION, Facet};
use trochoid_memory::Scratch;

/// Number of pixels judged together.
pub(super) const BLOCK: usize = 128;

/// The pixels of a block by channels.
pub(super) type Pixels<'a> = [&'a [f32; BLOCK]; 3];

/// Number of planes compared with a box together.
const LANES: usize = 16;

/// Number of vectors of pixels compared with a plane together: their coordinates and maxima stay in registers.
pub(super) const TOGETHER: usize = 4;

/// Unit roundoff of f32.
const U: f64 = 0.5 * f32::EPSILON as f64;

/// Planes by component; the last group is padded with planes that no pixel violates.
pub(super) type Groups = Scratch<[[f32; LANES]; 4]>;

/// A polytope inside a hull, or the hull itself, as a conservative test in f32.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Screen {
    /// Rounded normals, and offsets moved inward.
    planes: Vec<([f32; 3], f64)>,
    /// Bounds of the distance by the excess, by plane.
    nearness: Vec<Nearness>,
    /// Bound for all planes.
    worst: Nearness,
    /// Region of pixels for which the test holds: the bounding box of the hull, slightly enlarged.
    min: [f32; 3],
    max: [f32; 3],
    largest: f64,
}

impl Screen {
    /// Makes the screen of a polytope, given by its planes, inside of a hull with a bounding box; `None` if f32
    /// overflows or underflows.
    pub(super) fn new(planes: &[Facet], nearness: &[Nearness], bounds: &BoxHull, largest: f64) -> Option<Self> {
        if planes.is_empty() || !(1e-30..1e30).contains(&largest) {
            return None;
        }
        // Enough that a pixel that is off by some roundings is still inside.
        let more = largest / 65_536.0;
        let min = bounds.min().map(|v| (f64::from(v) - more) as f32);
        let max = bounds.max().map(|v| (f64::from(v) + more) as f32);
        let planes = planes.iter().map(|plane| narrow(plane, &min, &max, largest)).collect();
        let worst = Nearness::of_worst(nearness);
        Some(Self { planes, nearness: nearness.to_vec(), worst, min, max, largest })
    }

    /// Returns an excess over any plane, or a distance, up to which pixels are certainly within the margin.
    pub(super) fn safe_excess(&self, margin: f64) -> f64 {
        self.worst.excess(margin, self.largest)
    }

    /// Makes the test for a margin.
    ///
    /// A pixel in the box passes if x·n₀ + (y·n₁ + (z·n₂ + n₃)), in f32, is at most 0 for every plane. Then no plane is
    /// violated by more than the excess t ≥ 0 up to which its distance is within the margin.
    ///
    /// *Proof.* For each plane let n be the normal, d the offset and n̂ the rounded normal. For pixels in the box,
    /// the three products and the two inner sums have errors of at most u of their largest values by interval
    /// arithmetic; let E be the sum of these errors. (With fused multiply–add, products have no error.) An inner sum
    /// may be larger by t than its interval, which adds an error of 2 u of t. The outermost sum has the same sign
    /// before and after rounding. n̂·p exceeds n·p by at least D, the minimum of (n̂ − n)·p over the box. So with −n₃
    /// ≤ d + D − E + t(1 − 2u), a pixel that passes has n·p − d ≤ t. ∎
    pub(super) fn groups(&self, margin: f64) -> Groups {
        let mut groups = Scratch::new();
        for (planes, nearness) in self.planes.chunks(LANES).zip(self.nearness.chunks(LANES)) {
            let mut group = [[0.0; LANES], [0.0; LANES], [0.0; LANES], [f32::NEG_INFINITY; LANES]];
            for (lane, ((normal, offset), nearness)) in planes.iter().zip(nearness).enumerate() {
                let offset = offset + nearness.excess(margin, self.largest) * (1.0 - 1e-6);
                let rounded = offset as f32;
                let rounded = if f64::from(rounded) > offset { rounded.next_down() } else { rounded };
                for (i, v) in [normal[0], normal[1], normal[2], -rounded].into_iter().enumerate() {
                    group[i][lane] = v;
                }
            }
            groups.push(group);
        }
        groups
    }

    /// Whether the test holds for a pixel; false for NaN.
    pub(super) fn covers(&self, pixel: &[f32; 3]) -> bool {
        (0..3).all(|i| pixel[i] >= self.min[i] && pixel[i] <= self.max[i])
    }

    /// Whether the test holds for all pixels of a box.
    pub(super) fn covers_box(&self, bounds: &Bounds) -> bool {
        bounds.finite && self.covers(&bounds.min) && self.covers(&bounds.max)
    }
}

/// Returns the pixels of a block that do not pass, as bits. `planes` is scratch space.
///
/// `bounds` is the bounding box of the block, which the screen must cover.
pub(super) fn failing_pixels<S: Simd>(
    simd: S,
    groups: &[[[f32; LANES]; 4]],
    block: Pixels<'_>,
    bounds: &Bounds,
    planes: &mut Vec<[f32; 4]>,
) -> u128 {
    simd.vectorize(
        #[inline(always)]
        || {
            crossing(simd, groups, bounds, planes);
            if planes.is_empty() { 0 } else { violators(simd, planes, block) }
        },
    )
}

/// Collects the planes that some point of a box may violate.
///
/// Rounded sums and products are monotone in each coordinate, so the value at one corner of the box is an upper bound
/// of the values computed for its points.
#[inline(always)]
fn crossing<S: Simd>(simd: S, groups: &[[[f32; LANES]; 4]], bounds: &Bounds, crossing: &mut Vec<[f32; 4]>) {
    crossing.clear();
    let [min_r, min_g, min_b] = bounds.min;
    let [max_r, max_g, max_b] = bounds.max;
    for group in groups {
        let [xs, ys, zs, ws] = group;
        for start in (0..LANES).step_by(S::f32s::LEN) {
            let lanes = start..start + S::f32s::LEN;
            let x = S::f32s::from_slice(simd, &xs[lanes.clone()]);
            let y = S::f32s::from_slice(simd, &ys[lanes.clone()]);
            let z = S::f32s::from_slice(simd, &zs[lanes.clone()]);
            let w = S::f32s::from_slice(simd, &ws[lanes]);
            let r = x.simd_ge(0.0).select(S::f32s::splat(simd, max_r), S::f32s::splat(simd, min_r));
            let g = y.simd_ge(0.0).select(S::f32s::splat(simd, max_g), S::f32s::splat(simd, min_g));
            let b = z.simd_ge(0.0).select(S::f32s::splat(simd, max_b), S::f32s::splat(simd, min_b));
            let value = r.mul_add(x, g.mul_add(y, b.mul_add(z, w)));
            let mut crossed = value.simd_gt(0.0).to_bitmask();
            while crossed != 0 {
                let lane = start + crossed.trailing_zeros() as usize;
                crossing.push([xs[lane], ys[lane], zs[lane], ws[lane]]);
                crossed &= crossed - 1;
            }
        }
    }
}

/// Bounding box of the pixels of a block.
pub(super) struct Bounds {
    min: [f32; 3],
    max: [f32; 3],
    /// Whether all coordinates are finite; otherwise the box is meaningless.
    finite: bool,
}

impl Bounds {
    pub(super) fn of<S: Simd>(simd: S, block: Pixels<'_>) -> Self {
        simd.vectorize(
            #[inline(always)]
            || Self::inlined(simd, block),
        )
    }

    #[inline(always)]
    fn inlined<S: Simd>(simd: S, block: Pixels<'_>) -> Self {
        // 0 times a coordinate that is not finite is NaN, which propagates.
        let mut zero = S::f32s::splat(simd, 0.0);
        let (mut least, mut most) = ([0.0; 3], [0.0; 3]);
        // Plain loops here and below: a closure for `map` would be compiled without the instructions that `simd`
        // enables.
        for c in 0..3 {
            let channel = block[c];
            let mut min = S::f32s::splat(simd, f32::INFINITY);
            let mut max = S::f32s::splat(simd, f32::NEG_INFINITY);
            for values in channel.chunks_exact(S::f32s::LEN) {
                let values = S::f32s::from_slice(simd, values);
                min = min.min(values);
                max = max.max(values);
                zero = values.mul_add(0.0, zero);
            }
            least[c] = min.reduce_min();
            most[c] = max.reduce_max();
        }
        Self { min: least, max: most, finite: zero.reduce_sum() == 0.0 }
    }
}

/// Returns the pixels of a block that violate one of the planes, as bits.
#[inline(always)]
fn violators<S: Simd>(simd: S, planes: &[[f32; 4]], block: Pixels<'_>) -> u128 {
    let [r, g, b] = block;
    let mut violators = 0_u128;
    for start in (0..BLOCK).step_by(TOGETHER * S::f32s::LEN) {
        let zero = S::f32s::splat(simd, 0.0);
        let (mut red, mut green, mut blue) = ([zero; TOGETHER], [zero; TOGETHER], [zero; TOGETHER]);
        for i in 0..TOGETHER {
            let from = start + i * S::f32s::LEN;
            let lanes = from..from + S::f32s::LEN;
            red[i] = S::f32s::from_slice(simd, &r[lanes.clone()]);
            green[i] = S::f32s::from_slice(simd, &g[lanes.clone()]);
            blue[i] = S::f32s::from_slice(simd, &b[lanes]);
        }
        let mut largest = [S::f32s::splat(simd, f32::NEG_INFINITY); TOGETHER];
        for &[x, y, z, w] in planes {
            let (x, y) = (S::f32s::splat(simd, x), S::f32s::splat(simd, y));
            let (z, w) = (S::f32s::splat(simd, z), S::f32s::splat(simd, w));
            for i in 0..TOGETHER {
                largest[i] = largest[i].max(red[i].mul_add(x, green[i].mul_add(y, blue[i].mul_add(z, w))));
            }
        }
        for (i, largest) in largest.iter().enumerate() {
            let beyond = largest.simd_gt(0.0).to_bitmask();
            violators |= u128::from(beyond) << (start + i * S::f32s::LEN);
        }
    }
    violators
}

/// Returns the rounded normal of a plane, and d + D − E.
fn narrow(plane: &Facet, min: &[f32; 3], max: &[f32; 3], largest: f64) -> ([f32; 3], f64) {
    let normal = plane.normal.map(|v| v as f32);
    // From the innermost sum outward.
    let (mut low, mut high) = (-plane.offset, -plane.offset);
    let (mut error, mut drift) = (0.0, 0.0);
    for i in (0..3).rev() {
        let (min, max, wide) = (f64::from(min[i]), f64::from(max[i]), f64::from(normal[i]));
        let (a, b) = (wide * min, wide * max);
        low += a.min(b);
        high += a.max(b);
        error += U * a.abs().max(b.abs());
        if i > 0 {
            error += U * low.abs().max(high.abs());
        }
        let off = wide - plane.normal[i];
        drift += (off * min).min(off * max);
    }
    // The factor and the second term cover terms of second order and the different offset here and in the proof; the
    // last term covers the rounding of f64, here and in the final judgment of a pixel.
    let slack = 1.001 * error + 1e-3 * U * largest + 4.0 * EVALUATION * largest;
    (normal, plane.offset + drift - slack)
}
