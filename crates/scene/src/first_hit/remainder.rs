//! How far a sea may lie from the polynomial through some of its points.

use super::footprints::{Footprints, Growth};
use super::sizes::{Sizes, WaveSizes};
use super::{bernstein, squares};
use fearless_simd::{Simd, dispatch, f64x8, prelude::*};
use std::ops::Range;
use trochoid_sea::FramedSea;
use trochoid_sea::kernel64::{LANES, exp};

/// Bounds of the distance between the sea and its polynomial within a cell. What the polynomial's coefficients lose to
/// rounding is added when they are known ([`Cell`](super::cells::Cell)).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Remainder {
    /// Of the points along u, up, and along v, in meters.
    pub(super) off: [f64; 3],
    /// Share of these that is due to rounding, and hardly smaller for smaller cells.
    pub(super) rounding: [f64; 3],
    /// Of the derivatives by either side of the cell, −1…1, in any direction.
    pub(super) turn: f64,
    /// Share of this that may be as large in the middle of the cell as at its ends: lost waves, and rounded coefficients.
    pub(super) even: f64,
    /// Number of waves, by falling wavelength, that the polynomial must contain.
    pub(super) waves: usize,
    /// Number of the first of these that count as long ([`LONG`]).
    pub(super) long: usize,
}

/// Sizes ρ of the ellipses around a cell within which waves are bounded.
const ELLIPSES: [f64; 15] = [1.3, 1.7, 2.2, 3.0, 4.0, 5.5, 7.5, 10.0, 14.0, 20.0, 30.0, 50.0, 90.0, 200.0, 1000.0];

/// Exponent below which nothing is left of a wave.
const LEAST: f64 = -745.0;

/// What an ellipse of size ρ makes of a function of size 1 within it; z = 1/(1 − 1/ρ), n nodes.
struct Ellipse {
    /// Largest distance from the middle, and from the real numbers, relative to half a side.
    reach: f64,
    aside: f64,
    /// m − 1 within it, infinite where it does not converge, and what of it exceeds the linear part.
    grown: f64,
    bent: f64,
    /// ln of 4z·ρ⁻ⁿ, and the factor for derivatives.
    value: f64,
    slope: f64,
}

/// Rounding error of a point in the axes of the cells and along a ray's directions, relative to its distance: each is a sum
/// of three rounded products, and the cell's base one more.
const PLACE: f64 = 8.0 * f64::EPSILON;

/// Chebyshev points along each side through which a polynomial is determined: their number, and their Lebesgue constant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Through {
    points: usize,
    lebesgue: f64,
    /// Exponent from which a wave counts as lost, and need not be in the polynomial.
    lost: f64,
    /// How long waves come to the points.
    long: Option<&'static Self>,
}

/// Those of a cell: e⁻¹⁴, a millionth, is left of a lost wave at most.
pub(super) const CELL: Through =
    Through { points: bernstein::SIDE, lebesgue: bernstein::LEBESGUE, lost: 14.0, long: None };
/// Those of a square of cells. What it lacks of a wave is enlarged once more in its cells, so that less may be left.
pub(super) const SQUARE: Through =
    Through { points: squares::POINTS, lebesgue: squares::LEBESGUE, lost: SQUARE_LOST, long: Some(&LONG) };
const SQUARE_LOST: f64 = 20.0;
/// Those of a square for long waves, which turn by [`LONG_TURN`] at most within half a side.
const LONG: Through =
    Through { points: squares::LONG_POINTS, lebesgue: squares::LONG_LEBESGUE, lost: SQUARE_LOST, long: None };
/// The polynomial of 16 points lacks 2e-12 of waves that turn by as many radians.
const LONG_TURN: f64 = 2.0;

impl Remainder {
    /// Returns the remainder of a cell whose points are known from a polynomial with a remainder of its own, or are off
    /// for other reasons: the cell's polynomial is off by the Lebesgue constant times as much for each side, and its
    /// derivatives by the square of its degree times that (Markov's inequality).
    pub(super) fn with(mut self, points: &Self) -> Self {
        let Through { points: count, lebesgue, .. } = CELL;
        let enlarged = lebesgue * lebesgue;
        for axis in 0..3 {
            self.off[axis] += enlarged * points.off[axis];
            self.rounding[axis] += enlarged * points.rounding[axis];
        }
        let degree = (count - 1) as f64;
        let [u, up, v] = points.off;
        self.turn += degree * degree * enlarged * libm::sqrt(u * u + up * up + v * v);
        self
    }

    /// Returns the bound of the derivatives by one side at a place along it, −1…1.
    ///
    /// All but the even share consists of Chebyshev polynomials, bounded by m² times their sizes, and of polynomials of
    /// degree n = 8, by n² times theirs. By Bernstein's inequality, m/√(1 − s²) and n/√(1 − s²) are enough.
    pub(super) fn turn_at(&self, place: f64) -> f64 {
        self.even + (self.turn - self.even) * (1.0 / (DEGREE * aside(place))).min(1.0)
    }

    /// Returns the same for the second derivatives, without lost waves.
    ///
    /// Those of Chebyshev polynomials are m⁴/3 at most, and as coefficients fall as ρ⁻ᵐ, ρ ≥ 1.3 and m ≥ 9, Σm⁴|cₘ|/3 is
    /// at most 108·Σm²|cₘ|. For polynomials of degree 8, Markov's inequality adds a factor of 21. Between the ends, the
    /// derivatives of q(θ) = p(cos θ), m·|p| and m²·|p| at most, bound p″ by (m² + m/√(1 − s²))·|p|/(1 − s²). Coefficients
    /// that are rounded by r change p″ by 56·r, of which the even share contains 8·r.
    pub(super) fn bend_at(&self, place: f64) -> f64 {
        const MOST: f64 = 110.0;
        let aside = aside(place);
        let inner = (1.0 + 1.0 / (DEGREE * aside)) / (aside * aside);
        7.0 * self.even + (self.turn - self.even) * inner.min(MOST)
    }

    /// Returns the largest share of some limits that it takes; infinite where a wave grows without limit.
    pub(super) fn relative_to(&self, limits: [f64; 3]) -> f64 {
        let shares = self.off.iter().zip(limits).map(|(off, limit)| off / limit);
        shares.fold(0.0, |most, share| if share.is_nan() { f64::INFINITY } else { most.max(share) })
    }
}

/// Degree of the cells' polynomials.
const DEGREE: f64 = bernstein::DEGREE as f64;

/// Returns √(1 − s²).
fn aside(place: f64) -> f64 {
    libm::sqrt((1.0 - place * place).max(0.0))
}

/// Bounds the remainder of the polynomial through Chebyshev points of the square of half side `half` around `middle`
/// ahead of the camera. The square must not contain a kink of the footprints.
///
/// A wave is the real part of A·e^(iθ), θ = k_u·u + k_v·v + φ, with A falling as e^(−b), b = k²f²/8. Interpolation at
/// the n Chebyshev points errs along one side by at most 2·Σ|cₘ|, m ≥ n, and its derivative by 2·Σm²|cₘ|, since aliases
/// have smaller m; |cₘ| ≤ 2Mρ⁻ᵐ if the function stays below M within the ellipse of size ρ (Trefethen, *Approximation
/// Theory and Approximation Practice*, theorems 8.1 and 8.2). In the ellipse, |s| ≤ r = (ρ + 1/ρ)/2, and the power
/// series of b is bounded by that of b·m (see [`Growth`](super::footprints::Growth)), so that with the linear terms taken together
///
/// ```text
/// M = A·e^(−b)·exp(|i·k_u − b·m₁|·r·H + b·(m(r·H) − 1 − m₁·r·H))
/// ```
///
/// or, since no point of the ellipse is farther than (ρ − 1/ρ)/2 from the real numbers, with k_u·(ρ − 1/ρ)/2·H +
/// b·(m(r·H) − 1) in the exponent, whichever is smaller.
///
/// Along both sides, f − I_u·I_v·f = (f − I_u·f) + I_u·(f − I_v·f), and I_u enlarges by the Lebesgue constant at most.
pub(super) fn remainder(
    sea: &WaveSizes,
    footprints: &Footprints,
    through: &Through,
    middle: f64,
    half: f64,
    away: f64,
) -> Remainder {
    let (square, growth) = (footprints.square(middle), footprints.growth(middle));
    let whole = growth.at(half) - 1.0;
    let count = sea.numbers.len();
    if !whole.is_finite() {
        let endless = [f64::INFINITY; 3];
        return Remainder {
            off: endless,
            rounding: endless,
            turn: f64::INFINITY,
            even: f64::INFINITY,
            waves: count,
            long: 0,
        };
    }
    let is_kept = |k: &f64| k * k * (square / 8.0) * (whole - 1.0) >= -through.lost;
    let waves = sea.numbers.partition_point(is_kept);
    // Whole vectors of long waves.
    let long = through.long.map_or(0, |_| sea.numbers.partition_point(|k| k * half <= LONG_TURN).min(waves));
    let long = long / LANES * LANES;
    let mut sums = Sums::default();
    for (part, through) in [(0..long, through.long), (long..count, Some(through))] {
        let Some(through) = through.filter(|_| !part.is_empty()) else { continue };
        let bound = Bound::new(through, growth, square, half, sea.rounding, away);
        dispatch!(sea.level, simd => simd.vectorize(
            #[inline(always)]
            || bound.add(simd, &sea.blocks, &part, waves, &mut sums)
        ));
    }
    let total = |lanes: [f64; LANES]| lanes.iter().sum::<f64>();
    let mut remainder =
        Remainder { off: [0.0; 3], rounding: [0.0; 3], turn: total(sums.turn), even: total(sums.even), waves, long };
    for axis in 0..3 {
        remainder.rounding[axis] = total(sums.rounding[axis]) + PLACE * away;
        remainder.off[axis] = total(sums.off[axis]) + remainder.rounding[axis];
    }
    remainder
}

/// Sums of bounds over waves, lane by lane.
#[derive(Default)]
struct Sums {
    off: [[f64; LANES]; 3],
    rounding: [[f64; LANES]; 3],
    turn: [f64; LANES],
    even: [f64; LANES],
}

/// What bounds a wave of size 1.
struct Of<S: Simd> {
    /// Of the values and of the derivatives.
    off: f64x8<S>,
    turn: f64x8<S>,
    /// Share of the latter that is due to the wave itself.
    even: f64x8<S>,
    /// Share that is left of it.
    left: f64x8<S>,
}

/// What the bounds of all waves have in common.
struct Bound {
    ellipses: [Ellipse; ELLIPSES.len()],
    /// f²/8.
    filter: f64,
    half: f64,
    /// m(H) − 1, and its linear part.
    whole: f64,
    linear: f64,
    lebesgue: f64,
    steep: f64,
    lost: f64,
    /// Rounding error of sums, relative to the sizes of the waves, and distance from the origin.
    rounding: f64,
    away: f64,
}

impl Bound {
    fn new(through: &Through, growth: Growth, square: f64, half: f64, rounding: f64, away: f64) -> Self {
        let Through { points, lebesgue, lost, .. } = *through;
        let count = points as f64;
        let linear = growth.linear() * half;
        let ellipses = ELLIPSES.map(|rho| {
            let z = 1.0 / (1.0 - 1.0 / rho);
            let value = libm::log(4.0 * z) - count * libm::log(rho);
            let slope = count * count * (1.0 + 2.0 * z / count + 2.0 * z * z / (count * count));
            let reach = (rho + 1.0 / rho) / 2.0;
            let grown = growth.at(reach * half) - 1.0;
            let bent = (grown - linear * reach).max(0.0);
            Ellipse { reach, aside: (rho - 1.0 / rho) / 2.0, grown: grown.max(0.0), bent, value, slope }
        });
        // Markov's inequality: a polynomial's derivative is at most the square of its degree times its size.
        let steep = lebesgue * (count - 1.0) * (count - 1.0);
        let whole = growth.at(half) - 1.0;
        Self { ellipses, filter: square / 8.0, half, whole, linear, lebesgue, steep, lost, rounding, away }
    }

    /// Adds the bounds of some waves, the first of a vector to begin with; the polynomials contain the first `waves`.
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, blocks: &[Sizes], part: &Range<usize>, waves: usize, sums: &mut Sums) {
        let mut total = [f64x8::splat(simd, 0.0); 8];
        let blocks = &blocks[part.start / LANES..part.end.div_ceil(LANES)];
        for (index, sizes) in blocks.iter().enumerate() {
            let start = part.start + LANES * index;
            let b = load(simd, &sizes.square) * self.filter;
            let most = b * (self.whole - 1.0);
            let numbers = [load(simd, &sizes.numbers[0]) * self.half, load(simd, &sizes.numbers[1]) * self.half];
            let of = if start + LANES <= waves {
                self.kept(simd, b, numbers)
            } else if start >= waves {
                // Shorter waves do not leave anything either.
                if self.whole <= 1.0 && sizes.square[0] * self.filter * (self.whole - 1.0) < LEAST {
                    break;
                }
                self.lost(simd, b, most, numbers)
            } else {
                let (kept, lost) = (self.kept(simd, b, numbers), self.lost(simd, b, most, numbers));
                let is_lost = simd.simd_lt_f64x8(most, f64x8::splat(simd, -self.lost));
                let pick = |lost: f64x8<S>, kept: f64x8<S>| simd.select_f64x8(is_lost, lost, kept);
                Of {
                    off: pick(lost.off, kept.off),
                    turn: pick(lost.turn, kept.turn),
                    even: pick(lost.even, kept.even),
                    left: pick(lost.left, kept.left),
                }
            };
            let [by_meter, at_origin] = [load(simd, &sizes.phase_errors[0]), load(simd, &sizes.phase_errors[1])];
            let enlarged = self.lebesgue * self.lebesgue;
            let rounding = of.left * (by_meter * self.away + at_origin + self.rounding) * enlarged;
            for axis in 0..3 {
                let amplitude = load(simd, &sizes.amplitudes[axis]);
                total[axis] += amplitude * of.off;
                total[3 + axis] += amplitude * rounding;
            }
            total[6] += load(simd, &sizes.size) * (of.turn + rounding * self.steep);
            total[7] += load(simd, &sizes.size) * of.even;
        }
        let places = sums.off.iter_mut().chain(&mut sums.rounding).chain([&mut sums.turn, &mut sums.even]);
        for (place, total) in places.zip(total) {
            *place = (load(simd, place) + total).to_array();
        }
    }

    /// Returns the bound for waves that the polynomial contains.
    #[inline(always)]
    fn kept<S: Simd>(&self, simd: S, b: f64x8<S>, [ku, kv]: [f64x8<S>; 2]) -> Of<S> {
        let splat = |value: f64| f64x8::splat(simd, value);
        let bent = b * self.linear;
        let x = (ku * ku + bent * bent).sqrt();
        // The least exponent of any ellipse, and the factor of the derivatives that belongs to it.
        let (mut u, mut u_slope) = (splat(f64::INFINITY), splat(0.0));
        let (mut v, mut v_slope) = (u, u_slope);
        for ellipse in &self.ellipses {
            let slope = splat(ellipse.slope);
            if ellipse.grown.is_finite() {
                let together = x * ellipse.reach + b * ellipse.bent;
                let exponent = together.min(ku * ellipse.aside + b * ellipse.grown) + ellipse.value;
                let is_less = simd.simd_lt_f64x8(exponent, u);
                (u, u_slope) = (simd.select_f64x8(is_less, exponent, u), simd.select_f64x8(is_less, slope, u_slope));
            }
            let exponent = kv * ellipse.aside + ellipse.value;
            let is_less = simd.simd_lt_f64x8(exponent, v);
            (v, v_slope) = (simd.select_f64x8(is_less, exponent, v), simd.select_f64x8(is_less, slope, v_slope));
        }
        let (big, share) = (exp(simd, b * self.whole), exp(simd, b * -1.0));
        let (u, v) = (exp(simd, u), exp(simd, v) * big);
        let turn = (u * u_slope + v * self.steep).max(v * v_slope + u * self.steep);
        Of {
            off: share * (u + v * self.lebesgue),
            turn: share * turn,
            even: splat(0.0),
            left: (share * big).min(splat(1.0)),
        }
    }

    /// Returns the bound for waves that the polynomial may contain or not: it bounds a wave, and what interpolation makes
    /// of it.
    #[inline(always)]
    fn lost<S: Simd>(&self, simd: S, b: f64x8<S>, most: f64x8<S>, [ku, kv]: [f64x8<S>; 2]) -> Of<S> {
        let left = exp(simd, most);
        let growth = b * (2.0 * self.linear * (1.0 + self.whole));
        let own = ku + kv + growth;
        Of {
            off: left * (1.0 + self.lebesgue * self.lebesgue),
            turn: left * (own + self.lebesgue * self.steep),
            even: left * own,
            left,
        }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &[f64; LANES]) -> f64x8<S> {
    f64x8::load_array_ref(simd, lanes)
}

/// Bounds how far displacements in the square of half side `half` around `middle` ahead of the camera may be from a sum in
/// its middle, along u, up, and along v, in meters.
pub(super) fn spread(sea: &FramedSea, footprints: &Footprints, middle: f64, half: f64, away: f64) -> [f64; 3] {
    let (square, whole) = (footprints.square(middle), footprints.growth(middle).at(half) - 1.0);
    let mut spread = [PLACE * away; 3];
    for wave in sea.waves() {
        let b = wave.number * wave.number * square / 8.0;
        let left = libm::exp((b * whole - b).min(0.0));
        if left == 0.0 && whole <= 1.0 {
            break;
        }
        let turned = ((wave.numbers[0].abs() + wave.numbers[1].abs()) * half + (2.0 * b * whole).min(1.0)).min(2.0);
        let rounding = sea.rounding() + wave.phase_error(away);
        for (spread, amplitude) in spread.iter_mut().zip(wave.amplitudes) {
            *spread += amplitude.abs() * left * (turned + rounding);
        }
    }
    spread
}
