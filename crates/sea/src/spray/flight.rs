//! Flight of a drop at any time, in closed form.

use crate::GRAVITY;

/// Returns (1 − e^−s)/s and (s − 1 + e^−s)/s² for s ≥ 0: 1 and ½ at 0.
///
/// Below 0.1 they use power series, since the differences cancel there; ten terms leave an error below 1e-16.
fn decays(s: f64) -> (f64, f64) {
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

#[cfg(test)]
mod tests {
    use super::{decays, fly};

    #[test]
    fn both_forms_of_the_decays_meet() {
        for s in [0.099_999_999, 0.1] {
            let (first, second) = (-libm::expm1(-s) / s, (s + libm::expm1(-s)) / (s * s));
            let found = decays(s);
            assert!((found.0 - first).abs() < 1e-15 && (found.1 - second).abs() < 1e-13, "{s}: {found:?}");
        }
        assert_eq!(decays(0.0), (1.0, 0.5));
    }

    #[test]
    fn flight_solves_its_equation() {
        // Compared with many small steps of the midpoint rule.
        for drag in [0.0, 0.3, 4.0] {
            let (start, push, wind) = ([1.0, 2.0, -3.0], [4.0, 9.0, -2.0], [8.0, 0.5, 1.0]);
            let (mut x, mut v) = (start, push);
            let steps = 20_000;
            let dt = 1.5 / f64::from(steps);
            let pull = |v: [f64; 3], axis: usize| drag * (wind[axis] - v[axis]) - [0.0, crate::GRAVITY, 0.0][axis];
            for _ in 0..steps {
                let middle: [f64; 3] = std::array::from_fn(|axis| v[axis] + pull(v, axis) * dt / 2.0);
                for axis in 0..3 {
                    x[axis] += middle[axis] * dt;
                    v[axis] += pull(middle, axis) * dt;
                }
            }
            let (place, speed) = fly(start, push, wind, drag, 1.5);
            for axis in 0..3 {
                assert!((place[axis] - x[axis]).abs() < 1e-6, "{drag}: {place:?}, expected {x:?}");
                assert!((speed[axis] - v[axis]).abs() < 1e-6, "{drag}: {speed:?}, expected {v:?}");
            }
        }
    }
}
