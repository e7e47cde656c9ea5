//! Feature points, one per cell, and the distances to the nearest two.

use super::cells::Cells;
use super::{GOLDEN, LANES, MOST, extend, key, mix, mixed};
use fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u32x16};

/// Returns the position of a cell's feature point along an axis, from 0 to 1.
#[inline(always)]
pub(crate) fn feature(hash: u32, axis: usize) -> f32 {
    let bits = mix(hash.wrapping_add(1 + axis as u32 / 2)) >> (16 * (axis as u32 % 2));
    ((bits & 0xffff) as f32 + 0.5) / 65536.0
}

/// Cells along an axis in the order in which they are visited. The point's own cell comes first, because it most often
/// has the nearest feature point.
const STEPS: [i64; 3] = [0, -1, 1];

/// Returns which step a cell of the neighborhood, by its index, lies away along an axis.
#[inline(always)]
const fn step(index: usize, axis: usize) -> usize {
    index / 3usize.pow(axis as u32) % 3
}

/// Returns the distances from a point to the nearest and the second nearest feature point, each at most 1, and the
/// vectors to them: 0 if none is nearer than 1. The neighboring cells contain all of those nearer than 1.
pub(super) fn nearest_of_one<const D: usize>(seed: u32, cell: [i64; D], fraction: [f32; D]) -> [(f32, [f32; D]); 2] {
    let mut found = [(1.0, [0.0; D]); 2];
    for index in 0..3usize.pow(D as u32) {
        let (mut hash, mut way) = (seed, [0.0; D]);
        for axis in 0..D {
            hash = extend(hash, cell[axis].wrapping_add(STEPS[step(index, axis)]));
        }
        let mut square = 0.0;
        for axis in 0..D {
            way[axis] = STEPS[step(index, axis)] as f32 + feature(hash, axis) - fraction[axis];
            square += way[axis] * way[axis];
        }
        if square < found[0].0 {
            found = [(square, way), found[0]];
        } else if square < found[1].0 {
            found[1] = (square, way);
        }
    }
    found.map(|(square, way)| (square.sqrt(), way))
}

/// Feature points nearest to a block of points.
#[derive(Clone, Copy)]
pub(super) struct Nearest<S: Simd, const D: usize> {
    /// Distances to the nearest and, if requested, the second nearest, each at most 1.
    pub(super) distances: [f32x16<S>; 2],
    /// Vectors to them, if requested; 0 if none is nearer than 1.
    pub(super) ways: [[f32x16<S>; D]; 2],
}

/// The cell whose neighborhood was hashed last.
pub(super) struct Neighborhood<const D: usize> {
    cell: Option<[i64; D]>,
    /// Feature points relative to the cell, by axis and index of their cells.
    points: [[f32; MOST_CELLS]; D],
}

/// Cells of a neighborhood on the most axes, in whole vectors.
const MOST_CELLS: usize = 3usize.pow(MOST as u32).next_multiple_of(LANES);

/// For each axis, [`step`]s to the cells of a neighborhood.
const STEPS_TO: [[u32; MOST_CELLS]; MOST] = {
    let mut steps = [[0; MOST_CELLS]; MOST];
    let mut index = 0;
    while index < MOST * MOST_CELLS {
        steps[index / MOST_CELLS][index % MOST_CELLS] = step(index % MOST_CELLS, index / MOST_CELLS) as u32;
        index += 1;
    }
    steps
};

impl<const D: usize> Default for Neighborhood<D> {
    fn default() -> Self {
        Self { cell: None, points: [[0.0; MOST_CELLS]; D] }
    }
}

impl<const D: usize> Neighborhood<D> {
    /// Hashes the cells around a cell.
    #[inline(always)]
    fn hash<S: Simd>(&mut self, simd: S, seed: u32, cell: [i64; D]) {
        for first in (0..3usize.pow(D as u32)).step_by(LANES) {
            let mut hashes = u32x16::splat(simd, seed);
            for (axis, cell) in cell.into_iter().enumerate() {
                let [own, below, above] = STEPS.map(|step| key(cell.wrapping_add(step)));
                let steps = u32x16::from_slice(simd, &STEPS_TO[axis][first..][..LANES]);
                let (is_below, is_above): (mask32x16<S>, mask32x16<S>) = (steps.simd_eq(1), steps.simd_eq(2));
                let others = is_above.select(u32x16::splat(simd, above), u32x16::splat(simd, own));
                let keys = is_below.select(u32x16::splat(simd, below), others);
                hashes = mixed((hashes ^ keys) + GOLDEN);
            }
            for (axis, points) in self.points.iter_mut().enumerate() {
                let steps = u32x16::from_slice(simd, &STEPS_TO[axis][first..][..LANES]);
                let (is_below, is_above): (mask32x16<S>, mask32x16<S>) = (steps.simd_eq(1), steps.simd_eq(2));
                let others = is_above.select(f32x16::splat(simd, 1.0), f32x16::splat(simd, 0.0));
                let steps = is_below.select(f32x16::splat(simd, -1.0), others);
                (steps + features(hashes, axis)).store_slice(&mut points[first..][..LANES]);
            }
        }
        self.cell = Some(cell);
    }
}

/// Returns [`feature`] of each hash.
#[inline(always)]
fn features<S: Simd>(hashes: u32x16<S>, axis: usize) -> f32x16<S> {
    let bits = (mixed(hashes + (1 + axis as u32 / 2)) >> (16 * (axis as u32 % 2))) & 0xffff;
    let bits: f32x16<S> = bits.bitcast::<i32x16<S>>().to_float();
    (bits + 0.5) * (1.0 / 65536.0)
}

/// Returns what [`nearest_of_one`] does for a block of points, bit for bit. If they lie in the same cell, as they mostly
/// do, the cells around it are hashed once for all of them, unless they were just before.
#[inline(always)]
pub(super) fn nearest<S: Simd, const D: usize, const SECOND: bool, const WAYS: bool>(
    simd: S,
    seed: u32,
    block: &Cells<S, D>,
    around: &mut Neighborhood<D>,
) -> Nearest<S, D> {
    if block.starts() != 1 {
        return nearest_of_each::<S, D, SECOND, WAYS>(simd, seed, block);
    }
    let cell = block.cell(0);
    if around.cell != Some(cell) {
        around.hash(simd, seed, cell);
    }
    let points = &around.points;
    search::<S, D, SECOND, WAYS>(
        simd,
        &block.fractions,
        #[inline(always)]
        |index| {
            let mut place = [f32x16::splat(simd, 0.0); D];
            for axis in 0..D {
                place[axis] = f32x16::splat(simd, points[axis][index]);
            }
            place
        },
    )
}

/// Finds the nearest feature points for points in many cells. Cells share the hashes of the preceding axes.
#[inline(always)]
fn nearest_of_each<S: Simd, const D: usize, const SECOND: bool, const WAYS: bool>(
    simd: S,
    seed: u32,
    block: &Cells<S, D>,
) -> Nearest<S, D> {
    let mut hashes = [u32x16::splat(simd, seed); 27];
    let mut count = 1;
    for axis in 0..D - 1 {
        for index in 0..count {
            let before = hashes[index];
            for (digit, step) in STEPS.iter().enumerate() {
                let keys = block.keys(axis, *step as u32);
                hashes[index + digit * count] = mixed((before ^ keys) + GOLDEN);
            }
        }
        count *= 3;
    }
    let mut last = [u32x16::splat(simd, 0); 3];
    for (keys, step) in last.iter_mut().zip(STEPS) {
        *keys = block.keys(D - 1, step as u32);
    }
    search::<S, D, SECOND, WAYS>(
        simd,
        &block.fractions,
        #[inline(always)]
        |index| {
            let hash = mixed((hashes[index % count] ^ last[step(index, D - 1)]) + GOLDEN);
            let mut place = [f32x16::splat(simd, 0.0); D];
            for axis in 0..D {
                place[axis] = features(hash, axis) + STEPS[step(index, axis)] as f32;
            }
            place
        },
    )
}

/// Finds the nearest of the feature points of the cells around, whose places relative to the point's own cell `place`
/// returns. A cell farther from all points than what has been found is skipped, which does not change the result.
#[inline(always)]
fn search<S: Simd, const D: usize, const SECOND: bool, const WAYS: bool>(
    simd: S,
    fractions: &[f32x16<S>; D],
    place: impl Fn(usize) -> [f32x16<S>; D],
) -> Nearest<S, D> {
    // Squared distance to each cell along each axis.
    let mut aways = [[f32x16::splat(simd, 0.0); 3]; D];
    for (aways, inside) in aways.iter_mut().zip(fractions) {
        let beyond = f32x16::splat(simd, 1.0) - *inside;
        (aways[1], aways[2]) = (*inside * *inside, beyond * beyond);
    }
    let mut found = Nearest::none(simd);
    for index in 0..3usize.pow(D as u32) {
        let mut bounds = aways[0][step(index, 0)];
        for (axis, aways) in aways.iter().enumerate().skip(1) {
            bounds += aways[step(index, axis)];
        }
        let [first, second] = found.distances;
        let within = bounds.simd_le(if SECOND { second } else { first });
        if !within.any_true() {
            continue;
        }
        let mut ways = place(index);
        let mut square = f32x16::splat(simd, 0.0);
        for axis in 0..D {
            ways[axis] -= fractions[axis];
            square += ways[axis] * ways[axis];
        }
        let (nearest, nearer) = (square.simd_lt(first), square.simd_lt(second));
        found.distances[0] = nearest.select(square, first);
        if SECOND {
            found.distances[1] = nearest.select(first, nearer.select(square, second));
        }
        if WAYS {
            for (axis, way) in ways.into_iter().enumerate() {
                let [to_first, to_second] = [found.ways[0][axis], found.ways[1][axis]];
                found.ways[0][axis] = nearest.select(way, to_first);
                found.ways[1][axis] = nearest.select(to_first, nearer.select(way, to_second));
            }
        }
    }
    for distance in &mut found.distances {
        *distance = distance.sqrt();
    }
    found
}

impl<S: Simd, const D: usize> Nearest<S, D> {
    /// Returns what is found if no feature point is nearer than 1.
    #[inline(always)]
    fn none(simd: S) -> Self {
        Self { distances: [f32x16::splat(simd, 1.0); 2], ways: [[f32x16::splat(simd, 0.0); D]; 2] }
    }

    /// Returns the distance to the second nearest point minus that to the nearest.
    #[inline(always)]
    pub(super) fn edges(&self) -> f32x16<S> {
        self.distances[1] - self.distances[0]
    }

    /// Returns the slope of [`Self::edges`] along an axis, per cell: the difference of the unit vectors from both
    /// points. A distance that is 0 or limited to 1 has no slope.
    #[inline(always)]
    pub(super) fn slopes(&self, simd: S, axis: usize) -> f32x16<S> {
        let mut slopes = [f32x16::splat(simd, 0.0); 2];
        for (rank, slope) in slopes.iter_mut().enumerate() {
            let distance = self.distances[rank];
            *slope = distance.simd_gt(0.0).select(self.ways[rank][axis] / distance, *slope);
        }
        slopes[0] - slopes[1]
    }
}
