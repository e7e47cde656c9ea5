//! Convex hulls of control colors, against which pixels are judged.

mod box_hull;
mod builder;
mod judge;
mod nearness;
mod screen;
mod shape;
mod solid;
mod thin;
mod vector;

use trochoid_image::Rgb;

pub use box_hull::BoxHull;
pub use builder::HullBuilder;
use nearness::Nearness;
use screen::Screen;
use shape::{Shape, nearest_on_segment};
use solid::Mesh;
use vector::{Point, along, area_vector, cross, dot, length, sub, unit};

/// A half-space {p : normal·p ≤ offset}, with a normal of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Outward normal.
    pub normal: [f64; 3],
    /// The largest normal·v over the vertices.
    pub offset: f64,
}

impl Facet {
    /// The signed distance of p from the plane, positive outside.
    #[inline(always)]
    fn excess(&self, p: Point) -> f64 {
        dot(self.normal, p) - self.offset
    }
}

/// Proof that a point is outside of a hull: a plane between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness {
    /// Unit normal, from the nearest point of the hull toward the point.
    pub normal: [f64; 3],
    /// Offset of the plane: normal·v ≤ offset for every vertex v.
    pub offset: f64,
    /// Distance of the point from the hull.
    pub distance: f64,
}

/// The convex hull of control colors.
///
/// The combinatorics (dimension, vertices, which points share a facet) are exact for all finite f32 input, however
/// degenerate: every decision is the exact sign of a determinant. Planes and distances are f64 numbers, accurate to
/// about 10⁻¹² of the largest coordinate, 10⁻⁷ in the worst case of a hull that is nearly, but not exactly, flat.
///
/// A hull without volume is a point, a segment or a planar polygon. In every dimension
/// [`facets`](Hull::facets) are half-spaces whose intersection is the hull.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    dimension: Option<u8>,
    vertices: Vec<Rgb>,
    /// The facets, followed by the additional planes for thin hulls.
    planes: Vec<Facet>,
    facets: usize,
    /// Edges, which contain the nearest point of the hull if no facet does.
    edges: Vec<[Point; 2]>,
    /// Bounds of the distance by the excess, by plane.
    nearness: Vec<Nearness>,
    /// Fast tests that pass most pixels: for a hull with many facets, inner polytopes with few, and last the hull
    /// itself.
    screens: Vec<Screen>,
    largest: f64,
}

/// Number of facets above which a hull has an inner polytope as a screen; above four times as many, also a larger one.
const MANY_FACETS: usize = 96;

/// Number of pairs of facet and vertex up to which every facet is compared with every vertex.
const MANY_PRODUCTS: usize = 1 << 25;

/// Error bound of normal·p − offset, relative to the largest coordinate: three products, three sums, and the two
/// roundings in the length of the normal.
const EVALUATION: f64 = 16.0 * f64::EPSILON;

impl Hull {
    /// Makes the hull of a set of points, without those that are not finite.
    ///
    /// Duplicates and interior points take little time; use [`HullBuilder`] for points that come in several parts.
    #[must_use]
    pub fn new(points: &[Rgb]) -> Self {
        let mut builder = HullBuilder::new();
        builder.add(points);
        builder.finish()
    }

    /// Makes the hull of points that [`shape::sorted`] has sorted.
    fn of_sorted(points: &[Rgb]) -> Self {
        let exact: Vec<Point> = points.iter().map(|p| p.map(f64::from)).collect();
        let shape = Shape::of(&exact);
        let vertices = shape.vertices();
        let corners: Vec<Point> = vertices.iter().map(|&v| exact[v as usize]).collect();
        let (dimension, facets, edges) = match &shape {
            Shape::Empty => (None, Vec::new(), Vec::new()),
            Shape::Point => {
                let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                (Some(0), supporting(opposite(&axes), &corners), ring(&corners))
            }
            Shape::Segment(_) => {
                let frame = frame(sub(corners[1], corners[0]));
                (Some(1), supporting(opposite(&frame), &corners), ring(&corners))
            }
            Shape::Polygon(_) => (Some(2), supporting(polygon_normals(&corners), &corners), ring(&corners)),
            Shape::Solid(mesh) => {
                let edges = mesh.edges.iter().map(|edge| edge.map(|v| exact[v as usize])).collect();
                (Some(3), solid_facets(mesh, &exact, &corners), edges)
            }
        };
        let vertices: Vec<Rgb> = vertices.iter().map(|&v| points[v as usize]).collect();
        let largest = corners.iter().flatten().fold(0.0, |largest: f64, v| largest.max(v.abs()));
        let count = facets.len();
        let mut planes = facets;
        planes.extend(dimension.map_or(Vec::new(), |dimension| thin::guards(dimension, &planes, &corners)));
        let nearness = match &shape {
            // The worst plane may be a guard, which is not a facet.
            _ if planes.len() > count => vec![Nearness::NONE; planes.len()],
            Shape::Empty => Vec::new(),
            Shape::Point | Shape::Segment(_) => Nearness::of_box(&planes, &corners, largest),
            Shape::Polygon(_) => Nearness::of_polygon(&planes, &corners, largest),
            Shape::Solid(mesh) => Nearness::of_solid(mesh, &planes, &exact, largest),
        };
        let bounds = BoxHull::new(&vertices);
        // The polytope of n extremes has less than 2n facets, so the recursion ends.
        let inner = [(1, MANY_FACETS), (2, 4 * MANY_FACETS)].into_iter().filter(|&(_, least)| count > least);
        let inner = inner.map(|(n, _)| Self::of_sorted(&builder::extremes(&vertices, n)));
        let inner = inner.filter_map(|inner| Screen::new(&inner.planes, &inner.nearness, &bounds, largest));
        let screens = inner.chain(Screen::new(&planes, &nearness, &bounds, largest)).collect();
        Self { dimension, vertices, planes, facets: count, edges, nearness, screens, largest }
    }

    /// Returns the extreme points, each once. Control colors that are mixes of others are not among them.
    #[must_use]
    pub fn vertices(&self) -> &[Rgb] {
        &self.vertices
    }

    /// Returns half-spaces whose intersection is the hull; a planar hull has two for its plane, and one for each side.
    #[must_use]
    pub fn facets(&self) -> &[Facet] {
        &self.planes[..self.facets]
    }

    /// Returns the edges, each once, by their ends; a single point has one edge from it to itself.
    #[must_use]
    pub fn edges(&self) -> &[[[f64; 3]; 2]] {
        // The ring through two corners contains their edge twice.
        if self.dimension == Some(1) { &self.edges[..1] } else { &self.edges }
    }

    /// Returns the dimension: 0 for a point, 1 for a segment, 2 for a planar polygon, 3 for a solid; `None` for the
    /// empty hull.
    #[must_use]
    pub fn dimension(&self) -> Option<u8> {
        self.dimension
    }

    /// Returns the margin for a chain of `mix_levels` nested Mix nodes: how far rounding may move a pixel out of the
    /// hull.
    ///
    /// Each channel of a Mix differs from the exact mix of its rounded operands by at most 1.5 ulp, so the color
    /// differs by at most √3 times as much. Mixing does not amplify the errors of its operands, so the levels add up.
    /// A Blend rounds once and counts as one level. The ulp is that of the largest coordinate of the hull. The margin
    /// also includes the error of the test itself (10⁻¹⁵ of that coordinate), which is the whole margin for 0 levels.
    #[must_use]
    pub fn margin(&self, mix_levels: usize) -> f64 {
        let largest = self.largest as f32;
        // The spacing below the number, since the one above f32::MAX would be infinite.
        let ulp = f64::from(largest) - f64::from(largest.next_down().max(0.0));
        let ulp = if largest.to_bits() & 0x007f_ffff == 0 { 2.0 * ulp } else { ulp };
        1.5 * 3.0_f64.sqrt() * ulp * mix_levels as f64 + EVALUATION * self.largest
    }

    /// Returns the signed distance of a point from the hull.
    ///
    /// Outside it is the Euclidean distance to the nearest point of the hull, in every dimension. Inside of a solid
    /// hull it is the negative distance to the surface; on a hull without volume it is 0 up to rounding. It is +∞ for
    /// the empty hull and for a point that is not finite.
    #[must_use]
    pub fn signed_distance(&self, point: [f64; 3]) -> f64 {
        let Some((_, excess, projection)) = self.project(point) else {
            return f64::INFINITY;
        };
        if excess <= 0.0 || self.holds(projection) {
            return excess;
        }
        length(sub(point, self.nearest_on_edges(point)))
    }

    /// Returns a plane between a point and the hull that touches the hull; `None` if the point is inside or not
    /// finite, or the hull is empty.
    #[must_use]
    pub fn witness(&self, point: [f64; 3]) -> Option<Witness> {
        let (facet, excess, projection) = self.project(point)?;
        if excess <= 0.0 {
            return None;
        }
        if self.holds(projection) {
            // The normal of the facet: a normal from the difference would be less accurate for nearer points.
            let normal = facet.normal;
            return Some(Witness { normal, offset: dot(normal, projection), distance: excess });
        }
        let nearest = self.nearest_on_edges(point);
        let distance = length(sub(point, nearest));
        let normal = unit(sub(point, nearest));
        (distance > 0.0).then(|| Witness { normal, offset: dot(normal, nearest), distance })
    }

    /// Returns the plane that a point exceeds most, the excess, and the projection of the point onto that plane.
    fn project(&self, point: Point) -> Option<(&Facet, f64, Point)> {
        if !point.iter().all(|v| v.is_finite()) {
            return None;
        }
        let (facet, excess) = self.worst_facet(point)?;
        Some((facet, excess, along(point, -excess, facet.normal)))
    }

    fn worst_facet(&self, point: Point) -> Option<(&Facet, f64)> {
        let (first, rest) = self.planes.split_first()?;
        let mut worst = (first, first.excess(point));
        for facet in rest {
            let excess = facet.excess(point);
            if excess > worst.1 {
                worst = (facet, excess);
            }
        }
        Some(worst)
    }

    /// Whether a point is inside, up to the error of the evaluation.
    fn holds(&self, point: Point) -> bool {
        let slack = EVALUATION * self.largest;
        self.planes.iter().all(|facet| facet.excess(point) <= slack)
    }

    /// Returns the nearest point on the edges. It is the nearest point of the hull if no facet contains that one.
    fn nearest_on_edges(&self, point: Point) -> Point {
        let mut best = ([f64::INFINITY; 3], f64::INFINITY);
        for &[a, b] in &self.edges {
            let nearest = nearest_on_segment(point, a, b);
            let distance = length(sub(point, nearest));
            if distance < best.1 {
                best = (nearest, distance);
            }
        }
        best.0
    }
}

/// Returns the smallest half-spaces with given normals that contain all corners. The maximum is taken over the same
/// expression that judges pixels, so a corner is never outside.
fn supporting(normals: Vec<Point>, corners: &[Point]) -> Vec<Facet> {
    let reach = |normal| corners.iter().fold(f64::NEG_INFINITY, |reach: f64, &corner| reach.max(dot(normal, corner)));
    normals.into_iter().map(|normal| Facet { normal, offset: reach(normal) }).collect()
}

/// Returns the facets of a solid, each with the normal of all of its triangles together.
fn solid_facets(mesh: &Mesh, points: &[Point], corners: &[Point]) -> Vec<Facet> {
    let mut areas = vec![[0.0; 3]; mesh.facets];
    let triangle = |vertices: &[u32; 3]| vertices.map(|v| points[v as usize]);
    for (vertices, facet) in &mesh.triangles {
        let [a, b, c] = triangle(vertices);
        areas[*facet as usize] = along(areas[*facet as usize], 1.0, area_vector(a, b, c));
    }
    let normals: Vec<Point> = areas.into_iter().map(unit).collect();
    if mesh.facets.saturating_mul(corners.len()) <= MANY_PRODUCTS {
        return supporting(normals, corners);
    }
    // All other corners are inside, up to the error of the evaluation.
    let open = |&normal: &Point| Facet { normal, offset: f64::NEG_INFINITY };
    let mut facets: Vec<Facet> = normals.iter().map(open).collect();
    for (vertices, facet) in &mesh.triangles {
        let Facet { normal, offset } = &mut facets[*facet as usize];
        *offset = triangle(vertices).iter().fold(*offset, |offset, &corner| offset.max(dot(*normal, corner)));
    }
    facets
}

/// Returns each normal and its opposite.
fn opposite(normals: &[Point; 3]) -> Vec<Point> {
    normals.iter().flat_map(|&n| [n, n.map(|v| -v)]).collect()
}

/// Returns an orthonormal frame with its first axis along a direction.
fn frame(direction: Point) -> [Point; 3] {
    let u = unit(direction);
    let smallest = (1..3).fold(0, |best, axis| if u[axis].abs() < u[best].abs() { axis } else { best });
    let mut axis = [0.0; 3];
    axis[smallest] = 1.0;
    let v = unit(cross(u, axis));
    [u, v, cross(u, v)]
}

/// Returns the normals of a planar polygon: both normals of its plane, and those of its sides within the plane.
fn polygon_normals(corners: &[Point]) -> Vec<Point> {
    let fan = corners.windows(2).skip(1).map(|pair| area_vector(corners[0], pair[0], pair[1]));
    let plane = unit(fan.fold([0.0; 3], |sum, area| along(sum, 1.0, area)));
    let sides = ring(corners).into_iter().map(|[a, b]| unit(cross(sub(b, a), plane)));
    [plane, plane.map(|v| -v)].into_iter().chain(sides).collect()
}

/// Returns the closed ring of edges through all corners; for a single corner, the edge from it to itself.
fn ring(corners: &[Point]) -> Vec<[Point; 2]> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| [a, b]).collect()
}

/// Returns the surface of the hull of points that span space: the indices of its corners, and triangles of these,
/// counterclockwise as seen from outside, by their place among the corners. Facets of more than three corners are several
/// triangles. `None` if the points do not span space, or one is not finite.
///
/// ```
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.1, 0.1, 0.1]];
/// let (corners, triangles) = trochoid_weights::surface(&points).ok_or("flat")?;
/// assert_eq!((corners, triangles.len()), (vec![0, 1, 2, 3], 4));
/// # Ok::<(), &str>(())
/// ```
#[must_use]
pub fn surface(points: &[[f64; 3]]) -> Option<(Vec<usize>, Vec<[usize; 3]>)> {
    if points.iter().flatten().any(|v| !v.is_finite()) {
        return None;
    }
    let mut order: Vec<usize> = (0..points.len()).collect();
    let key = |index: usize| points[index].map(|v| v + 0.0);
    order.sort_by(|a, b| {
        key(*a).iter().zip(key(*b)).map(|(a, b)| a.total_cmp(&b)).find(|order| order.is_ne()).unwrap_or(a.cmp(b))
    });
    order.dedup_by(|a, b| key(*a) == key(*b));
    let distinct: Vec<Point> = order.iter().map(|index| key(*index)).collect();
    let Shape::Solid(mesh) = Shape::of(&distinct) else { return None };
    // Triangles of one facet may meet in its middle, at points that are not extreme.
    let mut used: Vec<u32> = mesh.triangles.iter().flat_map(|(triangle, _)| *triangle).collect();
    used.sort_unstable_by_key(|point| order[*point as usize]);
    used.dedup();
    let mut place = vec![0; distinct.len()];
    used.iter().enumerate().for_each(|(at, point)| place[*point as usize] = at);
    let corners = used.iter().map(|point| order[*point as usize]).collect();
    let triangles = mesh.triangles.iter().map(|(triangle, _)| triangle.map(|point| place[point as usize])).collect();
    Some((corners, triangles))
}
