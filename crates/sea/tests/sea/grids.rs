//! Tests of every method on grids against the f64 reference, on ordinary and on hostile parameters.

use crate::random::Random;
use trochoid_sea::{
    ExplicitWave, FieldSet, Fields, GerstnerSpectrum, Grid, GridError, GridPlan, Method, Sample, Sea, SeaFrame, Wave,
    attenuation,
};

fn sea(spectrum: GerstnerSpectrum) -> Sea {
    Sea::new(spectrum.waves().expect("valid knobs"))
}

fn values(sample: &Sample) -> [f64; 12] {
    let ([dx, dy, dz], [yx, yz], [xx, xz, zz]) = (sample.displacement, sample.slope, sample.strain);
    let [vx, vy, vz] = sample.velocity;
    [dx, dy, dz, yx, yz, xx, xz, zz, vx, vy, vz, sample.slope_variance]
}

fn found(fields: &Fields, index: usize) -> [f64; 12] {
    let ([dx, dy, dz], [yx, yz], [xx, xz, zz]) = (&fields.displacement, &fields.slope, &fields.strain);
    let [vx, vy, vz] = &fields.velocity;
    [dx, dy, dz, yx, yz, xx, xz, zz, vx, vy, vz, &fields.slope_variance].map(|values| f64::from(values[index]))
}

/// Returns root mean squares over independent phases of all quantities in the sums, and the lost slope variance
/// itself.
fn sizes(sea: &Sea, footprint: f64) -> [f64; 12] {
    let mut squares = [0.0; 12];
    for wave in sea.waves() {
        let (k, w, [x, z]) = (wave.wave_number(), wave.angular_frequency, wave.direction);
        let share = attenuation(k, footprint);
        let (a, h) = (wave.amplitude * share, wave.horizontal * share);
        let factors = [
            h * x,
            a,
            h * z,
            a * k * x,
            a * k * z,
            h * k * x * x,
            h * k * x * z,
            h * k * z * z,
            h * x * w,
            a * w,
            h * z * w,
        ];
        for (square, factor) in squares.iter_mut().zip(factors) {
            *square += factor * factor / 2.0;
        }
        squares[11] += (wave.steepness() * wave.steepness() / 2.0 * (1.0 - share * share)).max(1e-12);
    }
    let variance = squares[11];
    let mut sizes = squares.map(f64::sqrt);
    sizes[11] = variance;
    sizes
}

/// Returns the largest error at corners, edges, the center and random points, relative to the size of the quantity.
fn error(sea: &Sea, frame: &SeaFrame, grid: Grid, fields: &Fields) -> f64 {
    let sizes = sizes(sea, grid.footprint);
    let (columns, rows) = (grid.columns, grid.rows);
    let mut random = Random(7);
    let mut pick = |count: usize| (random.unit() * count as f64) as usize;
    let mut points: Vec<(usize, usize)> = (0..60).map(|_| (pick(columns), pick(rows))).collect();
    for column in [0, 1 % columns, columns / 2, columns - 1] {
        points.extend([0, 1 % rows, rows / 2, rows - 1].map(|row| (column, row)));
    }
    let mut worst = 0.0f64;
    for (column, row) in points {
        let rest = [grid.origin[0] + column as f64 * grid.step[0], grid.origin[1] + row as f64 * grid.step[1]];
        let exact = values(&frame.evaluate(rest, grid.footprint));
        for (quantity, found) in found(fields, row * columns + column).into_iter().enumerate() {
            let error = (found - exact[quantity]).abs();
            let error = if sizes[quantity] > 0.0 { error / sizes[quantity] } else { error };
            // NaN must count.
            worst = if error <= worst { worst } else { error };
        }
    }
    worst
}

/// Checks every method against the reference; `slack` multiplies its error where f64 itself loses the phases.
fn holds(what: &str, sea: &Sea, time: f64, grid: Grid, slack: f64) {
    let frame = sea.at(time);
    let mut fields = Fields::default();
    for method in Method::ALL {
        let mut plan = GridPlan::by(method, grid, FieldSet::ALL).expect("a legal grid");
        plan.evaluate(&frame, &mut fields);
        let error = error(sea, &frame, grid, &fields);
        println!("{what}, {method:?}: {error:e}");
        assert!(error <= method.error() * slack, "{what}, {method:?}: {error:e}");
    }
}

fn grid(columns: usize, rows: usize, step: f64) -> Grid {
    Grid { origin: [-7.0, 3.0], step: [step, step], columns, rows, footprint: 0.0 }
}

#[test]
fn methods_agree_on_grids_of_any_shape() {
    let sea = sea(GerstnerSpectrum { count: 100, sharpness: 0.8, ..GerstnerSpectrum::default() });
    for (columns, rows) in [(1, 1), (1, 37), (41, 1), (2, 3), (5, 2), (33, 47), (100, 64)] {
        holds(&format!("{columns} × {rows}"), &sea, 3.0, grid(columns, rows, 0.9), 1.0);
    }
}

#[test]
fn methods_agree_on_a_large_grid() {
    let sea = sea(GerstnerSpectrum { count: 1000, ..GerstnerSpectrum::default() });
    holds("large", &sea, 12.5, grid(1024, 700, 0.5), 1.0);
}

#[test]
fn methods_agree_far_from_the_origin_of_place_and_time() {
    let sea = sea(GerstnerSpectrum { count: 200, ..GerstnerSpectrum::default() });
    for far in [1e5, -1e7, 1e7] {
        let grid = Grid { origin: [far, -far], step: [0.7, -1.3], columns: 60, rows: 50, footprint: 0.5 };
        holds(&format!("far {far}"), &sea, far.abs(), grid, 1.0);
    }
}

#[test]
fn methods_agree_for_waves_of_any_length() {
    for (wavelength, spread) in [(1e-3, 0.3), (0.1, 0.5), (1.0, 3.0), (20.0, 2.0), (1e5, 0.5)] {
        let sea = sea(GerstnerSpectrum { count: 150, wavelength, spread, ..GerstnerSpectrum::default() });
        for step in [wavelength * 0.05, wavelength, 1.0] {
            // At a step of 1 m, waves of 1 mm are a thousand turns apart from point to point.
            holds(&format!("L {wavelength}, step {step}"), &sea, 50.0, grid(48, 40, step), 1.0);
        }
    }
    let fine = sea(GerstnerSpectrum { count: 50, wavelength: 1e-3, spread: 0.3, ..GerstnerSpectrum::default() });
    // 1e7 m are 1e10 turns, which f64 resolves only to 2e-6: 1e-5 rad in each phase.
    let far = Grid { origin: [1e7, 1e7], step: [1e-4; 2], columns: 30, rows: 30, footprint: 0.0 };
    holds("L 1e-3 at 1e7", &fine, 1e3, far, 100.0);
}

#[test]
fn waves_below_two_steps_are_exact_at_every_point_or_attenuated() {
    let sea = sea(GerstnerSpectrum { count: 120, wavelength: 3.0, spread: 0.2, ..GerstnerSpectrum::default() });
    for footprint in [0.0, 1.0, 4.0, 1e3] {
        let grid = Grid { origin: [5.0, 6.0], step: [5.0, 4.0], columns: 40, rows: 33, footprint };
        let frame = sea.at(1.0);
        let mut fields = Fields::default();
        for method in Method::ALL {
            GridPlan::by(method, grid, FieldSet::ALL).expect("legal").evaluate(&frame, &mut fields);
            // Compared with the whole waves, since waves below 1e-6 of their size are left out.
            let whole = sizes(&sea, 0.0)[1];
            for index in [0, 500, 40 * 33 - 1] {
                let rest = [5.0 + 5.0 * (index % 40) as f64, 6.0 + 4.0 * (index / 40) as f64];
                let exact = frame.evaluate(rest, footprint).displacement[1];
                let off = (f64::from(fields.displacement[1][index]) - exact).abs() / whole;
                assert!(off < method.error() + 1e-6, "{method:?}, footprint {footprint}: {off:e}");
            }
        }
    }
}

#[test]
fn methods_agree_for_extreme_sharpness_and_few_waves() {
    for count in [1, 2, 3] {
        let sea = sea(GerstnerSpectrum { count, sharpness: 10.0, spread: 0.0, ..GerstnerSpectrum::default() });
        holds(&format!("{count} waves"), &sea, 1e7, grid(31, 64, 0.5), 1.0);
    }
    // Along the axes and against them, at rest, and at exactly two steps per wave.
    for degrees in [0.0, 90.0, 180.0, 270.0f64] {
        let wave = ExplicitWave {
            wavelength: 2.0,
            amplitude: 1.0,
            direction: degrees.to_radians(),
            sharpness: 10.0,
            phase: 0.4,
            speed: Some(0.0),
        };
        let sea = Sea::new(vec![Wave::try_from(wave).expect("valid")]);
        for step in [1.0, 2.0, 0.3] {
            let frame = sea.at(9.0);
            let mut fields = Fields::default();
            for method in Method::ALL {
                let grid = grid(20, 21, step);
                GridPlan::by(method, grid, FieldSet::ALL).expect("legal").evaluate(&frame, &mut fields);
                for index in [0, 19, 210, 419] {
                    let rest = [-7.0 + step * (index % 20) as f64, 3.0 + step * (index / 20) as f64];
                    let exact = frame.evaluate(rest, 0.0).displacement[1];
                    let off = (f64::from(fields.displacement[1][index]) - exact).abs();
                    assert!(off < method.error(), "{method:?} at {degrees}°, step {step}: {off:e}");
                }
            }
        }
    }
}

#[test]
fn a_hundred_thousand_waves_agree() {
    let sea = sea(GerstnerSpectrum { count: 100_000, spread: 1.0, ..GerstnerSpectrum::default() });
    let frame = sea.at(77.0);
    let grid = grid(128, 96, 0.4);
    let mut fields = Fields::default();
    for method in [Method::Single, Method::Double] {
        GridPlan::by(method, grid, FieldSet::ALL).expect("legal").evaluate(&frame, &mut fields);
        let error = error(&sea, &frame, grid, &fields);
        assert!(error <= method.error(), "{method:?}: {error:e}");
    }
}

#[test]
fn no_waves_are_flat_and_no_points_are_no_values() {
    let mut fields = Fields::default();
    for method in Method::ALL {
        let mut plan = GridPlan::by(method, grid(3, 2, 1.0), FieldSet::ALL).expect("legal");
        plan.evaluate(&Sea::default().at(1.0), &mut fields);
        assert_eq!(fields.velocity[2], [0.0; 6]);
        let sea = sea(GerstnerSpectrum { count: 5, ..GerstnerSpectrum::default() });
        for (columns, rows) in [(0, 3), (3, 0)] {
            let mut plan = GridPlan::by(method, grid(columns, rows, 1.0), FieldSet::ALL).expect("legal");
            plan.evaluate(&sea.at(0.0), &mut fields);
            assert!(fields.displacement[0].is_empty());
        }
        // A plan still works after a sea without waves.
        let mut plan = GridPlan::by(method, grid(8, 8, 1.0), FieldSet::ALL).expect("legal");
        let mut first = Fields::default();
        plan.evaluate(&sea.at(2.0), &mut first);
        plan.evaluate(&Sea::default().at(1.0), &mut fields);
        plan.evaluate(&sea.at(2.0), &mut fields);
        assert_eq!(first, fields);
    }
}

#[test]
fn only_what_is_wanted_is_there_and_it_does_not_change() {
    let sea = sea(GerstnerSpectrum { count: 80, ..GerstnerSpectrum::default() });
    let (frame, grid) = (sea.at(2.0), grid(35, 27, 0.6));
    let (mut all, mut some) = (Fields::default(), Fields::default());
    for method in Method::ALL {
        GridPlan::by(method, grid, FieldSet::ALL).expect("legal").evaluate(&frame, &mut all);
        for kinds in 0..8 {
            let [displacement, derivatives, velocity] = [1, 2, 4].map(|kind| kinds & kind != 0);
            let wanted = FieldSet { displacement, derivatives, velocity, slope_variance: false };
            GridPlan::by(method, grid, wanted).expect("legal").evaluate(&frame, &mut some);
            let same = |wanted: bool, all: &[Vec<f32>], some: &[Vec<f32>]| {
                if wanted { all == some } else { some.iter().all(Vec::is_empty) }
            };
            assert!(same(displacement, &all.displacement, &some.displacement), "{method:?}, {kinds}");
            assert!(same(derivatives, &all.slope, &some.slope), "{method:?}, {kinds}");
            assert!(same(derivatives, &all.strain, &some.strain), "{method:?}, {kinds}");
            assert!(same(velocity, &all.velocity, &some.velocity), "{method:?}, {kinds}");
            assert!(some.slope_variance.is_empty());
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let sea = sea(GerstnerSpectrum { count: 300, spread: 1.0, ..GerstnerSpectrum::default() });
    let (frame, grid) = (sea.at(8.0), grid(130, 77, 0.5));
    for method in Method::ALL {
        let results = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let mut fields = Fields::default();
            pool.install(|| GridPlan::by(method, grid, FieldSet::ALL).expect("legal").evaluate(&frame, &mut fields));
            fields
        });
        assert!(results[0] == results[1] && results[0] == results[2], "{method:?}");
    }
}

#[test]
fn the_cheapest_method_within_the_tolerance_is_chosen() {
    let wanted = FieldSet { displacement: true, ..FieldSet::default() };
    let method = |columns: usize, waves: usize, tolerance: f64| {
        GridPlan::new(grid(columns, columns, 1.0), wanted, waves, tolerance).expect("legal").method()
    };
    assert_eq!(method(1024, 1000, 5e-4), Method::Single);
    assert_eq!(method(1024, 1000, 1e-6), Method::Double);
    assert_eq!(method(1024, 1000, 0.0), Method::Double);
    assert_eq!(method(1024, 3, 5e-4), Method::Separable);
    assert_eq!(method(1, 1000, 5e-4), Method::Direct);
    for waves in [1, 30, 1000, 100_000] {
        for columns in [1, 16, 300, 2000] {
            let found = method(columns, waves, 3e-5);
            assert!(found.error() <= 3e-5);
        }
    }
}

#[test]
fn grids_that_cannot_be_are_refused() {
    let refused = |grid: Grid| GridPlan::new(grid, FieldSet::ALL, 10, 1e-4).map(|_| ()).expect_err("refused");
    assert_eq!(refused(grid(usize::MAX, 2, 1.0)), GridError::Size(usize::MAX, 2));
    assert_eq!(refused(grid(1 << 21, 1, 1.0)), GridError::Size(1 << 21, 1));
    assert!(matches!(refused(grid(2, 2, f64::NAN)), GridError::Meters("step", _)));
    assert!(matches!(refused(Grid { footprint: -1.0, ..grid(2, 2, 1.0) }), GridError::Meters("footprint", _)));
    assert!(refused(Grid { origin: [f64::INFINITY, 0.0], ..grid(2, 2, 1.0) }).to_string().contains("origin"));
}

#[test]
fn sums_stop_when_they_are_told_to() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let sea = sea(GerstnerSpectrum { count: 30, ..GerstnerSpectrum::default() });
    let wanted = FieldSet { displacement: true, ..FieldSet::default() };
    let grid = grid(20, 300, 0.9);
    for method in [Method::Direct, Method::Separable] {
        let mut plan = GridPlan::by(method, grid, wanted).expect("a legal grid");
        let (mut whole, mut stopped) = (Fields::default(), Fields::default());
        plan.evaluate(&sea.at(1.0), &mut whole);
        let asked = AtomicUsize::new(0);
        plan.evaluate_unless(&sea.at(1.0), &mut stopped, &|| asked.fetch_add(1, Ordering::Relaxed) >= 10);
        let filled = |fields: &Fields| fields.displacement[1].iter().filter(|height| **height != 0.0).count();
        assert_eq!(filled(&whole), 20 * 300, "{method:?}");
        assert!(filled(&stopped) <= 20 * 10, "{method:?}: {} of {}", filled(&stopped), filled(&whole));
    }
}
