//! Tests of sums along lines against the plain sum, and of how they are spread over a grid of frequencies.

use trochoid_sea::inside::{BEFORE, fast_length, spread, spread_kernel, sum, transform};
use trochoid_sea::{FieldSet, Fields, GerstnerSpectrum, Line, LineScratch, Lines, Sea};

/// Number of sums of each point.
const SUMS: usize = 11;

/// Returns the largest error of each sum along a line, relative to its root mean square.
fn error(sea: &Sea, time: f64, line: &Line, count: usize, wanted: FieldSet) -> f64 {
    let frame = sea.at(time);
    let (mut out, mut scratch) = (Fields::default(), LineScratch::default());
    let lines = Lines::new(&frame, count);
    transform(&lines, line, wanted, &mut scratch, &mut out);
    let (mut worst, mut squares) = ([0.0_f64; SUMS], [0.0_f64; SUMS]);
    for index in 0..count {
        let rest = [0, 1].map(|axis| line.origin[axis] + index as f64 * line.step[axis]);
        let truth = frame.evaluate(rest, line.footprint);
        let ([dx, dy, dz], [yx, yz], [xx, xz, zz]) = (truth.displacement, truth.slope, truth.strain);
        let [vx, vy, vz] = truth.velocity;
        for (sum, truth) in [dx, dy, dz, yx, yz, xx, xz, zz, vx, vy, vz].into_iter().enumerate() {
            squares[sum] += truth * truth / count as f64;
            if let Some(found) = sums(&out)[sum].get(index) {
                worst[sum] = worst[sum].max((f64::from(*found) - truth).abs());
            }
        }
        if wanted.slope_variance {
            let (found, truth) = (f64::from(out.slope_variance[index]), truth.slope_variance);
            assert!((found - truth).abs() <= 1e-5 * truth.max(1e-12), "{found} and {truth}");
        }
    }
    let relative = worst.iter().zip(squares).map(|(worst, square)| worst / square.sqrt().max(1e-30));
    relative.into_iter().fold(0.0, f64::max)
}

/// Returns the sums in the order in which [`error`] has their truth.
fn sums(fields: &Fields) -> [&Vec<f32>; SUMS] {
    let ([dx, dy, dz], [yx, yz]) = (&fields.displacement, &fields.slope);
    let ([xx, xz, zz], [vx, vy, vz]) = (&fields.strain, &fields.velocity);
    [dx, dy, dz, yx, yz, xx, xz, zz, vx, vy, vz]
}

fn sea(spectrum: GerstnerSpectrum) -> Sea {
    Sea::new(spectrum.waves().unwrap_or_else(|error| panic!("{error}")))
}

#[test]
fn lines_agree_with_the_plain_sum() {
    let usual = GerstnerSpectrum { count: 300, ..GerstnerSpectrum::default() };
    let cases = [
        (usual, 12.5, Line { origin: [3.0, -70.0], step: [0.31, 0.07], footprint: 0.4 }, 501),
        (usual, 0.0, Line { origin: [0.0, 0.0], step: [-2.0, 1.0], footprint: 3.0 }, 200),
        (usual, 1e7, Line { origin: [1e7, -1e7], step: [0.5, 0.0], footprint: 0.0 }, 333),
        (usual, 5.0, Line { origin: [0.0, 0.0], step: [0.0, 0.0], footprint: 1.0 }, 17),
        (usual, 5.0, Line { origin: [0.0, 9.0], step: [0.0, 25.0], footprint: 0.1 }, 1),
        (
            GerstnerSpectrum { count: 1, ..usual },
            3.0,
            Line { origin: [0.0, 0.0], step: [1.0, 0.2], footprint: 0.5 },
            64,
        ),
        (
            GerstnerSpectrum { wavelength: 1e-2, height: 1e-3, sharpness: 10.0, ..usual },
            100.0,
            Line { origin: [50.0, 7.0], step: [1e-3, 2e-3], footprint: 1e-3 },
            700,
        ),
        (
            GerstnerSpectrum { wavelength: 1e5, spread: 2.0, ..usual },
            1e4,
            Line { origin: [-3e6, 4e6], step: [900.0, 350.0], footprint: 700.0 },
            400,
        ),
    ];
    for (spectrum, time, line, count) in cases {
        let sea = sea(spectrum);
        for wanted in [FieldSet::ALL, FieldSet { displacement: true, ..FieldSet::default() }] {
            let error = error(&sea, time, &line, count, wanted);
            assert!(error < 1e-5, "{line:?}, {count} points: {error}");
        }
        let derivatives = FieldSet { derivatives: true, ..FieldSet::default() };
        assert!(error(&sea, time, &line, count, derivatives) < 1e-5);
    }
}

#[test]
fn both_ways_agree() {
    let sea = sea(GerstnerSpectrum { count: 400, ..GerstnerSpectrum::default() });
    let frame = sea.at(7.0);
    let line = Line { origin: [10.0, 20.0], step: [0.2, -0.1], footprint: 0.3 };
    let lines = Lines::new(&frame, 300);
    let (mut scratch, mut fast, mut slow) = (LineScratch::default(), Fields::default(), Fields::default());
    transform(&lines, &line, FieldSet::ALL, &mut scratch, &mut fast);
    sum(&lines, &line, FieldSet::ALL, &mut scratch, &mut slow);
    let rms = sea.height_rms() as f32;
    for (fast, slow) in fast.displacement.iter().flatten().zip(slow.displacement.iter().flatten()) {
        assert!((fast - slow).abs() < 1e-5 * rms, "{fast} and {slow}");
    }
}

#[test]
fn no_wave_is_a_flat_sea() {
    let frame = Sea::default().at(1.0);
    let line = Line { origin: [0.0; 2], step: [1.0, 0.0], footprint: 1.0 };
    let mut out = Fields::default();
    Lines::new(&frame, 5).evaluate(&line, FieldSet::ALL, &mut LineScratch::default(), &mut out);
    assert_eq!(out.displacement, [vec![0.0; 5], vec![0.0; 5], vec![0.0; 5]]);
}

#[test]
fn polynomials_are_the_kernel() {
    for step in 0..1000 {
        let turns = f64::from(step) / 1000.0;
        let (cells, cell, weights) = spread(50, turns);
        for (neighbor, weight) in weights.iter().enumerate() {
            let at = cell as f64 + neighbor as f64 - BEFORE as f64;
            let truth = spread_kernel(at - turns * cells as f64);
            assert!((f64::from(*weight) - truth).abs() < 3e-7, "{turns}, {neighbor}: {weight} and {truth}");
        }
    }
}

#[test]
fn lengths_are_fast_and_long_enough() {
    for length in 16..3000 {
        let fast = fast_length(length);
        assert!(fast >= length && fast < 2 * length);
        assert!(fast.is_power_of_two() || (fast / 3).is_power_of_two() && fast.is_multiple_of(3));
    }
}
