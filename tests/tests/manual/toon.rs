//! Toon seas whose frames are whole steps: "Toon seas" of the definitions.

use super::camera::Ray;
use super::document::{list, number};
use super::vector::Vector;
use serde_json::Value as Json;
use std::f64::consts::PI;

/// A toon sea at a time: heights and rift, row by row.
pub(super) struct Toon {
    columns: i64,
    rows: i64,
    spacing: f64,
    from: [f64; 2],
    pub(super) level: f64,
    heights: Vec<f64>,
    rift: Vec<f64>,
}

/// The point where a ray meets the sea first.
pub(super) struct GridHit {
    pub(super) distance: f64,
    /// The upward normal, not normalized.
    pub(super) normal: Vector,
    pub(super) rift: f64,
}

impl Toon {
    pub(super) fn new(node: &Json, time: f64) -> Self {
        let knob = |key, default| number(node, key, default);
        let count = |key: &str| node[key].as_i64().unwrap_or(256);
        let (columns, rows) = (count("columns"), count("rows"));
        let cells = (columns * rows) as usize;
        let mut sea = Self {
            columns,
            rows,
            spacing: knob("spacing", 0.15),
            from: [knob("x", 0.0), knob("z", 0.0)],
            level: knob("level", 0.0),
            heights: vec![0.0; cells],
            rift: vec![0.0; cells],
        };
        let (c1, c2, preroll) = (knob("c1", 0.3), knob("c2", 0.65), knob("preroll", 120.0));
        let steps = (60.0 * time + preroll + 1e-6).floor() as i64;
        let mut before = sea.heights.clone();
        for step in 1..=steps {
            let now = (step as f64 - preroll) / 60.0;
            let bursts: Vec<Passing> =
                list(node, "bursts").iter().filter_map(|burst| Passing::at(burst, now)).collect();
            let next = (0..cells).map(|cell| {
                let raised: f64 = bursts.iter().map(|burst| burst.raises(sea.place(cell), node)).sum();
                let mean = sea.neighbors(cell, node["boundary"].as_str()) / 4.0;
                c1 * (2.0 * mean - before[cell]) + c2 * sea.heights[cell] + (1.0 - c1 - c2) * raised
            });
            let next: Vec<f64> = next.collect();
            before = std::mem::replace(&mut sea.heights, next);
            for cell in 0..cells {
                let [x, z] = sea.place(cell);
                let near = bursts.iter().map(|burst| {
                    (knob("rift_distance", 1.5) - (x - burst.center[0]).hypot(z - burst.center[1])).max(0.0)
                });
                let near = if node["rift"] == "nearest" { near.fold(0.0, f64::max) } else { near.sum() };
                sea.rift[cell] = (sea.rift[cell] + knob("rift_gain", 0.02) * near) / (1.0 + knob("rift_decay", 0.01));
            }
        }
        sea
    }

    /// Returns a cell's place relative to the first cell.
    fn place(&self, cell: usize) -> [f64; 2] {
        [cell as i64 % self.columns, cell as i64 / self.columns].map(|index| index as f64 * self.spacing)
    }

    /// Returns the sum of the heights of a cell's neighbors.
    fn neighbors(&self, cell: usize, boundary: Option<&str>) -> f64 {
        let (columns, rows) = (self.columns, self.rows);
        let (i, j) = (cell as i64 % columns, cell as i64 / columns);
        let at = |i: i64, j: i64| match boundary {
            Some("periodic") => self.heights[(j.rem_euclid(rows) * columns + i.rem_euclid(columns)) as usize],
            Some("fixed") if i < 0 || j < 0 || i >= columns || j >= rows => 0.0,
            _ => self.heights[(j.clamp(0, rows - 1) * columns + i.clamp(0, columns - 1)) as usize],
        };
        at(i - 1, j) + at(i + 1, j) + at(i, j - 1) + at(i, j + 1)
    }

    /// Returns a field between cells at a place in cells, and its slopes: Catmull and Rom's cubics in both directions.
    fn between(&self, field: &[f64], [u, v]: [f64; 2]) -> [f64; 3] {
        let (i, j) = ((u.floor() as i64).clamp(0, self.columns - 2), (v.floor() as i64).clamp(0, self.rows - 2));
        let at =
            |i: i64, j: i64| field[(j.clamp(0, self.rows - 1) * self.columns + i.clamp(0, self.columns - 1)) as usize];
        let rows = [-1, 0, 1, 2].map(|dj| cubic([-1, 0, 1, 2].map(|di| at(i + di, j + dj)), u - i as f64));
        let [value, along_v] = cubic(rows.map(|row| row[0]), v - j as f64);
        let [along_u, _] = cubic(rows.map(|row| row[1]), v - j as f64);
        [value, along_u / self.spacing, along_v / self.spacing]
    }

    /// Returns the first point on a ray, and whether it comes close to another one.
    pub(super) fn first(&self, ray: &Ray) -> (Option<GridHit>, bool) {
        let cells = |at: Vector| [(at[0] - self.from[0]) / self.spacing, (at[2] - self.from[1]) / self.spacing];
        let inside = |[u, v]: [f64; 2]| {
            (0.0..=(self.columns - 1) as f64).contains(&u) && (0.0..=(self.rows - 1) as f64).contains(&v)
        };
        let above = |distance: f64| {
            let at = ray.at(distance);
            inside(cells(at)).then(|| at[1] - self.level - self.between(&self.heights, cells(at))[0])
        };
        // The part of the ray over the grid.
        let (mut start, mut end) = (0.0_f64, f64::INFINITY);
        for (axis, along, count) in [(0, 0, self.columns), (1, 2, self.rows)] {
            let side = |cell: f64| (self.from[axis] + cell * self.spacing - ray.from[along]) / ray.along[along];
            let sides = [side(0.0), side((count - 1) as f64)];
            (start, end) = (start.max(sides[0].min(sides[1])), end.min(sides[0].max(sides[1])));
        }
        if start >= end {
            return (None, false);
        }
        let steps = ((end - start) / (self.spacing / 50.0)).ceil();
        let at = |step: f64| start + (end - start) * (step + 1e-9) / (steps + 2e-9);
        let mut is_close = false;
        let mut last: [Option<f64>; 2] = [None, above(at(0.0))];
        for step in 1..=steps as i64 {
            let next = above(at(step as f64));
            if let ([before, Some(here)], Some(next)) = (last, next) {
                if (here < 0.0) != (next < 0.0) {
                    let distance = bisected([at((step - 1) as f64), at(step as f64)], above);
                    let place = cells(ray.at(distance));
                    let [_, dx, dz] = self.between(&self.heights, place);
                    let rift = self.between(&self.rift, place)[0];
                    return (Some(GridHit { distance, normal: [-dx, 1.0, -dz], rift }), is_close);
                }
                // A minimum close to 0 may hide two roots.
                is_close |= here.abs() < 1e-3 * self.spacing
                    && before.is_some_and(|before| before.abs() >= here.abs() && next.abs() >= here.abs());
            }
            last = [last[1], next];
        }
        (None, is_close)
    }
}

/// Returns where a function changes its sign.
fn bisected([mut low, mut high]: [f64; 2], of: impl Fn(f64) -> Option<f64>) -> f64 {
    let is_below = |x: f64| of(x).is_some_and(|value| value < 0.0);
    let starts_below = is_below(low);
    for _ in 0..80 {
        let middle = low.midpoint(high);
        if is_below(middle) == starts_below { low = middle } else { high = middle }
    }
    low.midpoint(high)
}

/// Returns the cubic through the inner two of four values, whose slopes there are half the differences of their
/// neighbors, and its slope.
fn cubic([a, b, c, d]: [f64; 4], t: f64) -> [f64; 2] {
    let (from, to) = ((c - a) / 2.0, (d - b) / 2.0);
    let (square, cube) = (2.0 * (b - c) + from + to, 3.0 * (c - b) - 2.0 * from - to);
    [((square * t + cube) * t + from) * t + b, (3.0 * square * t + 2.0 * cube) * t + from]
}

/// A burst at a time.
struct Passing {
    center: [f64; 2],
    heading: [f64; 2],
    /// Radii along and across the heading.
    radii: [f64; 2],
    peak: f64,
    height: f64,
}

impl Passing {
    /// Returns a burst at a time, if it acts then.
    fn at(burst: &Json, time: f64) -> Option<Self> {
        let knob = |key, default| number(burst, key, default);
        if time < knob("start", f64::NEG_INFINITY) || time >= knob("end", f64::INFINITY) {
            return None;
        }
        let progress = ((time + knob("offset", 0.0)) / knob("duration", 10.0)).rem_euclid(1.0);
        let (t, s, fade) = (progress, 1.0 - progress, knob("fade", 0.0));
        let left = if fade > 0.0 { (t.min(s) / fade).min(1.0) } else { 1.0 };
        let path = |index: usize| burst["path"][index].as_f64().unwrap();
        let sum = |weights: [f64; 4]| {
            [0, 1].map(|axis| (0..4).map(|point| weights[point] * path(2 * point + axis)).sum::<f64>())
        };
        let center = sum([s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]);
        let slope = sum([-s * s, s * s - 2.0 * s * t, 2.0 * s * t - t * t, t * t]);
        Some(Self {
            center,
            heading: slope.map(|part| part / slope[0].hypot(slope[1])),
            radii: [knob("along", 2.0), knob("across", 2.0)],
            peak: knob("peak", 1.0),
            height: left * knob("height", 1.0),
        })
    }

    fn raises(&self, [x, z]: [f64; 2], node: &Json) -> f64 {
        let (dx, dz) = (x - self.center[0], z - self.center[1]);
        let [cos, sin] = if node["oriented"] == false { [1.0, 0.0] } else { self.heading };
        let distance = ((dx * cos + dz * sin) / self.radii[0]).hypot((dz * cos - dx * sin) / self.radii[1]);
        self.peak * self.height / 2.0 * ((PI * distance / self.peak).min(PI).cos() + 1.0)
    }
}
