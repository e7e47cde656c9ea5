//! What the reference of each node evaluates. A new node must be added here.

use crate::support::{evaluate, folder, graph_in, root, settings};
use std::collections::BTreeSet;
use std::path::Path;
use trochoid::{Buffers, Cache, ReferenceFrame, Silent};

/// Nodes whose references are computed in f64 from the knobs, from files, and from the references of their inputs: no
/// number of a picture enters. For seas, these are sums and simulations in f64.
const DOUBLE: &[&str] = &[
    "Bake",
    "Bands",
    "Blend",
    "Blur",
    "Camera",
    "Clamp",
    "Clouds",
    "Constant",
    "CrestFoam",
    "CryptoMask",
    "Curvature",
    "Decompose",
    "Depth",
    "DriftLines",
    "FieldMath",
    "Float",
    "FlowField",
    "FoldFoam",
    "Fresnel",
    "GerstnerSea",
    "Grain",
    "Height",
    "Hooks",
    "Invert",
    "Light",
    "LightPool",
    "LineSet",
    "Mesh",
    "Mix",
    "Noise",
    "NonSpecular",
    "Normal",
    "Normalize",
    "Outline",
    "Patch",
    "PickWeight",
    "Position",
    "Ramp",
    "Render",
    "Rest",
    "RestDistance",
    "Rift",
    "RippleSea",
    "Screen",
    "ScreenX",
    "Scumble",
    "Shape",
    "Sheet",
    "Silhouette",
    "Sky",
    "Specular",
    "Spray",
    "Stack",
    "Strokes",
    "SurfaceLines",
    "Switch",
    "Texture",
    "Thickness",
    "ToonSea",
    "Translucency",
    "UV",
    "Warp",
    "WaterlineFoam",
];

/// Nodes of the same kind in whose golden cases every number is an f32.
const SHORT: &[&str] = &["BezierModel", "Multiply", "ScreenY", "Shadow"];

/// Nodes without arithmetic, which compare or hand on what they are given: their pictures are their references.
const EXACT: &[&str] = &["InFront", "ObjectMask", "Read", "ViewFromPasses"];

/// Returns a node's golden case.
fn case(name: &str, folder: &Path) -> trochoid::CheckedGraph {
    let document = std::fs::read_to_string(root().join(format!("tests/nodes/{name}.json"))).unwrap();
    graph_in(folder, &document)
}

/// Whether any reference of a node's golden case is no f32, and whether all equal the picture.
fn looked_at(name: &str, folder: &Path) -> (bool, bool) {
    let graph = case(name, folder);
    let names: Vec<&str> = graph.outputs().iter().map(|output| output.name.as_str()).collect();
    let number = graph.frames().0;
    let frame = evaluate(&graph, number, &Buffers::new(), &settings(|_| ()));
    let reference = ReferenceFrame::prepared(&graph, &names, number, &mut Cache::new(), &Silent).unwrap();
    let (mut is_double, mut is_picture) = (false, true);
    let window = graph.format().window();
    let pixels: Vec<[i64; 2]> =
        (window.y0..window.y1).flat_map(|y| (window.x0..window.x1).map(move |x| [x, y])).collect();
    for (at, pixel) in reference.pixels(&pixels, &Silent).unwrap().into_iter().enumerate() {
        for (picture, found) in frame.pictures.iter().zip(pixel) {
            for (plane, value) in picture.planes.iter().zip(found.value) {
                is_double |= value.is_finite() && value != f64::from(value as f32);
                is_picture &= f64::from(plane.samples()[at]) == value;
            }
        }
    }
    (is_double, is_picture)
}

#[test]
fn every_node_says_what_its_reference_evaluates() {
    let registry = trochoid::registry();
    let all: BTreeSet<&str> = registry.names().collect();
    let listed: Vec<&str> = DOUBLE.iter().chain(SHORT).chain(EXACT).copied().collect();
    assert_eq!(listed.iter().copied().collect::<BTreeSet<_>>(), all, "each node in one list");
    assert_eq!(listed.len(), all.len(), "no node in two lists");
    let folder = folder();
    for name in all {
        let (is_double, is_picture) = looked_at(name, folder.path());
        assert_eq!(is_double, DOUBLE.contains(&name), "{name}: whether a reference needs more than an f32");
        assert!(is_picture || DOUBLE.contains(&name), "{name}: the picture is not the reference");
    }
}
