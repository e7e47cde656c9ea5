//! Surfaces through given points: Catmull–Rom splines as exact bicubic patches.

use glam::DVec3;

use super::{Bicubic, Patch};

/// Most points of one set of rails.
pub const MAX_RAIL_POINTS: usize = 1 << 16;

/// Rows of points that a surface passes through: u runs along a rail, v from rail to rail.
///
/// Tangents follow Catmull and Rom: half the step between a point's neighbors. At open ends they are those of the
/// parabola through the last three points, so that quadratic shapes are reproduced exactly. Neighboring patches join
/// C1. After Catmull and Rom, *A Class of Local Interpolating Splines*, 1974.
#[derive(Clone, Debug, PartialEq)]
pub struct Rails {
    /// Rails of equal length: at least two, with at least two points each.
    pub rails: Vec<Vec<DVec3>>,
    /// Whether the last point of each rail is followed by the first.
    pub closed_u: bool,
    /// Whether the last rail is followed by the first.
    pub closed_v: bool,
}

/// Why rails do not form a surface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RailsError {
    /// There are fewer than two rails; holds their number.
    Rails(usize),
    /// Rail `rail` has `found` points; all need as many as the first, and at least two.
    Points {
        /// Index of the rail.
        rail: usize,
        /// Number of its points.
        found: usize,
        /// Number of points expected.
        expected: usize,
    },
    /// There are more points in all than [`MAX_RAIL_POINTS`]; holds their number.
    TooMany(usize),
}

impl std::fmt::Display for RailsError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Rails(found) => write!(f, "{found} rails; a surface needs at least 2"),
            Self::Points { rail, found, expected } => {
                write!(f, "rail {rail} has {found} points; every rail needs {expected}")
            }
            Self::TooMany(found) => write!(f, "{found} points; at most {MAX_RAIL_POINTS} are allowed"),
        }
    }
}

impl std::error::Error for RailsError {}

impl Rails {
    /// Returns the patches, rail by rail; their texture coordinates run over the whole surface.
    ///
    /// # Errors
    /// Rails of unequal length, fewer than two of anything, or too many points.
    pub fn patches(&self) -> Result<Vec<Patch>, RailsError> {
        if self.rails.len() < 2 {
            return Err(RailsError::Rails(self.rails.len()));
        }
        let expected = self.rails[0].len().max(2);
        if let Some(rail) = self.rails.iter().position(|rail| rail.len() != expected) {
            return Err(RailsError::Points { rail, found: self.rails[rail].len(), expected });
        }
        let total = expected.saturating_mul(self.rails.len());
        if total > MAX_RAIL_POINTS {
            return Err(RailsError::TooMany(total));
        }
        // First the curves along each rail, then curves through their control points across the rails.
        let along: Vec<Vec<[DVec3; 4]>> = self.rails.iter().map(|rail| segments(rail, self.closed_u)).collect();
        let (columns, rows) = (along[0].len(), self.rails.len() - usize::from(!self.closed_v));
        let mut patches = vec![Patch::new(Bicubic { points: [DVec3::ZERO; 16] }); columns * rows];
        for column in 0..columns {
            for i in 0..4 {
                let across: Vec<DVec3> = along.iter().map(|rail| rail[column][i]).collect();
                for (row, curve) in segments(&across, self.closed_v).into_iter().enumerate() {
                    let patch = &mut patches[row * columns + column];
                    (0..4).for_each(|j| patch.shape.points[4 * j + i] = curve[j]);
                    let part = |index: usize, count: usize| index as f64 / count as f64;
                    patch.uv =
                        [[part(column, columns), part(row, rows)], [part(column + 1, columns), part(row + 1, rows)]];
                }
            }
        }
        Ok(patches)
    }
}

/// Returns the cubic pieces of the spline through two or more points.
fn segments(points: &[DVec3], closed: bool) -> Vec<[DVec3; 4]> {
    let n = points.len();
    let tangent = |i: usize| {
        if closed {
            return (points[(i + 1) % n] - points[(i + n - 1) % n]) * 0.5;
        }
        match (i, n) {
            (_, 2) => points[1] - points[0],
            (0, _) => end(points[0], points[1], points[2]),
            (last, _) if last + 1 == n => -end(points[n - 1], points[n - 2], points[n - 3]),
            _ => (points[i + 1] - points[i - 1]) * 0.5,
        }
    };
    (0..n - usize::from(!closed))
        .map(|i| {
            let next = (i + 1) % n;
            [points[i], points[i] + tangent(i) / 3.0, points[next] - tangent(next) / 3.0, points[next]]
        })
        .collect()
}

/// Returns the derivative at the first of three points of the parabola through them.
fn end(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    (4.0 * b - 3.0 * a - c) * 0.5
}
