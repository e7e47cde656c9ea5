//! Finds the first point of a sea on a ray, in f64, including folds.
//!
//! Rectangles of rest points are bisected, the nearest first, until bounds on the derivatives of the sea's points
//! prove either that no point of a rectangle lies on the ray, or that at most one does, which Newton's method then
//! finds or not.

use crate::sea_point::SeaPoint;
use crate::surface::GivenUp;
use crate::{Projector, Ray, SeaSurface};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Number of Newton steps, and their tolerance, relative to 1 m + distance.
const STEPS: usize = 24;
const CLOSE: f64 = 1e-13;
/// Most rectangles that are cut for a ray; most rays take some thousands.
const MOST: u32 = 200_000;
/// Share of a footprint that footprints nearby are at least.
pub(crate) const NEARBY: f64 = 0.9;
/// Half diagonal, relative to 1 m + distance, at which a rectangle whose points nearly touch the ray is not cut any
/// further.
const LEAST: f64 = 1e-9;
/// Rounding error of coordinates, relative to their size.
const ROUNDING: f64 = 2e-15;
/// e^(−x²/8)·x/4 is below this share of e^(−x²/16), the filter factor of a wave under a footprint 1/√2 as large.
const FADING: f64 = 0.43;

/// A ray, and a frame to measure the distance of points from it.
struct Search<'a> {
    sea: &'a SeaSurface,
    projector: &'a Projector,
    ray: &'a Ray,
    /// Unit vectors at right angles to the ray; the first one is horizontal.
    aside: [DVec3; 2],
    /// Horizontal unit vectors: along the ray, and across it.
    axes: [DVec3; 2],
    end: f64,
}

/// Rectangle of rest points: offsets in meters from the ray's origin along the axes.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    middle: [f64; 2],
    half: [f64; 2],
    /// No point of the rectangle lies on the ray nearer than this.
    nearest: f64,
}

enum Solutions {
    /// No point lies on the ray.
    Empty,
    /// At most one point lies on the ray: its distance and rest point.
    Point(f64, [f64; 2]),
    /// Some points may lie on the ray, from this distance on.
    From(f64),
}

/// Returns the distance and the rest point of the first point of a sea that a ray meets between two distances; gives up
/// after [`MOST`] rectangles.
///
/// The bounds account for rounding, and for everything except the curvature of the footprint: between two positions
/// where its growth is computed, it is assumed to grow at a rate in between.
pub(crate) fn first_point(
    sea: &SeaSurface,
    projector: &Projector,
    ray: &Ray,
    [start, end]: [f64; 2],
) -> Result<Option<(f64, [f64; 2])>, GivenUp> {
    // A flat sea leaves only one distance, and rounding.
    let (start, end) = (start * (1.0 - LEAST), end * (1.0 + LEAST));
    let horizontal = libm::hypot(ray.direction.x, ray.direction.z);
    let along = if horizontal > 0.0 {
        DVec3::new(ray.direction.x / horizontal, 0.0, ray.direction.z / horizontal)
    } else {
        DVec3::X
    };
    let across = DVec3::new(-along.z, 0.0, along.x);
    let aside = [across, across.cross(ray.direction).normalize()];
    let search = Search { sea, projector, ray, aside, axes: [along, across], end };
    // Points that waves carry onto the ray rest within the waves' reach of it.
    let half = (end - start) * horizontal / 2.0 + sea.drift;
    let whole =
        Rectangle { middle: [start * horizontal + half - sea.drift, 0.0], half: [half, sea.drift], nearest: 0.0 };
    let (mut rectangles, mut first) = (BinaryHeap::from([whole]), None::<(f64, [f64; 2])>);
    let mut left = MOST;
    while let Some(next) = rectangles.pop() {
        if first.is_some_and(|(distance, _)| distance <= next.nearest) {
            break;
        }
        left = left.checked_sub(1).ok_or(GivenUp)?;
        for part in next.cut() {
            match search.look(&part) {
                Solutions::Empty => {}
                Solutions::From(nearest) => rectangles.push(Rectangle { nearest, ..part }),
                Solutions::Point(distance, rest) => {
                    if first.is_none_or(|(known, _)| distance < known) {
                        first = Some((distance, rest));
                    }
                }
            }
        }
    }
    Ok(first)
}

impl Rectangle {
    /// Returns the two halves, cut across the longer side.
    fn cut(&self) -> [Self; 2] {
        let axis = usize::from(self.half[1] > self.half[0]);
        let mut half = self.half;
        half[axis] /= 2.0;
        [-half[axis], half[axis]].map(|offset| {
            let mut middle = self.middle;
            middle[axis] += offset;
            Self { middle, half, ..*self }
        })
    }
}

impl Search<'_> {
    fn rest(&self, offset: [f64; 2]) -> [f64; 2] {
        let place = self.ray.origin + self.axes[0] * offset[0] + self.axes[1] * offset[1];
        [place.x, place.z]
    }

    fn look(&self, part: &Rectangle) -> Solutions {
        let rest = self.rest(part.middle);
        let middle = self.sea.carried(self.projector, rest);
        let radius = libm::hypot(part.half[0], part.half[1]);
        let by = self.axes.map(|axis| middle.by[0] * axis.x + middle.by[1] * axis.z);
        let grown = self.growth(part, &middle);
        let limits = self.sea.limits();
        let [size, steepness, bend, ..] = limits.at(grown.least);
        let fading = FADING * limits.at(grown.least * std::f64::consts::FRAC_1_SQRT_2)[1];
        // Contribution of the footprint to second derivatives, for waves that are not much shorter than it.
        let bend = bend * (1.0 + 2.0 * grown.most) * (1.0 + 2.0 * grown.most);
        let uneven = fading * grown.uneven;
        let offset = middle.point - self.ray.origin;
        let rounding = rounding(self.ray, middle.point);
        // Returns how far points lie from the middle one at most, in a direction.
        let spread = |way: DVec3| {
            let resting = (0..2).map(|axis| self.axes[axis].dot(way).abs() * part.half[axis]).sum::<f64>();
            let turning = (0..2).map(|axis| by[axis].dot(way).abs() * part.half[axis]).sum::<f64>();
            let moved = (steepness * radius + fading * grown.range).min(2.0 * size);
            (resting + moved).min(turning + (bend * radius / 2.0 + uneven) * radius) + rounding
        };
        let off = self.aside.map(|way| offset.dot(way));
        let (distance, deep) = (offset.dot(self.ray.direction), spread(self.ray.direction));
        if (0..2).any(|side| off[side].abs() > spread(self.aside[side]))
            || distance + deep < 0.0
            || distance - deep > self.end
        {
            return Solutions::Empty;
        }
        // Bound on the change of the derivatives within twice the radius. If it is at most a quarter of their least
        // effect, no two points are carried to the same position, and each Newton step divides the error by at least
        // three.
        let least = least_stretch(across(self.aside, by));
        let is_least = radius <= LEAST * (1.0 + distance.abs());
        if is_least || 4.0 * (2.0 * bend * radius + 2.0 * uneven) <= least {
            return match newton(self.sea, self.projector, self.ray, self.aside, rest) {
                Some((distance, at, _))
                    if libm::hypot(at[0] - rest[0], at[1] - rest[1]) <= 2.0 * radius + LEAST * (1.0 + distance) =>
                {
                    if distance >= 0.0 && distance <= self.end {
                        Solutions::Point(distance, at)
                    } else {
                        Solutions::Empty
                    }
                }
                _ => Solutions::Empty,
            };
        }
        Solutions::From(distance - deep)
    }

    /// Returns the footprints of a rectangle, and how they grow.
    fn growth(&self, part: &Rectangle, middle: &SeaPoint) -> FootprintRange {
        let [x, z] = self.projector.heading();
        // Footprints change only along the camera's heading.
        let reach: f64 =
            (0..2).map(|axis| (self.axes[axis].x * x + self.axes[axis].z * z).abs() * part.half[axis]).sum();
        let center = self.rest(part.middle);
        let eye = self.projector.position;
        let ahead = (center[0] - eye.x) * x + (center[1] - eye.z) * z;
        let at = |ahead: f64| [eye.x + ahead * x, eye.z + ahead * z];
        let ends = [ahead - reach, ahead + reach];
        let least = self.sea.least_footprint(self.projector, ends).min(middle.footprint);
        // They grow to both sides of their minimum.
        let most = ends.map(|end| {
            let [x, z] = at(end);
            self.sea.footprint(self.projector, DVec3::new(x, self.sea.level, z))
        });
        let growths = ends.map(|end| self.sea.growth(self.projector, at(end)));
        let bent = growths.map(|growth| (growth - middle.growth).abs());
        FootprintRange {
            least,
            range: (most[0].max(most[1]) - middle.footprint).max(middle.footprint - least),
            most: growths[0].abs().max(growths[1].abs()).max(middle.growth.abs()),
            uneven: bent[0].max(bent[1]),
        }
    }
}

/// Returns the derivatives of a point's offset across a ray, row by row.
pub(crate) fn across(aside: [DVec3; 2], by: [DVec3; 2]) -> [[f64; 2]; 2] {
    aside.map(|way| by.map(|by| by.dot(way)))
}

/// Returns the rounding error of a point's offset from a ray's origin, in meters.
fn rounding(ray: &Ray, point: DVec3) -> f64 {
    ROUNDING * (point.abs() + ray.origin.abs()).max_element()
}

/// Applies Newton's method to find a point of a sea on a ray, from a rest point x, z; returns its distance, its rest
/// point and the point itself. `aside` are unit vectors at right angles to the ray.
pub(crate) fn newton(
    sea: &SeaSurface,
    projector: &Projector,
    ray: &Ray,
    aside: [DVec3; 2],
    mut rest: [f64; 2],
) -> Option<(f64, [f64; 2], SeaPoint)> {
    for _ in 0..STEPS {
        let here = sea.carried(projector, rest);
        let offset = here.point - ray.origin;
        let distance = offset.dot(ray.direction);
        let [p, q] = aside.map(|way| offset.dot(way));
        if libm::hypot(p, q) <= CLOSE * (1.0 + distance.abs()) + rounding(ray, here.point) {
            return Some((distance, rest, here));
        }
        let [[a, b], [c, d]] = across(aside, here.by);
        let area = a * d - b * c;
        rest = [rest[0] - (d * p - b * q) / area, rest[1] - (a * q - c * p) / area];
        if !(rest[0].is_finite() && rest[1].is_finite()) {
            return None;
        }
    }
    None
}

/// Errors of a point after one step of Newton's method with which it is good enough: of its distance, relative to 1 m +
/// distance, and of its derivatives.
const STEPPED: f64 = 1e-10;
const TURNED: f64 = 1e-4;

/// Most steps of [`stepped`] after which its last one may be good enough: the second mostly is, at the cost of two sums
/// where Newton's method takes three or four.
const STEPS_AT_ONCE: usize = 2;

/// Returns by how much derivatives change per meter at most, in any direction and for all phases, and footprints with them,
/// given limits under a smaller footprint and the growth of the footprint.
pub(crate) fn bend_of(limits: &[f64; 6], growth: f64) -> f64 {
    2.0 * limits[2] * (1.0 + 2.0 * growth.abs()) * (1.0 + 2.0 * growth.abs())
}

/// Does the same from a rest point whose point nearly lies on the ray, mostly with a single sum. Also returns how far the
/// distance, the derivatives and the roughness may be from those of the sea's point on the ray.
pub(crate) fn stepped(
    sea: &SeaSurface,
    projector: &Projector,
    ray: &Ray,
    aside: [DVec3; 2],
    start: [f64; 2],
) -> Option<(f64, [f64; 2], SeaPoint, f64)> {
    let mut rest = start;
    for _ in 0..STEPS_AT_ONCE {
        let here = sea.carried(projector, rest);
        let offset = here.point - ray.origin;
        let [p, q] = aside.map(|way| offset.dot(way));
        let [[a, b], [c, d]] = across(aside, here.by);
        let area = a * d - b * c;
        let [x, z] = [-(d * p - b * q) / area, -(a * q - c * p) / area];
        let moved = libm::hypot(x, z);
        let distance = (offset + here.by[0] * x + here.by[1] * z).dot(ray.direction);
        let limits = sea.limits().at(here.footprint * NEARBY);
        let bend = bend_of(&limits, here.growth);
        let size = here.by[0].length() + here.by[1].length();
        // What one step leaves moves the point once more along the surface.
        let left = bend * moved * moved * (1.0 + size * size / area.abs());
        let normal = DVec3::from(here.precise.sample.normal()).length();
        let turned = 2.0 * bend * moved * size * (1.0 + 1.0 / normal);
        let rougher = limits[1] * limits[1] * here.growth.abs() * moved / here.footprint;
        // False for NaN.
        let is_near = moved <= (1.0 - NEARBY) * here.footprint;
        // The only point within twice the step, by Newton and Kantorovich's theorem.
        let is_close = is_near
            && 4.0 * bend * moved * size <= area.abs()
            && left <= STEPPED * (1.0 + distance.abs())
            && turned <= TURNED;
        rest = [rest[0] + x, rest[1] + z];
        if is_close {
            return Some((distance, rest, here, left + turned + rougher));
        }
        if !is_near {
            break;
        }
    }
    newton(sea, projector, ray, aside, start).map(|(distance, rest, point)| (distance, rest, point, 0.0))
}

/// Footprints of a rectangle.
struct FootprintRange {
    /// Least footprint, in meters.
    least: f64,
    /// Largest difference from the footprint at its middle, in meters.
    range: f64,
    /// Largest rate of change, in meters per meter, and its largest difference from the rate at the middle.
    most: f64,
    uneven: f64,
}

/// Returns the smaller singular value of a matrix [[a, b], [c, d]].
fn least_stretch([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    let (sum, area) = (a * a + b * b + c * c + d * d, (a * d - b * c).abs());
    let most = libm::sqrt((sum + libm::sqrt((sum * sum - 4.0 * area * area).max(0.0))) / 2.0);
    if most > 0.0 { area / most } else { 0.0 }
}

impl PartialEq for Rectangle {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Rectangle {}
impl PartialOrd for Rectangle {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
/// The nearest rectangle is the greatest, so that a heap returns it first.
impl Ord for Rectangle {
    fn cmp(&self, other: &Self) -> Ordering {
        other.nearest.total_cmp(&self.nearest)
    }
}
