//! Tests of what the f64 runs add for bursts, and of the trails that they keep, against twice the precision.

use crate::random::Random;
use crate::twice::Twice;
use rayon::prelude::*;
use trochoid_sea::toon::reference::{Reference, Run};
use trochoid_sea::toon::*;

const ALL: TrailFields = TrailFields { rift: true, drift: true };

fn twice(value: f64) -> Twice {
    Twice::from(value)
}

/// A burst that is at the start of its path at every step, and so at a place and in a direction that are known exactly.
struct Still<'a> {
    burst: &'a Burst,
    heading: [f64; 2],
}

impl<'a> Still<'a> {
    fn new(burst: &'a Burst) -> Self {
        let [from, to, ..] = burst.path;
        let [x, z] = [to[0] - from[0], to[1] - from[1]];
        let length = (x * x + z * z).sqrt();
        Self { burst, heading: [x / length, z / length] }
    }

    /// Returns the position of a cell relative to it, along x and z.
    fn offset(&self, basin: &Basin, cell: usize) -> [Twice; 2] {
        let place = [cell % basin.columns, cell / basin.columns];
        [0, 1].map(|axis| twice(place[axis] as f64) * twice(basin.spacing) - twice(self.burst.path[0][axis]))
    }

    /// Returns the same along its heading and across.
    fn turned(&self, basin: &Basin, cell: usize) -> [Twice; 2] {
        let [x, z] = self.offset(basin, cell);
        let [cos, sin] = self.heading.map(twice);
        [x * cos + z * sin, z * cos - x * sin]
    }

    /// Returns a position relative to its radii, which are scaled.
    fn scaled(&self, place: [Twice; 2], scale: [f64; 2]) -> Twice {
        let [a, l] = [0, 1].map(|axis| {
            place[axis] / (twice(self.burst.influence[axis]) * twice(self.burst.peak) * twice(scale[axis]))
        });
        a * a + l * l
    }

    /// Returns its height in a cell.
    fn height(&self, basin: &Basin, cell: usize) -> Twice {
        let distance = self.scaled(self.turned(basin, cell), [1.0; 2]).sqrt();
        let [_, cos] = (twice(0.0) - (twice(0.0) - distance).max(twice(-1.0))).sincos();
        twice(self.burst.peak) * twice(self.burst.height) * twice(0.5) * (cos + twice(1.0))
    }

    /// Returns what it adds to drift lines of a cell in a lap of a path that is shorter than a line.
    fn drift(&self, basin: &Basin, drift: &Drift, cell: usize, lap: i64) -> [Twice; 5] {
        let [a, l] = self.turned(basin, cell);
        let inside = (twice(1.0) - self.scaled([a, l], drift.reach)).max(twice(0.0));
        if inside.abs() == 0.0 {
            return [twice(0.0); 5];
        }
        let weight = inside * inside;
        let soft = twice(1.5) * twice(basin.spacing);
        let swept = twice(drift.lag) * (l * l + soft * soft).sqrt();
        let turn = twice(drift.period) * twice(f64::from(Drift::LINES));
        let laps = lap.rem_euclid(16) as f64 / 16.0;
        let [along_sin, along_cos] = (twice(2.0) * ((a - swept) / turn + twice(laps))).sincos();
        let [across_sin, across_cos] = (twice(2.0) * (l + twice(self.burst.lane)) / turn).sincos();
        [weight, weight * along_cos, weight * along_sin, weight * across_cos, weight * across_sin]
    }
}

/// Returns the share of a trail that some literal steps leave, and what they add.
fn decayed(decay: f64, steps: u32) -> [Twice; 2] {
    let one = twice(1.0) / (twice(1.0) + twice(decay));
    let (mut left, mut added) = (twice(1.0), twice(0.0));
    for _ in 0..steps {
        left = left * one;
        added = added + left;
    }
    [left, added]
}

/// Returns rift and drift of a cell after all steps before time 0, each of some literal steps.
fn trails(sea: &ToonSea, bursts: &[Still<'_>], literal: u32, cell: usize) -> [Twice; 6] {
    let (basin, behavior) = (sea.basin(), sea.behavior());
    let (rift, drift) = (&behavior.rift, &behavior.drift);
    let mut deep = twice(0.0);
    for burst in bursts {
        let [x, z] = burst.offset(basin, cell);
        let inside = (twice(rift.distance) - (x * x + z * z).sqrt()).max(twice(0.0));
        deep = if rift.combine == Combine::Sum { deep + inside } else { deep.max(inside) };
    }
    let [left, added] = decayed(rift.decay, literal);
    let [drift_left, drift_added] = decayed(drift.decay, literal);
    let steps = i64::from(behavior.preroll);
    // What bursts add repeats every 16 laps.
    let sums: Vec<[Twice; 5]> = (0..steps.min(16))
        .map(|lap| {
            bursts.iter().fold([twice(0.0); 5], |mut sums, burst| {
                let added = burst.drift(basin, drift, cell, lap - steps + 1);
                sums.iter_mut().zip(added).for_each(|(sum, added)| *sum = *sum + added);
                sums
            })
        })
        .collect();
    let mut values = [twice(0.0); 6];
    for step in 0..steps as usize {
        values[0] = values[0] * left + deep * twice(rift.gain) * added;
        let sums = sums[step % 16];
        let renewed = twice(1.0) + twice(drift.renewal) * twice(f64::from(literal)) * sums[0];
        for (value, sum) in values[1..].iter_mut().zip(sums) {
            *value = (*value * drift_left + sum * drift_added) / renewed;
        }
    }
    values
}

/// Returns a burst in or near a basin; its rim, or that of its drift lines, often passes a cell by next to nothing.
fn burst(random: &mut Random, basin: &Basin, behavior: &Behavior, rate: f64) -> Burst {
    let mut below = |count: usize| (random.unit() * count as f64) as usize;
    let sizes = [1e-3, 0.3, 1.0, 2.7, 40.0, 1e4];
    let influence = [0, 1].map(|_| (sizes[below(6)] * basin.spacing).max(1e-3));
    let heading: [f64; 2] = [[3.0, 4.0], [-4.0, 3.0], [1.0, 0.0], [5.0, -12.0]][below(4)];
    let cell = [below(basin.columns), below(basin.rows)].map(|index| index as f64 * basin.spacing);
    let length = heading[0].hypot(heading[1]);
    let peak = [1.0, 0.7, 1.3][below(3)];
    let rims = [0.0, influence[0] * peak, influence[0] * peak * behavior.drift.reach[0], behavior.rift.distance];
    let rim = rims[below(4)] * (1.0 - [1e-3, 1e-6, 1e-9, 1e-12, -1e-12, 0.3][below(6)]);
    let from = [0, 1].map(|axis| cell[axis] - rim * heading[axis] / length);
    let step = 1e-2 * behavior.drift.period;
    let far = |times: f64| [0, 1].map(|axis| from[axis] + times * step * heading[axis]);
    Burst {
        duration: 1.0 / rate,
        height: [1.0, -2.0][below(2)],
        peak,
        influence,
        lane: random.between(-3.0, 3.0),
        ..Burst::along([from, far(1.0), far(1.5), far(2.0)])
    }
}

/// Returns a sea of bursts at the starts of their paths, and the number of literal steps in one of its.
fn sea(case: u64, motion: impl Fn(f64) -> Motion, most_steps: u32) -> (ToonSea, u32) {
    let mut random = Random(0x9e37_79b9 * (case + 1));
    random.unit();
    let mut below = |count: usize| (random.unit() * count as f64) as usize;
    let boundary = [Boundary::Replicate, Boundary::Periodic, Boundary::Fixed][below(3)];
    let spacing = [0.3, 1e-3, 25.0, 0.11][below(4)];
    let basin = Basin { columns: [3, 11, 30][below(3)], rows: [2, 3, 5][below(3)], spacing, boundary };
    // Times of steps are exact.
    let (rate, literal) = [(1.0, 60), (2.0, 30), (4.0, 15), (0.5, 120)][below(4)];
    let behavior = Behavior {
        oriented: true,
        injection: Some([1.0, 0.3][below(2)]),
        preroll: 1 + below(most_steps as usize) as u32,
        rift: Rift {
            distance: [1.5, 1e-3, 50.0][below(3)] * spacing,
            gain: [0.02, 7.0][below(2)],
            decay: [0.01, 0.0, 900.0, 1e-14][below(4)],
            combine: if below(2) == 0 { Combine::Sum } else { Combine::Nearest },
        },
        drift: Drift {
            reach: [[1.1, 1.25], [1e-2, 30.0], [2.0, 0.5]][below(3)],
            lag: [0.35, -1e3, 0.0][below(3)],
            decay: [0.02, 0.0, 1e-14][below(3)],
            renewal: [0.5, 0.0, 1e3, 1e-4][below(4)],
            period: [0.8, 0.05, 1e3][below(3)],
        },
        ..Behavior::default()
    };
    let count = 1 + below(4);
    let bursts = (0..count).map(|_| burst(&mut random, &basin, &behavior, rate)).collect();
    (ToonSea::new(basin, motion(rate), behavior, bursts).expect("stable"), literal)
}

/// Returns the fields at time 0.
fn exact(sea: &ToonSea, heights: bool) -> Reference {
    let mut run = Run::new(sea, heights, ALL);
    assert!(run.reach(0.0, &|| false));
    run.at(0.0)
}

/// Returns how far numbers are off at most.
fn off(found: &[f64], truth: impl Iterator<Item = Twice>) -> f64 {
    found.iter().zip(truth).fold(0.0_f64, |most, (found, truth)| most.max((truth - twice(*found)).abs()))
}

/// Returns the largest share of a doubt that is used, if there is any.
fn used(found: &[f64], truth: impl Iterator<Item = Twice>, doubt: f64) -> f64 {
    let off = off(found, truth);
    if off > 0.0 { off / doubt } else { 0.0 }
}

#[test]
fn trails_are_as_near_as_they_say() {
    let shares = (0..600_u64).into_par_iter().map(|case| {
        let motion = |rate: f64| Motion::Resampled { mixing: Mixing::default(), rate };
        let (sea, literal) = sea(case, motion, if case % 8 == 0 { 3000 } else { 40 });
        let bursts: Vec<Still<'_>> = sea.bursts().iter().map(Still::new).collect();
        let truth: Vec<[Twice; 6]> =
            (0..sea.basin().cells()).map(|cell| trails(&sea, &bursts, literal, cell)).collect();
        let Reference { rift, drift, doubt, .. } = exact(&sea, false);
        let field = |index: usize| truth.iter().map(move |values| values[index]);
        let of_rift = used(&rift, field(0), doubt.rift);
        let of_drift = (0..5).map(|index| used(&drift[index], field(index + 1), doubt.drift)).fold(0.0, f64::max);
        assert!(of_rift <= 1.0 && of_drift <= 1.0, "{case}: {of_rift}, {of_drift} of {doubt:?} of {sea:?}");
        [of_rift, of_drift]
    });
    let most = shares.reduce(|| [0.0; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
    println!("largest shares used: {most:?}");
    assert!(most.iter().all(|&most| most > 0.03), "{most:?}");
}

/// Bursts whose rims pass cells by next to nothing: the first step raises cells by the force alone. What these are off by
/// may be much more than roundings of the heights themselves.
#[test]
fn forces_are_as_near_as_they_say() {
    let shares = (0..3000_u64).into_par_iter().map(|case| {
        let (sea, _) = sea(case, |_| Motion::Literal(Mixing::default()), 1);
        let bursts: Vec<Still<'_>> = sea.bursts().iter().map(Still::new).collect();
        let injection = sea.behavior().injection.map_or(twice(1.0), twice);
        let truth = (0..sea.basin().cells()).map(|cell| {
            let heights = bursts.iter().map(|burst| burst.height(sea.basin(), cell));
            injection * heights.fold(twice(0.0), |sum, height| sum + height)
        });
        let Reference { height, doubt, .. } = exact(&sea, true);
        let largest = height.iter().fold(0.0_f64, |most, height| most.max(height.abs()));
        let off = off(&height, truth);
        // The bound on heights is larger than that on the force, the more the larger the basin is.
        let response = 1.0 + 2.0 * (sea.basin().cells() as f64).sqrt();
        assert!(off <= doubt.height, "{case}: {off:e} of {doubt:?} of {sea:?}");
        [if off > 0.0 { off / (doubt.height / response) } else { 0.0 }, off / largest.max(1e-9)]
    });
    let [used, relative] = shares.reduce(|| [0.0; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
    println!("largest share used: {used}; off by {relative:e} of the largest height");
    assert!(used > 0.05 && used < 1.0 && relative > 1e-12, "{used}, {relative:e}");
}
