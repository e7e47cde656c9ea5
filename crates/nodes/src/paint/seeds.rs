//! Seeds of strokes: points fixed on the surface, found again in every frame.
//!
//! There is a hierarchy of square grids on the surface; the cells of level ℓ have sides of 2^ℓ. Each cell has one point
//! at a random position, which depends only on the cell. The part of the surface seen between four pixels is a patch,
//! and its seeds are the grid points that lie in it, taken from the two levels whose density in the picture is nearest
//! to the requested one; one level fades out as the other fades in.

use trochoid_field::random::{draw, key};

/// Surface point that one pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    /// Point of the surface at rest; where no surface is seen, the point in the picture.
    pub(crate) rest: [f64; 3],
    /// Index of the surface; −1 where none is seen.
    pub(crate) part: f64,
    /// Depth; +∞ where no surface is seen.
    pub(crate) depth: f64,
}

/// A patch of the surface between four pixels, projected along the coordinate axis that it faces most. The axis depends
/// on the surface at rest only, not on the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Patch {
    /// Upper left, upper right, lower left and lower right corner.
    corners: [[f64; 2]; 4],
    /// Bounding box of the corners.
    low: [f64; 2],
    high: [f64; 2],
    /// Distance between its corners, in pixels.
    side: f64,
    /// Its area per pixel².
    pub(crate) area: f64,
    /// Index of the surface; −1 where none is seen.
    part: f64,
    /// Axis of the projection, and whether a surface is seen, in one number.
    tag: i64,
}

/// A grid point that lies in a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seed {
    /// Key of its random numbers.
    pub(crate) key: u64,
    /// Position, in pixels from the center of the patch's upper left pixel.
    pub(crate) at: [f64; 2],
    /// Strength by which its level is faded in, in [0, 1].
    pub(crate) share: f64,
    /// Index of the surface it lies on; −1 for none.
    pub(crate) part: f64,
}

/// Returns the patch between four pixels (upper left, upper right, lower left, lower right) that are `side` pixels
/// apart. Returns `None` if they see different surfaces, or depths that differ by more than the factor `step`.
#[inline(always)]
pub(crate) fn placed(corners: [Corner; 4], side: f64, step: f64) -> Option<Patch> {
    let [a, b, c, d] = corners;
    if a.part != b.part || a.part != c.part || a.part != d.part {
        return None;
    }
    let near = a.depth.min(b.depth).min(c.depth.min(d.depth));
    let far = a.depth.max(b.depth).max(c.depth.max(d.depth));
    if far > near * step {
        return None;
    }
    let less = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let (p, q) = (less(d.rest, a.rest), less(c.rest, b.rest));
    let areas = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]].map(f64::abs);
    // Ties go to the vertical axis, because seas are flat.
    let axis = if areas[1] >= areas[0] && areas[1] >= areas[2] { 1 } else { usize::from(areas[2] > areas[0]) * 2 };
    let kept = [[1, 2], [0, 2], [0, 1]][axis];
    let flat = |corner: Corner| kept.map(|axis| corner.rest[axis]);
    let tag = axis as i64 + if a.part < 0.0 { 3 } else { 0 };
    let part = a.part;
    let [a, b, c, d] = corners.map(flat);
    let low = [0, 1].map(|axis: usize| a[axis].min(b[axis]).min(c[axis].min(d[axis])));
    let high = [0, 1].map(|axis: usize| a[axis].max(b[axis]).max(c[axis].max(d[axis])));
    let area = areas[axis] / (2.0 * side * side);
    Some(Patch { corners: [a, b, c, d], low, high, side, area, part, tag })
}

/// Returns the lower of the two levels that give one point per `pixels` square pixels on a patch with the given area
/// per pixel²; `None` if the area is degenerate.
#[inline(always)]
pub(crate) fn level_of(area: f64, pixels: f64) -> Option<i64> {
    let cell = area * pixels;
    // The exponent of a float is the integer part of its base-2 logarithm.
    (cell > 1e-30 && cell < 1e30).then(|| ((cell.to_bits() >> 52) as i64 - 1023).div_euclid(2))
}

/// Returns 2^−level.
#[inline(always)]
fn cells_per_unit(level: i64) -> f64 {
    f64::from_bits(((1023 - level) as u64) << 52)
}

/// Returns the cell that contains a coordinate.
#[inline(always)]
fn cell(coordinate: f64) -> i64 {
    let toward_zero = coordinate as i64;
    toward_zero.saturating_sub(i64::from(toward_zero as f64 > coordinate))
}

/// Largest number of cells searched along an axis; patches seen at grazing angles would span too many.
const MOST: i64 = 15;

/// A cell in the cache.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// Level of the grid and tag of the patch, in one number.
    grid: i64,
    i: i64,
    j: i64,
    key: u64,
    point: [f64; 2],
}

/// Cache of the cells of one layer that were used last: neighboring patches often share cells.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    layer: u64,
    /// Indexed by the last bits of the level and the cell's coordinates.
    known: [Known; 8],
}

impl Cells {
    /// Creates the cache of the layer with this key.
    pub(crate) fn new(layer: u64) -> Self {
        Self { layer, known: [Known { grid: i64::MAX, i: 0, j: 0, key: 0, point: [0.0; 2] }; 8] }
    }

    /// Returns the key and the point of a cell.
    #[inline(always)]
    fn get(&mut self, level: i64, tag: i64, i: i64, j: i64, scale: f64) -> (u64, [f64; 2]) {
        let known = &mut self.known[(4 * (level & 1) + 2 * (i & 1) + (j & 1)) as usize];
        let grid = level * 8 + tag;
        if known.grid != grid || known.i != i || known.j != j {
            let key = key(key(key(self.layer, grid), i), j);
            let point = [(i as f64 + draw(key, 0)) / scale, (j as f64 + draw(key, 1)) / scale];
            *known = Known { grid, i, j, key, point };
        }
        (known.key, known.point)
    }
}

/// Calls `found` for the seeds in a patch, one per `pixels` square pixels on average.
#[inline(always)]
pub(crate) fn seeds_of(patch: &Patch, pixels: f64, cells: &mut Cells, mut found: impl FnMut(Seed)) {
    let Some(lower) = level_of(patch.area, pixels) else { return };
    let Patch { low, high, .. } = *patch;
    let scale = cells_per_unit(lower);
    let (first, last) = (low.map(|x| cell(x * scale)), high.map(|x| cell(x * scale)));
    if (0..2).any(|axis| last[axis].saturating_sub(first[axis]) > MOST) {
        return;
    }
    for up in 0..2 {
        // A cell of the upper level contains two by two cells of the lower one.
        let (level, scale) = (lower + up, if up == 0 { scale } else { 0.5 * scale });
        for i in first[0] >> up..(last[0] >> up).saturating_add(1) {
            for j in first[1] >> up..(last[1] >> up).saturating_add(1) {
                let (key, point) = cells.get(level, patch.tag, i, j, scale);
                let outside = |axis: usize| point[axis] < low[axis] || point[axis] > high[axis];
                if outside(0) || outside(1) {
                    continue;
                }
                if let Some(at) = within(&patch.corners, point) {
                    let at = at.map(|share| share * patch.side);
                    let above = 0.5 * libm::log2(patch.area * pixels) - lower as f64;
                    let share = if level == lower { 1.0 - above } else { above };
                    found(Seed { key, at, share: share.clamp(0.0, 1.0), part: patch.part });
                }
            }
        }
    }
}

/// Returns the position of a point between four corners (upper left, upper right, lower left, lower right), as
/// fractions across and down, linear within each of the two triangles; `None` if it lies outside.
#[inline(always)]
pub(crate) fn within(corners: &[[f64; 2]; 4], point: [f64; 2]) -> Option<[f64; 2]> {
    let [a, b, c, d] = *corners;
    // Barycentric coordinates along the edges from one corner to two others.
    let shares = |from: [f64; 2], to: [f64; 2], other: [f64; 2]| {
        let less = |p: [f64; 2]| [p[0] - from[0], p[1] - from[1]];
        let (u, v, p) = (less(to), less(other), less(point));
        let area = u[0] * v[1] - u[1] * v[0];
        [(p[0] * v[1] - p[1] * v[0]) / area, (u[0] * p[1] - u[1] * p[0]) / area]
    };
    let [s, t] = shares(a, b, c);
    if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        return Some([s, t]);
    }
    let [s, t] = shares(d, c, b);
    (s >= 0.0 && t >= 0.0 && s + t < 1.0).then_some([1.0 - s, 1.0 - t])
}
