#![allow(clippy::unwrap_used, reason = "a test may panic")]

use super::*;
use crate::parse;
use std::path::Path;
use trochoid_engine::{Settings, Silent};
use trochoid_graph::Tolerance;

/// A sea in a picture that is small enough for all of its references.
const SEA: &str = r##"{ "trochoid": 1,
  "format": { "width": 24, "height": 14 }, "working_space": "linear-srgb",
  "nodes": { "camera": { "type": "Camera", "position": [0, 6, 30], "target": [0, 1, 0] },
             "sea": { "type": "GerstnerSea", "count": 12 },
             "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
             "fresnel": { "type": "Fresnel", "view": "view" },
             "water": { "type": "Mix", "a": "#1a2438", "b": "#93b4a6", "weight": "fresnel" } },
  "outputs": { "beauty": { "color": "water" } } }"##;

const RAMP: &str = r##"{ "trochoid": 1, "format": { "width": 24, "height": 14 },
  "nodes": { "across": { "type": "ScreenX" },
             "mix": { "type": "Mix", "a": "#123", "b": "#fed", "weight": "across" } },
  "outputs": { "beauty": { "color": "mix" } } }"##;

fn ladder(text: &str, effort: Effort, seed: u64, clock: &(dyn Fn() -> f64 + Sync)) -> Ladder {
    let load = |set: &[String]| parse("sea.json", text, Path::new("."), set);
    let settings = Settings::default();
    let request = Request { outputs: &["beauty"], frame: 1, tolerance: Tolerance::Exact, settings: &settings };
    let asked = LadderRequest { request, format: None, effort, seed, tolerances: &[1.0 / 8.0, 1e-7] };
    climb_by(&load, &asked, clock, &Silent).unwrap()
}

/// Everything of a rung that is no time.
type Figures<'a> = (&'a [String], Option<&'a ErrorFigures>, Option<&'a ErrorFigures>, Option<Estimate>);

fn figures(ladder: &Ladder) -> Vec<Figures<'_>> {
    ladder
        .rungs
        .iter()
        .map(|rung| (&rung.set[..], rung.certified.as_ref(), rung.measured.as_ref(), rung.ambiguous))
        .collect()
}

#[test]
fn figures_follow_from_seed_and_number_of_pixels_and_bounds_hold() {
    let still = || 0.0;
    let some = ladder(SEA, Effort::Pixels(50), 1, &still);
    assert_eq!((some.looked_at.picture, some.looked_at.apart, some.looked_at.total), (64, 64, 336));
    assert!(some.looked_at.differing > 64 && some.looked_at.all < 64 + 64 + 7, "{:?}", some.looked_at);
    assert_eq!(figures(&some), figures(&ladder(SEA, Effort::Pixels(64), 1, &|| 1e9)));
    assert_ne!(figures(&some), figures(&ladder(SEA, Effort::Pixels(64), 2, &still)));
    // With time for all pixels, all are looked at, and intervals have no width.
    let all = ladder(SEA, Effort::Within(1.0), 1, &still);
    assert_eq!((all.looked_at.picture, all.looked_at.all), (336, 336));
    assert_eq!(all.shortfall, Shortfall::default());
    let whole = ladder(SEA, Effort::Whole(64), 1, &still);
    assert_eq!((some.rungs.len(), all.rungs.len(), whole.rungs.len()), (7, 7, 7));
    for ((some, all), whole) in some.rungs.iter().zip(&all.rungs).zip(&whole.rungs) {
        assert!(some.broken.is_empty() && all.broken.is_empty(), "{:?}", all.broken);
        let [part, full, map] = [some, all, whole].map(|rung| rung.certified.as_ref().unwrap());
        assert_eq!((full.max, full.clear_max, &full.picture), (map.max, map.clear_max, &map.picture));
        assert!(part.max.unwrap().size.display <= full.max.unwrap().size.display);
        let measured = [some, all].map(|rung| rung.measured.as_ref().unwrap());
        for (errors, bounds) in measured.iter().zip([part, full]) {
            assert!(errors.max.unwrap().size.display <= bounds.max.unwrap().size.display);
            assert!(errors.picture.rms() <= errors.max.map(|at| at.size.display));
        }
        let median = full.picture.quantile(0.5).unwrap();
        assert_eq!((median.low, median.high), (median.value, median.value));
        // The interval of some pixels holds that of all: chosen at a confidence of 95 %, and by this seed.
        let [few, true_share] = [part, full].map(|figures| figures.picture.above(1e-3).unwrap());
        assert!(few.low <= true_share.value && true_share.value <= few.high, "{few:?}, {true_share:?}");
        assert_eq!(whole.map.len(), 336);
    }
    assert!(whole.is_whole && !whole.scalings.is_empty() && some.scalings.is_empty());
    assert!(some.costly > 0 && whole.rungs.iter().all(|rung| rung.certify.is_some_and(|time| !time.is_predicted)));
    assert!(some.attempts[0].rung.is_some() && some.attempts[1].limit.is_some(), "{:?}", some.attempts);
    assert!(some.unseen.is_empty());
}

#[test]
fn what_does_not_fit_into_the_time_is_left_out_and_said() {
    // Past the time for rendering: one picture is made in any case.
    let late = ladder(SEA, Effort::Within(10.0), 1, &|| 5.0);
    assert_eq!((late.rungs.len(), late.shortfall.settings.len()), (1, 6));
    assert!(late.rungs[0].certified.is_some() && late.rungs[0].measured.is_some() && late.shortfall.bounds == 0);
    assert_eq!((late.rungs[0].times.runs(), late.rungs[0].predicted), (1, None));
    // Past the time for pixels.
    let later = ladder(SEA, Effort::Within(10.0), 1, &|| 8.5);
    assert_eq!((later.shortfall.bounds, later.shortfall.references, later.looked_at.all), (1, true, 0));
    assert!(later.rungs[0].certified.is_none() && later.rungs[0].certify.is_none() && !later.rungs[0].is_best);
    assert!(later.attempts.iter().all(|attempt| attempt.rung.is_none()));
}

#[test]
fn settings_that_change_nothing_are_not_taken_apart() {
    let ramp = ladder(RAMP, Effort::Pixels(32), 1, &|| 0.0);
    assert_eq!((ramp.rungs.len(), ramp.looked_at.differing, ramp.looked_at.apart), (1, 0, 0));
    let rung = &ramp.rungs[0];
    let certified = rung.certified.as_ref().unwrap().max.unwrap().size.display;
    assert!(certified > 0.0 && certified < 1e-5 && rung.broken.is_empty() && rung.is_best);
    assert_eq!(rung.ambiguous.map(|share| share.value), Some(0.0));
    assert!(ramp.unseen.is_empty());
}

#[test]
fn a_surface_that_the_view_does_not_show_is_named() {
    let far = SEA.replace("[0, 6, 30]", "[0, 3000000000, 10000000000]").replace("[0, 1, 0]", "[0, 3, 0]");
    let far = ladder(&far, Effort::Pixels(16), 1, &|| 0.0);
    assert_eq!(far.unseen, [Unseen { view: "view".into(), nodes: vec!["sea".into()] }]);
}
