//! Points and directions that are certain up to a distance and an angle, and what light gives there.

use super::lights::{Combine, Lights};
use crate::view::{NORMAL, POSITION};
use std::f64::consts::PI;
use trochoid_graph::{Bounding, Channel, One, Span, port};
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{DVec3, Light, Projector};

/// A vector that is certain up to a distance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub(crate) vector: DVec3,
    pub(crate) within: f64,
    pub(crate) clear: bool,
}

impl Near {
    /// Three channels of the view.
    pub(crate) fn of(bounding: &Bounding<'_>, view: &One<port::View>, channels: [Channel; 3], sample: usize) -> Self {
        let spans = channels.map(|channel| bounding.certain(view, channel, sample));
        Self {
            vector: DVec3::from(spans.map(Span::middle)),
            within: DVec3::from(spans.map(Span::half)).length(),
            clear: spans.iter().all(|span| span.clear),
        }
    }

    /// The point that is seen.
    pub(crate) fn point(bounding: &Bounding<'_>, view: &One<port::View>, sample: usize) -> Self {
        Self::of(bounding, view, POSITION, sample)
    }
}

/// A direction that is certain up to an angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Toward {
    /// Of length 1.
    unit: DVec3,
    /// How far it may turn, in radians.
    turn: f64,
    clear: bool,
}

/// Angles by which computing a unit vector may turn it.
const ROUNDED: f64 = 4e-16;

/// What products of unit vectors lose.
const LOST: f64 = 1e-15;

impl Toward {
    /// Along a vector; a degenerate one points up.
    pub(crate) fn along(Near { vector, within, clear }: Near) -> Self {
        let (unit, length) = (unit_or_up(vector), vector.length());
        if within == 0.0 {
            return Self { unit, turn: ROUNDED, clear };
        }
        // Seen from its origin, what lies around a vector's end is a cone.
        let sine = within / length;
        if sine < 0.999_999 {
            Self { unit, turn: libm::asin(sine) + ROUNDED, clear }
        } else {
            Self { unit, turn: PI, clear: false }
        }
    }

    /// A vector that is certain.
    pub(crate) fn exactly(vector: DVec3) -> Self {
        Self::along(Near { vector, within: 0.0, clear: true })
    }

    /// The normal that is seen.
    pub(crate) fn normal(bounding: &Bounding<'_>, view: &One<port::View>, sample: usize) -> Self {
        Self::along(Near::of(bounding, view, NORMAL, sample))
    }

    /// From a point to the eye.
    pub(crate) fn eye(eye: &Projector, point: Near) -> Self {
        if eye.orthographic { Self::exactly(-eye.forward) } else { Self::from(point, eye.position) }
    }

    /// From a point to a place.
    pub(crate) fn from(point: Near, place: DVec3) -> Self {
        Self::along(Near { vector: place - point.vector, ..point })
    }

    /// The angle between two directions, in radians.
    pub(crate) fn angle(self, other: Self) -> Span {
        let (a, b) = (self.unit, other.unit);
        let (angle, turn) = (libm::atan2(a.cross(b).length(), a.dot(b)), self.turn + other.turn);
        Span { low: (angle - turn).max(0.0), high: (angle + turn).min(PI), clear: self.clear && other.clear }
    }

    /// The cosine of that angle.
    pub(crate) fn cosine(self, other: Self) -> Span {
        self.angle(other).through(libm::cos).wider(LOST).within(-1.0, 1.0)
    }

    /// The cosine of half that angle, under which the direction in the middle stands to both.
    pub(crate) fn half_cosine(self, other: Self) -> Span {
        self.angle(other).through(|angle| libm::cos(angle / 2.0)).wider(LOST).within(0.0, 1.0)
    }

    /// The direction in the middle between two.
    pub(crate) fn halfway(self, other: Self) -> Self {
        let chord = |turn: f64| 2.0 * libm::sin(turn.min(PI) / 2.0);
        let within = chord(self.turn) + chord(other.turn);
        Self::along(Near { vector: self.unit + other.unit, within, clear: self.clear && other.clear })
    }

    /// How high it stands over the horizon, in degrees.
    pub(crate) fn elevation(self) -> Span {
        let DVec3 { x, y, z } = self.unit;
        let (angle, turn) = (libm::atan2(y, libm::sqrt(x * x + z * z)), self.turn + ROUNDED);
        let ends = [(angle - turn).max(-PI / 2.0), (angle + turn).min(PI / 2.0)].map(f64::to_degrees);
        Span { low: ends[0], high: ends[1], clear: self.clear }
    }

    /// Where a direction away from a surface is mirrored to by one of this normal.
    pub(crate) fn mirrored(self, direction: Self) -> Self {
        let vector = self.unit * (2.0 * self.unit.dot(direction.unit)) - direction.unit;
        let turn = (2.0 * self.turn + direction.turn).min(PI);
        Self { unit: unit_or_up(vector), turn: turn + ROUNDED, clear: self.clear && direction.clear }
    }
}

impl Lights {
    /// What the mask of all lights may be at a point, where `shade` gives that of one toward which a direction leads.
    pub(crate) fn may_give(&self, point: Near, shade: impl Fn(Toward) -> Span) -> Span {
        let (mut lows, mut highs, mut clear) = (Vec::new(), Vec::new(), true);
        for light in self.lights() {
            let (toward, arrives) = illuminated(light, point);
            let mask = if arrives.high > 0.0 { shade(toward).within(0.0, 1.0) } else { Span::exactly(0.0) };
            lows.push(arrives.low * mask.low);
            highs.push(arrives.high * mask.high);
            clear &= arrives.clear && mask.clear;
        }
        // However masks are combined, none takes from the result.
        let combine: Combine = self.combine();
        Span::of(&[combine.reference(&lows), combine.reference(&highs)]).within(0.0, 1.0).with(clear)
    }
}

/// The direction to a light, and how much of it arrives.
fn illuminated(light: &Light, point: Near) -> (Toward, Span) {
    match *light {
        Light::Directional { direction } => (Toward::exactly(direction), Span::exactly(1.0)),
        Light::Point { position } => (Toward::from(point, position), Span::exactly(1.0)),
        Light::Spot { position, target, angle, soft } => {
            let toward = Toward::from(point, position);
            let axis = (target - position).try_normalize().unwrap_or(DVec3::NEG_Y);
            let spot = Light::Spot { position: DVec3::ZERO, target: axis, angle, soft };
            let aside = axis.any_orthonormal_vector();
            let arrives = |off_axis: f64| {
                let (sin, cos) = libm::sincos(off_axis);
                spot.illuminate(axis * cos + aside * sin).intensity
            };
            let off_axis = Toward { unit: -toward.unit, ..toward }.angle(Toward::exactly(axis));
            let jumps = soft == 0.0 && arrives(off_axis.low) != arrives(off_axis.high);
            (toward, off_axis.through(arrives).within(0.0, 1.0).with(!jumps))
        }
    }
}
