//! The bases in which Lm is diagonal: cosines, sines, and for the periodic basin cas = cos + sin (Hartley).

use std::sync::Arc;

use rayon::prelude::*;
use rustdct::algorithm::{Dst1ConvertToFft, Type2And3ConvertToFft};
use rustdct::rustfft::num_complex::Complex;
use rustdct::rustfft::{Fft, FftPlannerScalar};
use rustdct::{Dct2, Dct3, Dst1, RequiredScratch};

use super::{Basin, Boundary};

/// Side of the square blocks in which a field is transposed.
const BLOCK: usize = 16;
/// Number of rows that one task transforms.
const ROWS: usize = 16;

/// Transforms of a basin's fields. Coefficients are stored column by column: the field's rows are transformed,
/// transposed, and transformed again, but not transposed back.
///
/// Only scalar transforms are used: the processor's vector instructions must not change a bit.
#[derive(Clone)]
pub(crate) struct Modes {
    basin: Basin,
    along_x: Axis,
    along_z: Axis,
}

/// The transform along one axis.
#[derive(Clone)]
enum Axis {
    Cosine(Arc<Type2And3ConvertToFft<f32>>),
    Sine(Arc<Dst1ConvertToFft<f32>>),
    Hartley(Arc<dyn Fft<f32>>),
}

/// Scratch buffers of one thread.
#[derive(Default)]
struct Scratch {
    real: Vec<f32>,
    complex: Vec<Complex<f32>>,
    inner: Vec<Complex<f32>>,
}

impl Axis {
    fn new(boundary: Boundary, n: usize, planner: &mut FftPlannerScalar<f32>) -> Self {
        match boundary {
            Boundary::Replicate => Self::Cosine(Arc::new(Type2And3ConvertToFft::new(planner.plan_fft_forward(n)))),
            Boundary::Fixed => Self::Sine(Arc::new(Dst1ConvertToFft::new(planner.plan_fft_forward(2 * (n + 1))))),
            Boundary::Periodic => Self::Hartley(planner.plan_fft_forward(n)),
        }
    }

    /// Returns the factor that makes `backward(forward(row))` equal to the row.
    fn scale(&self, n: usize) -> f64 {
        match self {
            Self::Cosine(_) => 2.0 / n as f64,
            Self::Sine(_) => 2.0 / (n + 1) as f64,
            Self::Hartley(_) => 1.0 / n as f64,
        }
    }

    fn run(&self, row: &mut [f32], forward: bool, scratch: &mut Scratch) {
        match self {
            Self::Cosine(transform) => {
                scratch.real.resize(transform.get_scratch_len(), 0.0);
                if forward {
                    transform.process_dct2_with_scratch(row, &mut scratch.real);
                } else {
                    transform.process_dct3_with_scratch(row, &mut scratch.real);
                }
            }
            Self::Sine(transform) => {
                scratch.real.resize(transform.get_scratch_len(), 0.0);
                transform.process_dst1_with_scratch(row, &mut scratch.real);
            }
            Self::Hartley(fft) => {
                scratch.complex.clear();
                scratch.complex.extend(row.iter().map(|&value| Complex::new(value, 0.0)));
                scratch.inner.resize(fft.get_inplace_scratch_len(), Complex::default());
                fft.process_with_scratch(&mut scratch.complex, &mut scratch.inner);
                for (value, coefficient) in row.iter_mut().zip(&scratch.complex) {
                    *value = coefficient.re - coefficient.im;
                }
            }
        }
    }

    fn rows(&self, values: &mut [f32], n: usize, forward: bool) {
        values.par_chunks_mut(n * ROWS).for_each_init(Scratch::default, |scratch, rows| {
            rows.chunks_exact_mut(n).for_each(|row| self.run(row, forward, scratch));
        });
    }
}

impl Modes {
    pub(crate) fn new(basin: &Basin) -> Self {
        let mut planner = FftPlannerScalar::new();
        Self {
            basin: *basin,
            along_x: Axis::new(basin.boundary, basin.columns, &mut planner),
            along_z: Axis::new(basin.boundary, basin.rows, &mut planner),
        }
    }

    /// Returns 1 − λ of every coefficient, in storage order.
    pub(crate) fn gap(&self) -> impl Fn(usize) -> f64 + Sync + use<> {
        let (x, z) = (self.basin.axis_gaps(self.basin.columns), self.basin.axis_gaps(self.basin.rows));
        let rows = self.basin.rows;
        move |index| (x[index / rows] + z[index % rows]) / 2.0
    }

    /// Computes the coefficients of a field, which is overwritten.
    pub(crate) fn forward(&self, field: &mut [f32], coefficients: &mut Vec<f32>) {
        let Basin { columns, rows, .. } = self.basin;
        self.along_x.rows(field, columns, true);
        coefficients.resize(field.len(), 0.0);
        turn(field, coefficients, columns, rows);
        self.along_z.rows(coefficients, rows, true);
        let scale = (self.along_x.scale(columns) * self.along_z.scale(rows)) as f32;
        coefficients.par_iter_mut().with_min_len(1 << 14).for_each(|value| *value *= scale);
    }

    /// Computes the field of coefficients, which are overwritten.
    pub(crate) fn backward(&self, coefficients: &mut [f32], field: &mut Vec<f32>) {
        let Basin { columns, rows, .. } = self.basin;
        self.along_z.rows(coefficients, rows, false);
        field.resize(coefficients.len(), 0.0);
        turn(coefficients, field, rows, columns);
        self.along_x.rows(field, columns, false);
    }
}

/// Transposes rows to columns: `from` has `columns` values in each of its rows.
fn turn(from: &[f32], to: &mut [f32], columns: usize, rows: usize) {
    to.par_chunks_mut(rows * BLOCK).enumerate().for_each(|(block, to)| {
        let first = block * BLOCK;
        for start in (0..rows).step_by(BLOCK) {
            for row in start..(start + BLOCK).min(rows) {
                let values = &from[row * columns + first..row * columns + (first + BLOCK).min(columns)];
                for (index, &value) in values.iter().enumerate() {
                    to[index * rows + row] = value;
                }
            }
        }
    });
}
