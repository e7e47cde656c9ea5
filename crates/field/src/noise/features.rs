//! Feature points, one per cell, and the distances to the nearest two.

use super::{GOLDEN, LANES, Lanes, key, mix};

/// Returns the position of a cell's feature point along an axis, from 0 to 1.
#[inline(always)]
pub(crate) fn feature(hash: u32, axis: usize) -> f32 {
    let bits = mix(hash.wrapping_add(1 + axis as u32 / 2)) >> (16 * (axis as u32 % 2));
    ((bits & 0xffff) as f32 + 0.5) / 65536.0
}

/// Feature points nearest to a block of points.
pub(super) struct Nearest<const D: usize> {
    /// Distances to the nearest and, if requested, the second nearest, each at most 1.
    pub(super) distances: [Lanes; 2],
    /// Vectors to them, if requested; 0 if none is nearer than 1.
    pub(super) ways: [[Lanes; D]; 2],
}

/// Cells along an axis in the order in which they are visited. The point's own cell comes first, because it most often
/// has the nearest feature point.
const STEPS: [i64; 3] = [0, -1, 1];

/// Finds the nearest feature points. The neighboring cells contain all of those nearer than 1. Cells share the hashes
/// of the preceding axes. A cell farther from all points than what has been found is skipped, which does not change the
/// result.
#[inline(always)]
pub(super) fn nearest<const D: usize, const SECOND: bool, const WAYS: bool>(
    seed: u32,
    cells: &[[i64; LANES]; D],
    fractions: &[Lanes; D],
) -> Nearest<D> {
    let keys = cells.map(|along| STEPS.map(|step| along.map(|cell| key(cell.wrapping_add(step)))));
    // Squared distance to each cell along each axis.
    let aways = fractions.map(|inside| [[0.0; LANES], inside.map(|f| f * f), inside.map(|f| (1.0 - f) * (1.0 - f))]);
    let mut hashes = [[seed; LANES]; 27];
    let mut count = 1;
    for keys in &keys[..D - 1] {
        for index in 0..count {
            let before = hashes[index];
            for (digit, keys) in keys.iter().enumerate() {
                for lane in 0..LANES {
                    hashes[index + digit * count][lane] = mix((before[lane] ^ keys[lane]).wrapping_add(GOLDEN));
                }
            }
        }
        count *= 3;
    }
    let (mut squares, mut ways) = ([[1.0f32; LANES]; 2], [[[0.0f32; LANES]; D]; 2]);
    for index in 0..3 * count {
        let mut rest = index;
        let digits: [usize; D] = std::array::from_fn(|_| (rest % 3, rest /= 3).0);
        let mut bounds = [0.0; LANES];
        for (axis, digit) in digits.into_iter().enumerate() {
            for lane in 0..LANES {
                bounds[lane] += aways[axis][digit][lane];
            }
        }
        let mut within = false;
        for lane in 0..LANES {
            within |= bounds[lane] <= squares[usize::from(SECOND)][lane];
        }
        if !within {
            continue;
        }
        let (before, last) = (&hashes[index % count], &keys[D - 1][digits[D - 1]]);
        let steps = digits.map(|digit| STEPS[digit] as f32);
        for lane in 0..LANES {
            let hash = mix((before[lane] ^ last[lane]).wrapping_add(GOLDEN));
            let way: [f32; D] = std::array::from_fn(|axis| steps[axis] + feature(hash, axis) - fractions[axis][lane]);
            let mut square = 0.0;
            for along in way {
                square += along * along;
            }
            let [first, second] = squares.map(|squares| squares[lane]);
            let (nearest, nearer) = (square < first, square < second);
            squares[0][lane] = if nearest { square } else { first };
            if SECOND {
                squares[1][lane] = if nearest {
                    first
                } else if nearer {
                    square
                } else {
                    second
                };
            }
            if WAYS {
                for (axis, along) in way.into_iter().enumerate() {
                    let [to_first, to_second] = [0, 1].map(|rank| ways[rank][axis][lane]);
                    ways[0][axis][lane] = if nearest { along } else { to_first };
                    ways[1][axis][lane] = if nearest {
                        to_first
                    } else if nearer {
                        along
                    } else {
                        to_second
                    };
                }
            }
        }
    }
    Nearest { distances: squares.map(|squares| squares.map(f32::sqrt)), ways }
}

impl<const D: usize> Nearest<D> {
    /// Returns the distance to the second nearest point minus that to the nearest.
    #[inline(always)]
    pub(super) fn edges(&self) -> Lanes {
        std::array::from_fn(|lane| self.distances[1][lane] - self.distances[0][lane])
    }

    /// Returns the slope of [`Self::edges`] along an axis, per cell: the difference of the unit vectors from both
    /// points. A distance that is 0 or limited to 1 has no slope.
    #[inline(always)]
    pub(super) fn slopes(&self, axis: usize) -> Lanes {
        let unit = |rank: usize, lane: usize| {
            let (distance, way): (f32, f32) = (self.distances[rank][lane], self.ways[rank][axis][lane]);
            if distance > 0.0 { way / distance } else { 0.0 }
        };
        std::array::from_fn(|lane| unit(0, lane) - unit(1, lane))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{in_lanes, points};
    use super::*;

    /// The same for a single point, cell by cell, with each hash computed from scratch: the lanes must have the same
    /// bits.
    fn nearest_of_one<const D: usize>(seed: u32, cell: [i64; D], fraction: [f32; D]) -> [(f32, [f32; D]); 2] {
        let mut found = vec![(1.0, [0.0; D]); 2];
        for index in 0..3usize.pow(D as u32) {
            let (mut hash, mut steps) = (seed, [0; D]);
            for axis in 0..D {
                steps[axis] = STEPS[index / 3usize.pow(axis as u32) % 3];
                hash = super::super::extend(hash, cell[axis].wrapping_add(steps[axis]));
            }
            let way: [f32; D] = std::array::from_fn(|axis| steps[axis] as f32 + feature(hash, axis) - fraction[axis]);
            found.push((way.iter().fold(0.0, |sum, along| sum + along * along), way));
        }
        // A stable sort: the first of equally distant points counts, and points at distance 1 do not.
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        [found[0], found[1]].map(|(square, way)| (square.sqrt(), way))
    }

    #[test]
    fn lanes_have_the_bits_of_single_points() {
        fn check<const D: usize>(points: &[[f64; D]]) {
            in_lanes(points, |cells, fractions| {
                let all = nearest::<D, true, true>(77, cells, fractions);
                let first = nearest::<D, false, false>(77, cells, fractions);
                let plain = nearest::<D, true, false>(77, cells, fractions);
                for lane in 0..LANES {
                    let (cell, fraction) = (cells.map(|along| along[lane]), fractions.map(|along| along[lane]));
                    let truth = nearest_of_one(77, cell, fraction);
                    for (rank, (distance, way)) in truth.into_iter().enumerate() {
                        assert_eq!(all.distances[rank][lane].to_bits(), distance.to_bits(), "{cell:?} {fraction:?}");
                        assert_eq!(plain.distances[rank][lane].to_bits(), distance.to_bits(), "{cell:?} {fraction:?}");
                        assert_eq!(all.ways[rank].map(|along| along[lane].to_bits()), way.map(f32::to_bits));
                    }
                    assert_eq!(first.distances[0][lane].to_bits(), truth[0].0.to_bits());
                }
            });
        }
        let points = points();
        check::<3>(&points);
        check::<2>(&points.iter().map(|[x, y, _]| [*x, *y]).collect::<Vec<_>>());
        check::<4>(&points.iter().map(|[x, y, z]| [*x, *y, *z, x * 0.5]).collect::<Vec<_>>());
    }
}
