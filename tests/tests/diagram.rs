//! Graphs drawn as pictures.

use crate::support::root;
use std::collections::HashSet;

/// Every scene that ships, drawn.
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
fn every_node_output_and_control_color_is_in_the_picture() {
    let drawings = drawings();
    assert!(drawings.len() > 10);
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
fn what_an_output_does_not_need_can_be_left_away() {
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
