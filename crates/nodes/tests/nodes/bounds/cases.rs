//! Cases of the bound tests: nodes with inputs, and how tight their bounds have to be.

/// A node "out" to test.
pub(super) struct Case {
    /// Key of the document's output.
    pub(super) key: &'static str,
    pub(super) nodes: &'static str,
    /// Largest allowed median of bound divided by error on smooth inputs; `None` if no bound is clear.
    pub(super) tight: Option<f64>,
}

/// Nodes that all cases connect to.
pub(super) const SCENE: &str = r#""c": { "type": "Camera", "position": [0, 5, 10], "target": [0, 0, 0] },
    "s": { "type": "GerstnerSea", "count": 0 }, "s2": { "type": "GerstnerSea", "count": 0, "level": -1 },
    "v": { "type": "Render", "camera": "c", "surfaces": ["s", "s2"] },
    "w": { "type": "Render", "camera": "c", "surfaces": ["s2"] },
    "sun": { "type": "Light", "direction": [0.3, 0.6, 0.4] },
    "lamp": { "type": "Light", "kind": "point", "position": [1, 4, 2] },
    "spot": { "type": "Light", "kind": "spot", "position": [2, 6, 3], "target": [0, 0, 0], "angle": 40, "soft": 30 },
    "hard": { "type": "Light", "kind": "spot", "position": [2, 6, 3], "target": [0, 0, 0], "angle": 30, "soft": 0 },
    "field": { "type": "FieldMath", "expression": "0" }, "field2": { "type": "FieldMath", "expression": "1" },
    "mask": { "type": "ScreenX" }, "mask2": { "type": "ScreenY" },"#;

pub(super) const LIT: &[Case] = &[
    Case { key: "weights", nodes: r#""out": { "type": "ObjectMask", "view": "v", "indices": [1] }"#, tight: None },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "NonSpecular", "view": "v", "lights": ["sun"] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "NonSpecular", "view": "v", "power": 0.3, "lights": ["lamp", "spot", "hard"] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "NonSpecular", "view": "v", "power": 3.5, "lights": ["sun", "spot"], "combine": "mean" }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Specular", "view": "v", "lights": ["sun"] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Specular", "view": "v", "shininess": 5000, "lights": ["lamp", "spot"] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Specular", "view": "v", "model": "reflection", "lights": ["sun", "lamp"], "combine": "max" }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Specular", "view": "v", "shininess": 0, "lights": ["sun"] }"#,
        tight: None,
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Specular", "view": "v", "shininess": 1e6, "lights": ["sun", "spot"] }"#,
        tight: None,
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Specular", "view": "v", "shininess": 1e6, "model": "reflection", "lights": ["lamp"] }"#,
        tight: None,
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "NonSpecular", "view": "v", "power": 100, "lights": ["sun", "lamp", "spot"] }"#,
        tight: None,
    },
    Case { key: "weights", nodes: r#""out": { "type": "Fresnel", "view": "v" }"#, tight: Some(10.0) },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Fresnel", "view": "v", "lights": ["lamp", "sun"], "cosine": "half", "eta": 3 }"#,
        tight: Some(10.0),
    },
    Case { key: "weights", nodes: r#""out": { "type": "FoldFoam", "view": "v" }"#, tight: Some(10.0) },
    Case { key: "weights", nodes: r#""out": { "type": "FoldFoam", "view": "v", "width": 0 }"#, tight: None },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "CrestFoam", "view": "v", "height": -0.5, "rise": 1 }"#,
        tight: Some(10.0),
    },
    Case { key: "weights", nodes: r#""out": { "type": "CrestFoam", "view": "v", "softness": 0 }"#, tight: None },
];

pub(super) const PATTERNS: &[Case] = &[
    Case { key: "field", nodes: r#""out": { "type": "Noise", "scale": 0.4, "evolution": 0.3 }"#, tight: Some(10.0) },
    Case { key: "field", nodes: r#""out": { "type": "Noise", "view": "v", "space": "world" }"#, tight: Some(10.0) },
    Case {
        key: "field",
        nodes: r#""out": { "type": "Noise", "view": "v", "space": "world", "kind": "ridged", "evolution": 2.5 }"#,
        tight: Some(10.0),
    },
    Case {
        key: "field",
        nodes: r#""out": { "type": "Noise", "view": "v", "space": "rest", "kind": "cellular", "offset": [1e5, 0, -20] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "field",
        nodes: r#""out": { "type": "Noise", "view": "v", "space": "rest", "kind": "edges", "filter": false }"#,
        tight: Some(10.0),
    },
    Case { key: "weights", nodes: r#""out": { "type": "Grain", "threads": 4 }"#, tight: Some(10.0) },
    Case { key: "weights", nodes: r#""out": { "type": "Grain", "threads": 3, "kind": "paper" }"#, tight: Some(10.0) },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Shape", "edge": 3, "shapes": [
            { "center": [0.4, 0.5], "radius": 0.3 },
            { "form": "polygon", "center": [1.1, 0.5], "angle": 20, "points": [-0.5, -0.4, 0.5, 0.4, 0.5, -0.4, -0.5, 0.4] }
        ] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Scumble", "density": "mask", "noise": "field" }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Scumble", "density": "mask", "noise": "field", "dry": 0 }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Scumble", "density": "mask", "noise": "mask2", "from": 0.7, "to": 0.7 }"#,
        tight: None,
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "LightPool", "view": "v", "noise": "field", "light": "sun", "pools": [
            { "x": 1, "z": 2, "length": 3, "width": 2, "direction": 30 }, { "x": 4, "z": 1, "length": 2, "width": 2 }
        ] }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "LightPool", "view": "v", "noise": "field", "ragged": -1, "from": 0.3, "to": 0.3 }"#,
        tight: None,
    },
];

pub(super) const VIEWS: &[Case] = &[
    Case { key: "weights", nodes: r#""out": { "type": "DriftLines", "view": "v" }"#, tight: Some(10.0) },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "DriftLines", "view": "v", "coordinate": "along", "thickness": 1, "finest": 0.2, "shift": 7.3 }"#,
        tight: Some(10.0),
    },
    Case { key: "weights", nodes: r#""out": { "type": "Outline", "view": "v", "thickness": "mask" }"#, tight: None },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Outline", "view": "v", "width": 2.5, "owner": "last", "depth_step": 0.05 }"#,
        tight: None,
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "InFront", "view": "v", "other": "w", "soft": 1 }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "InFront", "view": "v", "other": "w", "soft": 0 }"#,
        tight: None,
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Silhouette", "view": "v", "cutoff": 0.2, "ramp": 0.8 }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Silhouette", "view": "v", "cutoff": 0.5, "ramp": 1e-12 }"#,
        tight: None,
    },
    Case { key: "weights", nodes: r#""out": { "type": "Silhouette", "view": "v", "width": 8 }"#, tight: None },
    Case { key: "field", nodes: r#""out": { "type": "Curvature", "view": "v", "reach": 2 }"#, tight: None },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Sky", "view": "v", "from": -90, "to": 90 }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Sky", "view": "v", "from": -30, "to": -29.999999999999 }"#,
        tight: None,
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "WaterlineFoam", "view": "v", "behind": "w", "edge": "field", "distance": 3 }"#,
        tight: None,
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "WaterlineFoam", "view": "v", "behind": "w", "measure": "height", "solid": 1 }"#,
        tight: None,
    },
    Case { key: "weights", nodes: r#""out": { "type": "Shadow", "view": "v", "lights": ["sun"] }"#, tight: None },
    Case { key: "field", nodes: r#""out": { "type": "Thickness", "view": "v", "ray": "eye" }"#, tight: None },
    Case { key: "weights", nodes: r#""out": { "type": "Translucency", "view": "v", "lights": ["sun"] }"#, tight: None },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Spray", "view": "v", "bursts": [
            { "position": [0, 1, 2], "count": 400, "time": -0.7, "duration": 2 }
        ], "soft": 6 }"#,
        tight: Some(10.0),
    },
];

pub(super) const IMAGES: &[Case] = &[
    Case { key: "weights", nodes: r#""out": { "type": "Blur", "image": "mask", "size": 1.5 }"#, tight: Some(10.0) },
    Case {
        key: "color",
        nodes: r#""dark": { "type": "Constant", "color": [0, 0, 0] },
            "color": { "type": "Mix", "a": "dark", "b": "dark", "weight": 0.5 },
            "out": { "type": "Blur", "image": "color", "size": 2, "size_y": 0, "filter": "box" }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Warp", "image": "mask", "dx": "field", "dy": "field2" }"#,
        tight: Some(10.0),
    },
    Case {
        key: "field",
        nodes: r#""image": { "type": "FieldMath", "expression": "2" },
            "out": { "type": "Warp", "image": "image", "dx": "field", "dy": "field2", "reach": 3 }"#,
        tight: Some(10.0),
    },
];

pub(super) const FILES: &[Case] = &[
    Case {
        key: "color",
        nodes: r#""out": { "type": "Texture", "file": "a.exr", "as": "color", "u": "field", "v": "field2" }"#,
        tight: Some(10.0),
    },
    Case {
        key: "color",
        nodes: r#""out": { "type": "Texture", "file": "a.exr", "as": "color", "u": "mask", "v": "field", "wrap": "mirror" }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r#""out": { "type": "Texture", "file": "a.exr", "as": "weights", "channels": ["R"], "u": "field",
            "v": "field2", "wrap": "clamp", "filter": "nearest" }"#,
        tight: None,
    },
    Case {
        key: "color",
        nodes: r#""out": { "type": "Read", "file": "a.exr", "as": "color", "fit": "bilinear" }"#,
        tight: Some(10.0),
    },
    Case {
        key: "weights",
        nodes: r##""out": { "type": "Decompose", "file": "a.exr", "colors": ["#000", "#08f", "#f80", "#fff", "#f00"],
            "fit": "bilinear" }"##,
        tight: Some(10.0),
    },
];
