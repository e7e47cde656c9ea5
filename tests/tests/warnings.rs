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
        (
            r#""type": "ObjectMask", "view": "on_waves", "indices": [0, 7, 3]"#.into(),
            &["indices: found the surface 3, 7 of \"on_waves\", which has 1", "0, its only surface"],
        ),
        (
            r#""type": "Hooks", "view": "on_toon", "surface": 2, "rows": [{}]"#.into(),
            &["surface: found the surface 2 of \"on_toon\", which has 2", "expected 0 to 1"],
        ),
        (
            r#""type": "Hooks", "view": "on_toon", "rows": [{ "surface": 1 }, { "surface": 2 }]"#.into(),
            &["rows: found the surface 2 of \"on_toon\""],
        ),
        (
            r#""type": "Hooks", "view": "on_waves", "rows": [{}, { "from": [-5, 60], "to": [5, 60] }]"#.into(),
            &["rows: found rows[1] behind the camera", "turn the camera"],
        ),
        (
            r#""type": "InFront", "view": "on_waves", "other": "on_waves""#.into(),
            &["other: found the view itself", "connect a Render"],
        ),
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
        r#""type": "ObjectMask", "view": "on_toon", "indices": [0, 1]"#.into(),
        r#""type": "Hooks", "view": "on_toon", "surface": 1, "rows": [{ "surface": 0 }, {}]"#.into(),
        r#""type": "Hooks", "view": "on_waves", "rows": [{ "from": [-5, 60], "to": [5, 0] }]"#.into(),
        r#""type": "InFront", "view": "on_waves", "other": "on_toon""#.into(),
        r#""type": "Rift", "view": "on_toon""#.into(),
        r#""type": "DriftLines", "view": "on_toon""#.into(),
    ] {
        assert_eq!(warnings(&out), [""; 0], "{out}");
    }
}

#[test]
fn what_floats_twice_is_said() {
    let said = |model: &str| -> Vec<String> {
        let text = format!(
            r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 4 }}, "nodes": {{
"camera": {{ "type": "Camera" }}, "sea": {{ "type": "RippleSea" }},
"model": {{ "type": "BezierModel", "patches": [{{ "points": [{{ "at": [0, 0, 0] }}, {{ "at": [1, 0, 0] }},
    {{ "at": [0, 0, 1] }}, {{ "at": [1, 0, 1] }}] }}] }},
"boat": {{ "type": "Float", "model": "model", "sea": "sea", "bodies": [{{}}] }},
"out": {{ "type": "Float", "model": "{model}", "sea": "sea", "bodies": [{{}}] }},
"view": {{ "type": "Render", "camera": "camera", "surfaces": ["boat", "out"] }},
"depth": {{ "type": "Depth", "view": "view" }} }},
"outputs": {{ "out": {{ "field": "depth" }} }} }}"#
        );
        parse("test.json", &text, Path::new("."), &[]).unwrap().warnings.iter().map(ToString::to_string).collect()
    };
    assert_eq!(said("model"), [""; 0]);
    let [twice] = &said("boat")[..] else { panic!("{:?}", said("boat")) };
    assert!(twice.contains("node \"out\", model: found \"boat\", which floats already"), "{twice}");
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
"sea": {{ "type": "ToonSea", "columns": 1024, "rows": 1024, "preroll": {preroll},
    "bursts": [{{ "path": [1, 1, 2, 2, 3, 3, 4, 4] }}] }}, "bake": {{ "type": "Bake", "sea": "sea" }} }},
"outputs": {{ "out": {{ "field": "bake.height", "file": "a.exr", "precision": "{precision}" }} }} }}"#
        );
        parse("test.json", &text, Path::new("."), &[]).unwrap().warnings.iter().map(ToString::to_string).collect()
    };
    assert_eq!(said("float", 1000), [""; 0]);
    let [half] = &said("half", 1000)[..] else { panic!("{:?}", said("half", 1000)) };
    assert!(half.contains("test.json:4:") && half.contains("half for a Field"), "{half}");
    let [long] = &said("float", 100_000)[..] else { panic!("{:?}", said("float", 100_000)) };
    assert!(long.contains("test.json:2:") && long.contains("preroll: found work for about"), "{long}");
}

/// What is said of the node "out" among these nodes, in a picture of this format.
fn said_of_out(format: &str, nodes: &str, out: &str, output: &str) -> Vec<String> {
    let text = format!(
        r##"{{ "trochoid": 1, "format": {{ {format} }}, "nodes": {{
"camera": {{ "type": "Camera" }}, "sun": {{ "type": "Light" }}, "sea": {{ "type": "GerstnerSea", "count": 4 }}, {nodes}
"view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
"x": {{ "type": "ScreenX" }}, "image": {{ "type": "Mix", "a": "#000", "b": "#fff", "weight": "x" }},
"out": {{ {out} }} }}, "outputs": {{ "out": {{ {output} }} }} }}"##
    );
    let loaded = parse("test.json", &text, Path::new("."), &[]).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let all = loaded.warnings.iter().map(ToString::to_string);
    all.filter(|text| text.contains("node \"out\"") && !text.contains("no output needs")).collect()
}

#[test]
fn knobs_that_take_minutes_are_said_with_the_knob() {
    let layer = r#"{ "length": 512, "width": 256, "spacing": 1.5 }"#;
    let eight = [layer; 8].join(", ");
    let cloudy = [r#"{ "octaves": 16 }"#; 8].join(", ");
    let clawed = [r#"{ "count": 500, "thumbs": 4 }"#; 64].join(", ");
    for (out, output, knob) in [
        (format!(r#""type": "Strokes", "image": "image", "layers": [{eight}]"#), r#""color": "out""#, "layers"),
        (r#""type": "Blur", "image": "image", "size": 10000"#.into(), r#""color": "out""#, "size"),
        (
            format!(r#""type": "Clouds", "camera": "camera", "light": "sun", "steps": 256, "layers": [{cloudy}]"#),
            r#""weights": "out""#,
            "steps",
        ),
        (format!(r#""type": "Hooks", "view": "view", "rows": [{clawed}]"#), r#""weights": "out""#, "rows"),
    ] {
        let said = said_of_out(r#""width": 1920, "height": 1080, "samples": 16"#, "", &out, output);
        let [only] = &said[..] else { panic!("{out}: {said:?}") };
        let expected = format!("node \"out\", {knob}: found work for about ");
        assert!(only.contains(&expected) && only.contains("of one core") && only.contains("\n  remedy: "), "{only}");
        // The same is no news where the picture is small.
        let small = said_of_out(r#""width": 8, "height": 6"#, "", &out, output);
        assert_eq!(small, [""; 0], "{out}");
    }
    let waves = |count: u32| {
        let nodes = format!(r#""many": {{ "type": "GerstnerSea", "count": {count}, "sharpness": 0 }},"#);
        let text = format!(
            r#"{{ "trochoid": 1, "format": {{ "width": 7680, "height": 4320 }}, "nodes": {{ {nodes}
                "camera": {{ "type": "Camera" }},
                "view": {{ "type": "Render", "camera": "camera", "surfaces": ["many"] }},
                "out": {{ "type": "Depth", "view": "view" }} }}, "outputs": {{ "out": {{ "field": "out" }} }} }}"#
        );
        let loaded = parse("test.json", &text, Path::new("."), &[]).unwrap();
        loaded.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    assert!(waves(100_000).contains("count: found work for about 32 seconds"), "{}", waves(100_000));
    assert_eq!(waves(1000), "");
}

#[test]
fn what_shows_nothing_is_said() {
    let toon = |more: &str| format!(r#""toon": {{ "type": "ToonSea", "columns": 16, "rows": 16{more} }},"#);
    let small = r#""width": 8, "height": 6"#;
    for (nodes, out, output, parts) in [
        (
            r#""other": { "type": "RippleSea" },"#.to_owned(),
            r#""type": "ObjectMask", "view": "view", "surfaces": ["other"]"#,
            r#""weights": "out""#,
            &["\"other\", which \"view\" does not show", "add it to the surfaces of \"view\""][..],
        ),
        (
            String::new(),
            r#""type": "Render", "camera": "camera", "surfaces": ["sea", "sea"]"#,
            r#""weights": "out.coverage""#,
            &["\"sea\" twice", "name it once"],
        ),
        (
            String::new(),
            r#""type": "Hooks", "view": "view", "rows": [{}, { "from": [5000, 0], "to": [6000, 0] }]"#,
            r#""weights": "out""#,
            &["rows[1], 5000 m from the camera", "raise \"length\""],
        ),
        (
            String::new(),
            r#""type": "LightPool", "view": "view""#,
            r#""weights": "out""#,
            &["no pools and no noise", "give \"pools\""],
        ),
    ] {
        let said = said_of_out(small, &nodes, out, output);
        let [only] = &said[..] else { panic!("{out}: {said:?}") };
        assert!(parts.iter().all(|part| only.contains(part)), "{only}");
    }
    let of_toon = |more: &str| {
        let text = format!(
            r#"{{ "trochoid": 1, "format": {{ {small} }}, "nodes": {{ {} "out": {{ "type": "Bake", "sea": "toon" }} }},
                "outputs": {{ "out": {{ "field": "out.height" }} }} }}"#,
            toon(more)
        );
        let loaded = parse("test.json", &text, Path::new("."), &[]).unwrap();
        loaded.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    assert!(of_toon("").contains("no bursts, guides or bodies: the sea lies still"), "{}", of_toon(""));
    let away = of_toon(r#", "guides": [{ "path": [100, 100, 200, 200, 300, 300, 400, 400] }]"#);
    assert!(away.contains("guides: found every path beside the grid of 2.25 × 2.25 m"), "{away}");
    assert_eq!(of_toon(r#", "bursts": [{ "path": [-2, -2, 1, 1, 2, 2, 5, 5] }]"#), "");
    // A row that misses the only grid.
    let toon = toon(r#", "bursts": [{ "path": [0, 0, 1, 1, 2, 2, 3, 3] }]"#);
    let nodes = format!(r#"{toon} "on": {{ "type": "Render", "camera": "camera", "surfaces": ["toon"] }},"#);
    let hooks = |from: f64| {
        let out = format!(r#""type": "Hooks", "view": "on", "rows": [{{ "from": [{from}, 0], "to": [9, 0] }}]"#);
        said_of_out(small, &nodes, &out, r#""weights": "out""#).join("\n")
    };
    assert!(hooks(8.0).contains("rows[0] beside the grids of all surfaces"), "{}", hooks(8.0));
    assert_eq!(hooks(1.0), "");
}

#[test]
fn colors_beyond_white_and_branches_that_nobody_needs_are_said_once() {
    let said = |space: &str, color: &str| -> Vec<String> {
        let text = format!(
            r##"{{ "trochoid": 1, "format": {{ "width": 4, "height": 4 }}, "working_space": "{space}", "nodes": {{
"x": {{ "type": "ScreenX" }}, "y": {{ "type": "Invert", "weight": "x" }}, "z": {{ "type": "Invert", "weight": "y" }},
"out": {{ "type": "Constant", "color": {color} }} }}, "outputs": {{ "out": {{ "color": "out" }} }} }}"##
        );
        let loaded = parse("test.json", &text, Path::new("."), &[]).unwrap();
        loaded.warnings.iter().map(ToString::to_string).collect()
    };
    let branch = said("srgb", "[1, 0, 0]");
    let [only] = &branch[..] else { panic!("{branch:?}") };
    assert!(only.contains("node \"z\"") && only.contains("and what only it needs: x, y"), "{only}");
    // Two ends of one branch, and a node that hangs on nothing.
    let text = r##"{ "trochoid": 1, "format": { "width": 4, "height": 4 }, "nodes": {
"x": { "type": "ScreenX" }, "y": { "type": "Invert", "weight": "x" }, "z": { "type": "Invert", "weight": "x" },
"w": { "type": "ScreenY" },
"out": { "type": "Constant", "color": "#fff" } }, "outputs": { "out": { "color": "out" } } }"##;
    let loaded = parse("test.json", text, Path::new("."), &[]).unwrap();
    let two: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    let [branch, single] = &two[..] else { panic!("{two:?}") };
    assert!(
        branch.contains("node \"y\": found a node that no output needs, nor z, and what only they need: x;"),
        "{branch}"
    );
    assert!(single.contains("node \"w\": found a node that no output needs;"), "{single}");
    let red = said("srgb", "[255, 0, 0]").join("\n");
    assert!(red.contains("color: found the color [255, 0, 0]") && red.contains("divide by 255"), "{red}");
    assert_eq!(said("srgb", "[1.5, 0, 0]").len(), 2);
    assert_eq!(said("linear-srgb", "[1.5, 0, 0]").len(), 1, "light may be brighter than white");
    assert_eq!(said("linear-srgb", "[255, 0, 0]").len(), 2);
}
