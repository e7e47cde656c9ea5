//! Squares of footprints along a camera's heading, and how they change around a place.

use crate::footprint::{GRAZING, LEAST_DEPTH};
use crate::{Projector, SeaSurface};

/// Squares of the footprints of a sea's rest points by their distance u ahead of the camera; they do not change across
/// the heading.
///
/// For a perspective camera, f² = c²·d²/max(h/d, [`GRAZING`]) for the depth d, the height h over the rest level and the
/// size c of a pixel at depth 1. d is a linear function of u, or [`LEAST_DEPTH`] times the distance √(u² + h²), whichever
/// is larger.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprints {
    orthographic: Option<f64>,
    /// The linear depth: this times u, plus this.
    slope: f64,
    offset: f64,
    height: f64,
    /// c².
    pixel2: f64,
}

/// How f² changes around a place: at a distance σ, its power series is bounded, coefficient by coefficient, by that of
/// f²·m(`per`·|σ|).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Growth {
    form: Form,
    per: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// m = 1.
    Constant,
    /// m = (1 + x)²: the square of a linear depth, or of a distance.
    Square,
    /// m = (1 + x)³: the cube of a linear depth.
    Cube,
    /// The cube of a distance: (u² + h²)^(3/2) is the product of (1 − zσ)^(3/2) and its conjugate, |z| = `per`. The
    /// coefficients of (1 − x)^(3/2) are 1, 3/2, 3/8, 1/16 and less, so m = (1 + 3x/2 + 3x²/8 + x³/16(1 − x))².
    Distance,
}

impl Growth {
    /// Returns m at a distance, infinite where it does not converge.
    pub(super) fn at(self, distance: f64) -> f64 {
        let x = self.per * distance;
        match self.form {
            Form::Constant => 1.0,
            Form::Square => (1.0 + x) * (1.0 + x),
            Form::Cube => (1.0 + x) * (1.0 + x) * (1.0 + x),
            Form::Distance if x < 1.0 => {
                let root = 1.0 + 1.5 * x + 0.375 * x * x + x * x * x / (16.0 * (1.0 - x));
                root * root
            }
            Form::Distance => f64::INFINITY,
        }
    }

    /// Returns the coefficient of σ in m.
    pub(super) fn linear(self) -> f64 {
        match self.form {
            Form::Constant => 0.0,
            Form::Square => 2.0 * self.per,
            Form::Cube | Form::Distance => 3.0 * self.per,
        }
    }
}

impl Footprints {
    pub(super) fn new(sea: &SeaSurface, projector: &Projector) -> Self {
        let offset = sea.level - projector.position.y;
        let [x, z] = projector.heading();
        let (forward, pixel) = (projector.forward, projector.pixel_size(1.0) / sea.detail);
        let flat = pixel * pixel / forward.y.abs().max(GRAZING);
        Self {
            orthographic: projector.orthographic.then_some(flat),
            slope: forward.x * x + forward.z * z,
            offset: offset * forward.y,
            height: offset.abs(),
            pixel2: pixel * pixel,
        }
    }

    fn linear(&self, u: f64) -> f64 {
        u * self.slope + self.offset
    }

    fn distance(&self, u: f64) -> f64 {
        libm::sqrt(u * u + self.height * self.height)
    }

    /// Returns f² in m².
    pub(super) fn square(&self, u: f64) -> f64 {
        if let Some(flat) = self.orthographic {
            return flat;
        }
        let depth = self.linear(u).max(LEAST_DEPTH * self.distance(u));
        if depth == 0.0 { 0.0 } else { self.pixel2 * depth * depth / (self.height / depth).max(GRAZING) }
    }

    /// Returns f in meters, and its derivative by u.
    pub(super) fn change(&self, u: f64) -> (f64, f64) {
        let footprint = libm::sqrt(self.square(u));
        if self.orthographic.is_some() {
            return (footprint, 0.0);
        }
        let (linear, distance) = (self.linear(u), self.distance(u));
        let (depth, slope) = if linear >= LEAST_DEPTH * distance {
            (linear, self.slope)
        } else {
            (LEAST_DEPTH * distance, LEAST_DEPTH * u / distance)
        };
        // f is a power of the depth: its first, or that of 3/2.
        let power = if self.height <= GRAZING * depth { 1.0 } else { 1.5 };
        (footprint, power * footprint * slope / depth)
    }

    /// Returns the change around a place; it holds up to the next of the [`kinks`](Self::kinks).
    pub(super) fn growth(&self, u: f64) -> Growth {
        if self.orthographic.is_some() {
            return Growth { form: Form::Constant, per: 0.0 };
        }
        let (linear, distance) = (self.linear(u), self.distance(u));
        let depth = linear.max(LEAST_DEPTH * distance);
        let grazing = self.height <= GRAZING * depth;
        let (form, per) = match (linear >= LEAST_DEPTH * distance, grazing) {
            (true, true) => (Form::Square, self.slope.abs() / linear),
            (true, false) => (Form::Cube, self.slope.abs() / linear),
            (false, true) => (Form::Square, 1.0 / distance),
            (false, false) => (Form::Distance, 1.0 / distance),
        };
        Growth { form, per }
    }

    /// Returns the places between which f² is analytic, in order.
    pub(super) fn kinks(&self) -> Vec<f64> {
        if self.orthographic.is_some() {
            return Vec::new();
        }
        let Self { slope, offset, height, .. } = *self;
        let mut kinks = vec![0.0];
        // Where the linear depth equals the least depth: a quadratic equation in u.
        let least = LEAST_DEPTH * LEAST_DEPTH;
        let (a, b, c) = (slope * slope - least, slope * offset, offset * offset - least * height * height);
        let root = b * b - a * c;
        if root >= 0.0 && a != 0.0 {
            kinks.extend([-1.0, 1.0].map(|sign| (sign * libm::sqrt(root) - b) / a));
        } else if a == 0.0 && b != 0.0 {
            kinks.push(-c / (2.0 * b));
        }
        // Where either depth equals h/GRAZING.
        if slope != 0.0 {
            kinks.push((height / GRAZING - offset) / slope);
        }
        let far = 1.0 / (GRAZING * LEAST_DEPTH);
        let far = height * libm::sqrt(far * far - 1.0);
        kinks.extend([-far, far]);
        kinks.retain(|kink| kink.is_finite());
        kinks.sort_unstable_by(f64::total_cmp);
        kinks
    }
}
