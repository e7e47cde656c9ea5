//! Tests of the f64 runs against a recurrence in twice their precision, and of what their doubt covers.

use crate::random::Random;
use crate::twice::Twice;
use rayon::prelude::*;
use std::f64::consts::PI;
use trochoid_sea::toon::reference::{Reference, Run};
use trochoid_sea::toon::*;

const NONE: TrailFields = TrailFields { rift: false, drift: false };

/// Returns the heights of a burst that travels along a straight path at even speed, with radii along x and z.
fn raised(burst: &Burst, basin: &Basin, time: f64) -> Vec<f64> {
    let turns = (time + burst.offset) / burst.duration;
    let share = turns - turns.floor();
    let [from, .., to] = burst.path;
    let center = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
    let active = burst.active[0] <= time && time < burst.active[1];
    let cell = |cell: usize| {
        let place = [cell % basin.columns, cell / basin.columns].map(|index| index as f64 * basin.spacing);
        let [a, b] = [0, 1].map(|axis| (place[axis] - center[axis]) / burst.influence[axis]);
        let profile = (PI * a.hypot(b) / burst.peak).min(PI).cos() + 1.0;
        if active { burst.peak * burst.height / 2.0 * profile } else { 0.0 }
    };
    (0..basin.cells()).map(cell).collect()
}

/// Returns the heights after some steps of h' = c₁(2·Lm(h) − h₋) + c₂·h + (1 − c₁ − c₂)·bursts, as it is printed,
/// `literal` of them for each time at which bursts act.
fn printed(sea: &ToonSea, mixing: Mixing, steps: u64, literal: u64) -> Vec<Twice> {
    let basin = *sea.basin();
    let cells = basin.cells();
    let (c1, c2) = (Twice::from(mixing.c1), Twice::from(mixing.c2));
    let loss = Twice::from(1.0) - c1 - c2;
    let (mut h, mut before) = (vec![Twice::from(0.0); cells], vec![Twice::from(0.0); cells]);
    for step in 1..=steps {
        let time = (step as f64 - f64::from(sea.behavior().preroll)) / sea.motion().rate();
        let mut force = vec![0.0; cells];
        for burst in sea.bursts() {
            force.iter_mut().zip(raised(burst, &basin, time)).for_each(|(force, raised)| *force += raised);
        }
        for _ in 0..literal {
            let next = (0..cells).map(|cell| {
                let (x, z) = (cell as i64 % basin.columns as i64, cell as i64 / basin.columns as i64);
                let at = |x: i64, z: i64| {
                    let (columns, rows) = (basin.columns as i64, basin.rows as i64);
                    let (near_x, near_z) = match basin.boundary {
                        Boundary::Replicate => (x.clamp(0, columns - 1), z.clamp(0, rows - 1)),
                        Boundary::Periodic => (x.rem_euclid(columns), z.rem_euclid(rows)),
                        Boundary::Fixed if (0..columns).contains(&x) && (0..rows).contains(&z) => (x, z),
                        Boundary::Fixed => return Twice::from(0.0),
                    };
                    h[(near_z * columns + near_x) as usize]
                };
                let sum = at(x - 1, z) + at(x + 1, z) + at(x, z - 1) + at(x, z + 1);
                c1 * (sum * Twice::from(0.5) - before[cell]) + c2 * h[cell] + loss * Twice::from(force[cell])
            });
            let next = next.collect();
            before = std::mem::replace(&mut h, next);
        }
    }
    h
}

/// Returns a sea with a burst at rest and one that travels, each for a time in seconds.
fn sea_for(basin: Basin, motion: Motion, preroll: u32, seconds: f64) -> ToonSea {
    let far = basin.columns as f64 * basin.spacing;
    let rest = Burst { influence: [0.7, 0.9], height: 0.8, ..Burst::along([[0.3, 0.4]; 4]) };
    let line = [0.0, 1.0, 2.0, 3.0].map(|part| [far * part / 3.0, 0.5]);
    let pass = Burst { duration: 1.7, influence: [0.5, 0.8], height: -1.1, peak: 1.2, ..Burst::along(line) };
    let behavior = Behavior { preroll, ..Behavior::default() };
    let start = -f64::from(preroll) / motion.rate();
    let bursts = [rest, pass].map(|burst| Burst { active: [start, start + seconds], ..burst });
    ToonSea::new(basin, motion, behavior, bursts.into()).expect("stable")
}

fn sea(basin: Basin, motion: Motion, preroll: u32) -> ToonSea {
    sea_for(basin, motion, preroll, 40.0)
}

/// Returns the f64 fields at time 0.
fn exact(sea: &ToonSea) -> Reference {
    let mut run = Run::new(sea, true, NONE);
    assert!(run.reach(0.0, &|| false));
    run.at(0.0)
}

/// Holds a run against the printed recurrence; returns what failed, and how much of the doubt was used.
fn held(sea: &ToonSea, mixing: Mixing, literal: u64) -> Result<f64, String> {
    let preroll = u64::from(sea.behavior().preroll);
    let truth = printed(sea, mixing, preroll, literal);
    let Reference { height, doubt, .. } = exact(sea);
    let mut simulation = sea.simulate(NONE);
    let single = simulation.at(0.0).height;
    let off = |found: &mut dyn Iterator<Item = f64>| {
        found.zip(&truth).fold(0.0_f64, |most, (found, truth)| most.max((*truth - Twice::from(found)).abs()))
    };
    let far = off(&mut height.iter().copied());
    let picture = off(&mut single.iter().map(|height| f64::from(*height)));
    let between = single.iter().zip(&height).fold(0.0_f64, |most, (a, b)| most.max((f64::from(*a) - b).abs()));
    let found = format!("{:?} {mixing:?}, {preroll}: {far:e} of {doubt:?}", sea.basin());
    let size = height.iter().fold(1.0_f64, |most, height| most.max(height.abs()));
    // Where roots of modulus 1 nearly meet, little is certain.
    if far > doubt.height || picture > between + doubt.height || doubt.height >= 1e-2 * size {
        return Err(found);
    }
    Ok(far / doubt.height)
}

/// Mixings next to all edges and corners of the stable region.
fn edges(basin: &Basin) -> Vec<Mixing> {
    let corners = Mixing::stable_region(basin);
    let mut points = corners.clone();
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        points.extend([0.3, 0.5, 0.9].map(|t| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]));
    }
    let inside = |[c1, c2]: [f64; 2]| [1e-2, 1e-5, 1e-9].map(|by| Mixing { c1: (1.0 - by) * c1, c2: (1.0 - by) * c2 });
    points.into_iter().flat_map(inside).collect()
}

#[test]
fn runs_at_all_edges_are_as_near_as_they_say() {
    let mut cases = Vec::new();
    for boundary in [Boundary::Replicate, Boundary::Periodic, Boundary::Fixed] {
        for [columns, rows] in [[5, 4], [4, 7]] {
            let basin = Basin { columns, rows, spacing: 0.25, boundary };
            for (index, mixing) in edges(&basin).into_iter().enumerate() {
                cases.push((basin, mixing, [3, 170, 2900][index % 3]));
            }
        }
    }
    let held = cases.into_par_iter().map(|(basin, mixing, preroll)| {
        let literal = held(&sea(basin, Motion::Literal(mixing), preroll), mixing, 1)?;
        // Steps of other lengths are powers of the literal one, where these are real.
        let resampled = [(60.0, 1), (30.0, 2), (12.0, 5)].into_iter().map(|(rate, literal)| {
            let motion = Motion::Resampled { mixing, rate };
            let accepted = ToonSea::new(basin, motion, Behavior::default(), Vec::new()).is_ok();
            if accepted { held(&sea(basin, motion, preroll / literal as u32), mixing, literal) } else { Ok(0.0) }
        });
        let resampled: Result<Vec<f64>, String> = resampled.collect();
        Ok(resampled?.into_iter().fold(literal, f64::max))
    });
    let held: Vec<Result<f64, String>> = held.collect();
    let failed: Vec<&str> = held.iter().filter_map(|held| held.as_ref().err().map(String::as_str)).collect();
    assert!(failed.is_empty(), "{} of {}\n{}", failed.len(), held.len(), failed.join("\n"));
    assert!(held.len() > 300);
}

/// A million steps.
#[test]
fn long_runs_are_as_near_as_they_say() {
    let mixings = [Mixing { c1: 0.9, c2: 0.1 }, Mixing { c1: 0.999, c2: 9.99e-4 }, Mixing { c1: -0.2, c2: 0.39 }];
    let boundaries = [Boundary::Replicate, Boundary::Periodic, Boundary::Fixed];
    let failed = mixings.into_par_iter().zip(boundaries).filter_map(|(mixing, boundary)| {
        let basin = Basin { columns: 3, rows: 2, spacing: 0.25, boundary };
        held(&sea(basin, Motion::Literal(mixing), 1_000_000), mixing, 1).err()
    });
    let failed: Vec<String> = failed.collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

/// The hostile setting of the notes on numerics: what f32 loses is less than a millionth, where the printed form loses
/// a fiftieth, and the f64 run is known far better.
#[test]
fn nothing_but_rounding_is_lost_where_nothing_decays() {
    let mixing = Mixing { c1: 0.9999, c2: 9.999e-5 };
    let basin = Basin { columns: 24, rows: 24, spacing: 0.25, boundary: Boundary::Replicate };
    let sea = sea_for(basin, Motion::Literal(mixing), 60_000, f64::INFINITY);
    let Reference { height, doubt, .. } = exact(&sea);
    let mut simulation = sea.simulate(NONE);
    let off = simulation.at(0.0).height.iter().zip(&height);
    let off = off.fold(0.0_f64, |most, (found, exact)| most.max((f64::from(*found) - exact).abs()));
    let size = height.iter().fold(0.0_f64, |most, height| most.max(height.abs()));
    println!("{off:e} of {size}, doubt {:e}", doubt.height);
    assert!(off > 0.0 && off < 1e-4 * size, "{off:e} of {size}");
    assert!(doubt.height < off / 4.0, "{:e} of {off:e}", doubt.height);
}

/// Powers and exponentials, of whole steps and of parts: a force that is held for a step does the same in five steps.
#[test]
fn steps_of_all_lengths_are_as_near_as_they_say() {
    let moving = (0..48_u32).into_par_iter().map(|case| {
        let mut random = Random(u64::from(case) + 5);
        let boundary = [Boundary::Replicate, Boundary::Periodic, Boundary::Fixed][case as usize % 3];
        let basin = Basin { columns: 7, rows: 5, spacing: 0.3, boundary };
        let c1 = random.between(0.05, 0.999);
        let mixing = Mixing { c1, c2: (1.0 - c1) * random.between(0.1, 0.999) };
        let rate = if case % 4 == 0 { 60.0 } else { random.between(10.0, 90.0) };
        let physics = Physics {
            speed: random.between(0.0, 20.0),
            damping: random.between(0.0, 9.0) * if case % 5 == 0 { 100.0 } else { 1.0 },
            frequency: random.between(0.1, 9.0),
            push: None,
        };
        let motions = |rate: f64| [Motion::Resampled { mixing, rate }, Motion::Physical { physics, rate }];
        let steps = 5 + case * 5;
        let active = [(-f64::from(steps) + 3.1) / rate, (-f64::from(steps) + 4.05) / rate];
        let at = |motion: Motion, preroll: u32, time: f64| {
            let burst = Burst { active, ..Burst::along([[0.4, 0.5]; 4]) };
            let behavior = Behavior { preroll, ..Behavior::default() };
            let sea = ToonSea::new(basin, motion, behavior, vec![burst]).expect("stable");
            let mut run = Run::new(&sea, true, NONE);
            assert!(run.reach(time, &|| false));
            run.at(time)
        };
        let mut moving = 0;
        for (slow, quick) in motions(rate).into_iter().zip(motions(5.0 * rate)) {
            for time in [0.0, 0.37 / rate, 0.61 / rate] {
                let (one, five) = (at(slow, steps, time), at(quick, 5 * steps, time));
                let off = one.height.iter().zip(&five.height);
                let off = off.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
                let most = one.doubt.height + five.doubt.height;
                assert!(off <= most && most < 1e-7, "{boundary:?} {slow:?} at {time}: {off:e}, doubt {most:e}");
                moving += usize::from(one.height.iter().any(|height| height.abs() > 1e-6));
            }
        }
        moving
    });
    let moving: usize = moving.sum();
    assert!(moving > 100, "{moving}");
}
