use super::{Basin, Mixing};

/// A recurrence that grows without bound, and the nearest one that does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instability {
    /// The coefficients c₁, c₂.
    pub found: [f64; 2],
    /// By how much the fastest mode grows in a step.
    pub growth: f64,
    /// The stable coefficients closest to them, to four decimals.
    pub nearest: [f64; 2],
}

/// Rounding of 1 − c₁ − c₂ where the decimals sum to 1: a mode this far beyond grows by 1e-15 a step.
const SLACK: f64 = 1e-15;
/// How far inside the stable region the proposal lies, so that four decimals keep it there.
const INSIDE: f64 = 1e-4;

impl Instability {
    /// Whether every mode of the basin stays bounded: each obeys g² − b·g + c₁ = 0, b = 2c₁λ + c₂, so that
    /// |c₁| ≤ 1 and |b| ≤ 1 + c₁ for its every λ, without a double root on |g| = 1 (Jury's criterion). b is linear in
    /// λ: the two ends decide.
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

impl std::fmt::Display for Instability {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([c1, c2], [near1, near2]) = (self.found, self.nearest);
        write!(
            f,
            "c1 {c1}, c2 {c2}, with which the sea grows by {:.4} a step; expected |c1| ≤ 1 and |2·c1·λ + c2| ≤ 1 + c1 \
             for each mode λ of the grid; the nearest that holds: c1 {near1:.4}, c2 {near2:.4}",
            self.growth
        )
    }
}

/// A line in the plane of the coefficients: `normal`·(c₁, c₂) ≤ `limit` holds inside.
struct HalfPlane {
    normal: [f64; 2],
    limit: f64,
}

impl HalfPlane {
    fn inside(&self, [c1, c2]: [f64; 2]) -> f64 {
        self.limit - self.normal[0] * c1 - self.normal[1] * c2
    }
}

/// b ≤ 1 + c₁ and −b ≤ 1 + c₁ at both ends of the spectrum.
fn planes(gaps: [f64; 2]) -> [HalfPlane; 4] {
    let upper = |gap: f64| HalfPlane { normal: [1.0 - 2.0 * gap, 1.0], limit: 1.0 };
    let lower = |gap: f64| HalfPlane { normal: [2.0 * gap - 3.0, -1.0], limit: 1.0 };
    [upper(gaps[0]), upper(gaps[1]), lower(gaps[0]), lower(gaps[1])]
}

fn stable(found: [f64; 2], gaps: [f64; 2], margin: f64) -> bool {
    found[0].abs() <= 1.0 - margin.max(0.0) && planes(gaps).iter().all(|plane| plane.inside(found) >= margin)
}

/// Greatest |g| of the mode with this 1 − λ.
fn radius([c1, c2]: [f64; 2], gap: f64) -> f64 {
    let half = c1 * (1.0 - gap) + c2 / 2.0;
    let discriminant = half * half - c1;
    if discriminant < 0.0 { libm::sqrt(c1) } else { half.abs() + libm::sqrt(discriminant) }
}

/// The nearest point of the stable region, which is convex: on one of its sides, or in one of its corners.
fn nearest(found: [f64; 2], gaps: [f64; 2]) -> [f64; 2] {
    let found = found.map(|value| if value.is_finite() { value } else { 0.0 });
    let mut sides: Vec<HalfPlane> = planes(gaps).into();
    sides.push(HalfPlane { normal: [1.0, 0.0], limit: 1.0 });
    sides.push(HalfPlane { normal: [-1.0, 0.0], limit: 1.0 });
    for side in &mut sides {
        side.limit -= 4.0 * INSIDE;
    }
    let mut candidates = Vec::new();
    for (index, a) in sides.iter().enumerate() {
        let square = a.normal[0] * a.normal[0] + a.normal[1] * a.normal[1];
        let step = a.inside(found) / square;
        candidates.push([found[0] + step * a.normal[0], found[1] + step * a.normal[1]]);
        for b in &sides[index + 1..] {
            let determinant = a.normal[0] * b.normal[1] - a.normal[1] * b.normal[0];
            if determinant.abs() > 1e-12 {
                candidates.push([
                    (a.limit * b.normal[1] - b.limit * a.normal[1]) / determinant,
                    (a.normal[0] * b.limit - b.normal[0] * a.limit) / determinant,
                ]);
            }
        }
    }
    let distance = |point: &[f64; 2]| libm::hypot(point[0] - found[0], point[1] - found[1]);
    let best = candidates
        .into_iter()
        .filter(|&point| stable(point, gaps, 3.0 * INSIDE))
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    // The region holds (0, 0) whatever the basin.
    best.unwrap_or([0.0; 2]).map(|value| (value * 1e4).round() / 1e4)
}
