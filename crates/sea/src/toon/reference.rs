//! The definition of a toon sea in f64 and plain loops: every cell, every burst, every step, every mode.

use std::f64::consts::PI;

use super::propagator::{Transfer, transfer};
use super::spline::Spline;
use super::{Basin, Boundary, Burst, Combine, LITERAL_HZ, Mixing, Motion, Shape, ToonSea, TrailFields};

/// All fields of a sea at one time, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Heights, in meters.
    pub height: Vec<f64>,
    /// The rift.
    pub rift: Vec<f64>,
    /// Weight of the drift coordinates, and its products with cosine and sine of the angle along the path and of the
    /// angle across.
    pub drift: [Vec<f64>; 5],
}

/// Returns the fields at a time, from rest, without any jump; fields that are not wanted are 0.
///
/// Costs cells × (columns + rows) + cells × bursts for each step, so it suits only small seas.
pub fn frame(sea: &ToonSea, time: f64, wanted: TrailFields) -> Reference {
    let cells = sea.basin.cells();
    let zero = || vec![0.0; cells];
    let mut state = Reference { height: zero(), rift: zero(), drift: std::array::from_fn(|_| zero()) };
    // h₋, or the velocity.
    let mut other = zero();
    let (last, part) = sea.step_at(time);
    let stretch =
        |seconds: f64| Interval { sea, seconds, wanted, advance: Advance::new(&sea.motion, &sea.basin, seconds) };
    let whole = stretch(1.0 / sea.motion.rate());
    for step in 1..=last {
        whole.pass(sea.time_of(step), &mut state, &mut other);
    }
    if part > 0.0 {
        stretch(part).pass(time, &mut state, &mut other);
    }
    state
}

/// An interval of time, in seconds.
struct Interval<'a> {
    sea: &'a ToonSea,
    seconds: f64,
    wanted: TrailFields,
    advance: Advance,
}

/// A burst at one time.
struct ActiveBurst<'a> {
    burst: &'a Burst,
    center: [f64; 2],
    /// Cosine and sine of its heading.
    heading: [f64; 2],
    /// Share of the height that the fade leaves.
    left: f64,
    /// Turns of its drift lines.
    turns: f64,
    /// Distance from its center within which it has any effect.
    reach: f64,
}

impl<'a> ActiveBurst<'a> {
    /// Returns the bursts that are active.
    fn all(sea: &'a ToonSea, time: f64) -> Vec<Self> {
        let passing = |burst: &'a Burst| {
            let spline = Spline(burst.path);
            let (lap, progress) = burst.progress(time);
            let (rift, drift) = (sea.behavior.rift, sea.behavior.drift);
            let (radii, _) = burst.profile(sea.behavior.shape);
            let farthest = |[a, b]: [f64; 2]| a.max(b);
            let raised = match sea.behavior.shape {
                Shape::Intended => burst.peak * farthest(burst.influence),
                Shape::Literal => f64::INFINITY,
            };
            let drawn = farthest([radii[0] * drift.reach[0], radii[1] * drift.reach[1]]);
            Self {
                burst,
                center: spline.point(progress),
                heading: spline.heading(progress),
                left: burst.left(progress),
                turns: drift.along(lap, progress, &spline.lengths()),
                // Rounding must not cut off values that are nearly 0.
                reach: (1.0 + 1e-9) * raised.max(drawn).max(rift.distance),
            }
        };
        sea.bursts.iter().filter(|burst| burst.is_active(time)).map(passing).collect()
    }

    /// Returns whether it may have an effect at a position.
    fn reaches(&self, [x, z]: [f64; 2]) -> bool {
        let (dx, dz) = (x - self.center[0], z - self.center[1]);
        dx * dx + dz * dz <= self.reach * self.reach
    }
}

impl Interval<'_> {
    /// Lets the interval pass, under the bursts at its end.
    fn pass(&self, time: f64, state: &mut Reference, other: &mut Vec<f64>) {
        let Self { sea, seconds, wanted, .. } = *self;
        let Basin { columns, rows, spacing, .. } = sea.basin;
        let bursts = ActiveBurst::all(sea, time);
        let mut force = vec![0.0; columns * rows];
        for row in 0..rows {
            for column in 0..columns {
                let cell = row * columns + column;
                let place = [column as f64 * spacing, row as f64 * spacing];
                force[cell] = sea.injection()
                    * bursts
                        .iter()
                        .filter(|burst| burst.reaches(place))
                        .map(|burst| profile(sea, burst, place))
                        .sum::<f64>();
                if wanted.rift || wanted.drift {
                    trails(sea, &bursts, seconds, place, cell, state);
                }
            }
        }
        self.advance.step(&force, &mut state.height, other);
    }
}

/// The change of heights over an interval, without bursts: in cells if it is the literal step, else in modes.
pub(crate) struct Advance {
    basin: Basin,
    method: AdvanceMethod,
}

enum AdvanceMethod {
    Cells(Mixing),
    Modes(Basis, Vec<Transfer>),
}

impl Advance {
    pub(crate) fn new(motion: &Motion, basin: &Basin, seconds: f64) -> Self {
        let method = match motion {
            Motion::Literal(mixing) => AdvanceMethod::Cells(*mixing),
            _ => {
                let basis = Basis::new(basin);
                let gap =
                    |cell: usize| (basis.gaps[0][cell % basin.columns] + basis.gaps[1][cell / basin.columns]) / 2.0;
                let transfers = (0..basin.cells()).map(|cell| transfer(motion, basin.spacing, gap(cell), seconds));
                let transfers = transfers.collect();
                AdvanceMethod::Modes(basis, transfers)
            }
        };
        Self { basin: *basin, method }
    }

    /// Advances heights, and h₋ or the velocity, over the interval under a constant force.
    pub(crate) fn step(&self, force: &[f64], height: &mut Vec<f64>, other: &mut Vec<f64>) {
        match &self.method {
            AdvanceMethod::Cells(mixing) => {
                let next = (0..self.basin.cells())
                    .map(|cell| {
                        let mean = mean(&self.basin, height, cell);
                        mixing.c1 * (2.0 * mean - other[cell]) + mixing.c2 * height[cell] + force[cell]
                    })
                    .collect();
                *other = std::mem::replace(height, next);
            }
            AdvanceMethod::Modes(basis, transfers) => {
                let (mut a, mut b) = (basis.forward(height), basis.forward(other));
                let f = basis.forward(force);
                for (cell, m) in transfers.iter().enumerate() {
                    (a[cell], b[cell]) = (
                        m[0] * a[cell] + m[1] * b[cell] + m[4] * f[cell],
                        m[2] * a[cell] + m[3] * b[cell] + m[5] * f[cell],
                    );
                }
                *height = basis.backward(&a);
                *other = basis.backward(&b);
            }
        }
    }
}

/// Returns the mean of the four neighbors.
fn mean(basin: &Basin, h: &[f64], cell: usize) -> f64 {
    let (columns, rows) = (basin.columns as i64, basin.rows as i64);
    let (x, z) = (cell as i64 % columns, cell as i64 / columns);
    let at = |x: i64, z: i64| match basin.boundary {
        Boundary::Replicate => h[(z.clamp(0, rows - 1) * columns + x.clamp(0, columns - 1)) as usize],
        Boundary::Periodic => h[(z.rem_euclid(rows) * columns + x.rem_euclid(columns)) as usize],
        Boundary::Fixed if x < 0 || z < 0 || x >= columns || z >= rows => 0.0,
        Boundary::Fixed => h[(z * columns + x) as usize],
    };
    (at(x - 1, z) + at(x + 1, z) + at(x, z - 1) + at(x, z + 1)) / 4.0
}

/// Returns a position relative to a burst, along its heading and across it if it is oriented.
fn local(passing: &ActiveBurst<'_>, [x, z]: [f64; 2], oriented: bool) -> [f64; 2] {
    let [cos, sin] = if oriented { passing.heading } else { [1.0, 0.0] };
    let (dx, dz) = (x - passing.center[0], z - passing.center[1]);
    [dx * cos + dz * sin, dz * cos - dx * sin]
}

fn profile(sea: &ToonSea, passing: &ActiveBurst<'_>, place: [f64; 2]) -> f64 {
    let ActiveBurst { burst, left, .. } = passing;
    let [along, across] = local(passing, place, sea.behavior.oriented);
    let distance = libm::hypot(along / burst.influence[0], across / burst.influence[1]);
    let (p, h) = (burst.peak, burst.height);
    left * match sea.behavior.shape {
        Shape::Intended => p * h / 2.0 * (libm::cos((PI * distance / p).min(PI)) + 1.0),
        Shape::Literal => h * libm::cos((p * distance).min(PI) + 1.0),
    }
}

/// Adds to the rift and the drift of one cell.
fn trails(
    sea: &ToonSea,
    bursts: &[ActiveBurst<'_>],
    seconds: f64,
    place: [f64; 2],
    cell: usize,
    state: &mut Reference,
) {
    let (rift, drift) = (sea.behavior.rift, sea.behavior.drift);
    let steps = seconds * LITERAL_HZ;
    // Σ (1+ε)⁻ʲ over j = 1…steps.
    let factors = |decay: f64| {
        let left = libm::pow(1.0 + decay, -steps);
        (left, if decay > 0.0 { (1.0 - left) / decay } else { steps })
    };
    let mut near = 0.0;
    let mut sums = [0.0; 5];
    for passing in bursts.iter().filter(|burst| burst.reaches(place)) {
        let ActiveBurst { burst, heading: [cos, sin], left, turns, .. } = passing;
        let [along, across] = local(passing, place, false);
        let inside = (rift.distance - libm::hypot(along, across)).max(0.0);
        near = match rift.combine {
            Combine::Sum => near + inside,
            Combine::Nearest => inside.max(near),
        };
        let (a, l) = (along * cos + across * sin, across * cos - along * sin);
        let (radii, _) = burst.profile(sea.behavior.shape);
        let q = libm::hypot(a / (radii[0] * drift.reach[0]), l / (radii[1] * drift.reach[1]));
        let weight = left * (1.0 - q * q).max(0.0) * (1.0 - q * q).max(0.0);
        let swept = drift.lag * libm::sqrt(l * l + drift.softness(sea.basin.spacing));
        let angle = |meters: f64, turns: f64| libm::sincos(2.0 * PI * (meters * drift.frequency() + turns));
        let ((along_sin, along_cos), (across_sin, across_cos)) = (angle(a - swept, *turns), angle(burst.lane + l, 0.0));
        for (sum, value) in sums.iter_mut().zip([1.0, along_cos, along_sin, across_cos, across_sin]) {
            *sum += weight * value;
        }
    }
    let (left, added) = factors(rift.decay);
    state.rift[cell] = state.rift[cell] * left + rift.gain * near * added;
    let (left, added) = factors(drift.decay);
    let renewed = 1.0 + drift.renewal * steps * sums[0];
    for (values, sum) in state.drift.iter_mut().zip(sums) {
        values[cell] = (values[cell] * left + sum * added) / renewed;
    }
}

/// The modes of a basin as matrices: `axes[i][k][x]` is the kth function of axis i at x, with unit norm.
struct Basis {
    size: [usize; 2],
    axes: [Vec<Vec<f64>>; 2],
    /// The same by x, then k.
    turned: [Vec<Vec<f64>>; 2],
    gaps: [Vec<f64>; 2],
}

impl Basis {
    fn new(basin: &Basin) -> Self {
        let size = [basin.columns, basin.rows];
        let axis = |n: usize| -> Vec<Vec<f64>> {
            let function = |k: usize, x: usize| match basin.boundary {
                Boundary::Replicate => libm::cos(PI * k as f64 * (x as f64 + 0.5) / n as f64),
                Boundary::Fixed => libm::sin(PI * (k + 1) as f64 * (x + 1) as f64 / (n + 1) as f64),
                Boundary::Periodic => {
                    let (sin, cos) = libm::sincos(2.0 * PI * (k * x) as f64 / n as f64);
                    cos + sin
                }
            };
            let functions = (0..n).map(|k| {
                let values: Vec<f64> = (0..n).map(|x| function(k, x)).collect();
                let norm = libm::sqrt(values.iter().map(|value| value * value).sum());
                values.iter().map(|value| value / norm).collect()
            });
            functions.collect()
        };
        let axes = size.map(axis);
        let turned = axes
            .each_ref()
            .map(|axis| (0..axis.len()).map(|x| axis.iter().map(|function| function[x]).collect()).collect());
        Self { size, axes, turned, gaps: size.map(|n| basin.axis_gaps(n)) }
    }

    fn forward(&self, field: &[f64]) -> Vec<f64> {
        self.apply(field, &self.turned)
    }

    fn backward(&self, coefficients: &[f64]) -> Vec<f64> {
        self.apply(coefficients, &self.axes)
    }

    /// Sums along both axes in a fixed order; `matrices` hold, by axis and input, the factors of each output.
    fn apply(&self, values: &[f64], matrices: &[Vec<Vec<f64>>; 2]) -> Vec<f64> {
        let [columns, rows] = self.size;
        let add = |to: &mut [f64], factors: &[f64], factor: f64| {
            to.iter_mut().zip(factors).for_each(|(to, value)| *to += value * factor);
        };
        let mut half = vec![0.0; values.len()];
        for (row, half) in half.chunks_exact_mut(columns).enumerate() {
            for x in 0..columns {
                add(half, &matrices[0][x], values[row * columns + x]);
            }
        }
        let mut full = vec![0.0; values.len()];
        for (out, full) in full.chunks_exact_mut(columns).enumerate() {
            for z in 0..rows {
                add(full, &half[z * columns..][..columns], matrices[1][z][out]);
            }
        }
        full
    }
}
