//! Corners of a palette's hull that are moved, merged and rounded one by one.
//!
//! A corner x of a hull is free to move as long as the triangles that join it to the boundary of its neighborhood keep
//! all colors behind them: for a directed edge ab of that boundary and each color p, det(b − a, x − a, p − a) has one
//! sign. Around the edge, only the two outermost colors matter, so a corner has two half-spaces for each edge, and its
//! best place is a linear program in three unknowns. After Tan, Echevarria and Gingold, *Efficient palette-based
//! decomposition and recoloring of images via RGBXY-space geometry*, 2018, with half-spaces tangent to the colors
//! themselves instead of to the last hull.

use crate::mesh::Mesh;
use crate::program::{Half, least};
use crate::vector::{Point, add, cross, dot, scale, sub, unit};
use std::collections::HashMap;

/// What a palette has to enclose.
#[derive(Clone, Debug)]
pub(crate) struct Data {
    /// Corners of the hull of the colors and the prior colors.
    pub(crate) corners: Vec<Point>,
    /// A point inside.
    pub(crate) inside: Point,
    /// Colors that belong to each palette as they are.
    pub(crate) prior: Vec<Point>,
    /// Whether moves of all corners count the distance of a color outside from its nearest point of the hull, which takes
    /// longer, instead of that from the planes of facets, which is no larger.
    pub(crate) is_nearest: bool,
}

impl Data {
    /// Makes the hull of points and the prior colors; `None` if it has no volume.
    pub(crate) fn hull(&self, points: &[Point]) -> Option<Mesh> {
        Mesh::new(points, &self.prior)
    }
}

/// Returns a number that grows with the angle of a direction, from −2 to 2.
fn angle([x, y]: [f64; 2]) -> f64 {
    let part = y / (x.abs() + y.abs());
    if x >= 0.0 { part } else { 2.0_f64.copysign(y) - part }
}

/// Returns the half-spaces in which a corner may lie that is joined to a boundary: two for each edge, and the cube of
/// displayed colors. `None` if no corner there can enclose the colors.
pub(crate) fn tangents(boundary: &[[Point; 2]], data: &Data) -> Option<Vec<Half>> {
    let mut halves = Vec::with_capacity(2 * boundary.len() + 6);
    for [from, to] in boundary {
        let along = unit(sub(*to, *from))?;
        let inward = sub(data.inside, *from);
        let inward = unit(sub(inward, scale(along, dot(inward, along))))?;
        let aside = cross(along, inward);
        let mut ends: Option<[[f64; 2]; 2]> = None;
        for color in &data.corners {
            let seen = sub(*color, *from);
            let at = [dot(seen, inward), dot(seen, aside)];
            if at[0] * at[0] + at[1] * at[1] < 1e-14 {
                continue;
            }
            let [low, high] = ends.get_or_insert([at; 2]);
            if angle(at) < angle(*low) {
                *low = at;
            }
            if angle(at) > angle(*high) {
                *high = at;
            }
        }
        let [low, high] = ends?;
        let size = |[x, y]: [f64; 2]| (x * x + y * y).sqrt();
        // Colors on more than one side of every plane through the edge.
        if (low[0] * high[1] - low[1] * high[0]) < -1e-6 * size(low) * size(high) {
            return None;
        }
        for end in [low, high] {
            let direction = add(scale(inward, end[0] / size(end)), scale(aside, end[1] / size(end)));
            let normal = cross(direction, along);
            halves.push(Half { normal, offset: dot(normal, *from) });
        }
    }
    for c in 0..3 {
        let mut normal = [0.0; 3];
        normal[c] = 1.0;
        halves.push(Half { normal, offset: 255.0 });
        normal[c] = -1.0;
        halves.push(Half { normal, offset: 0.0 });
    }
    Some(halves)
}

/// Returns six times the gradient of the volume by a corner that is joined to a boundary.
pub(crate) fn growth(boundary: &[[Point; 2]], from: Point) -> Point {
    boundary.iter().fold([0.0; 3], |sum, [a, b]| add(sum, cross(sub(*a, from), sub(*b, from))))
}

/// Returns the place of a corner that is joined to a boundary, with the least volume, and that volume.
fn place(boundary: &[[Point; 2]], data: &Data) -> Option<(Point, f64)> {
    let halves = tangents(boundary, data)?;
    let growth = growth(boundary, data.inside);
    let point = least(growth, &halves)?;
    Some((point, dot(growth, sub(point, data.inside)) / 6.0))
}

/// Returns a corner that is joined to a boundary and stays where it is, and the volume; `None` if it does not enclose the
/// colors from there.
fn stay(point: Point, boundary: &[[Point; 2]], data: &Data) -> Option<(Point, f64)> {
    let encloses = tangents(boundary, data)?.iter().all(|half| dot(half.normal, point) <= half.offset + 1e-9);
    encloses.then(|| (point, dot(growth(boundary, data.inside), sub(point, data.inside)) / 6.0))
}

fn boundary_of(mesh: &Mesh, corners: &[usize], inside: Point) -> (Vec<[Point; 2]>, f64) {
    let (edges, volume) = mesh.link(corners, inside);
    (edges.into_iter().map(|edge| edge.map(|corner| mesh.corners[corner])).collect(), volume)
}

/// Moves corners one after the other, as long as the volume falls.
pub(crate) fn descend(mut mesh: Mesh, data: &Data, rounds: usize) -> Mesh {
    for _ in 0..rounds {
        let before = mesh.volume;
        for corner in 0..mesh.corners.len() {
            if !mesh.is_own.get(corner).is_some_and(|own| *own) {
                continue;
            }
            let (boundary, _) = boundary_of(&mesh, &[corner], data.inside);
            let Some((point, _)) = place(&boundary, data) else { continue };
            let mut points = mesh.without(&[corner]);
            points.push(point);
            // The moved corner may leave a dent, so the hull decides.
            if let Some(moved) = data.hull(&points)
                && moved.volume < mesh.volume - 1e-9
                && moved.count() == mesh.count()
            {
                mesh = moved;
            }
        }
        if before - mesh.volume < 1e-3 * before {
            break;
        }
    }
    mesh
}

/// A corner that takes the place of two, and the volume that it adds.
type Merged = Option<(Point, f64)>;

/// Places of merged corners, by the neighborhoods that they come from.
#[derive(Default)]
pub(crate) struct Merges(HashMap<Vec<[u64; 3]>, Merged>);

impl Merges {
    fn of(&mut self, mesh: &Mesh, edge: [usize; 2], data: &Data) -> Merged {
        let (boundary, volume) = boundary_of(mesh, &edge, data.inside);
        if boundary.len() < 3 {
            return None;
        }
        let bits = |point: Point| point.map(f64::to_bits);
        let mut key: Vec<[u64; 3]> = boundary.iter().flatten().map(|point| bits(*point)).collect();
        key.sort_unstable();
        key.extend(edge.map(|corner| bits(mesh.corners[corner])));
        // A prior corner stays where it is.
        let prior = edge.into_iter().find(|corner| !mesh.is_own[*corner]).map(|corner| mesh.corners[corner]);
        let placed = || match prior {
            Some(point) => stay(point, &boundary, data),
            None => place(&boundary, data),
        };
        *self.0.entry(key).or_insert_with(|| placed().map(|(point, after)| (point, after - volume)))
    }
}

/// Most corners for which several merges are compared by the hulls that they give.
const FEW: usize = 24;

/// Replaces two joined corners by one that adds the least volume; `chance`, from 0 to 1, may choose another of the best
/// ones. `None` if none can be merged.
pub(crate) fn merge(mesh: &Mesh, data: &Data, known: &mut Merges, chance: f64) -> Option<Mesh> {
    let mut merges: Vec<(f64, [usize; 2], Point)> = Vec::new();
    for edge in mesh.edges().into_iter().filter(|edge| edge.iter().any(|corner| mesh.is_own[*corner])) {
        if let Some((point, added)) = known.of(mesh, edge, data) {
            merges.push((added, edge, point));
        }
    }
    merges.sort_by(|a, b| a.0.total_cmp(&b.0));
    merges.truncate(if mesh.count() <= FEW { 8 } else { 1 });
    let merged = |(_, edge, point): &(f64, [usize; 2], Point)| {
        let mut points = mesh.without(edge);
        points.push(*point);
        data.hull(&points)
    };
    let mut hulls: Vec<Mesh> = merges.iter().filter_map(merged).collect();
    hulls.sort_by(|a, b| a.volume.total_cmp(&b.volume));
    // The k-th best is chosen with a probability that falls like 3⁻ᵏ.
    let mut choice = 0;
    let mut left = chance;
    while choice + 1 < hulls.len() && left > 2.0 / 3.0 {
        left = 3.0 * left - 2.0;
        choice += 1;
    }
    (choice < hulls.len()).then(|| hulls.swap_remove(choice))
}
