//! Mixes colors over a chunk; each source of a color is compiled into the loop.

use crate::audit::BitRange;
use crate::code::{CHUNK, Chunk};
use fearless_simd::{Bytes, Simd, SimdBase, f32x16, mask32x16, u32x16};
use trochoid_memory::{Stream, Target};

/// Makes an array of an expression's values for channels 0, 1 and 2. [`array::map`] is not always inlined, and a
/// function that is not inlined is compiled without the current instruction set.
macro_rules! rgb {
    ($c:ident => $value:expr) => {{
        let $c = 0usize;
        let r = $value;
        let $c = 1usize;
        let g = $value;
        let $c = 2usize;
        let b = $value;
        [r, g, b]
    }};
}
pub(crate) use rgb;

pub(crate) const LANES: usize = 16;
const VECTORS: usize = CHUNK / LANES;

pub(crate) type Lanes<S> = f32x16<S>;

#[inline(always)]
pub(crate) fn load<S: Stream>(simd: S, row: &[f32; CHUNK], i: usize) -> Lanes<S> {
    f32x16::from_slice(simd, &row[LANES * i..LANES * (i + 1)])
}

#[inline(always)]
pub(crate) fn splat<S: Stream>(simd: S, color: &[f32; 3]) -> [Lanes<S>; 3] {
    rgb!(c => simd.splat_f32x16(color[c]))
}

/// A mask prepared for mixing: which end of the mix is nearer, and the distance from it.
#[derive(Clone, Copy)]
pub(crate) struct PreparedMask<S: Stream> {
    near_a: mask32x16<S>,
    by: Lanes<S>,
}

#[inline(always)]
pub(crate) fn prepare_mask<S: Stream>(simd: S, t: Lanes<S>) -> PreparedMask<S> {
    let near_a = simd.simd_lt_f32x16(t, simd.splat_f32x16(0.5));
    let by = simd.select_f32x16(near_a, t, simd.sub_f32x16(t, simd.splat_f32x16(1.0)));
    PreparedMask { near_a, by }
}

/// Does [`mix`](trochoid_weights::arithmetic::mix) lane by lane: the same operations in the same order.
#[inline(always)]
pub(crate) fn mix<S: Stream>(simd: S, a: Lanes<S>, b: Lanes<S>, t: PreparedMask<S>) -> Lanes<S> {
    mix_with_difference(simd, a, b, simd.sub_f32x16(b, a), t)
}

/// Does the same with the difference known.
#[inline(always)]
pub(crate) fn mix_with_difference<S: Stream>(
    simd: S,
    a: Lanes<S>,
    b: Lanes<S>,
    difference: Lanes<S>,
    t: PreparedMask<S>,
) -> Lanes<S> {
    let near = simd.select_f32x16(t.near_a, a, b);
    if S::FUSED { simd.mul_add_precise_f32x16(t.by, difference, near) } else { mul_add(simd, t.by, difference, near) }
}

/// Adds a product, rounded once, without an instruction for that. It is long, and inlined into each mix, it would be
/// half of all code of this crate.
#[inline(never)]
fn mul_add<S: Simd>(simd: S, a: Lanes<S>, b: Lanes<S>, c: Lanes<S>) -> Lanes<S> {
    simd.mul_add_precise_f32x16(a, b, c)
}

/// Source of a color in a mix.
pub(crate) trait MixOperand<S: Stream>: Copy {
    /// Values that all three channels share.
    type Shared: Copy;
    /// Whether it reads the accumulator.
    const READS_LAST: bool = false;

    fn share(&self, simd: S, i: usize) -> Self::Shared;
    fn get(&self, simd: S, c: usize, i: usize, last: Lanes<S>, shared: Self::Shared) -> Lanes<S>;
}

#[derive(Clone, Copy)]
pub(crate) struct FromLast;

#[derive(Clone, Copy)]
pub(crate) struct FromRows<'a>(pub(super) [&'a [f32; CHUNK]; 3]);

#[derive(Clone, Copy)]
pub(crate) struct FromConstant<S: Stream>(pub(super) [Lanes<S>; 3]);

#[derive(Clone, Copy)]
pub(crate) struct FromPair<'a, S: Stream> {
    from: [Lanes<S>; 3],
    to: [Lanes<S>; 3],
    difference: [Lanes<S>; 3],
    by: &'a [f32; CHUNK],
}

impl<'a, S: Stream> FromPair<'a, S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, from: &[f32; 3], to: &[f32; 3], by: &'a [f32; CHUNK]) -> Self {
        let difference = rgb!(c => to[c] - from[c]);
        Self { from: splat(simd, from), to: splat(simd, to), difference: splat(simd, &difference), by }
    }
}

impl<S: Stream> MixOperand<S> for FromLast {
    type Shared = ();
    const READS_LAST: bool = true;

    #[inline(always)]
    fn share(&self, _simd: S, _i: usize) {}

    #[inline(always)]
    fn get(&self, _simd: S, _c: usize, _i: usize, last: Lanes<S>, _shared: ()) -> Lanes<S> {
        last
    }
}

impl<S: Stream> MixOperand<S> for FromRows<'_> {
    type Shared = ();

    #[inline(always)]
    fn share(&self, _simd: S, _i: usize) {}

    #[inline(always)]
    fn get(&self, simd: S, c: usize, i: usize, _last: Lanes<S>, _shared: ()) -> Lanes<S> {
        load(simd, self.0[c], i)
    }
}

impl<S: Stream> MixOperand<S> for FromConstant<S> {
    type Shared = ();

    #[inline(always)]
    fn share(&self, _simd: S, _i: usize) {}

    #[inline(always)]
    fn get(&self, _simd: S, c: usize, _i: usize, _last: Lanes<S>, _shared: ()) -> Lanes<S> {
        self.0[c]
    }
}

impl<S: Stream> MixOperand<S> for FromPair<'_, S> {
    type Shared = PreparedMask<S>;

    #[inline(always)]
    fn share(&self, simd: S, i: usize) -> PreparedMask<S> {
        prepare_mask(simd, load(simd, self.by, i))
    }

    #[inline(always)]
    fn get(&self, simd: S, c: usize, _i: usize, _last: Lanes<S>, shared: PreparedMask<S>) -> Lanes<S> {
        mix_with_difference(simd, self.from[c], self.to[c], self.difference[c], shared)
    }
}

/// Mixes into the accumulator.
#[inline(always)]
pub(crate) fn mix_rows<S: Stream>(
    simd: S,
    last: &mut [&mut Chunk; 3],
    a: impl MixOperand<S>,
    b: impl MixOperand<S>,
    t: &[f32; CHUNK],
) {
    let [r, g, blue] = last;
    let last = [&mut r.0, &mut g.0, &mut blue.0];
    for i in 0..VECTORS {
        let old = rgb!(c => load(simd, last[c], i));
        let mixed = mix_vector(simd, i, old, a, b, t);
        for c in 0..3 {
            mixed[c].store_slice(&mut last[c][LANES * i..LANES * (i + 1)]);
        }
    }
}

/// Mixes straight into the three targets of a root, from their sample `start` on, and records the bits of the result.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "one call site; all of it is the loop's")]
pub(crate) fn mix_out<S: Stream>(
    simd: S,
    last: &[&mut Chunk; 3],
    a: impl MixOperand<S>,
    b: impl MixOperand<S>,
    t: &[f32; CHUNK],
    out: &mut [Target<'_>; 3],
    start: usize,
    bits: &mut [BitRange; 3],
) {
    put(
        simd,
        out,
        start,
        bits,
        #[inline(always)]
        |i| {
            let old = rgb!(c => load(simd, &last[c].0, i));
            mix_vector(simd, i, old, a, b, t)
        },
    );
}

/// Writes a chunk of colors, 16 pixels at a time, around the cache if requested.
#[inline(always)]
fn put<S: Stream>(
    simd: S,
    out: &mut [Target<'_>; 3],
    start: usize,
    bits: &mut [BitRange; 3],
    color: impl Fn(usize) -> [Lanes<S>; 3],
) {
    let mut seen = ColorBitRange::load(simd, bits);
    let [red, green, blue] = out;
    let mut parts = [red.part(start, CHUNK), green.part(start, CHUNK), blue.part(start, CHUNK)];
    let [red, green, blue] = &mut parts;
    if let (Some(mut red), Some(mut green), Some(mut blue)) = (red.lines(), green.lines(), blue.lines()) {
        for i in 0..VECTORS {
            let [r, g, b] = color(i);
            seen.see(simd, [r, g, b]);
            red.store(i, r);
            green.store(i, g);
            blue.store(i, b);
        }
    } else {
        for i in 0..VECTORS {
            let [r, g, b] = color(i);
            seen.see(simd, [r, g, b]);
            red.store(LANES * i, r);
            green.store(LANES * i, g);
            blue.store(LANES * i, b);
        }
    }
    seen.store(bits);
}

#[inline(always)]
fn mix_vector<S: Stream, A: MixOperand<S>, B: MixOperand<S>>(
    simd: S,
    i: usize,
    old: [Lanes<S>; 3],
    a: A,
    b: B,
    t: &[f32; CHUNK],
) -> [Lanes<S>; 3] {
    let t = prepare_mask(simd, load(simd, t, i));
    let (shared_a, shared_b) = (a.share(simd, i), b.share(simd, i));
    rgb!(c => {
        let last = if A::READS_LAST || B::READS_LAST { old[c] } else { simd.splat_f32x16(0.0) };
        mix(simd, a.get(simd, c, i, last, shared_a), b.get(simd, c, i, last, shared_b), t)
    })
}

/// Mixes by y two pairs mixed by x, into the accumulator.
#[inline(always)]
pub(crate) fn patch_rows<S: Stream>(
    simd: S,
    last: &mut [&mut Chunk; 3],
    corners: &[[f32; 3]; 4],
    x: &[f32; CHUNK],
    y: &[f32; CHUNK],
) {
    let [corner, corner_2, corner_3, corner_4] = corners;
    let (from, to) = (splat(simd, corner), splat(simd, corner_2));
    let (from_2, to_2) = (splat(simd, corner_3), splat(simd, corner_4));
    let difference = splat(simd, &rgb!(c => corners[1][c] - corners[0][c]));
    let difference_2 = splat(simd, &rgb!(c => corners[3][c] - corners[2][c]));
    let [r, g, b] = last;
    let last = [&mut r.0, &mut g.0, &mut b.0];
    for i in 0..VECTORS {
        let (x, y) = (prepare_mask(simd, load(simd, x, i)), prepare_mask(simd, load(simd, y, i)));
        for c in 0..3 {
            let a = mix_with_difference(simd, from[c], to[c], difference[c], x);
            let b = mix_with_difference(simd, from_2[c], to_2[c], difference_2[c], x);
            mix(simd, a, b, y).store_slice(&mut last[c][LANES * i..LANES * (i + 1)]);
        }
    }
}

/// Writes the accumulator to the targets of a root.
#[inline(always)]
pub(crate) fn write_out<S: Stream>(
    simd: S,
    last: &[&mut Chunk; 3],
    out: &mut [Target<'_>; 3],
    start: usize,
    bits: &mut [BitRange; 3],
) {
    put(
        simd,
        out,
        start,
        bits,
        #[inline(always)]
        |i| rgb!(c => load(simd, &last[c].0, i)),
    );
}

/// Extremes of the bits of three channels, in registers.
struct ColorBitRange<S: Stream> {
    least: [u32x16<S>; 3],
    largest: [u32x16<S>; 3],
}

impl<S: Stream> ColorBitRange<S> {
    #[inline(always)]
    fn load(simd: S, bits: &[BitRange; 3]) -> Self {
        Self {
            least: rgb!(c => u32x16::from_slice(simd, &bits[c].least)),
            largest: rgb!(c => u32x16::from_slice(simd, &bits[c].largest)),
        }
    }

    #[inline(always)]
    fn see(&mut self, simd: S, color: [Lanes<S>; 3]) {
        for ((value, least), largest) in color.into_iter().zip(&mut self.least).zip(&mut self.largest) {
            let value: u32x16<S> = value.bitcast();
            *least = simd.min_u32x16(*least, value);
            *largest = simd.max_u32x16(*largest, value);
        }
    }

    #[inline(always)]
    fn store(self, bits: &mut [BitRange; 3]) {
        for ((bits, least), largest) in bits.iter_mut().zip(self.least).zip(self.largest) {
            least.store_slice(&mut bits.least);
            largest.store_slice(&mut bits.largest);
        }
    }
}

/// Records the extremes of the bits of a row of weights or of a channel.
#[inline(always)]
pub(crate) fn see_row<S: Stream>(simd: S, row: &[f32; CHUNK], bits: &mut BitRange) {
    let mut least = u32x16::from_slice(simd, &bits.least);
    let mut largest = u32x16::from_slice(simd, &bits.largest);
    for i in 0..VECTORS {
        let value: u32x16<S> = load(simd, row, i).bitcast();
        least = simd.min_u32x16(least, value);
        largest = simd.max_u32x16(largest, value);
    }
    least.store_slice(&mut bits.least);
    largest.store_slice(&mut bits.largest);
}

/// Records the largest bits of a row of any numbers, with the sign shifted out.
#[inline(always)]
pub(crate) fn see_field<S: Stream>(simd: S, row: &[f32; CHUNK], bits: &mut BitRange) {
    let mut largest = u32x16::from_slice(simd, &bits.largest);
    for i in 0..VECTORS {
        let value: u32x16<S> = load(simd, row, i).bitcast();
        largest = simd.max_u32x16(largest, simd.shl_u32x16(value, 1));
    }
    largest.store_slice(&mut bits.largest);
}

/// Does [`clamp`](trochoid_weights::arithmetic::clamp) for 0 < max − min and bounds below 2¹²⁶: the quotient alone
/// then tells on which side of the bounds x lies, so all cases share one formula.
#[inline(always)]
pub(crate) fn clamp_rows<S: Stream>(simd: S, to: &mut [f32; CHUNK], x: &[f32; CHUNK], min: f32, max: f32) {
    let (low, width) = (simd.splat_f32x16(min), simd.splat_f32x16(max - min));
    let (zero, one) = (simd.splat_f32x16(0.0), simd.splat_f32x16(1.0));
    for i in 0..VECTORS {
        let quotient = simd.div_f32x16(simd.sub_f32x16(load(simd, x, i), low), width);
        // NaN and −0 become 0.
        let ramp = simd.select_f32x16(simd.simd_gt_f32x16(quotient, zero), quotient, zero);
        let clamped = simd.select_f32x16(simd.simd_lt_f32x16(ramp, one), ramp, one);
        clamped.store_slice(&mut to[LANES * i..LANES * (i + 1)]);
    }
}

/// Returns whether all of a mask equals `value` (0 or 1) on a chunk.
#[inline(always)]
pub(crate) fn is_all<S: Stream>(simd: S, row: &[f32; CHUNK], value: f32) -> bool {
    let mut differs = simd.splat_u32x16(0);
    let value: u32x16<S> = simd.splat_u32x16(value.to_bits());
    for i in 0..VECTORS {
        let bits: u32x16<S> = load(simd, row, i).bitcast();
        differs = simd.or_u32x16(differs, simd.xor_u32x16(bits, value));
    }
    let mut lanes = [0u32; LANES];
    differs.store_slice(&mut lanes);
    lanes.iter().all(|lane| *lane == 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid_memory::{Instructions, Kernel, dispatch};
    use trochoid_weights::arithmetic;

    struct Clamp<'a>(&'a mut [f32; CHUNK], &'a [f32; CHUNK], f32, f32);

    impl Kernel for Clamp<'_> {
        type Output = ();

        #[inline(always)]
        fn run<S: Stream>(self, simd: S) {
            clamp_rows(simd, self.0, self.1, self.2, self.3);
        }
    }

    #[test]
    fn the_short_clamp_has_the_bits_of_the_long_one() {
        let tiny = f32::from_bits(1);
        for (min, max) in
            [(0.0, 1.0), (20.0, 1000.0), (-3.0, -2.5), (0.0, tiny), (1.0, 1.0f32.next_up()), (-8e37, 8e37)]
        {
            let near = [min, max].into_iter().flat_map(|v: f32| [v.next_down(), v, v.next_up()]);
            let edges = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, -0.0, tiny, -tiny];
            let between = (0..CHUNK).map(|i| min + (max - min) * (i as f32 / 100.0 - 0.1));
            let values: Vec<f32> = near.chain(edges).chain(between).take(CHUNK).collect();
            let x: [f32; CHUNK] = std::array::from_fn(|i| values[i]);
            for instructions in [Instructions::Best, Instructions::Avx2, Instructions::Baseline] {
                let mut found = [0.0; CHUNK];
                dispatch(instructions.level(), Clamp(&mut found, &x, min, max));
                for (x, found) in x.iter().zip(found) {
                    assert_eq!(found.to_bits(), arithmetic::clamp(*x, min, max).to_bits(), "{x} in {min} to {max}");
                }
            }
        }
    }
}
