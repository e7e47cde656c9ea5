//! Shape: ½ − d/edge, with d the least signed distance in pixels to discs and boxes.

use super::camera::{Place, point};
use super::document::{list, number};
use super::evaluate::Evaluator;
use serde_json::Value as Json;

impl Evaluator<'_> {
    pub(super) fn shape(&self, node: &Json, place: Place) -> Vec<f64> {
        let [x, y] = point(self.document, place);
        let height = self.document.height as f64;
        let distance = |shape: &Json| {
            let pair = |key: &str, default: [f64; 2]| match shape[key].as_array() {
                Some(pair) => [0, 1].map(|axis| pair[axis].as_f64().unwrap() * height),
                None => default.map(|side| side * height),
            };
            let center = pair("center", [0.0; 2]);
            let (sin, cos) = number(shape, "angle", 0.0).to_radians().sin_cos();
            let (x, y) = (x - center[0], y - center[1]);
            let (x, y) = (x * cos + y * sin, y * cos - x * sin);
            if shape["form"] == "box" {
                let size = pair("size", [0.2, 0.1]);
                let corner = (number(shape, "corner", 0.0) * height).min(size[0].min(size[1]) / 2.0);
                let beyond = [x.abs() - size[0] / 2.0 + corner, y.abs() - size[1] / 2.0 + corner];
                let outside = beyond[0].max(0.0).hypot(beyond[1].max(0.0));
                outside + beyond[0].max(beyond[1]).min(0.0) - corner
            } else {
                x.hypot(y) - number(shape, "radius", 0.1) * height
            }
        };
        let least = list(node, "shapes").iter().map(distance).fold(f64::INFINITY, f64::min);
        let edge = number(node, "edge", 1.0);
        if edge > 0.0 {
            return vec![(0.5 - least / edge).clamp(0.0, 1.0)];
        }
        self.threshold(least);
        vec![if least <= 0.0 { 1.0 } else { 0.0 }]
    }
}
