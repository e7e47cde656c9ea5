//! Three-component f64 vectors and exact orientation tests.

use robust::{Coord, Coord3D, orient2d, orient3d};

pub(super) type Point = [f64; 3];

pub(super) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns a + s·b.
pub(super) fn along(a: Point, s: f64, b: Point) -> Point {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// Returns the dot product, in one fixed order of operations, so that offsets and tests of planes round alike.
#[inline(always)]
pub(super) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// Scales a vector to length 1; the zero vector stays zero.
pub(super) fn unit(a: Point) -> Point {
    let length = length(a);
    if length > 0.0 { a.map(|v| v / length) } else { a }
}

/// Returns the cross product, accurate to about 1.5 ulp in each component, so that slivers have correct normals.
///
/// Uses Kahan's difference of products: a fused multiply–add recovers the rounding error of one product.
pub(super) fn cross(a: Point, b: Point) -> Point {
    let difference = |a: f64, b: f64, c: f64, d: f64| {
        let cd = c * d;
        let error = (-c).mul_add(d, cd);
        a.mul_add(b, -cd) + error
    };
    [difference(a[1], b[2], a[2], b[1]), difference(a[2], b[0], a[0], b[2]), difference(a[0], b[1], a[1], b[0])]
}

/// Returns twice the area vector of triangle abc, which points to the side from which abc is counterclockwise.
pub(super) fn area_vector(a: Point, b: Point, c: Point) -> Point {
    cross(sub(b, a), sub(c, a))
}

/// Returns the side of the plane abc on which p lies: positive where abc is counterclockwise, 0 exactly on the plane.
///
/// The sign is exact for all coordinates that are f32: no product of three differences overflows or underflows f64.
#[inline]
pub(super) fn side(a: Point, b: Point, c: Point, p: Point) -> f64 {
    let at = |p: Point| Coord3D { x: p[0], y: p[1], z: p[2] };
    // For `robust`, the other side is positive.
    -orient3d(at(a), at(b), at(c), at(p))
}

/// Returns the orientation of abc without coordinate `drop`: the sign is exact, positive if counterclockwise.
#[inline]
pub(super) fn turn(a: Point, b: Point, c: Point, drop: usize) -> f64 {
    let (u, v) = ((drop + 1) % 3, (drop + 2) % 3);
    let at = |p: Point| Coord { x: p[u], y: p[v] };
    orient2d(at(a), at(b), at(c))
}
