//! Warnings of toon seas that do what nobody wants.

use crate::sea::toon_sea::ToonSea;
use trochoid_graph::Check;
use trochoid_sea::toon::{self as model, Boundary, Forecast, Motion, Physics, Shape};

/// Warns about a sea that drifts, sinks, or has no waves.
pub(crate) fn check(sea: &model::ToonSea, check: &mut Check<'_>) {
    check_free(sea, check);
    check_literal(sea, check);
    check_bursts(sea, check);
}

/// Warns about a level sea with neither damping nor a restoring force.
fn check_free(sea: &model::ToonSea, check: &mut Check<'_>) {
    if !Forecast::new(sea.motion(), sea.basin()).bounded {
        let found = "damping 0 and frequency 0, so the sea's level drifts without limit once bursts push it";
        let remedy = "raise \"damping\" or \"frequency\"";
        check.warning(ToonSea::DAMPING, found, "damping or a restoring force", remedy);
    }
}

/// Warns about printed bursts, which push down the water wherever they are not.
fn check_literal(sea: &model::ToonSea, check: &mut Check<'_>) {
    // The printed profile far from a burst: cos(π + 1) of its height.
    let far = -libm::cos(1.0) * sea.bursts().iter().map(|burst| burst.height).sum::<f64>() * sea.injection();
    if sea.behavior().shape != Shape::Literal || far == 0.0 {
        return;
    }
    // What a level sea gives back, as a share of its height, equals what bursts push where the sea comes to rest.
    let back = match *sea.motion() {
        Motion::Literal(mixing) | Motion::Resampled { mixing, .. } => mixing.loss(),
        Motion::Physical { physics: Physics { frequency, push, .. }, .. } => {
            let own = frequency * frequency;
            push.map_or(1.0, |push| own / push)
        }
    };
    let level = far / back;
    let found = if level.is_finite() && back > 0.0 {
        let whither = if level < 0.0 { "sink" } else { "lift" };
        format!("bursts as printed, which {whither} the whole sea toward {level:.2} m while all of them last")
    } else {
        "bursts as printed, which move the whole sea without limit while they last".into()
    };
    let remedy =
        "set \"burst\" to \"intended\"; or raise \"level\", and set thresholds by the heights that the notes tell";
    check.warning(ToonSea::BURST, found, "bursts that move only the water around them", remedy);
}

/// Warns about a sea without waves.
fn check_bursts(sea: &model::ToonSea, check: &mut Check<'_>) {
    let remedy = "add \"guides\" or \"bursts\" with a \"path\" on the grid";
    if sea.bursts().is_empty() {
        let found = "no bursts, guides or bodies, so the sea is flat";
        return check.warning(ToonSea::BURSTS, found, "at least one of them", remedy);
    }
    let basin = sea.basin();
    let sides = [basin.columns, basin.rows].map(|cells| (cells - 1) as f64 * basin.spacing);
    // A profile ends within three radii.
    let misses = |burst: &model::Burst| {
        let reach = 3.0 * burst.influence[0].max(burst.influence[1]) * burst.peak.max(1.0);
        (0..2).any(|axis| {
            burst.path.iter().all(|point| point[axis] < -reach)
                || burst.path.iter().all(|point| point[axis] > sides[axis] + reach)
        })
    };
    if basin.boundary != Boundary::Periodic && sea.bursts().iter().all(misses) {
        let [x, z] = sides;
        let found = format!("every path outside the grid of {x:.2} × {z:.2} m, so the sea is flat");
        let item = if sea.bursts().len() > 1 { ToonSea::GUIDES } else { ToonSea::BURSTS };
        check.warning(item, found, "a path over the grid", remedy);
    }
}
