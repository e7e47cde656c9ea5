//! Groups and links: pictures are those of the document written by hand, and faults lead into the group and to its use.

use crate::support::{all_bits, evaluate, graph_in};
use std::path::Path;
use trochoid::{Buffers, LoadError, Settings, parse};

/// Returns a document with more at its top.
fn document(more: &str, nodes: &str, outputs: &str) -> String {
    format!(
        r#"{{ "trochoid": 1, "format": {{ "width": 24, "height": 16 }}, "frames": {{ "first": 1, "last": 12, "fps": 24 }},
            {more} "nodes": {{ {nodes} }}, "outputs": {{ {outputs} }} }}"#
    )
}

/// Asserts that two documents have the same pictures.
#[track_caller]
fn same(a: &str, b: &str) {
    let (a, b) = (graph_in(Path::new("."), a), graph_in(Path::new("."), b));
    for frame in [1, 5, 12] {
        let picture = |graph| all_bits(&evaluate(graph, frame, &Buffers::new(), &Settings::default()));
        assert_eq!(picture(&a), picture(&b), "frame {frame}");
    }
}

/// Returns the messages of an invalid document.
#[track_caller]
fn faults(text: &str) -> String {
    match parse("a.json", text, Path::new("."), &[]) {
        Err(LoadError::Invalid(faults)) => faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"),
        other => panic!("{other:?}"),
    }
}

const BAND: &str = r##""groups": { "Band": {
    "inputs": { "under": "Color", "where": { "kind": "Field", "optional": true, "help": "Field of the band." },
                "mask": { "kind": "Mask", "default": 1 } },
    "knobs": { "at": { "default": 0.3, "min": 0, "max": 1 }, "width": 0.1, "paint": { "default": "#c08040" }, "word": "smoothstep" },
    "nodes": {
        "x": { "type": "ScreenX" },
        "edge": { "type": "Clamp", "field": "x", "min": "= knobs.at", "max": "= knobs.at + knobs.width" },
        "cut": { "type": "Mix", "a": "under", "b": "= knobs.paint", "weight": "edge" },
        "over": { "type": "Mix", "a": "under", "b": "cut", "weight": "mask" } },
    "outputs": { "color": "over", "edge": "edge", "under": "under" } } },"##;

#[test]
fn uses_are_their_nodes() {
    let nodes = r##""y": { "type": "ScreenY" },
        "ground": { "type": "Mix", "a": "#102030", "b": "#8090a0", "weight": "y" },
        "one": { "type": "Band", "under": "ground", "at": { "keys": [[1, 0.2], [12, 0.6]] } },
        "two": { "type": "Band", "under": "one", "mask": "y", "paint": "#fff", "width": 0.25, "at": 0.5 },
        "all": { "type": "Mix", "a": "two.color", "b": "#f00", "weight": "one.edge" }"##;
    let by_hand = r##""y": { "type": "ScreenY" },
        "ground": { "type": "Mix", "a": "#102030", "b": "#8090a0", "weight": "y" },
        "x": { "type": "ScreenX" },
        "edge": { "type": "Clamp", "field": "x", "min": { "keys": [[1, 0.2], [12, 0.6]] },
                  "max": { "keys": KEYS } },
        "cut": { "type": "Mix", "a": "ground", "b": "#c08040", "weight": "edge" },
        "one": { "type": "Mix", "a": "ground", "b": "cut", "weight": 1 },
        "edge2": { "type": "Clamp", "field": "x", "min": 0.5, "max": 0.75 },
        "cut2": { "type": "Mix", "a": "one", "b": "#fff", "weight": "edge2" },
        "two": { "type": "Mix", "a": "one", "b": "cut2", "weight": "y" },
        "all": { "type": "Mix", "a": "two", "b": "#f00", "weight": "edge" }"##;
    let at = |frame: f64| {
        let t = (frame - 1.0) / 11.0;
        (1.0 - t) * 0.2 + t * 0.6
    };
    let keys: Vec<String> = (1..=12).map(|frame| format!("[{frame}, {}]", at(f64::from(frame)) + 0.1)).collect();
    let by_hand = by_hand.replace("KEYS", &format!("[{}]", keys.join(", ")));
    let outputs = r#""all": { "color": "all" }, "edge": { "weights": "two.edge" }, "under": { "color": "one.under" }"#;
    let by_hand_outputs =
        r#""all": { "color": "all" }, "edge": { "weights": "edge2" }, "under": { "color": "ground" }"#;
    same(&document(BAND, nodes, outputs), &document("", &by_hand, by_hand_outputs));
}

/// A group in a group, inputs that are passed on, lists of connections, links to nodes and to the document, and formulas.
#[test]
fn groups_nest_and_links_lead_anywhere() {
    let more = r##""knobs": { "warm": { "value": "#ff8040", "help": "Color of light." }, "speed": { "value": 2, "min": 0, "max": 5 } },
        "groups": {
            "Pair": {
                "inputs": { "masks": "Mask", "base": "Color" },
                "knobs": { "share": 0.5 },
                "nodes": {
                    "a": { "type": "Tint", "under": "base", "how": "= knobs.share" },
                    "b": { "type": "Tint", "under": "a", "how": "= knobs.share * knobs.share" },
                    "mean": { "type": "Blend", "colors": ["a", "b", "base"], "weights": [0.5, 0.25, 0.25] },
                    "out": { "type": "Mix", "a": "mean", "b": "b.color", "weight": "masks" } },
                "outputs": { "color": "out" } },
            "Tint": {
                "inputs": { "under": "Color" }, "knobs": { "how": { "default": 0.1 } },
                "nodes": { "mix": { "type": "Mix", "a": "under", "b": "#204060", "weight": "= knobs.how" } },
                "outputs": { "color": "mix" } } },"##;
    let nodes = r##""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
        "base": { "type": "Mix", "a": "#000", "b": "= knobs.warm", "weight": "x" },
        "soft": { "type": "Clamp", "field": "y", "min": "= 0.1 * knobs.speed", "max": "= min(soft.min + 0.5, 1)" },
        "pair": { "type": "Pair", "masks": "soft", "base": "base", "share": "= 0.5 + 0.25*(time * knobs.speed)" },
        "off": { "type": "Pair", "disabled": true, "masks": "x", "base": "base" },
        "all": { "type": "Blend", "colors": ["pair", "base"], "weights": [0.75, 0.25] },
        "gone": { "type": "Mix", "a": "#fff", "b": "#000", "weight": "off" }"##;
    let outputs = r#""all": { "color": "all" }, "inner": { "color": "pair" }, "gone": { "color": "gone" }"#;
    let share = |frame: i64| 0.5 + 0.25 * ((frame - 1) as f64 / 24.0 * 2.0);
    let keys = |of: &dyn Fn(i64) -> f64| {
        let keys: Vec<String> = (1..=12).map(|frame| format!("[{frame}, {}]", of(frame))).collect();
        format!("{{ \"keys\": [{}] }}", keys.join(", "))
    };
    let by_hand = r##""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
        "base": { "type": "Mix", "a": "#000", "b": "#ff8040", "weight": "x" },
        "soft": { "type": "Clamp", "field": "y", "min": 0.2, "max": 0.7 },
        "a": { "type": "Mix", "a": "base", "b": "#204060", "weight": SHARE },
        "b": { "type": "Mix", "a": "a", "b": "#204060", "weight": SQUARE },
        "mean": { "type": "Blend", "colors": ["a", "b", "base"], "weights": [0.5, 0.25, 0.25] },
        "pair": { "type": "Mix", "a": "mean", "b": "b", "weight": "soft" },
        "all": { "type": "Blend", "colors": ["pair", "base"], "weights": [0.75, 0.25] },
        "gone": { "type": "Mix", "a": "#fff", "b": "#000", "weight": "x" }"##;
    let by_hand =
        by_hand.replace("SHARE", &keys(&share)).replace("SQUARE", &keys(&|frame| share(frame) * share(frame)));
    let hand_outputs = r#""all": { "color": "all" }, "inner": { "color": "pair" }, "gone": { "color": "gone" }"#;
    same(&document(more, nodes, outputs), &document("", &by_hand, hand_outputs));
}

/// Whoever looks at a node of a group names it by its path, which may end at a node, at a use within, or at an input.
#[test]
fn paths_lead_into_uses() {
    let more = BAND.replacen(
        "\"groups\": {",
        r#""groups": { "Two": { "inputs": { "ground": "Color" },
        "nodes": { "one": { "type": "Band", "under": "ground" }, "two": { "type": "Band", "under": "one", "at": 0.6 } },
        "outputs": { "color": "two", "edge": "one.edge" } },"#,
        1,
    );
    let nodes = r##""y": { "type": "ScreenY" }, "ground": { "type": "Mix", "a": "#102030", "b": "#8090a0", "weight": "y" },
        "pair": { "type": "Two", "ground": "ground" }"##;
    let by_paths = r#""node": { "weights": "pair/one/edge" }, "use": { "color": "pair/two" }, "input": { "color": "pair/ground" },
        "output": { "weights": "pair/one.edge" }, "deep": { "color": "pair/one/under" }"#;
    let outside = r#""node": { "weights": "pair.edge" }, "use": { "color": "pair" }, "input": { "color": "ground" },
        "output": { "weights": "pair.edge" }, "deep": { "color": "ground" }"#;
    same(&document(&more, nodes, by_paths), &document(&more, nodes, outside));
    let told = faults(&document(&more, nodes, r#""o": { "color": "pair/three" }"#));
    assert!(told.contains("pair/three"), "{told}");
}

/// The document's knobs are set from outside, as nodes' are.
#[test]
fn knobs_of_the_document_are_set() {
    let more = r##""knobs": { "share": { "value": 0.25, "min": 0, "max": 1 }, "paint": "#fff" },"##;
    let nodes = r##""mix": { "type": "Mix", "a": "#000", "b": "= knobs.paint", "weight": "= knobs.share" }"##;
    let text = document(more, nodes, r#""mix": { "color": "mix" }"#);
    let set = |set: &[&str]| {
        let set: Vec<String> = set.iter().map(ToString::to_string).collect();
        parse("a.json", &text, Path::new("."), &set)
            .map(|loaded| all_bits(&evaluate(&loaded.graph, 1, &Buffers::new(), &Settings::default())))
    };
    let plain = |share: f64, paint: &str| {
        let nodes = format!(r##""mix": {{ "type": "Mix", "a": "#000", "b": "{paint}", "weight": {share} }}"##);
        let graph = graph_in(Path::new("."), &document("", &nodes, r#""mix": { "color": "mix" }"#));
        all_bits(&evaluate(&graph, 1, &Buffers::new(), &Settings::default()))
    };
    assert_eq!(set(&[]).unwrap(), plain(0.25, "#fff"));
    assert_eq!(set(&["knobs.share=0.75", "knobs.paint=#f80"]).unwrap(), plain(0.75, "#f80"));
    for (bad, said) in [
        ("knobs.shore=1", "did you mean \"share\"?"),
        ("knobs.share=2", "share: 2; expected a number from 0 to 1"),
        ("knobs.share=red", "a reference to \"red\", which is not a node"),
    ] {
        let error = set(&[bad]).unwrap_err().to_string();
        assert!(error.contains(said), "{bad}: {error}");
    }
}

/// `NODE.INDEX` stands for a PickWeight, also of what a group has, and within one.
#[test]
fn weights_are_named_by_their_index() {
    let group = r##""groups": { "Three": { "inputs": { "where": "Weights" }, "nodes": { "x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
        "own": { "type": "Stack", "weights": ["x", "y"] }, "m": { "type": "Multiply", "weights": ["own.1", "where.2"] } },
        "outputs": { "own": "own", "both": "m" } } },"##;
    let nodes = r##""x": { "type": "ScreenX" }, "bands": { "type": "Bands", "field": "x", "thresholds": [0.3, 0.6], "width": 0.2 },
        "t": { "type": "Three", "where": "bands" },
        "a": { "type": "Mix", "a": "#102030", "b": "#ffe0c0", "weight": "bands.1" },
        "b": { "type": "Mix", "a": "a", "b": "#ff0000", "weight": "t.own.0" },
        "c": { "type": "Mix", "a": "b", "b": "#00ff00", "weight": "t.both" }"##;
    let by_hand = r##""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" }, "bands": { "type": "Bands", "field": "x", "thresholds": [0.3, 0.6], "width": 0.2 },
        "own": { "type": "Stack", "weights": ["x", "y"] },
        "p": { "type": "PickWeight", "weights": "own", "index": 1 }, "q": { "type": "PickWeight", "weights": "bands", "index": 2 },
        "m": { "type": "Multiply", "weights": ["p", "q"] },
        "r": { "type": "PickWeight", "weights": "bands", "index": 1 }, "s": { "type": "PickWeight", "weights": "own", "index": 0 },
        "a": { "type": "Mix", "a": "#102030", "b": "#ffe0c0", "weight": "r" },
        "b": { "type": "Mix", "a": "a", "b": "#ff0000", "weight": "s" },
        "c": { "type": "Mix", "a": "b", "b": "#00ff00", "weight": "m" }"##;
    let outputs = r#""out": { "color": "c" }"#;
    same(&document(group, nodes, outputs), &document("", by_hand, outputs));
    for (weight, said) in [
        ("bands.3", &["node \"bands.3\", index", "3, of 3 weights", "a whole number from 0 to 2"][..]),
        ("x.2", &["2, of 2 weights"]),
        ("shade.0", &["node \"shade.0\", weights", "found \"shade\", a Color"]),
        ("nothing.0", &["a reference to \"nothing\", which is not a node"]),
    ] {
        let nodes = format!(
            r##""x": {{ "type": "ScreenX" }}, "shade": {{ "type": "Constant", "color": "#123" }},
                "bands": {{ "type": "Bands", "field": "x", "thresholds": [0.3, 0.6] }},
                "c": {{ "type": "Mix", "a": "shade", "b": "#fff", "weight": "{weight}" }}"##
        );
        let found = faults(&document("", &nodes, outputs));
        for words in said {
            assert!(found.contains(words), "{weight}: {words} in {found}");
        }
    }
}

/// `NODE.NAME` is the same as `NODE.INDEX` if the node names its weights, also of what a group has, and within one.
#[test]
fn weights_are_named_by_their_node() {
    let text = |index: bool| {
        let names = |names: &str| if index { String::new() } else { format!(r#", "names": {names}"#) };
        let pick = |name: &'static str, number: &'static str| if index { number } else { name };
        let group = format!(
            r##""groups": {{ "Three": {{ "inputs": {{ "where": "Weights" }}, "nodes": {{ "x": {{ "type": "ScreenX" }}, "y": {{ "type": "ScreenY" }},
                "own": {{ "type": "Stack", "weights": ["x", "y"]{} }}, "m": {{ "type": "Multiply", "weights": ["own.{}", "where.{}"] }} }},
                "outputs": {{ "own": "own", "both": "m" }} }} }},"##,
            names(r#"["rest", "right", "down"]"#),
            pick("right", "1"),
            pick("light", "2")
        );
        let nodes = format!(
            r##""x": {{ "type": "ScreenX" }}, "bands": {{ "type": "Bands", "field": "x", "thresholds": [0.3, 0.6], "width": 0.2{} }},
                "t": {{ "type": "Three", "where": "bands" }},
                "a": {{ "type": "Mix", "a": "#102030", "b": "#ffe0c0", "weight": "bands.{}" }},
                "b": {{ "type": "Mix", "a": "a", "b": "#ff0000", "weight": "t.own.{}" }},
                "c": {{ "type": "Mix", "a": "b", "b": "#00ff00", "weight": "t.both" }}"##,
            names(r#"["shadow", "half", "light"]"#),
            pick("half", "1"),
            pick("rest", "0")
        );
        document(&group, &nodes, r#""out": { "color": "c" }"#)
    };
    same(&text(false), &text(true));
    let outputs = r#""out": { "color": "c" }"#;
    for (names, weight, said) in [
        (
            r#"["dark", "half", "light"]"#,
            "bands.ligth",
            &["weight \"ligth\" of \"bands\"", "did you mean \"bands.light\"?"][..],
        ),
        (r#"["dark", "half", "light"]"#, "bands.zzz", &["weight \"zzz\"", "its weights: dark, half, light"]),
        (
            r#"["dark", "light"]"#,
            "bands.dark",
            &["2 names", "a list of 3 names, one for each weight", "name all weights"],
        ),
        (r#"["a", "b", "c", "d"]"#, "bands.a", &["4 names", "remove what is too much"]),
        (r#"["dark", "dark", "light"]"#, "bands.dark", &["a second \"dark\"", "each name once"]),
        (r#"["dark", "1st", "light"]"#, "bands.dark", &["the name \"1st\"", "rename the weight"]),
        (r#"["dark", "weights", "light"]"#, "bands.dark", &["that of the output", "a name of its own"]),
        (r#"["dark", 7, "light"]"#, "bands.dark", &["found 7", "the name of a weight"]),
        (r#""dark""#, "bands.dark", &["found \"dark\"", "a list of 3 names", "in brackets"]),
        ("null", "bands.1", &["a list of 3 names"]),
    ] {
        let nodes = format!(
            r##""x": {{ "type": "ScreenX" }}, "bands": {{ "type": "Bands", "field": "x", "thresholds": [0.3, 0.6], "names": {names} }},
                "c": {{ "type": "Mix", "a": "#000", "b": "#fff", "weight": "{weight}" }}"##
        );
        let found = faults(&document("", &nodes, outputs));
        for words in said {
            assert!(found.contains(words), "{names}, {weight}: {words} in {found}");
        }
    }
    let unnamed = r##""x": { "type": "ScreenX" }, "bands": { "type": "Bands", "field": "x", "thresholds": [0.3] },
        "c": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "bands.light" }"##;
    let found = faults(&document("", unnamed, outputs));
    assert!(found.contains("name its weights by \"names\": [ … ], or count them: \"bands.0\""), "{found}");
    let colored = r##""c": { "type": "Mix", "a": "#000", "b": "#fff", "weight": 0.5, "names": ["a", "b"] }"##;
    let found = faults(&document("", colored, outputs));
    assert!(found.contains("unknown key \"names\""), "{found}");
}

/// A list of which one component follows a keyed knob or the time is keyed as a whole.
#[test]
fn components_of_lists_may_follow_what_is_keyed() {
    let disc = |center: &str| {
        format!(
            r##""d": {{ "type": "Shape", "shapes": [{{ "form": "disc", "center": {center}, "radius": 0.3 }}] }},
                "m": {{ "type": "Mix", "a": "#123", "b": "#fed", "weight": "d" }}"##
        )
    };
    let outputs = r#""out": { "color": "m" }"#;
    let knob = r#""knobs": { "x": { "value": { "keys": [[1, 0.2], [12, 1.3]] } } },"#;
    let by_hand = disc(r#"{ "keys": [[1, [0.2, 0.5]], [12, [1.3, 0.5]]] }"#);
    same(&document(knob, &disc(r#"["= knobs.x", 0.5]"#), outputs), &document("", &by_hand, outputs));
    let by_time = disc(r#"{ "keys": [[1, [0.5, 0.25]], [13, [0.5, 0.75]]] }"#);
    same(&document("", &disc(r#"[0.5, "= 0.25 + time"]"#), outputs), &document("", &by_time, outputs));
}

#[test]
fn reports_have_sums_by_use() {
    let inner = r##""groups": { "I": { "inputs": { "in": "Color" }, "nodes": { "x": { "type": "ScreenX" }, "m": { "type": "Mix", "a": "in", "b": "#fff", "weight": "x" } }, "outputs": { "o": "m" } },
        "O": { "nodes": { "y": { "type": "ScreenY" }, "c": { "type": "Mix", "a": "#000", "b": "#123", "weight": "y" }, "i": { "type": "I", "in": "c" } }, "outputs": { "o": "i" } } },"##;
    let graph = graph_in(Path::new("."), &document(inner, r#""o": { "type": "O" }"#, r#""out": { "color": "o" }"#));
    let frame = evaluate(&graph, 1, &Buffers::new(), &Settings::default());
    let report = trochoid::frame_report(&graph, &frame, 0.0);
    let seconds = |name: &str| report["nodes"][name]["seconds"].as_f64().unwrap();
    let (outer, inner) = (&report["groups"]["o"], &report["groups"]["o/i"]);
    assert_eq!((outer["group"].as_str(), outer["nodes"].as_u64()), (Some("O"), Some(4)));
    assert_eq!((inner["group"].as_str(), inner["nodes"].as_u64()), (Some("I"), Some(2)));
    assert_eq!(inner["seconds"].as_f64().unwrap(), seconds("o/i/x") + seconds("o/i/m"));
    assert!(outer["seconds"].as_f64() >= inner["seconds"].as_f64());
}

/// Each fault has a message of its own, which leads to its place, and from within a group to its use.
#[test]
fn faults_are_told_with_their_places() {
    let group = |inside: &str| {
        format!(
            r#""groups": {{ "G": {{ "inputs": {{ "in": "Color" }}, "knobs": {{ "k": {{ "default": 0.5, "min": 0, "max": 1 }}, "must": {{ "min": 0 }} }},
            {inside} }} }},"#
        )
    };
    let good = group(
        r##""nodes": { "m": { "type": "Mix", "a": "in", "b": "#fff", "weight": "= knobs.k" } }, "outputs": { "o": "m" }"##,
    );
    let bad_weight = group(
        r##""nodes": { "m": { "type": "Mix", "a": "in", "b": "#fff", "weight": "= knobs.k + 1" } }, "outputs": { "o": "m" }"##,
    );
    let used = |more: &str| format!(r##""g": {{ "type": "G", "in": "#000", "must": 1 {more} }}"##);
    let x = r#""x": { "type": "ScreenX" },"#;
    let cases: Vec<(String, String, &[&str])> = vec![
        // Groups.
        (group(r#""outputs": { "o": "m" }"#), used(""), &["the group \"G\" without nodes"]),
        (group(r#""nodes": { "m": { "type": "ScreenX" } }"#), used(""), &["the group \"G\" without outputs"]),
        (group(r#""nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": 3 }"#), used(""), &["a reference to a node of the group"]),
        (group(r#""nodes": { "in": { "type": "ScreenX" } }, "outputs": { "o": "in" }"#), used(""), &["the name \"in\" for an input and for a node"]),
        (group(r#""nodez": {}, "nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": "m" }"#), used(""), &["unknown key \"nodez\"", "did you mean \"nodes\"?"]),
        (r#""groups": { "Mix": { "nodes": {}, "outputs": {} } },"#.into(), used(""), &["\"Mix\", which is a node type"]),
        (r#""groups": { "a b": { "nodes": {}, "outputs": {} } },"#.into(), used(""), &["the group name \"a b\""]),
        (r#""groups": 7,"#.into(), used(""), &["groups: 7; expected an object of groups by name"]),
        (r#""groups": { "A": { "inputs": { "i": "Colour" }, "nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": "m" } } },"#.into(), used(""), &["\"Colour\"", "did you mean \"Color\"?"]),
        (r#""groups": { "A": { "nodes": { "b": { "type": "B" } }, "outputs": { "o": "b" } }, "B": { "nodes": { "a": { "type": "A" } }, "outputs": { "o": "a" } } },"#.into(), used(""), &["a group that uses itself: A → B → A"]),
        (r#""groups": { "A": { "nodes": { "a": { "type": "A" } }, "outputs": { "o": "a" } } },"#.into(), used(""), &["a group that uses itself: A → A"]),
        (r#""groups": { "A": { "knobs": { "k": { "min": 2, "max": 1 } }, "nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": "m" } } },"#.into(), used(""), &["expected min ≤ max"]),
        // Uses.
        (good.clone(), r#""g": { "type": "G", "must": 1 }"#.into(), &["node \"g\"", "no \"in\"; expected a Color"]),
        (good.clone(), r##""g": { "type": "G", "in": "#000" }"##.into(), &["no \"must\"; expected a value"]),
        (good.clone(), used(r#", "kk": 1"#), &["unknown key \"kk\"", "did you mean \"k\"?"]),
        (good.clone(), used(r#", "k": 1.5"#), &["k: 1.5; expected a number from 0 to 1"]),
        (good.clone(), used(r#", "k": { "keys": [[1, 0.5], [3, 7]] }"#), &["k: 7; expected a number from 0 to 1"]),
        (good.clone(), used(r#", "k": "= 3""#), &["k: 3; expected a number from 0 to 1"]),
        (good.clone(), format!(r##"{x} "g": {{ "type": "G", "in": "x", "must": 1 }}"##), &["node \"g\", in: found \"x\", a mask; expected a Color"]),
        (good.clone(), used(r#"}, "h": { "type": "Mix", "a": "g.p", "b": "g", "weight": 0.5"#), &["output \"p\" of the group G", "outputs of G: o"]),
        (good.clone(), r#""g": { "type": "H", "in": 1 }"#.into(), &["unknown node type \"H\""]),
        (good.clone(), r#""g": { "type": "G", "in": "nothing", "must": 1 }"#.into(), &["a reference to \"nothing\", which is not a node"]),
        (good.clone(), used(r#", "disabled": 1"#), &["expected true or false"]),
        // Within a group, with the way back.
        (bad_weight, used(""), &["node \"g/m\"", "1.5, in the group G as used at 3:", "a mask"]),
        // Links.
        (String::new(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "= g.weight" }"##.into(), &["a value that leads back to itself: g.weight follows g.weight", "give one of them a value of its own"]),
        (String::new(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "= x.at" }"##.into(), &["a link to \"x\", which is not a node"]),
        (String::new(), format!(r##"{x} "g": {{ "type": "Mix", "a": "#000", "b": "#fff", "weight": "= x.at" }}"##), &["a link to \"at\" of \"x\""]),
        (String::new(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "= knobs.k" }"##.into(), &["\"knobs.k\", which the document does not have"]),
        (String::new(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "= fram / 10" }"##.into(), &["\"fram\" in the formula", "did you mean \"frame\"?"]),
        (String::new(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "= 1 +" }"##.into(), &["of the formula \"1 +\"", "expected a number"]),
        (String::new(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "= log(frame - 1)" }"##.into(), &["-inf at frame 1", "change one of these: frame is 1"]),
        (String::new(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "= frame" }"##.into(), &["found 2; expected a number from 0 to 1"]),
        (String::new(), r##""t": { "type": "Noise", "kind": "fbm" }, "g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "= t.kind * 2" }"##.into(), &["\"t.kind\", which is \"fbm\"", "expected numbers"]),
        (String::new(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "=" }"##.into(), &["of the formula \"\""]),
        (r#""knobs": { "k": { "min": 1 } },"#.into(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": 1 }"##.into(), &["the knob \"k\" without a value"]),
        (String::new(), r##""a": { "type": "Noise", "scale": "= b.gain" }, "b": { "type": "Noise", "gain": "= a.scale / 2" }, "g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": 1 }"##.into(), &["a value that leads back to itself: b.gain follows a.scale, which follows b.gain"]),
        (good.clone(), r##""g": { "type": "G", "in": "#000", "must": 1, "k": "= h.k" }, "h": { "type": "G", "in": "#000", "must": 1, "k": "= g.k" }"##.into(), &["a value that leads back to itself: ", "g.k follows h.k, which follows g.k"]),
        (r#""knobs": { "a": "= knobs.b", "b": "= knobs.a + 1" },"#.into(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": 1 }"##.into(), &["knobs.a follows knobs.b, which follows knobs.a"]),
        (r#""knobs": { "k": { "value": 3, "max": 2 } },"#.into(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": 1 }"##.into(), &["k: 3; expected a number of at most 2"]),
        (r#""knobs": [1],"#.into(), r##""g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": 1 }"##.into(), &["expected an object of knobs by name"]),
        (good.clone(), used(r#", "k": "= g.in""#), &["the group G does not have"]),
        (good.clone(), format!(r##"{}, "h": {{ "type": "Mix", "a": "#000", "b": "#fff", "weight": "= g.m" }}"##, used("")), &["\"knobs.m\", which the group G does not have"]),
        // More of groups.
        (r#""groups": { "A": { "inputs": { "type": "Color" }, "nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": "m" } } },"#.into(), used(""), &["the name \"type\" of an input"]),
        (r#""groups": { "A": { "knobs": { "a-b": 1 }, "nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": "m" } } },"#.into(), used(""), &["the name \"a-b\" of a knob"]),
        (r#""groups": { "A": { "inputs": { "i": "Color" }, "knobs": { "i": 1 }, "nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": "m" } } },"#.into(), used(""), &["the name \"i\" for an input and for a knob"]),
        (r#""groups": { "A": { "knobs": { "k": { "min": "low" } }, "nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": "m" } } },"#.into(), used(""), &["\"low\"; expected a number"]),
        (r#""groups": { "A": { "nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": "m" } }, "A": { "nodes": { "m": { "type": "ScreenY" } }, "outputs": { "o": "m" } } },"#.into(), used(""), &["a second \"A\"", "expected each name once"]),
        (r##""groups": { "A": { "inputs": { "i": { "kind": "Mask", "optional": 1 } }, "nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": "m" } } },"##.into(), used(""), &["1; expected true or false"]),
        (r##""groups": { "A": { "nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": "n" } } },"##.into(), r##""a": { "type": "A" }, "g": { "type": "Mix", "a": "#000", "b": "#fff", "weight": "a" }"##.into(), &["a reference to \"a/n\", which is not a node", "did you mean \"a/m\"?"]),
        (r##""groups": { "I": { "inputs": { "in": "Color" }, "nodes": { "m": { "type": "Mix", "a": "in", "b": "#fff", "weight": 1 } }, "outputs": { "o": "m" } },
             "A": { "nodes": { "i": { "type": "I" } }, "outputs": { "o": "i" } } },"##.into(), r##""g": { "type": "A" }"##.into(), &["node \"g/i\": found no \"in\", in the group A as used at 3:"]),
        (r##""groups": { "P": { "inputs": { "in": "Color" }, "nodes": { "m": { "type": "ScreenX" } }, "outputs": { "o": "in" } } },"##.into(), r##""g": { "type": "P", "in": "h" }, "h": { "type": "P", "in": "g" }"##.into(), &["a value that leads back to itself"]),
    ];
    for (more, nodes, words) in cases {
        let text = document(&more, &nodes, r#""out": { "color": "g" }"#);
        let said = faults(&text);
        for word in words {
            assert!(said.contains(word), "no {word:?} for {nodes}\n{more}\nin: {said}");
        }
    }
}
