//! Exact steps of single modes over any amount of time, in f64.

use rayon::prelude::*;

use super::modes::Modes;
use super::splat::flushed;
use super::{Basin, LITERAL_HZ, Mixing, Motion, Physics};

/// Effect of an amount of time on the two numbers (a, b) of a mode under a constant force f:
/// a' = m₀a + m₁b + m₄f, b' = m₂a + m₃b + m₅f.
pub(crate) type Transfer = [f64; 6];

/// Returns the transfer of the mode with this 1 − λ over `seconds`, for a motion with modes.
///
/// The force is the height that a burst reaches; literal bursts are already scaled by 1 − c₁ − c₂.
pub(crate) fn transfer(motion: &Motion, spacing: f64, gap: f64, seconds: f64) -> Transfer {
    match motion {
        Motion::Literal(mixing) | Motion::Resampled { mixing, .. } => resampled(*mixing, gap, seconds * LITERAL_HZ),
        Motion::Physical { physics, .. } => physical(*physics, spacing, gap, seconds),
    }
}

/// Returns M^τ, M = [[1 − d, c₁], [−d, c₁]] with d = 1 − c₁ − c₂ + 2c₁(1 − λ), on (h, v), v the change of h in the last
/// step, and the sum of Mʲ(1, 1) over the τ steps.
///
/// With the roots g₁, g₂ of g² − b·g + c₁, b = 1 + c₁ − d, and Uₙ = (g₁ⁿ − g₂ⁿ)/(g₁ − g₂):
/// M^τ = ½(g₁^τ + g₂^τ)·1 + U_τ·(M − ½b·1).
pub(crate) fn resampled(mixing: Mixing, gap: f64, steps: f64) -> Transfer {
    let Mixing { c1, .. } = mixing;
    // d = (1 − g₁)(1 − g₂), without cancellation.
    let d = mixing.loss() + 2.0 * c1 * gap;
    let b = 1.0 + c1 - d;
    let discriminant = (1.0 - c1) * (1.0 - c1) - d * (2.0 * (1.0 + c1) - d);
    let half = (1.0 - d - c1) / 2.0;
    if discriminant < 0.0 {
        let angle = libm::atan2(libm::sqrt(-discriminant), b);
        let (turned, sine) = (steps * angle, libm::sin(angle));
        let ratio = if sine == 0.0 { steps } else { libm::sin(turned) / sine };
        // |g| = √c₁.
        let power = |exponent: f64| libm::exp(exponent / 2.0 * libm::log(c1));
        let now = power(steps - 1.0) * ratio;
        let mean = power(steps) * libm::cos(turned);
        let halved = libm::sin(turned / 2.0);
        let fallen = -libm::expm1(steps / 2.0 * libm::log(c1)) + 2.0 * power(steps) * halved * halved - half * now;
        return [mean + half * now, c1 * now, -d * now, mean - half * now, fallen / d, now];
    }
    let (large, small) = roots(b, c1, discriminant);
    // g₂/g₁ as an exponent: both roots are positive.
    let fall = libm::log(c1 / (large * large));
    let ratio = if fall == 0.0 { steps } else { libm::expm1(steps * fall) / libm::expm1(fall) };
    let now = libm::exp((steps - 1.0) * libm::log(large)) * ratio;
    let mean = libm::exp(steps * libm::log(large)) * (1.0 + libm::exp(steps * fall)) / 2.0;
    let raised = if d >= 1e-2 {
        (1.0 - (mean + half * now)) / d
    } else if discriminant > 0.01 * (1.0 - c1) * (1.0 - c1) {
        // Near g₁ = 1 the quotient by d cancels, so sum U_j root by root; 1 − g₁ = d/(1 − g₂).
        let lacking = d / (1.0 - small);
        (large * series(lacking, steps) - small * series(1.0 - small, steps)) / (large - small)
    } else {
        // Nearly equal roots.
        let (decay, apart) = (steps / 2.0 * libm::log(c1), libm::sinh(steps * fall / 4.0));
        (-libm::expm1(decay) - 2.0 * libm::exp(decay) * apart * apart - half * now) / d
    };
    [mean + half * now, c1 * now, -d * now, mean - half * now, raised, now]
}

/// Returns Σ gʲ over j = 0…count−1 with g = 1 − lacking, for any real count.
fn series(lacking: f64, count: f64) -> f64 {
    if lacking.abs() < 1e-300 { count } else { -libm::expm1(count * libm::log1p(-lacking)) / lacking }
}

/// Returns the roots of g² − b·g + c₁, the larger first, without cancellation.
fn roots(b: f64, c1: f64, discriminant: f64) -> (f64, f64) {
    let large = (b + libm::sqrt(discriminant)) / 2.0;
    (large, c1 / large)
}

/// Returns the exact solution of v' = −ω²h − 2γv + push·f, h' = v on (h, v), ω² = ω₀² + c²·4(1 − λ)/dx².
pub(crate) fn physical(physics: Physics, spacing: f64, gap: f64, dt: f64) -> Transfer {
    let Physics { speed, damping, frequency, push } = physics;
    let stiffness = speed / spacing;
    let square = frequency * frequency + 4.0 * stiffness * stiffness * gap;
    let push = push.unwrap_or(frequency * frequency);
    let detuning = square - damping * damping;
    // e^(−γdt)·cos(Ωdt) and e^(−γdt)·sin(Ωdt)/Ω.
    let (cosine, sine) = if detuning >= 0.0 {
        let omega = libm::sqrt(detuning);
        let fall = libm::exp(-damping * dt);
        let sine = if omega * dt < 1e-8 { dt } else { libm::sin(omega * dt) / omega };
        (fall * libm::cos(omega * dt), fall * sine)
    } else {
        // Overdamped: the exponents are combined, since e^(−γdt)·cosh(κdt) would be 0·∞. κ − γ = −ω²/(κ + γ).
        let kappa = libm::sqrt(-detuning);
        let slow = libm::exp(-square / (kappa + damping) * dt);
        let fast = libm::exp(-(kappa + damping) * dt);
        let sine = if kappa * dt < 1e-8 { slow * dt } else { -slow * libm::expm1(-2.0 * kappa * dt) / (2.0 * kappa) };
        ((slow + fast) / 2.0, sine)
    };
    let reached = cosine + damping * sine;
    [reached, sine, -square * sine, cosine - damping * sine, push * raised(square, damping, reached, dt), push * sine]
}

/// Sizes of the terms that a transfer is computed from, and the number of roundings of these sizes by which it may be
/// off.
pub(crate) struct Scales {
    pub(crate) factors: Transfer,
    pub(crate) roundings: f64,
}

/// Returns the scales of [`transfer`].
pub(crate) fn scales(motion: &Motion, spacing: f64, gap: f64, seconds: f64) -> Scales {
    let factors = transfer(motion, spacing, gap, seconds);
    match *motion {
        Motion::Literal(mixing) | Motion::Resampled { mixing, .. } => {
            let (c1, steps) = (mixing.c1, seconds * LITERAL_HZ);
            let d = mixing.loss() + 2.0 * c1 * gap;
            let discriminant = (1.0 - c1) * (1.0 - c1) - d * (2.0 * (1.0 + c1) - d);
            let apart = libm::sqrt(discriminant.abs());
            let large = if discriminant < 0.0 { libm::sqrt(c1) } else { (1.0 + c1 - d + apart) / 2.0 };
            let power = libm::exp(steps * libm::log(large));
            // U_τ is at most τ·|g|^(τ−1) and 2|g|^τ/|g₁ − g₂|.
            let now = power * (steps.max(1.0) / large).min(2.0 / apart);
            let beside = (1.0 - d - c1).abs() / 2.0 * now;
            let (own, turned) = (power + beside, steps * libm::sqrt(d.abs()));
            let raised = if d >= 1e-2 {
                (1.0 + own) / d
            } else if discriminant > 0.01 * (1.0 - c1) * (1.0 - c1) {
                2.0 * steps.max(1.0) / apart
            } else {
                ((1.0 - power).abs() + turned * turned + beside) / d
            };
            let roundings = 64.0 + 16.0 * steps * (std::f64::consts::PI - libm::log(c1));
            Scales { factors: [own, c1 * now, d.abs() * now, own, raised.max(factors[4].abs()), now], roundings }
        }
        Motion::Physical { physics, .. } => {
            let Physics { speed, damping, frequency, push } = physics;
            let stiffness = speed / spacing;
            let square = frequency * frequency + 4.0 * stiffness * stiffness * gap;
            let push = push.unwrap_or(frequency * frequency).abs();
            let sine = seconds.min(1.0 / libm::sqrt((square - damping * damping).abs()));
            let (own, turned) = (1.0 + damping * sine, libm::sqrt(square) * seconds);
            let raised = if turned * turned > 1e-8 { own / square } else { seconds * seconds };
            let factors = [own, sine, square * sine, own, push * raised, push * sine];
            Scales { factors, roundings: 64.0 + 16.0 * (turned + damping * seconds) }
        }
    }
}

/// Returns the effect of a unit acceleration on h over dt: (1 − reached)/ω², without cancellation.
fn raised(square: f64, damping: f64, reached: f64, dt: f64) -> f64 {
    let kappa = libm::sqrt((damping * damping - square).max(0.0));
    if kappa * dt > 0.1 {
        let sum = kappa + damping;
        let slow = if square > 0.0 { -libm::expm1(-square * dt / sum) / square } else { dt / sum };
        (sum * slow + libm::expm1(-sum * dt) / sum) / (2.0 * kappa)
    } else if square * dt * dt > 1e-8 {
        (1.0 - reached) / square
    } else {
        // A free body under drag; γdt is small here too.
        let fall = 2.0 * damping * dt;
        dt * dt * (0.5 - fall / 6.0 + fall * fall / 24.0)
    }
}

/// Transfers of all modes of a basin.
#[derive(Clone, Debug)]
pub(crate) struct Propagator {
    factors: [Vec<f32>; 6],
}

impl Propagator {
    pub(crate) fn new(motion: &Motion, basin: &Basin, modes: &Modes, seconds: f64) -> Self {
        let gap = modes.gap();
        let transfers: Vec<[f32; 6]> = (0..basin.cells())
            .into_par_iter()
            .with_min_len(1 << 10)
            .map(|mode| transfer(motion, basin.spacing, gap(mode), seconds).map(|factor| factor as f32))
            .collect();
        Self { factors: std::array::from_fn(|index| transfers.iter().map(|factors| factors[index]).collect()) }
    }

    pub(crate) fn bytes(&self) -> usize {
        self.factors.iter().map(|factors| factors.capacity() * size_of::<f32>()).sum()
    }

    /// Advances all modes, with or without a force.
    pub(crate) fn apply(&self, a: &mut [f32], b: &mut [f32], force: Option<&[f32]>) {
        const LENGTH: usize = 1 << 13;
        let chunks = a.par_chunks_mut(LENGTH).zip(b.par_chunks_mut(LENGTH));
        chunks.enumerate().for_each(|(chunk, (a, b))| {
            let range = chunk * LENGTH..chunk * LENGTH + a.len();
            let [m0, m1, m2, m3, m4, m5] = self.factors.each_ref().map(|factors| &factors[range.clone()]);
            for (i, (a, b)) in a.iter_mut().zip(&mut *b).enumerate() {
                (*a, *b) = (m0[i] * *a + m1[i] * *b, m2[i] * *a + m3[i] * *b);
            }
            if let Some(force) = force {
                for (i, (a, b)) in a.iter_mut().zip(&mut *b).enumerate() {
                    (*a, *b) = (*a + m4[i] * force[range.start + i], *b + m5[i] * force[range.start + i]);
                }
            }
            a.iter_mut().chain(b).for_each(|value| *value = flushed(*value));
        });
    }
}
