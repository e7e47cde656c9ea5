//! Shapes of hulls, decided exactly: empty, a point, a segment, a polygon or a solid.

use trochoid_image::Rgb;

use super::solid::{Mesh, hull};
use super::vector::{Point, dot, length, side, sub, turn};

/// Exact hull of a set of distinct points, by indices into the set.
pub(super) enum Shape {
    Empty,
    Point,
    /// Two ends.
    Segment([u32; 2]),
    /// The corners in order; no three are collinear.
    Polygon(Vec<u32>),
    Solid(Mesh),
}

impl Shape {
    /// Analyzes points that [`sorted`] has sorted.
    pub(super) fn of(points: &[Point]) -> Self {
        let last = match points.len() {
            0 => return Self::Empty,
            1 => return Self::Point,
            count => count - 1,
        };
        let Some(third) = off_line(points, points[0], points[last]) else {
            // On a line the lexicographic order is the order along the line.
            return Self::Segment([0, last as u32]);
        };
        let base = [points[0], points[last], points[third]];
        match off_plane(points, base) {
            Some(fourth) => Self::Solid(hull(points, [0, last as u32, third as u32, fourth as u32])),
            None => Self::Polygon(polygon(points, base)),
        }
    }

    /// Returns the indices of the extreme points.
    pub(super) fn vertices(&self) -> Vec<u32> {
        match self {
            Self::Empty => Vec::new(),
            Self::Point => vec![0],
            Self::Segment(ends) => ends.to_vec(),
            Self::Polygon(corners) => corners.clone(),
            Self::Solid(mesh) => mesh.vertices.clone(),
        }
    }
}

/// Sorts points lexicographically, without duplicates and points that are not finite; −0 counts as 0.
pub(super) fn sorted(points: &mut Vec<Rgb>) {
    // Each key has the bits of three f32, changed so that they are in the order of the numbers: sorting integers is
    // several times faster than comparing colors.
    let key = |v: f32| {
        let bits = (v + 0.0).to_bits();
        if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
    };
    let value = |key: u32| f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key });
    let finite = points.iter().filter(|point| point.iter().all(|v| v.is_finite()));
    let mut keys: Vec<u128> =
        finite.map(|&[r, g, b]| u128::from(key(r)) << 64 | u128::from(key(g)) << 32 | u128::from(key(b))).collect();
    keys.sort_unstable();
    keys.dedup();
    points.clear();
    points.extend(keys.iter().map(|&k| [value((k >> 64) as u32), value((k >> 32) as u32), value(k as u32)]));
}

/// Returns a point that is not collinear with a and b, decided exactly: the farthest one up to rounding.
fn off_line(points: &[Point], a: Point, b: Point) -> Option<usize> {
    let apart = |p: Point| (0..3).any(|drop| turn(a, b, p, drop) != 0.0);
    let size = |p: Point| (0..3).map(|drop| turn(a, b, p, drop).abs()).fold(0.0, f64::max);
    farthest(points, size).filter(|&best| apart(points[best]))
}

/// Returns a point that is not coplanar with the base, decided exactly: the farthest one up to rounding.
fn off_plane(points: &[Point], [a, b, c]: [Point; 3]) -> Option<usize> {
    farthest(points, |p| side(a, b, c, p).abs()).filter(|&best| side(a, b, c, points[best]) != 0.0)
}

/// Returns the index of the largest value. The exact predicates return 0 only for an exact 0, so if the maximum is 0,
/// all are.
fn farthest(points: &[Point], value: impl Fn(Point) -> f64) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for (index, &point) in points.iter().enumerate() {
        let value = value(point);
        if best.is_none_or(|(_, largest)| value > largest) {
            best = Some((index, value));
        }
    }
    best.map(|(index, _)| index)
}

/// Returns the corners of exactly coplanar points, by Andrew's monotone chain in an exact projection.
///
/// The projection drops a coordinate. It is one-to-one on the plane if the area of the base does not become 0.
fn polygon(points: &[Point], [a, b, c]: [Point; 3]) -> Vec<u32> {
    let area = |drop: usize| turn(a, b, c, drop).abs();
    let drop = (1..3).fold(0, |best, drop| if area(drop) > area(best) { drop } else { best });
    convex_chain(points, drop)
}

/// Returns the corners of the hull of points without coordinate `drop`, counterclockwise.
pub(super) fn convex_chain(points: &[Point], drop: usize) -> Vec<u32> {
    let (u, v) = ((drop + 1) % 3, (drop + 2) % 3);
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_unstable_by(|&i, &j| {
        let (p, q) = (points[i as usize], points[j as usize]);
        p[u].total_cmp(&q[u]).then(p[v].total_cmp(&q[v]))
    });
    let mut chain = half_chain(points, drop, order.iter().copied());
    let mut upper = half_chain(points, drop, order.iter().rev().copied());
    // Each half ends with the first point of the other.
    chain.pop();
    upper.pop();
    chain.append(&mut upper);
    chain
}

fn half_chain(points: &[Point], drop: usize, order: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut chain: Vec<u32> = Vec::new();
    for index in order {
        while let [.., a, b] = chain[..] {
            if turn(points[a as usize], points[b as usize], points[index as usize], drop) > 0.0 {
                break;
            }
            chain.pop();
        }
        chain.push(index);
    }
    chain
}

/// Returns the point of segment ab nearest to p.
pub(super) fn nearest_on_segment(p: Point, a: Point, b: Point) -> Point {
    let along = sub(b, a);
    let square = dot(along, along);
    let t = if square > 0.0 { (dot(sub(p, a), along) / square).clamp(0.0, 1.0) } else { 0.0 };
    let nearest = super::vector::along(a, t, along);
    // b itself, if a + t·(b − a) is less exact because of rounding.
    if t == 1.0 || length(sub(p, b)) < length(sub(p, nearest)) { b } else { nearest }
}
