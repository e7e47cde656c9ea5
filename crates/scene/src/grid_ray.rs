//! The first point of a height field on a ray, in f64.
//!
//! Within a cell the field is a bicubic polynomial, so along a ray its distance from the ray is one of degree 6, whose
//! roots are isolated by its Bézier coefficients.

use glam::DVec3;

use crate::grid_ranges::BLOCK;
use crate::grid_values::Number;
use crate::{GridSurface, Ray};

/// Degree of a bicubic polynomial along a line.
const DEGREE: usize = 6;
/// Most halvings of an interval: the rest is below the rounding of its ends.
const HALVINGS: u32 = 52;

/// Coefficients of 1, t, t², t³ in the Catmull–Rom weights of the four neighbors.
const WEIGHTS: [[f64; 4]; 4] =
    [[0.0, -0.5, 1.0, -0.5], [1.0, 0.0, -2.5, 1.5], [0.0, 0.5, 2.0, -1.5], [0.0, 0.0, -0.5, 0.5]];

/// Returns the distance at which a ray first crosses a height field between two distances.
pub(crate) fn first_of_grid<T: Number>(grid: &GridSurface<T>, ray: &Ray, [start, end]: [f64; 2]) -> Option<f64> {
    let ([columns, rows], spacing, origin) = (grid.size(), grid.spacing(), grid.origin());
    // Positions in cells.
    let from = [(ray.origin.x - origin[0]) / spacing, (ray.origin.z - origin[1]) / spacing];
    let way = [ray.direction.x / spacing, ray.direction.z / spacing];
    let count = [columns - 1, rows - 1];
    let (mut near, mut far) = (start, end);
    for axis in 0..2 {
        if way[axis] == 0.0 {
            if !(0.0..=count[axis] as f64).contains(&from[axis]) {
                return None;
            }
            continue;
        }
        let (a, b) = (-from[axis] / way[axis], (count[axis] as f64 - from[axis]) / way[axis]);
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
    }
    let ranges = grid.ranges();
    let mut at = near;
    while at < far {
        // The cell just beyond this distance, and where the ray leaves it. Rounding may name a neighbor, whose
        // polynomial continues this one's.
        let cell = [0, 1].map(|axis| {
            let place = from[axis] + way[axis] * at;
            let nearest = (place.round() - place).abs() <= 1e-12 * (1.0 + place.abs());
            let below = match (nearest, way[axis] < 0.0) {
                (true, true) => place.round() - 1.0,
                (true, false) => place.round(),
                (false, _) => place.floor(),
            };
            below.clamp(0.0, (count[axis] - 1) as f64)
        });
        // Where the ray leaves the square of some cells that contains this one. Progress is certain even where rounding
        // hides it.
        let leaves = |size: usize| {
            let mut leave = far;
            for axis in 0..2 {
                let first = cell[axis] as usize / size * size;
                let side = (first + if way[axis] > 0.0 { size } else { 0 }) as f64;
                if way[axis] != 0.0 {
                    let there = (side - from[axis]) / way[axis];
                    if there > at {
                        leave = leave.min(there);
                    }
                }
            }
            leave.max(at.next_up()).min(far)
        };
        let height = |distance: f64| ray.origin.y - grid.level() + ray.direction.y * distance;
        let index = cell.map(|index| index as usize);
        let past = leaves(BLOCK);
        if ranges.block(index).misses([height(at), height(past)]) {
            at = past;
            continue;
        }
        let leave = leaves(1);
        if ranges.cell(index).misses([height(at), height(leave)]) {
            at = leave;
            continue;
        }
        let local = |distance: f64| [0, 1].map(|axis| from[axis] + way[axis] * distance - cell[axis]);
        let gap = along(&grid.neighbors(index), local(at), local(leave), [at, leave].map(height));
        if let Some(part) = first_root(&gap, 0.0, 1.0, HALVINGS) {
            return Some(at + part * (leave - at));
        }
        at = leave;
    }
    None
}

/// Returns the Bézier coefficients of a ray's height above a cell's polynomial between two positions in the cell, given
/// the heights of the ray there.
fn along(heights: &[[f64; 4]; 4], from: [f64; 2], to: [f64; 2], [rise, fall]: [f64; 2]) -> [f64; DEGREE + 1] {
    // By powers of u, then of v.
    let mut powers = [[0.0; 4]; 4];
    for (m, row) in heights.iter().enumerate() {
        for (n, height) in row.iter().enumerate() {
            for i in 0..4 {
                for j in 0..4 {
                    // Rows run along v.
                    powers[i][j] += WEIGHTS[n][i] * WEIGHTS[m][j] * height;
                }
            }
        }
    }
    let [u_powers, v_powers] = [0, 1].map(|axis| powers_of([from[axis], to[axis] - from[axis]]));
    let mut sum = [0.0; DEGREE + 1];
    for (by_v, u_power) in powers.iter().zip(&u_powers) {
        let mut inner = [0.0; 4];
        for (factor, v_power) in by_v.iter().zip(&v_powers) {
            inner.iter_mut().zip(v_power).for_each(|(inner, value)| *inner += factor * value);
        }
        for (i, a) in u_power.iter().enumerate() {
            for (j, b) in inner.iter().enumerate() {
                sum[i + j] += a * b;
            }
        }
    }
    // Powers to Bézier coefficients: b_k = Σ C(k, i)/C(6, i)·a_i.
    const CHOOSE: [f64; DEGREE + 1] = [1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0];
    std::array::from_fn(|k| {
        let mut choose = 1.0;
        let mut value = 0.0;
        for i in 0..=k {
            value += choose / CHOOSE[i] * sum[i];
            choose = choose * (k - i) as f64 / (i + 1) as f64;
        }
        rise + (fall - rise) * k as f64 / DEGREE as f64 - value
    })
}

/// Returns the powers of a + b·t from 0 to 3, each by its coefficients.
fn powers_of([a, b]: [f64; 2]) -> [[f64; 4]; 4] {
    let mut powers = [[1.0, 0.0, 0.0, 0.0]; 4];
    for power in 1..4 {
        let below = powers[power - 1];
        powers[power] = std::array::from_fn(|index| {
            let raised = if index > 0 { b * below[index - 1] } else { 0.0 };
            raised + a * below[index]
        });
    }
    powers
}

/// Returns the first root of a polynomial in Bézier form between two places.
///
/// It has no more roots than its coefficients change their sign, and as many with the same parity (Descartes).
fn first_root(coefficients: &[f64; DEGREE + 1], low: f64, high: f64, halvings: u32) -> Option<f64> {
    let signs = coefficients.map(|value| value > 0.0);
    let changes = signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
    if changes == 0 {
        return None;
    }
    if halvings == 0 {
        return Some(0.5 * (low + high));
    }
    let [first, second] = halves(coefficients);
    let middle = 0.5 * (low + high);
    first_root(&first, low, middle, halvings - 1).or_else(|| first_root(&second, middle, high, halvings - 1))
}

/// Returns both halves, by de Casteljau's algorithm.
fn halves(coefficients: &[f64; DEGREE + 1]) -> [[f64; DEGREE + 1]; 2] {
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
