//! The first point where a ray meets a sea: all roots are looked for in the plane of rest points.
//!
//! The point that rests at p lies on the ray where F(p) = 0, with F the distances from the ray along two directions
//! across it. Rectangles of rest points are halved. One is left out if F, by its derivative in the middle and a bound
//! on its second derivative, vanishes nowhere in it. If the derivative in the middle outweighs that bound, F has at
//! most one root there, which Newton's method finds if there is one. A rectangle that neither settles down to a tenth
//! of a micrometer touches a contour, and what the ray sees is left open.

use super::camera::{Camera, Ray};
use super::sea::{Sea, Sum};
use super::vector::{Vector, cross, dot, length, minus, plus, times};

/// What a ray meets first.
pub(super) struct FirstHit {
    /// The distance, the rest point and the sea there.
    pub(super) hit: Option<(f64, [f64; 2], Sum)>,
    /// Whether a contour is too close to the ray for certainty.
    pub(super) is_near_contour: bool,
}

/// Distance at which seas end, in meters.
const END: f64 = 1e7;
/// Size of squares that are not halved again, in meters, and the most squares for one ray.
const SMALLEST: f64 = 1e-7;
const MOST: usize = 100_000;
const NEWTON_STEPS: usize = 60;

/// A rectangle of rest points in coordinates along and across the ray's ground track.
#[derive(Clone, Copy)]
struct Part {
    along: [f64; 2],
    across: [f64; 2],
}

struct Search<'a> {
    sea: &'a Sea,
    camera: &'a Camera,
    ray: &'a Ray,
    /// Horizontal unit vector along the ray, and horizontal part of the ray's direction.
    heading: [f64; 2],
    level_part: f64,
    /// Unit vectors across the ray.
    sides: [Vector; 2],
}

/// Returns the first point of a sea on a ray from a camera.
pub(super) fn first_hit(sea: &Sea, camera: &Camera, ray: &Ray) -> FirstHit {
    let level_part = ray.along[0].hypot(ray.along[2]);
    let heading = if level_part > 1e-9 { [ray.along[0] / level_part, ray.along[2] / level_part] } else { [1.0, 0.0] };
    let side = [-heading[1], 0.0, heading[0]];
    let sides = [side, cross(side, ray.along)];
    let search = Search { sea, camera, ray, heading, level_part, sides };
    search.run()
}

impl Search<'_> {
    fn run(&self) -> FirstHit {
        let nothing = FirstHit { hit: None, is_near_contour: false };
        let rise: f64 = self.sea.waves.iter().map(|wave| wave.a.abs()).sum::<f64>() + 1e-9;
        let reach: f64 = self.sea.waves.iter().map(|wave| wave.h.abs()).sum::<f64>() + 1e-9;
        let (height, slope) = (self.ray.from[1] - self.sea.level, self.ray.along[1]);
        let ends = [(-rise - height) / slope, (rise - height) / slope];
        let start = ends[0].min(ends[1]).max(0.0);
        let end = ends[0].max(ends[1]).min(END / self.level_part.max(1e-9));
        // A level ray is in no picture of the tests.
        if start > end || end.is_nan() {
            return nothing;
        }
        let along = [start * self.level_part - reach, end * self.level_part + reach];
        let mut open = vec![Part { along, across: [-reach, reach] }];
        let (mut best, mut contour): (Option<(f64, [f64; 2])>, f64) = (None, f64::INFINITY);
        for _ in 0..MOST {
            let Some(part) = open.pop() else {
                let is_near_contour = contour < best.map_or(f64::INFINITY, |(distance, _)| distance) + 1e-5;
                let hit = best.map(|(distance, rest)| (distance, rest, self.sum(rest)));
                return FirstHit { hit, is_near_contour };
            };
            let nearest = if self.level_part > 1e-6 { (part.along[0] - reach) / self.level_part } else { 0.0 };
            if best.is_some_and(|(distance, _)| nearest > distance) {
                continue;
            }
            match self.settle(part, rise) {
                Settled::Nothing => {}
                Settled::Root(rest) => {
                    let distance = dot(minus(self.sum(rest).point, self.ray.from), self.ray.along);
                    if distance > 0.0 && best.is_none_or(|(best, _)| distance < best) {
                        best = Some((distance, rest));
                    }
                }
                Settled::Unclear(distance) => contour = contour.min(distance),
                // The nearer half is looked at first.
                Settled::Halves(halves) => open.extend(halves),
            }
        }
        FirstHit { hit: None, is_near_contour: true }
    }

    fn rest(&self, [along, across]: [f64; 2]) -> [f64; 2] {
        let [x, z] = self.heading;
        [self.ray.from[0] + along * x - across * z, self.ray.from[2] + along * z + across * x]
    }

    fn sum(&self, rest: [f64; 2]) -> Sum {
        self.sea.at(rest, self.sea.footprint(self.camera, rest))
    }

    fn settle(&self, part: Part, rise: f64) -> Settled {
        let [half, wide] = [part.along, part.across].map(|[from, to]| (to - from) / 2.0);
        let center = [part.along[0] + half, part.across[0] + wide];
        let middle = self.rest(center);
        // The least footprint in the part; footprints change slowly.
        let corners = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[i, j]| self.rest([part.along[i], part.across[j]]));
        let prints = corners.iter().chain([&middle]).map(|rest| self.sea.footprint(self.camera, *rest));
        let apart = center[0].hypot(self.ray.from[1] - self.sea.level);
        // Rounding far away; a root on a border may be found twice.
        let slack = 1e-10 * (1.0 + apart);
        let print = if half > 0.1 * apart { 0.0 } else { 0.8 * prints.fold(f64::INFINITY, f64::min) };
        // Bounds on the displacement and on its second derivative. A footprint grows no faster than with the root of the
        // distance cubed; `fade` bounds the change of a wave's share.
        let (mut low, mut moved, mut bend) = (0.0, 0.0, 0.0);
        for wave in &self.sea.waves {
            let left = (-(wave.k * print) * (wave.k * print) / 8.0).exp();
            let size = left * wave.a.hypot(wave.h);
            low += left * wave.a.abs();
            moved += left * wave.h.abs();
            let fade = (wave.k * print).powi(2) / apart;
            bend += 1.2 * size * ((wave.k + fade).powi(2) + 2.0 * fade / apart);
        }
        if self.level_part > 1e-6 {
            let heights = [part.along[0] - moved, part.along[1] + moved]
                .map(|along| self.ray.from[1] + along / self.level_part * self.ray.along[1] - self.sea.level);
            let low = low.min(rise) + slack;
            let is_above = heights[0].min(heights[1]) > low || heights[0].max(heights[1]) < -low;
            if is_above || part.across[0] > moved + slack || part.across[1] < -moved - slack {
                return Settled::Nothing;
            }
        }
        let radius = half.hypot(wide);
        let sum = self.sum(middle);
        // In large parts, what is known of the footprint tells nothing.
        let is_small = print > 0.0;
        let off = if is_small { bend * radius * radius / 2.0 + slack } else { f64::INFINITY };
        let (value, derivative) = self.distances(&sum, middle);
        let reaches = |i: usize| derivative[i][0].abs() * half + derivative[i][1].abs() * wide + off;
        if (0..2).any(|i| value[i].abs() > reaches(i)) {
            return Settled::Nothing;
        }
        // Twice the radius leaves room for Newton's steps.
        if is_small && bend * 2.0 * radius < 0.5 * least_stretch(derivative) {
            return match self.newton(center, 1.5 * radius + slack) {
                Newton::Root([along, across]) => {
                    let is_inside =
                        (along - center[0]).abs() <= half + slack && (across - center[1]).abs() <= wide + slack;
                    if is_inside { Settled::Root(self.rest([along, across])) } else { Settled::Nothing }
                }
                Newton::Away => Settled::Nothing,
                Newton::Lost => Settled::Unclear(0.0),
            };
        }
        if radius < SMALLEST {
            return Settled::Unclear(dot(minus(sum.point, self.ray.from), self.ray.along));
        }
        let (mut near, mut far) = (part, part);
        if half >= wide {
            (near.along[1], far.along[0]) = (center[0], center[0]);
        } else {
            (near.across[1], far.across[0]) = (center[1], center[1]);
        }
        Settled::Halves([far, near])
    }

    /// Returns the distances from the ray along its sides, and their derivatives along and across the track.
    fn distances(&self, sum: &Sum, rest: [f64; 2]) -> ([f64; 2], [[f64; 2]; 2]) {
        let away = minus(sum.point, self.ray.from);
        let [x, z] = self.heading;
        // The footprint is a smooth formula: differences give its slope to nine digits.
        let step = 1e-5 * (1.0 + length(away));
        let print = |dx: f64, dz: f64| self.sea.footprint(self.camera, [rest[0] + dx, rest[1] + dz]);
        let slopes = [print(step, 0.0) - print(-step, 0.0), print(0.0, step) - print(0.0, -step)];
        let [by_x, by_z] = slopes.map(|slope| times(slope / (2.0 * step), sum.by_footprint));
        let (along_x, along_z) = (plus(sum.along_x, by_x), plus(sum.along_z, by_z));
        let value = self.sides.map(|side| dot(side, away));
        let derivative = self.sides.map(|side| {
            let by = [dot(side, along_x), dot(side, along_z)];
            [by[0] * x + by[1] * z, by[1] * x - by[0] * z]
        });
        (value, derivative)
    }

    /// Follows Newton's steps. F is so close to linear that the first one leads away from a root by an eighth of the
    /// radius at most, if there is one in the part.
    fn newton(&self, start: [f64; 2], radius: f64) -> Newton {
        let mut place = start;
        for _ in 0..NEWTON_STEPS {
            let rest = self.rest(place);
            let ([f, g], [[fu, fv], [gu, gv]]) = self.distances(&self.sum(rest), rest);
            let determinant = fu * gv - fv * gu;
            let step = [(f * gv - g * fv) / determinant, (g * fu - f * gu) / determinant];
            place = [place[0] - step[0], place[1] - step[1]];
            if (place[0] - start[0]).hypot(place[1] - start[1]) > radius {
                return Newton::Away;
            }
            // Then the step was the last that makes a difference.
            if step[0].hypot(step[1]) < 1e-10 * (1.0 + place[0].abs()) {
                return Newton::Root(place);
            }
        }
        Newton::Lost
    }
}

enum Newton {
    Root([f64; 2]),
    Away,
    Lost,
}

enum Settled {
    Nothing,
    Root([f64; 2]),
    Unclear(f64),
    Halves([Part; 2]),
}

/// Returns the least singular value of a matrix.
fn least_stretch([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    let (sum, area) = (a * a + b * b + c * c + d * d, (a * d - b * c).abs());
    let greatest = ((sum + (sum * sum - 4.0 * area * area).max(0.0).sqrt()) / 2.0).sqrt();
    if greatest > 0.0 { area / greatest } else { 0.0 }
}
