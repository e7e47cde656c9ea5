use std::f64::consts::PI;
use trochoid_key::content_key;

use super::error::within;
use super::{ToonError, ToonParameter};

/// Most cells of a basin.
const MAX_CELLS: f64 = (1 << 26) as f64;

/// Behavior at the edges of a basin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// The cells of the edge again: waves are reflected.
    #[default]
    Replicate,
    /// The opposite edge.
    Periodic,
    /// Water at rest: waves are reflected upside down.
    Fixed,
}

content_key!(
    enum Boundary {
        Replicate,
        Periodic,
        Fixed,
    }
);

/// A grid of cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basin {
    /// Number of cells along x.
    pub columns: usize,
    /// Number of cells along z.
    pub rows: usize,
    /// Distance between neighboring cells, in meters.
    pub spacing: f64,
    /// Behavior at the edges.
    pub boundary: Boundary,
}

content_key!(Basin { columns, rows, spacing, boundary });

impl Basin {
    /// Returns the number of cells.
    pub fn cells(&self) -> usize {
        self.columns * self.rows
    }

    pub(crate) fn validate(&self) -> Result<(), ToonError> {
        let side = (2.0, 16_384.0);
        within(ToonParameter::Columns, self.columns as f64, side, "2 to 16384 cells")?;
        within(ToonParameter::Rows, self.rows as f64, side, "2 to 16384 cells")?;
        within(ToonParameter::Cells, self.columns as f64 * self.rows as f64, (4.0, MAX_CELLS), "at most 2²⁶ cells")?;
        within(ToonParameter::Spacing, self.spacing, (1e-6, 1e6), "1e-6 to 1e6 meters")
    }

    /// Returns the angle of the kth basis function along an axis of n cells: the mean of a cell's two neighbors
    /// multiplies the function by the cosine of the angle.
    pub(crate) fn angle(&self, k: usize, n: usize) -> f64 {
        match self.boundary {
            Boundary::Replicate => PI * k as f64 / n as f64,
            // The functions of k and n − k share a cosine.
            Boundary::Periodic => 2.0 * PI * k.min(n - k) as f64 / n as f64,
            Boundary::Fixed => PI * (k + 1) as f64 / (n + 1) as f64,
        }
    }

    /// Returns 1 − λ for the least and greatest eigenvalue λ of Lm, without cancellation.
    pub(crate) fn gaps(&self) -> [f64; 2] {
        let axis = |n: usize| {
            let gaps = (0..n).map(|k| gap(self.angle(k, n)));
            gaps.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], gap| [low.min(gap), high.max(gap)])
        };
        let (x, z) = (axis(self.columns), axis(self.rows));
        [(x[0] + z[0]) / 2.0, (x[1] + z[1]) / 2.0]
    }

    /// Returns 1 − λ of each basis function along an axis of n cells.
    pub(crate) fn axis_gaps(&self, n: usize) -> Vec<f64> {
        (0..n).map(|k| gap(self.angle(k, n))).collect()
    }
}

/// Returns 1 − cos of an angle, without cancellation.
fn gap(angle: f64) -> f64 {
    let sine = libm::sin(angle / 2.0);
    2.0 * sine * sine
}
