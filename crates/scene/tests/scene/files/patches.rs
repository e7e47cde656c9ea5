//! Valid and invalid models of patches.

use std::path::Path;
use trochoid_scene::bezier::{Continuity, continuity};
use trochoid_scene::files::patches;

#[test]
fn what_is_no_model_is_refused_by_name_and_place() {
    let refused = |text: &str| patches(text.as_bytes()).unwrap_err().to_string();
    let points = r#""points": [[0,0,0],[1,0,0],[0,0,1],[1,0,1]]"#;
    assert_eq!(
        patches(format!(r#"{{"trochoid_model":1,{points},"patches":[[0,1,2,3]]}}"#).as_bytes()).unwrap().len(),
        1
    );
    for (text, part) in [
        ("{\n\"trochoid_model\": 1,\n\"pints\": []}", "unknown field `pints`"),
        ("{\n\"trochoid_model\": 1,\n\"pints\": []}", "line 3"),
        (r#"{"trochoid_model": 2}"#, "\"trochoid_model\": 2; expected 1"),
        (r#"{"points": []}"#, "found no \"trochoid_model\"; expected \"trochoid_model\": 1"),
        (r#"{"trochoid_model": 1}"#, "found 0 patches"),
        (r#"{"trochoid_model": 1, "points": [[1e300,0,0]]}"#, "point 0"),
        (r#"{"trochoid_model": 1, "points": [[1e999,0,0]]}"#, "line 1"),
        (r#"{"trochoid_model": 1, "points": [[0,0]]}"#, "line 1"),
        (r#"{"trochoid_model": 1, "points": [[0,0,0]], "patches": [[0,0,0]]}"#, "found 3 points"),
        (r#"{"trochoid_model": 1, "points": [[0,0,0]], "patches": [[0,0,7,0]]}"#, "names point 7, but there are 1"),
        (r#"{"trochoid_model": 1, "sheets": [{"rails": [[[0,0,0],[1,0,0]]]}]}"#, "sheet 0: 1 rails"),
    ] {
        assert!(refused(text).contains(part), "{text}: {}", refused(text));
    }
    let nested = "[".repeat(100_000);
    assert!(refused(&nested).contains("line 1"));
}

fn sample(name: &str) -> Continuity {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples").join(name);
    let patches = patches(&std::fs::read(path).unwrap()).unwrap();
    continuity(patches.iter().map(|patch| &patch.shape))
}

#[test]
fn the_teapot_is_newells() {
    let report = sample("teapot.json");
    // Body with bottom, lid, handle and spout each join smoothly within; 8 open edges around rim and lid, 8 at the
    // ends of handle and spout; the tip of the lid and the middle of the bottom are points of 4 patches each.
    assert_eq!((report.patches, report.joints, report.exact, report.smooth), (32, 52, 52, 52), "{report}");
    assert_eq!((report.open, report.points, report.widest_gap), (16, 8, 0.0), "{report}");
}

#[test]
fn the_other_models_join_without_gaps() {
    let wave = sample("great_wave.json");
    assert_eq!((wave.patches, wave.joints, wave.equal_handles), (190, 351, 351), "{wave}");
    for name in ["boat.json", "lighthouse.json", "great_wave.json"] {
        let report = sample(name);
        assert!(report.joints > 100 && report.exact == report.joints, "{name}: {report}");
    }
}
