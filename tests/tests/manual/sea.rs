//! Gerstner seas: their waves and their sum.

use super::camera::Camera;
use super::document::{list, number};
use super::vector::{Vector, cross, plus, times};
use rand::Rng;
use rand_pcg::Pcg64;
use serde_json::Value as Json;
use std::f64::consts::TAU;

const GRAVITY: f64 = 9.81;

pub(super) struct Wave {
    /// Wave number in rad/m.
    pub(super) k: f64,
    direction: [f64; 2],
    /// Amplitudes, vertical and horizontal.
    pub(super) a: f64,
    pub(super) h: f64,
    frequency: f64,
    phase: f64,
}

pub(super) struct Sea {
    pub(super) waves: Vec<Wave>,
    pub(super) level: f64,
    detail: f64,
    time: f64,
}

/// The sea at a rest point.
pub(super) struct Sum {
    pub(super) point: Vector,
    /// Changes of the point by x and z of the rest point.
    pub(super) along_x: Vector,
    pub(super) along_z: Vector,
    /// Change of the point by the footprint.
    pub(super) by_footprint: Vector,
    pub(super) slope_variance: f64,
}

impl Sum {
    /// Returns the normal, not normalized; its y is the Jacobian.
    pub(super) fn normal(&self) -> Vector {
        cross(self.along_z, self.along_x)
    }
}

/// A number in (0, 1) of a generator.
fn unit(random: &mut Pcg64) -> f64 {
    ((random.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

fn toward(degrees: f64) -> [f64; 2] {
    [degrees.to_radians().cos(), degrees.to_radians().sin()]
}

impl Sea {
    pub(super) fn new(node: &Json, time: f64) -> Self {
        let mut waves = random_waves(node);
        for wave in list(node, "waves") {
            let k = TAU / wave["wavelength"].as_f64().unwrap();
            waves.push(Wave {
                k,
                direction: toward(number(wave, "direction", 0.0)),
                a: wave["amplitude"].as_f64().unwrap(),
                h: number(wave, "sharpness", 0.0) / k,
                frequency: wave["speed"].as_f64().map_or((GRAVITY * k).sqrt(), |speed| k * speed),
                phase: number(wave, "phase", 0.0).to_radians(),
            });
        }
        list(node, "groups").iter().for_each(|group| waves.extend(group_waves(group)));
        Self { waves, level: number(node, "level", 0.0), detail: number(node, "detail", 1.0), time }
    }

    pub(super) fn footprint(&self, camera: &Camera, [x, z]: [f64; 2]) -> f64 {
        camera.footprint([x, self.level, z]) / self.detail
    }

    /// Returns the sea at a rest point, under the footprint of a pixel there.
    pub(super) fn at(&self, [x, z]: [f64; 2], footprint: f64) -> Sum {
        let mut sum = Sum {
            point: [x, self.level, z],
            along_x: [1.0, 0.0, 0.0],
            along_z: [0.0, 0.0, 1.0],
            by_footprint: [0.0; 3],
            slope_variance: 0.0,
        };
        for wave in &self.waves {
            let Wave { k, direction: [dx, dz], a, h, .. } = *wave;
            let left = (-(k * footprint) * (k * footprint) / 8.0).exp();
            let (sin, cos) = (k * (dx * x + dz * z) - wave.frequency * self.time + wave.phase).sin_cos();
            let moved = [-h * dx * sin, a * cos, -h * dz * sin];
            let change = [-h * dx * cos, -a * sin, -h * dz * cos];
            sum.point = plus(sum.point, times(left, moved));
            sum.by_footprint = plus(sum.by_footprint, times(-k * k * footprint / 4.0 * left, moved));
            sum.along_x = plus(sum.along_x, times(left * k * dx, change));
            sum.along_z = plus(sum.along_z, times(left * k * dz, change));
            sum.slope_variance += 0.5 * (a * k) * (a * k) * (1.0 - left * left);
        }
        sum
    }
}

fn random_waves(node: &Json) -> Vec<Wave> {
    let count = node["count"].as_u64().unwrap_or(1000);
    let knob = |key, default| number(node, key, default);
    let (mean, spread, height) = (knob("wavelength", 20.0), knob("spread", 0.5), knob("height", 1.0));
    let (direction, directions) = (knob("direction", 0.0), knob("direction_spread", 30.0));
    let (sharpness, seed) = (knob("sharpness", 0.5), node["seed"].as_u64().unwrap_or(0));
    let drawn: Vec<[f64; 3]> = (0..count)
        .map(|index| {
            let state = (u128::from(seed) << 64) + u128::from(index.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let mut random = Pcg64::new(state, index.into());
            let (radius, angle) = ((-2.0 * unit(&mut random).ln()).sqrt(), TAU * unit(&mut random));
            let length = (mean.ln() + spread * (radius * angle.cos() - spread / 2.0)).exp();
            [length, direction + directions * radius * angle.sin(), TAU * unit(&mut random)]
        })
        .collect();
    let (n, is_thesis) = (count as f64, node["convention"] == "thesis");
    let scale = if is_thesis {
        sharpness * (height / 2.0) / mean / n
    } else {
        height / 4.0 * (2.0 / drawn.iter().map(|wave| wave[0] * wave[0]).sum::<f64>()).sqrt()
    };
    let compression = sharpness * (2.0 / n).sqrt() / (2.0 * n).sqrt().min(2.5);
    let wave = |[length, direction, phase]: [f64; 3]| {
        let (k, a) = (TAU / length, scale * length);
        let frequency = match node["dispersion"].as_str() {
            Some("speed") => k * knob("speed", 5.0),
            Some("period") => TAU / knob("period", 4.0),
            _ => (GRAVITY * k).sqrt(),
        };
        let h = if is_thesis { -a } else { compression / k };
        Wave { k, direction: toward(direction), a, h, frequency, phase }
    };
    drawn.into_iter().map(wave).collect()
}

fn group_waves(node: &Json) -> Vec<Wave> {
    let knob = |key, default| number(node, key, default);
    let length = node["wavelength"].as_f64().unwrap();
    let (along, across) = (knob("along", length / 2.0), knob("across", length / 2.0));
    let count = |key: &str| node[key].as_u64().unwrap_or(5);
    let (d, e) = (toward(knob("direction", 0.0)), toward(knob("direction", 0.0) + 90.0));
    let seed = node["seed"].as_u64().unwrap_or(0);
    let mut random = Pcg64::new(seed.into(), 0);
    let mut value = |index: u64, of: u64| {
        let drawn = unit(&mut random);
        if of == 1 { 0.0 } else { 1.8 * (2.0 * index as f64 / (of - 1) as f64 - 1.0) + 0.12 * (2.0 * drawn - 1.0) }
    };
    let mut packet = Vec::new();
    for p in 0..count("waves_along") {
        for q in 0..count("waves_across") {
            let (p, q) = (value(p, count("waves_along")), value(q, count("waves_across")));
            let (forward, sideward) = (TAU / length + p / along, q / across);
            let vector = [d[0] * forward + e[0] * sideward, d[1] * forward + e[1] * sideward];
            packet.push((vector, forward, (-(p * p + q * q) / 2.0).exp()));
        }
    }
    let total: f64 = packet.iter().map(|wave| wave.2).sum();
    let size = |[x, z]: [f64; 2]| x.hypot(z);
    let squeeze: f64 = packet.iter().map(|(k, forward, w)| w / total * forward * forward / size(*k)).sum();
    let wave = |(vector, forward, w): ([f64; 2], f64, f64)| {
        let k = size(vector);
        let frequency = node["speed"].as_f64().map_or((GRAVITY * k).sqrt(), |speed| speed * forward);
        Wave {
            k,
            direction: vector.map(|part| part / k),
            a: node["height"].as_f64().unwrap() * w / total,
            h: knob("sharpness", 0.5) * w / total / squeeze,
            frequency,
            phase: frequency * knob("time", 0.0) - vector[0] * knob("x", 0.0) - vector[1] * knob("z", 0.0),
        }
    };
    packet.into_iter().map(wave).collect()
}
