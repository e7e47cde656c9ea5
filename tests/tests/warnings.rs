//! Documents that are legal and mean nothing, or less than their author thinks: what `check` says of them, and of
//! documents beside them that are sound.

use std::path::Path;
use trochoid::parse;

/// Seas, a camera and views of them; the output is a mask.
fn warnings(out: &str) -> Vec<String> {
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 4 }}, "nodes": {{
"camera": {{ "type": "Camera" }}, "ripples": {{ "type": "RippleSea" }},
"toon": {{ "type": "ToonSea", "columns": 16, "rows": 16 }}, "waves": {{ "type": "GerstnerSea", "count": 4 }},
"steep": {{ "type": "GerstnerSea", "count": 4, "sharpness": 5 }},
"on_ripples": {{ "type": "Render", "camera": "camera", "surfaces": ["ripples"] }},
"on_toon": {{ "type": "Render", "camera": "camera", "surfaces": ["waves", "toon"] }},
"on_waves": {{ "type": "Render", "camera": "camera", "surfaces": ["waves"] }},
"on_steep": {{ "type": "Render", "camera": "camera", "surfaces": ["steep"] }},
"out": {{ {out} }} }},
"outputs": {{ "out": {{ "field": "out" }} }} }}"#
    );
    let loaded = parse("test.json", &text, Path::new("."), &[]).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let all = loaded.warnings.iter().map(ToString::to_string);
    all.filter(|text| !text.contains("no output needs")).collect()
}

#[test]
fn what_means_nothing_is_said() {
    let warnings =
        |out: &str| -> Vec<String> { warnings(out).into_iter().filter(|text| text.contains("node \"out\"")).collect() };
    let spray = |more: &str| format!(r#""type": "Spray", "view": "on_waves", {more}"#);
    for (out, expected) in [
        (spray(r#""sea": "ripples""#), &["it throws nothing", "connect a GerstnerSea", "or give \"bursts\""][..]),
        (spray(r#""seed": 1"#), &["it throws nothing"]),
        (spray(r#""sea": "waves", "size": [0, 0]"#), &["a region of 0 × 0 m", "make \"size\" larger"]),
        (r#""type": "Rift", "view": "on_waves""#.into(), &["no surface has trails of bursts", "add a ToonSea"]),
        (r#""type": "DriftLines", "view": "on_ripples""#.into(), &["no surface has trails of bursts", "add a ToonSea"]),
    ] {
        let found = warnings(&out);
        let [only] = &found[..] else { panic!("{out}: {found:?}") };
        assert!(only.contains("test.json:9:"), "{only}");
        for part in expected {
            assert!(only.contains(part), "{out}: no {part:?} in {only}");
        }
    }
    for out in [
        spray(r#""sea": "ripples", "bursts": [{}]"#),
        spray(r#""sea": "ripples", "threshold": 2"#),
        spray(r#""sea": "waves""#),
        spray(r#""sea": "waves", "size": [0, 0], "bursts": [{}]"#),
        r#""type": "Rift", "view": "on_toon""#.into(),
        r#""type": "DriftLines", "view": "on_toon""#.into(),
    ] {
        assert_eq!(warnings(&out), [""; 0], "{out}");
    }
}

#[test]
fn folds_are_no_news_where_they_are_wanted() {
    let folded = |out: &str| warnings(out).iter().any(|text| text.contains("crests that fold over"));
    assert!(folded(r#""type": "Depth", "view": "on_steep""#));
    assert!(folded(r#""type": "Spray", "view": "on_steep", "sea": "waves""#), "the spray of another sea");
    assert!(!folded(r#""type": "Spray", "view": "on_waves", "sea": "steep""#));
    assert!(!folded(r#""type": "FoldFoam", "view": "on_steep""#));
    assert!(!folded(r#""type": "CrestFoam", "view": "on_steep""#));
}

#[test]
fn measures_in_half_precision_and_long_prerolls_are_said() {
    let said = |precision: &str, preroll: u32| -> Vec<String> {
        let text = format!(
            r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 4 }}, "nodes": {{
"sea": {{ "type": "ToonSea", "columns": 1024, "rows": 1024, "preroll": {preroll} }}, "bake": {{ "type": "Bake", "sea": "sea" }} }},
"outputs": {{ "out": {{ "field": "bake.height", "file": "a.exr", "precision": "{precision}" }} }} }}"#
        );
        parse("test.json", &text, Path::new("."), &[]).unwrap().warnings.iter().map(ToString::to_string).collect()
    };
    assert_eq!(said("float", 1000), [""; 0]);
    let [half] = &said("half", 1000)[..] else { panic!("{:?}", said("half", 1000)) };
    assert!(half.contains("test.json:3:") && half.contains("half for a Field"), "{half}");
    let [long] = &said("float", 100_000)[..] else { panic!("{:?}", said("float", 100_000)) };
    assert!(long.contains("test.json:2:") && long.contains("100000 steps") && long.contains("minutes"), "{long}");
}
