//! Places in pixels, rays and footprints: "Samples", "Rays" and "Footprints" of the definitions.

use super::document::{Document, number, three};
use super::vector::{Vector, cross, dot, length, minus, plus, times, unit};
use serde_json::Value as Json;

/// A pixel, and one of its samples or, as `None`, its center.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Place {
    pub(super) x: i64,
    pub(super) y: i64,
    pub(super) sample: Option<usize>,
}

impl Place {
    pub(super) fn moved(self, right: i64, down: i64) -> Self {
        Self { x: self.x + right, y: self.y + down, ..self }
    }

    /// Returns the first sample of the pixel; the center is its own.
    pub(super) fn first(self) -> Self {
        Self { sample: self.sample.map(|_| 0), ..self }
    }
}

/// Returns where a sample lies in its pixel.
pub(super) fn offset(samples: usize, sample: Option<usize>) -> [f64; 2] {
    let m = match samples {
        4 => 2,
        16 => 4,
        _ => return [0.5, 0.5],
    };
    let Some(s) = sample else { return [0.5, 0.5] };
    let (i, j, n) = (s % m, s / m, samples as f64);
    [((m * i + j) as f64 + 0.5) / n, ((m * j + m - 1 - i) as f64 + 0.5) / n]
}

/// Returns a place as a point of the picture.
pub(super) fn point(document: &Document, place: Place) -> [f64; 2] {
    let [x, y] = offset(document.samples, place.sample);
    [place.x as f64 + x, place.y as f64 + y]
}

pub(super) struct Ray {
    pub(super) from: Vector,
    /// A unit vector.
    pub(super) along: Vector,
}

impl Ray {
    pub(super) fn at(&self, distance: f64) -> Vector {
        plus(self.from, times(distance, self.along))
    }
}

pub(super) struct Camera {
    pub(super) position: Vector,
    pub(super) right: Vector,
    pub(super) up: Vector,
    pub(super) forward: Vector,
    pub(super) is_parallel: bool,
    /// Pixels for each tangent of 1, or for each meter.
    scale: f64,
    size: [f64; 2],
}

impl Camera {
    pub(super) fn new(node: &Json, document: &Document) -> Self {
        let position = three(node, "position", [0.0, 2.0, 10.0]);
        let forward = unit(minus(three(node, "target", [0.0; 3]), position));
        let right = unit(cross(forward, [0.0, 1.0, 0.0]));
        let up = cross(right, forward);
        let roll = number(node, "roll", 0.0).to_radians();
        let size = [document.width as f64, document.height as f64];
        let is_parallel = node["projection"] == "orthographic";
        let scale = if is_parallel {
            size[1] / number(node, "height", 10.0)
        } else {
            size[0] / 2.0 / (number(node, "fov", 50.0).to_radians() / 2.0).tan()
        };
        Self {
            position,
            right: minus(times(roll.cos(), right), times(roll.sin(), up)),
            up: plus(times(roll.cos(), up), times(roll.sin(), right)),
            forward,
            is_parallel,
            scale,
            size,
        }
    }

    pub(super) fn ray(&self, [x, y]: [f64; 2]) -> Ray {
        let across = times((x - self.size[0] / 2.0) / self.scale, self.right);
        let upward = times((self.size[1] / 2.0 - y) / self.scale, self.up);
        let beside = plus(across, upward);
        if self.is_parallel {
            Ray { from: plus(self.position, beside), along: self.forward }
        } else {
            Ray { from: self.position, along: unit(plus(self.forward, beside)) }
        }
    }

    pub(super) fn depth(&self, point: Vector) -> f64 {
        dot(minus(point, self.position), self.forward)
    }

    /// Returns the direction from a point to the eye.
    pub(super) fn eye(&self, point: Vector) -> Vector {
        if self.is_parallel { times(-1.0, self.forward) } else { unit(minus(self.position, point)) }
    }

    /// Returns the footprint of a pixel that sees a rest point.
    pub(super) fn footprint(&self, rest: Vector) -> f64 {
        let forward = self.forward;
        if self.is_parallel {
            return 1.0 / self.scale / forward[1].abs().max(0.02).sqrt();
        }
        let away = minus(rest, self.position);
        let level = length([forward[0], 0.0, forward[2]]);
        let ahead = (away[0] * forward[0] + away[2] * forward[2]) / level;
        let depth = dot(away, forward).max((ahead * ahead + away[1] * away[1]).sqrt() / 4.0);
        depth / self.scale / (away[1].abs() / depth).max(0.02).sqrt()
    }
}
