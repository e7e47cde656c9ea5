//! Tests of the toon sea against its f64 reference and against known properties.

use crate::random::Random;
use trochoid_sea::toon::{
    Basin, Behavior, Body, Boundary, Burst, Combine, Drift, DriftPhases, Field, Guide, Mixing, Motion, Physics, Rift,
    Scratch, Shape, Simulation, ToonError, ToonFrame, ToonSea, TrailFields, reference,
};

const ALL: TrailFields = TrailFields { rift: true, drift: true };

/// Returns bursts around a basin, some of them outside, some small, some as large as the basin.
fn bursts(random: &mut Random, basin: &Basin, count: usize) -> Vec<Burst> {
    let size = basin.columns.max(basin.rows) as f64 * basin.spacing;
    (0..count)
        .map(|_| {
            let path = std::array::from_fn(|_| [random.between(-0.3, 1.3) * size, random.between(-0.3, 1.3) * size]);
            let start = random.between(-0.5, 0.5);
            Burst {
                duration: random.between(0.2, 3.0),
                offset: random.between(0.0, 10.0),
                height: random.between(-1.0, 3.0),
                peak: random.between(0.5, 1.5),
                influence: [random.between(0.4, 6.0) * basin.spacing, random.between(0.4, 6.0) * basin.spacing],
                fade: random.between(0.0, 0.3),
                active: if random.unit() < 0.5 { [start, start + 0.3] } else { [f64::NEG_INFINITY, f64::INFINITY] },
                lane: random.between(-3.0, 3.0),
                ..Burst::along(path)
            }
        })
        .collect()
}

fn motions() -> Vec<Motion> {
    let physics = Physics { speed: 3.0, damping: 2.0, frequency: 4.0, push: None };
    vec![
        Motion::Literal(Mixing::default()),
        Motion::Resampled { mixing: Mixing::default(), rate: 60.0 },
        Motion::Resampled { mixing: Mixing { c1: 0.9, c2: 0.1 }, rate: 24.0 },
        Motion::Resampled { mixing: Mixing { c1: 0.05, c2: 0.9 }, rate: 97.3 },
        Motion::Physical { physics, rate: 30.0 },
        Motion::Physical { physics: Physics { damping: 500.0, ..physics }, rate: 30.0 },
        Motion::Physical { physics: Physics { speed: 1e3, damping: 0.0, push: Some(40.0), ..physics }, rate: 25.0 },
    ]
}

/// Returns the largest error, relative to the largest value.
fn error(found: &[f32], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let size = expected.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
    let off = found.iter().zip(expected).map(|(&found, expected)| (f64::from(found) - expected).abs());
    off.fold(0.0, |worst: f64, off| if off <= worst { worst } else { off }) / size.max(1e-12)
}

/// Returns all fields of drift.
fn drifts<'a>(frame: &ToonFrame<'a>) -> [&'a [f32]; 5] {
    let DriftPhases { weight, along: [ac, as_], across: [lc, ls] } = frame.drift;
    [weight, ac, as_, lc, ls]
}

#[test]
fn agrees_with_the_reference() {
    let mut random = Random(7);
    for boundary in [Boundary::Replicate, Boundary::Periodic, Boundary::Fixed] {
        for (index, motion) in motions().into_iter().enumerate() {
            let basin = Basin { columns: 31 + 40 * (index % 2), rows: 40 - 3 * index, spacing: 0.3, boundary };
            let behavior = Behavior {
                shape: if index % 3 == 1 { Shape::Literal } else { Shape::Intended },
                oriented: index % 2 == 0,
                preroll: 5,
                injection: (index == 2).then_some(0.02),
                rift: Rift { combine: if index % 2 == 0 { Combine::Sum } else { Combine::Nearest }, ..Rift::default() },
                drift: Drift::default(),
            };
            let sea = ToonSea::new(basin, motion, behavior, bursts(&mut random, &basin, 9)).expect("valid");
            let time = [0.0, 0.25, 0.4171][index % 3];
            let expected = reference::frame(&sea, time, ALL);
            let mut simulation = sea.simulate(ALL);
            let found = simulation.at(time);
            let mut errors = vec![error(found.height, &expected.height), error(found.rift, &expected.rift)];
            let drift = drifts(&found);
            errors.extend(drift.iter().zip(&expected.drift).map(|(found, expected)| error(found, expected)));
            assert!(errors.iter().all(|&error| error < 2e-5), "{boundary:?} {motion:?} at {time}: {errors:?}");
        }
    }
}

#[test]
fn resampled_equals_literal_at_60_hz() {
    let mut random = Random(11);
    let mixing = Mixing::default();
    for boundary in [Boundary::Replicate, Boundary::Periodic, Boundary::Fixed] {
        let basin = Basin { columns: 50, rows: 37, spacing: 0.2, boundary };
        let bursts = bursts(&mut random, &basin, 6);
        let sea = |motion| ToonSea::new(basin, motion, Behavior::default(), bursts.clone()).expect("valid");
        let mut literal = sea(Motion::Literal(mixing)).simulate(ALL);
        let mut resampled = sea(Motion::Resampled { mixing, rate: 60.0 }).simulate(ALL);
        for step in [1, 7, 40, 90] {
            let time = f64::from(step) / 60.0;
            let literal: Vec<f64> = literal.at(time).height.iter().map(|&height| f64::from(height)).collect();
            assert!(error(resampled.at(time).height, &literal) < 1e-5, "{boundary:?}, step {step}");
        }
    }
}

/// An interval without bursts is one jump, unlike in the reference: after an impulse, and before one.
#[test]
fn a_free_sea_jumps_as_it_steps() {
    let basin = Basin { columns: 40, rows: 30, spacing: 0.25, boundary: Boundary::Replicate };
    for motion in motions().into_iter().skip(1) {
        let rate = motion.rate();
        let at = |step: f64| [(step - 0.5) / rate, (step + 0.5) / rate];
        let first = Burst { active: at(5.0), ..Burst::along([[5.0, 4.0]; 4]) };
        let second = Burst { active: at(31.0), height: 0.3, ..Burst::along([[2.0, 3.0]; 4]) };
        let sea = ToonSea::new(basin, motion, Behavior::default(), vec![first, second]).expect("valid");
        let mut simulation = sea.simulate(ALL);
        for step in [4.0, 5.0, 17.3, 30.0, 31.0, 40.0] {
            let expected = reference::frame(&sea, step / rate, ALL);
            let found = simulation.at(step / rate);
            assert!(error(found.height, &expected.height) < 3e-5, "{motion:?}, step {step}");
            assert!(error(found.rift, &expected.rift) < 2e-5, "{motion:?}, step {step}");
        }
    }
}

fn bits(simulation: &mut Simulation, time: f64) -> Vec<u32> {
    let frame = simulation.at(time);
    let fields = [&[frame.height, frame.rift][..], &drifts(&frame)].concat();
    fields.iter().flat_map(|field| field.iter().map(|value| value.to_bits())).collect()
}

#[test]
fn a_frame_alone_is_the_frame_of_a_run() {
    let mut random = Random(3);
    for motion in motions() {
        let basin = Basin { columns: 45, rows: 33, spacing: 0.3, boundary: Boundary::Replicate };
        let mut bursts = bursts(&mut random, &basin, 8);
        // Includes intervals without bursts.
        bursts.iter_mut().for_each(|burst| burst.active = if burst.fade < 0.15 { [0.2, 0.5] } else { [1.1, 1.3] });
        let behavior = Behavior { preroll: 3, ..Behavior::default() };
        let sea = ToonSea::new(basin, motion, behavior, bursts).expect("valid");
        let mut run = sea.simulate(ALL);
        let frames: Vec<Vec<u32>> = (0..48).map(|frame| bits(&mut run, f64::from(frame) / 24.0)).collect();
        for frame in [47, 0, 11, 20, 30, 46] {
            let alone = bits(&mut sea.simulate(ALL), f64::from(frame) / 24.0);
            assert!(alone == frames[frame as usize], "{motion:?}, frame {frame} alone");
            assert!(bits(&mut run, f64::from(frame) / 24.0) == alone, "{motion:?}, frame {frame} after others");
        }
        let threads = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
        assert!(threads.install(|| bits(&mut sea.simulate(ALL), 1.25)) == frames[30], "{motion:?} on one thread");
    }
}

/// A process that is killed between two steps leaves a state from which another one goes on.
#[test]
fn a_saved_state_goes_on_as_the_run_that_saved_it() {
    let mut random = Random(23);
    for (index, motion) in motions().into_iter().enumerate() {
        let basin = Basin { columns: 33, rows: 41, spacing: 0.3, boundary: Boundary::Replicate };
        let mut bursts = bursts(&mut random, &basin, 8);
        // Includes intervals without bursts, short and long ones.
        let spans = [[0.2, 0.5], [1.1, 1.3], [6.0, 6.2]];
        bursts.iter_mut().enumerate().for_each(|(at, burst)| burst.active = spans[at % 3]);
        let behavior = Behavior { preroll: 3, ..Behavior::default() };
        let sea = ToonSea::new(basin, motion, behavior, bursts).expect("valid");
        for begin in [|sea: &ToonSea| sea.simulate(ALL), |sea: &ToonSea| sea.simulate_trails(ALL)] {
            let expected = bits(&mut begin(&sea), 6.4);
            let mut run = begin(&sea);
            for stops in [1, 4, 30, 61, 66, 90] {
                // Stops after some steps, wherever that is.
                let left = std::cell::Cell::new(stops);
                run.reach(6.4, &|| left.replace(left.get() - 1) <= 0);
                let saved = run.save();
                assert_eq!(saved.len() as u64, run.saved_bytes());
                assert!(run.step() <= run.last_step(6.4));
                let mut other = begin(&sea);
                assert!(other.restore(run.step(), &saved));
                assert!(bits(&mut other, 6.4) == expected, "{index}: {motion:?} from step {}", run.step());
                // Going back starts over.
                assert!(bits(&mut other, 0.3) == bits(&mut begin(&sea), 0.3), "{motion:?}");
            }
        }
    }
}

#[test]
fn what_is_no_state_is_refused_and_changes_nothing() {
    let basin = Basin { columns: 20, rows: 10, spacing: 0.3, boundary: Boundary::Replicate };
    let sea = ToonSea::new(basin, Motion::default(), Behavior::default(), bursts(&mut Random(5), &basin, 4));
    let sea = sea.expect("valid");
    let mut run = sea.simulate(ALL);
    run.reach(0.5, &|| false);
    let (step, saved) = (run.step(), run.save());
    let mut other = sea.simulate(ALL);
    let start = other.save();
    assert!(start != saved);
    let nan = [&f32::NAN.to_le_bytes()[..], &saved[4..]].concat();
    for bad in [&saved[1..], &[], &nan, &[&saved[..], &[0; 4]].concat()] {
        assert!(!other.restore(step, bad), "{} bytes", bad.len());
        assert_eq!((other.step(), other.save() == start), (0, true));
    }
}

#[test]
fn what_is_not_asked_for_changes_nothing() {
    let basin = Basin { columns: 70, rows: 40, spacing: 0.3, boundary: Boundary::Replicate };
    let bursts = bursts(&mut Random(5), &basin, 12);
    let sea = ToonSea::new(basin, Motion::default(), Behavior::default(), bursts).expect("valid");
    let (mut all, mut none) = (sea.simulate(ALL), sea.simulate(TrailFields::default()));
    let (all, none) = (all.at(0.7), none.at(0.7));
    assert!(none.rift.is_empty() && none.drift.weight.is_empty());
    assert_eq!(all.height, none.height);
}

#[test]
fn trails_alone_are_the_same_bits() {
    let basin = Basin { columns: 150, rows: 70, spacing: 0.3, boundary: Boundary::Replicate };
    let physics = Physics { speed: 2.0, damping: 3.0, frequency: 5.0, push: None };
    for motion in [
        Motion::default(),
        Motion::Literal(Mixing::default()),
        Motion::Resampled { mixing: Mixing::default(), rate: 50.0 },
        Motion::Physical { physics, rate: 60.0 },
    ] {
        for combine in [Combine::Sum, Combine::Nearest] {
            let mut bursts = bursts(&mut Random(9), &basin, 9);
            // An interval without bursts, long enough for a jump.
            bursts.iter_mut().for_each(|burst| burst.active = [-1.0, 0.2]);
            bursts[0].active = [2.0, 2.3];
            let rift = Rift { combine, ..Rift::default() };
            let sea = ToonSea::new(basin, motion, Behavior { rift, preroll: 60, ..Behavior::default() }, bursts);
            let sea = sea.expect("valid");
            let mut all = sea.simulate(ALL);
            let mut rift = sea.simulate_trails(TrailFields { rift: true, drift: false });
            let mut drift = sea.simulate_trails(TrailFields { rift: false, drift: true });
            for time in [0.0, 0.11, 2.125, 1.0, 3.0] {
                let all = all.at(time);
                let (rift, drift) = (rift.at(time), drift.at(time));
                assert!(rift.height.is_empty() && rift.drift.weight.is_empty() && drift.rift.is_empty());
                assert_eq!(all.rift, rift.rift, "{motion:?} at {time}");
                let bits = |drift: DriftPhases<'_>| -> Vec<u32> {
                    let fields = [&[drift.weight][..], &drift.along, &drift.across].concat();
                    fields.concat().iter().map(|value| value.to_bits()).collect()
                };
                assert!(bits(all.drift) == bits(drift.drift), "{motion:?} at {time}");
                assert!(all.rift.iter().any(|&value| value > 0.0) && all.drift.weight.iter().any(|&value| value > 0.0));
            }
        }
    }
}

#[test]
fn a_burst_that_rests_reaches_its_plateau() {
    // As wide as the basin, whose edges mirror it: the mean settles at the mean of the burst.
    let basin = Basin { columns: 40, rows: 40, spacing: 0.5, boundary: Boundary::Replicate };
    let burst = Burst { influence: [9.0; 2], height: 2.0, ..Burst::along([[10.0, 10.0]; 4]) };
    let physics = Physics { speed: 2.0, damping: 3.0, frequency: 5.0, push: None };
    for motion in [Motion::default(), Motion::Physical { physics, rate: 60.0 }] {
        let sea = ToonSea::new(basin, motion, Behavior::default(), vec![burst]).expect("valid");
        let mut simulation = sea.simulate(ALL);
        let frame = simulation.at(20.0);
        let mean = frame.height.iter().map(|&height| f64::from(height)).sum::<f64>() / 1600.0;
        let profile = |cell: usize| {
            let (x, z) = ((cell % 40) as f64 * 0.5 - 10.0, (cell / 40) as f64 * 0.5 - 10.0);
            (std::f64::consts::PI * (x.hypot(z) / 9.0).min(1.0)).cos() + 1.0
        };
        let expected = (0..1600).map(profile).sum::<f64>() / 1600.0;
        assert!((mean / expected - 1.0).abs() < 1e-4, "{motion:?}: {mean} for {expected}");
        let rift = Rift::default();
        let center = f64::from(frame.rift[20 * 40 + 20]);
        assert!((center / rift.plateau(0.0) - 1.0).abs() < 1e-4, "{center}");
    }
}

#[test]
fn stability_is_exact() {
    let check = |c1: f64, c2: f64, columns: usize, boundary: Boundary| {
        let basin = Basin { columns, rows: columns, spacing: 1.0, boundary };
        ToonSea::new(basin, Motion::Literal(Mixing { c1, c2 }), Behavior::default(), Vec::new())
    };
    for (c1, c2) in [(0.3, 0.65), (0.9, 0.1), (0.35, 0.65), (0.0, 1.0), (-0.2, 0.39), (0.5, -0.49)] {
        assert!(check(c1, c2, 64, Boundary::Replicate).is_ok(), "{c1} {c2}");
    }
    for (c1, c2, growth) in [(0.9, -0.5, 1.80), (-0.5, 0.65, 1.91), (1.0, 0.0, 1.0), (0.4, 0.7, 1.153)] {
        let Err(ToonError::Unstable(found)) = check(c1, c2, 64, Boundary::Replicate) else {
            panic!("{c1} {c2} is not stable");
        };
        assert!((found.growth - growth).abs() < 0.02, "{c1} {c2}: {}", found.growth);
        let [c1, c2] = found.nearest;
        assert!(check(c1, c2, 64, Boundary::Replicate).is_ok(), "{c1} {c2} is proposed");
        assert!((c1 - found.found[0]).hypot(c2 - found.found[1]) < 0.61, "{found:?}");
    }
    // Coefficients that sum to more than 1 are stable if no mode is level.
    assert!(check(0.3, 0.701, 8, Boundary::Fixed).is_ok());
    assert!(check(0.3, 0.701, 8, Boundary::Replicate).is_err());
    assert!(check(f64::NAN, 0.5, 8, Boundary::Replicate).is_err());
    assert!(check(0.3, 0.65, 1, Boundary::Replicate).is_err());
    let basin = Basin { columns: 8, rows: 8, spacing: 1.0, boundary: Boundary::Replicate };
    let motion = Motion::Resampled { mixing: Mixing { c1: 0.2, c2: -0.7 }, rate: 60.0 };
    let refused = ToonSea::new(basin, motion, Behavior::default(), Vec::new());
    assert!(matches!(refused, Err(ToonError::NotResampled { .. })), "{refused:?}");
}

/// A level sea with c₁ + c₂ = 1 stays where it is, and decaying values end at 0, not in subnormal numbers.
#[test]
fn neither_drift_nor_subnormals() {
    let basin = Basin { columns: 16, rows: 16, spacing: 1.0, boundary: Boundary::Replicate };
    let mut field = Field { height: vec![1.0; 256], velocity: vec![0.0; 256] };
    (0..200_000).for_each(|_| field.step(Mixing { c1: 0.9, c2: 0.1 }, &basin));
    assert!(field.height.iter().all(|height| (height - 1.0).abs() < 1e-5), "{}", field.height[0]);
    (0..2_000).for_each(|_| field.step(Mixing::default(), &basin));
    assert!(field.height.iter().all(|&height| height == 0.0), "{}", field.height[0]);
}

#[test]
fn guides_scatter_as_told() {
    let burst = Burst::along([[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]]);
    let guide = Guide { burst, count: 4000, width: 8.0, jitter: 0.5, jitter_time: 0.25, jitter_size: 0.1, seed: 9 };
    let bursts = guide.bursts();
    assert_eq!(bursts, guide.bursts());
    assert_ne!(bursts, Guide { seed: 10, ..guide }.bursts());
    let deviation = |values: Vec<f64>| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    };
    let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 0.05, "{found} for {expected}");
    near(deviation(bursts.iter().map(|burst| burst.path[1][0]).collect()), 0.5);
    near(deviation(bursts.iter().map(|burst| burst.path[3][1] - burst.lane).collect()), 0.5);
    near(deviation(bursts.iter().map(|burst| burst.offset).collect()), 0.25);
    near(deviation(bursts.iter().map(|burst| burst.peak).collect()), 0.1);
    near(deviation(bursts.iter().map(|burst| burst.duration).collect()), 1.0);
    near(deviation(bursts.iter().map(|burst| burst.influence[1]).collect()), 0.2);
    assert_eq!(bursts[0].lane, -4.0);
    assert_eq!(bursts[3999].lane, 4.0);
}

/// Bursts far away, at late times and of extreme sizes keep everything finite.
#[test]
fn hostile_bursts_stay_finite() {
    let basin = Basin { columns: 33, rows: 21, spacing: 1e-3, boundary: Boundary::Periodic };
    let still = Burst { height: 1e6, peak: 1e3, influence: [1e6, 1e-3], ..Burst::along([[1e9, -1e9]; 4]) };
    let quick = Burst { duration: 1e-3, offset: -1e9, ..Burst::along([[-1e9, 0.0], [1e9, 0.0], [0.0, 1e9], [0.0; 2]]) };
    for shape in [Shape::Intended, Shape::Literal] {
        let behavior = Behavior { shape, oriented: true, ..Behavior::default() };
        let sea = ToonSea::new(basin, Motion::default(), behavior, vec![still, quick]).expect("valid");
        let mut simulation = sea.simulate(ALL);
        let frame = simulation.at(0.5);
        let fields = [&[frame.height, frame.rift][..], &drifts(&frame)].concat();
        assert!(fields.iter().all(|field| field.iter().all(|value| value.is_finite())), "{shape:?}");
    }
}

/// A step in parts equals the simulation's own step.
#[test]
fn parts_of_a_step_are_the_step() {
    let basin = Basin { columns: 70, rows: 50, spacing: 0.3, boundary: Boundary::Replicate };
    let mixing = Mixing::default();
    let bursts = bursts(&mut Random(21), &basin, 10);
    let sea = ToonSea::new(basin, Motion::Literal(mixing), Behavior::default(), bursts).expect("valid");
    let (mut field, mut rift) = (Field::at_rest(&basin), vec![0.0; basin.cells()]);
    let mut scratch = Scratch::default();
    for step in 1..=20 {
        field.accelerate(mixing, &basin);
        sea.inject(f64::from(step) / 60.0, &mut field, &mut rift, &mut scratch);
    }
    let mut simulation = sea.simulate(ALL);
    let frame = simulation.at(20.0 / 60.0);
    assert_eq!((frame.height, frame.rift), (field.height.as_slice(), rift.as_slice()));
}

/// A body piles the water up in front of its bow, lies in a trough, and leaves foam and lines behind; far away
/// nothing moves.
#[test]
fn bodies_press_and_heap() {
    let basin = Basin { columns: 120, rows: 60, spacing: 0.2, boundary: Boundary::Replicate };
    let path = [[2.0, 6.0], [8.0, 6.0], [14.0, 6.0], [20.0, 6.0]];
    let way = Burst { duration: 9.0, ..Burst::along(path) };
    let body = Body { way, length: 3.0, beam: 1.2, draught: 0.5 };
    let bursts = body.bursts().expect("valid");
    let behavior = Behavior { oriented: true, ..Behavior::default() };
    let sea = ToonSea::new(basin, Motion::default(), behavior, bursts).expect("valid");
    let mut simulation = sea.simulate(ALL);
    let frame = simulation.at(4.5);
    let at = |x: f64, z: f64| (z / 0.2).round() as usize * 120 + (x / 0.2).round() as usize;
    // The middle is at x = 11 m, the bow 1.5 m ahead.
    assert!(frame.height[at(10.6, 6.0)] < -0.05, "{}", frame.height[at(10.6, 6.0)]);
    assert!(frame.height[at(12.4, 6.0)] > 0.05, "{}", frame.height[at(12.4, 6.0)]);
    assert!(frame.rift[at(7.0, 6.0)] > 0.05 && frame.rift[at(16.0, 6.0)] == 0.0);
    assert!(frame.drift.weight[at(7.0, 6.0)] > 0.0 && frame.drift.weight[at(16.0, 6.0)] == 0.0);
    assert!(frame.height[at(20.0, 10.0)].abs() < 1e-3);
    // A body that does not move has no bow; a parameter out of range is named.
    let still = Body { way: Burst::along([[5.0, 5.0]; 4]), ..body };
    assert_eq!(still.bursts().expect("valid").len(), 1);
    for wrong in [Body { length: 0.0, ..body }, Body { beam: f64::NAN, ..body }, Body { draught: 1e9, ..body }] {
        assert!(wrong.bursts().expect_err("a wrong body").to_string().contains("of a body"), "{wrong:?}");
    }
}

#[test]
fn bytes_are_those_of_what_is_kept() {
    let basin = Basin { columns: 70, rows: 40, spacing: 0.3, boundary: Boundary::Replicate };
    let bursts = bursts(&mut Random(5), &basin, 12);
    let physics = Physics { speed: 2.0, damping: 3.0, frequency: 5.0, push: None };
    // Number of fields. Literal sea: two heights. Modes: their two numbers, at the step and where a frame ends,
    // force, coefficients, heights, and six factors for a step and for the part in which a frame ends.
    for (motion, fields) in
        [(Motion::Literal(Mixing::default()), 2), (Motion::Physical { physics, rate: 60.0 }, 4 + 3 + 12)]
    {
        let sea = ToonSea::new(basin, motion, Behavior::default(), bursts.clone()).expect("valid");
        let bytes = |wanted: TrailFields| {
            let mut simulation = sea.simulate(wanted);
            simulation.at(0.71);
            simulation.bytes()
        };
        let (none, all) = (bytes(TrailFields::default()), bytes(ALL));
        let cells = basin.cells() * size_of::<f32>();
        assert!((fields * cells..(fields + 1) * cells).contains(&none), "{motion:?}: {none} of {cells}");
        let trails = if matches!(motion, Motion::Literal(_)) { 6 } else { 12 };
        assert!((trails * cells..(trails + 1) * cells).contains(&(all - none)), "{motion:?}: {all} after {none}");
    }
}
