//! Three-component f64 vectors and exact orientation tests.

use robust::{Coord, Coord3D, orient2d, orient3d};

pub(super) type Point = [f64; 3];

pub(super) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + s·b.
pub(super) fn along(a: Point, s: f64, b: Point) -> Point {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// The dot product, in one fixed order of operations: offsets and tests of planes must round alike.
#[inline(always)]
pub(super) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// a scaled to length 1; the zero vector stays.
pub(super) fn unit(a: Point) -> Point {
    let length = length(a);
    if length > 0.0 { a.map(|v| v / length) } else { a }
}

/// The cross product with each component good to about 1.5 ulp, so that slivers still get their normal.
///
/// Kahan's difference of products: the rounding error of one product is recovered by a fused multiply–add.
pub(super) fn cross(a: Point, b: Point) -> Point {
    let difference = |a: f64, b: f64, c: f64, d: f64| {
        let cd = c * d;
        let error = (-c).mul_add(d, cd);
        a.mul_add(b, -cd) + error
    };
    [difference(a[1], b[2], a[2], b[1]), difference(a[2], b[0], a[0], b[2]), difference(a[0], b[1], a[1], b[0])]
}

/// Twice the area vector of triangle abc; points to where abc appears counterclockwise.
pub(super) fn area_vector(a: Point, b: Point, c: Point) -> Point {
    cross(sub(b, a), sub(c, a))
}

/// Which side of the plane abc holds p: positive where abc appears counterclockwise, 0 exactly on the plane.
///
/// The sign is exact for all coordinates that are f32: no product of three differences overflows or underflows f64.
#[inline]
pub(super) fn side(a: Point, b: Point, c: Point, p: Point) -> f64 {
    let at = |p: Point| Coord3D { x: p[0], y: p[1], z: p[2] };
    // `robust` counts the other side as positive.
    -orient3d(at(a), at(b), at(c), at(p))
}

/// Orientation of abc with coordinate `drop` ignored: the sign is exact, positive if counterclockwise.
#[inline]
pub(super) fn turn(a: Point, b: Point, c: Point, drop: usize) -> f64 {
    let (u, v) = ((drop + 1) % 3, (drop + 2) % 3);
    let at = |p: Point| Coord { x: p[u], y: p[v] };
    orient2d(at(a), at(b), at(c))
}
