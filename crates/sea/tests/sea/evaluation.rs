//! Tests of the fast evaluations against the f64 reference, on ordinary and on extreme parameters.

use crate::random::Random;
use trochoid_sea::{
    ExplicitWave, FieldSet, Fields, GerstnerSpectrum, Points, Precise, PreciseSea, Sample, Sea, SeaFrame, Wave,
    attenuation,
};

fn sea(spectrum: GerstnerSpectrum) -> Sea {
    Sea::new(spectrum.waves().expect("valid knobs"))
}

fn values(sample: &Sample) -> [f64; 12] {
    let ([dx, dy, dz], [yx, yz], [xx, xz, zz]) = (sample.displacement, sample.slope, sample.strain);
    let [vx, vy, vz] = sample.velocity;
    [dx, dy, dz, yx, yz, xx, xz, zz, sample.slope_variance, vx, vy, vz]
}

fn fast(fields: &Fields, index: usize) -> [f64; 12] {
    let ([dx, dy, dz], [yx, yz], [xx, xz, zz]) = (&fields.displacement, &fields.slope, &fields.strain);
    let [vx, vy, vz] = &fields.velocity;
    [dx, dy, dz, yx, yz, xx, xz, zz, &fields.slope_variance, vx, vy, vz].map(|values| f64::from(values[index]))
}

/// Returns the largest root-mean-square error of a quantity, relative to the root mean square of that quantity.
fn error(frame: &SeaFrame, x: &[f64], z: &[f64], footprint: &[f64], fields: &Fields) -> f64 {
    let (mut errors, mut sizes) = ([0.0; 12], [0.0; 12]);
    for index in 0..x.len() {
        let exact = values(&frame.evaluate([x[index], z[index]], footprint[index]));
        for (quantity, value) in fast(fields, index).into_iter().enumerate() {
            errors[quantity] += (value - exact[quantity]).powi(2);
            sizes[quantity] += exact[quantity].powi(2);
        }
    }
    let ratio = |(error, size): (f64, f64)| if size > 0.0 { (error / size).sqrt() } else { error.sqrt() };
    errors.into_iter().zip(sizes).map(ratio).fold(0.0, f64::max)
}

/// Returns the error over points around `center` whose neighbors are `step` apart, with footprints up to `footprint`.
fn around(sea: &Sea, time: f64, center: f64, step: f64, footprint: f64) -> f64 {
    let frame = sea.at(time);
    let mut random = Random(42);
    let count = 200;
    let mut place = |index: usize| center + step * (index as f64 + random.unit());
    let x: Vec<f64> = (0..count).map(&mut place).collect();
    let z: Vec<f64> = (0..count).map(&mut place).collect();
    let prints: Vec<f64> = (0..count).map(|_| footprint * random.unit()).collect();
    let mut fields = Fields::default();
    let points = Points { x: &x, z: &z, footprint: &prints };
    frame.direct(points, FieldSet::ALL, &mut fields);
    let direct = error(&frame, &x, &z, &prints, &fields);
    frame.scattered(points, FieldSet::ALL, &mut fields);
    direct.max(error(&frame, &x, &z, &prints, &fields))
}

#[test]
fn direct_agrees_with_the_reference_near_and_far() {
    let sea = sea(GerstnerSpectrum { count: 300, height: 4.0, sharpness: 0.7, ..GerstnerSpectrum::default() });
    for far in [0.0, 1e5, 1e7] {
        for footprint in [0.0, 3.0, 40.0] {
            let error = around(&sea, far, far, 0.5, footprint);
            assert!(error < 2e-6, "at {far}, footprint {footprint}: {error:e}");
        }
    }
}

#[test]
fn direct_agrees_where_neighbors_lie_many_waves_apart() {
    let sea = sea(GerstnerSpectrum { count: 100, ..GerstnerSpectrum::default() });
    assert!(around(&sea, 10.0, 0.0, 1e4, 0.0) < 2e-6);
}

#[test]
fn direct_agrees_for_waves_of_any_length() {
    for (wavelength, tolerance) in [(1e-3, 2e-5), (1.0, 2e-6), (1e5, 2e-6)] {
        let sea = sea(GerstnerSpectrum { count: 100, wavelength, spread: 0.3, ..GerstnerSpectrum::default() });
        // At 1e7 m a wave of 1 mm is 1e10 turns away, which f64 resolves only to 2e-6 turns.
        let error = around(&sea, 1e3, 1e7, wavelength * 0.1, wavelength);
        assert!(error < tolerance, "wavelength {wavelength}: {error:e}");
    }
}

#[test]
fn footprints_that_hardly_vary_are_as_exact() {
    let sea = sea(GerstnerSpectrum { count: 200, ..GerstnerSpectrum::default() });
    let frame = sea.at(1.0);
    let x: Vec<f64> = (0..64).map(f64::from).collect();
    let prints: Vec<f64> = (0..64).map(|index| 6.0 * (1.0 + 1e-5 * f64::from(index))).collect();
    let mut fields = Fields::default();
    frame.direct(Points { x: &x, z: &x, footprint: &prints }, FieldSet::ALL, &mut fields);
    assert!(error(&frame, &x, &x, &prints, &fields) < 2e-6);
}

#[test]
fn scattered_points_do_not_change_each_other() {
    let sea = sea(GerstnerSpectrum { count: 150, sharpness: 0.5, ..GerstnerSpectrum::default() });
    let frame = sea.at(7.0);
    let mut random = Random(5);
    let [x, z]: [Vec<f64>; 2] = [1e6, 300.0].map(|far| (0..100).map(|_| far * (random.unit() - 0.5)).collect());
    let prints: Vec<f64> = (0..100).map(|index| [0.0, 0.5, 30.0, 1e300][index % 4] * random.unit()).collect();
    let bits = |x: &[f64], z: &[f64], footprint: &[f64]| {
        let mut fields = Fields::default();
        frame.scattered(Points { x, z, footprint }, FieldSet::ALL, &mut fields);
        (0..x.len()).map(|index| fast(&fields, index).map(f64::to_bits)).collect::<Vec<_>>()
    };
    let together = bits(&x, &z, &prints);
    for (index, together) in together.iter().enumerate() {
        let one = index..index + 1;
        assert_eq!(bits(&x[one.clone()], &z[one.clone()], &prints[one])[0], *together, "{index}");
        let from = index.saturating_sub(13);
        assert_eq!(bits(&x[from..], &z[from..], &prints[from..])[index - from], *together, "{index}");
    }
}

#[test]
fn only_what_is_wanted_is_there_and_it_does_not_change() {
    let sea = sea(GerstnerSpectrum { count: 50, ..GerstnerSpectrum::default() });
    let frame = sea.at(2.0);
    let x: Vec<f64> = (0..40).map(f64::from).collect();
    let points = Points { x: &x, z: &x, footprint: &x };
    let (mut all, mut some) = (Fields::default(), Fields::default());
    frame.direct(points, FieldSet::ALL, &mut all);
    frame.direct(points, FieldSet { displacement: true, ..FieldSet::default() }, &mut some);
    assert_eq!(all.displacement, some.displacement);
    assert!(some.slope[0].is_empty() && some.strain[2].is_empty() && some.slope_variance.is_empty());
    frame.direct(points, FieldSet { derivatives: true, ..FieldSet::default() }, &mut some);
    assert_eq!((&all.slope, &all.strain), (&some.slope, &some.strain));
    assert!(some.displacement[1].is_empty());
    frame.direct(points, FieldSet { velocity: true, ..FieldSet::default() }, &mut some);
    assert_eq!(all.velocity, some.velocity);
    assert!(some.slope[1].is_empty());
}

#[test]
fn a_sea_without_waves_is_flat() {
    let frame = Sea::default().at(5.0);
    assert_eq!(frame.evaluate([3.0, 4.0], 0.0), Sample::default());
    let mut fields = Fields::default();
    frame.direct(Points { x: &[1.0], z: &[2.0], footprint: &[0.0] }, FieldSet::ALL, &mut fields);
    assert_eq!(fast(&fields, 0), [0.0; 12]);
}

fn single(sharpness: f64) -> Sea {
    let wave = ExplicitWave { wavelength: 10.0, amplitude: 1.0, direction: 0.0, sharpness, phase: 0.0, speed: None };
    Sea::new(vec![Wave::try_from(wave).expect("valid")])
}

#[test]
fn one_wave_is_a_trochoid() {
    let frame = single(0.8).at(0.0);
    // A crest above the origin, a trough half a wave further, neither moved sideways; between them a quarter wave
    // moves by h.
    assert_eq!(frame.evaluate([0.0, 0.0], 0.0).displacement[1], 1.0);
    assert!((frame.evaluate([5.0, 9.0], 0.0).displacement[1] + 1.0).abs() < 1e-12);
    let quarter = frame.evaluate([2.5, 0.0], 0.0).displacement;
    let h = 0.8 / (std::f64::consts::TAU / 10.0);
    assert!((quarter[0] + h).abs() < 1e-12 && quarter[1].abs() < 1e-12 && quarter[2].abs() < 1e-12);
    // Sharp crests, flat troughs: compressed at the crest, stretched in the trough.
    assert!((frame.evaluate([0.0, 0.0], 0.0).jacobian() - 0.2).abs() < 1e-12);
    assert!((frame.evaluate([5.0, 0.0], 0.0).jacobian() - 1.8).abs() < 1e-12);
}

#[test]
fn sharpness_one_is_the_cusp() {
    let crest = |sharpness: f64| single(sharpness).at(0.0).evaluate([0.0, 0.0], 0.0).jacobian();
    assert!(crest(1.0).abs() < 1e-12);
    assert!(crest(0.999) > 0.0 && crest(1.001) < 0.0 && (crest(10.0) + 9.0).abs() < 1e-9);
    assert_eq!(crest(0.0), 1.0);
}

#[test]
fn waves_travel_along_their_direction() {
    let wave = ExplicitWave {
        wavelength: 10.0,
        amplitude: 1.0,
        direction: std::f64::consts::FRAC_PI_2,
        sharpness: 0.5,
        phase: 0.0,
        speed: Some(3.0),
    };
    // Azimuth ½π travels toward +Z: after one second the crest has moved by 3 m.
    let frame = Sea::new(vec![Wave::try_from(wave).expect("valid")]).at(1.0);
    assert!((frame.evaluate([0.0, 3.0], 0.0).displacement[1] - 1.0).abs() < 1e-12);
}

#[test]
fn the_velocity_is_that_of_finite_differences() {
    let sea = sea(GerstnerSpectrum { count: 30, sharpness: 0.6, ..GerstnerSpectrum::default() });
    let at = |time: f64| sea.at(time).evaluate([7.0, 8.0], 0.5);
    let (before, after) = (at(3.0 - 1e-5).displacement, at(3.0 + 1e-5).displacement);
    for (axis, exact) in at(3.0).velocity.into_iter().enumerate() {
        assert!((exact - (after[axis] - before[axis]) / 2e-5).abs() < 1e-8);
    }
}

#[test]
fn the_normal_is_that_of_finite_differences() {
    let sea = sea(GerstnerSpectrum { count: 30, sharpness: 0.6, ..GerstnerSpectrum::default() });
    let frame = sea.at(3.0);
    let at = |x: f64, z: f64| {
        let [dx, dy, dz] = frame.evaluate([x, z], 0.0).displacement;
        [x + dx, dy, z + dz]
    };
    let step = 1e-5;
    let difference = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|axis| (a[axis] - b[axis]) / (2.0 * step));
    let u = difference(at(7.0 + step, 8.0), at(7.0 - step, 8.0));
    let v = difference(at(7.0, 8.0 + step), at(7.0, 8.0 - step));
    let cross = [v[1] * u[2] - v[2] * u[1], v[2] * u[0] - v[0] * u[2], v[0] * u[1] - v[1] * u[0]];
    for (exact, found) in frame.evaluate([7.0, 8.0], 0.0).normal().into_iter().zip(cross) {
        assert!((exact - found).abs() < 1e-8);
    }
}

#[test]
fn the_footprint_attenuates_and_its_loss_is_reported() {
    let sea = single(0.5);
    let k = sea.waves()[0].wave_number();
    let sample = sea.at(0.0).evaluate([0.0, 0.0], 4.0);
    assert!((sample.displacement[1] - (-(k * 2.0) * (k * 2.0) / 2.0).exp()).abs() < 1e-15);
    let lost = k * k / 2.0 * (1.0 - attenuation(k, 4.0).powi(2));
    assert!((sample.slope_variance - lost).abs() < 1e-15);
    assert_eq!(sea.at(0.0).evaluate([0.0, 0.0], 0.0).slope_variance, 0.0);
}

#[test]
fn the_precise_sum_is_the_reference_to_rounding() {
    let mut random = Random(5);
    for (count, sharpness) in [(0, 0.0), (1, 0.9), (7, 0.5), (8, 0.5), (300, 0.7)] {
        let sea = sea(GerstnerSpectrum { count, height: 4.0, sharpness, ..GerstnerSpectrum::default() });
        let sizes: f64 = sea.waves().iter().map(|wave| wave.amplitude.abs() * (1.0 + wave.wave_number())).sum();
        for far in [0.0, 1e3, 1e7] {
            let frame = sea.at(far);
            let precise = PreciseSea::new(&frame);
            for _ in 0..200 {
                let rest = [far + 100.0 * random.unit(), -far + 100.0 * random.unit()];
                let footprint = [0.0, 0.3, 5.0, 60.0, 1e4][(5.0 * random.unit()) as usize % 5] * random.unit();
                let (fast, slow) = (precise.evaluate(rest, footprint), frame.evaluate(rest, footprint));
                // Precision of the phase at 1e7 m, in f64.
                let allowed = sizes * (1e-14 + 1e-15 * far);
                for (fast, slow) in values(&fast.sample).into_iter().zip(values(&slow)).take(9) {
                    assert!(
                        (fast - slow).abs() <= allowed,
                        "{count} waves at {rest:?}, {footprint}: {fast} is not {slow}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_precise_sum_leaves_out_waves_far_below_the_footprint() {
    let wave = |wavelength, amplitude| ExplicitWave {
        wavelength,
        amplitude,
        direction: 0.3,
        sharpness: 0.2,
        phase: 0.1,
        speed: None,
    };
    let waves = [wave(40.0, 1.0), wave(0.5, 0.01), wave(1e-3, 1e-5)].map(|wave| Wave::try_from(wave).expect("valid"));
    let frame = Sea::new(waves.to_vec()).at(0.0);
    for footprint in [0.0, 0.01, 0.3, 5.0, 60.0, 1e4] {
        let (fast, slow) =
            (PreciseSea::new(&frame).evaluate([3.0, 4.0], footprint), frame.evaluate([3.0, 4.0], footprint));
        for (fast, slow) in fast.sample.displacement.into_iter().zip(slow.displacement) {
            assert!((fast - slow).abs() < 1e-13, "{footprint}: {fast} is not {slow}");
        }
    }
}

#[test]
fn the_precise_sum_knows_its_slopes_and_their_bounds() {
    let sea = sea(GerstnerSpectrum { count: 60, height: 3.0, sharpness: 0.6, ..GerstnerSpectrum::default() });
    let frame = sea.at(2.0);
    let precise = PreciseSea::new(&frame);
    let step = 1e-4;
    let mut random = Random(11);
    for _ in 0..300 {
        let (rest, footprint) = ([50.0 * random.unit(), 50.0 * random.unit()], 0.1 + 3.0 * random.unit());
        let moved = |by: f64| frame.evaluate(rest, footprint + by).displacement;
        let slopes = precise.evaluate(rest, footprint).by_footprint;
        for ((more, less), slope) in moved(step).into_iter().zip(moved(-step)).zip(slopes) {
            assert!(((more - less) / (2.0 * step) - slope).abs() < 1e-7);
        }
        // Differences of the displacement and of its derivatives, along x and along z.
        let at = |by: [f64; 2]| precise.evaluate([rest[0] + by[0], rest[1] + by[1]], footprint);
        let (same, most) = (at([0.0; 2]), precise.most(footprint));
        for by in [[step, 0.0], [0.0, step]] {
            let (after, before) = (at(by), at(by.map(|by| -by)));
            let slope = |of: &dyn Fn(&Precise) -> f64| (of(&after) - of(&before)) / (2.0 * step);
            let bend = |of: &dyn Fn(&Precise) -> f64| (of(&after) - 2.0 * of(&same) + of(&before)) / (step * step);
            for i in 0..3 {
                let (moved, first) = (same.sample.displacement[i], same.sample.strain[i]);
                assert!(moved.abs() <= most[0] && first.abs() <= most[1]);
                let second = slope(&|precise| precise.sample.strain[i]);
                let third = bend(&|precise| precise.sample.strain[i]);
                assert!(second.abs() <= most[2] * (1.0 + 1e-6) && third.abs() <= most[3] * (1.0 + 1e-6) + 1e-5);
                let by_footprint = slope(&|precise| precise.by_footprint[i]);
                assert!(by_footprint.abs() <= footprint / 4.0 * most[3] * (1.0 + 1e-6));
            }
        }
        // The displacement spreads like heat while the footprint grows.
        let spread = |i: usize| {
            let bend = |by: [f64; 2]| {
                let sum = at(by).sample.displacement[i] + at(by.map(|by| -by)).sample.displacement[i];
                (sum - 2.0 * same.sample.displacement[i]) / (step * step)
            };
            footprint / 4.0 * (bend([step, 0.0]) + bend([0.0, step]))
        };
        assert!((0..3).all(|i| (spread(i) - slopes[i]).abs() < 1e-6));
    }
    // One wave alone reaches the bound at its crest.
    let wave =
        ExplicitWave { wavelength: 7.0, amplitude: 0.3, direction: 0.0, sharpness: 0.2, phase: 0.0, speed: None };
    let alone = PreciseSea::new(&Sea::new(vec![Wave::try_from(wave).expect("valid")]).at(0.0));
    let k = std::f64::consts::TAU / 7.0;
    let share = attenuation(k, 1.5);
    let mut expected = 0.3 * share;
    for most in alone.most(1.5) {
        assert!((most - expected).abs() < 1e-12);
        expected *= k;
    }
}
