//! Passes of a view.

use super::camera::{Place, point};
use super::document::{list, number};
use super::evaluate::Evaluator;
use super::vector::{Vector, cross, dot, length, minus, plus, times, unit};
use super::view::{Light, Seen, View, highlight, lit, schlick};
use serde_json::Value as Json;

impl Evaluator<'_> {
    /// Returns a pass; `None` for a node that is none.
    pub(super) fn pass(&self, index: usize, place: Place, output: &str) -> Option<Vec<f64>> {
        let node = self.document.node(index);
        let kind = node["type"].as_str().unwrap();
        const PASSES: [&str; 18] = [
            "Depth",
            "Position",
            "Normal",
            "Height",
            "Rest",
            "RestDistance",
            "Rift",
            "UV",
            "NonSpecular",
            "Specular",
            "Fresnel",
            "CrestFoam",
            "FoldFoam",
            "ObjectMask",
            "Sky",
            "Silhouette",
            "Curvature",
            "Render",
        ];
        if !PASSES.contains(&kind) {
            return None;
        }
        let view = if kind == "Render" { self.document.name(index).into() } else { node["view"].clone() };
        let seen = self.seen(&view, place);
        let view = || self.view(&node["view"]);
        let eye = || view().camera.eye(seen.position);
        let lights = || {
            let node_of = |source| self.document.node(self.document.wire(source).unwrap().0);
            list(node, "lights").iter().map(|source| Light::new(node_of(source))).collect::<Vec<_>>()
        };
        let knob = |key, default| number(node, key, default);
        let nothing = !seen.is_something();
        Some(match kind {
            "Depth" => vec![seen.depth],
            "Position" => seen.position.to_vec(),
            "Normal" => seen.normal.to_vec(),
            "Height" => vec![seen.height],
            "Rest" => seen.rest.to_vec(),
            "RestDistance" => vec![length(minus(seen.position, seen.rest))],
            "UV" => seen.uv.to_vec(),
            "Rift" => vec![seen.rift],
            "Sky" if output != "reflected" => {
                vec![elevated(node, view().camera.ray(point(self.document, place)).along)]
            }
            "Silhouette" if output == "edge" => vec![if nothing { 1.0 } else { edge(&view(), &seen) }],
            "Render" => vec![if nothing { 0.0 } else { 1.0 }],
            _ if nothing => vec![0.0],
            "Sky" => {
                let d = view().camera.ray(point(self.document, place)).along;
                vec![elevated(node, minus(d, times(2.0 * dot(d, seen.normal), seen.normal)))]
            }
            "NonSpecular" => {
                let power = knob("power", 1.0);
                let of = |light| ((dot(seen.normal, light) + 1.0) / 2.0).powf(power);
                vec![lit(node, &lights(), seen.position, of)]
            }
            "Specular" => {
                let eye = eye();
                vec![lit(node, &lights(), seen.position, |light| {
                    self.threshold(dot(seen.normal, light));
                    highlight(node, &seen, light, eye)
                })]
            }
            "Fresnel" if node["cosine"] == "half" => {
                let eye = eye();
                vec![lit(node, &lights(), seen.position, |light| schlick(node, dot(unit(plus(light, eye)), eye)))]
            }
            "Fresnel" => vec![schlick(node, dot(seen.normal, eye()))],
            "CrestFoam" => {
                let high = self.ramp(seen.height, knob("height", 0.5), knob("rise", 0.5));
                vec![high * self.ramp(seen.normal[1], knob("flatness", 0.9), knob("softness", 0.05))]
            }
            "FoldFoam" => {
                let (threshold, width) = (knob("threshold", 0.4), knob("width", 0.3));
                vec![((threshold - seen.jacobian) / width).clamp(0.0, 1.0)]
            }
            "ObjectMask" => {
                let chosen = list(node, "indices").iter().any(|index| index.as_f64() == Some(seen.surface));
                vec![f64::from(u8::from(chosen))]
            }
            "Silhouette" => vec![self.silhouette(node, &seen, place)],
            _ => vec![self.curvature(node, place)],
        })
    }

    /// Rises from 0 at `from` to 1 over a width; with width 0 a step.
    fn ramp(&self, x: f64, from: f64, width: f64) -> f64 {
        if width > 0.0 {
            return ((x - from) / width).clamp(0.0, 1.0);
        }
        self.threshold(x - from);
        if x >= from { 1.0 } else { 0.0 }
    }

    /// Returns half the difference of the neighbors at a distance along an axis, as far as they see the same surface.
    fn change<const N: usize>(
        &self,
        node: &Json,
        place: Place,
        by: [i64; 2],
        of: impl Fn(&Seen) -> [f64; N],
    ) -> Option<[f64; N]> {
        let here = self.seen(&node["view"], place);
        let beside = [-1, 1].map(|side| {
            let there = self.seen(&node["view"], place.moved(side * by[0], side * by[1]));
            (there.surface == here.surface).then(|| of(&there))
        });
        let (own, less) = (of(&here), |a: [f64; N], b: [f64; N]| std::array::from_fn(|i| a[i] - b[i]));
        match beside {
            [Some(before), Some(after)] => Some(less(after, before).map(|change: f64| change / 2.0)),
            [Some(before), None] => Some(less(own, before)),
            [None, Some(after)] => Some(less(after, own)),
            [None, None] => None,
        }
    }

    fn silhouette(&self, node: &Json, seen: &Seen, place: Place) -> f64 {
        let view = self.view(&node["view"]);
        let e = edge(&view, seen);
        let Some(width) = node["width"].as_f64() else {
            let (cutoff, ramp) = (number(node, "cutoff", 0.2), number(node, "ramp", 0.05));
            return ((cutoff + ramp - e) / ramp).clamp(0.0, 1.0);
        };
        let square = |seen: &Seen| [edge(&view, seen).powi(2)];
        let [across, down] =
            [[1, 0], [0, 1]].map(|by| self.change(node, place, by, square).map_or(0.0, |change| change[0]));
        let slope = across.hypot(down);
        // Only there is a jump.
        self.jump(e < 1e-6 && slope < 1e-6);
        if e == 0.0 {
            (width + 0.5).min(1.0)
        } else if slope > 0.0 {
            (width + 0.5 - e * e / slope).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    fn curvature(&self, node: &Json, place: Place) -> f64 {
        let reach = node["reach"].as_i64().unwrap_or(1);
        let both = |seen: &Seen| -> [f64; 6] {
            let ([a, b, c], [d, e, f]) = (seen.position, seen.normal);
            [a, b, c, d, e, f]
        };
        let changes = [[reach, 0], [0, reach]].map(|by| self.change(node, place, by, both));
        let [Some(across), Some(down)] = changes else { return 0.0 };
        let split = |all: [f64; 6]| ([all[0], all[1], all[2]], [all[3], all[4], all[5]]);
        let ((px, nx), (py, ny)): ((Vector, Vector), (Vector, Vector)) = (split(across), split(down));
        let (e, f, g) = (dot(px, px), dot(px, py), dot(py, py));
        let (se, sf, sg) = (dot(px, nx), dot(px, ny) + dot(py, nx), dot(py, ny));
        let area = dot(cross(px, py), cross(px, py));
        self.threshold((area / (e * g) - 1e-6) * 1e3);
        if area > 1e-6 * e * g { (se * g - sf * f + sg * e) / (2.0 * area) } else { 0.0 }
    }
}

/// N · V, at least 0.
fn edge(view: &View, seen: &Seen) -> f64 {
    dot(seen.normal, view.camera.eye(seen.position)).max(0.0)
}

fn elevated(node: &Json, direction: Vector) -> f64 {
    let elevation = direction[1].atan2(direction[0].hypot(direction[2])).to_degrees();
    let (from, to) = (number(node, "from", 0.0), number(node, "to", 90.0));
    ((elevation - from) / (to - from)).clamp(0.0, 1.0)
}
