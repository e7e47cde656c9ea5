//! Exported programs in WGSL, as a card runs them: at hostile values, and for pixels of whole scenes.

use super::super::card::Card;
use super::{card, number};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use std::path::Path;
use trochoid::{
    Access, Buffers, Cache, CheckedGraph, Illegal, Kind, Look, Plan, Samples, SamplesMut, Settings, Silent, parse,
    parse_within,
};
use trochoid_export::{ExportError, Language, Request, export};

/// Largest difference of a color in [0, 1], of which 1/255 is seen.
const MOST: f32 = 2e-6;

/// Runs an exported function on a card, and returns its colors, channel by channel. Each channel of `planes` is a number
/// that it takes, or the part of a color.
fn run(card: &Card, graph: &CheckedGraph, bound: &[&str], colors: &[bool], planes: &[&[f32]]) -> Vec<f32> {
    let request = Request { output: 0, frame: 1, bound, linear: false, language: Language::Wgsl, by: "a test" };
    let shader = export(graph, &request).unwrap();
    let mut channels = 0..planes.len();
    let mut next = || format!("taken({}u, pixel)", channels.next().unwrap());
    let mut passed = Vec::new();
    for is_color in colors {
        passed.push(if *is_color { format!("vec3f({}, {}, {})", next(), next(), next()) } else { next() });
    }
    let count = planes[0].len();
    let text = format!(
        "{}
@group(0) @binding(0) var<storage, read_write> made: array<u32>;
@group(0) @binding(1) var<storage, read> given: array<u32>;

fn taken(channel: u32, pixel: u32) -> f32 {{
    let bits = given[channel * {count}u + pixel];
    return bitcast<f32>(select(bits, 0u, (bits & 0x7fffffffu) > 0x7f800000u));
}}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {{
    if (id.x < {}u) {{
        let pixel = id.x % {count}u;
        let color = {}({});
        made[id.x] = bitcast<u32>(color[id.x / {count}u]);
    }}
}}
",
        shader.text,
        3 * count,
        shader.names[0],
        passed.join(", "),
    );
    let kernel = card.kernel(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let parts: Vec<&[u8]> = planes.iter().map(|plane| bytemuck::cast_slice(plane)).collect();
    let given = card.upload(&parts).unwrap();
    let bytes = card.run(&kernel, 3 * count, &[&given]).unwrap();
    bytemuck::pod_collect_to_vec(&bytes)
}

/// Every operation.
const LOOK: &str = r##"{ "trochoid": 1, "format": { "width": 4, "height": 2 }, "working_space": "srgb", "nodes": {
    "across": { "type": "Noise", "scale": 3 }, "down": { "type": "Noise", "scale": 5 }, "tint": { "type": "Constant", "color": "#204060" },
    "parts": { "type": "Bands", "field": "across", "thresholds": [0.2, 0.6] },
    "lit": { "type": "Clamp", "field": "across", "min": 0.1, "max": 0.9, "smooth": true },
    "deep": { "type": "Clamp", "field": "down", "min": -0.5, "max": 2, "power": 2.5 },
    "wide": { "type": "Clamp", "field": "down", "min": -3.4e38, "max": 3.4e38, "power": 70.3 },
    "sides": { "type": "Bands", "field": "down", "thresholds": [0.5] },
    "hard": { "type": "PickWeight", "weights": "sides", "index": 1 },
    "both": { "type": "Multiply", "weights": ["lit", "deep"] },
    "other": { "type": "Invert", "weight": "hard" },
    "shares": { "type": "Normalize", "fields": ["across", "down"], "floor": 0.5 },
    "one": { "type": "PickWeight", "weights": "shares", "index": 1 },
    "water": { "type": "Mix", "a": "tint", "b": "#ece6c2", "weight": "both" },
    "some": { "type": "Blend", "colors": ["water", "#839191", "#274e53"], "weights": "shares" },
    "more": { "type": "Blend", "colors": ["some", "#ffffff", "water"], "weights": "parts" },
    "fixed": { "type": "Blend", "colors": ["more", "tint"], "weights": [0.25, 0.75] },
    "mixed": { "type": "Mix", "a": "fixed", "b": "more", "weight": "other" },
    "far": { "type": "Mix", "a": "mixed", "b": "#c04020", "weight": "wide" },
    "look": { "type": "Mix", "a": "far", "b": "#000000", "weight": "one" } },
  "outputs": { "look": { "color": "look" } } }"##;

#[test]
fn every_operation_is_computed_as_by_the_processor_at_hostile_values_too() {
    let graph = parse("look.json", LOOK, Path::new("."), &[]).unwrap().graph;
    let bound = ["across", "down", "tint", "parts"];
    let look = Look::new(graph.clone(), "look", 1, &bound, &Settings::default()).unwrap();
    let look = look.with_illegal(Illegal::Clamp);
    assert_eq!(look.inputs(), 8);
    let mut random = Pcg64Mcg::new(0x109a);
    let count = 6000;
    let mut planes: Vec<Vec<f32>> = vec![Vec::new(); 8];
    for _ in 0..count {
        for (channel, plane) in planes.iter_mut().enumerate() {
            let value = number(&mut random);
            // A card may take the smallest numbers as 0, which a sum of weights must not be.
            let value = if value.is_subnormal() { 0.0 } else { value };
            plane.push(if (2..5).contains(&channel) { random.random() } else { value });
        }
    }
    let planes: Vec<&[f32]> = planes.iter().map(Vec::as_slice).collect();
    let mut expected = vec![vec![0.0; count]; 3];
    let inputs: Vec<Samples<'_>> = planes.iter().map(|plane| Samples::new(plane)).collect();
    let mut outputs: Vec<SamplesMut<'_>> = expected.iter_mut().map(|plane| SamplesMut::new(plane)).collect();
    look.shader().unwrap().shade(count, &inputs, &mut outputs).unwrap();
    let colors = [false, false, true, false, false, false];
    let found = run(&card(), &graph, &bound, &colors, &planes);
    for (at, (found, expected)) in found.iter().zip(expected.concat()).enumerate() {
        let taken: Vec<f32> = planes.iter().map(|plane| plane[at % count]).collect();
        assert!((found - expected).abs() <= MOST, "{taken:?}: {found} {expected}");
    }
}

#[test]
fn scenes_are_computed_as_by_the_processor() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../graphs");
    let access = Access::usual(&folder).allowing(&folder.join("../samples"));
    let card = card();
    for scene in ["open_sea", "glow", "noise_and_shapes", "painted_normals", "from_passes", "cartoon_bay"] {
        let text = std::fs::read_to_string(folder.join(format!("{scene}.json"))).unwrap();
        let mut document: Value = serde_json::from_str(&text).unwrap();
        let format = &mut document["format"];
        format["samples"] = 1.into();
        // Small scenes may read pictures of their size.
        if format["width"].as_u64().is_some_and(|width| width > 640) {
            (format["width"], format["height"]) = (96.into(), 54.into());
        }
        let outputs = document["outputs"].as_object().unwrap();
        let (name, output) = outputs.iter().find(|(_, output)| output.get("color").is_some()).unwrap();
        let mut outputs = json!({ name: { "color": output["color"] } });
        let parsed = |outputs: &Value| {
            let mut document = document.clone();
            document["outputs"] = outputs.clone();
            parse_within(scene, &document.to_string(), &folder, &[], access.clone()).unwrap().graph
        };
        // What a shader cannot compute becomes an output, too.
        let plain = parsed(&outputs);
        let request = Request { output: 0, frame: 1, bound: &[], linear: false, language: Language::Wgsl, by: "" };
        let Err(ExportError::Unbound(unbound)) = export(&plain, &request) else { panic!("{scene} has no inputs") };
        for (at, input) in unbound.iter().enumerate() {
            let key = match input.kind {
                Kind::Color => "color",
                Kind::Weights(_) => "weights",
                _ => "field",
            };
            outputs[format!("in{at}")] = json!({ key: input.input });
        }
        let graph = parsed(&outputs);
        let plan = Plan::new(&graph, &[], 1, &[], &Settings::default()).unwrap();
        let mut frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
        frame.pictures.sort_by_key(|picture| picture.output);
        let (made, inputs) = frame.pictures.split_first().unwrap();
        let colors = inputs.iter().flat_map(|input| match input.kind {
            Kind::Color => vec![true],
            kind => vec![false; kind.channels()],
        });
        let planes: Vec<&[f32]> = inputs.iter().flat_map(|input| &input.planes).map(|plane| plane.samples()).collect();
        let bound: Vec<&str> = unbound.iter().map(|input| input.input.as_str()).collect();
        let found = run(&card, &plain, &bound, &colors.collect::<Vec<_>>(), &planes);
        let expected = made.planes.iter().flat_map(|plane| plane.samples());
        let off = found.iter().zip(expected).map(|(found, expected)| (found - expected).abs()).fold(0.0, f32::max);
        assert!(off <= MOST && found.len() == 3 * planes[0].len(), "{scene}: {off}");
    }
}
