//! Normals, also where tangents vanish.

use glam::DVec3;

use super::{Bicubic, curve};

/// A normal, and how it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnitNormal {
    /// ∂P/∂u × ∂P/∂v, normalized.
    Regular(DVec3),
    /// Tangents vanish or are parallel: the limit of the normal along a path into the patch.
    Limit(DVec3),
    /// There is no normal, as in a patch without area: (0, 1, 0).
    None,
}

impl UnitNormal {
    /// Returns the unit vector.
    pub fn vector(self) -> DVec3 {
        match self {
            Self::Regular(normal) | Self::Limit(normal) => normal,
            Self::None => DVec3::Y,
        }
    }
}

/// Least sine of the angle between tangents, and least tangent relative to the patch's size, that count as regular.
const DEGENERATE: f64 = 1e-9;
/// An edge whose control polygon is shorter than this share of the patch's extent counts as a point for normals.
///
/// The lid of the published teapot ends in loops 0.002 wide; seen closely, its normals turn over there.
pub(super) const POINT_EDGE: f64 = 0.01;

impl Bicubic {
    /// Returns the largest extent of the control points along an axis.
    pub fn extent(&self) -> f64 {
        let (low, high) = self.bounds();
        (high - low).max_element()
    }

    /// Returns the least and greatest coordinates of the control points, which contain the whole patch.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let fold = |f: fn(DVec3, DVec3) -> DVec3| self.points[1..].iter().fold(self.points[0], |a, b| f(a, *b));
        (fold(DVec3::min), fold(DVec3::max))
    }

    /// Returns the patch from which normals are computed: very short edges are collapsed to points.
    pub fn for_normals(&self) -> Self {
        let extent = self.extent();
        let mut points = self.points;
        for edge in [[0, 1, 2, 3], [3, 7, 11, 15], [12, 13, 14, 15], [0, 4, 8, 12]] {
            let curve = edge.map(|index| self.points[index]);
            if curve::polygon(&curve) < POINT_EDGE * extent {
                let middle = (curve[0] + curve[3]) * 0.5;
                edge.into_iter().for_each(|index| points[index] = middle);
            }
        }
        Self { points }
    }

    /// Returns the unit normal at (u, v).
    ///
    /// Where ∂P/∂u × ∂P/∂v vanishes, it is the limit along a path into the patch, found from higher derivatives:
    /// across an edge that is a single point, else toward the middle of the patch.
    pub fn normal(&self, u: f64, v: f64) -> UnitNormal {
        let size = self.extent();
        let [along_u, along_v] = self.tangents(u, v);
        let cross = along_u.cross(along_v);
        let (length_u, length_v) = (along_u.length(), along_v.length());
        if length_u > DEGENERATE * size
            && length_v > DEGENERATE * size
            && cross.length() > DEGENERATE * length_u * length_v
        {
            return cross.try_normalize().map_or(UnitNormal::None, UnitNormal::Regular);
        }
        let inward = |t: f64| if t > 0.5 { -1.0 } else { 1.0 };
        let middle = [0.5 - u, 0.5 - v];
        let center = if middle == [0.0; 2] { [1.0, 0.5] } else { middle };
        let across = if length_u <= DEGENERATE * size && length_v > DEGENERATE * size {
            [0.0, inward(v)]
        } else if length_v <= DEGENERATE * size && length_u > DEGENERATE * size {
            [inward(u), 0.0]
        } else {
            center
        };
        let limit = self.limit(u, v, across, size).or_else(|| self.limit(u, v, center, size));
        limit.map_or(UnitNormal::None, UnitNormal::Limit)
    }

    /// Returns the limit of the unit normal at (u, v) coming from (u, v) + s·`path`, s > 0.
    ///
    /// Along the path both tangents are polynomials of s, and so is their cross product: its first nonzero
    /// coefficient gives the limit.
    fn limit(&self, u: f64, v: f64, path: [f64; 2], size: f64) -> Option<DVec3> {
        let taylor = self.taylor(u, v);
        let (mut along_u, mut along_v) = ([DVec3::ZERO; 6], [DVec3::ZERO; 6]);
        for (j, row) in taylor.iter().enumerate() {
            for (i, coefficient) in row.iter().enumerate() {
                let power = |base: f64, exponent: usize| (0..exponent).fold(1.0, |product, _| product * base);
                if i > 0 {
                    along_u[i - 1 + j] += i as f64 * power(path[0], i - 1) * power(path[1], j) * *coefficient;
                }
                if j > 0 {
                    along_v[i + j - 1] += j as f64 * power(path[0], i) * power(path[1], j - 1) * *coefficient;
                }
            }
        }
        (0..=10).find_map(|order: usize| {
            let first = order.saturating_sub(5);
            let sum: DVec3 = (first..=order.min(5)).map(|i| along_u[i].cross(along_v[order - i])).sum();
            if sum.length() > DEGENERATE * size * size { sum.try_normalize() } else { None }
        })
    }
}
