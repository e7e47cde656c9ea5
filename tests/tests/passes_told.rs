//! Passes of other renderers: what `check` tells of them, and that they are as those of a Render.

use crate::support::{evaluate, folder, graph_in, settings, write_exr};
use std::path::Path;
use trochoid::{Buffers, CheckedGraph, Plan};

const WIDTH: u32 = 48;
const HEIGHT: u32 = 27;

const CAMERA: &str = r#""type": "Camera", "position": [3, 6, 26], "target": [0, 0, 0], "fov": 55"#;

/// Returns a document in whose view a plane floats before the sky.
fn document(folder: &Path, camera: &str, view: &str) -> CheckedGraph {
    let text = format!(
        r#"{{ "trochoid": 1, "format": {{ "width": {WIDTH}, "height": {HEIGHT} }}, "nodes": {{
            "camera": {{ {camera} }}, "mesh": {{ "type": "Mesh", "file": "mesh.obj" }}, "view": {{ {view}, "camera": "camera" }},
            "depth": {{ "type": "Depth", "view": "view" }}, "position": {{ "type": "Position", "view": "view" }},
            "normal": {{ "type": "Normal", "view": "view" }},
            "rim": {{ "type": "Silhouette", "view": "view", "cutoff": 0.3, "ramp": 0.6 }} }},
            "outputs": {{ "coverage": {{ "weights": "view.coverage" }}, "depth": {{ "field": "depth" }},
                "rim": {{ "weights": "rim" }}, "position": {{ "field": "position" }}, "normal": {{ "field": "normal" }} }} }}"#
    );
    graph_in(folder, &text)
}

/// Returns the channels of all outputs: coverage, depth, rim, three of the position and three of the normal.
fn planes(graph: &CheckedGraph) -> Vec<Vec<f32>> {
    let frame = evaluate(graph, 1, &Buffers::new(), &settings(|_| ()));
    let of = |name: &str| frame.pictures.iter().find(|picture| graph.outputs()[picture.output].name == name).unwrap();
    let planes =
        ["coverage", "depth", "rim", "position", "normal"].map(of).into_iter().flat_map(|picture| &picture.planes);
    planes.map(|plane| plane.samples().to_vec()).collect()
}

/// Returns what `check` says of the files of a document.
fn notes(graph: &CheckedGraph) -> Vec<String> {
    let plan = Plan::new(graph, &[], 1, &[], &settings(|_| ())).unwrap();
    plan.file_notes().into_iter().flat_map(|(_, notes)| notes).collect()
}

/// Writes the passes of a Render as another renderer would: depth along the ray if so, and all of the sky 0.
fn write_passes(folder: &Path, along_ray: bool) -> Vec<Vec<f32>> {
    let rendered = planes(&document(folder, CAMERA, r#""type": "Render", "surfaces": ["mesh"]"#));
    let [coverage, depth, rim, x, y, z, a, b, c] = &rendered[..] else { panic!("{} planes", rendered.len()) };
    assert!(coverage.contains(&0.0) && coverage.contains(&1.0) && rim.iter().any(|rim| 0.0 < *rim && *rim < 1.0));
    let seen = |normal: &[f32]| normal.iter().zip(coverage).map(|(part, seen)| part * seen).collect::<Vec<f32>>();
    let [a, b, c] = [a, b, c].map(|normal| seen(normal));
    let from = [3.0, 6.0, 26.0];
    let stored: Vec<f32> = (0..depth.len())
        .map(|at| {
            let seen = [x[at], y[at], z[at]].map(f64::from);
            let distance = seen.iter().zip(from).map(|(p, c)| (p - c) * (p - c)).sum::<f64>().sqrt();
            match (coverage[at] > 0.0, along_ray) {
                (false, _) => 0.0,
                (true, true) => distance as f32,
                (true, false) => depth[at],
            }
        })
        .collect();
    let position: [(&str, &[f32]); 3] = [("p.X", x), ("p.Y", y), ("p.Z", z)];
    let others: [(&str, &[f32]); 4] = [("d.T", &stored), ("n.X", &a), ("n.Y", &b), ("n.Z", &c)];
    write_exr(&folder.join("a.exr"), WIDTH, HEIGHT, &[&position[..], &others[..]].concat());
    rendered
}

const PASSES: &str = r#""type": "ViewFromPasses", "file": "a.exr", "depth": "d.T", "position": "p", "normal": "n""#;

#[test]
fn passes_with_depth_along_the_ray_and_without_a_sky_are_as_rendered() {
    let folder = folder();
    for along_ray in [true, false] {
        let rendered = write_passes(folder.path(), along_ray);
        let found = planes(&document(folder.path(), CAMERA, PASSES));
        for (plane, (rendered, found)) in rendered.iter().zip(&found).enumerate() {
            for (at, (rendered, found)) in rendered.iter().zip(found).enumerate() {
                let close = rendered == found || (rendered - found).abs() <= 1e-6 * rendered.abs();
                assert!(close, "plane {plane}, pixel {at}: {found}, not {rendered}; along the ray: {along_ray}");
            }
        }
    }
}

#[test]
fn check_says_what_depth_is() {
    let folder = folder();
    let said = |camera: &str, knobs: &str| notes(&document(folder.path(), camera, &format!("{PASSES}{knobs}")));
    let is = |notes: Vec<String>, what: &[&str]| {
        assert!(notes.len() == 1 && what.iter().all(|what| notes[0].contains(what)), "{notes:?}");
    };
    let elsewhere = CAMERA.replace("[3, 6, 26]", "[-9, 12, 19]");
    write_passes(folder.path(), true);
    is(said(CAMERA, ""), &["measured along the ray, and is converted", "within 0.00 % of distances"]);
    is(
        said(CAMERA, r#", "depth_is": "planar""#),
        &["is read as \"planar\", but positions tell that it is \"distance\""],
    );
    is(said(&elsewhere, ""), &["does not fit the positions", "Compare camera, \"up\" and \"scale\" with"]);
    is(said(CAMERA, r#", "up": "z""#), &["does not fit the positions"]);
    assert_eq!(said(CAMERA, r#", "convention": "mitsuba""#), [""; 0]);
    write_passes(folder.path(), false);
    assert_eq!(said(CAMERA, ""), [""; 0]);
    is(
        said(CAMERA, r#", "depth_is": "distance""#),
        &["is read as \"distance\", but positions tell that it is \"planar\""],
    );
}

#[test]
fn check_says_when_names_of_a_cryptomatte_are_not_known() {
    let folder = folder();
    let graph = |file: &str| {
        let text = format!(
            r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 3 }}, "nodes": {{
                "mask": {{ "type": "CryptoMask", "file": "{file}", "names": ["hull"] }} }},
                "outputs": {{ "mask": {{ "weights": "mask" }} }} }}"#
        );
        graph_in(folder.path(), &text)
    };
    assert_eq!(notes(&graph("crypto.exr")), [""; 0]);
    let id = [f32::from_bits(0x2c1f_9a4a); 12];
    let channels: [(&str, &[f32]); 2] = [("CryptoObject00.r", &id), ("CryptoObject00.g", &[0.5; 12])];
    write_exr(&folder.path().join("bare.exr"), 4, 3, &channels);
    let said = notes(&graph("bare.exr"));
    assert!(said.len() == 1 && said[0].contains("has no manifest: IDs are computed from the names"), "{said:?}");
}
