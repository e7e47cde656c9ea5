//! How far a sea may lie from the polynomial through some of its points.

use super::footprints::Footprints;
use super::{bernstein, squares};
use trochoid_sea::FramedSea;

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
    /// Number of waves, by falling wavelength, that the polynomial must contain.
    pub(super) waves: usize,
}

/// Sizes ρ of the ellipses around a cell within which waves are bounded.
const ELLIPSES: [f64; 15] = [1.3, 1.7, 2.2, 3.0, 4.0, 5.5, 7.5, 10.0, 14.0, 20.0, 30.0, 50.0, 90.0, 200.0, 1000.0];
/// What an ellipse of size ρ makes of a function of size 1 within it; z = 1/(1 − 1/ρ), n nodes.
struct Ellipse {
    /// Largest distance from the middle, and from the real numbers, relative to half a side.
    reach: f64,
    aside: f64,
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
}

/// Those of a cell: e⁻¹⁴, a millionth, is left of a lost wave at most.
pub(super) const CELL: Through = Through { points: bernstein::SIDE, lebesgue: bernstein::LEBESGUE, lost: 14.0 };
/// Those of a square of cells. What it lacks of a wave is enlarged once more in its cells, so that less may be left.
pub(super) const SQUARE: Through = Through { points: squares::POINTS, lebesgue: squares::LEBESGUE, lost: 20.0 };

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

    /// Returns the largest share of some limits that it takes; infinite where a wave grows without limit.
    pub(super) fn relative_to(&self, limits: [f64; 3]) -> f64 {
        let shares = self.off.iter().zip(limits).map(|(off, limit)| off / limit);
        shares.fold(0.0, |most, share| if share.is_nan() { f64::INFINITY } else { most.max(share) })
    }
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
    sea: &FramedSea,
    footprints: &Footprints,
    through: Through,
    middle: f64,
    half: f64,
    away: f64,
) -> Remainder {
    let (square, growth) = (footprints.square(middle), footprints.growth(middle));
    let Through { points, lebesgue, lost } = through;
    let count = points as f64;
    let ellipses = ELLIPSES.map(|rho| {
        let z = 1.0 / (1.0 - 1.0 / rho);
        let value = libm::log(4.0 * z) - count * libm::log(rho);
        let slope = count * count * (1.0 + 2.0 * z / count + 2.0 * z * z / (count * count));
        Ellipse { reach: (rho + 1.0 / rho) / 2.0, aside: (rho - 1.0 / rho) / 2.0, value, slope }
    });
    let reaches = ellipses.each_ref().map(|ellipse| growth.at(ellipse.reach * half) - 1.0);
    let (linear, whole) = (growth.linear() * half, growth.at(half) - 1.0);
    // Markov's inequality: a polynomial's derivative is at most the square of its degree times its size.
    let steep = lebesgue * (count - 1.0) * (count - 1.0);
    let added = sea.rounding();
    let mut remainder = Remainder::default();
    // The best ellipse hardly changes from wave to wave.
    let mut best = [ELLIPSES.len() - 1; 2];
    for (index, wave) in sea.waves().iter().enumerate() {
        let b = wave.number * wave.number * square / 8.0;
        let most = b * whole - b;
        let [along, up, across] = wave.amplitudes.map(f64::abs);
        let size = libm::sqrt(along * along + up * up + across * across);
        let ku = wave.numbers[0].abs() * half;
        let kv = wave.numbers[1].abs() * half;
        let (off, turn, left) = if most < -lost {
            // The polynomial may contain the wave or not: this bounds it, and what interpolation makes of it.
            let left = libm::exp(most);
            let growth = 2.0 * b * linear * (1.0 + whole);
            (left * (1.0 + lebesgue * lebesgue), left * (lebesgue * steep + ku + kv + growth), left)
        } else {
            remainder.waves = index + 1;
            let x = libm::hypot(ku, b * linear);
            let along = |index: usize, ellipse: &Ellipse| {
                let together = x * ellipse.reach + b * (reaches[index] - linear * ellipse.reach).max(0.0);
                together.min(ku * ellipse.aside + b * reaches[index].max(0.0))
            };
            let [u, u_slope] = least(&ellipses, &mut best[0], along);
            let [v, v_slope] = least(&ellipses, &mut best[1], |_, ellipse| kv * ellipse.aside);
            let big = libm::exp(b * whole);
            let share = libm::exp(-b);
            let turn = (u_slope + steep * v * big).max(v_slope * big + steep * u);
            // A wave of size 0 that may grow without limit (0·∞) counts as whole.
            (share * (u + lebesgue * v * big), share * turn, (share * big).min(1.0))
        };
        // Shorter waves do not leave anything either.
        if left == 0.0 && whole <= 1.0 {
            break;
        }
        let rounding = left * (added + wave.phase_error(away)) * lebesgue * lebesgue;
        for (axis, amplitude) in [along, up, across].into_iter().enumerate() {
            remainder.off[axis] += amplitude * off;
            remainder.rounding[axis] += amplitude * rounding;
        }
        remainder.turn += size * (turn + rounding * steep);
    }
    for (off, rounding) in remainder.off.iter_mut().zip(&mut remainder.rounding) {
        *rounding += PLACE * away;
        *off += *rounding;
    }
    remainder
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

/// Returns the bound of the values by an ellipse, given the exponent of what the function grows to within it, and that of
/// the slopes. From the one that was best before, it looks for the best one: the exponent falls with ρ, and then rises.
fn least(ellipses: &[Ellipse], best: &mut usize, exponent: impl Fn(usize, &Ellipse) -> f64) -> [f64; 2] {
    let at = |index: usize| {
        let exponent = exponent(index, &ellipses[index]) + ellipses[index].value;
        if exponent.is_nan() { f64::INFINITY } else { exponent }
    };
    let (start, mut least) = (*best, at(*best));
    while *best > 0 && at(*best - 1) <= least {
        *best -= 1;
        least = at(*best);
    }
    while *best >= start && *best + 1 < ellipses.len() && at(*best + 1) < least {
        *best += 1;
        least = at(*best);
    }
    let value = libm::exp(least);
    [value, value * ellipses[*best].slope]
}
