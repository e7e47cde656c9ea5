//! The law of recipes: a picture that is painted again from its weights is the one that a render in these colors makes.

use crate::random::{AREA, Drawn, HEIGHT, Pixels, WIDTH};
use crate::support::{all_bits, evaluate, graph_in, root, settings, under_all_settings, write_exr};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use std::path::Path;
use trochoid::{Buffers, CheckedGraph, Format, Frame, Kind, OutputFile, Recipe, Settings, Window, load, write_output};

/// Returns the graph with two recipes of its first output, in halves and in floats, as its last outputs.
fn with_recipes(graph: &CheckedGraph) -> CheckedGraph {
    let mut graph = graph.clone();
    for is_float in [false, true] {
        graph.add_recipe(0, is_float);
    }
    let all: Vec<usize> = (0..graph.outputs().len()).collect();
    match graph.with_recipes(&all) {
        Ok(graph) => graph,
        Err(faults) => panic!("{}", faults[0]),
    }
}

/// Returns settings for a picture that keeps its size because of the files it reads.
fn part(graph: &CheckedGraph) -> Settings {
    let window = Window::new(0, 0, 64, 36);
    settings(|s| (s.threads, s.region) = (2, (graph.format().window().area() > 10_000).then_some(window)))
}

/// Renders the recipes of the first output to files, reads them, and checks that all pictures beside them keep every
/// bit. Returns the recipes and the frame without them.
fn recipes(graph: &CheckedGraph, frame: i64, what: &str) -> ([Recipe; 2], Frame) {
    let with = with_recipes(graph);
    let plain = evaluate(graph, frame, &Buffers::new(), &part(graph));
    let made = evaluate(&with, frame, &Buffers::new(), &part(graph));
    let before = graph.outputs().len();
    assert!(all_bits(&made)[..before] == all_bits(&plain), "{what}: a picture changed");
    for (plain, made) in plain.pictures.iter().zip(&made.pictures) {
        assert_eq!((plain.audit, plain.control_count), (made.audit, made.control_count), "{what}");
    }
    let folder = tempfile::tempdir().unwrap();
    let recipes = [before, before + 1].map(|index| {
        let file = OutputFile { path: folder.path().join(format!("{index}.exr")), outputs: vec![index] };
        write_output(&with, &made, &file, &[]).unwrap();
        // Reading checks that weights are ≥ 0 with the sum 1.
        Recipe::read(&file.path).unwrap()
    });
    (recipes, plain)
}

/// Returns the colors of another graph that differs in nothing else, in the order of a recipe.
fn colors(graph: &CheckedGraph, recipe: &Recipe, frame: i64) -> Vec<[f64; 3]> {
    let graph = with_recipes(graph);
    let controls = graph.recipes().unwrap().controls();
    assert!(controls.iter().map(|control| &control.name).eq(&recipe.info.names));
    controls.iter().map(|control| control.color.at(frame as f64).try_into().unwrap()).collect()
}

/// Returns the largest difference of a recolored picture from a render in the same colors, in ulps of the largest
/// control, after subtracting what storing may change.
fn apart(recipe: &Recipe, colors: &[[f64; 3]], rendered: &Frame) -> f64 {
    let picture = &rendered.pictures[0];
    let painted = recipe.recolor(colors).unwrap();
    let largest = picture.hull.as_ref().unwrap().vertices().iter().flatten().fold(0.0_f32, |a, b| a.max(*b));
    let ulp = f64::from(largest.next_up() - largest).max(f64::from(f32::MIN_POSITIVE));
    let mut worst = 0.0_f64;
    for (channel, (painted, rendered)) in painted.iter().zip(&picture.planes).enumerate() {
        let values = colors.iter().map(|color| color[channel]);
        let (least, most) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        // What images contribute is beside the colors.
        let range = if recipe.info.has_images { most } else { most - least };
        let allowed = recipe.rounding.bound(range);
        for (painted, rendered) in painted.samples().iter().zip(rendered.samples()) {
            let off = (f64::from(*painted) - f64::from(*rendered)).abs();
            worst = worst.max((off - allowed) / ulp);
        }
    }
    worst
}

/// Checks the law for a graph and others that differ in their colors alone; returns how far floats are off, in ulps.
fn law(own: &CheckedGraph, others: &[CheckedGraph], frame: i64, what: &str) -> f64 {
    let (recipes, plain) = recipes(own, frame, what);
    let rendered = others.iter().map(|other| evaluate(other, frame, &Buffers::new(), &part(other)));
    let rendered: Vec<Frame> = std::iter::once(plain).chain(rendered).collect();
    let mut worst = 0.0_f64;
    for (recipe, is_float) in recipes.iter().zip([false, true]) {
        for (graph, rendered) in std::iter::once(own).chain(others).zip(&rendered) {
            let off = apart(recipe, &colors(graph, recipe, frame), rendered);
            assert!(off <= 4.0, "{what}: {off} ulps, floats: {is_float}");
            if is_float {
                worst = worst.max(off);
            }
        }
    }
    worst
}

/// Nodes of a small picture over which filters are tried.
const MIXED: &str = r##""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
    "n": { "type": "Noise", "scale": 4 }, "m": { "type": "Clamp", "field": "n", "min": -0.4, "max": 0.5 },
    "sky": { "type": "Ramp", "weight": "x", "stops": [{ "at": 0, "color": "palette.dusk" },
             { "at": 0.4, "color": "#204060" }, { "at": 1, "color": "palette.sun" }] },
    "sea": { "type": "Mix", "a": "palette.night", "b": "palette.foam", "weight": "m" },
    "c": { "type": "Constant", "color": "palette.moss" },
    "all": { "type": "Mix", "a": "sky", "b": "sea", "weight": "y" },
    "land": { "type": "Mix", "a": "all", "b": "c", "weight": 0.25 }"##;

const PALETTE: [(&str, &str, &str); 5] = [
    ("night", "\"#101a33\"", "\"#ffffff\""),
    ("dusk", "\"#5a3f5e\"", "\"#004411\""),
    ("sun", "{ \"keys\": [[1, \"#f0cf8e\"], [9, \"#ff0000\"]] }", "[0.1, 2.5, 0.3]"),
    ("foam", "\"#e8f4ff\"", "\"#112233\""),
    ("moss", "\"#2f6b3a\"", "\"#aa00aa\""),
];

/// Returns the picture in its own colors and in others.
fn both(folder: &Path, format: &str, more: &str, shown: &str) -> [CheckedGraph; 2] {
    [0, 1].map(|which| {
        let colors = PALETTE.map(|(name, own, other)| format!("\"{name}\": {}", if which == 0 { own } else { other }));
        let text = format!(
            r#"{{ "trochoid": 1, "format": {{ {format} }}, "working_space": "srgb", "palette": {{ {} }},
                "nodes": {{ {MIXED}, {more} }}, "outputs": {{ "o": {{ "color": "{shown}" }} }} }}"#,
            colors.join(", ")
        );
        graph_in(folder, &text)
    })
}

#[test]
fn every_filter_keeps_the_law_at_every_setting() {
    let folder = tempfile::tempdir().unwrap();
    let area = 24 * 16;
    let plane = |by: usize| -> Vec<f32> { (0..area).map(|i| ((i * by) % 97) as f32 / 97.0).collect() };
    let channels = [("R", plane(7)), ("G", plane(11)), ("B", plane(13))];
    let channels: Vec<(&str, &[f32])> = channels.iter().map(|(name, plane)| (*name, &plane[..])).collect();
    write_exr(&folder.path().join("a.exr"), 24, 16, &channels);
    let strokes = r#""type": "Strokes", "image": "land", "anchor": "screen", "layers": [{ "spacing": 5, "length": 9, "width": 4 }]"#;
    for (filter, what) in [
        (r#""type": "Blur", "image": "land", "size": 1.5"#, "f"),
        (r#""type": "Blur", "image": "land", "size": 2, "filter": "box""#, "f"),
        (r#""type": "Warp", "image": "land", "dx": "n", "dy": "m""#, "f"),
        (strokes, "f"),
        // A literal, an image and a chosen input.
        (r##""type": "Blur", "image": "#345678", "size": 2"##, "after"),
        (r#""type": "Read", "file": "a.exr", "as": "color""#, "after"),
        (r#""type": "Switch", "which": 1, "inputs": ["sky", "land"]"#, "f"),
    ] {
        let more = format!(
            r#""f": {{ {filter} }}, "b": {{ "type": "Blur", "image": "f", "size": 1 }},
               "after": {{ "type": "Mix", "a": "land", "b": "b", "weight": "m" }}"#
        );
        for format in [r#""width": 24, "height": 16"#, r#""width": 24, "height": 16, "samples": 4, "shading": "pixel""#]
        {
            let [own, other] = both(folder.path(), format, &more, what);
            law(&own, &[other], 3, filter);
            under_all_settings(&with_recipes(&own), 3, &Buffers::new(), filter);
        }
    }
}

#[test]
fn random_graphs_keep_the_law() {
    let folder = tempfile::tempdir().unwrap();
    let (mut worst, mut graphs, mut images) = (0.0_f64, 0, 0);
    for seed in 0..300 {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let pixels = Pixels::tame(&mut random);
        let file = format!("{seed}.exr");
        write_exr(&folder.path().join(&file), WIDTH as u32, HEIGHT as u32, &pixels.channels());
        let drawn = Drawn::draw(&mut random, &file);
        let repainted = |random: &mut Pcg64Mcg| -> CheckedGraph {
            let mut document: Value = serde_json::from_str(&drawn.text).unwrap();
            for node in document["nodes"].as_object_mut().unwrap().values_mut() {
                repaint(node, random);
            }
            graph_in(folder.path(), &document.to_string())
        };
        let (own, other) = (repainted(&mut random), repainted(&mut random));
        if own.outputs()[0].kind != Kind::Color {
            continue;
        }
        worst = worst.max(law(&own, &[other], 2, &format!("graph {seed}: {}", drawn.text)));
        graphs += 1;
        images += usize::from(with_recipes(&own).recipes().unwrap().has_images());
    }
    assert!(graphs > 250 && images > 50, "{graphs} graphs, {images} with images of {AREA} pixels");
    println!("floats are off by up to {worst:.2} ulps");
}

/// Gives new colors to a node.
fn repaint(value: &mut Value, random: &mut Pcg64Mcg) {
    let Some(items) = value.as_object_mut() else { return };
    let mut color = |value: &mut Value| {
        let is_literal =
            value.is_object() || value.as_array().is_some_and(|numbers| numbers.iter().all(Value::is_number));
        if is_literal {
            *value = json!([(); 3].map(|()| f64::from(random.random_range(0..=64_u32)) / 64.0));
        }
    };
    for (key, value) in items {
        match (key.as_str(), value) {
            ("a" | "b" | "color", value) => color(value),
            ("colors", Value::Array(colors)) => colors.iter_mut().for_each(&mut color),
            ("stops", Value::Array(stops)) => stops.iter_mut().for_each(|stop| color(&mut stop["color"])),
            _ => {}
        }
    }
}

#[test]
fn scenes_keep_the_law_in_their_second_palettes() {
    let palettes = root().join("graphs/palettes");
    for entry in std::fs::read_dir(root().join("graphs")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if path.extension().is_none_or(|extension| extension != "json") {
            continue;
        }
        let second = std::fs::read_dir(&palettes).unwrap().map(|entry| entry.unwrap().path());
        let second =
            second.filter(|file| file.file_stem().unwrap().to_string_lossy().rsplit_once('_').unwrap().0 == name);
        let own = load(&path, &[]).unwrap().graph;
        let small = |graph: CheckedGraph| {
            let reads =
                graph.nodes().iter().any(|node| matches!(node.ty.declaration().name, "Read" | "ViewFromPasses"));
            let format = graph.format();
            let samples = if format.samples() > 1 { 4 } else { 1 };
            let small = Format::new(64, 36, samples).unwrap().with_shading(format.shading());
            if reads { graph } else { graph.with_format(small) }
        };
        let own = small(own);
        let others: Vec<CheckedGraph> =
            second.map(|file| small(load(&path, &[format!("palette={}", file.display())]).unwrap().graph)).collect();
        let frame = (own.frames().0 + own.frames().1) / 2;
        law(&own, &others, frame, &name);
    }
}

#[test]
fn what_no_recipe_holds_is_refused() {
    let refused = |nodes: &str, words: &str| {
        let text = format!(
            r##"{{ "trochoid": 1, "format": {{ "width": 2, "height": 1 }}, "palette": {{ "p": "#123456", "q": "#fedcba" }},
                "nodes": {{ {nodes} }}, "outputs": {{ "o": {{ "recipe": "m" }} }} }}"##
        );
        let error = trochoid::parse("a.json", &text, Path::new("."), &[]).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    let keyed = r##""m": { "type": "Mix", "a": { "keys": [[1, "palette.p"], [5, "palette.q"]] }, "b": "#fff", "weight": 0.5 }"##;
    refused(keyed, "node \"m\", a: found \"palette.p\" in a key, in a picture with a recipe");
    let outside = r##""r": { "type": "Read", "file": "a.exr", "as": "color", "outside": "palette.p" },
        "m": { "type": "Mix", "a": "r", "b": "palette.q", "weight": 0.5 }"##;
    refused(outside, "node \"r\", outside: found \"palette.p\" as part of an image");
    refused(r#""m": { "type": "ScreenX" }"#, "expected a value for \"recipe\"");
}
