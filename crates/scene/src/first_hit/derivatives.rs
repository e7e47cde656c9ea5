//! Derivatives of the polynomials of a part, which are combinations of the differences of their coefficients.

use super::bernstein::{DEGREE, Net, SIDE, larger};
use fearless_simd::{Simd, f64x8, prelude::*};
use glam::{DMat2, DVec2};

/// Derivatives of two components over a part.
pub(super) struct Derivatives;

impl Derivatives {
    /// Returns the means of one component's derivatives by s and by t.
    #[inline(always)]
    pub(super) fn means(net: &Net) -> [f64; 2] {
        let by_s = (0..SIDE).map(|j| net[DEGREE][j] - net[0][j]).sum::<f64>() / SIDE as f64;
        let by_t = net.iter().map(|row| row[DEGREE] - row[0]).sum::<f64>() / SIDE as f64;
        [by_s, by_t]
    }

    /// Returns the means of both components as columns.
    #[inline(always)]
    pub(super) fn mean(p: &Net, q: &Net) -> DMat2 {
        let ([ps, pt], [qs, qt]) = (Self::means(p), Self::means(q));
        DMat2::from_cols(DVec2::new(ps, qs), DVec2::new(pt, qt))
    }

    /// Returns by how much Y times the derivatives differ from the unit vectors: the largest sizes of both rows, for
    /// the derivatives by s and by t.
    #[inline(always)]
    pub(super) fn changes<S: Simd>(simd: S, p: &Net, q: &Net, mean: &DMat2, inverse: &DMat2) -> [DVec2; 2] {
        let degree = DEGREE as f64;
        let (mut by_s, mut by_t) = ([f64x8::splat(simd, 0.0); 2], [f64x8::splat(simd, 0.0); 2]);
        // Row after row, so that the differences of neighbors along s fill whole vectors.
        let ((p_low, p_high), (q_low, q_high)) = (neighbors(p), neighbors(q));
        for ((p_low, p_high), (q_low, q_high)) in p_low.iter().zip(p_high).zip(q_low.iter().zip(q_high)) {
            let x = difference(simd, p_low, p_high) * degree - mean.x_axis.x;
            let y = difference(simd, q_low, q_high) * degree - mean.x_axis.y;
            raise(simd, &mut by_s, inverse, [x, y]);
        }
        for (p, q) in p.iter().zip(q) {
            let x = difference(simd, &p[..DEGREE], &p[1..]) * degree - mean.y_axis.x;
            let y = difference(simd, &q[..DEGREE], &q[1..]) * degree - mean.y_axis.y;
            raise(simd, &mut by_t, inverse, [x, y]);
        }
        [most(by_s), most(by_t)]
    }

    /// Returns the value in the middle: the mean of the coefficients, weighted by the binomial ones.
    #[inline(always)]
    pub(super) fn middle(net: &Net) -> f64 {
        const WEIGHTS: [f64; SIDE] = [1.0, 8.0, 28.0, 56.0, 70.0, 56.0, 28.0, 8.0, 1.0];
        let mut rows = [0.0; SIDE];
        for (row, weight) in net.iter().zip(WEIGHTS) {
            for (total, value) in rows.iter_mut().zip(row) {
                *total += weight * value;
            }
        }
        rows.iter().zip(WEIGHTS).map(|(value, weight)| value * weight).sum::<f64>() / 65536.0
    }
}

/// Returns all coefficients that have a neighbor along s, and these neighbors, eight by eight.
#[inline(always)]
fn neighbors(net: &Net) -> (&[[f64; DEGREE]], &[[f64; DEGREE]]) {
    let all = net.as_flattened();
    (all[..SIDE * DEGREE].as_chunks().0, all[SIDE..].as_chunks().0)
}

#[inline(always)]
fn difference<S: Simd>(simd: S, low: &[f64], high: &[f64]) -> f64x8<S> {
    f64x8::from_slice(simd, high) - f64x8::from_slice(simd, low)
}

/// Raises the largest sizes known of both rows of Y times some columns.
#[inline(always)]
fn raise<S: Simd>(simd: S, known: &mut [f64x8<S>; 2], inverse: &DMat2, [x, y]: [f64x8<S>; 2]) {
    let [first, second] = known;
    let sizes =
        [(x * inverse.x_axis.x + y * inverse.y_axis.x).abs(), (x * inverse.x_axis.y + y * inverse.y_axis.y).abs()];
    *first = simd.select_f64x8(simd.simd_gt_f64x8(sizes[0], *first), sizes[0], *first);
    *second = simd.select_f64x8(simd.simd_gt_f64x8(sizes[1], *second), sizes[1], *second);
}

/// Returns the largest number of each vector.
#[inline(always)]
fn most<S: Simd>(vectors: [f64x8<S>; 2]) -> DVec2 {
    let mut most = [0.0; 2];
    for (most, vector) in most.iter_mut().zip(vectors) {
        let mut lanes = vector.to_array();
        for half in [4, 2, 1] {
            for lane in 0..half {
                lanes[lane] = larger(lanes[lane], lanes[lane + half]);
            }
        }
        *most = lanes[0];
    }
    DVec2::from_array(most)
}
