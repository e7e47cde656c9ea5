//! Drawings of graphs as SVG.

use crate::support::root;
use std::collections::HashSet;

/// Draws all scenes that ship with Trochoid.
fn drawings() -> Vec<(String, trochoid::Loaded, String)> {
    let mut paths: Vec<_> =
        std::fs::read_dir(root().join("graphs")).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "json"));
    paths.sort();
    let draw = |path: &std::path::PathBuf| {
        let loaded = trochoid::load(path, &[]).unwrap();
        let picture = trochoid_diagram::tree(&loaded.graph, &[], &vec![None; loaded.graph.nodes().len()]);
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
    let all = trochoid_diagram::tree(&loaded.graph, &[], &left_out);
    let one = trochoid_diagram::tree(&loaded.graph, &[0], &left_out);
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
        let drawn = trochoid_diagram::tree(graph, &[], &left_out);
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
