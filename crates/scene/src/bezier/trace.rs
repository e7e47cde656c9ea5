//! Rays against patches in f64, by subdivision alone.

use glam::DVec3;

use super::{Bicubic, PatchModel};
use crate::surface::Hit;
use crate::{Projector, Ray};

/// Halvings of u and v: they are known to 2⁻²⁶, and so is the point against the patch's size.
const HALVINGS: u32 = 26;
/// Slack of the test whether a part of a patch may hold the ray, against the patch's distance and size: rounding must
/// not open gaps between parts.
const SLACK: f64 = 1e-12;

/// A patch as the ray sees it: x and y across the ray, z along it.
struct Lined {
    shape: Bicubic,
    u: f64,
    v: f64,
    /// Number of halvings made.
    depth: u32,
}

/// Where a ray meets a patch first.
struct Met {
    distance: f64,
    place: [f64; 2],
}

/// The first point of the patches along a ray, between two distances.
///
/// A part of a patch lies in the hull of its control points: where that misses the ray, or lies behind what is
/// already found, so does the part. All else is quartered.
pub(super) fn trace(model: &PatchModel, projector: &Projector, ray: &Ray, [from, to]: [f64; 2]) -> Option<Hit> {
    let (right, up) = ray.direction.any_orthonormal_pair();
    let mut nearest: Option<(usize, Met)> = None;
    for (index, placed) in model.placed.iter().enumerate() {
        let lined = placed.shape.map(|point| {
            let offset = point - ray.origin;
            DVec3::new(offset.dot(right), offset.dot(up), offset.dot(ray.direction))
        });
        let limit = nearest.as_ref().map_or(to, |(_, met)| met.distance);
        if let Some(met) = meet(lined, from, limit) {
            nearest = Some((index, met));
        }
    }
    let (index, met) = nearest?;
    let placed = &model.placed[index];
    let [u, v] = met.place;
    let position = placed.shape.evaluate(u, v);
    // Open surfaces are seen from both sides: the normal of the side that is seen.
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

/// The first point of one patch on the ray, from a distance on and nearer than `limit`.
fn meet(shape: Bicubic, from: f64, limit: f64) -> Option<Met> {
    let (low, high) = shape.bounds();
    let slack = SLACK * (low.abs().max_element() + high.abs().max_element());
    let mut limit = limit;
    let mut found = None;
    let mut open = vec![Lined { shape, u: 0.0, v: 0.0, depth: 0 }];
    while let Some(part) = open.pop() {
        let (low, high) = part.shape.bounds();
        let misses = low.x > slack || low.y > slack || high.x < -slack || high.y < -slack;
        if misses || high.z < from || low.z >= limit {
            continue;
        }
        let width = 1.0 / f64::from(1_u32 << part.depth);
        if part.depth == HALVINGS {
            let distance = 0.5 * (low.z + high.z);
            if (from..limit).contains(&distance) {
                limit = distance;
                found = Some(Met { distance, place: [part.u + 0.5 * width, part.v + 0.5 * width] });
            }
            continue;
        }
        let mut quarters: Vec<(f64, Lined)> = part
            .shape
            .quarters()
            .into_iter()
            .enumerate()
            .map(|(quarter, shape)| {
                let (u, v) = (quarter % 2, quarter / 2);
                let place = |start: f64, half: usize| start + half as f64 * 0.5 * width;
                let near = shape.bounds().0.z;
                (near, Lined { shape, u: place(part.u, u), v: place(part.v, v), depth: part.depth + 1 })
            })
            .collect();
        // The nearest quarter is looked at first: it is popped last in, first out.
        quarters.sort_by(|a, b| b.0.total_cmp(&a.0));
        open.extend(quarters.into_iter().map(|(_, lined)| lined));
    }
    found
}
