//! A document's JSON, as far as the evaluator reads it.

use super::camera::Place;
use super::keys::at_frame;
use serde_json::Value as Json;
use std::collections::HashMap;

/// A document at a frame.
pub(super) struct Document {
    pub(super) width: i64,
    pub(super) height: i64,
    pub(super) samples: usize,
    /// Tolerance of adaptive sampling.
    pub(super) adaptive: Option<f64>,
    pub(super) shades_pixels: bool,
    /// Whether colors mix as they are encoded for display.
    is_encoded: bool,
    /// Seconds since the first frame.
    pub(super) time: f64,
    names: Vec<String>,
    nodes: Vec<Json>,
    indices: HashMap<String, usize>,
    outputs: HashMap<String, Json>,
}

impl Document {
    pub(super) fn new(json: &Json, frame: i64) -> Self {
        let (format, frames) = (&json["format"], &json["frames"]);
        let first = frames["first"].as_i64().unwrap_or(1);
        let fps = frames["fps"].as_f64().unwrap_or(24.0);
        let nodes = json["nodes"].as_object().unwrap();
        Self {
            width: format["width"].as_i64().unwrap(),
            height: format["height"].as_i64().unwrap(),
            samples: format["samples"].as_u64().unwrap_or(1) as usize,
            adaptive: format["adaptive"].as_f64(),
            shades_pixels: format["shading"] == "pixel",
            is_encoded: json["working_space"] == "srgb",
            time: (frame - first) as f64 / fps,
            names: nodes.keys().cloned().collect(),
            nodes: nodes.values().map(|node| at_frame(node, frame)).collect(),
            indices: nodes.keys().cloned().zip(0..).collect(),
            outputs: json["outputs"].as_object().unwrap().clone().into_iter().collect(),
        }
    }

    /// Returns the node that an output shows.
    pub(super) fn output(&self, name: &str) -> Json {
        let output = &self.outputs[name];
        ["color", "weights", "field"].into_iter().find_map(|kind| output.get(kind)).unwrap().clone()
    }

    pub(super) fn name(&self, node: usize) -> &str {
        &self.names[node]
    }

    pub(super) fn node(&self, index: usize) -> &Json {
        &self.nodes[index]
    }

    /// Returns the node that a wire comes from, and the word behind the dot; `None` for a literal.
    pub(super) fn wire<'a>(&self, source: &'a Json) -> Option<(usize, &'a str)> {
        let text = source.as_str().filter(|text| !text.starts_with('#'))?;
        let (name, output) = text.split_once('.').unwrap_or((text, ""));
        Some((self.indices[name], output))
    }

    /// Returns a literal's numbers; a color's in the working space.
    pub(super) fn literal(&self, source: &Json) -> Vec<f64> {
        match source {
            Json::String(color) => {
                let digits = |at: usize| f64::from(u8::from_str_radix(&color[at..at + 2], 16).unwrap()) / 255.0;
                [1, 3, 5].map(|at| if self.is_encoded { digits(at) } else { decoded(digits(at)) }).to_vec()
            }
            Json::Array(numbers) => numbers.iter().map(|number| number.as_f64().unwrap()).collect(),
            number => vec![number.as_f64().unwrap()],
        }
    }

    /// Returns a place of a pixel, or of the nearest one in the picture.
    pub(super) fn nearest(&self, place: Place) -> Place {
        Place { x: place.x.clamp(0, self.width - 1), y: place.y.clamp(0, self.height - 1), ..place }
    }
}

/// The display value of sRGB as linear light.
fn decoded(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// Returns a knob that is a number.
pub(super) fn number(node: &Json, key: &str, default: f64) -> f64 {
    node[key].as_f64().unwrap_or(default)
}

/// Returns a knob that is a list of three numbers.
pub(super) fn three(node: &Json, key: &str, default: [f64; 3]) -> [f64; 3] {
    let Some(list) = node[key].as_array() else { return default };
    [0, 1, 2].map(|axis| list[axis].as_f64().unwrap())
}

/// Returns the items of a list.
pub(super) fn list<'a>(node: &'a Json, key: &str) -> &'a [Json] {
    node[key].as_array().map_or(&[], |list| list)
}
