use glam::DVec3;

use super::Bicubic;
use super::curve::lerp;

/// A bilinear patch: p₀, p₁ along u at v = 0, then p₂, p₃ along u at v = 1.
///
/// ```
/// use trochoid_scene::{DVec3, bezier::Bilinear};
///
/// let saddle = Bilinear { points: [DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::new(1.0, 1.0, 1.0)] };
/// assert_eq!(saddle.evaluate(0.5, 0.5), DVec3::new(0.5, 0.25, 0.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bilinear {
    /// The four corners.
    pub points: [DVec3; 4],
}

impl Bilinear {
    /// Returns the point at (u, v), u first: Lerp(v, Lerp(u, p₀, p₁), Lerp(u, p₂, p₃)).
    pub fn evaluate(&self, u: f64, v: f64) -> DVec3 {
        let [a, b, c, d] = self.points;
        lerp(lerp(a, b, u), lerp(c, d, u), v)
    }

    /// Returns the same point, v first: Lerp(u, Lerp(v, p₀, p₂), Lerp(v, p₁, p₃)).
    pub fn evaluate_v_first(&self, u: f64, v: f64) -> DVec3 {
        let [a, b, c, d] = self.points;
        lerp(lerp(a, c, v), lerp(b, d, v), u)
    }

    /// Returns the same point as a sum of the corners: [1−u u] · [p₀ p₂; p₁ p₃] · [1−v v]ᵀ.
    pub fn evaluate_by_matrix(&self, u: f64, v: f64) -> DVec3 {
        let [a, b, c, d] = self.points;
        let [across, along] = [[1.0 - u, u], [1.0 - v, v]];
        let column = |p: DVec3, q: DVec3| p * along[0] + q * along[1];
        column(a, c) * across[0] + column(b, d) * across[1]
    }

    /// Returns ∂P/∂u and ∂P/∂v at (u, v).
    pub fn tangents(&self, u: f64, v: f64) -> [DVec3; 2] {
        let [a, b, c, d] = self.points;
        [lerp(b - a, d - c, v), lerp(c - a, d - b, u)]
    }

    /// Returns the same patch as a bicubic one: degree elevation, exact except for rounding.
    pub fn elevate(&self) -> Bicubic {
        let points = std::array::from_fn(|index| {
            let (i, j) = (index % 4, index / 4);
            match (i, j) {
                // Corners keep their bits, and edges depend only on their own ends, so neighbors keep a common edge.
                (0 | 3, 0 | 3) => self.points[i / 3 + 2 * (j / 3)],
                (_, 0 | 3) => third(self.points[2 * (j / 3)], self.points[2 * (j / 3) + 1], i),
                (0 | 3, _) => third(self.points[i / 3], self.points[i / 3 + 2], j),
                _ => self.evaluate(i as f64 / 3.0, j as f64 / 3.0),
            }
        });
        Bicubic { points }
    }
}

/// Returns the point at `i` thirds between two others, with the same bits in either order of the two.
fn third(a: DVec3, b: DVec3, i: usize) -> DVec3 {
    (a * (3 - i) as f64 + b * i as f64) / 3.0
}
