//! Vectors in color space, in steps of 8-bit channels.

/// A point or direction.
pub(crate) type Point = [f64; 3];

#[inline(always)]
pub(crate) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn scale(a: Point, by: f64) -> Point {
    a.map(|channel| channel * by)
}

#[inline(always)]
pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// Returns a direction of length 1; `None` for one without length.
pub(crate) fn unit(a: Point) -> Option<Point> {
    let length = length(a);
    (length > 0.0).then(|| scale(a, 1.0 / length))
}

/// Returns the mean of some points.
pub(crate) fn mean(points: &[Point]) -> Point {
    let sum = points.iter().fold([0.0; 3], |sum, point| add(sum, *point));
    scale(sum, 1.0 / points.len().max(1) as f64)
}
