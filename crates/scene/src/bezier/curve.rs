//! Cubic Bézier curves.

use glam::DVec3;

/// Returns the point between two others; exactly `a` at 0.
#[inline]
pub(super) fn lerp(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a + (b - a) * t
}

/// Returns the point at `t`, by de Casteljau's algorithm.
#[inline]
pub(super) fn point([a, b, c, d]: [DVec3; 4], t: f64) -> DVec3 {
    let (p, q, r) = (lerp(a, b, t), lerp(b, c, t), lerp(c, d, t));
    lerp(lerp(p, q, t), lerp(q, r, t), t)
}

/// Returns the derivative at `t`: three times the last difference of de Casteljau's algorithm.
#[inline]
pub(super) fn tangent([a, b, c, d]: [DVec3; 4], t: f64) -> DVec3 {
    let (p, q, r) = (lerp(a, b, t), lerp(b, c, t), lerp(c, d, t));
    3.0 * (lerp(q, r, t) - lerp(p, q, t))
}

/// Returns the halves of a curve, each over [0, 1].
#[inline]
pub(super) fn halves([a, b, c, d]: [DVec3; 4]) -> [[DVec3; 4]; 2] {
    let middle = |a: DVec3, b: DVec3| (a + b) * 0.5;
    let (p, q, r) = (middle(a, b), middle(b, c), middle(c, d));
    let (s, t) = (middle(p, q), middle(q, r));
    let m = middle(s, t);
    [[a, p, s, m], [m, t, r, d]]
}

/// Returns the length of the control polygon.
pub(super) fn polygon(points: &[DVec3; 4]) -> f64 {
    points.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// Returns the largest second difference of the control points: a sixth of the largest second derivative.
pub(super) fn bend(points: &[DVec3; 4]) -> f64 {
    points.windows(3).map(|three| (three[0] - 2.0 * three[1] + three[2]).length()).fold(0.0, f64::max)
}
