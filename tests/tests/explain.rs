//! Omitted nodes are reported with correct proofs.

use crate::support::{graph, settings};
use trochoid::{
    Account, Cache, CheckedGraph, Evidence, Fate, Kind, LeftOut, Omission, Plan, Silent, Switches, measure,
};

const FORMAT: &str = r#""width": 96, "height": 54"#;

/// A shaded sea and a sky; `more` adds the picture, which needs the sea only through a weight.
fn sea(more: &str) -> String {
    format!(
        r##""camera": {{ "type": "Camera", "position": [0, 4, 20], "target": [0, 2, 0] }}, "sun": {{ "type": "Light" }},
        "sea": {{ "type": "GerstnerSea", "count": 8 }},
        "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
        "light": {{ "type": "NonSpecular", "view": "view", "lights": ["sun"] }},
        "water": {{ "type": "Mix", "a": "#123", "b": "#def", "weight": "light" }},
        "across": {{ "type": "ScreenX" }},
        "sky": {{ "type": "Mix", "a": "#fff", "b": "#88a", "weight": "across" }}, {more}"##
    )
}

const OUT: &str = r#""out": { "color": "out" }"#;
const SIMULATOR: [&str; 6] = ["camera", "sun", "sea", "view", "light", "water"];

fn explained(graph: &CheckedGraph, frame: i64) -> Vec<Account> {
    Plan::explained(graph, &["out"], frame, &[], &settings(|_| ())).unwrap().1
}

fn of<'a>(graph: &CheckedGraph, accounts: &'a [Account], node: &str) -> &'a Account {
    let account = &accounts[graph.find(node).unwrap().0];
    assert_eq!(account.node, graph.find(node).unwrap());
    account
}

/// Node, ends of the interval, and evidence of each step of a proof.
fn steps(account: &Account) -> Vec<(&str, [f64; 2], &Evidence)> {
    let step = |bound: &trochoid::ProofStep| [bound.interval.low, bound.interval.high];
    account.proof.iter().map(|bound| (bound.node.as_str(), step(bound), &bound.evidence)).collect()
}

const WRITTEN: &Evidence = &Evidence::Written { keyed: false };

fn computed(from: &[&str]) -> Evidence {
    Evidence::Computed(from.iter().map(|name| (*name).into()).collect())
}

#[test]
fn a_proof_goes_back_to_what_is_known() {
    let nodes = sea(r#""deep": { "type": "Clamp", "field": "across", "min": 2, "max": 3, "smooth": true },
        "dry": { "type": "Invert", "weight": "deep" },
        "out": { "type": "Mix", "a": "water", "b": "sky", "weight": "dry" }"#);
    let graph = graph(FORMAT, &nodes, OUT);
    let accounts = explained(&graph, 1);
    for node in SIMULATOR {
        let account = of(&graph, &accounts, node);
        assert_eq!(account.fate, Fate::LeftOut(LeftOut::Weight("out".into())), "{node}");
        let expected = [
            ("dry", [1.0, 1.0], &computed(&["deep"])),
            ("deep", [0.0, 0.0], &computed(&["across"])),
            ("across", [0.0, 1.0], &Evidence::Stated),
        ];
        assert_eq!(steps(account), expected, "{node}");
    }
    assert_eq!(of(&graph, &accounts, "out").fate, Fate::PassesThrough("sky".into()));
    assert_eq!(of(&graph, &accounts, "deep").fate, Fate::Folded);
    for node in ["across", "sky"] {
        let account = of(&graph, &accounts, node);
        assert_eq!((&account.fate, account.proof.len()), (&Fate::Evaluated, 0), "{node}");
    }
}

#[test]
fn numbers_in_the_document_are_proofs() {
    for (weight, keyed) in [("0", false), (r#"{ "keys": [[1, 0], [3, 1]] }"#, true)] {
        let out = format!(r#""out": {{ "type": "Mix", "a": "sky", "b": "water", "weight": {weight} }}"#);
        let graph = graph(FORMAT, &sea(&out), OUT);
        let accounts = explained(&graph, 1);
        let expected = [("out", [0.0, 0.0], &Evidence::Written { keyed })];
        assert_eq!(steps(of(&graph, &accounts, "sea")), expected, "{weight}");
        let later = explained(&graph, 2);
        assert_eq!(of(&graph, &later, "sea").fate == Fate::Evaluated, keyed, "{weight}");
    }
    let blend = r##""out": { "type": "Blend", "colors": ["sky", "water", "#fff"], "weights": [0.5, 0, 0.5] }"##;
    let graph = graph(FORMAT, &sea(blend), OUT);
    assert_eq!(steps(of(&graph, &explained(&graph, 1), "sea")), [("out", [0.0, 0.0], WRITTEN)]);
}

#[test]
fn a_node_that_makes_no_difference_to_a_mask_has_a_proof_too() {
    let nodes = sea(r##""bright": { "type": "Clamp", "field": "light", "min": 0.5 },
        "both": { "type": "Multiply", "weights": ["bright", 0] },
        "out": { "type": "Mix", "a": "sky", "b": "#000", "weight": "both" }"##);
    let graph = graph(FORMAT, &nodes, OUT);
    let accounts = explained(&graph, 1);
    let account = of(&graph, &accounts, "sea");
    assert_eq!(account.fate, Fate::LeftOut(LeftOut::Constant("both".into())));
    assert_eq!(steps(account), [("both", [0.0, 0.0], WRITTEN)], "one factor of 0 is enough");
    // Of a bound pass, only the range of its kind is known.
    let nodes = sea(r#""never": { "type": "Clamp", "field": "light", "min": 1.5, "max": 2 },
        "out": { "type": "Mix", "a": "sky", "b": "water", "weight": "never" }"#);
    let graph = crate::support::graph(FORMAT, &nodes, OUT);
    let (_, accounts) = Plan::explained(&graph, &["out"], 1, &["light"], &settings(|_| ())).unwrap();
    assert_eq!(of(&graph, &accounts, "sea").fate, Fate::LeftOut(LeftOut::Bound));
    let steps = steps(of(&graph, &accounts, "water"));
    assert_eq!(steps[1], ("light", [0.0, 1.0], &Evidence::Kind(Kind::MASK)));
}

#[test]
fn folded_merged_and_passed_through_nodes_are_reported() {
    let nodes = r##""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
        "xy": { "type": "Multiply", "weights": ["x", "y"] }, "yx": { "type": "Multiply", "weights": ["y", "x"] },
        "again": { "type": "Multiply", "weights": ["y", "x"] },
        "gray": { "type": "Mix", "a": "#000", "b": "#fff", "weight": 0.5 },
        "p": { "type": "Mix", "a": "gray", "b": "#f00", "weight": "xy" },
        "q": { "type": "Mix", "a": "p", "b": "#0f0", "weight": "yx" },
        "r": { "type": "Mix", "a": "q", "b": "#00f", "weight": "again" },
        "off": { "type": "Noise", "disabled": true }, "lost": { "type": "Noise" },
        "out": { "type": "Switch", "inputs": ["p", "r"], "which": 1 }"##;
    let graph = graph(FORMAT, nodes, OUT);
    let accounts = explained(&graph, 1);
    for (node, fate) in [
        ("x", Fate::Evaluated),
        ("gray", Fate::Folded),
        ("r", Fate::Evaluated),
        ("off", Fate::LeftOut(LeftOut::Disabled)),
        ("lost", Fate::LeftOut(LeftOut::Unreachable)),
        ("out", Fate::PassesThrough("r".into())),
    ] {
        assert_eq!(of(&graph, &accounts, node).fate, fate, "{node}");
    }
    // The order of the graph decides which of equal nodes is evaluated.
    let fate = |node: &str| of(&graph, &accounts, node).fate.clone();
    let same = |a: &str, b: &str| fate(a) == Fate::LeftOut(LeftOut::SameAs(b.into()));
    assert!(same("yx", "again") || same("again", "yx"), "{:?} {:?}", fate("yx"), fate("again"));
    let merged = ["xy", "yx", "again"].into_iter().filter(|node| matches!(fate(node), Fate::Merged(_))).count();
    let runs = ["xy", "yx", "again"].into_iter().filter(|node| fate(node) == Fate::Evaluated).count();
    assert_eq!((merged, runs), (1, 1));
    let plain = settings(|s| s.switches = Switches::NONE);
    let (_, accounts) = Plan::explained(&graph, &["out"], 1, &[], &plain).unwrap();
    for node in ["yx", "again", "gray"] {
        assert_eq!(of(&graph, &accounts, node).fate, Fate::Evaluated, "{node}");
    }
}

#[test]
fn channels_are_those_that_passes_ask_for() {
    let nodes =
        sea(r##""depth": { "type": "Depth", "view": "view" }, "far": { "type": "Clamp", "field": "depth", "max": 9 },
        "out": { "type": "Mix", "a": "#fff", "b": "#000", "weight": "far" }"##);
    let graph = graph(FORMAT, &nodes, OUT);
    let accounts = explained(&graph, 1);
    let [view, coverage] = &of(&graph, &accounts, "view").channels[..] else { panic!("a view and its coverage") };
    assert_eq!((view.output, coverage.output), ("view", "coverage"));
    assert_eq!(view.wanted, ["Depth"]);
    assert_eq!(view.wanted.len() + view.unasked.len(), trochoid::Channel::COUNT);
    assert!(view.unasked.contains(&"Jacobian".into()));
    assert_eq!((&coverage.wanted[..], &coverage.unasked[..]), (&[][..], &["coverage".to_string()][..]));
    assert_eq!(of(&graph, &accounts, "depth").channels[0].wanted.len(), 1);
    assert!(of(&graph, &accounts, "sea").channels.iter().all(|output| output.wanted.is_empty()));
}

/// Returns the work that the stages of a graph's only output skip.
fn omissions(graph: &CheckedGraph) -> Vec<(String, Omission)> {
    let plan = Plan::new(graph, &["out"], 1, &[], &settings(|_| ())).unwrap();
    let found = plan.omissions(&mut Cache::new(), &Silent).unwrap();
    let name = |id: trochoid::NodeId| graph.node(id).name.clone();
    found.into_iter().flat_map(|(id, all)| all.into_iter().map(move |one| (name(id), one))).collect()
}

#[test]
fn waves_below_the_pixel_and_drops_beside_the_picture_are_counted() {
    // Seen from 1 km above, 1 pixel is some meters: two of these waves are far below it, and one fills the picture.
    let nodes = |height: f64| {
        format!(
            r#""camera": {{ "type": "Camera", "position": [0, {height}, 1], "target": [0, 0, 0], "fov": 30 }},
            "sea": {{ "type": "GerstnerSea", "count": 0, "waves": [
              {{ "wavelength": 0.1, "amplitude": 0.001 }}, {{ "wavelength": 300, "amplitude": 2 }},
              {{ "wavelength": 0.2, "amplitude": 0.002, "direction": 40 }} ] }},
            "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
            "out": {{ "type": "Height", "view": "view" }}"#
        )
    };
    let field = r#""out": { "field": "out" }"#;
    let far = omissions(&graph(FORMAT, &nodes(1000.0), field));
    assert_eq!(far.len(), 2);
    for (node, Omission { port, count, of, .. }) in &far {
        assert_eq!(
            (node.as_str(), port.map(|(port, index)| (port.name(), index)), *count, *of),
            ("view", Some(("surfaces", 0)), 2.0, 3.0)
        );
    }
    assert_eq!(far[0].1.what, "waves");
    // From just above, every wave is needed somewhere, though not in the distance.
    let near = omissions(&graph(FORMAT, &nodes(0.05).replace("30", "60"), field));
    assert!(near.iter().all(|(_, omission)| omission.what != "waves" && omission.count < 2.0), "{near:?}");
    let spray = |x: f64| {
        let nodes = format!(
            r#""camera": {{ "type": "Camera", "position": [0, 1, 20], "target": [0, 1, 0], "fov": 30 }},
            "sea": {{ "type": "GerstnerSea", "count": 0 }},
            "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
            "spray": {{ "type": "Spray", "view": "view", "bursts": [
              {{ "position": [0, 1, 0], "time": -0.1, "duration": 0, "count": 40 }},
              {{ "position": [{x}, 1, 0], "time": -0.1, "duration": 0, "count": 60 }} ] }}"#
        );
        omissions(&graph(FORMAT, &nodes, r#""out": { "weights": "spray.alpha" }"#))
    };
    let drops = spray(500.0);
    assert_eq!((drops[0].0.as_str(), drops[0].1.what, drops[0].1.of), ("spray", "drops", 100.0));
    assert_eq!(drops[0].1.count, 60.0);
    assert_eq!(spray(0.0), []);
}

#[test]
fn costs_tell_what_was_never_evaluated() {
    let nodes = sea(r#""lost": { "type": "Noise" },
        "out": { "type": "Mix", "a": "sky", "b": "water", "weight": 0 }"#);
    let graph = graph(FORMAT, &nodes, OUT);
    let costs = measure(&graph, "out", 1, 40, &Silent).unwrap();
    assert_eq!((costs.format.width(), costs.format.height(), costs.runs), (32, 18, 3));
    let cost = |node: &str| costs.nodes[graph.find(node).unwrap().0];
    let view = cost("view");
    assert!(view.seconds.is_none() && view.saved() > Some(0.0) && !view.estimated, "{view:?}");
    assert!(cost("sky").seconds.is_some() && cost("sky").estimated);
    let lost = cost("lost");
    assert_eq!((lost.seconds, lost.seconds_in_full, lost.saved()), (None, None, None));
    assert_eq!(costs.nodes.len(), graph.nodes().len());
    assert!(measure(&graph, "none", 1, 40, &Silent).is_err());
}
