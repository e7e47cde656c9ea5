use crate::fields::FieldSet;
use crate::spread::Kernel;

/// How the sum of waves is evaluated on a regular grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// [`SeaFrame::direct`](crate::SeaFrame::direct) at every point.
    Direct,
    /// exp(iθ) as a factor per column times a factor per row.
    Separable,
    /// Non-uniform Fourier transform in f32: eight lines per wave, oversampling 1.5.
    Single,
    /// Non-uniform Fourier transform in f64: fourteen lines per wave, oversampling 1.25.
    Double,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 4] = [Self::Direct, Self::Separable, Self::Single, Self::Double];

    /// Returns the largest error at any point of a grid, relative to the root mean square that the quantity has for
    /// independent phases, not including the rounding of the result itself to f32.
    ///
    /// It holds as long as f64 resolves the phases: up to 1e9 turns from the origin of space and time. The measured
    /// errors are 4e-6, 9e-6, 1.5e-4 (for 100,000 waves; 2e-5 for 1000) and 2e-7.
    pub fn error(self) -> f64 {
        match self {
            Self::Direct | Self::Separable => 2e-5,
            Self::Single => 3e-4,
            Self::Double => 1e-6,
        }
    }

    pub(crate) fn kernel(self) -> Option<Kernel> {
        match self {
            Self::Direct | Self::Separable => None,
            // f32 rounds relative to the center of the grid: at its corners, which the kernel attenuates most, errors
            // grow by the square of that attenuation: 50 at 1.5 and 5e5 at 1.25.
            Self::Single => Some(Kernel::new(8, 1.5)),
            Self::Double => Some(Kernel::new(14, 1.25)),
        }
    }

    /// Returns the cost of a grid in nanoseconds of one core, from a table that is the same on every machine.
    fn cost(self, [columns, rows]: [usize; 2], sums: usize, waves: usize) -> f64 {
        let (points, sums, waves) = (columns as f64 * rows as f64, sums as f64, waves as f64);
        // Sixteen neighbors of a row are evaluated at once.
        let padded = columns.next_multiple_of(16) as f64;
        match self {
            Self::Direct => padded * rows as f64 * waves * (0.42 + 0.035 * sums),
            Self::Separable => waves * (padded * rows as f64 * (0.13 + 0.018 * sums) + 4.0 * padded),
            Self::Single => points * sums * 3.5 + waves * (200.0 + 70.0 * sums) + 2e4 + 3e4 * sums,
            Self::Double => points * sums * 4.5 + waves * (500.0 + 250.0 * sums) + 2e4 + 4e4 * sums,
        }
    }

    /// Returns the cheapest method whose error is at most `tolerance`, or the most exact one.
    pub(crate) fn cheapest(sides: [usize; 2], wanted: FieldSet, waves: usize, tolerance: f64) -> Self {
        let sums = wanted.sums().into_iter().filter(|&wanted| wanted).count();
        let cost = |method: &Self| method.cost(sides, sums, waves);
        let exact = Self::ALL.into_iter().filter(|method| method.error() <= tolerance);
        exact.min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(Self::Double)
    }
}
