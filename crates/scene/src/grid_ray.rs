//! The first point of a height field on a ray, in f64.
//!
//! Within a cell the field is a bicubic polynomial, so along a ray its distance from the ray is one of degree 6, whose
//! roots are isolated by its Bézier coefficients. Newton's method finds a root that is alone.

#![allow(clippy::needless_range_loop, reason = "loops over several arrays")]

use glam::DVec3;

use crate::grid_ranges::SIZES;
use crate::grid_values::Number;
use crate::{GridSurface, Ray};

/// Degree of a bicubic polynomial along a line.
const DEGREE: usize = 6;
/// Most halvings of an interval: the rest is below the rounding of its ends.
const HALVINGS: u32 = 52;
/// Most steps to a root that is alone in its interval, each at least a halving or one of Newton's, and a step that is
/// small enough to be the last one.
const STEPS: u32 = 100;
const LAST: f64 = 4.0 * f64::EPSILON;

/// A polynomial in Bézier form.
type Bezier = [f64; DEGREE + 1];

/// Where a ray first crosses a height field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub(crate) distance: f64,
    /// The cell that it lies in, if the ray certainly crosses the field only once there.
    pub(crate) only: Option<[usize; 2]>,
}

/// A ray on its way across the cells of a grid: positions in cells, as a function of the distance.
struct Way {
    from: [f64; 2],
    by: [f64; 2],
    /// 1 divided by `by`; unused where that is 0.
    inverse: [f64; 2],
    /// Last cell along each axis.
    last: [usize; 2],
}

impl Way {
    /// Returns the index along an axis of the cell just beyond a distance. Rounding may name a neighbor, whose
    /// polynomial continues this one's.
    #[inline]
    fn cell(&self, axis: usize, distance: f64) -> usize {
        let place = (self.from[axis] + self.by[axis] * distance).max(0.0);
        (place as usize).min(self.last[axis])
    }

    /// Returns where the ray leaves the square of `size` cells a side that contains a cell, at most at `far`, and the cell
    /// that it enters there. Every square is left forward, so progress is certain even where rounding hides it.
    #[inline]
    fn leaves(&self, cell: [usize; 2], size: usize, at: f64, far: f64) -> (f64, [usize; 2]) {
        let first = cell.map(|index| index / size * size);
        let (mut leave, mut across) = (far, None);
        for axis in 0..2 {
            // The end of the grid lies at `far`.
            let (side, next) = if self.by[axis] > 0.0 && first[axis] + size <= self.last[axis] {
                (first[axis] + size, first[axis] + size)
            } else if self.by[axis] < 0.0 && first[axis] > 0 {
                (first[axis], first[axis] - 1)
            } else {
                continue;
            };
            let there = (side as f64 - self.from[axis]) * self.inverse[axis];
            if there < leave {
                (leave, across) = (there, Some((axis, next)));
            }
        }
        let leave = leave.max(at);
        let mut entered = cell;
        if let Some((axis, next)) = across {
            entered[axis] = next;
            let other = 1 - axis;
            if size > 1 {
                entered[other] = self.cell(other, leave).clamp(first[other], first[other] + size - 1);
            }
        }
        (leave, entered)
    }
}

/// Returns where a ray first crosses a height field between two distances.
pub(crate) fn first_of_grid<T: Number>(grid: &GridSurface<T>, ray: &Ray, [start, end]: [f64; 2]) -> Option<Crossing> {
    let ([columns, rows], spacing, origin) = (grid.size(), grid.spacing(), grid.origin());
    let by = [ray.direction.x / spacing, ray.direction.z / spacing];
    let way = Way {
        from: [(ray.origin.x - origin[0]) / spacing, (ray.origin.z - origin[1]) / spacing],
        by,
        inverse: by.map(|by| 1.0 / by),
        last: [columns - 2, rows - 2],
    };
    let (mut near, mut far) = (start, end);
    for axis in 0..2 {
        let count = (way.last[axis] + 1) as f64;
        if by[axis] == 0.0 {
            if !(0.0..=count).contains(&way.from[axis]) {
                return None;
            }
            continue;
        }
        let (a, b) = (-way.from[axis] / by[axis], (count - way.from[axis]) / by[axis]);
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
    }
    let ranges = grid.ranges();
    let above = ray.origin.y - grid.level();
    let height = |distance: f64| above + ray.direction.y * distance;
    // Where the ray leaves the block of each size that it may meet the field in.
    let mut within = [f64::NEG_INFINITY; SIZES.len()];
    let (mut at, mut cell) = (near, [way.cell(0, near), way.cell(1, near)]);
    'way: while at < far {
        let from = height(at);
        for (level, size) in SIZES.into_iter().enumerate() {
            if at < within[level] {
                continue;
            }
            let (past, entered) = way.leaves(cell, size, at, far);
            if ranges.block(level, cell).misses([from, height(past)]) {
                (at, cell) = (past, entered);
                continue 'way;
            }
            within[level] = past;
        }
        let (leave, entered) = way.leaves(cell, 1, at, far);
        let to = height(leave);
        if !ranges.cell(cell).misses([from, to]) {
            let local = |distance: f64| [0, 1].map(|axis| way.from[axis] + by[axis] * distance - cell[axis] as f64);
            let gap = along(&grid.neighbors(cell), local(at), local(leave), [from, to]);
            if let Some(part) = first_root(&gap, 0.0, 1.0, HALVINGS) {
                let only = (leave < end && changes(&gap) == 1).then_some(cell);
                return Some(Crossing { distance: at + part * (leave - at), only });
            }
        }
        (at, cell) = (leave, entered);
    }
    None
}

/// Returns the coefficients of 1, t, t², t³ of the Catmull–Rom interpolation of four neighbors.
#[inline]
fn powers([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    [b, 0.5 * (c - a), a - 2.5 * b + 2.0 * c - 0.5 * d, 1.5 * (b - c) + 0.5 * (d - a)]
}

/// Returns the Bézier coefficients of a ray's height above a cell's polynomial between two positions in the cell, given
/// the heights of the ray there.
fn along(heights: &[[f64; 4]; 4], from: [f64; 2], to: [f64; 2], [rise, fall]: [f64; 2]) -> Bezier {
    // By powers of u, row by row along v; then by powers of u and of v.
    let rows = [powers(heights[0]), powers(heights[1]), powers(heights[2]), powers(heights[3])];
    let [u, v] = [0, 1].map(|axis| [from[axis], to[axis] - from[axis]]);
    // Horner's scheme in u, whose factors are polynomials of the place along the ray, as u and v are.
    let mut sum = [0.0; DEGREE + 1];
    for i in (0..4).rev() {
        let by_v = powers([rows[0][i], rows[1][i], rows[2][i], rows[3][i]]);
        let mut inner = [by_v[3], 0.0, 0.0, 0.0];
        for j in (0..3).rev() {
            inner = times(inner, v);
            inner[0] += by_v[j];
        }
        sum = times(sum, u);
        for k in 0..4 {
            sum[k] += inner[k];
        }
    }
    // Powers to Bézier coefficients: b_k = Σ C(k, i)/C(6, i)·a_i.
    let mut bezier = [0.0; DEGREE + 1];
    for (k, bezier) in bezier.iter_mut().enumerate() {
        let mut value = 0.0;
        for i in 0..=k {
            value += TO_BEZIER[k][i] * sum[i];
        }
        *bezier = rise + (fall - rise) * (k as f64 / DEGREE as f64) - value;
    }
    bezier
}

/// C(k, i)/C(6, i).
const TO_BEZIER: [[f64; DEGREE + 1]; DEGREE + 1] = {
    let mut shares = [[0.0; DEGREE + 1]; DEGREE + 1];
    let mut k = 0;
    while k <= DEGREE {
        let (mut own, mut all, mut i) = (1, 1, 0);
        while i <= k {
            shares[k][i] = own as f64 / all as f64;
            own = own * (k - i) / (i + 1);
            all = all * (DEGREE - i) / (i + 1);
            i += 1;
        }
        k += 1;
    }
    shares
};

/// Returns a polynomial, by its coefficients, times a + b·t. Its highest coefficient is 0.
#[inline]
fn times<const N: usize>(polynomial: [f64; N], [a, b]: [f64; 2]) -> [f64; N] {
    let mut product = polynomial;
    product[0] = a * polynomial[0];
    for i in 1..N {
        product[i] = a * polynomial[i] + b * polynomial[i - 1];
    }
    product
}

/// Returns how often the coefficients of a polynomial change their sign; 0 counts as negative.
///
/// It has no more roots than these, and as many with the same parity (Descartes).
#[inline]
fn changes(coefficients: &Bezier) -> u32 {
    let mut signs = 0;
    for (index, coefficient) in coefficients.iter().enumerate() {
        signs |= u32::from(*coefficient > 0.0) << index;
    }
    ((signs ^ (signs >> 1)) & ((1 << DEGREE) - 1)).count_ones()
}

/// Returns the first root of a polynomial in Bézier form between two places.
fn first_root(coefficients: &Bezier, low: f64, high: f64, halvings: u32) -> Option<f64> {
    match changes(coefficients) {
        0 => return None,
        1 => return Some(low + only_root(coefficients) * (high - low)),
        _ => {}
    }
    let middle = 0.5 * (low + high);
    if halvings == 0 {
        return Some(middle);
    }
    let [first, second] = halves(coefficients);
    first_root(&first, low, middle, halvings - 1).or_else(|| first_root(&second, middle, high, halvings - 1))
}

/// Returns the root of a polynomial in Bézier form that has only one, by Newton's method, which halves the rest wherever
/// it leaves it.
fn only_root(coefficients: &Bezier) -> f64 {
    let (first, last) = (coefficients[0], coefficients[DEGREE]);
    let (mut low, mut high) = (0.0, 1.0);
    let mut at = first / (first - last);
    for _ in 0..STEPS {
        let (value, slope) = value(coefficients, at);
        if (value > 0.0) == (last > 0.0) {
            high = at;
        } else {
            low = at;
        }
        let led = at - value / slope;
        let next = if led >= low && led <= high { led } else { 0.5 * (low + high) };
        let step = (next - at).abs();
        at = next;
        if step <= LAST {
            break;
        }
    }
    at
}

/// Returns a polynomial's value and slope, by de Casteljau's algorithm.
#[inline]
fn value(coefficients: &Bezier, at: f64) -> (f64, f64) {
    let mut left = *coefficients;
    for step in 1..DEGREE {
        for index in 0..=DEGREE - step {
            left[index] += at * (left[index + 1] - left[index]);
        }
    }
    (left[0] + at * (left[1] - left[0]), DEGREE as f64 * (left[1] - left[0]))
}

/// Returns both halves, by de Casteljau's algorithm.
fn halves(coefficients: &Bezier) -> [Bezier; 2] {
    let (mut left, mut low, mut high) = (*coefficients, [0.0; DEGREE + 1], [0.0; DEGREE + 1]);
    for step in 0..=DEGREE {
        low[step] = left[0];
        high[DEGREE - step] = left[DEGREE - step];
        for index in 0..DEGREE - step {
            left[index] = 0.5 * (left[index] + left[index + 1]);
        }
    }
    [low, high]
}

impl<T: Number> GridSurface<T> {
    /// Returns the range of distances in which a ray may meet the surface; `None` if it cannot.
    pub(crate) fn within_slab(&self, ray: &Ray) -> Option<[f64; 2]> {
        let [low, high] = self.bounds().map(|height| self.level() + height);
        let (height, slope) = (ray.origin.y, ray.direction.y);
        if slope == 0.0 {
            return (low..=high).contains(&height).then_some([0.0, f64::INFINITY]);
        }
        let (a, b) = ((low - height) / slope, (high - height) / slope);
        let range = [a.min(b).max(0.0), a.max(b)];
        (range[0] <= range[1]).then_some(range)
    }

    /// Returns the position on the grid nearest to a point.
    pub(crate) fn place_of(&self, point: DVec3) -> [f64; 2] {
        self.within_reach([point.x, point.z])
    }
}
