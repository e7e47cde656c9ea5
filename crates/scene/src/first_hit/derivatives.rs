//! Derivatives of the polynomials of a part, which are combinations of the differences of their coefficients.

use super::bernstein::{DEGREE, Net, SIDE, larger};
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
    pub(super) fn changes(p: &Net, q: &Net, mean: &DMat2, inverse: &DMat2) -> [DVec2; 2] {
        let (mut by_s, mut by_t) = ([[0.0_f64; DEGREE]; 2], [[0.0_f64; DEGREE]; 2]);
        let [a, b, c, d] = [inverse.x_axis.x, inverse.y_axis.x, inverse.x_axis.y, inverse.y_axis.y];
        let degree = DEGREE as f64;
        // Row after row, so that the differences of neighbors along s fill whole vectors.
        let ((p_low, p_high), (q_low, q_high)) = (neighbors(p), neighbors(q));
        for ((p_low, p_high), (q_low, q_high)) in p_low.iter().zip(p_high).zip(q_low.iter().zip(q_high)) {
            for j in 0..DEGREE {
                let x = degree * (p_high[j] - p_low[j]) - mean.x_axis.x;
                let y = degree * (q_high[j] - q_low[j]) - mean.x_axis.y;
                by_s[0][j] = larger(by_s[0][j], (a * x + b * y).abs());
                by_s[1][j] = larger(by_s[1][j], (c * x + d * y).abs());
            }
        }
        for i in 0..SIDE {
            for j in 0..DEGREE {
                let x = degree * (p[i][j + 1] - p[i][j]) - mean.y_axis.x;
                let y = degree * (q[i][j + 1] - q[i][j]) - mean.y_axis.y;
                by_t[0][j] = larger(by_t[0][j], (a * x + b * y).abs());
                by_t[1][j] = larger(by_t[1][j], (c * x + d * y).abs());
            }
        }
        [DVec2::from_array(by_s.map(largest)), DVec2::from_array(by_t.map(largest))]
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
fn largest<const N: usize>(values: [f64; N]) -> f64 {
    values.into_iter().fold(0.0, larger)
}
