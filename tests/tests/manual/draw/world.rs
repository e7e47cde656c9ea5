//! What a view sees: seas, a sail, and their passes.

use super::Draw;
use rand::RngExt;
use serde_json::{Value as Json, json};

impl Draw<'_> {
    /// Adds waves of a sea: gentle, folded, random, or groups.
    fn sea(&mut self, level: f64) -> String {
        let mut sea = json!({ "type": "GerstnerSea", "count": 0, "level": level, "detail": self.number(1.0, 4.0) });
        match self.random.random_range(0..4) {
            0 | 1 => {
                let is_folded = self.chance(0.5);
                let count = self.random.random_range(1..=4);
                let waves = (0..count).map(|index| {
                    let length = self.number(2.0, 9.0);
                    let sharpest = if is_folded { 1.6 } else { 0.8 } / f64::from(count).sqrt();
                    let mut wave = json!({ "wavelength": length, "amplitude": length * self.number(0.02, 0.07),
                        "direction": self.number(-180.0, 180.0), "phase": self.number(0.0, 360.0),
                        "sharpness": sharpest * self.number(0.5, 1.0) });
                    if index == 1 {
                        wave["speed"] = self.number(0.0, 4.0).into();
                    }
                    wave
                });
                sea["waves"] = waves.collect::<Vec<Json>>().into();
            }
            2 => {
                sea["count"] = self.random.random_range(3..=12).into();
                sea["seed"] = self.random.random_range(0..1000).into();
                sea["wavelength"] = self.number(3.0, 8.0).into();
                sea["spread"] = self.number(0.1, 0.6).into();
                sea["height"] = self.number(0.2, 0.9).into();
                sea["direction"] = self.number(0.0, 360.0).into();
                sea["direction_spread"] = self.number(0.0, 60.0).into();
                sea["sharpness"] = self.number(0.2, 1.4).into();
                sea["dispersion"] = self.pick(&["deep", "speed", "period"]).into();
                sea["speed"] = self.number(1.0, 6.0).into();
                if self.chance(0.2) {
                    sea["convention"] = "thesis".into();
                }
            }
            _ => {
                let mut group = json!({ "wavelength": self.number(4.0, 9.0), "height": self.number(0.4, 1.0),
                    "direction": self.number(0.0, 360.0), "x": self.number(-3.0, 3.0), "z": self.number(-8.0, 0.0),
                    "time": self.number(0.0, 1.0), "sharpness": self.number(0.3, 1.2), "waves_along": 3,
                    "waves_across": self.random.random_range(1..=3), "seed": self.random.random_range(0..1000) });
                if self.chance(0.4) {
                    (group["speed"], group["along"]) = (self.number(1.0, 5.0).into(), self.number(3.0, 6.0).into());
                }
                sea["groups"] = json!([group]);
            }
        }
        self.node(sea)
    }

    /// Adds a toon sea, with its rift among the fields.
    fn toon(&mut self) -> String {
        let bursts: Vec<Json> = (0..self.random.random_range(1..=3))
            .map(|_| {
                let path: Vec<f64> = (0..8).map(|_| self.number(0.0, 10.0)).collect();
                json!({ "path": path, "duration": self.number(0.5, 4.0), "offset": self.number(0.0, 3.0),
                    "height": self.number(0.2, 0.9), "peak": self.number(0.5, 1.4), "along": self.number(1.0, 3.0),
                    "across": self.number(1.0, 3.0), "fade": self.number(0.0, 0.4) })
            })
            .collect();
        let c1 = self.number(0.1, 0.9);
        let mut sea = json!({ "type": "ToonSea", "mode": self.pick(&["literal", "resampled"]), "columns": 23, "rows": 21, "spacing": 0.45,
            "x": self.number(-6.0, -4.0), "z": self.number(-7.0, -4.0), "level": self.number(-0.2, 0.2), "c1": c1,
            "c2": ((0.99 - c1) * self.number(0.3, 1.0)), "boundary": self.pick(&["replicate", "periodic", "fixed"]),
            "preroll": self.random.random_range(0..40), "oriented": self.chance(0.7), "bursts": bursts,
            "rift": self.pick(&["sum", "nearest"]), "rift_distance": self.number(0.5, 2.0),
            "rift_gain": self.number(0.01, 0.2), "rift_decay": self.number(0.0, 0.1) });
        if self.chance(0.3) {
            (sea["bursts"][0]["start"], sea["bursts"][0]["end"]) = ((-0.1).into(), 0.1.into());
        }
        let rift = self.node(json!({ "type": "Rift", "view": "view" }));
        self.fields.push(rift);
        self.node(sea)
    }

    /// Adds camera, lights and surfaces as `camera`, `sun`, `lamp`, `view`.
    pub(super) fn world(&mut self, is_toon: bool) {
        let is_parallel = self.chance(0.2);
        let camera = json!({ "type": "Camera",
            "position": [self.number(-2.0, 2.0), self.number(2.8, 7.0), self.number(8.0, 14.0)],
            "target": [self.number(-2.0, 2.0), self.number(-1.0, 1.5), self.number(-8.0, 2.0)],
            "roll": if self.chance(0.5) { self.number(-30.0, 30.0) } else { 0.0 },
            "projection": if is_parallel { "orthographic" } else { "perspective" },
            "height": self.number(3.0, 7.0), "fov": self.number(20.0, 65.0) });
        self.nodes.insert("camera".into(), camera);
        let direction = [self.number(-1.0, 1.0), self.number(0.2, 1.0), self.number(-1.0, 1.0)];
        self.nodes.insert("sun".into(), json!({ "type": "Light", "direction": direction }));
        let lamp = json!({ "type": "Light", "kind": self.pick(&["point", "spot"]),
            "position": [self.number(-3.0, 3.0), self.number(4.0, 9.0), self.number(-6.0, 3.0)],
            "target": [self.number(-2.0, 2.0), 0, self.number(-3.0, 3.0)],
            "angle": self.number(20.0, 50.0), "soft": self.number(5.0, 20.0) });
        self.nodes.insert("lamp".into(), lamp);
        let mut surfaces = vec![if is_toon { self.toon() } else { self.sea(0.0) }];
        if !is_toon && self.chance(0.3) {
            surfaces.push(self.sea(-0.3));
        }
        if self.chance(0.5) {
            let at = [self.number(-2.0, 0.0), -1.0, self.number(-3.0, 3.0)];
            let (wide, tall) = (self.number(1.0, 2.5), self.number(2.0, 4.0));
            let (turn, lean) = (self.number(-0.5, 0.5), self.number(-0.5, 0.5));
            let [x, y, z] = at;
            let points = [
                [x, y, z],
                [x + wide, y, z + turn],
                [x + lean, y + tall, z - lean],
                [x + wide + lean, y + tall, z + turn - lean],
            ];
            let points = points.map(|at| json!({ "at": at }));
            surfaces.push(self.node(json!({ "type": "BezierModel", "patches": [{ "points": points }] })));
        }
        self.nodes.insert("view".into(), json!({ "type": "Render", "camera": "camera", "surfaces": surfaces }));
    }

    pub(super) fn passes(&mut self) {
        let view = "view";
        let lights = if self.chance(0.5) { json!(["sun"]) } else { json!(["sun", "lamp"]) };
        let combine = self.pick(&["screen", "max", "mean"]);
        let mut masks = vec![
            json!({ "type": "NonSpecular", "view": view, "lights": lights, "combine": combine,
                "power": self.number(0.5, 3.0) }),
            json!({ "type": "Specular", "view": view, "lights": lights, "combine": combine,
                "shininess": self.number(2.0, 80.0), "model": self.pick(&["half", "reflection"]) }),
            json!({ "type": "Fresnel", "view": view, "eta": self.number(1.1, 2.0) }),
            json!({ "type": "Fresnel", "view": view, "lights": lights, "combine": combine, "cosine": "half" }),
            json!({ "type": "CrestFoam", "view": view, "height": self.number(-0.2, 0.2), "rise": self.number(0.1, 0.6),
                "flatness": self.number(0.5, 0.95), "softness": self.number(0.05, 0.4) }),
            json!({ "type": "FoldFoam", "view": view, "threshold": self.number(0.5, 1.0),
                "width": self.number(0.2, 0.8) }),
            json!({ "type": "Sky", "view": view, "from": self.number(-30.0, 0.0), "to": self.number(20.0, 60.0) }),
            json!({ "type": "ObjectMask", "view": view, "indices": [1] }),
            json!({ "type": "Silhouette", "view": view, "cutoff": self.number(0.05, 0.4),
                "ramp": self.number(0.05, 0.4) }),
        ];
        // It looks at more pixels.
        if self.chance(0.3) {
            masks.push(json!({ "type": "Silhouette", "view": view, "width": self.number(0.5, 2.0) }));
        }
        for node in masks {
            let is_sky = node["type"] == "Sky";
            let name = self.node(node);
            if is_sky {
                self.passes.push(format!("{name}.reflected"));
            }
            self.passes.push(name);
        }
        self.passes.push("view.coverage".into());
        self.masks.extend(self.passes.clone());
        let depth = self.node(json!({ "type": "Depth", "view": view }));
        let near = self.number(4.0, 8.0);
        let far = near + self.number(4.0, 20.0);
        let clamp = self.node(json!({ "type": "Clamp", "field": depth, "min": near, "max": far }));
        self.masks.push(clamp);
        for kind in ["Height", "RestDistance", "Curvature"] {
            if self.chance(0.5) {
                let name = self.node(json!({ "type": kind, "view": view }));
                self.fields.push(name);
            }
        }
        for kind in ["Position", "Normal", "Rest"] {
            let name = self.node(json!({ "type": kind, "view": view }));
            self.vectors.push(name);
        }
        let (vector, axis) = (self.any(|draw| &draw.vectors), self.pick(&["x", "y", "z"]));
        let name = self.node(json!({ "type": "FieldMath", "a": vector, "expression": format!("a.{axis}") }));
        self.fields.push(name);
        let height = self.node(json!({ "type": "Height", "view": view }));
        self.fields.push(height);
    }
}
