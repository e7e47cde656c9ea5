//! Points of rays whose values come from their cells alone, without a sum over the waves.

use super::first::{FirstPoint, Shape};
use super::part::Part;
use super::search::{Search, SeenCell};
use crate::first_point::{NEARBY, across, bend_of};
use glam::{DVec2, DVec3};

/// How far any value may be off that is taken from a cell.
const MOST_OFF: f64 = 1e-3;
/// Rounding error of derivatives, relative to their size.
const ROUNDED: f64 = 1e-12;
/// Distance to the solution, in Newton steps, if 2h ≤ ½ in Kantorovich's theorem: (1 − √(1 − 2h))/h.
const REACHED: f64 = 1.18;
/// Newton steps up to which there is no other solution: (1 + √(1 − 2h))/h, and some reserve.
const ALONE: f64 = 8.0;

impl Search<'_> {
    /// Returns the only point that a part may have on the ray, if it certainly has one and its values are known well
    /// enough; `start` is the patch's point on the ray.
    ///
    /// Let T be the sea's points, under the footprint f of their rest points. The patch tells T and its derivatives up to
    /// the remainder, and thus the Newton step η from here to the ray's point and the inverse β of the derivatives across
    /// the ray. If 4·β·K·η ≤ 1 for a bound K of the change of T's derivatives, that point exists within 1.18·η, and no
    /// other one within 6.8·η (Kantorovich's theorem, with h ≤ ¼).
    ///
    /// The normal belongs to the derivatives under a constant footprint, T_u − f′·D_f for the displacement D. Since waves
    /// fade as exp(−k²f²/8), D_f = f/4·(D_uu + D_vv), which the patch tells nearly: with |f′| ≤ fλ/2 and |f″| ≤ fλ², the
    /// second derivative T_uu exceeds D_uu by 2f′·D_uf + f′²·D_ff + f″·D_f, and limits of the derivatives of D bound these.
    /// What lost waves add to f′·D_f is less than what they add to T_u, which the remainder contains.
    pub(super) fn nearly(&self, seen: &SeenCell<'_>, part: &Part, start: DVec2) -> Option<FirstPoint> {
        let (cell, cells, sea) = (seen.cell, self.cells, self.sea);
        let at = part.whole(start);
        let place = cell.rest(at);
        let patch = cell.patch_at(cells.level, at);
        let (footprint, change) = cells.footprints.change(place[0]);
        let limits = sea.limits().at(footprint * NEARBY);
        let (remainder, sides) = (&cell.remainder, at.map(|at| 2.0 * at - 1.0));
        let rounding = ROUNDED * (patch.by[0].length() + patch.by[1].length());
        let error = sides.map(|side| remainder.turn_at(side) / cell.half + rounding);

        let offset = patch.point - self.origin;
        let [p, q] = self.aside.map(|way| offset.dot(way));
        let [[a, b], [c, d]] = across(self.aside, patch.by);
        let inverse = libm::sqrt(a * a + b * b + c * c + d * d) / (a * d - b * c).abs();
        let wrong = libm::hypot(error[0], error[1]);
        let doubt = wrong * inverse;
        let inverse = inverse / (1.0 - doubt);
        let step = inverse * libm::hypot(p.abs() + seen.slacks[0], q.abs() + seen.slacks[1]);
        let bend = bend_of(&limits, change);
        // False for NaN.
        let is_found = doubt <= 0.5 && 4.0 * bend * inverse * step <= 1.0 && ALONE * step <= (1.0 - NEARBY) * footprint;
        let moved = REACHED * step;
        let border = start.min(1.0 - start) * DVec2::from(part.size) * (2.0 * cell.half);
        if !(is_found && moved < border.min_element()) {
            return None;
        }

        let [along_u, along_v] = patch.by.map(|by| by.dot(self.direction));
        let slope = libm::hypot(along_u, along_v) + wrong + bend * moved;
        let deep = seen.deep + slope * moved;

        // f² times this bounds the slope of f².
        let grows = cells.footprints.growth(place[0]).linear();
        let (square, [_, _, second, third, fourth, _]) = (footprint * footprint, limits);
        // Derivatives under a constant footprint change by their own second derivatives, and by f′·D_uf, in which the
        // footprint on the way is a tenth larger at most.
        let turned = (second + 0.3 * change.abs() * footprint * third) * moved;
        let bent = (remainder.bend_at(sides[0]) + remainder.bend_at(sides[1])) / (cell.half * cell.half)
            + square * grows * (0.25 * third + 0.3125 * grows * second + square * grows * fourth / 64.0);
        let fading = change * footprint / 4.0;
        let by = [patch.by[0] - patch.bend * fading, patch.by[1]];
        let off = [error[0] + remainder.even / cell.half + fading.abs() * bent + turned, error[1] + turned];
        let normal = by[1].cross(by[0]);
        let tilted = by[0].length() * off[1] + by[1].length() * off[0] + off[0] * off[1];
        // In an Euclidean space, unit vectors are no farther apart than 2·|a − b|/(|a| + |b|).
        let unit = tilted / (normal.length() - 0.5 * tilted);
        let (slope_variance, interpolated) = sea.limits().roughness(footprint)?;
        let rougher = interpolated + limits[1] * limits[1] * change.abs() * moved / footprint;
        let off = tilted.max(unit).max(rougher).max(deep + moved);
        // The normal's side must be certain as well. False for NaN.
        let is_close = off <= MOST_OFF && tilted < 0.5 * normal.length() && tilted < normal.dot(self.direction).abs();
        is_close.then(|| FirstPoint {
            distance: offset.dot(self.direction),
            rest: cells.axes.rest(place),
            shape: Some(Shape { normal: cells.axes.of_world(normal), slope_variance }),
            off,
            deep,
            moved,
            sheet: Some(part.sheet(cell, cells)),
        })
    }
}

/// A patch at a place.
pub(super) struct PatchPoint {
    /// Its point, in the cells' axes.
    pub(super) point: DVec3,
    /// Its derivatives by the rest point's u and v.
    pub(super) by: [DVec3; 2],
    /// The sum of its second derivatives by u and by v, in 1/m.
    pub(super) bend: DVec3,
}
