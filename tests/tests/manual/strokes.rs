//! Strokes: "Random numbers of strokes" and "Strokes" of the definitions.

use super::camera::{Place, offset};
use super::document::{list, number};
use super::evaluate::{Evaluator, count};
use super::mixes::sum;
use super::vector::{Vector, cross, minus};
use super::view::Seen;
use serde_json::Value as Json;
use std::f64::consts::TAU;

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

fn scrambled(z: u64) -> u64 {
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

fn key(key: u64, number: i64) -> u64 {
    let number = (number as u64).wrapping_mul(0xd6e8_feb8_6659_fd93);
    scrambled(key.wrapping_add(GOLDEN).wrapping_add(number))
}

fn random(key: u64, which: u64) -> f64 {
    let bits = scrambled(key.wrapping_add(which.wrapping_mul(GOLDEN)));
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

type Point = [f64; 2];

/// A triangle wave.
fn triangle(x: f64) -> f64 {
    2.0 * (x - (x + 0.5).floor()).abs()
}

/// A layer's knobs, with lengths in pixels of this picture.
struct Layer<'j> {
    node: &'j Json,
    key: u64,
    scale: f64,
    is_last: bool,
}

impl Layer<'_> {
    fn pixels(&self, key: &str, default: f64) -> f64 {
        number(self.node, key, default) * self.scale
    }

    fn knob(&self, key: &str, default: f64) -> f64 {
        number(self.node, key, default)
    }
}

struct Seed {
    key: u64,
    at: Point,
    share: f64,
    surface: f64,
}

struct Stroke {
    key: u64,
    at: Point,
    along: Point,
    half: [f64; 2],
    bend: f64,
    opacity: f64,
    bristle: f64,
    hairs: [f64; 2],
    /// Surface and depth that it keeps to.
    kept: Option<(f64, f64)>,
    source: [i64; 2],
}

/// All that is read from other pixels, at the first samples.
struct Surroundings<'a, 'd> {
    evaluator: &'a Evaluator<'d>,
    node: &'a Json,
    /// Sample for which strokes are found.
    sample: Option<usize>,
    /// Largest ratio of depths that are close.
    step: f64,
}

impl Surroundings<'_, '_> {
    fn place(&self, [x, y]: [i64; 2]) -> Place {
        Place { x, y, sample: self.sample }
    }

    fn contains(&self, [x, y]: [i64; 2]) -> bool {
        let document = self.evaluator.document;
        (0..document.width).contains(&x) && (0..document.height).contains(&y)
    }

    /// Returns the surface, depth and rest point at a pixel.
    fn seen(&self, pixel: [i64; 2]) -> (f64, f64, Option<Vector>) {
        self.seen_at(self.place(pixel))
    }

    fn seen_at(&self, place: Place) -> (f64, f64, Option<Vector>) {
        if self.node["view"].is_null() {
            return (-1.0, f64::INFINITY, None);
        }
        let seen: Seen = self.evaluator.seen(&self.node["view"], place);
        let is_on_surface = seen.is_something() && self.node["anchor"] != "screen";
        (seen.surface, seen.depth, is_on_surface.then_some(seen.rest))
    }

    fn input(&self, key: &str, pixel: [i64; 2], default: f64) -> f64 {
        let place = self.evaluator.document.nearest(self.place(pixel));
        self.evaluator.scalar_or(&self.node[key], place, default)
    }

    fn flow(&self, pixel: [i64; 2]) -> Point {
        let place = self.evaluator.document.nearest(self.place(pixel));
        let source = &self.node["flow"];
        let flow = if source.is_null() { vec![1.0, 0.0] } else { self.evaluator.value(source, place) };
        let length = flow[0].hypot(flow[1]);
        self.evaluator.threshold(length);
        if length > 0.0 { [flow[0] / length, flow[1] / length] } else { [1.0, 0.0] }
    }

    /// Whether depths are close; tells if that is uncertain.
    fn is_close(&self, a: f64, b: f64) -> bool {
        if a == b {
            return true;
        }
        let ratio = a.max(b) / a.min(b);
        self.evaluator.threshold(ratio - self.step);
        ratio <= self.step
    }

    /// Returns the pixel of a position; tells if that is uncertain.
    fn pixel(&self, at: Point) -> [i64; 2] {
        at.map(|x| {
            self.evaluator.threshold(x + 0.5 - (x + 0.5).round());
            (x + 0.5).floor() as i64
        })
    }

    /// Returns the seeds of a layer in the patch at a pixel.
    fn seeds(&self, layer: &Layer<'_>, pixel: [i64; 2], side: i64) -> Vec<Seed> {
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| [pixel[0] + i * side, pixel[1] + j * side]);
        if !corners.into_iter().all(|corner| self.contains(corner)) {
            return Vec::new();
        }
        let seen = corners.map(|corner| self.seen(corner));
        let surface = seen[0].0;
        let depths = seen.map(|(_, depth, _)| depth);
        let [near, far] = [f64::min, f64::max].map(|of| depths.into_iter().reduce(of).unwrap());
        if seen.iter().any(|(other, ..)| *other != surface) || !self.is_close(near, far) {
            return Vec::new();
        }
        let [right, down] = offset(self.evaluator.document.samples, self.sample);
        let rests = [0, 1, 2, 3].map(|corner| {
            let [x, y] = corners[corner];
            seen[corner].2.unwrap_or([x as f64 + right, 0.0, y as f64 + down])
        });
        let [a, b, c, d] = rests;
        let normal = cross(minus(d, a), minus(c, b)).map(f64::abs);
        let axis = match normal {
            [x, y, z] if y >= x && y >= z => 1,
            [x, _, z] if z > x => 2,
            _ => 0,
        };
        let kept = [[1, 2], [0, 2], [0, 1]][axis];
        let [a, b, c, d] = rests.map(|rest| kept.map(|axis| rest[axis]));
        let area = normal[axis] / (2 * side * side) as f64;
        let size = self.input("size", pixel, 1.0).clamp(1.0 / 16.0, 1.0);
        let spacing = (layer.pixels("spacing", 8.0).max(1.5) * size).max(1.5);
        let level = 0.5 * (area * spacing * spacing).log2();
        if !level.is_finite() {
            return Vec::new();
        }
        let bounds = [0, 1].map(|i| [a, b, c, d].map(|corner| corner[i]));
        let bounds = bounds.map(|all| [f64::min, f64::max].map(|of| all.into_iter().reduce(of).unwrap()));
        let tag = axis as i64 + if surface < 0.0 { 3 } else { 0 };
        let mut seeds = Vec::new();
        for up in 0..2 {
            let ell = level.floor() + f64::from(up);
            let cell = ell.exp2();
            let range = bounds.map(|[low, high]| [(low / cell).floor() as i64, (high / cell).floor() as i64]);
            if up == 0 && range.iter().any(|[first, last]| last - first > 15) {
                return Vec::new();
            }
            let share = if up == 0 { ell + 1.0 - level } else { level - (ell - 1.0) };
            for i in range[0][0]..=range[0][1] {
                for j in range[1][0]..=range[1][1] {
                    let key = key(key(key(layer.key, 8 * ell as i64 + tag), i), j);
                    let point = [(i as f64 + random(key, 0)) * cell, (j as f64 + random(key, 1)) * cell];
                    if let Some([s, t]) = self.within([a, b, c, d], point) {
                        let at = [pixel[0] as f64 + s * side as f64, pixel[1] as f64 + t * side as f64];
                        seeds.push(Seed { key, at, share, surface });
                    }
                }
            }
        }
        seeds
    }

    /// Returns where a point lies in a patch, in sides of the patch; tells if it lies on the patch's border.
    fn within(&self, [a, b, c, d]: [Point; 4], point: Point) -> Option<Point> {
        let shares = |from: Point, to: Point, other: Point| {
            let less = |p: Point| [p[0] - from[0], p[1] - from[1]];
            let (u, v, p) = (less(to), less(other), less(point));
            let area = u[0] * v[1] - u[1] * v[0];
            [(p[0] * v[1] - p[1] * v[0]) / area, (u[0] * p[1] - u[1] * p[0]) / area]
        };
        let is_inside = |[s, t]: Point| {
            let least = s.min(t).min(1.0 - s - t);
            self.evaluator.threshold(least);
            least >= 0.0
        };
        let upper = shares(a, b, c);
        if is_inside(upper) {
            return Some(upper);
        }
        let lower = shares(d, c, b);
        is_inside(lower).then(|| [1.0 - lower[0], 1.0 - lower[1]])
    }

    /// Returns the stroke of a seed, if it is there.
    fn stroke(&self, layer: &Layer<'_>, seed: &Seed) -> Option<Stroke> {
        let r = |which| random(seed.key, which);
        let pixel = self.pixel(seed.at);
        let size = self.input("size", pixel, 1.0).clamp(1.0 / 16.0, 1.0);
        let detail = if layer.is_last { 0.0 } else { self.input("detail", pixel, 0.0) };
        let kept = seed.share * self.input("density", pixel, 1.0) * layer.knob("density", 1.0) * (1.0 - detail);
        let there = ((1.25 * kept - r(2)) / 0.25).clamp(0.0, 1.0);
        if there <= 0.0 {
            return None;
        }
        let half = |key, default, which| {
            0.5 * layer.pixels(key, default) * (0.5 + 0.5 * r(which)) * size * (0.6 + 0.4 * there)
        };
        let (long, wide) = (half("length", 32.0, 3), half("width", 8.0, 4));
        let thin = (wide / 0.5).min(1.0);
        let wide = wide.max(0.5);
        let look = long.clamp(1.0, 8.0);
        let (surface, depth, _) = self.seen(pixel);
        if surface != seed.surface {
            return None;
        }
        let hides = |index: &u64| {
            let angle = TAU * *index as f64 / 16.0;
            let by = self.pixel([look * angle.cos(), look * angle.sin()]);
            let there = [pixel[0] + by[0], pixel[1] + by[1]];
            if !self.contains(there) {
                return true;
            }
            let other = self.seen(there).1;
            other < depth && !self.is_close(other, depth)
        };
        let hidden = (0..16).filter(hides).count();
        let open = (1.0 - hidden as f64 / 8.0).max(0.0);
        let opacity = layer.knob("opacity", 0.8) * there * thin * open;
        if opacity <= 0.0 {
            return None;
        }
        let flow = self.flow(pixel);
        let turned = |by: f64| {
            let there = self.flow(self.pixel([seed.at[0] + by * flow[0], seed.at[1] + by * flow[1]]));
            let product = flow[0] * there[1] - flow[1] * there[0];
            let cosine = flow[0] * there[0] + flow[1] * there[1];
            self.evaluator.threshold(cosine);
            if cosine < 0.0 { -product } else { product }
        };
        let turning = (0.5 * (turned(look) - turned(-look)) * long / look).clamp(-0.6, 0.6);
        let sign = if r(6) < 0.5 { -1.0 } else { 1.0 };
        let (sin, cos) = (layer.knob("turn", 12.0).to_radians() * (2.0 * r(5) - 1.0)).sin_cos();
        let along = [sign * (flow[0] * cos - flow[1] * sin), sign * (flow[0] * sin + flow[1] * cos)];
        let far = layer.pixels("stray", 0.5).min(8.0) * r(8);
        let mut source = self.pixel([seed.at[0] + far * (TAU * r(7)).cos(), seed.at[1] + far * (TAU * r(7)).sin()]);
        let keeps_to_edges = r(9) >= number(self.node, "lost", 0.3);
        if keeps_to_edges {
            let (other, there, _) = self.seen(source);
            if !self.contains(source) || other != surface || !self.is_close(there, depth) {
                source = pixel;
            }
        }
        Some(Stroke {
            key: seed.key,
            at: seed.at,
            along,
            half: [long, wide],
            bend: turning * long / (2.0 * wide) * sign,
            opacity,
            bristle: layer.knob("bristle", 0.7),
            hairs: [r(10), r(11)],
            kept: keeps_to_edges.then_some((surface, depth)),
            source,
        })
    }
}

impl Stroke {
    /// Returns the stroke's weight at an offset from its middle.
    fn weight(&self, [x, y]: Point, around: &Surroundings<'_, '_>, sight: (f64, f64, Option<Vector>)) -> f64 {
        let [cos, sin] = self.along;
        let a = (x * cos + y * sin) / self.half[0];
        let b = (y * cos - x * sin) / self.half[1] - self.bend * a * a;
        if a.abs() > 1.0 || b.abs() > 1.0 {
            return 0.0;
        }
        if let Some((surface, depth)) = self.kept
            && (surface != sight.0 || !around.is_close(sight.1, depth))
        {
            return 0.0;
        }
        let hair = 0.5 * (triangle(2.3 * b + self.hairs[0]) + triangle(3.9 * b + self.hairs[1]));
        let body = (2.2 * (1.0 - a * a) * (1.0 - b * b)).min(1.0);
        let dry = 1.0 - 0.55 * self.bristle * (1.0 - hair);
        self.opacity * body * dry * (1.0 - 0.8 * self.bristle * a.max(0.0) * hair)
    }
}

impl Evaluator<'_> {
    /// Returns the painted image.
    pub(super) fn painted(&self, node: &Json, place: Place) -> Vec<f64> {
        let document = self.document;
        let first = if document.shades_pixels { place.first() } else { place };
        let around =
            Surroundings { evaluator: self, node, sample: first.sample, step: 1.0 + number(node, "edge", 0.12) };
        let [own, found] = [place, first].map(|place| offset(document.samples, place.sample));
        let sample = [place.x as f64 + own[0] - found[0], place.y as f64 + own[1] - found[1]];
        let scale = node["height"].as_f64().map_or(1.0, |height| document.height as f64 / height);
        let layers = list(node, "layers");
        let base = key(0x7374_726f_6b65, node["seed"].as_i64().unwrap_or(0));
        let mut value = self.value(&node["image"], place);
        for (index, layer) in layers.iter().enumerate() {
            let is_last = index + 1 == layers.len();
            let layer = Layer { node: layer, key: key(base, index as i64), scale, is_last };
            let side = if layer.pixels("spacing", 8.0).max(1.5) < 5.0 { 1 } else { 2 };
            // Half the diagonal of the longest stroke, whose ends are bent by at most 0.3 of half its length.
            let [long, wide] =
                [("length", 32.0), ("width", 8.0)].map(|(key, default)| layer.pixels(key, default) / 2.0);
            let reach = long.hypot(0.3 * long + wide.max(0.5)).ceil() as i64 + side + 1;
            let mut strokes = Vec::new();
            for y in (place.y - reach..=place.y + reach).filter(|y| y.rem_euclid(side) == 0) {
                for x in (place.x - reach..=place.x + reach).filter(|x| x.rem_euclid(side) == 0) {
                    let seeds = around.seeds(&layer, [x, y], side);
                    strokes.extend(seeds.iter().filter_map(|seed| around.stroke(&layer, seed)));
                }
            }
            strokes.sort_by(|a, b| {
                let down = |axis: usize| b.at[axis].total_cmp(&a.at[axis]);
                a.key.cmp(&b.key).then(down(1)).then(down(0))
            });
            let sight = around.seen_at(place);
            for stroke in strokes {
                let w = stroke.weight([sample[0] - stroke.at[0], sample[1] - stroke.at[1]], &around, sight);
                if w > 0.0 {
                    count(&self.counts.strokes);
                    let color = self.value(&node["image"], document.nearest(around.place(stroke.source)));
                    value = sum([(1.0 - w, value), (w, color)]);
                }
            }
        }
        value
    }
}
