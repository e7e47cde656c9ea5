//! What f32 loses of a toon sea, step by step, and how that depends on its settings.

use rayon::prelude::*;
use trochoid_graph::{StepErrorGroup, StepErrorRow, StepErrors};
use trochoid_sea::toon::{Basin, Behavior, Body, Boundary, Burst, LITERAL_HZ, Mixing, Motion, Physics, ToonSea};

/// Most cells along each side of the grid that is run.
const SIDE: usize = 48;

/// What moves the water.
#[derive(Clone, Copy)]
enum Mover {
    Rest,
    Travel,
    Body,
}

/// A setting that is run.
type Setting = (String, Motion, Basin, Mover);

/// Runs variants of a sea for a number of steps, in f32 and in f64 beside each other, on a small grid with bursts of its
/// own. Returns `None` soon after `stop` says that they are no longer needed.
pub(crate) fn errors(sea: &ToonSea, most: u64, stop: &(dyn Fn() -> bool + Sync)) -> Option<StepErrors> {
    let basin = *sea.basin();
    let small = Basin { columns: basin.columns.min(SIDE), rows: basin.rows.min(SIDE), ..basin };
    let decades = (0..).flat_map(|power| [1, 2, 5].map(|digit| digit * 10_u64.pow(power)));
    let mut steps: Vec<u64> = decades.take_while(|steps| *steps < most).collect();
    steps.push(most);
    let groups = settings(*sea.motion(), small);
    let flat: Vec<&Setting> = groups.iter().flat_map(|(_, settings)| settings).collect();
    let rows = flat.into_par_iter().map(|(name, motion, basin, mover)| {
        // Settings that are refused have no row.
        let Some(sea) = moved(*motion, *basin, *mover) else { return Some(None) };
        let found = sea.step_errors(&steps, &|| stop())?;
        let share = |part: f64, height: f64| if height > 0.0 { part / height } else { 0.0 };
        Some(Some(StepErrorRow {
            name: name.clone(),
            errors: found.iter().map(|found| share(found.error, found.height)).collect(),
            doubt: found.last().map_or(0.0, |found| share(found.doubt, found.height)),
        }))
    });
    let rows: Option<Vec<Option<StepErrorRow>>> = rows.collect();
    let mut rows = rows?.into_iter();
    let groups = groups
        .into_iter()
        .map(|(name, settings)| StepErrorGroup { name, rows: rows.by_ref().take(settings.len()).flatten().collect() });
    let note = format!(
        "{} × {} cells; largest error of a height, as a share of the largest height",
        small.columns, small.rows
    );
    Some(StepErrors { groups: groups.collect(), steps, note })
}

/// Returns the sea with a motion and something that moves it over its small grid.
fn moved(motion: Motion, basin: Basin, mover: Mover) -> Option<ToonSea> {
    let [x, z] = [basin.columns, basin.rows].map(|cells| cells as f64 * basin.spacing);
    let around = |points: [[f64; 2]; 4]| points.map(|[u, v]| [u * x, v * z]);
    let way = Burst {
        duration: 7.3,
        influence: [0.09 * x, 0.12 * z],
        ..Burst::along(around([[0.2, 0.3], [0.5, 0.9], [0.9, 0.4], [0.7, 0.2]]))
    };
    let bursts = match mover {
        Mover::Rest => vec![Burst { path: around([[0.4, 0.45]; 4]), ..way }],
        Mover::Travel => vec![way],
        Mover::Body => Body { way, length: 0.2 * x, beam: 0.08 * z, draught: 0.5 }.bursts().ok()?,
    };
    ToonSea::new(basin, motion, Behavior::default(), bursts).ok()
}

/// Returns the settings to run, in groups: the sea's own, and changes of one thing at a time.
fn settings(own: Motion, basin: Basin) -> Vec<(&'static str, Vec<Setting>)> {
    let with = |name: String, motion: Motion| (name, motion, basin, Mover::Travel);
    let mixing = match own {
        Motion::Literal(mixing) | Motion::Resampled { mixing, .. } => Some(mixing),
        Motion::Physical { .. } => None,
    };
    let of = |mixing: Mixing| match own {
        Motion::Resampled { rate, .. } => Motion::Resampled { mixing, rate },
        _ => Motion::Literal(mixing),
    };
    let physics = match own {
        Motion::Physical { physics, .. } => physics,
        Motion::Literal(mixing) | Motion::Resampled { mixing, .. } => mixing.continuum(basin.spacing),
    };
    let waves = |physics: Physics| Motion::Physical { physics, rate: own.rate() };
    let mut modes = vec![with("as it is set".into(), own)];
    if let Some(mixing) = mixing {
        let resampled = |rate: f64| (format!("resampled, {rate} Hz"), Motion::Resampled { mixing, rate });
        let literal = ("literal".to_owned(), Motion::Literal(mixing));
        let others = [literal, resampled(LITERAL_HZ), resampled(24.0)].into_iter().filter(|(_, motion)| *motion != own);
        modes.extend(others.map(|(name, motion)| with(name, motion)));
    }
    if mixing.is_some() {
        modes.push(with("physical".into(), waves(physics)));
    }
    let (stiffness, damping) = match mixing {
        Some(mixing) => {
            let loss = |loss: f64| {
                let changed = Mixing { c2: 1.0 - mixing.c1 - loss, ..mixing };
                with(format!("1 - c1 - c2 = {loss:.0e}"), of(changed))
            };
            let slow = |less: f64| {
                let changed = Mixing { c1: 1.0 - less, c2: 0.9 * less };
                with(format!("c1 = 1 - {less:.0e}, c2 = {:.0e}", changed.c2), of(changed))
            };
            ([1e-2, 1e-4, 1e-6, 1e-8].map(loss), [0.5, 1e-2, 1e-3, 1e-4].map(slow))
        }
        None => {
            let quick =
                |by: f64| with(format!("speed × {by}"), waves(Physics { speed: by * physics.speed, ..physics }));
            let slow = |by: f64| {
                let changed = Physics { damping: by * physics.damping, ..physics };
                with(format!("damping × {by}"), waves(changed))
            };
            ([0.1, 1.0, 10.0, 1000.0].map(quick), [10.0, 1.0, 0.01, 1e-4].map(slow))
        }
    };
    let boundary = [("replicate", Boundary::Replicate), ("periodic", Boundary::Periodic), ("fixed", Boundary::Fixed)];
    let boundary = boundary.map(|(name, boundary)| (name.to_owned(), own, Basin { boundary, ..basin }, Mover::Travel));
    let movers =
        [("a burst at rest", Mover::Rest), ("a burst that travels", Mover::Travel), ("a moving body", Mover::Body)];
    let movers = movers.map(|(name, mover)| (name.to_owned(), own, basin, mover));
    vec![
        ("mode", modes),
        ("boundary", boundary.into()),
        ("stiffness", stiffness.into()),
        ("damping", damping.into()),
        ("what moves the water", movers.into()),
    ]
}
