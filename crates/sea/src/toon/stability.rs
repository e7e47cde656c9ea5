//! Predicts a motion's behavior before anything is stepped: eigenvalues, growth, and the stable region.

use std::f64::consts::LN_2;

use super::{Basin, Instability, LITERAL_HZ, Mixing, Motion, Physics};

/// Theoretical behavior of a motion on a grid.
///
/// Each mode of the recurrence obeys g² − b·g + c₁ = 0 with b = 2c₁λ + c₂; each mode of the wave equation obeys s² +
/// 2γs + ω² = 0, g = eˢᵈᵗ. [`Probe`](super::Probe) measures the same without these formulas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// Least and greatest eigenvalue λ of the mean of four neighbors, exactly.
    pub eigenvalues: [f64; 2],
    /// Largest factor by which a mode grows in a step of the motion: the spectral radius. Below 1 everything decays.
    pub radius: f64,
    /// Whether every mode stays bounded.
    pub bounded: bool,
    /// Number of steps after which half of the slowest mode is left; infinite if it stays or grows.
    pub half_life: f64,
    /// c·dt/dx, the number of cells that waves cross per step; `None` if c₁ < 0, which gives no waves.
    pub stiffness: Option<f64>,
}

impl Forecast {
    /// Returns the forecast of a motion, stable or not.
    pub fn new(motion: &Motion, basin: &Basin) -> Self {
        let gaps = basin.gaps();
        let seconds = 1.0 / motion.rate();
        let ends = |radius: &dyn Fn(f64) -> f64| gaps.map(radius).into_iter().fold(0.0, f64::max);
        let (radius, bounded, stiffness) = match *motion {
            Motion::Literal(mixing) | Motion::Resampled { mixing, .. } => {
                let steps = seconds * LITERAL_HZ;
                let radius = ends(&|gap| radius([mixing.c1, mixing.c2], gap));
                let cells = (mixing.c1 >= 0.0).then(|| libm::sqrt(mixing.c1 / (1.0 + mixing.c1)) * steps);
                (libm::pow(radius, steps), Instability::check(mixing, basin).is_ok(), cells)
            }
            Motion::Physical { physics, .. } => {
                let Physics { speed, damping, frequency, .. } = physics;
                let radius = |gap: f64| {
                    let square = frequency * frequency + 4.0 * (speed / basin.spacing) * (speed / basin.spacing) * gap;
                    let detuning = damping * damping - square;
                    // −γ + √(γ² − ω²) without cancellation, where it is real.
                    let slow = if detuning > 0.0 { -square / (damping + libm::sqrt(detuning)) } else { -damping };
                    libm::exp(slow * seconds)
                };
                // A mode without any restoring force and without drag keeps moving as it was pushed.
                let free = gaps[0] * speed == 0.0 && frequency == 0.0 && damping == 0.0;
                (ends(&radius), !free, Some(speed * seconds / basin.spacing))
            }
        };
        let half_life = half_life(libm::log(radius));
        Self { eigenvalues: [1.0 - gaps[1], 1.0 - gaps[0]], radius, bounded, half_life, stiffness }
    }
}

/// Returns the number of steps after which half is left of what a step multiplies by e^`growth`.
pub(super) fn half_life(growth: f64) -> f64 {
    if growth < 0.0 { -LN_2 / growth } else { f64::INFINITY }
}

impl Mixing {
    /// Returns the corners of the stable region of the plane (c₁, c₂) on a grid, in order around it. Its sides belong
    /// to it except for c₁ = 1, where a mode may have a double root.
    pub fn stable_region(basin: &Basin) -> Vec<[f64; 2]> {
        let sides = sides(basin.gaps());
        let mut corners: Vec<[f64; 2]> = Vec::new();
        for (index, a) in sides.iter().enumerate() {
            for b in &sides[index + 1..] {
                let Some(corner) = a.meets(b) else { continue };
                let known = corners.iter().any(|known| libm::hypot(known[0] - corner[0], known[1] - corner[1]) < 1e-9);
                if !known && sides.iter().all(|side| side.inside(corner) >= -1e-12) {
                    corners.push(corner);
                }
            }
        }
        // (0, 0) is inside for every grid.
        corners.sort_by(|a, b| libm::atan2(a[1], a[0]).total_cmp(&libm::atan2(b[1], b[0])));
        corners
    }

    /// Returns the distance to the nearest side of the stable region in the plane (c₁, c₂): the allowed change in the
    /// worst direction; negative outside.
    pub fn margin(self, basin: &Basin) -> f64 {
        let distance = |side: &HalfPlane| side.inside([self.c1, self.c2]) / libm::hypot(side.normal[0], side.normal[1]);
        sides(basin.gaps()).iter().map(distance).fold(f64::INFINITY, f64::min)
    }

    /// Returns how far each coefficient of a stable mixing may change while the other stays: [c₁ from, to], [c₂ from,
    /// to].
    pub fn limits(self, basin: &Basin) -> [[f64; 2]; 2] {
        let found = [self.c1, self.c2];
        std::array::from_fn(|axis| {
            let mut limits = [f64::NEG_INFINITY, f64::INFINITY];
            for side in sides(basin.gaps()) {
                let slope = side.normal[axis];
                let limit = found[axis] + side.inside(found) / slope;
                if slope < 0.0 {
                    limits[0] = f64::max(limits[0], limit);
                } else if slope > 0.0 {
                    limits[1] = f64::min(limits[1], limit);
                }
            }
            limits
        })
    }

    /// Returns the wave equation whose step of 1/60 s is this mixing in the continuum: γ·dt = (1−c₁)/(1+c₁),
    /// c·dt/dx = √(c₁/(1+c₁)), (ω₀·dt)² = 2(1−c₁−c₂)/(1+c₁). c₁ is clamped to [0, 1], since c₁ < 0 gives no waves.
    pub fn continuum(self, spacing: f64) -> Physics {
        let c1 = self.c1.clamp(0.0, 1.0);
        let over = 1.0 + c1;
        Physics {
            speed: LITERAL_HZ * spacing * libm::sqrt(c1 / over),
            damping: LITERAL_HZ * (1.0 - c1) / over,
            frequency: LITERAL_HZ * libm::sqrt(2.0 * (1.0 - c1 - self.c2).max(0.0) / over),
            push: None,
        }
    }
}

/// Rounding of 1 − c₁ − c₂ if the decimals sum to 1: a mode this far beyond grows by 1e-15 per step.
const SLACK: f64 = 1e-15;
/// Distance of the proposal from the edge of the stable region, so that rounding to four decimals keeps it inside.
const INSIDE: f64 = 1e-4;

impl Instability {
    /// Checks that every mode of the basin stays bounded: each obeys g² − b·g + c₁ = 0, b = 2c₁λ + c₂, so that
    /// |c₁| ≤ 1 and |b| ≤ 1 + c₁ must hold for each λ, without a double root on |g| = 1 (Jury's criterion). b is
    /// linear in λ, so the two ends of the spectrum decide.
    ///
    /// # Errors
    /// The instability, with the nearest stable coefficients.
    pub fn check(mixing: Mixing, basin: &Basin) -> Result<(), Self> {
        let gaps = basin.gaps();
        let found = [mixing.c1, mixing.c2];
        let double = mixing.c1 == 1.0 && planes(gaps).iter().any(|plane| plane.inside(found).abs() <= SLACK);
        let finite = mixing.c1.is_finite() && mixing.c2.is_finite();
        if finite && !double && stable(found, gaps, -SLACK) {
            return Ok(());
        }
        let growth = gaps.map(|gap| radius(found, gap)).into_iter().fold(0.0, f64::max);
        Err(Self { found, growth, nearest: nearest(found, gaps) })
    }
}

/// A half plane of the coefficients: `normal`·(c₁, c₂) ≤ `limit` holds inside.
struct HalfPlane {
    normal: [f64; 2],
    limit: f64,
}

impl HalfPlane {
    /// Returns where two lines cross, unless they are parallel.
    fn meets(&self, other: &Self) -> Option<[f64; 2]> {
        let (a, b) = (self, other);
        let determinant = a.normal[0] * b.normal[1] - a.normal[1] * b.normal[0];
        (determinant.abs() > 1e-12).then(|| {
            [
                (a.limit * b.normal[1] - b.limit * a.normal[1]) / determinant,
                (a.normal[0] * b.limit - b.normal[0] * a.limit) / determinant,
            ]
        })
    }

    fn inside(&self, [c1, c2]: [f64; 2]) -> f64 {
        self.limit - self.normal[0] * c1 - self.normal[1] * c2
    }
}

/// Returns b ≤ 1 + c₁ and −b ≤ 1 + c₁ at both ends of the spectrum.
fn planes(gaps: [f64; 2]) -> [HalfPlane; 4] {
    let upper = |gap: f64| HalfPlane { normal: [1.0 - 2.0 * gap, 1.0], limit: 1.0 };
    let lower = |gap: f64| HalfPlane { normal: [2.0 * gap - 3.0, -1.0], limit: 1.0 };
    [upper(gaps[0]), upper(gaps[1]), lower(gaps[0]), lower(gaps[1])]
}

/// Returns all sides of the stable region: these, and |c₁| ≤ 1.
fn sides(gaps: [f64; 2]) -> Vec<HalfPlane> {
    let mut sides: Vec<HalfPlane> = planes(gaps).into();
    sides.extend([1.0, -1.0].map(|sign| HalfPlane { normal: [sign, 0.0], limit: 1.0 }));
    sides
}

fn stable(found: [f64; 2], gaps: [f64; 2], margin: f64) -> bool {
    found[0].abs() <= 1.0 - margin.max(0.0) && planes(gaps).iter().all(|plane| plane.inside(found) >= margin)
}

/// Returns the largest |g| of the mode with this 1 − λ.
fn radius([c1, c2]: [f64; 2], gap: f64) -> f64 {
    let half = c1 * (1.0 - gap) + c2 / 2.0;
    let discriminant = half * half - c1;
    if discriminant < 0.0 { libm::sqrt(c1) } else { half.abs() + libm::sqrt(discriminant) }
}

/// Returns the nearest point of the stable region, which is convex: on one of its sides, or in one of its corners.
fn nearest(found: [f64; 2], gaps: [f64; 2]) -> [f64; 2] {
    let found = found.map(|value| if value.is_finite() { value } else { 0.0 });
    let mut sides = sides(gaps);
    for side in &mut sides {
        side.limit -= 4.0 * INSIDE;
    }
    let mut candidates = Vec::new();
    for (index, a) in sides.iter().enumerate() {
        let square = a.normal[0] * a.normal[0] + a.normal[1] * a.normal[1];
        let step = a.inside(found) / square;
        candidates.push([found[0] + step * a.normal[0], found[1] + step * a.normal[1]]);
        candidates.extend(sides[index + 1..].iter().filter_map(|b| a.meets(b)));
    }
    let distance = |point: &[f64; 2]| libm::hypot(point[0] - found[0], point[1] - found[1]);
    let best = candidates
        .into_iter()
        .filter(|&point| stable(point, gaps, 3.0 * INSIDE))
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    // The region contains (0, 0) for every basin.
    best.unwrap_or([0.0; 2]).map(|value| (value * 1e4).round() / 1e4)
}
