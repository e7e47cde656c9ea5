//! Flight of a drop at any time, in closed form.

use crate::GRAVITY;

/// Returns (1 − e^−s)/s and (s − 1 + e^−s)/s² for s ≥ 0: 1 and ½ at 0.
///
/// Below 0.1 they use power series, since the differences cancel there; ten terms leave an error below 1e-16.
pub(crate) fn decays(s: f64) -> (f64, f64) {
    if s < 0.1 {
        let (mut first, mut second, mut term) = (0.0, 0.0, 1.0);
        for n in 1..=10 {
            // (−s)ⁿ⁻¹/n!
            term /= f64::from(n);
            first += term;
            second += term / f64::from(n + 1);
            term *= -s;
        }
        (first, second)
    } else {
        let first = -libm::expm1(-s) / s;
        (first, (1.0 - first) / s)
    }
}

/// Returns position and velocity after `time` seconds of flight under gravity, in a wind w with drag k in 1/s:
/// v' = −g·ŷ + k(w − v).
///
/// x = x₀ + v₀·t·φ₁ + (k·w − g·ŷ)·t²·φ₂ and v = v₀ + (k(w − v₀) − g·ŷ)·t·φ₁, with φ₁ and φ₂ of k·t.
pub(crate) fn fly(
    position: [f64; 3],
    velocity: [f64; 3],
    wind: [f64; 3],
    drag: f64,
    time: f64,
) -> ([f64; 3], [f64; 3]) {
    let (first, second) = decays(drag * time);
    let gravity = [0.0, GRAVITY, 0.0];
    let place = |axis: usize| {
        let push = drag * wind[axis] - gravity[axis];
        position[axis] + velocity[axis] * time * first + push * time * time * second
    };
    let speed = |axis: usize| {
        let push = drag * (wind[axis] - velocity[axis]) - gravity[axis];
        velocity[axis] + push * time * first
    };
    (std::array::from_fn(place), std::array::from_fn(speed))
}
