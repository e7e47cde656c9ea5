//! Blur and Warp, which read other pixels.

use super::camera::Place;
use super::document::number;
use super::evaluate::Evaluator;
use super::mixes::sum;
use serde_json::Value as Json;

impl Evaluator<'_> {
    /// Returns the value of a node whose samples never share; `None` for another node.
    pub(super) fn filtered(&self, node: &Json, place: Place) -> Option<Vec<f64>> {
        let at = |right: i64, down: i64| self.value(&node["image"], self.document.nearest(place.moved(right, down)));
        match node["type"].as_str().unwrap() {
            "Blur" => {
                let size = number(node, "size", 1.0);
                let is_box = node["filter"] == "box";
                let across = kernel(size, is_box);
                let down = kernel(number(node, "size_y", size), is_box);
                let weights = down.iter().flat_map(|(j, v)| across.iter().map(move |(k, w)| (*k, *j, v * w)));
                Some(sum(weights.map(|(k, j, weight)| (weight, at(k, j)))))
            }
            "Warp" => {
                let reach = number(node, "reach", 32.0);
                let [dx, dy] = ["dx", "dy"].map(|key| self.scalar_or(&node[key], place, 0.0).clamp(-reach, reach));
                let ([i, j], [u, v]) = ([dx, dy].map(|by| by.floor() as i64), [dx - dx.floor(), dy - dy.floor()]);
                let four = [(0, 0, (1.0 - u) * (1.0 - v)), (1, 0, u * (1.0 - v)), (0, 1, (1.0 - u) * v), (1, 1, u * v)];
                let four = four.into_iter().filter(|(.., weight)| *weight > 0.0);
                Some(sum(four.map(|(right, down, weight)| (weight, at(i + right, j + down)))))
            }
            "Shape" => Some(self.shape(node, place)),
            "Strokes" => Some(self.painted(node, place)),
            _ => None,
        }
    }
}

/// Returns the distances and weights of a kernel.
fn kernel(size: f64, is_box: bool) -> Vec<(i64, f64)> {
    let radius = if is_box { size.ceil() } else { (4.0 * size).ceil() } as i64;
    let weight = |k: i64| {
        let k = k as f64;
        if is_box {
            (size + 1.0 - k.abs()).min(1.0)
        } else if k == 0.0 {
            1.0
        } else {
            (-k * k / (2.0 * size * size)).exp()
        }
    };
    let total: f64 = (-radius..=radius).map(weight).sum();
    (-radius..=radius).map(|k| (k, weight(k) / total)).collect()
}
