use glam::DVec3;

use super::curve;

/// A bicubic patch of 4 × 4 control points, row by row, u fastest.
///
/// ```
/// use trochoid_scene::{DVec3, bezier::{Bicubic, Bilinear}};
///
/// let flat = Bilinear { points: [DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::X + DVec3::Z] }.elevate();
/// assert!((flat.evaluate(0.25, 0.5) - DVec3::new(0.25, 0.0, 0.5)).length() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bicubic {
    /// Control points.
    pub points: [DVec3; 16],
}

/// Bézier's basis in the powers 1, t, t², t³: row k holds the coefficients of tᵏ.
const BASIS: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [-3.0, 3.0, 0.0, 0.0], [3.0, -6.0, 3.0, 0.0], [-1.0, 3.0, -3.0, 1.0]];

impl Bicubic {
    /// Returns the control points of row `j`, a curve along u.
    pub fn row(&self, j: usize) -> [DVec3; 4] {
        std::array::from_fn(|i| self.points[4 * j + i])
    }

    /// Returns the control points of column `i`, a curve along v.
    pub fn column(&self, i: usize) -> [DVec3; 4] {
        std::array::from_fn(|j| self.points[4 * j + i])
    }

    /// Returns the point at (u, v), by de Casteljau's algorithm along u, then along v.
    pub fn evaluate(&self, u: f64, v: f64) -> DVec3 {
        curve::point(std::array::from_fn(|j| curve::point(self.row(j), u)), v)
    }

    /// Returns the same point, evaluated along v first.
    pub fn evaluate_v_first(&self, u: f64, v: f64) -> DVec3 {
        curve::point(std::array::from_fn(|i| curve::point(self.column(i), v)), u)
    }

    /// Returns the coefficients of uⁱvʲ at `[j][i]`: C = BᵀGB.
    pub fn powers(&self) -> [[DVec3; 4]; 4] {
        let half: [[DVec3; 4]; 4] = std::array::from_fn(|j| {
            std::array::from_fn(|i| (0..4).map(|k| BASIS[i][k] * self.points[4 * j + k]).sum())
        });
        std::array::from_fn(|j| std::array::from_fn(|i| (0..4).map(|k| BASIS[j][k] * half[k][i]).sum()))
    }

    /// Returns the same point as [`evaluate`](Self::evaluate), by the matrix form VᵀCU.
    pub fn evaluate_by_matrix(&self, u: f64, v: f64) -> DVec3 {
        let horner = |c: [DVec3; 4], t: f64| ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
        horner(self.powers().map(|row| horner(row, u)), v)
    }

    /// Returns ∂P/∂u and ∂P/∂v at (u, v).
    pub fn tangents(&self, u: f64, v: f64) -> [DVec3; 2] {
        let along_u = std::array::from_fn(|i| curve::point(self.column(i), v));
        let along_v = std::array::from_fn(|j| curve::point(self.row(j), u));
        [curve::tangent(along_u, u), curve::tangent(along_v, v)]
    }

    /// Returns the Taylor coefficients at (u, v): ∂ⁱ⁺ʲP/∂uⁱ∂vʲ / (i!·j!) at `[j][i]`.
    pub fn taylor(&self, u: f64, v: f64) -> [[DVec3; 4]; 4] {
        let rows: [[DVec3; 4]; 4] = std::array::from_fn(|j| taylor(self.row(j), u));
        let columns: [[DVec3; 4]; 4] = std::array::from_fn(|i| taylor(std::array::from_fn(|j| rows[j][i]), v));
        std::array::from_fn(|j| std::array::from_fn(|i| columns[i][j]))
    }

    /// Returns the four quarters: [low u, low v], [high u, low v], [low u, high v], [high u, high v].
    pub fn quarters(&self) -> [Self; 4] {
        let mut sides = [[DVec3::ZERO; 16]; 2];
        for j in 0..4 {
            let halves = curve::halves(self.row(j));
            for (side, half) in sides.iter_mut().zip(halves) {
                side[4 * j..4 * j + 4].copy_from_slice(&half);
            }
        }
        let mut quarters = [Self { points: [DVec3::ZERO; 16] }; 4];
        for (side, points) in sides.iter().enumerate() {
            for i in 0..4 {
                let [low, high] = curve::halves([points[i], points[4 + i], points[8 + i], points[12 + i]]);
                for (j, (low, high)) in low.into_iter().zip(high).enumerate() {
                    quarters[side].points[4 * j + i] = low;
                    quarters[2 + side].points[4 * j + i] = high;
                }
            }
        }
        quarters
    }

    /// Returns the curve along an edge: 0 at v = 0, 1 at u = 1, 2 at v = 1, 3 at u = 0. All edges run
    /// counterclockwise around the border, seen from the outer side.
    pub fn edge(&self, edge: usize) -> [DVec3; 4] {
        let reversed = |[a, b, c, d]: [DVec3; 4]| [d, c, b, a];
        match edge % 4 {
            0 => self.row(0),
            1 => self.column(3),
            2 => reversed(self.row(3)),
            _ => reversed(self.column(0)),
        }
    }

    /// Returns the patch with every control point mapped.
    pub fn map(&self, f: impl Fn(DVec3) -> DVec3) -> Self {
        Self { points: self.points.map(f) }
    }
}

/// Returns the Taylor coefficients of a curve at `t`: differences of de Casteljau's steps times 1, 3, 3, 1.
fn taylor([a, b, c, d]: [DVec3; 4], t: f64) -> [DVec3; 4] {
    let mix = |a: DVec3, b: DVec3| curve::lerp(a, b, t);
    let second = [a - 2.0 * b + c, b - 2.0 * c + d];
    [
        curve::point([a, b, c, d], t),
        curve::tangent([a, b, c, d], t),
        3.0 * mix(second[0], second[1]),
        d - a + 3.0 * (b - c),
    ]
}
