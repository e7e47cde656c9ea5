//! Tests of drift lines over time: they move, but never jump.

use crate::random::Random;
use std::f64::consts::PI;
use trochoid_sea::toon::lines::{LinePoint, Lines, density};
use trochoid_sea::toon::{
    Basin, Behavior, Boundary, Burst, Drift, LineMasks, LinePlaces, Motion, NearPhase, ToonFrame, ToonSea, TrailFields,
    density_span,
};

const BASIN: Basin = Basin { columns: 180, rows: 150, spacing: 0.2, boundary: Boundary::Replicate };
/// Cells per side of the tiles in which changes are measured.
const TILE: usize = 10;
/// Frames per second.
const RATE: usize = 120;

fn behavior() -> Behavior {
    Behavior { oriented: true, drift: Drift::default(), ..Behavior::default() }
}

/// Returns a burst that turns by more than a right angle, twice.
fn turning() -> Burst {
    let path = [[2.0, 4.0], [34.0, 2.0], [4.0, 28.0], [33.0, 26.0]];
    Burst { duration: 9.0, height: 2.6, influence: [2.0, 3.2], fade: 0.1, ..Burst::along(path) }
}

/// Returns a burst that crosses the wake of the other one, later and with its own lines.
fn crossing() -> Burst {
    let path = [[32.0, 9.0], [24.0, 13.0], [14.0, 11.0], [4.0, 15.0]];
    Burst { offset: -2.0, lane: 5.6, path, ..turning() }
}

/// Returns the mask of every cell, with its neighbors as the adjacent pixels.
fn masks(lines: &Lines, frame: &ToonFrame<'_>, along: bool) -> Vec<f64> {
    let scale = Drift::default().scale();
    let planes = if along { frame.drift.along } else { frame.drift.across };
    let phase = |cell: usize| planes.map(|plane| f64::from(plane[cell]) * scale);
    let Basin { columns, rows, .. } = BASIN;
    (0..columns * rows)
        .map(|cell| {
            let (x, z) = (cell % columns, cell / columns);
            let weight = f64::from(frame.drift.weight[cell]) * scale;
            if weight == 0.0 || x == 0 || z == 0 || x + 1 == columns || z + 1 == rows {
                return 0.0;
            }
            let here = phase(cell);
            let beside = [[phase(cell - 1), phase(cell + 1)], [phase(cell - columns), phase(cell + columns)]];
            let density = density(here, beside);
            lines.mask(&LinePoint { weight, phase: here, height: f64::from(frame.height[cell]), density })
        })
        .collect()
}

/// Returns the largest change of any tile between masks `apart` frames apart, in cells, over all pairs of a run.
fn greatest(run: &[Vec<f64>], apart: usize) -> f64 {
    let across = BASIN.columns / TILE;
    let mut greatest: f64 = 0.0;
    for pair in run.windows(apart + 1) {
        let mut tiles = vec![0.0; across * BASIN.rows / TILE];
        for (cell, (a, b)) in pair[0].iter().zip(&pair[apart]).enumerate() {
            let (x, z) = (cell % BASIN.columns, cell / BASIN.columns);
            tiles[z / TILE * across + x / TILE] += (a - b).abs();
        }
        greatest = tiles.into_iter().fold(greatest, f64::max);
    }
    greatest
}

/// Returns the largest changes over 6 s at 1/120, 1/60 and 1/30 s, across the path and along it.
fn changes(bursts: Vec<Burst>, lines: &Lines) -> [[f64; 3]; 2] {
    let sea = ToonSea::new(BASIN, Motion::default(), behavior(), bursts).expect("valid");
    let mut simulation = sea.simulate(TrailFields { rift: false, drift: true });
    let mut runs = [Vec::new(), Vec::new()];
    for time in (2 * RATE..8 * RATE).map(|frame| frame as f64 / RATE as f64) {
        let frame = simulation.at(time);
        runs.iter_mut().zip([false, true]).for_each(|(run, along)| run.push(masks(lines, &frame, along)));
    }
    runs.map(|run| {
        let drawn = run.iter().map(|mask| mask.iter().sum::<f64>()).sum::<f64>() / run.len() as f64;
        assert!(drawn > 300.0, "there are lines: {drawn}");
        [1, 2, 4].map(|apart| greatest(&run, apart))
    })
}

/// Half the time means half the change, in every tile and at every moment: lines change only by moving and tapering.
#[test]
fn lines_move_and_never_jump() {
    let lines = Lines { finest: 1.0, ..Lines::default() };
    for (name, bursts) in [("turning", vec![turning()]), ("crossing", vec![turning(), crossing()])] {
        for ([quarter, half, whole], way) in changes(bursts, &lines).into_iter().zip(["across", "along"]) {
            println!("{name}, {way}: {quarter} {half} {whole}");
            for (short, long) in [(quarter, half), (half, whole)] {
                let ratio = short / long;
                assert!((0.4..0.6).contains(&ratio), "{name}, {way}: {quarter} {half} {whole}");
            }
        }
    }
}

/// Compares rows in vectors with single positions in f64, on random and hostile values.
/// Returns a part of both components of phases.
fn part<'a>([cos, sin]: &'a [Vec<f32>; 2], of: &std::ops::Range<usize>) -> [&'a [f32]; 2] {
    [&cos[of.clone()], &sin[of.clone()]]
}

#[test]
fn rows_are_places() {
    let mut random = Random(77);
    for round in 0..400 {
        let n = 1 + round % 67;
        let rough = [0.01, 0.3, 6.0][round % 3];
        let mut angle = random.between(-9.0, 9.0);
        // Neighbors of about the same angle; sometimes none at all, or a weight that is nearly 0.
        let mut phases = |len: usize| -> Vec<[f32; 3]> {
            (0..len)
                .map(|_| {
                    angle += random.between(-rough, rough);
                    let weight = [1.0, 0.2, 0.0, 1e-20, 1e-4][(random.unit() * 1.3 * 5.0) as usize % 5] * random.unit();
                    let left = random.between(0.9, 1.0).powf([0.1, 3.0][round % 2]) * weight;
                    [weight as f32, (left * angle.cos()) as f32, (left * angle.sin()) as f32]
                })
                .collect()
        };
        let (own, above, below) = (phases(n + 2), phases(n), phases(n));
        let height: Vec<f32> = (0..n).map(|_| random.between(-3.0, 4.0) as f32).collect();
        let lines = Lines {
            thickness: random.unit(),
            low: random.between(-1.0, 3.0),
            high: if round % 9 == 0 { 1.0 } else { random.between(-1.0, 3.0) },
            shift: random.between(-40.0, 40.0),
            fresh: random.between(0.01, 1.0),
            spread: random.between(0.1, 3.0),
            finest: random.between(0.0, 2.0),
            seed: round as u32,
        };
        let plane = |values: &[[f32; 3]], what: usize| values.iter().map(|value| value[what]).collect::<Vec<f32>>();
        let weight = plane(&own[1..=n], 0);
        let pair = |values: &[[f32; 3]]| [plane(values, 1), plane(values, 2)];
        let (here, [left, right]) = (pair(&own[1..=n]), [pair(&own[..n]), pair(&own[2..])]);
        let [over, under] = [pair(&above), pair(&below)];
        let masks = LineMasks::new(lines);
        let fill = |of: std::ops::Range<usize>| {
            let beside = [[part(&left, &of), part(&right, &of)], [part(&over, &of), part(&under, &of)]];
            let (weight, height) = (&weight[of.clone()], &height[of.clone()]);
            let mut found = vec![f32::NAN; of.len()];
            masks.fill(&LinePlaces { weight, height, phase: part(&here, &of), beside }, &mut found);
            found
        };
        let found = fill(0..n);
        let first = round % n;
        assert_eq!(found[first..], fill(first..n), "the same from another place on");
        for index in 0..n {
            let phase = |[_, cos, sin]: [f32; 3]| [f64::from(cos), f64::from(sin)];
            let beside = [[own[index], own[index + 2]], [above[index], below[index]]].map(|sides| sides.map(phase));
            let here = phase(own[index + 1]);
            let density = density(here, beside);
            let (weight, height) = (f64::from(weight[index]), f64::from(height[index]));
            let expected = lines.mask(&LinePoint { weight, phase: here, height, density });
            // An edge may be off by a few millionths of a line distance, a root near its zero by more.
            let tolerance = 1e-4 + (2e-5 / density).min(1.0);
            let off = (f64::from(found[index]) - expected).abs();
            assert!(off <= tolerance, "round {round}, {index}: {} for {expected}, density {density}", found[index]);
        }
    }
}

#[test]
fn densities_stay_within_their_bounds_as_far_as_phases_may_move() {
    let mut random = Random(9);
    let mut closest = f64::INFINITY;
    for round in 0..30_000 {
        let reach = [0.0, 1e-12, 1e-4, 0.05, 0.0999, 0.3][round % 6];
        let size = [1.0, 0.2, 3e-8, 1e-9, 1e-140, 1e-170][round / 6 % 6];
        let angle = random.between(-PI, PI);
        // A phase, and one that is as far away as it may be, and turned as far as that allows.
        let mut phase = |angle: f64| {
            let length = size * random.between(0.2, 1.0);
            let within = length * reach * (1.0 - 1e-12);
            let turn = angle + (PI / 2.0 + (within / length).asin()).copysign(random.unit() - 0.5);
            let at = [length * angle.cos(), length * angle.sin()];
            let moved = [at[0] + within * turn.cos(), at[1] + within * turn.sin()];
            (NearPhase::new(at, within), moved)
        };
        let here = phase(angle);
        let beside = [-0.4, 0.4, 0.3, -0.2].map(|by| phase(angle + by));
        let near = [[beside[0].0, beside[1].0], [beside[2].0, beside[3].0]];
        let ([low, high], _) = density_span(here.0, near);
        let moved = [[beside[0].1, beside[1].1], [beside[2].1, beside[3].1]];
        let found = density(here.1, moved);
        assert!(low <= found && found <= high, "round {round}: {found} beyond {low} to {high}");
        if reach == 0.0999 && size == 1.0 {
            closest = closest.min((high - found) / found);
        }
    }
    assert!(closest < 1e-3, "bounds are {closest} too large at least");
}

#[test]
fn no_line_is_drawn_where_all_end_before() {
    let mut random = Random(31);
    let [mut ended, mut drawn] = [0; 2];
    for round in 0..20_000 {
        let scale = [1e-6, 1.0, 1e5][round % 3];
        let mut between = |low: f64, high: f64| random.between(low, high);
        let low = scale * between(-1.0, 1.0);
        let high = if round % 100 == 0 { low } else { scale * between(-1.0, 1.0) };
        let lines = Lines { low, high, seed: round as u32, thickness: 1.0, ..Lines::default() };
        // Often about where the longest lines may end.
        let end = low + (high - low) * [1.1, 1.1 + 1e-12, 1.1 - 1e-12, 1.0, between(-1.0, 3.0)][round / 3 % 5];
        let reach = [0.0, 1e-15, 0.1][round / 15 % 3] * scale;
        let is_ended = lines.end_before([end - reach, end + reach]);
        let heights = [end - reach, end, end + reach, end + reach * between(-1.0, 1.0)];
        for line in 0..32 {
            let angle = PI * (f64::from(line) + 0.5) / 16.0;
            let phase = [angle.cos(), angle.sin()];
            let masks = heights.map(|height| lines.mask(&LinePoint { weight: 1.0, phase, height, density: 0.1 }));
            assert!(!is_ended || masks == [0.0; 4], "{masks:?} at {heights:?}: {lines:?}");
            drawn += usize::from(masks != [0.0; 4]);
        }
        ended += usize::from(is_ended);
    }
    assert!(ended > 3000 && drawn > 3000, "{ended}, {drawn}");
}
