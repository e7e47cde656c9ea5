//! Points and directions with error bounds, and the span of the lights' masks there.

use super::lights::{Combine, Lights};
use crate::view::{NORMAL, POSITION};
use std::f64::consts::PI;
use trochoid_graph::{Bounding, Channel, One, Span, port};
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{DVec3, Light, Projector};

/// A vector with a bound of its error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundedVector {
    pub(crate) vector: DVec3,
    pub(crate) within: f64,
    pub(crate) clear: bool,
}

impl BoundedVector {
    /// Reads a vector from three channels of the view.
    pub(crate) fn of(bounding: &Bounding<'_>, view: &One<port::View>, channels: [Channel; 3], sample: usize) -> Self {
        // No closures of arrays, which are not inlined.
        let [a, b, c] = channels;
        let certain = |channel| bounding.certain(view, channel, sample);
        let spans = [certain(a), certain(b), certain(c)];
        let [x, y, z] = &spans;
        let vector = DVec3::new(x.middle(), y.middle(), z.middle());
        let within = DVec3::new(x.half(), y.half(), z.half()).length();
        Self { vector, within, clear: spans.iter().all(|span| span.clear) }.rounded(vector.length())
    }

    /// Adds what a few operations on numbers of a size round, unless the vector is exact: then the reference does the
    /// same operations on the same numbers.
    fn rounded(self, size: f64) -> Self {
        let within = self.within + 4.0 * f64::EPSILON * size;
        match self.within {
            0.0 => self,
            // A coordinate is anything.
            _ if within.is_nan() => Self { within: f64::INFINITY, ..self },
            _ => Self { within, ..self },
        }
    }

    /// Reads the point that is seen.
    pub(crate) fn point(bounding: &Bounding<'_>, view: &One<port::View>, sample: usize) -> Self {
        Self::of(bounding, view, POSITION, sample)
    }
}

/// A direction with a bound of its angular error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundedDirection {
    /// Direction, of length 1.
    unit: DVec3,
    /// Largest angle between this and the true direction, in radians.
    turn: f64,
    clear: bool,
}

/// Largest angle, in radians, by which the rounding of a unit vector turns it, and of the operations that take the angle
/// between two: each coordinate is off by less than 3·2⁻⁵³, the angle by less than √3 times as much, twice.
const ROUNDED: f64 = 1.2e-15;

/// Rounding error of a dot product of unit vectors: less than 8·2⁻⁵³.
const LOST: f64 = 2e-15;

impl BoundedDirection {
    /// Creates the direction of a vector; a degenerate vector points up.
    pub(crate) fn along(BoundedVector { vector, within, clear }: BoundedVector) -> Self {
        let (unit, length) = (unit_or_up(vector), vector.length());
        if within == 0.0 {
            return Self { unit, turn: ROUNDED, clear };
        }
        // Seen from the origin, the sphere around the vector's end fills a cone.
        let sine = within / length;
        if sine < 0.999_999 {
            Self { unit, turn: libm::asin(sine) + ROUNDED, clear }
        } else {
            Self { unit, turn: PI, clear: false }
        }
    }

    /// Creates the direction of an exact vector.
    pub(crate) fn exactly(vector: DVec3) -> Self {
        Self::along(BoundedVector { vector, within: 0.0, clear: true })
    }

    /// Reads the surface normal that is seen.
    pub(crate) fn normal(bounding: &Bounding<'_>, view: &One<port::View>, sample: usize) -> Self {
        Self::along(BoundedVector::of(bounding, view, NORMAL, sample))
    }

    /// Returns the direction from a point to the eye.
    pub(crate) fn eye(eye: &Projector, point: BoundedVector) -> Self {
        if eye.orthographic { Self::exactly(-eye.forward) } else { Self::from(point, eye.position) }
    }

    /// Returns the direction from an uncertain point to an exact one.
    pub(crate) fn from(point: BoundedVector, place: DVec3) -> Self {
        let size = place.length() + point.vector.length();
        Self::along(BoundedVector { vector: place - point.vector, ..point }.rounded(size))
    }

    /// Returns the angle between two directions, in radians.
    pub(crate) fn angle(self, other: Self) -> Span {
        let (a, b) = (self.unit, other.unit);
        let (angle, turn) = (libm::atan2(a.cross(b).length(), a.dot(b)), self.turn + other.turn);
        Span { low: (angle - turn).max(0.0), high: (angle + turn).min(PI), clear: self.clear && other.clear }
    }

    /// Returns the cosine of the angle between two directions.
    pub(crate) fn cosine(self, other: Self) -> Span {
        self.angle(other).through(libm::cos).wider(LOST).within(-1.0, 1.0)
    }

    /// Returns the cosine of half the angle between two directions: that of the half vector to either.
    pub(crate) fn half_cosine(self, other: Self) -> Span {
        self.angle(other).through(|angle| libm::cos(angle / 2.0)).wider(LOST).within(0.0, 1.0)
    }

    /// Returns the direction halfway between two.
    pub(crate) fn halfway(self, other: Self) -> Self {
        let chord = |turn: f64| 2.0 * libm::sin(turn.min(PI) / 2.0);
        let within = chord(self.turn) + chord(other.turn);
        Self::along(BoundedVector { vector: self.unit + other.unit, within, clear: self.clear && other.clear })
    }

    /// Returns the elevation above the horizon, in degrees.
    pub(crate) fn elevation(self) -> Span {
        let DVec3 { x, y, z } = self.unit;
        let (angle, turn) = (libm::atan2(y, libm::sqrt(x * x + z * z)), self.turn + ROUNDED);
        let ends = [(angle - turn).max(-PI / 2.0), (angle + turn).min(PI / 2.0)].map(f64::to_degrees);
        Span { low: ends[0], high: ends[1], clear: self.clear }
    }

    /// Mirrors a direction that points away from a surface, with `self` as its normal.
    pub(crate) fn mirrored(self, direction: Self) -> Self {
        let vector = self.unit * (2.0 * self.unit.dot(direction.unit)) - direction.unit;
        let turn = (2.0 * self.turn + direction.turn).min(PI);
        Self { unit: unit_or_up(vector), turn: turn + ROUNDED, clear: self.clear && direction.clear }
    }
}

impl Lights {
    /// Returns the span of the combined mask of all lights at a point. `shade` gives the span for one light from the
    /// direction toward it.
    pub(crate) fn mask_span(&self, point: BoundedVector, shade: impl Fn(BoundedDirection) -> Span) -> Span {
        let (mut lows, mut highs, mut clear) = (Vec::new(), Vec::new(), true);
        for light in self.lights() {
            let (toward, arrives) = illuminated(light, point);
            let mask = if arrives.high > 0.0 { shade(toward).within(0.0, 1.0) } else { Span::exactly(0.0) };
            lows.push(arrives.low * mask.low);
            highs.push(arrives.high * mask.high);
            clear &= arrives.clear && mask.clear;
        }
        // Every way of combining masks is monotonic, so the ends of the span come from the ends of the masks.
        let combine: Combine = self.combine();
        Span::of(&[combine.reference(&lows), combine.reference(&highs)]).within(0.0, 1.0).with(clear)
    }
}

/// Returns the direction to a light, and its intensity at a point.
fn illuminated(light: &Light, point: BoundedVector) -> (BoundedDirection, Span) {
    match *light {
        Light::Directional { direction } => (BoundedDirection::exactly(direction), Span::exactly(1.0)),
        Light::Point { position } => (BoundedDirection::from(point, position), Span::exactly(1.0)),
        Light::Spot { position, target, angle, soft } => {
            let toward = BoundedDirection::from(point, position);
            let axis = (target - position).try_normalize().unwrap_or(DVec3::NEG_Y);
            let spot = Light::Spot { position: DVec3::ZERO, target: axis, angle, soft };
            let aside = axis.any_orthonormal_vector();
            let arrives = |off_axis: f64| {
                let (sin, cos) = libm::sincos(off_axis);
                spot.illuminate(axis * cos + aside * sin).intensity
            };
            let off_axis = BoundedDirection { unit: -toward.unit, ..toward }.angle(BoundedDirection::exactly(axis));
            let jumps = soft == 0.0 && arrives(off_axis.low) != arrives(off_axis.high);
            (toward, off_axis.through(arrives).within(0.0, 1.0).with(!jumps))
        }
    }
}
