//! Tests of spray: births by the grid against those by plain f64 sums, and drops that depend only on their time.

use crate::random::Random;
use std::f64::consts::FRAC_PI_4;
use trochoid_sea::inside::sincos_lanes;
use trochoid_sea::spray::{Burst, Droplet, Spray, SprayError, SprayRun, reference};
use trochoid_sea::{ExplicitWave, GerstnerSpectrum, Sea, Wave};

fn sea(count: usize, sharpness: f64, seed: u64) -> Sea {
    let spectrum = GerstnerSpectrum { count, sharpness, height: 2.0, seed, ..GerstnerSpectrum::default() };
    Sea::new(spectrum.waves().expect("valid"))
}

/// Small enough for the reference.
fn small() -> Spray {
    Spray { size: [24.0, 16.0], cell: 1.0, rate: 8.0, density: 8.0, threshold: 0.7, lifetime: 1.0, ..Spray::default() }
}

fn burst() -> Burst {
    Burst {
        position: [1.0, 2.0, 3.0],
        extent: 0.5,
        time: 0.0,
        duration: 0.3,
        direction: [0.2, 1.0, 0.0],
        spread: 0.5,
        speed: 8.0,
        count: 40,
    }
}

/// Computes drops by both methods and checks that they are the same, in the same order, at the same positions to
/// `tolerance` meters.
fn agree(spray: &Spray, sea: &Sea, time: f64, tolerance: f64, what: &str) -> Vec<Droplet> {
    let run = SprayRun::new(spray.clone(), sea.clone(), 1.5).expect("valid");
    let found = run.at(time).expect("few");
    let truth = reference::drops(spray, sea, Some(1.5), time);
    assert_eq!(run.exact_at(time), truth, "{what}");
    // At the very limit of strength or lifetime, f32 may keep or lose a drop; bits of shape tell which drops are the
    // same.
    let shapes: std::collections::HashMap<u64, &Droplet> = truth.iter().map(|drop| (drop.shape, drop)).collect();
    let mut lost = 0;
    for drop in &found {
        let Some(truth) = shapes.get(&drop.shape) else {
            assert!(drop.strength < 1e-3, "{what}: {drop:?} is not in the reference");
            lost += 1;
            continue;
        };
        for axis in 0..3 {
            let off = (drop.position[axis] - truth.position[axis]).abs();
            assert!(off <= tolerance, "{what}: {off} m off: {drop:?}, expected {truth:?}");
        }
        assert_eq!((drop.radius, drop.age), (truth.radius, truth.age), "{what}");
    }
    assert!(found.len() - lost + 2 >= truth.len(), "{what}: {} of {} drops", found.len(), truth.len());
    found
}

#[test]
fn drops_are_those_of_the_reference() {
    let mut random = Random(11);
    let mut total = 0;
    for round in 0..12 {
        let count = [1, 3, 40, 200][round % 4];
        let sea = sea(count, random.between(0.4, 1.6), round as u64);
        let spray = Spray {
            center: [random.between(-50.0, 50.0), random.between(-50.0, 50.0)],
            cell: random.between(0.5, 2.0),
            threshold: random.between(0.4, 1.1),
            width: [0.0, 0.3][round % 2],
            torn: random.unit(),
            drag: random.between(0.0, 5.0),
            seed: round as i64,
            bursts: vec![Burst { time: 3.0, ..burst() }],
            ..small()
        };
        total += agree(&spray, &sea, random.between(3.0, 4.0), 1e-4, &format!("round {round}")).len();
    }
    assert!(total > 2000, "{total} drops say little");
}

#[test]
fn hostile_figures_agree_too() {
    // (sea, spray, time, tolerance)
    let far = [1e7 + 0.25, -1e7];
    for (sea, spray, time, tolerance, what) in [
        (Sea::default(), small(), 3.0, 0.0, "no wave"),
        (Sea::default(), Spray { threshold: 1.5, ..small() }, 3.0, 0.0, "no wave, and drops all the same"),
        (sea(60, 10.0, 1), small(), 2.0, 1e-3, "sharpness 10"),
        (sea(60, 0.9, 1), small(), 1e7, 1e-3, "a late time"),
        (sea(60, 0.9, 1), Spray { center: far, ..small() }, 2.0, 1e-3, "far off"),
        (sea(60, 0.9, 1), Spray { lifetime: 0.0, ..small() }, 2.0, 0.0, "no life"),
        (sea(60, 0.9, 1), Spray { density: 0.0, ..small() }, 2.0, 0.0, "no density"),
        (sea(60, 0.9, 1), Spray { size: [0.0, 0.0], ..small() }, 2.0, 1e-3, "no region"),
        (sea(60, 0.9, 1), Spray { radius: 0.0, ..small() }, 2.0, 1e-3, "no radius"),
        (sea(60, 0.9, 1), Spray { vary: 0.0, torn: 0.0, cone: 0.0, ..small() }, 2.0, 1e-3, "all alike"),
        (sea(60, 0.9, 1), Spray { drag: 1e4, wind: [1e4; 3], ..small() }, 2.0, 1e-2, "a wall of wind"),
        (sea(60, 0.9, 1), Spray { tuft: 1e-3, torn: 1.0, cone: 9.0, ..small() }, 2.0, 1e-3, "dust"),
        (sea(60, 0.9, 1), Spray { threshold: 1e6, width: 1e6, ..small() }, 2.0, 1e-3, "everywhere"),
    ] {
        for drop in agree(&spray, &sea, time, tolerance, what) {
            let numbers = drop.position.iter().chain(&drop.velocity).chain([&drop.radius, &drop.age, &drop.strength]);
            assert!(numbers.into_iter().all(|number| number.is_finite()), "{what}: {drop:?}");
            assert!((0.0..1.0).contains(&drop.age) && (0.0..=1.0).contains(&drop.strength), "{what}: {drop:?}");
        }
    }
    assert!(agree(&small(), &Sea::default(), 3.0, 0.0, "calm").is_empty(), "a calm sea throws nothing");
}

#[test]
fn a_moment_depends_on_nothing_before_it() {
    let (sea, spray) = (sea(80, 1.0, 2), Spray { bursts: vec![burst()], ..small() });
    let alone = |time: f64| SprayRun::new(spray.clone(), sea.clone(), 0.0).expect("valid").at(time).expect("few");
    let run = SprayRun::new(spray.clone(), sea.clone(), 0.0).expect("valid");
    for time in [0.0, 1.0 / 24.0, 0.5, 0.1, 7.0, 0.5] {
        let drops = run.at(time).expect("few");
        assert_eq!(drops, alone(time), "{time}");
        assert_eq!(run.exact_at(time), reference::drops(&spray, &sea, Some(0.0), time), "{time}");
    }
    assert!(alone(0.5).len() > 20 && alone(0.5) != alone(0.1));
}

#[test]
fn regions_share_the_drops_of_cells_that_they_share() {
    let sea = sea(80, 1.0, 2);
    let of = |center: [f64; 2]| {
        let spray = Spray { center, ..small() };
        reference::births(&spray, &sea, 0.0, 2.0)
    };
    let (here, moved) = (of([0.0, 0.0]), of([5.3, 0.0]));
    let shared = here.iter().filter(|birth| moved.contains(birth)).count();
    assert!(shared > here.len() / 3 && shared < here.len(), "{shared} of {}", here.len());
}

#[test]
fn drops_are_born_where_the_sea_is_squeezed_only() {
    // One wave along x: det J = 1 − q·cos θ is least at its crests.
    let wave =
        ExplicitWave { wavelength: 8.0, amplitude: 0.6, direction: 0.0, sharpness: 0.8, phase: 0.0, speed: None };
    let sea = Sea::new(vec![Wave::try_from(wave).expect("valid")]);
    let spray = Spray { cell: 0.25, threshold: 0.4, size: [32.0, 8.0], ..small() };
    let births = reference::births(&spray, &sea, 0.0, 2.0);
    assert!(births.len() > 50, "{} drops", births.len());
    for birth in births {
        // Drops are born slightly below the crests, which are at 0.6 m, and those born during a step have risen or
        // sunk since it began.
        assert!(birth.position[1] > 0.25, "{birth:?}");
    }
}

#[test]
fn what_would_take_too_much_is_refused() {
    let refused = |spray: Spray| SprayRun::new(spray, Sea::default(), 0.0).expect_err("too much").to_string();
    for (spray, expected) in [
        (Spray { size: [1e9, 1e9], ..small() }, "cells, more than"),
        (Spray { lifetime: 1e9, ..small() }, "steps in a lifetime"),
        (Spray { size: [1000.0, 1000.0], lifetime: 100.0, ..small() }, "over all steps"),
        (Spray { density: 1e9, ..small() }, "drops from a cell"),
        (Spray { cell: 0.0, ..small() }, "cell 0"),
        (Spray { wind: [f64::NAN, 0.0, 0.0], ..small() }, "wind NaN"),
        (Spray { speed: -1.0, ..small() }, "speed -1"),
        (Spray { bursts: vec![Burst { count: usize::MAX, ..burst() }; 2], ..small() }, "drops at a time"),
        (Spray { bursts: vec![Burst { speed: f64::INFINITY, ..burst() }], ..small() }, "bursts inf"),
    ] {
        let text = refused(spray.clone());
        assert!(text.contains(expected), "{spray:?}: {text}");
    }
    // There are too many only once the sea is known.
    let crowd = Spray { size: [200.0, 200.0], density: 500.0, threshold: 2.0, torn: 0.0, ..small() };
    let run = SprayRun::new(crowd, Sea::default(), 0.0).expect("its figures are fine");
    assert_eq!(run.at(1.0).expect_err("too many"), SprayError::Drops);
}

#[test]
fn sines_have_the_bits_of_libm() {
    let mut random = Random(43);
    let mut angles: Vec<f64> = (0..400_000).map(|_| random.between(-8.0, 8.0)).collect();
    angles.extend((0..100_000).map(|_| random.between(-1e3, 1e3)));
    angles.extend((0..100_000).map(|_| random.between(-1.0, 1.0) * libm::exp2(random.between(-60.0, 40.0))));
    // Next to all multiples of an eighth of a turn, where libm changes its path.
    for eighth in -40..=40 {
        let middle = f64::from(eighth) * FRAC_PI_4;
        angles.push(middle);
        for power in 10..53 {
            let by = middle.abs().max(1.0) * libm::exp2(-f64::from(power));
            angles.extend([middle - by, middle + by, middle - 0.7 * by, middle + 0.7 * by]);
        }
    }
    for part in angles.chunks(8) {
        // The last one is repeated.
        let angle: [f64; 8] = std::array::from_fn(|lane| part[lane.min(part.len() - 1)]);
        let found = sincos_lanes(angle);
        for lane in 0..8 {
            let expected = libm::sincos(angle[lane]);
            let bits = [found[0][lane], found[1][lane]].map(f64::to_bits);
            assert!(bits == [expected.0, expected.1].map(f64::to_bits), "{:e}: {found:?}", angle[lane]);
        }
    }
}
