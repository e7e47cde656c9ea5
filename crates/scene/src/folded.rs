//! Rays against seas that may fold over.

use crate::crossing::first_crossing;
use crate::{Projector, Ray, SeaSurface};
use glam::DVec3;

/// Newton's steps onto the plane of a ray, and how near they lead, over 1 m + distance.
const STEPS: usize = 24;
const CLOSE: f64 = 1e-12;
/// Steps for each shortest wave or footprint, whichever is longer.
const STEPS_PER_LENGTH: f64 = 10.0;
/// The part of a step that leads past a place where the ray has met the sea.
const PAST: f64 = 1e-3;

/// The rest points that are carried into the vertical plane of a ray: a curve, which folds as the sea does.
struct Curve<'a> {
    sea: &'a SeaSurface,
    projector: &'a Projector,
    ray: &'a Ray,
    /// Horizontal unit vectors along the ray's plane and across it.
    along: [f64; 2],
    across: [f64; 2],
    /// Rest points by the way along the curve.
    points: Vec<(f64, [f64; 2])>,
    /// Its direction at the last one.
    tangent: [f64; 2],
}

/// A point of the curve.
struct Carried {
    /// How far ahead of the ray's origin, and how far from its plane, in meters.
    ahead: f64,
    beside: f64,
    /// Derivatives of the latter by the rest point.
    by: [f64; 2],
    /// World y.
    height: f64,
    footprint: f64,
}

/// The distance and the rest point of the first point of a sea along a ray, between two distances; `None` where there is
/// none, and along rays straight up or down, which have no plane.
///
/// In its vertical plane the ray is a line and the sea a curve, that of the rest points which are carried there. It is
/// followed from behind the ray's beginning on by ways that are short against the shortest wave; wherever it passes
/// through the line, there the ray meets the sea. Of all these places the nearest counts: beyond one, others are looked
/// for as far as waves may carry anything back. A sea that folds along a ray and across it at once may have parts that do
/// not hang together with the curve: those are not found.
pub(crate) fn first_of_folded(
    sea: &SeaSurface,
    projector: &Projector,
    ray: &Ray,
    [start, end]: [f64; 2],
) -> Option<(f64, [f64; 2])> {
    let horizontal = libm::hypot(ray.direction.x, ray.direction.z);
    if horizontal < 1e-6 {
        return None;
    }
    let along = [ray.direction.x / horizontal, ray.direction.z / horizontal];
    let across = [-along[1], along[0]];
    let back = 2.0 * sea.drift();
    let first = start * horizontal - back;
    let begin = [ray.origin.x + first * along[0], ray.origin.z + first * along[1]];
    let mut curve = Curve { sea, projector, ray, along, across, points: Vec::new(), tangent: along };
    let begin = curve.onto(begin);
    curve.points.push((0.0, begin));
    let slope = ray.direction.y / horizontal;
    let (mut from, mut limit) = (0.0, end * horizontal + back);
    let mut nearest: Option<(f64, [f64; 2])> = None;
    loop {
        let found = first_crossing([from, f64::INFINITY], |way| {
            let rest = curve_point(&mut curve, way);
            let here = curve.carried(rest);
            let step = sea.shortest.max(here.footprint) / STEPS_PER_LENGTH;
            let gap = ray.origin.y + slope * here.ahead - here.height;
            (gap, if here.ahead > limit { 0.0 } else { step })
        });
        let Some(way) = found else { return nearest };
        let rest = curve_point(&mut curve, way);
        let here = curve.carried(rest);
        let distance = here.ahead / horizontal;
        if distance >= 0.0 && nearest.is_none_or(|(nearest, _)| distance < nearest) {
            nearest = Some((distance, rest));
            limit = limit.min(here.ahead + back);
        }
        from = way + PAST * sea.shortest.max(here.footprint) / STEPS_PER_LENGTH;
    }
}

/// The rest point so far along a curve, which is followed there.
fn curve_point(curve: &mut Curve<'_>, way: f64) -> [f64; 2] {
    let last = curve.points.len() - 1;
    let (end, from) = curve.points[last];
    if way >= end {
        let to = curve.onto([0, 1].map(|axis| from[axis] + (way - end) * curve.tangent[axis]));
        let by = curve.carried(to).by;
        let length = libm::hypot(by[0], by[1]);
        if length > 0.0 {
            let tangent = [-by[1] / length, by[0] / length];
            let ahead = tangent[0] * curve.tangent[0] + tangent[1] * curve.tangent[1] >= 0.0;
            curve.tangent = tangent.map(|part| if ahead { part } else { -part });
        }
        curve.points.push((way, to));
        return to;
    }
    let after = curve.points.partition_point(|(known, _)| *known <= way).max(1);
    let ((a, p), (b, q)) = (curve.points[after - 1], curve.points[after]);
    let share = (way - a) / (b - a);
    curve.onto([0, 1].map(|axis| p[axis] + share * (q[axis] - p[axis])))
}

impl Curve<'_> {
    fn carried(&self, rest: [f64; 2]) -> Carried {
        let footprint = self.sea.footprint(self.projector, DVec3::new(rest[0], self.sea.level, rest[1]));
        let sample = self.sea.frame.evaluate(rest, footprint);
        let ([dx, dy, dz], [xx, xz, zz]) = (sample.displacement, sample.strain);
        let place = [rest[0] + dx - self.ray.origin.x, rest[1] + dz - self.ray.origin.z];
        let part = |way: [f64; 2]| place[0] * way[0] + place[1] * way[1];
        let [x, z] = self.across;
        Carried {
            ahead: part(self.along),
            beside: part(self.across),
            by: [x * (1.0 + xx) + z * xz, x * xz + z * (1.0 + zz)],
            height: self.sea.level + dy,
            footprint,
        }
    }

    /// The nearest point of the curve.
    fn onto(&self, mut rest: [f64; 2]) -> [f64; 2] {
        for _ in 0..STEPS {
            let here = self.carried(rest);
            let square = here.by[0] * here.by[0] + here.by[1] * here.by[1];
            if here.beside.abs() <= CLOSE * (1.0 + here.ahead.abs()) || square == 0.0 {
                break;
            }
            rest = [0, 1].map(|axis| rest[axis] - here.beside * here.by[axis] / square);
        }
        rest
    }
}
