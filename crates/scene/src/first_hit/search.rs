//! Finds the first point of a sea on a ray among its cells.

use super::bernstein::{DEGREE, Net, SIDE, evaluate, halves, range};
use super::cells::{Cell, SeaCells};
use crate::boxes::Line;
use crate::first_point::newton;
use crate::{Projector, Ray, SeaSurface};
use glam::{DMat2, DVec2, DVec3};
use trochoid_sea::Sample;

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum First {
    /// No point of the sea.
    Nothing,
    /// The first point: its distance in meters, its rest point x, z, and the sea there.
    At(f64, [f64; 2], Sample),
    /// It is not known: the effort was not enough, or the cells do not contain this part of the ray.
    Unknown,
}

/// Effort that a search may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Thoroughness {
    /// As much as most rays need; some rays, near contours above all, remain unknown.
    Quick,
    /// As much as nearly all rays need.
    Thorough,
}

impl Thoroughness {
    /// Returns the most parts of patches, and the most smaller cells, that a ray may take.
    fn most(self) -> (u32, u32) {
        match self {
            Self::Quick => (600, 3),
            Self::Thorough => (200_000, 2000),
        }
    }
}

/// Most times that a patch is halved, and the size of a part, in distances of the sea from its patch, from which halving
/// does not help any more; then a smaller cell replaces it.
const HALVINGS: u32 = 40;
const INDISTINCT: f64 = 8.0;
/// Most times that a smaller cell replaces a part of a smaller cell: each is smaller by the eighth power of its size.
const LEVELS: u32 = 6;
/// Change of the derivatives across a part, relative to their mean, below which the part is one-to-one.
const ONE_TO_ONE: f64 = 0.5;
/// Number of Newton steps on a patch before those on the sea itself.
const ON_PATCH: usize = 2;
/// Most steps of the projected iteration, which at least halve the distance each.
const STEPS: usize = 60;
/// Share by which the part of a ray that is searched is longer at both ends.
const WIDER: f64 = 1e-9;
/// Distance in a part at which two points count as one.
const SAME: f64 = 1e-9;

/// A part of a cell, in a ray's coordinates.
struct Part {
    /// Offsets aside of the ray, by its two directions, and distances along it.
    aside: [Net; 2],
    along: Net,
    /// Start and size in the cell's unit square.
    start: [f64; 2],
    size: [f64; 2],
    halvings: u32,
}

/// A search along one ray.
struct Search<'a> {
    cells: &'a SeaCells,
    sea: &'a SeaSurface,
    projector: &'a Projector,
    ray: &'a Ray,
    /// The ray in the cells' axes, and unit vectors at right angles to it, also in these axes.
    origin: DVec3,
    direction: DVec3,
    aside: [DVec3; 2],
    /// Distance of the first point known, and its rest point.
    end: f64,
    rest: Option<([f64; 2], Sample)>,
    /// Parts and smaller cells that may still be looked at.
    parts: u32,
    smaller: u32,
    /// Number of cells within which the current one lies.
    level: u32,
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
            return First::Unknown;
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
            end,
            rest: None,
            parts,
            smaller,
            level: 0,
            unknown: f64::INFINITY,
        };
        self.tree.visit(&Line::new(origin, direction), end, |cell| {
            search.cell(&self.cells[cell]);
            // What lies behind something unknown does not matter any more.
            if search.unknown < f64::INFINITY { search.unknown.min(search.end) } else { search.end }
        });
        match search.rest {
            _ if search.unknown <= search.end => First::Unknown,
            Some((rest, sample)) => First::At(search.end, rest, sample),
            None => First::Nothing,
        }
    }
}

impl Search<'_> {
    fn cell(&mut self, cell: &Cell) {
        let [p, q] = self.aside;
        let [p, q, along] = cell.seen_along(self.origin, [p, q, self.direction]);
        let whole = Part { aside: [p, q], along, start: [0.0; 2], size: [1.0; 2], halvings: HALVINGS };
        let mut open = vec![whole];
        while let Some(part) = open.pop() {
            if self.parts == 0 {
                self.unknown = self.unknown.min(range(&part.along)[0]);
                continue;
            }
            self.parts -= 1;
            match self.solutions(cell, &part) {
                Solutions::None => {}
                Solutions::One(guess) => self.one(cell, &part, guess),
                Solutions::Several { along_s } => {
                    let [first, second] = part.halved(along_s);
                    // The nearer half is looked at first.
                    let is_first = range(&first.along)[0] <= range(&second.along)[0];
                    open.extend(if is_first { [second, first] } else { [first, second] });
                }
                Solutions::Indistinct => self.again(cell, &part),
            }
        }
    }

    /// Replaces a part by a smaller cell of its own, whose remainder is smaller by far.
    fn again(&mut self, cell: &Cell, part: &Part) {
        let middle = cell.rest([0, 1].map(|axis| part.start[axis] + 0.5 * part.size[axis]));
        let half = cell.half * part.size[0].max(part.size[1]);
        let may = self.smaller > 0 && self.level < LEVELS;
        let smaller = if may { self.cells.smaller(middle, half, &cell.remainder) } else { None };
        match smaller {
            Some(cell) => {
                self.smaller -= 1;
                self.level += 1;
                self.cell(&cell);
                self.level -= 1;
            }
            None => self.unknown = self.unknown.min(range(&part.along)[0]),
        }
    }

    /// Returns how far the sea may lie from a part, along a direction.
    fn slack(cell: &Cell, way: DVec3) -> f64 {
        (0..3).map(|axis| way[axis].abs() * cell.remainder.off[axis]).sum()
    }

    fn solutions(&self, cell: &Cell, part: &Part) -> Solutions {
        let slack = self.aside.map(|way| Self::slack(cell, way));
        let mut is_distinct = part.halvings > 0;
        for (net, slack) in part.aside.iter().zip(slack) {
            let [low, high] = range(net);
            if low > slack || high < -slack {
                return Solutions::None;
            }
            is_distinct &= high - low > INDISTINCT * slack;
        }
        let deep = Self::slack(cell, self.direction);
        let [near, far] = range(&part.along);
        if near - deep > self.end || far + deep < 0.0 {
            return Solutions::None;
        }
        // Derivatives by s and t of the part, as columns: their mean J, and by how much Y·(J − mean), Y = J⁻¹, changes.
        let [p, q] = &part.aside;
        let mean = Derivatives::mean(p, q);
        let several = |along_s: bool| if is_distinct { Solutions::Several { along_s } } else { Solutions::Indistinct };
        let is_long = mean.x_axis.length_squared() > mean.y_axis.length_squared();
        let inverse = mean.inverse();
        if !inverse.is_finite() {
            return several(is_long);
        }
        let [by_s, by_t] = Derivatives::changes(p, q, &mean, &inverse);
        // The derivatives of the sea itself turn a little more.
        let norm = inverse.x_axis.abs() + inverse.y_axis.abs();
        let turn = 2.0 * cell.remainder.turn * (part.size[0] + part.size[1]);
        let change = by_s + by_t + norm * turn;
        let most = change.max_element();
        // False for NaN.
        let is_one_to_one = most <= ONE_TO_ONE;
        if !is_one_to_one {
            let (s, t) = (by_s.max_element(), by_t.max_element());
            return several(if s == t { is_long } else { s > t });
        }
        // G(x) = x − Y·F(x) contracts the part by `change`, so a point of the ray lies within change/2 of G(middle).
        let middle = DVec2::splat(0.5);
        let value = DVec2::new(evaluate_middle(p), evaluate_middle(q));
        let guess = middle - inverse * value;
        let reach = 0.5 * change + norm * slack[0].max(slack[1]) + SAME;
        let is_outside = (guess + reach).min_element() < 0.0 || (guess - reach).max_element() > 1.0;
        if is_outside { Solutions::None } else { Solutions::One(guess.to_array()) }
    }

    /// Finds the only point that a part may have on the ray.
    ///
    /// The part is one-to-one across the ray: G(x) = x − Y·F(x) contracts it by κ ≤ ½. Newton's method on the sea itself
    /// mostly finds the point within the part. If it finds one beyond the part, or none, there may still be one in the
    /// part, and then it is the fixed point of x ↦ clamp(G(x)), which contracts as well. For any x and δ = |clamp(G(x))
    /// − x|, that fixed point lies within 2δ of x; if it was a point of the ray, |G(x) − x| could be 3δ at most.
    fn one(&mut self, cell: &Cell, part: &Part, guess: [f64; 2]) {
        let place =
            |local: DVec2| cell.rest([0, 1].map(|axis| part.start[axis] + part.size[axis] * local.to_array()[axis]));
        // A step on the patch costs much less than one on the sea.
        let mut start = DVec2::from(guess).clamp(DVec2::ZERO, DVec2::ONE);
        for _ in 0..ON_PATCH {
            let [(p, by_p), (q, by_q)] = part.aside.each_ref().map(|net| evaluate(net, start.to_array()));
            let ways = DMat2::from_cols(DVec2::new(by_p[0], by_q[0]), DVec2::new(by_p[1], by_q[1]));
            let to = start - ways.inverse() * DVec2::new(p, q);
            if !to.is_finite() {
                break;
            }
            start = to.clamp(DVec2::ZERO, DVec2::ONE);
        }
        let from = self.cells.axes.rest(place(start));
        let found = newton(self.sea, self.projector, self.ray, self.world_aside(), from);
        let mut near = start;
        if let Some((distance, rest, point)) = found {
            let own = self.cells.axes.direction(DVec3::new(
                rest[0] - self.cells.axes.eye.x,
                0.0,
                rest[1] - self.cells.axes.eye.z,
            ));
            let local = [own.x, own.z];
            let local = DVec2::from_array([0, 1].map(|axis| {
                let unit = 0.5 + 0.5 * (local[axis] - cell.middle[axis]) / cell.half;
                (unit - part.start[axis]) / part.size[axis]
            }));
            // Wherever it is, it is a point of the sea on the ray.
            if distance >= 0.0 && distance < self.end && (local - 0.5).abs().max_element() < 2.0 {
                (self.end, self.rest) = (distance, Some((rest, point.precise.sample)));
            }
            if (local - 0.5).abs().max_element() <= 0.5 + SAME {
                return;
            }
            near = local.clamp(DVec2::ZERO, DVec2::ONE);
        }
        let [p, q] = &part.aside;
        let mean = Derivatives::mean(p, q);
        let inverse = mean.inverse();
        let slack = self.aside.map(|way| Self::slack(cell, way));
        let norm = inverse.x_axis.abs() + inverse.y_axis.abs();
        let off = (norm * slack[0].max(slack[1])).max_element();
        for _ in 0..STEPS {
            let at = near.to_array();
            let step = inverse * DVec2::new(evaluate(p, at).0, evaluate(q, at).0);
            let to = (near - step).clamp(DVec2::ZERO, DVec2::ONE);
            let delta = (to - near).abs().max_element();
            if step.abs().max_element() > 3.0 * (delta + off) + off {
                return;
            }
            if delta <= SAME {
                break;
            }
            near = to;
        }
        // The point is too close to the part's border to tell, and Newton's method has not found it.
        let accepted = self.rest.is_some() && found.is_some_and(|(distance, ..)| distance <= self.end * (1.0 + SAME));
        if !accepted {
            self.again(cell, part);
        }
    }

    fn world_aside(&self) -> [DVec3; 2] {
        let [x, z] = self.cells.axes.heading;
        self.aside.map(|way| DVec3::new(way.x * x - way.z * z, way.y, way.x * z + way.z * x))
    }
}

/// Returns the value in the middle: the mean of the coefficients, weighted by the binomial ones.
fn evaluate_middle(net: &Net) -> f64 {
    const WEIGHTS: [f64; SIDE] = [1.0, 8.0, 28.0, 56.0, 70.0, 56.0, 28.0, 8.0, 1.0];
    let mut rows = [0.0; SIDE];
    for (row, weight) in net.iter().zip(WEIGHTS) {
        for (total, value) in rows.iter_mut().zip(row) {
            *total += weight * value;
        }
    }
    rows.iter().zip(WEIGHTS).map(|(value, weight)| value * weight).sum::<f64>() / 65536.0
}

/// Derivatives of two components over a part.
struct Derivatives;

impl Derivatives {
    /// Returns their means as columns.
    fn mean(p: &Net, q: &Net) -> DMat2 {
        let along_s = |net: &Net| (0..SIDE).map(|j| net[DEGREE][j] - net[0][j]).sum::<f64>() / SIDE as f64;
        let along_t = |net: &Net| net.iter().map(|row| row[DEGREE] - row[0]).sum::<f64>() / SIDE as f64;
        DMat2::from_cols(DVec2::new(along_s(p), along_s(q)), DVec2::new(along_t(p), along_t(q)))
    }

    /// Returns by how much Y times the derivatives differ from the unit vectors: the largest sizes of both rows, for
    /// the derivatives by s and by t. Derivatives are combinations of the differences of coefficients.
    fn changes(p: &Net, q: &Net, mean: &DMat2, inverse: &DMat2) -> [DVec2; 2] {
        let (mut by_s, mut by_t) = ([[0.0_f64; SIDE]; 2], [[0.0_f64; SIDE]; 2]);
        let [a, b, c, d] = [inverse.x_axis.x, inverse.y_axis.x, inverse.x_axis.y, inverse.y_axis.y];
        let degree = DEGREE as f64;
        for i in 0..DEGREE {
            for j in 0..SIDE {
                let x = degree * (p[i + 1][j] - p[i][j]) - mean.x_axis.x;
                let y = degree * (q[i + 1][j] - q[i][j]) - mean.x_axis.y;
                by_s[0][j] = by_s[0][j].max((a * x + b * y).abs());
                by_s[1][j] = by_s[1][j].max((c * x + d * y).abs());
            }
        }
        for i in 0..SIDE {
            for j in 0..DEGREE {
                let x = degree * (p[i][j + 1] - p[i][j]) - mean.y_axis.x;
                let y = degree * (q[i][j + 1] - q[i][j]) - mean.y_axis.y;
                by_t[0][j] = by_t[0][j].max((a * x + b * y).abs());
                by_t[1][j] = by_t[1][j].max((c * x + d * y).abs());
            }
        }
        let most = |rows: [[f64; SIDE]; 2]| DVec2::from_array(rows.map(|row| row.into_iter().fold(0.0, f64::max)));
        [most(by_s), most(by_t)]
    }
}

impl Part {
    fn halved(&self, along_s: bool) -> [Self; 2] {
        let [p, q] = self.aside.each_ref().map(|net| halves(net, along_s));
        let along = halves(&self.along, along_s);
        let axis = usize::from(!along_s);
        let mut size = self.size;
        size[axis] *= 0.5;
        [0, 1].map(|half| {
            let mut start = self.start;
            start[axis] += size[axis] * half as f64;
            Self { aside: [p[half], q[half]], along: along[half], start, size, halvings: self.halvings - 1 }
        })
    }
}
