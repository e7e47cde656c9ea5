//! Stability of sums of waves: they are closed forms, so only phases and folds can fail.

use super::{duration, figure};
use trochoid_graph::{Figure, Relation, Stability, Verdict};
use trochoid_sea::{FieldSet, Fields, FoldOptions, Points, Sea, Wave};

/// Distance in meters, and time in seconds, at which phases are measured.
const FAR: f64 = 1e7;
/// Phase error, in turns, at which an error could become visible.
const VISIBLE: f64 = 1e-3;
/// Number of points at which f32 heights are compared with the f64 sum.
const POINTS: usize = 64;
/// Maximum number of terms (waves times points) in the f64 sum.
const TERMS: usize = 4_000_000;
/// Times at which folds are looked for, in seconds.
const TIMES: [f64; 4] = [0.0, 1.0, 10.0, 1000.0];

/// Returns the stability report of a sum of waves.
pub(crate) fn waves(waves: Vec<Wave>) -> Stability {
    let sea = Sea::new(waves);
    let (mut explanation, mut figures) = (Vec::new(), Vec::new());
    explanation.push(
        "Every frame is computed from its own time: nothing carries over from frame to frame, so no error grows."
            .into(),
    );
    if !sea.waves().is_empty() {
        phases(&sea, &mut explanation, &mut figures);
        heights(&sea, &mut figures);
    }
    if sea.waves().iter().any(|wave| wave.horizontal != 0.0) {
        folds(&sea, &mut explanation, &mut figures);
    } else {
        explanation.push("Nothing folds: waves only move up and down.".into());
    }
    Stability { verdict: Verdict::ClosedForm, explanation, figures, map: None }
}

fn phases(sea: &Sea, explanation: &mut Vec<String>, figures: &mut Vec<Figure>) {
    let worst = |of: &dyn Fn(&Wave) -> f64| sea.waves().iter().map(of).fold(0.0, f64::max);
    let places = [[0.0, 0.0], [FAR, -FAR], [-FAR, 0.3 * FAR]];
    let measured = |wave: &Wave| places.iter().map(|&place| wave.phase_error(place, FAR)).fold(0.0, f64::max);
    let bound = |wave: &Wave| places.iter().map(|&place| wave.phase_error_bound(place, FAR)).fold(0.0, f64::max);
    let rate = worst(&|wave| wave.phase_error_bound([0.0; 2], FAR)) / FAR;
    let reach = worst(&|wave| wave.phase_error_bound([FAR, FAR], 0.0)) / FAR;
    explanation.push(format!(
        "Phases are accurate to a thousandth of a turn for {}, and up to {:.0e} m from the origin; beyond, the \
         fastest or the shortest wave is less accurate.",
        duration(VISIBLE / rate),
        VISIBLE / reach,
    ));
    figures.push(Figure {
        predicted: Some(worst(&bound)),
        measured: Some(worst(&measured)),
        relation: Relation::AtMost,
        note: "x = t = 1e7, in twice the precision".into(),
        ..figure("phase_error", "greatest error of a phase", "turns")
    });
    figures.push(Figure {
        predicted: Some(VISIBLE / rate),
        note: "until a phase is 1e-3 turns off".into(),
        ..figure("exact_until", "phases are exact for", "s")
    });
}

/// Compares the f32 sum with the f64 sum, far away and late.
fn heights(sea: &Sea, figures: &mut Vec<Figure>) {
    let points = (TERMS / sea.waves().len()).clamp(4, POINTS);
    let longest = sea.waves().iter().map(|wave| wave.wavelength).fold(0.0, f64::max);
    let along = |ratio: f64| -> Vec<f64> {
        let turns = |index: usize| (ratio * (index + 1) as f64).fract();
        (0..points).map(|index| FAR + 3.0 * longest * turns(index)).collect()
    };
    let (x, z, footprint) = (along(0.754_877_666), along(0.569_840_291), vec![0.0; points]);
    let frame = sea.at(FAR);
    let mut fields = Fields::default();
    let wanted = FieldSet { displacement: true, ..FieldSet::default() };
    frame.direct(Points { x: &x, z: &z, footprint: &footprint }, wanted, &mut fields);
    let rms = sea.height_rms();
    let off = |index: usize| {
        let exact = frame.evaluate([x[index], z[index]], 0.0).displacement[1];
        (f64::from(fields.displacement[1][index]) - exact).abs()
    };
    let worst = (0..points).map(off).fold(0.0, f64::max);
    figures.push(Figure {
        predicted: Some(2e-5),
        measured: Some(if rms > 0.0 { worst / rms } else { worst }),
        relation: Relation::AtMost,
        note: format!("f32 at {points} points, over the RMS"),
        ..figure("height_error", "greatest error of a height", "")
    });
}

fn folds(sea: &Sea, explanation: &mut Vec<String>, figures: &mut Vec<Figure>) {
    let folds = TIMES.map(|time| sea.folding(FoldOptions { time, ..FoldOptions::default() }));
    let least = folds.iter().map(|fold| fold.jacobian_min).fold(f64::INFINITY, f64::min);
    let share = folds.iter().map(|fold| fold.folded_share).fold(0.0, f64::max);
    let scale = folds.iter().map(|fold| fold.unfolded_scale).fold(f64::INFINITY, f64::min);
    let (fold, samples) = (folds[0], FoldOptions::default().samples);
    // The bound holds only for waves with the settled signs.
    let proved = fold.proved() && sea.waves().iter().all(|wave| wave.horizontal >= 0.0);
    explanation.push(match (proved, scale.is_finite()) {
        (true, _) => format!(
            "Nothing folds anywhere at any time: λ1 is {:.3}, less than 1. The proof holds until every sharpness is \
             multiplied by {:.3}.",
            fold.lambda[0],
            1.0 / fold.lambda[0],
        ),
        (false, true) => format!(
            "Crests fold over on {:.2} % of the sea; with every sharpness times {scale:.3}, on a thousandth of it.",
            100.0 * share
        ),
        (false, false) => "Crests are flat and troughs sharp, as printed in the thesis; no crest folds over.".into(),
    });
    figures.extend([
        Figure {
            predicted: Some(fold.lambda[0]),
            note: "less than 1 proves that nothing folds".into(),
            ..figure("fold_eigenvalue", "λ1 of Σ q d dᵀ", "")
        },
        Figure {
            predicted: Some(fold.q_sum),
            note: "at most 1 suffices, but is too strict".into(),
            ..figure("fold_sum", "Σq", "")
        },
        Figure {
            predicted: proved.then(|| fold.jacobian_infimum()),
            measured: Some(least),
            // The slack covers strains, which are f32.
            relation: if proved { Relation::AtLeast(0.0) } else { Relation::Unrelated },
            note: format!("{samples} points at {} times{}", TIMES.len(), if proved { "; a bound" } else { "" }),
            ..figure("jacobian", "least det J", "")
        },
        Figure {
            predicted: proved.then_some(0.0),
            measured: Some(share),
            relation: Relation::Equal(0.0),
            note: "of those points".into(),
            ..figure("folded_share", "folded share", "")
        },
    ]);
}
