//! Edge functions of a triangle in the picture, in whole numbers.

use std::ops::{Add, Mul, Sub};

use crate::project::ScreenVertex;

/// Numbers in which edge functions are exact.
pub(crate) trait Whole:
    Copy + PartialOrd + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// Converts a number, which must fit.
    fn of(number: i64) -> Self;
    fn float(self) -> f64;
    /// Returns a number that is at least 0 if both are.
    fn both(self, other: Self) -> Self;
    /// Returns a number that is at least 0 if one of them is.
    fn either(self, other: Self) -> Self;
}

impl Whole for i64 {
    #[inline(always)]
    fn of(number: i64) -> Self {
        number
    }

    #[inline(always)]
    fn float(self) -> f64 {
        self as f64
    }

    #[inline(always)]
    fn both(self, other: Self) -> Self {
        self | other
    }

    #[inline(always)]
    fn either(self, other: Self) -> Self {
        self & other
    }
}

/// For triangles smaller than 2¹⁴ in each direction and pixels of at most 2¹²: a function is then below 2³⁰ at a
/// sample of any pixel that one of the triangle's points lies in.
impl Whole for i32 {
    #[inline(always)]
    fn of(number: i64) -> Self {
        number as Self
    }

    #[inline(always)]
    fn float(self) -> f64 {
        f64::from(self)
    }

    #[inline(always)]
    fn both(self, other: Self) -> Self {
        self | other
    }

    #[inline(always)]
    fn either(self, other: Self) -> Self {
        self & other
    }
}

/// For triangles smaller than 2²⁴ in each direction and pixels of at most 2¹²: a function is then below 2⁵⁰. Few
/// processors multiply vectors of i64.
impl Whole for f64 {
    #[inline(always)]
    fn of(number: i64) -> Self {
        number as Self
    }

    #[inline(always)]
    fn float(self) -> f64 {
        self
    }

    #[inline(always)]
    fn both(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn either(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

/// Edge functions A·x + B·y + C over the triangle, each at least 0 inside and on the edges that belong to it.
pub(crate) struct Edges<I> {
    a: [I; 3],
    b: [I; 3],
    /// Values at the starting position.
    pub(crate) first: [I; 3],
    /// Bias that was subtracted from each function: 0 if the edge itself belongs to the triangle, else 1.
    least: [I; 3],
    /// Keys of the corner opposite each edge, divided by twice the area.
    keys: [f64; 3],
}

impl<I: Whole> Edges<I> {
    /// Computes the functions from a starting position; `None` for a triangle without area.
    ///
    /// Both orientations are visible: where a sea folds over, its triangles are turned over. A sample exactly on an
    /// edge belongs to the triangle for which the edge is a top or a left one, so that exactly one of two neighbors
    /// takes it.
    #[inline(always)]
    pub(crate) fn new(mut corners: [ScreenVertex; 3], from: [i64; 2]) -> Option<Self> {
        let at = |vertex: ScreenVertex| (I::of(i64::from(vertex.x) - from[0]), I::of(i64::from(vertex.y) - from[1]));
        let ((x0, y0), (x1, y1), (x2, y2)) = (at(corners[0]), at(corners[1]), at(corners[2]));
        let zero = I::of(0);
        let mut area = (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0);
        if area == zero {
            return None;
        }
        if area < zero {
            corners.swap(1, 2);
            area = zero - area;
        }
        let (mut a, mut b, mut first, mut least) = ([zero; 3], [zero; 3], [zero; 3], [zero; 3]);
        for edge in 0..3 {
            let (px, py) = at(corners[(edge + 1) % 3]);
            let (qx, qy) = at(corners[(edge + 2) % 3]);
            a[edge] = py - qy;
            b[edge] = qx - px;
            // With positive area and y down: a left edge rises (A > 0), a top edge is level and runs right (B > 0).
            let takes_edge = a[edge] > zero || (a[edge] == zero && b[edge] > zero);
            least[edge] = I::of(i64::from(!takes_edge));
            first[edge] = zero - a[edge] * px - b[edge] * py - least[edge];
        }
        let area = area.float();
        let key = |corner: usize| f64::from(corners[corner].key) / area;
        Some(Self { a, b, first, least, keys: [key(0), key(1), key(2)] })
    }

    /// Returns how much the functions change over a displacement.
    #[inline(always)]
    pub(crate) fn change(&self, x: I, y: I) -> [I; 3] {
        let of = |edge: usize| self.a[edge] * x + self.b[edge] * y;
        [of(0), of(1), of(2)]
    }

    /// Returns a number that is at least 0 if a position with these values belongs to the triangle.
    #[inline(always)]
    pub(crate) fn inside(at: [I; 3]) -> I {
        at[0].both(at[1]).both(at[2])
    }

    /// Returns the key at a position with these values.
    #[inline(always)]
    pub(crate) fn key(&self, at: [I; 3]) -> f64 {
        let weight = |edge: usize| (at[edge] + self.least[edge]).float() * self.keys[edge];
        weight(0) + weight(1) + weight(2)
    }
}
