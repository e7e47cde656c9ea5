//! Stability of the height field: predicted modes, powers of its step, and runs of the production code.

use super::{duration, figure};
use trochoid_graph::{Figure, Relation, Stability, StabilityMap, Verdict};
use trochoid_sea::toon::{
    Basin, Boundary, Decay, Forecast, LITERAL_HZ, LevelDrift, Mixing, Motion, Physics, Probe, ToonSea, Transient, Trial,
};

/// Number of steps for which a level sea is held.
const DRIFT_STEPS: u64 = 1_000_000;
/// Logarithm of the growth per step below which the rounding of heights hides it.
const LEAST_GROWTH: f64 = 2e-5;
/// Number of points of the map along each axis.
const MAP: usize = 280;
/// Ranges of c₁ and c₂ on the map: the whole stable region of every grid, with a margin.
const RANGES: [[f64; 2]; 2] = [[-1.2, 1.2], [-1.4, 1.4]];
/// Number of measured points of the map along each axis, and of cells along each side of the grid they are measured
/// on.
const MEASURED: usize = 11;
const MEASURED_SIDE: usize = 6;

/// Returns the stability report of an accepted sea, which is stable or at least bounded.
pub(crate) fn toon(sea: &ToonSea) -> Stability {
    let (motion, basin) = (sea.motion(), sea.basin());
    let forecast = Forecast::new(motion, basin);
    let verdict = match forecast {
        Forecast { bounded: false, .. } => Verdict::Unstable,
        Forecast { radius, .. } if radius < 1.0 - 1e-12 => Verdict::Stable,
        _ => Verdict::Bounded,
    };
    let stored = Decay::predicted(motion, basin);
    let explanation = explanation(sea, &stored, verdict);
    let map = match motion {
        Motion::Literal(mixing) | Motion::Resampled { mixing, .. } => Some(map(*mixing, basin)),
        Motion::Physical { .. } => None,
    };
    Stability { verdict, explanation, figures: figures(sea, &forecast, &stored), map }
}

fn cells(basin: &Basin) -> String {
    format!("{} × {} cells", basin.columns, basin.rows)
}

fn explanation(sea: &ToonSea, stored: &Decay, verdict: Verdict) -> Vec<String> {
    let (motion, basin) = (sea.motion(), sea.basin());
    let rate = motion.rate();
    let mut explanation = vec![match verdict {
        Verdict::Stable => format!(
            "Every wave dies away: the slowest loses half in {:.3} steps ({}), and is down to a thousandth in {:.1}.",
            stored.half_life,
            duration(stored.half_life / rate),
            stored.half_life * libm::log2(1000.0),
        ),
        Verdict::Bounded => "No wave grows, but at least one never dies away, so what bursts add to it stays.".into(),
        Verdict::Unstable | Verdict::ClosedForm => {
            "Once bursts push the level of the sea, it drifts without limit: set damping or frequency above 0.".into()
        }
    }];
    // Below this, the level would double in longer than any animation.
    const GROWS: f64 = 1e-12;
    if stored.growth > GROWS && verdict != Verdict::Unstable {
        let doubles = std::f64::consts::LN_2 / stored.growth;
        explanation.push(format!(
            "As 32-bit floats hold its coefficients, a wave that should stay grows by {:.1e} a step, and doubles in {:.1e} \
             steps ({}).",
            stored.growth,
            doubles,
            duration(doubles / rate),
        ));
    }
    match motion {
        Motion::Literal(mixing) | Motion::Resampled { mixing, .. } => {
            let [[low1, high1], [low2, high2]] = mixing.limits(basin);
            let margin = match mixing.margin(basin) {
                none if none < 1e-12 => "any size".into(),
                small if small < 1e-3 => format!("{small:.1e}"),
                margin => format!("{margin:.4}"),
            };
            explanation.push(format!(
                "It becomes unstable with c1 outside {low1:.4} to {high1:.4} at c2 {}, with c2 outside {low2:.4} to \
                 {high2:.4} at c1 {}, or with a change of {margin} in the worst direction.",
                mixing.c2, mixing.c1,
            ));
            if mixing.c1 > 0.0 {
                let Physics { speed, damping, frequency, .. } = mixing.continuum(basin.spacing);
                explanation.push(format!(
                    "As waves: speed {speed:.3} m/s, damping {damping:.2} /s, frequency {frequency:.2} rad/s; mode \
                     \"physical\" with these values is always stable."
                ));
            }
        }
        Motion::Physical { .. } => explanation.push(
            "It is always stable: a step is the exact solution on the grid, at any speed, damping and number of steps \
             per second."
                .into(),
        ),
    }
    explanation
}

fn figures(sea: &ToonSea, forecast: &Forecast, stored: &Decay) -> Vec<Figure> {
    let (motion, basin) = (sea.motion(), sea.basin());
    let probe = Probe::new(motion, basin);
    let small = Forecast::new(motion, probe.basin());
    let (trial, transient) = (Trial::new(motion, basin), Transient::new(motion, basin));
    let (slowest, run) = (Decay::predicted(motion, probe.basin()), Decay::measured(motion, probe.basin()));
    let drifting = LevelDrift::new(motion, &probe, DRIFT_STEPS);
    // A run of 4000 steps shows only what has died away by then, to 1e-26; what swings slowly needs all of that.
    let decides = stored.half_life > 0.5 && stored.half_life < 46.0;
    // Below this growth, what rounding does to heights decides.
    let grows = slowest.growth.is_finite() && slowest.growth.abs() > LEAST_GROWTH;
    let mut figures = vec![
        Figure {
            predicted: Some(forecast.eigenvalues[0]),
            note: "of the mean of 4 neighbors, exactly".into(),
            ..figure("least_eigenvalue", "least eigenvalue of the grid", "")
        },
        Figure {
            predicted: Some(forecast.eigenvalues[1]),
            note: "the level sea, or its flattest wave".into(),
            ..figure("greatest_eigenvalue", "greatest eigenvalue of the grid", "")
        },
        Figure {
            predicted: Some(forecast.radius),
            note: format!("growth in 1/{} s, {}", motion.rate(), cells(basin)),
            ..figure("spectral_radius", "spectral radius", "")
        },
        Figure {
            predicted: Some(small.radius),
            measured: Some(probe.radius()),
            relation: Relation::Equal(1e-6),
            note: format!("2³⁰ steps in f64, {}", cells(probe.basin())),
            ..figure("spectral_radius_small", "  the same on a small grid", "")
        },
        Figure {
            predicted: Some(stored.half_life),
            measured: decides.then_some(trial.half_life),
            relation: Relation::Near(0.05),
            note: format!("{} f32 steps of {}", trial.steps, cells(&trial.basin)),
            ..figure("half_life", "half-life", "steps")
        },
        Figure {
            predicted: Some(slowest.growth),
            measured: grows.then_some(run.growth),
            relation: Relation::Near(0.05),
            note: format!("{} f32 steps, {}", run.steps, cells(probe.basin())),
            ..figure("growth_small", "  ln of growth on a small grid", "")
        },
        Figure {
            predicted: Some(modal_gain(motion, basin)),
            measured: Some(transient.gain),
            relation: if basin.boundary == Boundary::Fixed { Relation::Unrelated } else { Relation::AtLeast(1e-6) },
            note: format!("one wave; all within ±1 m, at step {}", transient.step),
            ..figure("transient_gain", "worst transient gain", "")
        },
        Figure {
            predicted: forecast.stiffness,
            note: "cells/step; explicit waves: ≤ 0.7071".into(),
            ..figure("stiffness", "stiffness c·dt/dx", "")
        },
    ];
    if let Some(explicit) = Probe::explicit(motion, basin) {
        figures.push(Figure {
            measured: Some(explicit.radius()),
            note: "one step of an explicit solver".into(),
            ..figure("explicit_radius", "  growth if explicit", "")
        });
    }
    // Each step rounds by 2⁻²⁴, and errors accumulate for as long as a step is remembered.
    let bounded = (forecast.radius < 1.0 - 1e-6)
        .then(|| transient.gain.max(1.0) * 4.0 / f64::from(1u32 << 24) / (1.0 - forecast.radius));
    figures.extend([
        Figure {
            predicted: bounded,
            measured: Some(drifting.drift),
            relation: Relation::AtMost,
            note: if bounded.is_some() { "a sea held level in f32; a bound" } else { "a sea held level in f32" }.into(),
            ..figure("drift", "drift over 10⁶ steps", "")
        },
        Figure {
            predicted: Some(0.0),
            measured: Some(trial.subnormal_share),
            relation: Relation::Equal(0.0),
            note: format!("of heights in {} steps to rest", trial.steps),
            ..figure("subnormal_share", "subnormal share", "")
        },
        Figure {
            measured: trial.printed_subnormal_share,
            note: "without flushing below 1e-30".into(),
            ..figure("subnormal_share_printed", "  the same as printed", "")
        },
        Figure {
            predicted: Some(0.0),
            note: "heights over a grid cannot fold".into(),
            ..figure("folded_share", "folded share", "")
        },
        Figure {
            predicted: Some(sea.behavior().rift.half_life()),
            note: format!("ln 2/ln(1 + ε), of 1/{LITERAL_HZ} s"),
            ..figure("rift_half_life", "half-life of the rift", "steps")
        },
    ]);
    figures.retain(|figure| figure.predicted.is_some() || figure.measured.is_some());
    figures
}

/// Returns the greatest transient growth of a single wave from any initial state.
fn modal_gain(motion: &Motion, basin: &Basin) -> f64 {
    let (Motion::Literal(mixing) | Motion::Resampled { mixing, .. }) = *motion else { return 1.0 };
    let [low, high] = Forecast::new(motion, basin).eigenvalues;
    let gain = |mode: usize| {
        let lambda = low + (high - low) * mode as f64 / 64.0;
        // Start from 1 after 0 and from 0 after 1: the sum of both is the most for any two heights within ±1.
        let (mut first, mut second, mut most) = ([1.0f64, 0.0], [0.0f64, 1.0], 1.0f64);
        let step = |[now, before]: [f64; 2]| [(2.0 * mixing.c1 * lambda + mixing.c2) * now - mixing.c1 * before, now];
        for _ in 0..400 {
            (first, second) = (step(first), step(second));
            most = most.max(first[0].abs() + second[0].abs());
        }
        most
    };
    (0..=64).map(gain).fold(1.0, f64::max)
}

fn map(mixing: Mixing, basin: &Basin) -> StabilityMap {
    let growth = |mixing: Mixing, basin: &Basin| Forecast::new(&Motion::Literal(mixing), basin);
    let at = |index: usize, size: usize, axis: usize| {
        let [low, high] = RANGES[axis];
        low + (high - low) * (index as f64 + 0.5) / size as f64
    };
    let mixing_at = |cell: usize, size: usize| Mixing { c1: at(cell % size, size, 0), c2: at(cell / size, size, 1) };
    // Measure on a small grid where waves grow as on the sea's own grid: one with the same boundary if possible,
    // otherwise a periodic one, whose spectrum reaches from −1 to 1, as the spectrum of a large grid nearly does.
    let side = |cells: usize| if cells > MEASURED_SIDE { MEASURED_SIDE - cells % 2 } else { cells };
    let small = Basin { columns: side(basin.columns), rows: side(basin.rows), ..*basin };
    let periodic = Basin { boundary: Boundary::Periodic, columns: MEASURED_SIDE, rows: MEASURED_SIDE, ..*basin };
    let alike = |mixing: Mixing| {
        let own = growth(mixing, basin);
        [small, periodic].into_iter().find(|basin| {
            let found = growth(mixing, basin);
            found.bounded == own.bounded && (found.radius - own.radius).abs() < 0.01
        })
    };
    let measured = (0..MEASURED * MEASURED).filter_map(|cell| {
        let mixing = mixing_at(cell, MEASURED);
        let radius = Probe::new(&Motion::Literal(mixing), &alike(mixing)?).radius();
        Some(([mixing.c1, mixing.c2], radius))
    });
    StabilityMap {
        axes: ["c1", "c2"],
        ranges: RANGES,
        size: [MAP; 2],
        growth: (0..MAP * MAP).map(|cell| growth(mixing_at(cell, MAP), basin).radius).collect(),
        region: Mixing::stable_region(basin),
        point: [mixing.c1, mixing.c2],
        measured: measured.collect(),
        note: format!(
            "{}, stable within the line; dots are measured, on {} of the same or a periodic boundary",
            cells(basin),
            cells(&small)
        ),
    }
}
