//! Gradient noise: random slopes at the corners of a lattice, blended into each other.

use super::{GOLDEN, LANES, Lanes, MOST, key, mix};

/// Returns the component of a corner's gradient along an axis, in [−1, 1].
#[inline(always)]
pub(crate) fn gradient(hash: u32, axis: usize) -> f32 {
    (2 * ((hash >> (8 * axis)) & 255) as i32 - 255) as f32 / 255.0
}

/// Amplitude of gradient noise by the number of axes, chosen such that its standard deviation at a cell's center is
/// about 0.3 and fewer than one sample in a thousand is clamped.
pub(crate) const AMPLITUDE: [f32; MOST + 1] = [0.0, 0.0, 1.5, 1.7, 2.1];

/// Returns t³(6t² − 15t + 10).
#[inline(always)]
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Returns gradient noise of one octave at a block of points, in [−1, 1]. Corners share the hashes of the preceding
/// axes.
#[inline(always)]
pub(super) fn gradient_noises<const D: usize>(seed: u32, cells: &[[i64; LANES]; D], fractions: &[Lanes; D]) -> Lanes {
    let (mut hashes, mut weights) = ([[seed; LANES]; 1 << MOST], [[1.0f32; LANES]; 1 << MOST]);
    for axis in 0..D {
        let (lower, upper) = (cells[axis].map(key), cells[axis].map(|cell| key(cell.wrapping_add(1))));
        let share = fractions[axis].map(fade);
        for corner in 0..1 << axis {
            let other = corner + (1 << axis);
            for lane in 0..LANES {
                let (hash, weight) = (hashes[corner][lane], weights[corner][lane]);
                hashes[corner][lane] = mix((hash ^ lower[lane]).wrapping_add(GOLDEN));
                hashes[other][lane] = mix((hash ^ upper[lane]).wrapping_add(GOLDEN));
                weights[corner][lane] = weight * (1.0 - share[lane]);
                weights[other][lane] = weight * share[lane];
            }
        }
    }
    let mut sums = [0.0; LANES];
    for corner in 0..1 << D {
        for lane in 0..LANES {
            let mut dot = 0.0;
            for (axis, inside) in fractions.iter().enumerate() {
                dot += gradient(hashes[corner][lane], axis) * (inside[lane] - ((corner >> axis) & 1) as f32);
            }
            sums[lane] += weights[corner][lane] * dot;
        }
    }
    sums.map(|sum| (AMPLITUDE[D] * sum).clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::super::extend;
    use super::super::tests::{in_lanes, points};
    use super::*;

    /// Gradient noise at a single point: the lanes must have the same bits.
    fn gradient_noise<const D: usize>(seed: u32, cell: [i64; D], fraction: [f32; D]) -> f32 {
        let (mut hashes, mut weights) = ([seed; 1 << MOST], [1.0f32; 1 << MOST]);
        for axis in 0..D {
            let (half, s) = (1 << axis, fade(fraction[axis]));
            for corner in 0..half {
                let (hash, weight) = (hashes[corner], weights[corner]);
                hashes[corner] = extend(hash, cell[axis]);
                hashes[corner + half] = extend(hash, cell[axis].wrapping_add(1));
                weights[corner] = weight * (1.0 - s);
                weights[corner + half] = weight * s;
            }
        }
        let mut sum = 0.0;
        for corner in 0..1 << D {
            let mut dot = 0.0;
            for (axis, inside) in fraction.iter().enumerate() {
                dot += gradient(hashes[corner], axis) * (inside - ((corner >> axis) & 1) as f32);
            }
            sum += weights[corner] * dot;
        }
        (AMPLITUDE[D] * sum).clamp(-1.0, 1.0)
    }

    #[test]
    fn lanes_have_the_bits_of_single_points() {
        fn check<const D: usize>(points: &[[f64; D]]) {
            in_lanes(points, |cells, fractions| {
                let found = gradient_noises(77, cells, fractions);
                for lane in 0..LANES {
                    let (cell, fraction) = (cells.map(|along| along[lane]), fractions.map(|along| along[lane]));
                    assert_eq!(found[lane].to_bits(), gradient_noise(77, cell, fraction).to_bits(), "{cell:?}");
                }
            });
        }
        let points = points();
        check::<3>(&points);
        check::<2>(&points.iter().map(|[x, y, _]| [*x, *y]).collect::<Vec<_>>());
        check::<4>(&points.iter().map(|[x, y, z]| [*x, *y, *z, x * 0.5]).collect::<Vec<_>>());
    }
}
