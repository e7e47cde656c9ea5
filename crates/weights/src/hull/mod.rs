//! The convex hull of control colors, and the judgment of pixels against it.

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
    /// Points out of the hull.
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

/// Why a point is outside: a plane that has the whole hull on its inner side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness {
    /// Unit normal, from the nearest point of the hull toward the point.
    pub normal: [f64; 3],
    /// normal·v ≤ offset for every vertex v.
    pub offset: f64,
    /// The distance of the point from the hull.
    pub distance: f64,
}

/// The convex hull of control colors.
///
/// The combinatorics (dimension, vertices, which points share a facet) are exact for all finite f32 input, however
/// degenerate: every decision is the exact sign of a determinant. Planes and distances are f64 numbers, good to about
/// 10⁻¹² of the largest coordinate, 10⁻⁷ in the worst case of a hull that is nearly flat but not quite.
///
/// A hull without volume is handled as what it is: a point, a segment or a planar polygon. In every dimension
/// [`facets`](Hull::facets) are half-spaces whose intersection is the hull.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    dimension: Option<u8>,
    vertices: Vec<Rgb>,
    /// The facets, and after them the further planes that judge a thin hull.
    planes: Vec<Facet>,
    facets: usize,
    /// Where the nearest point lies if it lies inside no facet.
    edges: Vec<[Point; 2]>,
    /// How the distance follows from the excess, by plane.
    nearness: Vec<Nearness>,
    /// What passes most pixels quickly: of a hull with many facets inner polytopes with few, and last the hull itself.
    screens: Vec<Screen>,
    largest: f64,
}

/// Above this many facets a hull is screened by an inner polytope; above four times as many, by a larger one too.
const MANY_FACETS: usize = 96;

/// Up to this many pairs of facet and vertex, every facet is held against every vertex.
const MANY_PRODUCTS: usize = 1 << 25;

/// Computing normal·p − offset errs by less than this, relative to the largest coordinate: three products, three sums,
/// and a normal whose length is off by two roundings.
const EVALUATION: f64 = 16.0 * f64::EPSILON;

impl Hull {
    /// The hull of a set of points. Points that are not finite are left out.
    ///
    /// Duplicates and interior points cost little; see [`HullBuilder`] for points that come in pieces.
    #[must_use]
    pub fn new(points: &[Rgb]) -> Self {
        let mut builder = HullBuilder::new();
        builder.add(points);
        builder.finish()
    }

    /// From points as [`shape::sorted`] leaves them.
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
            // A guard may be the worst plane, and it is no facet.
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

    /// The extreme points, each once. A control color that is a mix of others is not among them.
    #[must_use]
    pub fn vertices(&self) -> &[Rgb] {
        &self.vertices
    }

    /// Half-spaces whose intersection is the hull; a planar hull has its plane from both sides and its sides.
    #[must_use]
    pub fn facets(&self) -> &[Facet] {
        &self.planes[..self.facets]
    }

    /// The edges, each once, from end to end; of a single point, one from it to itself.
    #[must_use]
    pub fn edges(&self) -> &[[[f64; 3]; 2]] {
        // The ring through two corners comes back along the same edge.
        if self.dimension == Some(1) { &self.edges[..1] } else { &self.edges }
    }

    /// 0 a point, 1 a segment, 2 a planar polygon, 3 a solid; `None` the empty hull.
    #[must_use]
    pub fn dimension(&self) -> Option<u8> {
        self.dimension
    }

    /// How far rounding may carry a pixel out of the hull: the margin for a chain of `mix_levels` nested Mix nodes.
    ///
    /// Each channel of a Mix is off the exact mix of its rounded operands by at most 1.5 ulp, each channel on its own,
    /// so the color by at most √3 times as much; mixing does not amplify what its operands bring along, so levels add
    /// up. A Blend rounds once and counts as one level. The ulp is that of the largest coordinate of the hull. Added to
    /// it is the error of the test itself (10⁻¹⁵ of that coordinate), which is all that is left for 0 levels.
    #[must_use]
    pub fn margin(&self, mix_levels: usize) -> f64 {
        let largest = self.largest as f32;
        // From below: the spacing above f32::MAX would be infinite.
        let ulp = f64::from(largest) - f64::from(largest.next_down().max(0.0));
        let ulp = if largest.to_bits() & 0x007f_ffff == 0 { 2.0 * ulp } else { ulp };
        1.5 * 3.0_f64.sqrt() * ulp * mix_levels as f64 + EVALUATION * self.largest
    }

    /// The distance of a point from the hull: negative inside a solid hull, where it is the distance to the surface.
    ///
    /// Outside it is the Euclidean distance to the nearest point of the hull, in every dimension; on a hull without
    /// volume it is 0 up to rounding. +∞ for the empty hull and for a point that is not finite.
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

    /// A plane between a point and the hull, as far from the hull as the point is; `None` if the point is inside, not
    /// finite, or the hull empty.
    #[must_use]
    pub fn witness(&self, point: [f64; 3]) -> Option<Witness> {
        let (facet, excess, projection) = self.project(point)?;
        if excess <= 0.0 {
            return None;
        }
        if self.holds(projection) {
            // The facet's own normal: that of a difference is the less exact the nearer the point is.
            let normal = facet.normal;
            return Some(Witness { normal, offset: dot(normal, projection), distance: excess });
        }
        let nearest = self.nearest_on_edges(point);
        let distance = length(sub(point, nearest));
        let normal = unit(sub(point, nearest));
        (distance > 0.0).then(|| Witness { normal, offset: dot(normal, nearest), distance })
    }

    /// The facet that a point exceeds most, by how much, and the point projected onto its plane.
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

    /// Whether a point is inside up to the error of the evaluation.
    fn holds(&self, point: Point) -> bool {
        let slack = EVALUATION * self.largest;
        self.planes.iter().all(|facet| facet.excess(point) <= slack)
    }

    /// The nearest point on the edges: it is the nearest of the hull, where no facet holds that.
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

/// The half-spaces with these normals that just hold all corners: the maximum is taken of the very expression that
/// judges pixels, so a corner is never outside.
fn supporting(normals: Vec<Point>, corners: &[Point]) -> Vec<Facet> {
    let reach = |normal| corners.iter().fold(f64::NEG_INFINITY, |reach: f64, &corner| reach.max(dot(normal, corner)));
    normals.into_iter().map(|normal| Facet { normal, offset: reach(normal) }).collect()
}

/// Facets of a solid: the normal is that of all triangles of the facet together.
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
    // The other corners are on the inner side of a facet up to the error of the evaluation.
    let open = |&normal: &Point| Facet { normal, offset: f64::NEG_INFINITY };
    let mut facets: Vec<Facet> = normals.iter().map(open).collect();
    for (vertices, facet) in &mesh.triangles {
        let Facet { normal, offset } = &mut facets[*facet as usize];
        *offset = triangle(vertices).iter().fold(*offset, |offset, &corner| offset.max(dot(*normal, corner)));
    }
    facets
}

/// Each normal and its opposite.
fn opposite(normals: &[Point; 3]) -> Vec<Point> {
    normals.iter().flat_map(|&n| [n, n.map(|v| -v)]).collect()
}

/// An orthonormal frame whose first axis is along a direction.
fn frame(direction: Point) -> [Point; 3] {
    let u = unit(direction);
    let smallest = (1..3).fold(0, |best, axis| if u[axis].abs() < u[best].abs() { axis } else { best });
    let mut axis = [0.0; 3];
    axis[smallest] = 1.0;
    let v = unit(cross(u, axis));
    [u, v, cross(u, v)]
}

/// Normals of a planar polygon: of its plane, both ways, and of its sides within the plane.
fn polygon_normals(corners: &[Point]) -> Vec<Point> {
    let fan = corners.windows(2).skip(1).map(|pair| area_vector(corners[0], pair[0], pair[1]));
    let plane = unit(fan.fold([0.0; 3], |sum, area| along(sum, 1.0, area)));
    let sides = ring(corners).into_iter().map(|[a, b]| unit(cross(sub(b, a), plane)));
    [plane, plane.map(|v| -v)].into_iter().chain(sides).collect()
}

/// The closed ring of edges through all corners; of one corner, the edge from it to itself.
fn ring(corners: &[Point]) -> Vec<[Point; 2]> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| [a, b]).collect()
}
