//! Intersects rays with patches in f64: by subdivision until a part can meet the ray only once, then by Newton's
//! method.

use glam::{DMat2, DVec2, DVec3};

use super::ball::SLACK;
use super::{Bicubic, PatchModel};
use crate::boxes::Line;
use crate::surface::Hit;
use crate::{Projector, Ray};

/// Number of bisections of u and v if nothing else finds the point: they are then known to 2⁻²⁶, and so is the point
/// relative to the patch's size.
const HALVINGS: u32 = 26;
/// A patch in the ray's coordinates: x and y across the ray, z along it.
struct RaySpacePatch {
    shape: Bicubic,
    u: f64,
    v: f64,
    /// Number of bisections made.
    depth: u32,
}

/// First point where a ray meets a patch.
struct PatchHit {
    distance: f64,
    place: [f64; 2],
}

/// Returns the first point of the patches along a ray, between two distances.
///
/// A part of a patch lies in the convex hull of its control points: if the hull misses the ray, or lies behind a
/// point already found, so does the part. Every other part is divided into quarters.
pub(super) fn trace(model: &PatchModel, projector: &Projector, ray: &Ray, [from, to]: [f64; 2]) -> Option<Hit> {
    let boxes = model.boxes.as_deref().filter(|_| model.ball.may_meet(ray, [from, to]))?;
    let mut near: Vec<usize> = Vec::new();
    boxes.visit(&Line::new(ray.origin, ray.direction), to, |index| {
        near.push(index);
        to
    });
    // Where patches meet, the first one in the list counts.
    near.sort_unstable();
    let (right, up) = ray.direction.any_orthonormal_pair();
    let mut nearest: Option<(usize, PatchHit)> = None;
    for index in near {
        let placed = &model.placed[index];
        let limit = nearest.as_ref().map_or(to, |(_, met)| met.distance);
        if !placed.ball.may_meet(ray, [from, limit]) {
            continue;
        }
        let mut lined = placed.shape;
        for point in &mut lined.points {
            let offset = *point - ray.origin;
            *point = DVec3::new(offset.dot(right), offset.dot(up), offset.dot(ray.direction));
        }
        if let Some(met) = meet(lined, from, limit) {
            nearest = Some((index, met));
        }
    }
    let (index, met) = nearest?;
    let placed = &model.placed[index];
    let [u, v] = met.place;
    let position = placed.shape.evaluate(u, v);
    // Open surfaces are visible from both sides, so use the normal of the visible side.
    let normal = placed.for_normals.normal(u, v).vector();
    let [along_u, along_v] = placed.shape.tangents(u, v);
    let side = along_u.cross(along_v).dot(ray.direction);
    let side = if side == 0.0 { normal.dot(ray.direction) } else { side };
    let normal = if side > 0.0 { -normal } else { normal };
    let rest = placed.rest.evaluate(u, v);
    Some(Hit {
        surface: 0,
        distance: met.distance,
        depth: (position - projector.position).dot(projector.forward),
        position,
        normal,
        rest,
        height: position.y - model.level,
        rest_distance: position.distance(rest),
        slope_variance: 0.0,
        jacobian: 1.0,
        trails: [0.0; 6],
        uv: placed.uv([u, v]),
    })
}

/// Returns the first point of one patch on the ray, from distance `from` on and nearer than `limit`.
fn meet(shape: Bicubic, from: f64, limit: f64) -> Option<PatchHit> {
    let (low, high) = shape.bounds();
    let slack = SLACK * (low.abs().max_element() + high.abs().max_element());
    let mut search = PatchSearch { slack, from, limit, found: None };
    search.look(&RaySpacePatch { shape, u: 0.0, v: 0.0, depth: 0 });
    search.found
}

/// A search for the first point of a patch on the ray.
struct PatchSearch {
    slack: f64,
    from: f64,
    /// Distance of the nearest point up to now.
    limit: f64,
    found: Option<PatchHit>,
}

impl PatchSearch {
    /// Searches a part of the patch, its nearest quarter first.
    fn look(&mut self, part: &RaySpacePatch) {
        let (low, high) = part.shape.bounds();
        let slack = self.slack;
        let misses = low.x > slack || low.y > slack || high.x < -slack || high.y < -slack;
        if misses || high.z < self.from || low.z >= self.limit {
            return;
        }
        let width = 1.0 / f64::from(1_u32 << part.depth);
        if part.depth == HALVINGS {
            self.take(0.5 * (low.z + high.z), [part.u + 0.5 * width, part.v + 0.5 * width]);
            return;
        }
        if let Some([u, v]) = crossing(&part.shape) {
            self.take(part.shape.evaluate(u, v).z, [part.u + u * width, part.v + v * width]);
            return;
        }
        let quarters = part.shape.quarters();
        let near = quarters.each_ref().map(|shape| shape.bounds().0.z);
        let mut order = [0, 1, 2, 3];
        // Of quarters at equal distances, the last one comes first.
        order.sort_by(|a, b| near[*a].total_cmp(&near[*b]).then(b.cmp(a)));
        for quarter in order {
            let place = |start: f64, half: usize| start + half as f64 * 0.5 * width;
            let (u, v) = (place(part.u, quarter % 2), place(part.v, quarter / 2));
            self.look(&RaySpacePatch { shape: quarters[quarter], u, v, depth: part.depth + 1 });
        }
    }

    /// Takes a point if it is the nearest one.
    fn take(&mut self, distance: f64, place: [f64; 2]) {
        if (self.from..self.limit).contains(&distance) {
            self.limit = distance;
            self.found = Some(PatchHit { distance, place });
        }
    }
}

/// Distance by which a point may lie outside of its part: rounding must not open gaps between parts.
const EDGE: f64 = 1e-9;

/// Most Newton steps to the point where a part crosses the ray, and the size of the last step.
const STEPS: usize = 8;
const LAST: f64 = 1e-14;

/// Returns where a part crosses the ray, x = y = 0, if it certainly does so only once: if its derivatives by u and v
/// are so close to their means, whose matrix is A, that |∂ − A| stays below the least singular value of A, the part
/// is one-to-one.
fn crossing(part: &Bicubic) -> Option<[f64; 2]> {
    let flat = part.points.map(|point| point.truncate());
    let along_u: [DVec2; 12] = std::array::from_fn(|i| 3.0 * (flat[i / 3 * 4 + i % 3 + 1] - flat[i / 3 * 4 + i % 3]));
    let along_v: [DVec2; 12] = std::array::from_fn(|i| 3.0 * (flat[i + 4] - flat[i]));
    let mean = |all: &[DVec2; 12]| all.iter().sum::<DVec2>() / 12.0;
    let (u, v) = (mean(&along_u), mean(&along_v));
    let most = |all: &[DVec2; 12], mean: DVec2| all.iter().map(|of| (of - mean).length_squared()).fold(0.0, f64::max);
    let off = most(&along_u, u) + most(&along_v, v);
    // The sum of the squared singular values is the sum of the squares, and their product is the determinant.
    let (sum, area) = (u.length_squared() + v.length_squared(), u.perp_dot(v));
    let greatest = (sum + libm::sqrt((sum * sum - 4.0 * area * area).max(0.0))) / 2.0;
    if off * greatest >= 0.8 * area * area {
        return None;
    }
    let mut place = DVec2::splat(0.5);
    for _ in 0..STEPS {
        let [along_u, along_v] = part.tangents(place.x, place.y).map(|along| along.truncate());
        let step = DMat2::from_cols(along_u, along_v).inverse() * part.evaluate(place.x, place.y).truncate();
        place = (place - step).clamp(DVec2::splat(-0.5), DVec2::splat(1.5));
        if step.abs().max_element() <= LAST {
            let is_inside = place.min_element() >= -EDGE && place.max_element() <= 1.0 + EDGE;
            return is_inside.then(|| place.clamp(DVec2::ZERO, DVec2::ONE).to_array());
        }
    }
    None
}
