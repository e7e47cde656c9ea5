use std::collections::HashSet;
use trochoid_key::{ContentKey, Key};
use trochoid_sea::spray::{Burst, Spray};
use trochoid_sea::toon::{Basin, Behavior, Boundary, Combine, Drift, Mixing, Motion, Physics, Rift, Shape, ToonSea};

/// Returns whether every change of a value gives a key that differs from that of the value and of all other changes.
fn every_change_counts<T: ContentKey + Clone>(value: &T, changes: &[fn(&mut T)]) -> bool {
    let changed = changes.iter().map(|change| {
        let mut changed = value.clone();
        change(&mut changed);
        changed.key()
    });
    let keys: HashSet<Key> = changed.chain([value.key()]).collect();
    keys.len() == changes.len() + 1
}

fn up(number: &mut f64) {
    *number = number.next_up();
}

#[test]
fn every_figure_of_a_spray_counts_to_its_last_bit() {
    let burst = Burst {
        position: [0.0; 3],
        extent: 1.0,
        time: 0.0,
        duration: 1.0,
        direction: [0.0, 1.0, 0.0],
        spread: 0.5,
        speed: 4.0,
        count: 9,
    };
    let spray = Spray { bursts: vec![burst], ..Spray::default() };
    let changes: &[fn(&mut Spray)] = &[
        |spray| up(&mut spray.center[0]),
        |spray| up(&mut spray.center[1]),
        |spray| up(&mut spray.size[1]),
        |spray| up(&mut spray.cell),
        |spray| up(&mut spray.rate),
        |spray| up(&mut spray.threshold),
        |spray| up(&mut spray.width),
        |spray| up(&mut spray.density),
        |spray| up(&mut spray.follow),
        |spray| up(&mut spray.speed),
        |spray| up(&mut spray.cone),
        |spray| up(&mut spray.wind[2]),
        |spray| up(&mut spray.drag),
        |spray| up(&mut spray.lifetime),
        |spray| up(&mut spray.radius),
        |spray| up(&mut spray.growth),
        |spray| up(&mut spray.vary),
        |spray| up(&mut spray.tuft),
        |spray| up(&mut spray.torn),
        |spray| spray.seed += 1,
        |spray| spray.bursts.clear(),
        |spray| up(&mut spray.bursts[0].position[1]),
        |spray| up(&mut spray.bursts[0].extent),
        |spray| up(&mut spray.bursts[0].time),
        |spray| up(&mut spray.bursts[0].duration),
        |spray| up(&mut spray.bursts[0].direction[0]),
        |spray| up(&mut spray.bursts[0].spread),
        |spray| up(&mut spray.bursts[0].speed),
        |spray| spray.bursts[0].count += 1,
    ];
    assert!(every_change_counts(&spray, changes));
}

#[test]
fn every_figure_of_a_toon_sea_counts_to_its_last_bit() {
    let basin = Basin { columns: 20, rows: 30, spacing: 0.5, boundary: Boundary::Replicate };
    let behavior = Behavior::default();
    let motion = |motion| ToonSea::new(basin, motion, behavior, Vec::new()).expect("stable").key();
    let mixing = Mixing::default();
    let physics = Physics { speed: 2.0, damping: 0.5, frequency: 1.0, push: None };
    let motions = [
        motion(Motion::Literal(mixing)),
        motion(Motion::Literal(Mixing { c1: 0.25, ..mixing })),
        motion(Motion::Resampled { mixing, rate: 60.0 }),
        motion(Motion::Resampled { mixing, rate: 59.0 }),
        motion(Motion::Physical { physics, rate: 60.0 }),
        motion(Motion::Physical { physics: Physics { push: Some(1.0), ..physics }, rate: 60.0 }),
    ];
    assert_eq!(motions.iter().collect::<HashSet<_>>().len(), motions.len());
    assert!(every_change_counts(
        &basin,
        &[
            |basin| basin.columns += 1,
            |basin| basin.rows += 1,
            |basin| up(&mut basin.spacing),
            |basin| basin.boundary = Boundary::Fixed,
        ]
    ));
    assert!(every_change_counts(
        &behavior,
        &[
            |behavior| behavior.shape = Shape::Literal,
            |behavior| behavior.oriented = !behavior.oriented,
            |behavior| behavior.injection = Some(0.0),
            |behavior| behavior.preroll += 1,
            |behavior| behavior.rift = Rift { combine: Combine::Nearest, ..behavior.rift },
            |behavior| up(&mut behavior.rift.decay),
            |behavior| behavior.drift = Drift { reach: [1.0, 1.25], ..behavior.drift },
            |behavior| up(&mut behavior.drift.renewal),
        ]
    ));
}
