//! Tests of the fast f64 runs of toon seas against the plain loops.

use crate::random::Random;
use rayon::prelude::*;
use trochoid_sea::toon::reference::{Reference, Run, frame};
use trochoid_sea::toon::*;

const ALL: TrailFields = TrailFields { rift: true, drift: true };

/// Returns a burst, most of it in or near a basin; a hostile one may be far away, huge, or as thin as can be.
fn burst(random: &mut Random, basin: &Basin, is_hostile: bool) -> Burst {
    let size = basin.columns.max(basin.rows) as f64 * basin.spacing;
    let mut place = || random.between(-0.3, 1.3) * size;
    let mut path = std::array::from_fn(|_| [place(), place()]);
    let mut influence = [0.4 + 6.0 * random.unit(), 0.4 + 6.0 * random.unit()].map(|radius| radius * basin.spacing);
    let mut height = random.between(-1.0, 3.0);
    let mut peak = random.between(0.5, 1.5);
    if is_hostile {
        match (6.0 * random.unit()) as usize {
            0 => influence = [1e-3, 1e6],
            1 => influence = [0.5 * size, 1e-3],
            // Nearly a circle through cells, and on one.
            2 => (path, influence) = ([[3.0 * basin.spacing; 2]; 4], [2.0 * basin.spacing; 2]),
            3 => path[3] = [1e9, -1e9],
            4 => (height, peak) = (1e6, 1e3),
            _ => peak = 1e-3,
        }
    }
    let start = random.between(-0.5, 0.5);
    Burst {
        duration: if is_hostile { 1e-3 } else { random.between(0.2, 3.0) },
        offset: random.between(0.0, 10.0),
        height,
        peak,
        influence: influence.map(|radius| radius.max(1e-3)),
        fade: random.between(0.0, 0.3),
        active: if random.unit() < 0.4 { [start, start + 0.3] } else { [f64::NEG_INFINITY, f64::INFINITY] },
        lane: random.between(-3.0, 3.0),
        ..Burst::along(path)
    }
}

/// Returns a sea of few cells, with anything that a sea may have, and a time.
fn sea(case: u64) -> (ToonSea, f64) {
    let mut random = Random(0x9e37_79b9 * (case + 1));
    random.unit();
    let mut below = |count: usize| (random.unit() * count as f64) as usize;
    let basin = Basin {
        columns: 2 + below(45),
        rows: 2 + below(20),
        spacing: [0.3, 1e-3, 25.0, 0.11][below(4)],
        boundary: [Boundary::Replicate, Boundary::Periodic, Boundary::Fixed][below(3)],
    };
    let physics = Physics { speed: 2.0 * basin.spacing, damping: 2.0, frequency: 4.0, push: None };
    let motion = match below(6) {
        0 => Motion::Resampled { mixing: Mixing { c1: 0.9, c2: 0.09 }, rate: 24.0 },
        1 => Motion::Physical { physics, rate: 30.0 },
        2 => Motion::Literal(Mixing { c1: -0.2, c2: 0.39 }),
        3 => Motion::Literal(Mixing::default()),
        _ => Motion::default(),
    };
    let behavior = Behavior {
        shape: if below(4) == 0 { Shape::Literal } else { Shape::Intended },
        oriented: below(3) > 0,
        injection: [None, None, Some(-0.4), Some(0.0)][below(4)],
        preroll: below(40) as u32,
        rift: Rift {
            distance: [1.5, 1e-6, 1e6, 4.0 * basin.spacing][below(4)],
            gain: [0.02, 7.0][below(2)],
            decay: [0.01, 0.0, 900.0][below(3)],
            combine: if below(2) == 0 { Combine::Sum } else { Combine::Nearest },
        },
        drift: Drift {
            reach: [[1.1, 1.25], [1e-3, 1e3], [2.0, 0.5]][below(3)],
            lag: [0.35, -1e3, 0.0][below(3)],
            decay: [0.02, 0.0][below(2)],
            renewal: [0.5, 0.0, 1e3][below(3)],
            period: [0.8, 1e-6, 1e6][below(3)],
        },
    };
    let (count, is_hostile) = (below(9), case % 3 == 2);
    let time = [0.0, 0.25, 0.4171, 0.7 + 1e-3 * case as f64][below(4)];
    let bursts = (0..count).map(|_| burst(&mut random, &basin, is_hostile)).collect();
    (ToonSea::new(basin, motion, behavior, bursts).expect("valid"), time)
}

/// Fails with the first difference.
fn same(found: &Reference, expected: &Reference, of: &str) {
    let fields = |all: &Reference| [&[all.height.clone(), all.rift.clone()][..], &all.drift].concat();
    for (field, (found, expected)) in fields(found).iter().zip(&fields(expected)).enumerate() {
        assert_eq!(found.len(), expected.len(), "field {field} of {of}");
        let cell = found.iter().zip(expected).position(|(found, expected)| found != expected);
        let at = cell.map(|cell| (cell, found[cell], expected[cell]));
        assert!(at.is_none(), "field {field}, {at:?}, of {of}");
    }
    assert_eq!(found.doubt, expected.doubt, "{of}");
}

/// The same numbers as the plain loops, bit for bit but for the sign of a zero, however the time is reached.
#[test]
fn runs_have_the_numbers_of_the_plain_loops() {
    let moving = (0..300_u64).into_par_iter().map(|case| {
        let (sea, time) = sea(case);
        let expected = frame(&sea, time, ALL);
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        assert!(finite(&expected.height) && finite(&expected.rift) && expected.drift.iter().all(|v| finite(v)));
        let mut all = Run::new(&sea, true, ALL);
        if case % 2 == 0 {
            let asked = std::sync::atomic::AtomicU32::new(0);
            let stop = || asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) % 3 == 2;
            all.reach(time / 2.0, &stop);
            all.at(time);
        }
        assert!(all.reach(time, &|| false));
        same(&all.at(time), &expected, &format!("case {case}: {sea:?} at {time}"));
        let mut later = Run::new(&sea, false, ALL);
        for time in [time + 0.3, time] {
            assert!(later.reach(time, &|| false));
        }
        let later = later.at(time);
        assert!(later.height.is_empty() && later.rift == expected.rift && later.drift == expected.drift, "{case}");
        let is_moving = |values: &[f64]| usize::from(values.iter().any(|value| value.abs() > 1e-9));
        [is_moving(&expected.height), is_moving(&expected.rift), is_moving(&expected.drift[2])]
    });
    let moving = moving.reduce(|| [0; 3], |a, b| std::array::from_fn(|field| a[field] + b[field]));
    assert!(moving.iter().all(|&moving| moving > 100), "{moving:?}");
}

/// Rows that end within a vector, ends of bursts between cells, and many threads.
#[test]
fn a_wide_sea_has_the_numbers_of_the_plain_loops() {
    let mut random = Random(77);
    let basin = Basin { columns: 203, rows: 26, spacing: 0.25, boundary: Boundary::Replicate };
    let bursts = (0..20).map(|_| Burst { duration: 9.0, ..burst(&mut random, &basin, false) }).collect();
    let behavior = Behavior { oriented: true, preroll: 30, ..Behavior::default() };
    let sea = ToonSea::new(basin, Motion::default(), behavior, bursts).expect("valid");
    let expected = frame(&sea, 0.1, ALL);
    for threads in [1, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let found = pool.install(|| {
            let mut run = Run::new(&sea, true, ALL);
            assert!(run.reach(0.1, &|| false));
            run.at(0.1)
        });
        same(&found, &expected, &format!("{threads} threads"));
    }
    assert!(expected.height.iter().any(|height| height.abs() > 1e-3));
}
