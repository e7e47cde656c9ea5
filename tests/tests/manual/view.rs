//! What a camera sees at a place: "What is seen" of the definitions.

use super::camera::{Camera, Place, Ray, point};
use super::document::{Document, list, number, three};
use super::first_hit::first_hit;
use super::sea::Sea;
use super::toon::Toon;
use super::vector::{Vector, cross, dot, length, minus, plus, times, unit};
use serde_json::Value as Json;

/// What a sample sees; with the values that the manuals give for nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Index of the surface among those of the view; −1 for none.
    pub(super) surface: f64,
    pub(super) depth: f64,
    pub(super) position: Vector,
    pub(super) normal: Vector,
    pub(super) rest: Vector,
    pub(super) height: f64,
    pub(super) uv: [f64; 2],
    pub(super) slope_variance: f64,
    pub(super) jacobian: f64,
    pub(super) rift: f64,
    /// Whether the sample is so close to a contour that what it sees is open.
    pub(super) is_near_contour: bool,
}

impl Seen {
    const NOTHING: Self = Self {
        surface: -1.0,
        depth: f64::INFINITY,
        position: [0.0; 3],
        normal: [0.0, 1.0, 0.0],
        rest: [0.0; 3],
        height: 0.0,
        uv: [0.0; 2],
        slope_variance: 0.0,
        jacobian: 1.0,
        rift: 0.0,
        is_near_contour: false,
    };

    pub(super) fn is_something(&self) -> bool {
        self.surface >= 0.0
    }
}

/// A view: a camera and surfaces.
pub(super) struct View {
    pub(super) camera: Camera,
    pub(super) surfaces: Vec<Surface>,
}

pub(super) enum Surface {
    Sea(Sea),
    Toon(Toon),
    /// A flat patch: a corner, and the sides to two others.
    Sail([Vector; 3]),
}

/// What a ray meets of a surface first, and whether a contour is too near to tell.
struct Met {
    first: Option<(f64, Seen)>,
    is_near_contour: bool,
}

impl View {
    pub(super) fn new(node: &Json, document: &Document) -> Self {
        let wired = |source: &Json| document.node(document.wire(source).unwrap().0);
        Self {
            camera: Camera::new(wired(&node["camera"]), document),
            surfaces: list(node, "surfaces").iter().map(|source| Surface::new(wired(source), document)).collect(),
        }
    }

    pub(super) fn see(&self, document: &Document, place: Place) -> Seen {
        let ray = self.camera.ray(point(document, place));
        let mut nearest = (f64::INFINITY, Seen::NOTHING);
        let mut is_near_contour = false;
        for (index, surface) in self.surfaces.iter().enumerate() {
            let met = surface.meet(&self.camera, &ray);
            is_near_contour |= met.is_near_contour;
            let Some((distance, seen)) = met.first else { continue };
            // Two surfaces that cut each other.
            is_near_contour |= (distance - nearest.0).abs() < 1e-5;
            if distance < nearest.0 {
                nearest = (distance, Seen { surface: index as f64, ..seen });
            }
        }
        Seen { is_near_contour, ..nearest.1 }
    }
}

impl Surface {
    fn new(node: &Json, document: &Document) -> Self {
        match node["type"].as_str().unwrap() {
            "GerstnerSea" => Self::Sea(Sea::new(node, document.time)),
            "ToonSea" => Self::Toon(Toon::new(node, document.time)),
            _ => {
                let points = list(&list(node, "patches")[0], "points").iter().map(|point| three(point, "at", [0.0; 3]));
                let [a, b, c]: [Vector; 3] = points.take(3).collect::<Vec<_>>().try_into().unwrap();
                Self::Sail([a, minus(b, a), minus(c, a)])
            }
        }
    }

    fn meet(&self, camera: &Camera, ray: &Ray) -> Met {
        // Cameras are above the water: all normals point to where the ray comes from.
        let seen = |position: Vector, normal: Vector, level: f64| Seen {
            depth: camera.depth(position),
            position,
            normal: times(if dot(normal, ray.along) > 0.0 { -1.0 } else { 1.0 }, unit(normal)),
            height: position[1] - level,
            ..Seen::NOTHING
        };
        match self {
            Self::Sea(sea) => {
                let met = first_hit(sea, camera, ray);
                let first = met.hit.map(|(distance, rest, sum)| {
                    let normal = sum.normal();
                    let seen = Seen {
                        rest: [rest[0], sea.level, rest[1]],
                        uv: rest,
                        slope_variance: sum.slope_variance,
                        jacobian: normal[1],
                        ..seen(sum.point, normal, sea.level)
                    };
                    (distance, seen)
                });
                Met { first, is_near_contour: met.is_near_contour }
            }
            Self::Toon(sea) => {
                let (hit, is_near_contour) = sea.first(ray);
                let first = hit.map(|hit| {
                    let [x, y, z] = ray.at(hit.distance);
                    let (rest, uv) = ([x, sea.level, z], [x, z]);
                    (hit.distance, Seen { rest, uv, rift: hit.rift, ..seen([x, y, z], hit.normal, sea.level) })
                });
                Met { first, is_near_contour }
            }
            Self::Sail([corner, across, down]) => {
                let normal = cross(*across, *down);
                let distance = dot(minus(*corner, ray.from), normal) / dot(ray.along, normal);
                let position = ray.at(distance);
                // Shares of the two sides.
                let within = minus(position, *corner);
                let area = dot(normal, normal);
                let uv = [dot(cross(within, *down), normal) / area, dot(cross(*across, within), normal) / area];
                let is_met = distance > 0.0 && uv.iter().all(|share| (0.0..=1.0).contains(share));
                let is_near_contour = distance > 0.0 && uv.iter().any(|x| x.abs() < 1e-9 || (x - 1.0).abs() < 1e-9);
                let first = is_met.then(|| (distance, Seen { rest: position, uv, ..seen(position, normal, 0.0) }));
                Met { first, is_near_contour }
            }
        }
    }
}

/// A light, by its JSON.
pub(super) struct Light {
    kind: Kind,
    /// The direction of a directional light, the position of another one.
    at: Vector,
    target: Vector,
    angle: f64,
    soft: f64,
}

#[derive(PartialEq)]
enum Kind {
    Directional,
    Point,
    Spot,
}

impl Light {
    pub(super) fn new(node: &Json) -> Self {
        let three = |key, default| three(node, key, default);
        let (kind, at) = match node["kind"].as_str() {
            Some("point") => (Kind::Point, three("position", [0.0, 10.0, 0.0])),
            Some("spot") => (Kind::Spot, three("position", [0.0, 10.0, 0.0])),
            _ => (Kind::Directional, three("direction", [0.3, 1.0, 0.5])),
        };
        let degrees = |key, default| number(node, key, default).to_radians();
        Self { kind, at, target: three("target", [0.0; 3]), angle: degrees("angle", 30.0), soft: degrees("soft", 5.0) }
    }

    /// Returns the direction to the light from a point, and how much of it arrives.
    fn toward(&self, point: Vector) -> (Vector, f64) {
        if self.kind == Kind::Directional {
            return (unit(self.at), 1.0);
        }
        let direction = unit(minus(self.at, point));
        if self.kind == Kind::Point {
            return (direction, 1.0);
        }
        let axis = unit(minus(self.target, self.at));
        let away = times(-1.0, direction);
        let off = length(cross(axis, away)).atan2(dot(axis, away));
        let t = ((self.angle - off) / self.soft).clamp(0.0, 1.0);
        (direction, t * t * (3.0 - 2.0 * t))
    }
}

/// Returns the mask of several lights at a point, each by a function of its direction.
pub(super) fn lit(node: &Json, lights: &[Light], point: Vector, of: impl Fn(Vector) -> f64) -> f64 {
    let masks = lights.iter().map(|light| {
        let (direction, intensity) = light.toward(point);
        intensity * of(direction)
    });
    let masks: Vec<f64> = masks.collect();
    match node["combine"].as_str() {
        Some("max") => masks.into_iter().fold(0.0, f64::max),
        Some("mean") => masks.iter().sum::<f64>() / masks.len() as f64,
        _ => 1.0 - masks.iter().map(|mask| 1.0 - mask).product::<f64>(),
    }
}

/// (N · H)ˢ or (R · V)ˢ, with s widened by waves that were filtered out.
pub(super) fn highlight(node: &Json, seen: &Seen, light: Vector, eye: Vector) -> f64 {
    let (n, s) = (seen.normal, number(node, "shininess", 60.0));
    if dot(n, light) <= 0.0 {
        return 0.0;
    }
    let (cosine, widening) = if node["model"] == "reflection" {
        let mirrored = minus(times(2.0 * dot(n, light), n), light);
        (dot(mirrored, eye), 2.0)
    } else {
        (dot(n, unit(plus(light, eye))), 0.5)
    };
    cosine.max(0.0).powf(s / (1.0 + widening * s * seen.slope_variance))
}

/// F₀ + (1 − F₀)(1 − cos θ)⁵.
pub(super) fn schlick(node: &Json, cosine: f64) -> f64 {
    let eta = number(node, "eta", 1.333);
    let least = ((eta - 1.0) / (eta + 1.0)).powi(2);
    least + (1.0 - least) * (1.0 - cosine.clamp(0.0, 1.0)).powi(5)
}
