//! Random documents over the nodes that the evaluator knows.

mod world;

use rand::seq::IndexedRandom;
use rand::{Rng, RngExt};
use rand_pcg::Pcg64Mcg;
use serde_json::{Map, Value as Json, json};

/// What a document is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Family {
    /// Masks of the picture's coordinates, back-end nodes and filters.
    Flat,
    /// Seas, without or with a sail, their passes, back-end nodes and filters.
    Sea,
    /// A toon sea, without or with a sail, like seas.
    Toon,
    /// Strokes over a flat picture.
    Painted,
    /// Strokes on seas.
    PaintedSea,
}

/// Frame at which documents are evaluated.
pub(super) const FRAME: i64 = 7;

struct Draw<'r> {
    random: &'r mut Pcg64Mcg,
    nodes: Map<String, Json>,
    masks: Vec<String>,
    /// Fields of one component, which are finite everywhere.
    fields: Vec<String>,
    /// Fields of three components.
    vectors: Vec<String>,
    colors: Vec<String>,
    /// Weights of three shares.
    shares: Vec<String>,
    /// Masks of what a view sees, each of which is an output.
    passes: Vec<String>,
}

/// Returns a random document.
pub(super) fn draw(family: Family, random: &mut Pcg64Mcg) -> Json {
    let none = Vec::new;
    let mut draw = Draw {
        random,
        nodes: Map::new(),
        masks: none(),
        fields: none(),
        vectors: none(),
        colors: none(),
        shares: none(),
        passes: none(),
    };
    draw.coordinates();
    let has_view = !matches!(family, Family::Flat | Family::Painted);
    if has_view {
        draw.world(family == Family::Toon);
        draw.passes();
    }
    draw.formulas();
    let count = draw.random.random_range(4..=8);
    (0..count).for_each(|_| draw.mask());
    (0..count).for_each(|_| draw.color());
    let is_painted = matches!(family, Family::Painted | Family::PaintedSea);
    if is_painted {
        draw.strokes(has_view);
    } else if draw.random.random_bool(0.6) {
        draw.filter();
    }
    let [width, height] = if is_painted { [26, 18] } else { [14, 10] };
    let samples = *[1, 4, 4, 16].choose(draw.random).unwrap();
    // Strokes of 16 samples take the slow reference too long.
    let samples = if is_painted { samples.min(4) } else { samples };
    let shading = *["sample", "pixel"].choose(draw.random).unwrap();
    let space = *["linear-srgb", "srgb"].choose(draw.random).unwrap();
    let mut outputs = Map::new();
    let [some_mask, some_field] = [&draw.masks, &draw.fields].map(|all| all.choose(draw.random).cloned());
    let shown = [
        ("beauty", "color", draw.colors.last().cloned()),
        ("mask", "weights", some_mask),
        ("last_mask", "weights", draw.masks.last().cloned()),
        ("shares", "weights", draw.shares.last().cloned()),
        ("field", "field", some_field),
        ("last_field", "field", draw.fields.last().cloned()),
        ("vector", "field", draw.vectors.last().cloned()),
    ];
    // The other families hold masks and fields.
    for (name, kind, node) in shown.into_iter().take(if is_painted { 1 } else { usize::MAX }) {
        if let Some(node) = node {
            outputs.insert(name.into(), json!({ kind: node }));
        }
    }
    if !is_painted {
        for pass in &draw.passes {
            outputs.insert(pass.replace('.', "_"), json!({ "weights": pass }));
        }
    }
    draw.key_some();
    let adaptive = *[None, Some(0.05), Some(0.3)].choose(draw.random).unwrap();
    let mut format = json!({ "width": width, "height": height, "samples": samples, "shading": shading });
    if let Some(tolerance) = adaptive {
        format["adaptive"] = tolerance.into();
    }
    // The same as "literal" only at 60 frames per second.
    let is_resampled = draw.nodes.values().any(|node| node["mode"] == "resampled");
    json!({
        "trochoid": 1,
        "format": format,
        "working_space": space,
        "frames": { "first": 1, "last": 100, "fps": if is_resampled { 60 } else { 24 } },
        "nodes": draw.nodes,
        "outputs": outputs
    })
}

impl Draw<'_> {
    /// Adds a node and returns its name.
    fn node(&mut self, node: Json) -> String {
        let name = format!("n{}", self.nodes.len());
        self.nodes.insert(name.clone(), node);
        name
    }

    fn number(&mut self, from: f64, to: f64) -> f64 {
        // Few digits keep documents legible.
        (self.random.random_range(from..to) * 1000.0).round() / 1000.0
    }

    fn chance(&mut self, of: f64) -> bool {
        self.random.random_bool(of)
    }

    fn pick<'w>(&mut self, words: &[&'w str]) -> &'w str {
        words.choose(self.random).unwrap()
    }

    fn any(&mut self, of: fn(&Self) -> &Vec<String>) -> String {
        let all = of(self).clone();
        // The latest twice as often, so that graphs get deep.
        let from = if self.random.random_bool(0.5) { all.len() / 2 } else { 0 };
        all[from..].choose(self.random).unwrap().clone()
    }

    fn a_mask(&mut self) -> Json {
        if self.chance(0.9) { self.any(|draw| &draw.masks).into() } else { self.number(0.0, 1.0).into() }
    }

    fn a_color(&mut self) -> Json {
        if !self.colors.is_empty() && self.chance(0.5) {
            return self.any(|draw| &draw.colors).into();
        }
        if self.chance(0.5) {
            return format!("#{:06x}", self.random.next_u32() & 0xff_ffff).into();
        }
        json!([self.number(0.0, 1.0), self.number(0.0, 1.0), self.number(0.0, 3.0)])
    }

    fn coordinates(&mut self) {
        let nodes = [
            json!({ "type": "ScreenX" }),
            json!({ "type": "ScreenY" }),
            json!({ "type": "Shape", "edge": self.number(0.5, 4.0), "shapes": [
                { "center": [self.number(0.2, 1.0), self.number(0.2, 0.8)], "radius": self.number(0.1, 0.4) },
                { "form": "box", "center": [self.number(0.2, 1.0), self.number(0.2, 0.8)],
                  "angle": self.number(-90.0, 90.0), "size": [self.number(0.1, 0.6), self.number(0.1, 0.6)],
                  "corner": self.number(0.0, 0.1) }] }),
            json!({ "type": "Shape", "edge": 0, "shapes": [
                { "center": [self.number(0.2, 1.0), self.number(0.2, 0.8)], "radius": self.number(0.1, 0.4) }] }),
        ];
        for node in nodes {
            let name = self.node(node);
            self.masks.push(name.clone());
            self.fields.push(name);
        }
    }

    /// Adds formulas of fields.
    fn formulas(&mut self) {
        for _ in 0..2 {
            let (a, b) = (self.any(|draw| &draw.fields), self.any(|draw| &draw.fields));
            let (p, q) = (self.number(0.5, 4.0), self.number(0.1, 2.0));
            let expression = match self.random.random_range(0..4) {
                0 => format!("sin({p} * a) + {q} * b"),
                1 => format!("max(a, {q}) * b - {q}"),
                2 => format!("sqrt(1 + a * a) - {q} * cos({p} * b)"),
                _ => format!("(a - b) / (1 + {p} * a * a)"),
            };
            let name = self.node(json!({ "type": "FieldMath", "a": a, "b": b, "expression": expression }));
            self.fields.push(name);
        }
    }

    /// Adds a mask made of fields or other masks.
    fn mask(&mut self) {
        let min = self.number(-0.6, 0.6);
        let node = match self.random.random_range(0..6) {
            0 | 1 => json!({ "type": "Clamp", "field": self.any(|draw| &draw.fields), "min": min,
                "max": if self.chance(0.15) { min } else { min + self.number(0.2, 1.5) }, "smooth": self.chance(0.3),
                "power": if self.chance(0.3) { self.number(1.0, 3.0) } else { 1.0 } }),
            2 => json!({ "type": "Multiply", "weights": [self.a_mask(), self.a_mask()] }),
            3 => json!({ "type": "Screen", "weights": [self.a_mask(), self.a_mask()] }),
            4 => json!({ "type": "Bands", "field": self.any(|draw| &draw.fields), "thresholds": [min],
                "width": if self.chance(0.3) { 0.0 } else { self.number(0.1, 0.8) } }),
            _ => json!({ "type": "Invert", "weight": self.a_mask() }),
        };
        let name = self.node(node);
        self.masks.push(name);
    }

    /// Adds a color.
    fn color(&mut self) {
        let node = match self.random.random_range(0..6) {
            0 | 1 => json!({ "type": "Mix", "a": self.a_color(), "b": self.a_color(), "weight": self.a_mask() }),
            2 => {
                let stops = self.random.random_range(2..=4);
                let mut at: Vec<f64> = (0..stops).map(|_| self.number(0.0, 1.0)).collect();
                at.sort_by(f64::total_cmp);
                if self.chance(0.2) {
                    at[1] = at[0];
                }
                let stops: Vec<Json> = at.into_iter().map(|at| json!({ "at": at, "color": self.a_color() })).collect();
                json!({ "type": "Ramp", "weight": self.a_mask(), "stops": stops,
                    "interpolation": self.pick(&["linear", "smooth", "step"]) })
            }
            3 => {
                let weights = match self.random.random_range(0..3) {
                    0 => json!({ "type": "Stack", "weights": [self.a_mask(), self.a_mask()] }),
                    1 => json!({ "type": "Bands", "field": self.any(|draw| &draw.fields), "thresholds": [-0.2, 0.3],
                        "width": self.number(0.1, 0.8) }),
                    _ => {
                        let fields = [self.any(|draw| &draw.fields), self.any(|draw| &draw.fields)];
                        json!({ "type": "Normalize", "fields": fields, "floor": self.number(0.05, 0.5) })
                    }
                };
                let weights = self.node(weights);
                self.shares.push(weights.clone());
                let colors = [self.a_color(), self.a_color(), self.a_color()];
                json!({ "type": "Blend", "colors": colors, "weights": weights })
            }
            4 => {
                let count = if self.chance(0.5) { 4 } else { 16 };
                let colors: Vec<Json> = (0..count).map(|_| self.a_color()).collect();
                json!({ "type": "Patch", "u": self.a_mask(), "v": self.a_mask(), "colors": colors })
            }
            _ => json!({ "type": "Switch", "which": self.random.random_range(0..2),
                "inputs": [self.a_color(), self.a_color()] }),
        };
        let name = self.node(node);
        self.colors.push(name);
    }

    /// Adds a filter over the latest color, mask, field, vector and Weights.
    fn filter(&mut self) {
        let blur = |draw: &mut Self, image: String| {
            let mut blur = json!({ "type": "Blur", "image": image, "size": draw.number(0.2, 0.75),
                "filter": draw.pick(&["gaussian", "box"]) });
            if draw.chance(0.5) {
                blur["size_y"] = if draw.chance(0.3) { 0.0 } else { draw.number(0.2, 0.75) }.into();
            }
            blur
        };
        let warp = |draw: &mut Self, image: String| {
            let (by, most, from) = (draw.any(|draw| &draw.fields), draw.number(1.0, 4.0), draw.number(-2.0, 2.0));
            let dx = draw.node(json!({ "type": "FieldMath", "a": by, "expression": format!("{most} * a - 1") }));
            json!({ "type": "Warp", "image": image, "dx": dx, "dy": from, "reach": 3 })
        };
        type Pool = for<'a> fn(&'a mut Draw<'_>) -> &'a mut Vec<String>;
        let pools: [Pool; 5] = [
            |draw| &mut draw.colors,
            |draw| &mut draw.masks,
            |draw| &mut draw.fields,
            |draw| &mut draw.vectors,
            |draw| &mut draw.shares,
        ];
        for pool in pools {
            let Some(image) = pool(self).last().cloned() else { continue };
            let filtered = if self.chance(0.5) { blur(self, image) } else { warp(self, image) };
            let filtered = self.node(filtered);
            pool(self).push(filtered);
        }
    }

    /// Adds strokes over the last color.
    fn strokes(&mut self, has_view: bool) {
        let count = self.random.random_range(1..=2);
        let layers: Vec<Json> = (0..count)
            .map(|_| {
                json!({ "length": self.number(4.0, 9.0), "width": self.number(0.8, 5.0),
                    "spacing": self.number(2.0, 6.0), "density": self.number(0.5, 1.0),
                    "opacity": self.number(0.4, 1.0), "turn": self.number(0.0, 60.0), "stray": self.number(0.0, 3.0), "bristle": self.number(0.0, 1.0) })
            })
            .collect();
        let image = self.colors.last().unwrap().clone();
        let mut strokes = json!({ "type": "Strokes", "image": image, "layers": layers, "lost": self.number(0.0, 0.6),
            "seed": self.random.random_range(0..1000) });
        if has_view {
            strokes["view"] = "view".into();
            strokes["anchor"] = self.pick(&["rest", "rest", "screen"]).into();
            strokes["edge"] = self.number(0.05, 0.3).into();
        }
        if self.chance(0.7) {
            let (a, b, c) = (self.any(|draw| &draw.fields), self.number(-1.0, 1.0), self.number(1.0, 4.0));
            let expression = format!("[cos({c} * a), sin({c} * a) + {b}]").replace("+ -", "- ");
            strokes["flow"] =
                self.node(json!({ "type": "FieldMath", "a": a, "expression": expression, "components": 2 })).into();
        }
        for key in ["size", "density", "detail"] {
            if self.chance(0.3) {
                strokes[key] = self.any(|draw| &draw.masks).into();
            }
        }
        if self.chance(0.3) {
            strokes["height"] = self.random.random_range(9..16).into();
        }
        let name = self.node(strokes);
        self.colors.push(name);
    }

    /// Keys some knobs, whose values then differ from frame to frame by a few percent.
    fn key_some(&mut self) {
        const KNOBS: [&str; 9] =
            ["position", "target", "fov", "roll", "direction", "power", "shininess", "eta", "size"];
        let mut nodes = std::mem::take(&mut self.nodes);
        for node in nodes.values_mut().flat_map(Json::as_object_mut) {
            for (_, value) in node.iter_mut().filter(|(key, _)| KNOBS.contains(&key.as_str())) {
                let is_number = value.is_number() || value.is_array();
                if is_number && self.chance(0.35) {
                    *value = self.keyed(value);
                }
            }
        }
        self.nodes = nodes;
    }

    fn keyed(&mut self, value: &Json) -> Json {
        let keys = [1, 4, 9, 30].map(|frame| {
            let varied = |draw: &mut Self, number: &Json| number.as_f64().unwrap() * draw.number(1.0, 1.03);
            let value: Json = match value.as_array() {
                Some(list) => list.iter().map(|number| varied(self, number)).collect(),
                None => varied(self, value).into(),
            };
            json!([frame, value])
        });
        let interpolation = self.pick(&["linear", "hold", "monotone", "monotone"]);
        let mut keyed = json!({ "keys": keys, "interpolation": interpolation });
        if interpolation != "hold" && self.chance(0.5) {
            // Handles of half a percent, some of them longer than the way to the next key.
            let reach = [self.number(0.5, 6.0), self.number(0.5, 6.0)];
            for (key, frames) in [(1, -reach[0]), (1, reach[1]), (2, -reach[1])] {
                let (turn, value) = (self.number(-0.005, 0.005), keyed["keys"][key][1].clone());
                let changed = |number: &Json| number.as_f64().unwrap() * turn;
                let change: Json = match value.as_array() {
                    Some(list) => list.iter().map(changed).collect(),
                    None => changed(&value).into(),
                };
                let item = &mut keyed["keys"][key];
                if item[2].is_null() {
                    item.as_array_mut().unwrap().push(json!({}));
                }
                item[2][if frames < 0.0 { "in" } else { "out" }] = json!([frames, change]);
            }
        }
        keyed
    }
}
