//! Tessellates patches for one camera.

use glam::DVec3;
use rayon::prelude::*;

use super::edge::{Scale, SharedCurve, whole};
use super::model::{MAX_SEGMENTS, PlacedPatch, Tessellation};
use super::stitch::Cut;
use super::{Bicubic, PatchModel};
use crate::channel::{NORMALS, RESTS};
use crate::surface::{Mesh, Topology};
use crate::{ChannelSet, Projector};

/// Most vertices of one model; beyond this limit the spacing is increased.
const MAX_VERTICES: f64 = 4e6;

/// Returns the largest distance of the triangles from the patches, in pixels: twice the tolerance, because of the
/// strips along edges that are cut differently from the inside. `None` if the document chooses the cuts, or if a
/// limit on vertices or segments was reached.
fn kept(tessellation: Tessellation, cuts: &[Cut], limited: bool) -> Option<f64> {
    let Tessellation::Adaptive { tolerance } = tessellation else { return None };
    let most = |cut: &Cut| cut.edges.iter().chain(&cut.inner).any(|count| *count >= MAX_SEGMENTS);
    (!limited && !cuts.iter().any(most)).then_some(2.0 * tolerance)
}

/// Returns the patches that a camera may see, and how to cut them.
fn cuts<'a>(
    model: &'a PatchModel,
    projector: &Projector,
    tessellation: Tessellation,
    tolerance: f64,
) -> (Vec<&'a PlacedPatch>, Vec<Cut>) {
    let seen: Vec<&PlacedPatch> =
        model.placed.iter().filter(|placed| !outside(projector, &placed.shape.points)).collect();
    let scale = Scale { projector, tolerance };
    let cuts = seen.par_iter().map(|placed| plan(&placed.shape, tessellation, &scale)).collect();
    (seen, cuts)
}

fn count(cuts: &[Cut]) -> f64 {
    cuts.iter().map(Cut::vertices).sum::<usize>() as f64
}

/// Returns the mesh of a model, and the number of its vertices without a normal.
pub(super) fn mesh(
    model: &PatchModel,
    projector: &Projector,
    tessellation: Tessellation,
    wanted: ChannelSet,
) -> (Mesh, usize) {
    let tolerance = match tessellation {
        Tessellation::Adaptive { tolerance } => tolerance / (projector.fineness * projector.fineness),
        Tessellation::Uniform { .. } => 1.0,
    };
    let (seen, mut cuts) = self::cuts(model, projector, tessellation, tolerance);
    let limited = count(&cuts) > MAX_VERTICES;
    if let Tessellation::Adaptive { .. } = tessellation {
        // The number of vertices is inverse to the tolerance, except for rounding up.
        let mut coarse = tolerance;
        while count(&cuts) > MAX_VERTICES && coarse < 1e6 {
            coarse *= (count(&cuts) / MAX_VERTICES).max(1.25);
            cuts = self::cuts(model, projector, tessellation, coarse).1;
        }
    }
    let parts: Vec<Part> =
        seen.par_iter().zip(&cuts).map(|(placed, cut)| part(placed, cut, projector, wanted)).collect();
    let mut mesh = Mesh::empty(model.level);
    let mut triangles = Vec::with_capacity(parts.iter().map(|part| part.triangles.len()).sum());
    let mut without = 0;
    for part in parts {
        let first = mesh.positions.len() as u32;
        let number = |[a, b, c]: [u32; 3]| {
            if model.turned { [a + first, c + first, b + first] } else { [a + first, b + first, c + first] }
        };
        triangles.extend(part.triangles.into_iter().map(number));
        mesh.positions.extend(part.positions);
        mesh.normals.extend(part.normals.iter().map(|normal| if model.turned { normal.map(|n| -n) } else { *normal }));
        mesh.rests.extend(part.rests.iter().map(|rest| [rest[0], rest[2]]));
        mesh.rest_heights.extend(part.rests.iter().map(|rest| rest[1]));
        mesh.uvs.extend(part.uvs);
        without += part.without;
    }
    mesh.tolerance = kept(tessellation, &cuts, limited);
    mesh.topology = Topology::Triangles(triangles);
    (mesh, without)
}

/// Returns how to cut one patch.
fn plan(shape: &Bicubic, tessellation: Tessellation, scale: &Scale<'_>) -> Cut {
    if let Tessellation::Uniform { segments } = tessellation {
        let segments = whole(f64::from(segments));
        return Cut { edges: [segments; 4], inner: [segments.max(2); 2] };
    }
    let edges = std::array::from_fn(|edge| SharedCurve::new(shape.edge(edge)).segments(scale));
    // A triangle over steps h and k is off by up to (h²·Puu + 2hk·Puv + k²·Pvv)/8; each term gets a third.
    let difference = |a: usize, b: usize| shape.points[b] - shape.points[a];
    let second = |stride: usize, starts: [usize; 8]| {
        let ends = starts.map(|s| (difference(s + stride, s + 2 * stride) - difference(s, s + stride)).length());
        6.0 * ends.into_iter().fold(0.0, f64::max)
    };
    let (uu, vv) = (second(1, [0, 1, 4, 5, 8, 9, 12, 13]), second(4, [0, 1, 2, 3, 4, 5, 6, 7]));
    let twist = (0..9).map(|cell| {
        let corner = cell / 3 * 4 + cell % 3;
        (difference(corner + 4, corner + 5) - difference(corner, corner + 1)).length()
    });
    let uv = 9.0 * twist.fold(0.0, f64::max);
    let pixels = scale.pixels_per_meter(&shape.points) / scale.tolerance;
    let [mut across, mut along] = [uu, vv].map(|bend| libm::sqrt(3.0 * bend * pixels / 8.0).max(2.0));
    let least = 0.75 * uv * pixels;
    if across * along < least {
        let grow = libm::sqrt(least / (across * along));
        (across, along) = (across * grow, along * grow);
    }
    Cut { edges, inner: [whole(across).max(2), whole(along).max(2)] }
}

/// Returns whether all points lie beyond one side of the view.
fn outside(projector: &Projector, points: &[DVec3]) -> bool {
    let half = projector.size.map(|size| 0.5 * size / projector.scale);
    let beyond = |side: &dyn Fn([f64; 3], f64) -> bool| {
        points.iter().all(|point| {
            let offset = *point - projector.position;
            let view = [offset.dot(projector.right), offset.dot(projector.up), offset.dot(projector.forward)];
            side(view, if projector.orthographic { 1.0 } else { view[2] })
        })
    };
    beyond(&|view, _| view[2] < 0.0)
        || beyond(&|view, depth| view[0] < -half[0] * depth)
        || beyond(&|view, depth| view[0] > half[0] * depth)
        || beyond(&|view, depth| view[1] < -half[1] * depth)
        || beyond(&|view, depth| view[1] > half[1] * depth)
}

/// Triangles of one patch.
struct Part {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    rests: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
    /// Number of vertices without a normal.
    without: usize,
}

fn part(placed: &PlacedPatch, cut: &Cut, projector: &Projector, wanted: ChannelSet) -> Part {
    let mut points = Vec::with_capacity(cut.vertices());
    let mut places = Vec::with_capacity(cut.vertices());
    for (edge, &count) in cut.edges.iter().enumerate() {
        let shared = SharedCurve::new(placed.shape.edge(edge));
        for index in 0..count {
            points.push(shared.point(index, count));
            let t = index as f64 / count as f64;
            places.push([[t, 0.0], [1.0, t], [1.0 - t, 1.0], [0.0, 1.0 - t]][edge]);
        }
    }
    places.extend(cut.inner_points());
    points.extend(cut.inner_points().map(|[u, v]| placed.shape.evaluate(u, v)));
    let relative = |point: DVec3| (point - projector.position).as_vec3().to_array();
    let mut without = 0;
    let mut normals = Vec::new();
    if wanted.intersects(NORMALS) {
        normals.extend(places.iter().map(|[u, v]| {
            let normal = placed.for_normals.normal(*u, *v);
            without += usize::from(normal == super::UnitNormal::None);
            normal.vector().as_vec3().to_array()
        }));
    }
    let rests = if wanted.intersects(RESTS) {
        places.iter().map(|[u, v]| relative(placed.rest.evaluate(*u, *v))).collect()
    } else {
        Vec::new()
    };
    let uvs = if wanted.intersects(ChannelSet::UV) {
        places.iter().map(|place| placed.uv(*place).map(|part| part as f32)).collect()
    } else {
        Vec::new()
    };
    let positions = points.into_iter().map(relative).collect();
    Part { positions, normals, rests, uvs, triangles: cut.triangles(), without }
}
