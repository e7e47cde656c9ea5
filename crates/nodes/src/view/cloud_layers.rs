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
