//! Finds the first point of a sea on a ray among its cells.

use super::bernstein::{DEGREE, Net, evaluate, part, range};
use super::cells::{Cell, SeaCells};
use super::derivatives::Derivatives;
use super::first::{First, FirstPoint, Shape, Thoroughness};
use super::part::Part;
use crate::boxes::Line;
use crate::first_point::{newton, stepped};
use crate::{Projector, Ray, SeaSurface};
use fearless_simd::{Simd, dispatch};
use glam::{DVec2, DVec3};

/// Most times that a patch is halved, and the size of a part, in distances of the sea from its patch, from which halving
/// does not help any more; then a smaller cell replaces it.
pub(super) const HALVINGS: u32 = 40;
const INDISTINCT: f64 = 8.0;
/// Most times that a smaller cell replaces a part of a smaller cell: each is smaller by the eighth power of its size.
const LEVELS: u32 = 6;
/// Change κ of the derivatives across a part, relative to their mean, up to which the part counts as one-to-one: a smaller
/// one takes more halves, and a larger one, more steps. If a step moves a place by δ, the end of all steps is within
/// [`ALL_STEPS`]·δ = δ/(1 − κ) of it.
const ONE_TO_ONE: f64 = 0.75;
const ALL_STEPS: f64 = 1.0 / (1.0 - ONE_TO_ONE);
/// Most steps of the projected iteration, each of which leaves κ of the distance at most: 1e-10 of it, all together.
const STEPS: usize = 80;
/// Share by which the part of a ray that is searched is longer at both ends.
const WIDER: f64 = 1e-9;
/// Distance in a part at which two points count as one.
const SAME: f64 = 1e-9;
/// The same for rest points, relative to 1 m + distance.
const SAME_PLACE: f64 = 1e-9;
/// Distance of a point found from the middle of a part, in sizes of the part, from which it has nothing to do with it.
const FAR: f64 = 2.0;

/// A cell in a ray's coordinates.
pub(super) struct SeenCell<'c> {
    pub(super) cell: &'c Cell,
    /// Number of cells within which it lies.
    level: u32,
    /// Distances along the ray, and the least and the greatest of them.
    along: Net,
    near: f64,
    far: f64,
    /// How far the sea may lie from the patch along the ray, and aside of it.
    pub(super) deep: f64,
    slack: f64,
    pub(super) slacks: [f64; 2],
    /// Whether distances mostly grow with s, and with t.
    grows: [bool; 2],
}

/// A search along one ray.
pub(super) struct Search<'a> {
    pub(super) cells: &'a SeaCells,
    pub(super) sea: &'a SeaSurface,
    projector: &'a Projector,
    ray: &'a Ray,
    /// The ray in the cells' axes, and unit vectors at right angles to it, also in these axes.
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    pub(super) aside: [DVec3; 2],
    effort: Thoroughness,
    /// Distance of the first point known, and the point.
    end: f64,
    found: Option<FirstPoint>,
    /// Parts and smaller cells that may still be looked at.
    parts: u32,
    smaller: u32,
    /// Room for the parts of a cell that remain to be looked at, the nearest last; empty between cells.
    open: Vec<Part>,
    /// Least distance at which something remains unknown.
    unknown: f64,
}

/// What is known about the points of a part on the ray.
enum Solutions {
    None,
    /// One at most, near this place.
    One([f64; 2]),
    /// Any number.
    Several {
        /// Whether to halve the part along s.
        along_s: bool,
    },
    /// Any number, and the sea is not known well enough to tell.
    Indistinct,
}

impl SeaCells {
    /// Returns the first point that a ray of the camera meets between two distances.
    pub(crate) fn first(
        &self,
        sea: &SeaSurface,
        projector: &Projector,
        ray: &Ray,
        [start, end]: [f64; 2],
        effort: Thoroughness,
    ) -> First {
        let (origin, direction) = (self.axes.point(ray.origin), self.axes.direction(ray.direction));
        let own = Ray { origin, direction };
        // A flat sea leaves only one distance, and rounding.
        let (start, end) = (start * (1.0 - WIDER), end * (1.0 + WIDER));
        if !self.region.holds(&own, [start, end]) {
            return First::Beyond;
        }
        let horizontal = DVec3::new(-direction.z, 0.0, direction.x).try_normalize().unwrap_or(DVec3::X);
        let aside = [horizontal, horizontal.cross(direction)];
        let (parts, smaller) = effort.most();
        let mut search = Search {
            cells: self,
            sea,
            projector,
            ray,
            origin,
            direction,
            aside,
            effort,
            end,
            found: None,
            parts,
            smaller,
            open: Vec::new(),
            unknown: f64::INFINITY,
        };
        self.tree.visit(&Line::new(origin, direction), end, |cell| {
            search.look(self.cell(cell), 0);
            // What lies behind something unknown does not matter any more.
            if search.unknown < f64::INFINITY { search.unknown.min(search.end) } else { search.end }
        });
        match search.found {
            _ if search.unknown <= search.end => First::Unknown,
            Some(found) => First::At(found),
            None => First::Nothing,
        }
    }
}

impl Search<'_> {
    /// Looks at a cell, as vector code. Not inlined: this code is a quarter of the crate, and once is enough.
    #[inline(never)]
    fn look(&mut self, cell: &Cell, level: u32) {
        dispatch!(self.cells.level, simd => simd.vectorize(
            #[inline(always)]
            || self.cell(simd, cell, level)
        ));
    }

    /// Looks at a cell that lies within some other ones.
    #[inline(always)]
    fn cell<S: Simd>(&mut self, simd: S, cell: &Cell, level: u32) {
        let slacks = self.aside.map(|way| cell.slack(way));
        // Most cells lie above or below the ray.
        let q = cell.seen_along(self.origin, self.aside[1]);
        if misses(range(&q), slacks[1]) {
            return;
        }
        let p = cell.seen_along(self.origin, self.aside[0]);
        if misses(range(&p), slacks[0]) {
            return;
        }
        let along = cell.seen_along(self.origin, self.direction);
        let [near, far] = range(&along);
        let [by_s, by_t] = Derivatives::means(&along);
        let seen = SeenCell {
            cell,
            level,
            along,
            near,
            far,
            deep: cell.slack(self.direction),
            slack: slacks[0].max(slacks[1]),
            slacks,
            grows: [by_s >= 0.0, by_t >= 0.0],
        };
        // A smaller cell within this one takes room of its own.
        let mut open = std::mem::take(&mut self.open);
        open.push(Part { aside: [p, q], start: [0.0; 2], size: [1.0; 2], halvings: HALVINGS });
        while let Some(part) = open.last_mut() {
            if self.parts == 0 {
                self.leave(&seen, part);
            } else {
                self.parts -= 1;
                match self.solutions(simd, &seen, part) {
                    Solutions::None => {}
                    Solutions::One(guess) => {
                        let start = part.on_patch(guess);
                        self.one(&seen, part, start);
                    }
                    Solutions::Several { along_s } => {
                        // The nearer half is looked at first.
                        let nearer = part.halve(simd, along_s, seen.grows[usize::from(!along_s)]);
                        open.push(nearer);
                        continue;
                    }
                    Solutions::Indistinct => self.again(&seen, part),
                }
            }
            open.truncate(open.len() - 1);
        }
        self.open = open;
    }

    /// Notes that the points of a part remain unknown.
    #[cold]
    fn leave(&mut self, seen: &SeenCell<'_>, part: &Part) {
        self.unknown = self.unknown.min(seen.reach(part)[0]);
    }

    /// Replaces a part by a smaller cell of its own, whose remainder is smaller by far.
    #[cold]
    fn again(&mut self, seen: &SeenCell<'_>, part: &Part) {
        let cell = seen.cell;
        let middle = cell.rest([0, 1].map(|axis| part.start[axis] + 0.5 * part.size[axis]));
        let half = cell.half * part.size[0].max(part.size[1]);
        let may = self.smaller > 0 && seen.level < LEVELS;
        match if may { self.cells.smaller(middle, half, &cell.remainder) } else { None } {
            Some(cell) => {
                self.smaller -= 1;
                self.look(&cell, seen.level + 1);
            }
            None => self.leave(seen, part),
        }
    }

    #[inline(always)]
    fn solutions<S: Simd>(&self, simd: S, seen: &SeenCell<'_>, part: &Part) -> Solutions {
        let mut is_distinct = part.halvings > 0;
        for (net, slack) in part.aside.iter().zip(seen.slacks) {
            let [low, high] = range(net);
            if misses([low, high], slack) {
                return Solutions::None;
            }
            is_distinct &= high - low > INDISTINCT * slack;
        }
        let whole = [seen.near - seen.deep, seen.far + seen.deep];
        if self.is_beyond(whole) {
            return Solutions::None;
        }
        match Self::crossings(simd, seen, part, is_distinct) {
            Solutions::None => Solutions::None,
            // Last, because few parts come so far, and it takes longer than all others.
            _ if (whole[1] > self.end || whole[0] < 0.0) && self.is_beyond(seen.reach(part)) => Solutions::None,
            found => found,
        }
    }

    /// Returns whether no distance of a range matters.
    #[inline(always)]
    fn is_beyond(&self, [near, far]: [f64; 2]) -> bool {
        near > self.end || far < 0.0
    }

    /// Returns what is known about the points of a part on the ray's line.
    #[inline(always)]
    fn crossings<S: Simd>(simd: S, seen: &SeenCell<'_>, part: &Part, is_distinct: bool) -> Solutions {
        // Derivatives by s and t of the part, as columns: their mean J, and by how much Y·(J − mean), Y = J⁻¹, changes.
        let [p, q] = &part.aside;
        let mean = Derivatives::mean(p, q);
        let several = |along_s: bool| if is_distinct { Solutions::Several { along_s } } else { Solutions::Indistinct };
        let is_long = mean.x_axis.length_squared() > mean.y_axis.length_squared();
        let inverse = mean.inverse();
        if !inverse.is_finite() {
            return several(is_long);
        }
        let [by_s, by_t] = Derivatives::changes(simd, p, q, &mean, &inverse);
        // The derivatives of the sea itself turn a little more.
        let norm = inverse.x_axis.abs() + inverse.y_axis.abs();
        let turn = 2.0 * seen.cell.remainder.turn * (part.size[0] + part.size[1]);
        let change = by_s + by_t + norm * turn;
        // False for NaN.
        let is_one_to_one = change.max_element() <= ONE_TO_ONE;
        if !is_one_to_one {
            let (s, t) = (by_s.max_element(), by_t.max_element());
            return several(if s == t { is_long } else { s > t });
        }
        // G(x) = x − Y·F(x) contracts the part by `change`, so a point of the ray lies within change/2 of G(middle).
        let middle = DVec2::splat(0.5);
        let value = DVec2::new(Derivatives::middle(p), Derivatives::middle(q));
        let guess = middle - inverse * value;
        let reach = 0.5 * change + norm * seen.slack + SAME;
        let is_outside = (guess + reach).min_element() < 0.0 || (guess - reach).max_element() > 1.0;
        if is_outside { Solutions::None } else { Solutions::One(guess.to_array()) }
    }

    /// Finds the only point that a part may have on the ray, given that of its patch.
    ///
    /// The part is one-to-one across the ray: G(x) = x − Y·F(x) contracts it by κ ≤ ¾. Newton's method on the sea itself
    /// mostly finds the point within the part. If it finds one beyond the part, or none, there may still be one in the
    /// part, and then it is the fixed point of x ↦ clamp(G(x)), which contracts as well and cannot leave the part. For any
    /// x and δ = |clamp(G(x)) − x|, that fixed point lies within δ/(1 − κ) = 4δ of x; if it was a point of the ray,
    /// |G(x) − x| could be (1 + κ)·4δ = 7δ at most.
    fn one(&mut self, seen: &SeenCell<'_>, part: &Part, start: DVec2) {
        let cell = seen.cell;
        // On the part's border, the patch mostly tells that its point lies in another part.
        let is_on_border = start.min_element() <= 0.0 || start.max_element() >= 1.0;
        if is_on_border && Self::settle(seen, part, start).is_none() {
            return;
        }
        let axes = &self.cells.axes;
        let rest = cell.rest(part.whole(start));
        let from = axes.rest(rest);
        if self.effort == Thoroughness::Rough
            && let Some([distance, deep, moved]) = self.roughly(seen, part, start)
        {
            let sheet = Some(part.sheet(cell, self.cells));
            self.take(FirstPoint { distance, rest: from, shape: None, off: 0.0, deep, moved, sheet });
            return;
        }
        if self.effort == Thoroughness::Near
            && let Some(point) = self.nearly(seen, part, start)
        {
            self.take(point);
            return;
        }
        let mut beyond = None;
        let near = match self.effort {
            Thoroughness::Rough | Thoroughness::Near | Thoroughness::Quick => {
                stepped(self.sea, self.projector, self.ray, self.world_aside(), from)
            }
            Thoroughness::Thorough => {
                let found = newton(self.sea, self.projector, self.ray, self.world_aside(), from);
                found.map(|(distance, rest, point)| (distance, rest, point, 0.0))
            }
        };
        if let Some((distance, rest, point, off)) = near {
            let local = part.local(cell.place(axes.point(DVec3::new(rest[0], axes.level, rest[1]))));
            let is_within = (local - 0.5).abs().max_element() <= 0.5 + SAME;
            // Wherever it is, it is a point of the sea on the ray.
            if (local - 0.5).abs().max_element() < FAR {
                self.take(FirstPoint {
                    distance,
                    rest,
                    shape: Some(Shape::from(&point.precise.sample)),
                    off,
                    deep: 0.0,
                    moved: 0.0,
                    sheet: None,
                });
            }
            // A part beside this one may have found it before.
            if is_within && let Some(found) = &mut self.found {
                let sheet = part.sheet(cell, self.cells);
                found.sheet = found.sheet.or_else(|| sheet.holds(found.rest).then_some(sheet));
            }
            if is_within {
                return;
            }
            beyond = Some(local);
        }
        let Some((near, off)) = Self::settle(seen, part, beyond.unwrap_or(start)) else { return };
        // If the part has a point, it is within four times the errors of this place, too close to the part's border to tell.
        // It may be the one that Newton's method has found just beyond, which then counts.
        let same = 2.0 * ALL_STEPS * (off + SAME);
        let is_known = beyond.is_some_and(|local| (local - near).abs().max_element() <= same);
        if !is_known {
            self.again(seen, part);
        }
    }

    /// Returns the fixed point of x ↦ clamp(G(x)) in a part, and how far G may be off; `None` if no point of the ray lies
    /// in the part.
    fn settle(seen: &SeenCell<'_>, part: &Part, start: DVec2) -> Option<(DVec2, f64)> {
        let [p, q] = &part.aside;
        let inverse = Derivatives::mean(p, q).inverse();
        let norm = inverse.x_axis.abs() + inverse.y_axis.abs();
        let off = (norm * seen.slack).max_element();
        let mut near = start.clamp(DVec2::ZERO, DVec2::ONE);
        for _ in 0..STEPS {
            let [(p, _), (q, _)] = evaluate(&part.aside, near.to_array());
            let step = inverse * DVec2::new(p, q);
            let to = (near - step).clamp(DVec2::ZERO, DVec2::ONE);
            let delta = (to - near).abs().max_element();
            if step.abs().max_element() > (1.0 + ONE_TO_ONE) * ALL_STEPS * (delta + off) + off {
                return None;
            }
            if delta <= SAME {
                break;
            }
            near = to;
        }
        Some((near, off))
    }

    /// Takes a point of the ray if it is the first one known. If it is too close to that to tell, both remain unknown.
    fn take(&mut self, point: FirstPoint) {
        let [near, far] = [point.distance - point.deep, point.distance + point.deep];
        if far < 0.0 || near >= self.end {
            return;
        }
        let is_other = |found: &FirstPoint| {
            let apart = libm::hypot(found.rest[0] - point.rest[0], found.rest[1] - point.rest[1]);
            near <= found.distance + found.deep
                && found.distance - found.deep <= far
                && apart > found.moved + point.moved + SAME_PLACE * (1.0 + point.distance)
        };
        let is_rough = matches!(self.effort, Thoroughness::Rough | Thoroughness::Near);
        if near < 0.0 || (is_rough && self.found.as_ref().is_some_and(is_other)) {
            self.unknown = self.unknown.min(near);
        }
        if self.found.as_ref().is_none_or(|found| point.distance < found.distance) {
            self.end = self.end.min(far);
            self.found = Some(point);
        }
    }

    /// Returns the distance of the only point that a part may have on the ray, how far it may be off, and how far its rest
    /// point may, if the part certainly has one; `start` is the patch's point on the ray.
    ///
    /// G contracts the part by κ ≤ ¾ and moves this place by e = |Y|·(slack + |F|) at most. If the square of half side
    /// e/(1 − κ) = 4e around it lies in the part, then G maps it to itself, so that the point exists and lies in it.
    fn roughly(&self, seen: &SeenCell<'_>, part: &Part, start: DVec2) -> Option<[f64; 3]> {
        let [p, q] = &part.aside;
        let inverse = Derivatives::mean(p, q).inverse();
        let norm = inverse.x_axis.abs() + inverse.y_axis.abs();
        let [(p, _), (q, _)] = evaluate(&part.aside, start.to_array());
        let within = ALL_STEPS * (norm * (seen.slack + p.abs().max(q.abs()))).max_element() + SAME;
        let is_inside = start.min_element() >= within && start.max_element() <= 1.0 - within;
        if !is_inside {
            return None;
        }
        let [(distance, _)] = evaluate(&[seen.along], part.whole(start));
        // A polynomial's derivatives are at most its degree times the largest difference of its coefficients.
        let turn = DEGREE as f64 * (seen.far - seen.near);
        let deep = seen.deep + turn * within * (part.size[0] + part.size[1]);
        Some([distance, deep, 2.0 * seen.cell.half * within * (part.size[0] + part.size[1])])
    }

    fn world_aside(&self) -> [DVec3; 2] {
        self.aside.map(|way| self.cells.axes.of_world(way))
    }
}

/// Returns whether no value of a range is 0, however far it is off.
#[inline(always)]
fn misses([low, high]: [f64; 2], slack: f64) -> bool {
    low > slack || high < -slack
}

impl SeenCell<'_> {
    /// Returns the range of distances of a part.
    #[cold]
    #[inline(never)]
    fn reach(&self, within: &Part) -> [f64; 2] {
        let [near, far] = range(&part(&self.along, within.start, within.size));
        [near - self.deep, far + self.deep]
    }
}
