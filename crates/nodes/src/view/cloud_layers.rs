//! Cloud layers: their intersection with rays, and their density.

use crate::view::ramp;
use trochoid_field::{Noise, Octave};
use trochoid_scene::{DVec3, Ray};

/// Maximum number of parts of a slanting ray, relative to a vertical one.
pub(crate) const MORE_STEPS: f64 = 6.0;
/// Sinking of a layer below a level plane, in meters per squared meter of distance: that of the Earth.
pub(crate) const BEND: f64 = 0.5 / 6_371_000.0;
/// Standard deviation of one octave of gradient noise in space.
const DEVIATION: f64 = 0.25;

/// One layer at the frame's time.
pub(crate) struct Layer {
    pub(crate) base: f64,
    pub(crate) thickness: f64,
    /// Noise value above which the middle of the layer holds clouds.
    pub(crate) sparse: f64,
    pub(crate) softness: f64,
    pub(crate) rounding: f64,
    pub(crate) opacity: f64,
    pub(crate) noise: Noise,
    /// Direction of the wind, x and z.
    pub(crate) wind: [f64; 2],
    pub(crate) stretch: f64,
    /// Distance that the wind has moved the clouds, in meters.
    pub(crate) moved: f64,
}

impl Layer {
    /// Returns the first segment of a ray within the layer, no farther than `limit`, for a layer that sinks by
    /// `bend`·distance².
    ///
    /// Above the layer's plane, the ray's height is y + d·t + b·t², with b the bend times the squared horizontal part:
    /// a parabola that never sinks if d ≥ 0. A ray that sinks from below a layer meets the ground before the layer.
    pub(crate) fn span(&self, ray: &Ray, bend: f64, limit: f64) -> Option<[f64; 2]> {
        let d = ray.direction;
        let b = bend * (d.x * d.x + d.z * d.z);
        let (over, under) = (ray.origin.y - self.base, ray.origin.y - self.base - self.thickness);
        // Distances at which a height that starts at c reaches 0: going up, and the first and last time going down.
        let root = |c: f64| libm::sqrt(d.y * d.y - 4.0 * b * c);
        let up = |c: f64| if c >= 0.0 { 0.0 } else { -2.0 * c / (d.y + root(c)) };
        let down = |c: f64| if c <= 0.0 { 0.0 } else { 2.0 * c / (root(c) - d.y) };
        let (near, far) = if d.y >= 0.0 {
            (up(over), if under < 0.0 { up(under) } else { 0.0 })
        } else if over < 0.0 {
            return None;
        } else {
            let out = down(over);
            // A ray that does not reach the base leaves through the top.
            (down(under), if out.is_nan() { (root(under) - d.y) / (2.0 * b) } else { out })
        };
        // For a ray that stays in the layer, or passes above it, this is a division by 0, or NaN.
        let far = if far.is_nan() { return None } else { far.min(limit) };
        (far > near).then_some([near, far])
    }

    /// Returns the position of a point in the noise, given its height above the bent plane.
    pub(crate) fn place(&self, point: DVec3, height: f64) -> [f64; 3] {
        let [x, z] = self.wind;
        [(point.x * x + point.z * z - self.moved) / self.stretch, height, point.z * x - point.x * z]
    }

    /// Cuts a ray's segment within the layer into parts.
    pub(crate) fn cut(&self, [near, far]: [f64; 2], steps: usize) -> Cut {
        let count = steps as f64 * ((far - near) / self.thickness).clamp(1.0, MORE_STEPS);
        Cut { near, part: (far - near) / count, count }
    }

    /// Returns the largest deviation of the noise from what remains of it at a footprint, as if evenly distributed: √3
    /// times the standard deviation of the detail lost.
    pub(crate) fn spread(&self, footprint: f64) -> f64 {
        let lost = |octave: &Octave| {
            let t = (2.0 - 2.0 * footprint * octave.frequency).clamp(0.0, 1.0);
            let kept = t * t * (3.0 - 2.0 * t);
            octave.weight * octave.weight * (1.0 - kept * kept)
        };
        DEVIATION * libm::sqrt(3.0 * self.noise.octaves.iter().map(lost).sum::<f64>())
    }

    /// Returns the mean density where the noise at a height lies within `spread` of `noise`. Without the spread,
    /// unresolved distant clouds would vanish or fill the sky.
    pub(crate) fn density(&self, noise: f64, height: f64, spread: f64) -> f64 {
        let below = (height - self.base) / self.thickness;
        if !(0.0..=1.0).contains(&below) {
            return 0.0;
        }
        let from_middle = 2.0 * below - 1.0;
        let from = self.sparse + self.rounding * from_middle * from_middle;
        if spread < 1e-6 {
            return ramp(noise, from, self.softness);
        }
        // The ramp's integral up to x.
        let integral = |x: f64| match x {
            x if x <= 0.0 => 0.0,
            x if x < self.softness => 0.5 * x * x / self.softness,
            x => x - 0.5 * self.softness,
        };
        let over = noise - from;
        ((integral(over + spread) - integral(over - spread)) / (2.0 * spread)).clamp(0.0, 1.0)
    }
}

/// A segment of a ray, cut into parts. Their number need not be whole, so that it varies continuously from ray to ray;
/// the last part is shorter.
#[derive(Clone, Copy)]
pub(crate) struct Cut {
    near: f64,
    pub(crate) part: f64,
    count: f64,
}

impl Cut {
    /// Returns the middle and the length of a part; `None` past the last one.
    pub(crate) fn at(self, step: usize) -> Option<(f64, f64)> {
        let step = step as f64;
        let share = (self.count - step).min(1.0);
        (share > 0.0).then_some((self.near + (step + 0.5 * share) * self.part, share * self.part))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid_field::{NoiseKind, NoiseParameters};

    /// Returns a layer without noise.
    fn layer(base: f64, thickness: f64) -> Layer {
        let parameters = NoiseParameters { scale: 1e3, octaves: 1, lacunarity: 2.0, gain: 0.5, seed: 1 };
        Layer {
            base,
            thickness,
            sparse: 0.0,
            softness: 0.3,
            rounding: 0.5,
            opacity: 6.0,
            noise: Noise::new(NoiseKind::Fbm, parameters, None),
            wind: [1.0, 0.0],
            stretch: 1.0,
            moved: 0.0,
        }
    }

    #[test]
    fn layers_come_down_to_the_horizon() {
        let layer = layer(900.0, 400.0);
        let ray = |from: f64, up: f64| Ray {
            origin: DVec3::new(0.0, from, 0.0),
            direction: DVec3::new(0.0, up, -1.0).normalize(),
        };
        let span = |from: f64, up: f64| layer.span(&ray(from, up), BEND, 1e7);
        // Straight up the ray meets the layer as over a plane; at the horizon, the Earth hides anything higher.
        let up = Ray { origin: DVec3::ZERO, direction: DVec3::Y };
        assert_eq!(layer.span(&up, BEND, 1e7), Some([900.0, 1300.0]));
        let [near, far] = span(0.0, 0.0).unwrap();
        assert!((near - (900.0 / BEND).sqrt()).abs() < 1e-6 && (far - (1300.0 / BEND).sqrt()).abs() < 1e-6);
        // The segment changes continuously down to the horizon; below it, there is none.
        let mut before = near;
        for step in 0..2000 {
            let [near, far] = span(0.0, f64::from(step) * 1e-5).unwrap();
            assert!(near <= before && before - near < 2e3 && far > near, "{step}: {near} after {before}");
            before = near;
        }
        assert_eq!(span(0.0, -1e-9), None);
        // From within and above: down to the base, or out through the top if the ray does not reach the base.
        let [near, far] = span(1000.0, -0.1).unwrap();
        assert!(near == 0.0 && (far - 100.0 / 0.0995).abs() < 10.0, "{far}");
        let [near, far] = span(1000.0, -1e-4).unwrap();
        assert!(near == 0.0 && far > (300.0 / BEND).sqrt(), "{far}");
        assert!(span(5000.0, -0.2).is_some_and(|[near, far]| near > 18_000.0 && far > near));
        assert_eq!(span(5000.0, -1e-4), None, "it passes over the layer");
        assert_eq!(span(5000.0, 0.1), None);
        // Without a bend, layers are planes.
        assert_eq!(layer.span(&ray(1000.0, 0.0), 0.0, 500.0), Some([0.0, 500.0]));
        assert_eq!(layer.span(&ray(0.0, 0.0), 0.0, 500.0), None);
        assert_eq!(layer.span(&ray(0.0, -0.5), 0.0, 500.0), None);
    }

    #[test]
    fn parts_grow_in_number_and_make_up_the_way() {
        let layer = layer(900.0, 400.0);
        for (length, steps, most) in [(400.0, 6, 6), (100.0, 6, 6), (500.0, 6, 8), (1e6, 6, 36), (1e6, 1, 6)] {
            let cut = layer.cut([50.0, 50.0 + length], steps);
            let parts: Vec<(f64, f64)> = (0..).map_while(|step| cut.at(step)).collect();
            assert!(parts.len() <= most + 1 && parts.len() >= most, "{length}: {}", parts.len());
            let sum: f64 = parts.iter().map(|(_, length)| length).sum();
            assert!((sum - length).abs() < 1e-9 * length, "{sum} of {length}");
            assert!(parts.windows(2).all(|pair| pair[0].0 < pair[1].0));
        }
    }

    #[test]
    fn what_cannot_be_told_apart_has_its_mean_density() {
        let mut layer = layer(0.0, 1.0);
        layer.rounding = 0.0;
        for softness in [0.0, 0.3, 2.0] {
            layer.softness = softness;
            for (noise, spread) in [(0.0, 0.4), (0.1, 0.05), (-0.2, 0.1), (-0.2, 0.7), (0.5, 1e-9)] {
                let count = 20_000;
                let at = |index: i32| noise + spread * (2.0 * (f64::from(index) + 0.5) / f64::from(count) - 1.0);
                let mean = (0..count).map(|index| layer.density(at(index), 0.5, 0.0)).sum::<f64>() / f64::from(count);
                let found = layer.density(noise, 0.5, spread);
                assert!((found - mean).abs() < 1e-3, "{softness}, {noise} ± {spread}: {found}, expected {mean}");
            }
        }
    }
}
