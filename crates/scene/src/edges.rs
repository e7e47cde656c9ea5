//! Edge functions of a triangle in the picture, in whole numbers.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

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

/// For triangles smaller than [`NARROW`] in each direction and pixels of at most 2¹²: a function is then below 2³⁰ at a
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

/// Size from which on triangles are too large for edge functions in i32.
pub(crate) const NARROW: i32 = 1 << 14;
/// Number of triangles whose functions are computed side by side, in vectors.
pub(crate) const WIDE: usize = 16;

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

/// Edge functions of several triangles smaller than [`NARROW`].
pub(crate) struct NarrowEdges {
    a: [[i32; WIDE]; 3],
    b: [[i32; WIDE]; 3],
    first: [[i32; WIDE]; 3],
    least: [[i32; WIDE]; 3],
    keys: [[f64; WIDE]; 3],
}

impl Default for NarrowEdges {
    fn default() -> Self {
        let none = [[0; WIDE]; 3];
        Self { a: none, b: none, first: none, least: none, keys: [[0.0; WIDE]; 3] }
    }
}

impl NarrowEdges {
    /// Computes the functions of triangles as [`Edges::new`] does, given their corners and starting positions; those of
    /// larger ones are meaningless. Returns 1 for each triangle without area, else 0.
    #[inline(always)]
    pub(crate) fn set_up(
        &mut self,
        x: [[i32; WIDE]; 3],
        y: [[i32; WIDE]; 3],
        keys: [[f32; WIDE]; 3],
        from: [[i32; WIDE]; 2],
    ) -> [i32; WIDE] {
        let mut flat = [0; WIDE];
        let (mut px, mut py, mut pk) = ([[0; WIDE]; 3], [[0; WIDE]; 3], [[0.0; WIDE]; 3]);
        let mut areas = [0.0; WIDE];
        for lane in 0..WIDE {
            let at = |corner: usize| (x[corner][lane] - from[0][lane], y[corner][lane] - from[1][lane]);
            let ((x0, y0), (x1, y1), (x2, y2)) = (at(0), at(1), at(2));
            let area = (x1 - x0).wrapping_mul(y2 - y0).wrapping_sub((y1 - y0).wrapping_mul(x2 - x0));
            let is_turned = area < 0;
            flat[lane] = i32::from(area == 0);
            areas[lane] = f64::from(area.wrapping_abs());
            (px[0][lane], py[0][lane], pk[0][lane]) = (x0, y0, keys[0][lane]);
            px[1][lane] = if is_turned { x2 } else { x1 };
            py[1][lane] = if is_turned { y2 } else { y1 };
            pk[1][lane] = if is_turned { keys[2][lane] } else { keys[1][lane] };
            px[2][lane] = if is_turned { x1 } else { x2 };
            py[2][lane] = if is_turned { y1 } else { y2 };
            pk[2][lane] = if is_turned { keys[1][lane] } else { keys[2][lane] };
        }
        for edge in 0..3 {
            let (p, q) = ((edge + 1) % 3, (edge + 2) % 3);
            let (mut a, mut b, mut first, mut least) = ([0; WIDE], [0; WIDE], [0; WIDE], [0; WIDE]);
            let mut shares = [0.0; WIDE];
            for lane in 0..WIDE {
                a[lane] = py[p][lane] - py[q][lane];
                b[lane] = px[q][lane] - px[p][lane];
                let takes_edge = i32::from(a[lane] > 0) | i32::from(a[lane] == 0) & i32::from(b[lane] > 0);
                least[lane] = 1 - takes_edge;
                let (ax, by) = (a[lane].wrapping_mul(px[p][lane]), b[lane].wrapping_mul(py[p][lane]));
                first[lane] = 0_i32.wrapping_sub(ax).wrapping_sub(by).wrapping_sub(least[lane]);
                shares[lane] = f64::from(pk[edge][lane]) / areas[lane];
            }
            (self.a[edge], self.b[edge], self.first[edge], self.least[edge]) = (a, b, first, least);
            self.keys[edge] = shares;
        }
        flat
    }

    /// Returns the functions of one triangle.
    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> Edges<i32> {
        let of = |values: &[[i32; WIDE]; 3]| [values[0][lane], values[1][lane], values[2][lane]];
        let keys = [self.keys[0][lane], self.keys[1][lane], self.keys[2][lane]];
        Edges { a: of(&self.a), b: of(&self.b), first: of(&self.first), least: of(&self.least), keys }
    }
}
