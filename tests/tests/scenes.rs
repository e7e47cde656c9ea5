//! Scenes that ship with Trochoid: they are valid by the schema, inside their palette, and near the f64 references.

use crate::support::{all_bits, evaluate, root, sample, settings, under_all_settings};
use std::path::PathBuf;
use trochoid::{
    Buffers, Cache, Certified, Certifier, CheckedGraph, CheckedNode, Format, Guarantee, Kind, Picture, ReferenceFrame,
    Silent, Switches, load, registry, schema,
};

fn documents() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join("graphs")).unwrap().map(|entry| entry.unwrap().path());
    let mut documents: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|extension| extension == "json")).collect();
    documents.sort();
    assert!(!documents.is_empty());
    documents
}

fn schema_validator() -> jsonschema::Validator {
    jsonschema::validator_for(&schema(registry())).unwrap()
}

#[test]
fn scenes_satisfy_the_schema() {
    let validator = schema_validator();
    for path in documents() {
        let document: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let faults: Vec<String> =
            validator.iter_errors(&document).map(|fault| format!("{}: {fault}", fault.instance_path())).collect();
        assert!(faults.is_empty(), "{}:\n{}", path.display(), faults.join("\n"));
    }
}

#[test]
fn golden_cases_satisfy_the_schema() {
    let validator = schema_validator();
    for entry in std::fs::read_dir(root().join("tests/nodes")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.to_string_lossy();
        if name.ends_with(".expect.json") || !name.ends_with(".json") {
            continue;
        }
        let document: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let faults: Vec<String> =
            validator.iter_errors(&document).map(|fault| format!("{}: {fault}", fault.instance_path())).collect();
        assert!(faults.is_empty(), "{}:\n{}", path.display(), faults.join("\n"));
    }
}

#[test]
fn the_schema_refuses_what_it_should() {
    let validator = schema_validator();
    let text = r##"{ "trochoid": 1, "format": { "width": 4, "height": 4 },
        "nodes": { "c": { "type": "Constant", "color": "#fff" }, "m": { "type": "Mix", "a": "c", "b": "#000",
            "weight": { "keys": [[1, 0, { "out": [4, 0.5], "interpolation": "linear" }], [9, 1, { "in": [-2, 0] }]] } } },
        "outputs": { "o": { "color": "c" } } }"##;
    assert!(validator.is_valid(&serde_json::from_str(text).unwrap()));
    for (from, to) in [
        ("Constant", "Konstant"),
        ("\"color\": \"#fff\"", "\"colour\": \"#fff\""),
        ("\"width\": 4", "\"width\": 0"),
        ("\"trochoid\": 1", "\"trochoid\": 2"),
        ("\"out\": [4", "\"out\": [-4"),
        ("\"in\": [-2", "\"in\": [2"),
        ("[4, 0.5]", "[4]"),
        ("\"in\"", "\"before\""),
        ("\"linear\"", "\"eased\""),
        ("0] }]]", "0] }, 0]]"),
        ("{ \"o\": { \"color\": \"c\" } }", "{}"),
    ] {
        let changed = text.replace(from, to);
        assert_ne!(changed, text);
        assert!(!validator.is_valid(&serde_json::from_str(&changed).unwrap()), "{changed}");
    }
}

/// Returns a scene at a format that is small enough for tests; one that reads pictures without `fit` keeps its own.
fn small(graph: &CheckedGraph, width: u32, height: u32) -> CheckedGraph {
    let fixed = |node: &CheckedNode| {
        let reads = matches!(node.ty.declaration().name, "Read" | "ViewFromPasses" | "CryptoMask");
        reads && !node.record.settle(graph.frames().0 as f64).is_set("fit")
    };
    if graph.nodes().iter().any(fixed) {
        return graph.clone();
    }
    graph.clone().with_format(Format::new(width, height, 1).unwrap())
}

#[test]
fn scenes_stay_in_their_palette() {
    for path in documents() {
        let loaded = load(&path, &[]).unwrap();
        assert_eq!(loaded.warnings, [], "{}", path.display());
        let graph = small(&loaded.graph, 160, 90);
        let (first, last) = graph.frames();
        assert!(graph.outputs().iter().any(|output| output.kind == Kind::Color), "{}", path.display());
        for frame in [first, (first + last) / 2] {
            let frame = evaluate(&graph, frame, &Buffers::new(), &settings(|s| s.threads = 2));
            // Outputs that are baked for other renderers have no palette.
            for picture in frame.pictures.iter().filter(|picture| picture.kind == Kind::Color) {
                let (audit, what) = (picture.audit, format!("{}, output {}", path.display(), picture.output));
                assert_eq!((audit.hull_exits, audit.nan_count), (0, 0), "{what}");
                assert_eq!(audit.weight_sum_max_deviation, 0.0, "{what}");
                assert!(audit.weight_min >= 0.0, "{what}");
                assert_eq!(audit.pixels, graph.format().window().area() as u64, "{what}");
                assert!(picture.margin < 1e-4 && picture.control_count > 2, "{what}");
                assert_eq!(picture.guarantee, Some(Guarantee::Hull), "{what}");
            }
        }
    }
}

#[test]
fn scenes_keep_their_bits_without_any_optimization() {
    for path in documents() {
        let graph = load(&path, &[]).unwrap().graph;
        let whole = graph.format();
        // The same number of samples and the same shading, so that values that samples share are tested, too.
        let format = Format::new(40, 23, whole.samples()).unwrap().sampled_like(whole);
        // A scene that reads pictures without `fit` keeps its format.
        let fixed = small(&graph, 1, 1).format() == whole;
        let graph = if fixed { graph } else { graph.with_format(format) };
        let (first, last) = graph.frames();
        let at = (first + last) / 2;
        let frame = evaluate(&graph, at, &Buffers::new(), &settings(|s| s.threads = 2));
        let plain = evaluate(&graph, at, &Buffers::new(), &settings(|s| (s.threads, s.switches) = (2, Switches::NONE)));
        assert!(all_bits(&frame) == all_bits(&plain), "{} has other bits at frame {at}", path.display());
    }
}

#[test]
fn samples_that_are_followed_have_the_same_bits_under_all_settings() {
    let overrides = ["view.points=surface", "deck.points=exact", "storm.count=60"].map(String::from);
    let graph = load(&root().join("graphs/open_sea.json"), &overrides).unwrap().graph;
    let graph = graph.clone().with_format(Format::new(16, 9, 4).unwrap());
    under_all_settings(&graph, 1, &Buffers::new(), "open_sea, followed");
}

/// Tolerances of colors against the references: one step of 8 bits if surfaces are tessellated or baked, else rounding.
const TOLERANCE: [f64; 2] = [4e-3, 1e-6];
/// Tolerances for unambiguous samples that are followed to the surfaces themselves, in f32 and in f64, and their
/// certified errors. Samples right beside contours count, where what is seen changes fastest.
const FOLLOWED: [(&str, f64, f64); 2] = [("surface", 1e-3, 2e-2), ("exact", 1e-5, 3e-3)];
/// Share of pixels that may miss the tolerance because of uncertain visibility: edges of waves against waves and sky.
const AMBIGUOUS: f64 = 0.1;

/// Returns overrides that make the reference of a node fast enough for tests and keep all its features: the f64 paths
/// visit every wave at each pixel, and every cell and burst at each step.
fn cheaper(node: &CheckedNode, graph: &CheckedGraph) -> Vec<String> {
    let most: &[(&str, f64)] = match node.ty.declaration().name {
        "ToonSea" => &[("preroll", 6.0), ("columns", 64.0), ("rows", 64.0)],
        // With fewer waves, the sea would differ: its waves would be steeper.
        "GerstnerSea" => &[("count", 200.0)],
        _ => &[],
    };
    let settled = node.record.settle(graph.frames().0 as f64);
    let above = most.iter().filter(|(knob, most)| settled.number(knob) > *most);
    above.map(|(knob, most)| format!("{}.{knob}={most}", node.name)).collect()
}

/// Picture with its certified errors.
struct Certain {
    picture: Picture,
    certified: Certified,
}

impl Certain {
    /// Evaluates and certifies the first output of a graph. What its references have in common with those of other
    /// graphs is kept in `cache`.
    fn new(graph: &CheckedGraph, frame: i64, cache: &mut Cache) -> Self {
        let certifier = Certifier::new(graph, &[], frame, &[], &settings(|s| s.threads = 2)).unwrap();
        let mut certified = certifier.certify(&Buffers::new(), cache, &Silent).unwrap();
        let mut fast = evaluate(graph, frame, &Buffers::new(), &settings(|s| s.threads = 2));
        Self { picture: fast.pictures.swap_remove(0), certified: certified.swap_remove(0) }
    }

    /// Returns the largest error of a pixel's channels; panics if one exceeds its bound.
    fn error(&self, x: i64, y: i64, truth: &[f64], what: &str) -> f64 {
        let index = y as usize * self.certified.window.width() + x as usize;
        let error = |(channel, truth): (usize, &f64)| {
            let found = f64::from(sample(&self.picture, channel, x, y));
            let error = if found == *truth { 0.0 } else { (found - truth).abs() };
            let bound = f64::from(self.certified.errors[channel][index]);
            assert!(
                error <= bound,
                "{what}, channel {channel} of ({x}, {y}): {found} is not {truth}, certified {bound:e}"
            );
            error
        };
        truth.iter().enumerate().map(error).fold(0.0, f64::max)
    }

    fn is_clear(&self, x: i64, y: i64) -> bool {
        self.certified.doubt[y as usize * self.certified.window.width() + x as usize] == 0.0
    }
}

#[test]
fn scenes_agree_with_the_reference_1() {
    every_third_agrees(0);
}

#[test]
fn scenes_agree_with_the_reference_2() {
    every_third_agrees(1);
}

#[test]
fn scenes_agree_with_the_reference_3() {
    every_third_agrees(2);
}

/// Compares every third scene with its reference. Several tests take the time of one if there are several processors.
fn every_third_agrees(first: usize) {
    for path in documents().into_iter().skip(first).step_by(3) {
        let loaded = load(&path, &[]).unwrap();
        // Each pixel of these needs thousands of others; `painter` and the golden cases test them on small pictures.
        let asks_far = |node: &CheckedNode| matches!(node.ty.declaration().name, "Strokes" | "Hooks");
        if loaded.graph.nodes().iter().any(asks_far) {
            continue;
        }
        let overrides: Vec<String> =
            loaded.graph.nodes().iter().flat_map(|node| cheaper(node, &loaded.graph)).collect();
        let graph = small(&load(&path, &overrides).unwrap().graph, 80, 45);
        let views = graph.nodes().iter().filter(|node| node.ty.declaration().name == "Render");
        let views: Vec<&String> = views.map(|node| &node.name).collect();
        let (frame, window) = (graph.frames().0, graph.format().window());
        let mut cache = Cache::new();
        let meshed = Certain::new(&graph, frame, &mut cache);
        let followed = FOLLOWED.map(|(points, ..)| {
            let own = overrides.iter().cloned().chain(views.iter().map(|view| format!("{view}.points={points}")));
            Certain::new(&small(&load(&path, &own.collect::<Vec<_>>()).unwrap().graph, 80, 45), frame, &mut cache)
        });
        let name = &graph.outputs()[meshed.picture.output].name;
        let reference = ReferenceFrame::prepared(&graph, &[name.as_str()], frame, &mut cache, &Silent).unwrap();
        let approximated = graph.nodes().iter().any(|node| matches!(node.ty.declaration().name, "Render" | "Bake"));
        let tolerance = if approximated { TOLERANCE[0] } else { TOLERANCE[1] };
        let count = 60;
        let (mut off, mut errors) = (0, Vec::new());
        for i in 0..count {
            // Positions on a grid that is not parallel to the picture.
            let x = (i * 37 + 11) % window.width() as i64;
            let y = (i * window.height() as i64 / count).min(window.height() as i64 - 1);
            let truth = reference.pixel(x, y).unwrap();
            let what = path.display().to_string();
            let error = meshed.error(x, y, &truth, &what);
            errors.push(error);
            off += usize::from(error > tolerance);
            for (followed, (points, exact, _)) in followed.iter().zip(FOLLOWED) {
                let error = followed.error(x, y, &truth, &what);
                assert!(error < exact || !followed.is_clear(x, y), "{what}, {points}, ({x}, {y}): {error:e}");
            }
        }
        errors.sort_by(f64::total_cmp);
        let median = errors[errors.len() / 2];
        let text = format!("{}: {off} of {count} pixels miss, median {median:e}", path.display());
        assert!(off as f64 <= AMBIGUOUS * count as f64, "{text}");
        assert!(median < tolerance / 4.0, "{text}");
        for (followed, (points, _, certain)) in followed.iter().zip(FOLLOWED) {
            let most = followed.certified.clear.max();
            assert!(most < certain, "{}, {points}: {most:e} is certified", path.display());
        }
    }
}
