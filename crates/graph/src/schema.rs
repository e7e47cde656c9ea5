//! The JSON Schema of documents, generated from the declarations.

use crate::check::weight_names::{WEIGHT_NAMES, takes_weight_names};
use crate::{Accepts, Arity, Item, Knob, KnobDefault, KnobType, Precision, Registry, expand};
use serde_json::{Map, Value, json};
use trochoid_image::{MAX_SIDE, Shading, WorkingSpace};

/// Returns the JSON Schema (draft 2020-12) of documents that use the node types of a registry.
pub fn schema(registry: &Registry) -> Value {
    let mut types: Vec<Value> = registry
        .iter()
        .map(|ty| {
            let declaration = ty.declaration();
            let mut object = object(declaration.items);
            object["description"] = json!(declaration.summary);
            object["properties"]["type"] = json!({ "const": declaration.name });
            object["properties"]["disabled"] = json!({ "type": "boolean", "default": false });
            object["properties"]["ui"] = json!(true);
            object["properties"]["notes"] = json!(true);
            if takes_weight_names(declaration) {
                object["properties"][WEIGHT_NAMES] = json!({
                    "description": "Names of the weights, in their order: a reference picks one, as in \"parts.light\".",
                    "type": "array",
                    "items": { "type": "string", "pattern": "^[A-Za-z_][A-Za-z0-9_]*$" },
                    "uniqueItems": true
                });
            }
            if let Some(required) = object["required"].as_array_mut() {
                required.insert(0, json!("type"));
            }
            object
        })
        .collect();
    let names: Vec<&str> = registry.names().collect();
    types.push(json!({
        "description": "A use of a group, with its inputs and knobs.",
        "type": "object",
        "required": ["type"],
        "properties": { "type": { "type": "string", "not": { "enum": names } } }
    }));
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Trochoid document",
        "type": "object",
        "required": ["trochoid", "format", "nodes", "outputs"],
        "additionalProperties": false,
        // Without groups, every type is one of the registry.
        "if": { "not": { "anyOf": [{ "required": ["groups"] }, { "required": ["include"] }] } },
        "then": { "properties": { "nodes": { "additionalProperties": { "properties": { "type": { "enum": names } } } } } },
        "properties": {
            "trochoid": { "const": 1, "description": "Version of the document format." },
            "format": {
                "type": "object",
                "description": "Size of the pictures in pixels, and number of samples averaged per pixel.",
                "required": ["width", "height"],
                "additionalProperties": false,
                "properties": {
                    "width": { "type": "integer", "minimum": 1, "maximum": MAX_SIDE },
                    "height": { "type": "integer", "minimum": 1, "maximum": MAX_SIDE },
                    "samples": { "enum": [1, 4, 16], "default": 1 },
                    "shading": {
                        "enum": Shading::ALL.map(Shading::name),
                        "default": Shading::default().name(),
                        "description": "Where passes that vary smoothly over a surface are evaluated: \"sample\" at every \
                                        sample; \"pixel\", about four times as fast, at the pixel's first sample for \
                                        all samples that see the same surface."
                    },
                    "adaptive": {
                        "type": "number", "minimum": 0, "maximum": 1,
                        "description": "Tolerance of adaptive sampling: a pixel keeps its first sample if those of the \
                                        pixels around it differ by at most this, in square roots of values. Without it, \
                                        every sample is taken."
                    }
                }
            },
            "working_space": {
                "enum": WorkingSpace::ALL.map(WorkingSpace::name),
                "default": "linear-srgb",
                "description": "Color space in which colors mix and the guarantee holds; srgb is display-encoded, like sampled swatches."
            },
            "tolerance": {
                "description": "Required accuracy of pictures; settings that reach it are chosen at rendering.",
                "anyOf": [
                    { "type": "number", "exclusiveMinimum": 0, "maximum": 1 },
                    { "enum": ["exact", "reference"] },
                    { "type": "string", "pattern": "^[0-9.e+-]+ */ *[0-9.e+-]+$" }
                ]
            },
            "frames": {
                "type": "object",
                "description": "Range of frames; time is (frame − first)/fps seconds.",
                "additionalProperties": false,
                "properties": {
                    "first": { "type": "integer", "default": 1 },
                    "last": { "type": "integer" },
                    "fps": { "type": "number", "exclusiveMinimum": 0, "default": 24 }
                }
            },
            "palette": {
                "description": "Colors by name, which \"palette.NAME\" stands for; or the path of a file that has them, JSON or .gpl, relative to the document.",
                "anyOf": [
                    { "type": "string" },
                    {
                        "type": "object",
                        "propertyNames": { "pattern": "^[A-Za-z_][A-Za-z0-9_]*$" },
                        "additionalProperties": { "anyOf": [{ "$ref": "#/$defs/color" }, keyed(json!({ "$ref": "#/$defs/color" }))] }
                    }
                ]
            },
            "include": {
                "description": "Documents whose groups this one uses, by paths relative to it.",
                "type": "array",
                "items": { "type": "string", "minLength": 1 }
            },
            "knobs": {
                "description": "Knobs of the document by name, which links name as \"= knobs.NAME\": a value, or \"value\" with min, max, unit and help.",
                "type": "object",
                "propertyNames": { "pattern": "^[A-Za-z_][A-Za-z0-9_]*$" },
                "additionalProperties": knob_of("value")
            },
            "groups": {
                "description": "Groups of nodes by name, each of which is used like a node type.",
                "type": "object",
                "propertyNames": { "pattern": "^[A-Za-z_][A-Za-z0-9_]*$" },
                "additionalProperties": { "$ref": "#/$defs/group" }
            },
            "nodes": { "$ref": "#/$defs/nodes" },
            "outputs": {
                "type": "object",
                "minProperties": 1,
                "propertyNames": { "pattern": "^[A-Za-z0-9_-]+$" },
                "additionalProperties": { "$ref": "#/$defs/output" }
            },
            "ui": { "description": "Data of editors; evaluation ignores it." },
            "notes": { "description": "Comments for people; evaluation ignores them." }
        },
        "$defs": {
            "nodes": {
                "type": "object",
                "propertyNames": { "pattern": "^[A-Za-z_][A-Za-z0-9_]*$" },
                "additionalProperties": { "oneOf": types }
            },
            "group": {
                "type": "object",
                "required": ["nodes", "outputs"],
                "additionalProperties": false,
                "properties": {
                    "inputs": {
                        "description": "Sockets by name: their kind, or an object with \"kind\" and \"default\" or \"optional\".",
                        "type": "object",
                        "additionalProperties": {
                            "anyOf": [
                                { "enum": expand::input_kinds() },
                                {
                                    "type": "object",
                                    "required": ["kind"],
                                    "additionalProperties": false,
                                    "properties": {
                                        "kind": { "enum": expand::input_kinds() },
                                        "default": true,
                                        "optional": { "type": "boolean", "default": false },
                                        "help": { "type": "string" },
                                        "notes": true
                                    }
                                }
                            ]
                        }
                    },
                    "knobs": {
                        "description": "Knobs by name, which links within name as \"= knobs.NAME\".",
                        "type": "object",
                        "additionalProperties": knob_of("default")
                    },
                    "nodes": { "$ref": "#/$defs/nodes" },
                    "outputs": {
                        "description": "References within the group by name; the first is meant where none is named.",
                        "type": "object",
                        "minProperties": 1,
                        "additionalProperties": { "$ref": "#/$defs/reference" }
                    },
                    "ui": true,
                    "notes": true
                }
            },
            "link": {
                "description": "Value of another knob, \"= knobs.NAME\" or \"= NODE.KNOB\"; or a formula of such numbers, frame, time, width and height.",
                "type": "string",
                "pattern": "^="
            },
            "reference": { "description": "\"node\" for the first output of a node, or \"node.output\".", "type": "string", "pattern": "^[A-Za-z_][A-Za-z0-9_]*(\\.[A-Za-z0-9_]+){0,2}$" },
            "color": {
                "oneOf": [
                    { "type": "string", "pattern": "^(#([0-9A-Fa-f]{3}|[0-9A-Fa-f]{6})|palette\\.[A-Za-z_][A-Za-z0-9_]*)$" },
                    { "type": "array", "items": { "type": "number", "minimum": 0 }, "minItems": 3, "maxItems": 3 }
                ]
            },
            "output": {
                "type": "object",
                "description": "One picture: exactly one of color, weights, field and recipe.",
                "additionalProperties": false,
                "properties": {
                    "color": { "$ref": "#/$defs/reference" },
                    "weights": { "$ref": "#/$defs/reference" },
                    "field": { "$ref": "#/$defs/reference" },
                    "recipe": { "$ref": "#/$defs/reference", "description": "A color whose weights are written instead of the color: a channel of an EXR file for each control color, from which `trochoid recolor` makes the picture in other colors." },
                    "file": { "type": "string", "description": "Path that ends in .exr or .png, relative to the document; #### or %04d stands for the frame, \\# and \\% for the signs themselves, {output} for the name of the output." },
                    "layer": { "type": "string", "description": "Layer within the EXR; \"\" is the main layer. Outputs with the same file share it; by default each has a layer with its own name." },
                    "precision": { "enum": Precision::NAMES, "description": "half (default) or float (default of fields) in EXR, uint8 (default) or uint16 in PNG." },
                    "require": {
                        "type": "object",
                        "description": "Guarantee without which the file is not written: hull, the convex hull of the control colors, or box, each channel between its smallest and largest control.",
                        "additionalProperties": false,
                        "properties": { "guarantee": { "enum": ["hull", "box"] } }
                    },
                    "notes": true
                },
                "oneOf": [{ "required": ["color"] }, { "required": ["weights"] }, { "required": ["field"] }, { "required": ["recipe"] }]
            }
        }
    })
}

fn object(items: &[Item]) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    for item in items {
        let (schema, needed) = match item {
            Item::Port(port) => {
                let one = connection(port.accepts);
                let schema = match port.arity {
                    Arity::Many { min, max } => {
                        json!({ "type": "array", "items": one, "minItems": min, "maxItems": max })
                    }
                    Arity::One | Arity::Optional => one,
                };
                let needed = !matches!(port.arity, Arity::Optional | Arity::Many { min: 0, .. });
                (described(schema, port.help, ""), needed)
            }
            Item::Knob(knob) => (described(knob_schema(knob), knob.help, knob.unit), knob.default.is_none()),
            Item::List(list) => {
                let items = object(list.items);
                let schema = json!({ "type": "array", "items": items, "minItems": list.min, "maxItems": list.max });
                (described(schema, list.help, ""), list.min > 0)
            }
        };
        properties.insert(item.name().into(), schema);
        if needed {
            required.push(json!(item.name()));
        }
    }
    json!({ "type": "object", "required": required, "additionalProperties": false, "properties": properties })
}

fn described(mut schema: Value, help: &str, unit: &str) -> Value {
    let text = if unit.is_empty() { help.to_string() } else { format!("{help} Unit: {unit}.") };
    schema["description"] = json!(text);
    schema
}

/// Returns the schema of a knob of a group or of the document, whose value is under this key.
fn knob_of(value: &str) -> Value {
    let number = json!({ "type": "number" });
    let mut described = json!({
        "type": "object",
        "additionalProperties": false,
        "properties": { "min": number, "max": number, "unit": { "type": "string" }, "help": { "type": "string" }, "ui": true, "notes": true }
    });
    described["properties"][value] = json!(true);
    json!({ "anyOf": [{ "type": ["number", "string", "boolean", "array"] }, keyed(json!(true)), described] })
}

fn connection(accepts: Accepts) -> Value {
    let reference = json!({ "anyOf": [{ "$ref": "#/$defs/reference" }, { "$ref": "#/$defs/link" }] });
    match accepts {
        Accepts::Color => {
            let color = json!({ "$ref": "#/$defs/color" });
            json!({ "anyOf": [reference, color, keyed(color.clone())] })
        }
        Accepts::Mask => {
            let number = json!({ "type": "number", "minimum": 0, "maximum": 1 });
            json!({ "anyOf": [reference, number, keyed(number.clone())] })
        }
        Accepts::Scalar | Accepts::Field => {
            let number = json!({ "type": "number" });
            json!({ "anyOf": [reference, number, keyed(number.clone())] })
        }
        Accepts::Image => {
            let number = json!({ "type": "number", "minimum": 0, "maximum": 1 });
            json!({ "anyOf": [reference, { "$ref": "#/$defs/color" }, number] })
        }
        Accepts::Weights => {
            json!({ "anyOf": [reference, { "type": "array", "items": { "type": "number", "minimum": 0 } }] })
        }
        Accepts::Direction | Accepts::Surface | Accepts::Camera | Accepts::Light | Accepts::View => reference,
    }
}

fn keyed(value: Value) -> Value {
    let interpolation = json!({ "enum": crate::Interpolation::NAMES });
    let number = json!({ "type": "number" });
    let change = json!({ "anyOf": [number, { "type": "array", "items": number }] });
    let handle = |side: &str, limit: &str| {
        let frames = json!({ "type": "number", (limit): 0 });
        let help = format!("Handle {side} the key: frames and change of the value, as seen from the key.");
        json!({ "type": "array", "prefixItems": [frames, change], "minItems": 2, "maxItems": 2, "description": help })
    };
    let more = json!({
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "in": handle("before", "maximum"),
            "out": handle("after", "minimum"),
            "interpolation": interpolation
        }
    });
    json!({
        "type": "object",
        "required": ["keys"],
        "additionalProperties": false,
        "properties": {
            "keys": {
                "type": "array",
                "minItems": 1,
                "items": { "type": "array", "prefixItems": [number, value, more], "minItems": 2, "maxItems": 3 }
            },
            "interpolation": { "enum": crate::Interpolation::NAMES, "default": "linear" }
        }
    })
}

fn knob_schema(knob: &Knob) -> Value {
    let plain = match knob.takes {
        KnobType::Number { min, max } => range(json!({ "type": "number" }), min, max),
        KnobType::Integer { min, max } => json!({ "type": "integer", "minimum": min, "maximum": max }),
        KnobType::Bool => json!({ "type": "boolean" }),
        KnobType::Choice(words) => json!({ "enum": words }),
        KnobType::Color => json!({ "$ref": "#/$defs/color" }),
        KnobType::Vector(n) => json!({ "type": "array", "items": { "type": "number" }, "minItems": n, "maxItems": n }),
        KnobType::Text | KnobType::Path => json!({ "type": "string", "minLength": 1 }),
        KnobType::Numbers { min, max } => {
            json!({ "type": "array", "items": { "type": "number" }, "minItems": min, "maxItems": max })
        }
        KnobType::Texts { max } => {
            json!({ "type": "array", "items": { "type": "string" }, "minItems": 1, "maxItems": max })
        }
    };
    let link = json!({ "$ref": "#/$defs/link" });
    let mut schema = if knob.animated {
        let mut keyed = keyed(plain.clone());
        if knob.hold_keys {
            keyed["properties"]["interpolation"] = json!({ "const": "hold", "default": "hold" });
        }
        json!({ "anyOf": [plain, keyed, link] })
    } else {
        json!({ "anyOf": [plain, link] })
    };
    match knob.default {
        Some(KnobDefault::Number(number)) => schema["default"] = json!(number),
        Some(KnobDefault::Bool(value)) => schema["default"] = json!(value),
        Some(KnobDefault::Text(text)) => schema["default"] = json!(text),
        Some(KnobDefault::Vector(values)) => schema["default"] = json!(values),
        Some(KnobDefault::Unset) | None => {}
    }
    schema
}

fn range(mut schema: Value, min: f64, max: f64) -> Value {
    // Limits that only mean "finite in f32" would be noise.
    if min > -1e30 {
        schema["minimum"] = json!(min);
    }
    if max < 1e30 {
        schema["maximum"] = json!(max);
    }
    schema
}
