use crate::fields::{FieldSet, Fields, Points};
use crate::frame::{CUT, SeaFrame};
use crate::grid::{Grid, GridError};
use crate::method::Method;
use crate::nufft::Nufft;
use rayon::prelude::*;

/// Evaluation of seas on one grid: everything that does not depend on the sea or the time is computed once, and
/// buffers are kept.
///
/// Points, wave numbers and times may be as large as f64 resolves: phases are reduced to one turn in f64. Waves that
/// are shorter than two steps are exact at every point; the grid's footprint attenuates them, according to the
/// crate's filter. Results do not depend on the number of threads.
///
/// ```
/// use trochoid_sea::{FieldSet, Fields, GerstnerSpectrum, Grid, GridPlan, Sea};
///
/// let sea = Sea::new(GerstnerSpectrum { count: 200, ..GerstnerSpectrum::default() }.waves()?);
/// let grid = Grid { origin: [0.0; 2], step: [0.5; 2], columns: 64, rows: 64, footprint: 0.5 };
/// let wanted = FieldSet { displacement: true, ..FieldSet::default() };
/// let mut plan = GridPlan::new(grid, wanted, sea.waves().len(), 1e-4)?;
/// let mut fields = Fields::default();
/// for frame in 0..3 {
///     plan.evaluate(&sea.at(f64::from(frame) / 24.0), &mut fields);
/// }
/// assert_eq!(fields.displacement[1].len(), 64 * 64);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct GridPlan {
    grid: Grid,
    wanted: FieldSet,
    method: Method,
    transform: Transform,
}

/// State that a method keeps.
enum Transform {
    None,
    Single(Box<Nufft<f32>>),
    Double(Box<Nufft<f64>>),
}

impl GridPlan {
    /// Makes a plan that evaluates seas of about `waves` waves by the cheapest method whose [error](Method::error) is
    /// at most `tolerance`, or by the most exact one if there is none.
    ///
    /// # Errors
    /// The grid has too many points, or a number that is not finite.
    pub fn new(grid: Grid, wanted: FieldSet, waves: usize, tolerance: f64) -> Result<Self, GridError> {
        grid.validate()?;
        Ok(Self::build(grid, wanted, Method::cheapest([grid.columns, grid.rows], wanted, waves, tolerance)))
    }

    /// Makes a plan that evaluates by this method.
    ///
    /// # Errors
    /// The grid has too many points, or a number that is not finite.
    pub fn by(method: Method, grid: Grid, wanted: FieldSet) -> Result<Self, GridError> {
        grid.validate()?;
        Ok(Self::build(grid, wanted, method))
    }

    fn build(grid: Grid, wanted: FieldSet, method: Method) -> Self {
        let Grid { columns, rows, .. } = grid;
        let transform = match method.kernel() {
            None => Transform::None,
            Some(kernel) if method == Method::Single => Transform::Single(Box::new(Nufft::new(columns, rows, kernel))),
            Some(kernel) => Transform::Double(Box::new(Nufft::new(columns, rows, kernel))),
        };
        Self { grid, wanted, method, transform }
    }

    /// Returns the method in use.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Computes the wanted quantities at every point of the grid, row by row.
    pub fn evaluate(&mut self, frame: &SeaFrame, out: &mut Fields) {
        self.evaluate_unless(frame, out, &|| false);
    }

    /// Does the same, but asks about once per row whether to stop; if so, the result is useless.
    pub fn evaluate_unless(&mut self, frame: &SeaFrame, out: &mut Fields, stop: &(dyn Fn() -> bool + Sync)) {
        let (grid, wanted) = (self.grid, self.wanted);
        out.reset(wanted, grid.columns * grid.rows);
        if frame.is_empty() || grid.columns * grid.rows == 0 {
            return;
        }
        if wanted.slope_variance {
            // The footprint is the same everywhere.
            let point = Points { x: &[0.0], z: &[0.0], footprint: &[grid.footprint] };
            let mut lost = Fields::default();
            frame.direct(point, FieldSet { slope_variance: true, ..FieldSet::default() }, &mut lost);
            out.slope_variance.fill(lost.slope_variance[0]);
        }
        let footprint2 = grid.footprint * grid.footprint;
        let exponents = frame.filters.iter().map(|&filter| f64::from(filter) * footprint2);
        let shares: Vec<f32> =
            exponents.take_while(|&exponent| exponent <= CUT).map(|exponent| libm::exp(-exponent) as f32).collect();
        if shares.is_empty() || wanted.sums().iter().all(|wanted| !wanted) {
            return;
        }
        match &mut self.transform {
            Transform::Single(transform) => transform.evaluate(frame, grid, &shares, out, stop),
            Transform::Double(transform) => transform.evaluate(frame, grid, &shares, out, stop),
            Transform::None if self.method == Method::Separable => frame.separable(grid, &shares, wanted, out, stop),
            Transform::None => direct(frame, grid, wanted, out, stop),
        }
    }
}

/// Evaluates row by row, by the sum for any points.
fn direct(frame: &SeaFrame, grid: Grid, wanted: FieldSet, out: &mut Fields, stop: &(dyn Fn() -> bool + Sync)) {
    let wanted = FieldSet { slope_variance: false, ..wanted };
    let x: Vec<f64> = (0..grid.columns).map(|column| grid.origin[0] + column as f64 * grid.step[0]).collect();
    let footprint = vec![grid.footprint; grid.columns];
    let row = |row: usize| {
        if stop() {
            return None;
        }
        let z = vec![grid.origin[1] + row as f64 * grid.step[1]; grid.columns];
        let mut fields = Fields::default();
        frame.direct(Points { x: &x, z: &z, footprint: &footprint }, wanted, &mut fields);
        Some(fields)
    };
    let rows: Vec<usize> = (0..grid.rows).collect();
    // A few rows at a time, so that they take little memory beside the result.
    for rows in rows.chunks(64) {
        let results: Option<Vec<Fields>> = rows.par_iter().map(|&index| row(index)).collect();
        let Some(results) = results else { return };
        for (mut fields, &row) in results.into_iter().zip(rows) {
            for (out, values) in out.sums_mut().into_iter().zip(fields.sums_mut()) {
                if !out.is_empty() {
                    out[row * grid.columns..][..grid.columns].copy_from_slice(values);
                }
            }
        }
    }
}
