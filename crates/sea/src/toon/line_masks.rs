//! Line masks of many positions at once: the same mask in single precision, vectorized.

use std::f64::consts::TAU;

use fearless_simd::{Level, Simd, dispatch, f32x4, f32x16, i32x16, prelude::*};

use super::lines::{LEAST_DENSITY, LEAST_NORM, Lines, STALE, TOO_MANY};
use super::trail::Drift;

const LANES: usize = 16;
const COUNT: usize = Drift::LINES as usize;
/// Lines per radian.
const PER_RADIAN: f32 = (Drift::LINES as f64 / TAU) as f32;
/// atan(x)/2π = x·Σ aₙx²ⁿ on 0…1, interpolated at Chebyshev points: to 2e-7 of a turn.
const ATAN: [f32; 7] =
    [0.159_154_82, -0.053_039_464, 0.031_627_335, -0.021_402_94, 0.013_229_986, -0.005_786_942_5, 0.001_217_273_3];

/// Values at some positions and at the four beside each, one pixel away. All slices are as long as the result.
#[derive(Clone, Copy, Debug)]
pub struct LinePlaces<'a> {
    /// Weights.
    pub weight: &'a [f32],
    /// Heights, in meters.
    pub height: &'a [f32],
    /// Weight × (cos, sin) of the angle.
    pub phase: [&'a [f32]; 2],
    /// The same to the left and right, then above and below.
    pub beside: [[[&'a [f32]; 2]; 2]; 2],
}

/// Parameters of each of the lines of a turn: the height at which it ends, the inverse of the height difference to
/// there, half its largest width, and its displacement to the side.
type Table = [[f32; 4]; COUNT];

/// [`Lines`], made ready for many positions.
#[derive(Clone, Debug)]
pub struct LineMasks {
    lines: Lines,
    table: Table,
    /// Weight up to which nothing is drawn.
    stale: f32,
}

impl LineMasks {
    /// Prepares lines.
    pub fn new(lines: Lines) -> Self {
        let stale = (STALE * lines.fresh) as f32;
        Self { lines, table: lines.table(), stale }
    }

    /// Returns the lines.
    pub fn lines(&self) -> &Lines {
        &self.lines
    }

    /// Returns whether nothing is drawn at a weight.
    #[inline]
    pub fn hides(&self, weight: f32) -> bool {
        weight <= self.stale
    }

    /// Computes the masks of positions: those of [`Lines::mask`] with the [`density`](super::lines::density), each the
    /// same wherever in the slices its position is.
    ///
    /// # Panics
    /// The slices are not as long as `out`.
    pub fn fill(&self, places: &LinePlaces<'_>, out: &mut [f32]) {
        let n = out.len();
        let beside = places.beside.as_flattened().as_flattened();
        let all = [places.weight, places.height].into_iter().chain(places.phase).chain(beside.iter().copied());
        assert!({ all }.all(|slice| slice.len() == n), "a value for every place");
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            for start in (0..n).step_by(LANES) {
                self.chunk(simd, places, start, &mut out[start..(start + LANES).min(n)]);
            }
        }));
    }

    #[inline(always)]
    fn chunk<S: Simd>(&self, simd: S, places: &LinePlaces<'_>, start: usize, out: &mut [f32]) {
        let Self { lines, table, stale } = self;
        let zero = f32x16::splat(simd, 0.0);
        let one = f32x16::splat(simd, 1.0);
        let weight = load(simd, places.weight, start);
        let drawn = weight.simd_gt(f32x16::splat(simd, *stale));
        if !drawn.any_true() {
            out.fill(0.0);
            return;
        }
        let here @ [cos, sin] = pair(simd, places.phase, start);
        let square = cos * cos + sin * sin;
        let safe = drawn.select(weight, one);
        let spread = (one - square / (safe * safe)).max(zero).sqrt() * PER_RADIAN;
        let agreed = smooth(weight * (1.0 / lines.fresh) as f32) * smooth(spread * (-1.0 / lines.spread) as f32 + 2.0);
        if !(drawn & agreed.simd_gt(zero)).any_true() {
            out.fill(0.0);
            return;
        }
        // Square of the larger of the sines that determine an angle.
        let [[left, right], [above, below]] = places.beside;
        let across = axis(simd, here, [pair(simd, left, start), pair(simd, right, start)]);
        let density = across + axis(simd, here, [pair(simd, above, start), pair(simd, below, start)]);
        let density = density.sqrt().max(f32x16::splat(simd, LEAST_DENSITY as f32));

        let wide = one / (density * lines.finest as f32).max(f32x16::splat(simd, 1e-9)) - 1.0;
        let shown = drawn.select(agreed * smooth(wide), zero);
        if !shown.simd_gt(zero).any_true() {
            out.fill(0.0);
            return;
        }

        // The angle in turns: that of the octant, then mirrored.
        let (ax, ay) = (cos.max(-cos), sin.max(-sin));
        let (short, long) = (ax.min(ay), ax.max(ay));
        let ratio = short / long.simd_gt(zero).select(long, one);
        let r2 = ratio * ratio;
        let mut angle = r2 * ATAN[6] + ATAN[5];
        for n in (0..5).rev() {
            angle = angle * r2 + ATAN[n];
        }
        let angle = angle * ratio;
        let angle = ay.simd_gt(ax).select(angle * -1.0 + 0.25, angle);
        let angle = cos.simd_lt(zero).select(angle * -1.0 + 0.5, angle);
        let angle = sin.simd_lt(zero).select(-angle, angle);
        let shift = (lines.shift / COUNT as f64).rem_euclid(1.0) as f32;
        let turns = angle + shift;
        let at = (turns - turns.floor()) * COUNT as f32;
        let floor = at.floor();
        let f = at - floor - 0.5;

        // The lines of the pixels, and those beside them.
        let last = (COUNT - 1) as i32;
        let own = floor.to_int::<i32x16<S>>() & last;
        let is_before = f.simd_lt(zero);
        let next = (own + is_before.select(i32x16::splat(simd, last), i32x16::splat(simd, 1))) & last;
        let height = load(simd, places.height, start);
        let at = LineValues { height, shown, density };
        let beyond = is_before.select(f + 1.0, f - 1.0);
        let mask = (covered(table, own, f, at) + covered(table, next, beyond, at)).min(one);
        let mask = shown.simd_gt(zero).select(mask, zero);
        if out.len() == LANES {
            mask.store_slice(out);
        } else {
            out.copy_from_slice(&mask.to_array()[..out.len()]);
        }
    }
}

impl Lines {
    fn table(&self) -> Table {
        std::array::from_fn(|index| {
            let [end, half, aside] = self.line(index as u32);
            let inverse = if end == self.low { 0.0 } else { (1.0 / (end - self.low)) as f32 };
            [end as f32, inverse, half as f32, aside as f32]
        })
    }
}

// Functions and loops instead of closures, which would be compiled without the instruction set, with a call for every
// operation.

/// Loads values from an index on; 0 beyond the end.
#[inline(always)]
fn load<S: Simd>(simd: S, slice: &[f32], at: usize) -> f32x16<S> {
    let rest = &slice[at.min(slice.len())..];
    if let Some(lanes) = rest.first_chunk() {
        return f32x16::load_array_ref(simd, lanes);
    }
    let mut lanes = [0.0; LANES];
    lanes[..rest.len()].copy_from_slice(rest);
    f32x16::load_array_ref(simd, &lanes)
}

/// Loads both components of a phase.
#[inline(always)]
fn pair<S: Simd>(simd: S, [cos, sin]: [&[f32]; 2], at: usize) -> [f32x16<S>; 2] {
    [load(simd, cos, at), load(simd, sin, at)]
}

/// Returns the square of the density along an axis: that of the larger of the sines that determine an angle.
#[inline(always)]
fn axis<S: Simd>(simd: S, [cos, sin]: [f32x16<S>; 2], sides: [[f32x16<S>; 2]; 2]) -> f32x16<S> {
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let least = f32x16::splat(simd, LEAST_NORM as f32);
    let square = cos * cos + sin * sin;
    let mut greatest = f32x16::splat(simd, -1.0);
    for [c, s] in sides {
        let cross = cos * s - sin * c;
        let norm = square * (c * c + s * s);
        let told = norm.simd_gt(least) & (cos * c + sin * s).simd_gt(zero);
        let sine = (cross * cross) / told.select(norm, one);
        greatest = told.select(sine.max(greatest), greatest);
    }
    let too_many = f32x16::splat(simd, (TOO_MANY * TOO_MANY) as f32);
    greatest.simd_lt(zero).select(too_many, greatest * (PER_RADIAN * PER_RADIAN))
}

/// Returns 0 up to 0 and 1 from 1 on, with level ends.
#[inline(always)]
fn smooth<S: Simd>(t: f32x16<S>) -> f32x16<S> {
    let t = t.max(f32x16::splat(t.simd, 0.0)).min(f32x16::splat(t.simd, 1.0));
    (t * t) * (t * -2.0 + 3.0)
}

/// Values that lines at some positions share.
#[derive(Clone, Copy)]
struct LineValues<S: Simd> {
    height: f32x16<S>,
    shown: f32x16<S>,
    density: f32x16<S>,
}

/// Returns the parameters of lines, each as a vector.
#[inline(always)]
fn parameters<S: Simd>(simd: S, table: &Table, lines: [i32; LANES]) -> [f32x16<S>; 4] {
    let mut quarters = [[f32x4::splat(simd, 0.0); 4]; 4];
    for (quarter, lines) in quarters.iter_mut().zip(lines.as_chunks::<4>().0) {
        let mut four = [[0.0; 4]; 4];
        for (line, parameters) in lines.iter().zip(&mut four) {
            *parameters = table[*line as usize % COUNT];
        }
        *quarter = f32x4::load_four_interleaved(simd, four.as_flattened());
    }
    let [a, b, c, d] = quarters;
    let mut parameters = [f32x16::splat(simd, 0.0); 4];
    for (which, parameter) in parameters.iter_mut().enumerate() {
        *parameter = a[which].combine(b[which]).combine(c[which].combine(d[which]));
    }
    parameters
}

/// Returns the shares of pixels covered by lines whose middles are about `f` line distances away.
#[inline(always)]
fn covered<S: Simd>(table: &Table, lines: i32x16<S>, f: f32x16<S>, at: LineValues<S>) -> f32x16<S> {
    let [end, inverse, half, aside] = parameters(f.simd, table, lines.to_array());
    let (zero, one) = (f32x16::splat(f.simd, 0.0), f32x16::splat(f.simd, 1.0));
    let left = ((end - at.height) * inverse).max(zero).min(one);
    let half = half * left.sqrt() * at.shown;
    let away = f - aside;
    let half_pixel = at.density * 0.5;
    let (low, high) = ((away - half_pixel).max(-half), (away + half_pixel).min(half));
    ((high - low) / at.density).max(zero).min(one)
}
