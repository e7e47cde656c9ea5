//! Collects millions of points, and reduces them to the few that can be vertices.

use trochoid_image::Rgb;

use super::shape::{Shape, sorted};
use super::vector::{Point, dot, side};
use super::{BoxHull, Facet, Hull};

/// Number of points that are filtered together.
const BLOCK: usize = 128;

/// Number of slots for recent points; a power of 2.
const RECENT: usize = 4096;

/// Number of points that are collected before the first reduction.
const FIRST_BATCH: usize = 1024;
/// Number up to which later batches grow.
const FULL_BATCH: usize = 32_768;

/// Collects points, in any number of parts, and makes their [`Hull`].
///
/// The memory stays close to that of the hull itself: collected points are repeatedly reduced to their exact extreme
/// points. The result is exact, because the hull of a union is the hull of the vertices of its parts. Between
/// reductions, points that are certainly interior, or were added recently, are dropped.
#[derive(Clone, Debug)]
pub struct HullBuilder {
    points: Vec<Rgb>,
    batch: usize,
    filter: Option<Filter>,
    recent: Vec<[u32; 3]>,
}

impl Default for HullBuilder {
    fn default() -> Self {
        Self::new()
    }
}

impl HullBuilder {
    /// Makes a builder without points.
    #[must_use]
    pub fn new() -> Self {
        // The bits of a NaN, which no finite point has.
        Self { points: Vec::new(), batch: FIRST_BATCH, filter: None, recent: vec![[u32::MAX; 3]; RECENT] }
    }

    /// Adds points, without those that are not finite.
    pub fn add(&mut self, points: &[Rgb]) {
        let mut channels = [[0.0_f32; BLOCK]; 3];
        for block in points.chunks(BLOCK) {
            for (x, point) in block.iter().enumerate() {
                for (channel, &v) in channels.iter_mut().zip(point) {
                    channel[x] = v;
                }
            }
            self.add_block(&channels, block.len());
        }
    }

    /// Adds the pixels of a row, given by channels, without those that are not finite.
    ///
    /// # Panics
    ///
    /// If the three channels differ in length.
    pub fn add_row(&mut self, r: &[f32], g: &[f32], b: &[f32]) {
        assert!(r.len() == g.len() && g.len() == b.len(), "channels of equal length");
        let mut channels = [[0.0_f32; BLOCK]; 3];
        for start in (0..r.len()).step_by(BLOCK) {
            let count = BLOCK.min(r.len() - start);
            for (channel, row) in channels.iter_mut().zip([r, g, b]) {
                channel[..count].copy_from_slice(&row[start..start + count]);
            }
            self.add_block(&channels, count);
        }
    }

    /// Adds all points that another builder has collected.
    pub fn merge(&mut self, other: &Self) {
        self.add(&other.points);
    }

    /// Returns the corners of the hull of all points, sorted.
    #[must_use]
    pub fn corners(mut self) -> Vec<Rgb> {
        self.reduce();
        self.points
    }

    /// Returns the hull of all points.
    #[must_use]
    pub fn finish(mut self) -> Hull {
        self.reduce();
        Hull::of_sorted(&self.points)
    }

    fn add_block(&mut self, channels: &[[f32; BLOCK]; 3], count: usize) {
        let interior = self.filter.as_ref().map_or([false; BLOCK], |filter| filter.interior(channels));
        for x in (0..count).filter(|&x| !interior[x]) {
            let point = [channels[0][x], channels[1][x], channels[2][x]];
            let bits = point.map(f32::to_bits);
            let mixed = bits.iter().fold(0_u32, |hash, &bits| (hash.rotate_left(11) ^ bits).wrapping_mul(0x9e37_79b1));
            let slot = &mut self.recent[mixed as usize >> (32 - RECENT.trailing_zeros())];
            if *slot != bits && point.iter().all(|v| v.is_finite()) {
                *slot = bits;
                self.points.push(point);
            }
        }
        if self.points.len() >= self.batch {
            self.reduce();
            self.batch = (self.batch * 4).min(FULL_BATCH).max(4 * self.points.len());
        }
    }

    /// Reduces the collected points to their extreme points, sorted.
    fn reduce(&mut self) {
        sorted(&mut self.points);
        let exact: Vec<Point> = self.points.iter().map(|p| p.map(f64::from)).collect();
        let shape = Shape::of(&exact);
        let mut kept: Vec<Rgb> = shape.vertices().iter().map(|&v| self.points[v as usize]).collect();
        sorted(&mut kept);
        self.points = kept;
        if matches!(shape, Shape::Polygon(_) | Shape::Solid(_)) {
            self.filter = Filter::new(&self.points);
        }
    }
}

/// Polytopes that are certainly inside of the hull of the points so far.
#[derive(Clone, Debug)]
struct Filter {
    /// Planes of a polytope with few facets, in f32 and moved inward; for a planar hull, its sides.
    planes: Vec<([f32; 3], f32)>,
    /// Facets of a larger polytope, for points outside of the first one.
    fine: Vec<Facet>,
    /// Three points in the plane of a planar hull.
    flat: Option<[Point; 3]>,
    /// Minimum distance inward for interior points.
    clear: f64,
    min: Rgb,
    max: Rgb,
}

impl Filter {
    /// Makes the polytopes of the extremes of sorted points; `None` if they have no interior.
    fn new(points: &[Rgb]) -> Option<Self> {
        let inner = Hull::of_sorted(&extremes(points, 1));
        // The extremes of a solid may be coplanar by chance. The filter is still correct then, since it checks
        // whether each point is in the plane.
        let (flat, sides) = match (inner.dimension(), inner.vertices()) {
            (Some(3), _) => (None, inner.facets()),
            (Some(2), &[a, b, c, ..]) => (Some([a, b, c].map(|p| p.map(f64::from))), inner.facets().get(2..)?),
            _ => return None,
        };
        // Within the box, rounding normal, offset and sums to f32 causes an error below 16 u of the largest coordinate,
        // unless products overflow or become subnormal.
        if !(1e-30..1e30).contains(&inner.largest) {
            return None;
        }
        let clear = 2e-6 * inner.largest;
        let narrow = |facet: &Facet| (facet.normal.map(|v| v as f32), (facet.offset - clear) as f32);
        let planes = sides.iter().map(narrow).collect();
        let fine = Hull::of_sorted(&extremes(points, 2));
        let fine = if fine.dimension() == Some(3) && flat.is_none() { fine.planes } else { Vec::new() };
        let bounds = BoxHull::new(inner.vertices());
        Some(Self { planes, fine, flat, clear, min: bounds.min(), max: bounds.max() })
    }

    /// Marks the points of a block that are certainly interior, hence not vertices. Never marks NaN.
    fn interior(&self, [r, g, b]: &[[f32; BLOCK]; 3]) -> [bool; BLOCK] {
        let mut largest = [f32::NEG_INFINITY; BLOCK];
        for (normal, offset) in &self.planes {
            for x in 0..BLOCK {
                let excess = normal[0] * r[x] + normal[1] * g[x] + normal[2] * b[x] - offset;
                largest[x] = if excess > largest[x] { excess } else { largest[x] };
            }
        }
        let within =
            |channel: &[f32; BLOCK], i: usize, x: usize| (channel[x] >= self.min[i]) & (channel[x] <= self.max[i]);
        let boxed: [bool; BLOCK] = std::array::from_fn(|x| within(r, 0, x) & within(g, 1, x) & within(b, 2, x));
        std::array::from_fn(|x| {
            let point = || [r[x], g[x], b[x]].map(f64::from);
            let caught = boxed[x] & (largest[x] < 0.0);
            match self.flat {
                Some([a, b, c]) => caught && side(a, b, c, point()) == 0.0,
                None => caught || boxed[x] && !self.fine.is_empty() && self.deep(point()),
            }
        })
    }

    fn deep(&self, point: Point) -> bool {
        self.fine.iter().all(|facet| facet.excess(point) < -self.clear)
    }
}

/// Returns the extreme points of a set, distinct and sorted, in directions spread over the sphere: the directions to
/// the integer points on the surface of the cube [−n, n]³, 26 for n = 1 and 98 for n = 2.
pub(super) fn extremes(points: &[Rgb], n: i32) -> Vec<Rgb> {
    let mut found = Vec::new();
    let side = 2 * n + 1;
    for code in 0..side * side * side {
        let direction = [code / (side * side), code / side % side, code % side].map(|digit| digit - n);
        if direction.iter().all(|v| v.abs() < n) {
            continue;
        }
        let direction: Point = direction.map(f64::from);
        let height = |point: &Rgb| dot(direction, point.map(f64::from));
        let mut best: Option<(Rgb, f64)> = None;
        for point in points {
            let height = height(point);
            if best.is_none_or(|(_, highest)| height > highest) {
                best = Some((*point, height));
            }
        }
        found.extend(best.map(|(point, _)| point));
    }
    sorted(&mut found);
    found
}
