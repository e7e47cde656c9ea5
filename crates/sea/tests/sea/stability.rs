//! Tests of the predictions about a toon sea's motion against powers of its step and runs of its f32 code.

use rayon::prelude::*;
use trochoid_sea::toon::*;

const BOUNDARIES: [Boundary; 3] = [Boundary::Replicate, Boundary::Periodic, Boundary::Fixed];

fn basin(columns: usize, rows: usize, boundary: Boundary) -> Basin {
    Basin { columns, rows, spacing: 0.25, boundary }
}

/// Returns the largest difference between predicted and measured radius over a map of n × n mixings that extends
/// beyond the stable region, and every mixing with a wrong verdict.
fn map(n: usize, basin: Basin) -> (f64, Vec<String>) {
    let at = |index: usize, reach: f64| reach * (2.0 * (index as f64 + 0.5) / n as f64 - 1.0);
    let compared = (0..n * n).into_par_iter().map(|cell| {
        let mixing = Mixing { c1: at(cell % n, 1.25), c2: at(cell / n, 1.4) };
        let motion = Motion::Literal(mixing);
        let probe = Probe::new(&motion, &basin);
        let forecast = Forecast::new(&motion, probe.basin());
        let radius = probe.radius();
        let wrong = forecast.bounded != (radius <= 1.0 + 1e-7);
        ((radius - forecast.radius).abs(), wrong.then(|| format!("{basin:?} {mixing:?}: {forecast:?} for {radius}")))
    });
    let compared: Vec<(f64, Option<String>)> = compared.collect();
    let most = compared.iter().fold(0.0, |most: f64, (off, _)| most.max(*off));
    (most, compared.into_iter().filter_map(|(_, wrong)| wrong).collect())
}

#[test]
fn the_radius_that_is_predicted_is_measured() {
    for (boundary, [columns, rows]) in BOUNDARIES.into_iter().zip([[5, 4], [4, 5], [4, 3]]) {
        let (most, wrong) = map(20, basin(columns, rows, boundary));
        println!("{boundary:?}: {most:e}");
        assert!(most < 1e-6, "{boundary:?}: {most:e}");
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}

/// `cargo test --release -p trochoid-sea --test sea the_whole_map -- --ignored --nocapture`
#[test]
#[ignore = "minutes; its figures are in BENCHMARKS.md"]
fn the_whole_map_200_by_200() {
    for boundary in BOUNDARIES {
        let (most, wrong) = map(200, basin(6, 5, boundary));
        println!("{boundary:?}: greatest difference {most:e}, {} wrong of 40000", wrong.len());
        assert!(most < 1e-6 && wrong.is_empty(), "{boundary:?}: {most:e}, {}", wrong.join("\n"));
    }
}

/// On the edge itself, where roots of modulus 1 may be double: motions that are called stable stay bounded over 2²⁰
/// steps.
#[test]
fn nothing_that_grows_is_called_stable() {
    for boundary in BOUNDARIES {
        for sides in [[4, 4], [5, 5], [2, 3]] {
            let basin = basin(sides[0], sides[1], boundary);
            let mut points = Mixing::stable_region(&basin);
            assert!(points.len() >= 4, "{points:?}");
            // Corners, and points along the sides, also slightly inside and outside.
            let corners = points.clone();
            for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                for t in [0.25, 0.5, 0.75] {
                    points.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
                }
            }
            for [c1, c2] in points {
                for scale in [1.0, 1.0 - 1e-12, 1.0 + 1e-12, 0.999, 1.001] {
                    let mixing = Mixing { c1: scale * c1, c2: scale * c2 };
                    let motion = Motion::Literal(mixing);
                    let norms = Probe::new(&motion, &basin).norms(20);
                    // Detects any growth from 4096 to a million steps. At 1e-12 from a double root, a sea grows for
                    // longer but finally decays.
                    let grows = scale != 1.0 - 1e-12 && norms[20] > 8.0 * norms[12] || !norms[20].is_finite();
                    let bounded = Forecast::new(&motion, &basin).bounded;
                    assert!(!(bounded && grows), "{basin:?} {mixing:?}: {norms:?}");
                    assert!(bounded || scale < 1.001 || grows, "{basin:?} {mixing:?}: {norms:?}");
                    assert!(bounded || scale > 0.999, "{basin:?} {mixing:?} lies inside");
                }
            }
        }
    }
}

#[test]
fn margins_and_limits_reach_the_edge() {
    for boundary in BOUNDARIES {
        let basin = basin(6, 5, boundary);
        let bounded = |c1: f64, c2: f64| Forecast::new(&Motion::Literal(Mixing { c1, c2 }), &basin).bounded;
        for [c1, c2] in [[0.3, 0.65], [-0.1, 0.2], [0.8, -0.1], [0.0, 0.0]] {
            let mixing = Mixing { c1, c2 };
            let margin = mixing.margin(&basin);
            assert!(margin > 0.0);
            for turn in 0..64 {
                let (sin, cos) = (f64::from(turn) * 0.1).sin_cos();
                assert!(bounded(c1 + 0.999 * margin * cos, c2 + 0.999 * margin * sin), "{mixing:?} {margin}");
            }
            let [[low1, high1], [low2, high2]] = mixing.limits(&basin);
            for (inside, [x, y]) in [
                (true, [low1 + 1e-6, c2]),
                (false, [low1 - 1e-6, c2]),
                (true, [high1 - 1e-6, c2]),
                (false, [high1 + 1e-6, c2]),
                (true, [c1, low2 + 1e-6]),
                (false, [c1, low2 - 1e-6]),
                (true, [c1, high2 - 1e-6]),
                (false, [c1, high2 + 1e-6]),
            ] {
                assert_eq!(bounded(x, y), inside, "{boundary:?} {mixing:?}: {x} {y}");
            }
        }
    }
}

/// Tests the other motions: their f64 steps are powers and exponentials, the forecast uses the roots.
#[test]
fn resampled_and_physical_radii_are_measured() {
    let physics = |speed: f64, damping: f64, frequency: f64| Physics { speed, damping, frequency, push: None };
    let motions = [
        Motion::Resampled { mixing: Mixing::default(), rate: 60.0 },
        Motion::Resampled { mixing: Mixing::default(), rate: 24.0 },
        Motion::Resampled { mixing: Mixing { c1: 0.9, c2: 0.1 }, rate: 1000.0 },
        Motion::Resampled { mixing: Mixing { c1: 0.5, c2: 0.2 }, rate: 7.0 },
        Motion::Physical { physics: physics(6.0, 16.0, 16.0), rate: 60.0 },
        Motion::Physical { physics: physics(2.0, 0.1, 1.0), rate: 24.0 },
        Motion::Physical { physics: physics(1e4, 3.0, 0.5), rate: 60.0 },
        Motion::Physical { physics: physics(1.0, 900.0, 2.0), rate: 60.0 },
        Motion::Physical { physics: physics(1.0, 2.0, 0.0), rate: 60.0 },
    ];
    for boundary in BOUNDARIES {
        for motion in motions {
            let probe = Probe::new(&motion, &basin(5, 6, boundary));
            let forecast = Forecast::new(&motion, probe.basin());
            let radius = probe.radius();
            assert!((radius - forecast.radius).abs() < 1e-6, "{boundary:?} {motion:?}: {radius} for {forecast:?}");
            assert!(forecast.bounded && forecast.radius <= 1.0);
        }
        // A level sea without restoring force and drag keeps moving as it is pushed.
        let free = Motion::Physical { physics: physics(1.0, 0.0, 0.0), rate: 60.0 };
        let bounded = Forecast::new(&free, &basin(5, 6, boundary)).bounded;
        assert_eq!(bounded, boundary == Boundary::Fixed);
        let norms = Probe::new(&free, &basin(5, 6, boundary)).norms(20);
        assert_eq!(norms[20] < 8.0 * norms[12], bounded, "{norms:?}");
    }
    // The usual explicit scheme breaks beyond 1/√2 of a cell per step; the exact one does not.
    for (speed, grows) in [(10.0, false), (11.0, true), (60.0, true)] {
        let motion = Motion::Physical { physics: physics(speed, 0.0, 0.5), rate: 60.0 };
        let radius = Probe::explicit(&motion, &basin(6, 6, Boundary::Periodic)).expect("physical").radius();
        assert_eq!(radius > 1.0 + 1e-6, grows, "{speed}: {radius}");
    }
}

#[test]
fn runs_of_the_f32_code_show_the_half_life() {
    let physics = Physics { speed: 2.0, damping: 3.0, frequency: 5.0, push: None };
    for motion in [
        Motion::default(),
        Motion::Literal(Mixing { c1: 0.8, c2: 0.15 }),
        Motion::Literal(Mixing { c1: 0.2, c2: -0.7 }),
        Motion::Resampled { mixing: Mixing::default(), rate: 24.0 },
        Motion::Physical { physics, rate: 60.0 },
    ] {
        for boundary in BOUNDARIES {
            let basin = basin(40, 32, boundary);
            let (trial, forecast) = (Trial::new(&motion, &basin), Forecast::new(&motion, &basin));
            let ratio = trial.half_life / forecast.half_life;
            assert!((ratio - 1.0).abs() < 0.03, "{boundary:?} {motion:?}: {trial:?} {forecast:?}");
            assert_eq!(trial.subnormal_share, 0.0, "{motion:?}");
        }
    }
    // The printed form ends in subnormal numbers, as the notes on numerics say.
    let trial = Trial::new(&Motion::default(), &basin(40, 32, Boundary::Replicate));
    assert!(trial.printed_subnormal_share.is_some_and(|share| share > 0.01), "{trial:?}");
}

#[test]
fn a_held_level_does_not_drift() {
    let physics = Physics { speed: 2.0, damping: 3.0, frequency: 5.0, push: None };
    for motion in [
        Motion::default(),
        Motion::Literal(Mixing { c1: 0.9, c2: 0.1 }),
        Motion::Resampled { mixing: Mixing::default(), rate: 24.0 },
        Motion::Physical { physics, rate: 60.0 },
    ] {
        let probe = Probe::new(&motion, &basin(6, 5, Boundary::Replicate));
        let drifting = LevelDrift::new(&motion, &probe, 50_000);
        println!("{motion:?}: {drifting:?}");
        assert!(drifting.drift < 1e-5, "{motion:?}: {drifting:?}");
    }
}

/// Tests the gains that the notes on numerics state.
#[test]
fn transient_gains_are_known() {
    for (c1, c2, expected) in [(0.3, 0.65, 1.64), (0.95, 0.0, 19.7)] {
        for side in [65, 400] {
            let motion = Motion::Literal(Mixing { c1, c2 });
            let transient = Transient::new(&motion, &basin(side, side, Boundary::Replicate));
            assert!((transient.gain / expected - 1.0).abs() < 0.003, "{c1} {c2}: {transient:?} for {expected}");
        }
    }
}

/// Tests half-lives and growth on both sides of all edges of the stable region, against runs of the f32 code.
#[test]
fn the_slowest_wave_is_that_of_the_f32_code() {
    let mut motions = Vec::new();
    for (boundary, [columns, rows]) in BOUNDARIES.into_iter().zip([[4, 4], [4, 6], [5, 3]]) {
        let basin = basin(columns, rows, boundary);
        let corners = Mixing::stable_region(&basin);
        for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            for (index, t) in [0.0, 0.2, 0.5, 0.8].into_iter().enumerate() {
                for by in [1.0 - 0.02, 1.0 - 1e-3, 1.0 - 1e-4, 1.0 + 1e-3] {
                    let [c1, c2] = [0, 1].map(|axis| by * (a[axis] + t * (b[axis] - a[axis])));
                    let mixing = Mixing { c1, c2 };
                    motions.push((Motion::Literal(mixing), basin));
                    let rate = [60.0, 30.0, 24.0, 97.0][index];
                    let motion = Motion::Resampled { mixing, rate };
                    if ToonSea::new(basin, motion, Behavior::default(), Vec::new()).is_ok() {
                        motions.push((motion, basin));
                    }
                }
            }
        }
        for (speed, damping, frequency) in [(6.0, 16.0, 16.0), (2.0, 0.01, 1.0), (50.0, 300.0, 2.0), (1.0, 0.3, 0.3)] {
            motions.push((
                Motion::Physical { physics: Physics { speed, damping, frequency, push: None }, rate: 60.0 },
                basin,
            ));
        }
    }
    let compared = motions.into_par_iter().map(|(motion, basin)| {
        let predicted = Decay::predicted(&motion, &basin);
        if predicted.growth.abs() < 2e-5 {
            return (false, None);
        }
        let measured = Decay::measured(&motion, &basin);
        let off = (measured.growth / predicted.growth - 1.0).abs();
        (true, (off > 0.05).then(|| format!("{motion:?} {:?}: {predicted:?}, {measured:?}", basin.boundary)))
    });
    let compared: Vec<(bool, Option<String>)> = compared.collect();
    let count = compared.iter().filter(|(compared, _)| *compared).count();
    let wrong: Vec<String> = compared.into_iter().filter_map(|(_, wrong)| wrong).collect();
    assert!(wrong.is_empty(), "{} of {count}\n{}", wrong.len(), wrong.join("\n"));
    assert!(count >= 200, "{count}");
}
