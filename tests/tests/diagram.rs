//! Drawings of graphs as SVG.

use crate::support::root;
use std::collections::HashSet;
use trochoid_diagram::Groups;

/// Draws all scenes that ship with Trochoid.
fn drawings() -> Vec<(String, trochoid::Loaded, String)> {
    let mut paths: Vec<_> =
        std::fs::read_dir(root().join("graphs")).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "json"));
    paths.sort();
    let draw = |path: &std::path::PathBuf| {
        let loaded = trochoid::load(path, &[]).unwrap();
        let picture = trochoid_diagram::tree(&loaded.graph, &[], &vec![None; loaded.graph.nodes().len()], Groups::Open);
        (path.display().to_string(), loaded, picture)
    };
    paths.iter().map(draw).collect()
}

#[test]
fn every_node_and_control_color_is_in_the_picture() {
    let drawings = drawings();
    assert!(!drawings.is_empty());
    for (path, loaded, picture) in &drawings {
        let names: HashSet<&str> = svg::read(picture).unwrap().filter_map(text).collect();
        for node in loaded.graph.nodes() {
            assert!(names.contains(node.name.as_str()), "{path}: {}", node.name);
        }
        let shown = vec![true; loaded.graph.nodes().len()];
        for swatch in trochoid_diagram::palette(&loaded.graph, &shown) {
            assert!(names.contains(swatch.to_string().as_str()), "{path}: {swatch}");
        }
        assert!(!picture.contains("NaN") && !picture.contains("inf,"), "{path}");
    }
}

fn text(event: svg::parser::Event<'_>) -> Option<&str> {
    if let svg::parser::Event::Text(text) = event { Some(text.trim()) } else { None }
}

#[test]
fn nodes_that_an_output_does_not_need_are_left_out() {
    let text = r##"{
      "trochoid": 1, "format": { "width": 2, "height": 2 },
      "nodes": {
        "across": { "type": "ScreenX" }, "down": { "type": "ScreenY" },
        "a": { "type": "Mix", "a": "#102030", "b": "#405060", "weight": "across" },
        "b": { "type": "Mix", "a": "#708090", "b": "#a0b0c0", "weight": "down" }
      },
      "outputs": { "first": { "color": "a" }, "second": { "color": "b" } }
    }"##;
    let loaded = trochoid::parse("two.json", text, std::path::Path::new("."), &[]).unwrap();
    let left_out = [None, Some("disabled".into()), None, None];
    let all = trochoid_diagram::tree(&loaded.graph, &[], &left_out, Groups::Closed);
    let one = trochoid_diagram::tree(&loaded.graph, &[0], &left_out, Groups::Closed);
    for (part, stays) in
        [(">across<", true), (">down<", false), ("#405060", true), ("#a0b0c0", false), (">second<", false)]
    {
        let compact = |picture: &str| picture.replace('\n', "");
        assert!(compact(&all).contains(part), "{part}");
        assert_eq!(compact(&one).contains(part), stays, "{part}");
    }
    assert!(all.contains("Left out: disabled") && all.contains("opacity"));
    assert!(!one.contains("opacity"));
}

#[test]
fn the_stored_trees_are_those_of_the_scenes() {
    let folder = root().join("graphs/trees");
    let trees: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(!trees.is_empty());
    for tree in trees {
        let name = tree.file_stem().unwrap().to_str().unwrap();
        let loaded = trochoid::load(&root().join(format!("graphs/{name}.json")), &[]).unwrap();
        let graph = &loaded.graph;
        let plan = trochoid::Plan::new(graph, &[], graph.frames().0, &[], &trochoid::Settings::default()).unwrap();
        let left_out: Vec<_> = plan.left_out().iter().map(|why| why.as_ref().map(ToString::to_string)).collect();
        let drawn = trochoid_diagram::tree(graph, &[], &left_out, Groups::Closed);
        // The title names the path that the document was loaded by.
        let after_title = |text: &str| {
            let (_, rest) = text.split_once("</title>").unwrap();
            // After the picture, the file names the program that made it.
            let (drawn, _) = rest.split_once("</svg>").unwrap();
            drawn.to_string()
        };
        let shown = std::fs::read_to_string(&tree).unwrap();
        assert!(after_title(&shown) == after_title(&drawn), "graphs/trees/{name}.svg is old: run samples/gallery.sh");
    }
}

/// Uses of a group that uses another one, and one use whose own result comes back to it.
const NESTED: &str = r##"{
  "trochoid": 1, "format": { "width": 2, "height": 2 },
  "groups": {
    "Inner": { "inputs": { "in": "Color" }, "nodes": { "tint": { "type": "Mix", "a": "in", "b": "#102030", "weight": 0.5 } },
               "outputs": { "color": "tint" } },
    "Outer": { "inputs": { "first": "Color", "second": { "kind": "Color", "default": "#fff" } },
               "nodes": { "x": { "type": "ScreenX" }, "one": { "type": "Inner", "in": "first" },
                          "two": { "type": "Mix", "a": "second", "b": "#405060", "weight": "x" } },
               "outputs": { "color": "two", "one": "one" } }
  },
  "nodes": {
    "ground": { "type": "Constant", "color": "#708090" },
    "plain": { "type": "Outer", "first": "ground", "second": "plain_too" },
    "plain_too": { "type": "Outer", "first": "ground" },
    "back": { "type": "Mix", "a": "circle.one", "b": "#a0b0c0", "weight": 0.5 },
    "circle": { "type": "Outer", "first": "plain", "second": "back" }
  },
  "outputs": { "o": { "color": "circle" }, "p": { "color": "plain.one" } }
}"##;

#[test]
fn uses_of_groups_are_boxes_that_can_be_opened() {
    let loaded = trochoid::parse("nested.json", NESTED, std::path::Path::new("."), &[]).unwrap();
    let left_out = vec![None; loaded.graph.nodes().len()];
    let names = |groups: Groups<'_>| {
        let drawn = trochoid_diagram::tree(&loaded.graph, &[], &left_out, groups);
        let names: Vec<String> = svg::read(&drawn).unwrap().filter_map(text).map(str::to_owned).collect();
        move |name: &str| names.iter().any(|known| known == name)
    };
    let closed = names(Groups::Closed);
    for shown in ["ground", "plain", "plain_too", "back", "o", "Outer · 3 nodes", "#405060"] {
        assert!(closed(shown), "{shown}");
    }
    assert!(!closed("plain/x") && !closed("plain/one/tint") && !closed("plain/one"));
    // A box that led to itself through another could not be drawn from the top down.
    assert!(closed("circle/x") && closed("circle/one") && closed("Inner · 1 node") && !closed("circle"));
    let open = names(Groups::Open);
    for node in loaded.graph.nodes() {
        assert!(open(&node.name), "{}", node.name);
    }
    let inside = names(Groups::Inside("plain"));
    assert!(inside("plain/x") && inside("plain/one") && inside("plain_too") && inside("ground"));
    assert!(!inside("back") && !inside("plain/one/tint") && !inside("o") && !inside("circle/x"));
    let within = names(Groups::Inside("plain/one"));
    assert!(within("plain/one/tint") && within("ground") && !within("plain/x"));
}
