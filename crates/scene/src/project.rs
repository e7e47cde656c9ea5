//! Turns meshes into triangles on the picture: fixed-point projection, clipping and binning.

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;
use rayon::prelude::*;
use trochoid_image::Window;

use crate::Projector;
use crate::surface::{Mesh, Topology};

/// Nearest depth that a perspective camera sees, in meters.
const NEAR_M: f64 = 1e-4;
/// Size of a bin, in pixels: wide and low, like the far sea.
pub(crate) const BIN: [i64; 2] = [64, 16];
/// Number of primitives that one task projects.
const TASK: usize = 1 << 14;

/// The fixed-point raster of a picture.
///
/// Coordinates are integer multiples of 2^−`bits` pixels below 2^29 in size, so that edge functions are exact in i64:
/// differences below 2^30, products below 2^60. Exact edge functions leave no cracks between triangles and count no
/// sample twice.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Raster {
    pub(crate) bits: u32,
    /// Largest coordinate, in pixels.
    limit: f64,
}

impl Raster {
    pub(crate) fn new(projector: &Projector) -> Self {
        let side = projector.size[0].max(projector.size[1]);
        // Room for twice the picture to each side of its origin.
        let whole = libm::log2(side * 4.0).ceil() as u32;
        let bits = (28 - whole.min(24)).min(12);
        Self { bits, limit: f64::from(1_u32 << (28 - bits)) }
    }

    /// Returns the smallest difference of coordinates, in pixels.
    pub(crate) fn step(self) -> f64 {
        1.0 / f64::from(1_u32 << self.bits)
    }

    /// Converts pixels to fixed point, rounding to nearest.
    pub(crate) fn fix(self, pixels: f64) -> i64 {
        self.whole(pixels) as i64
    }

    #[inline(always)]
    fn whole(self, pixels: f64) -> f64 {
        (pixels * f64::from(1_u32 << self.bits)).round_ties_even()
    }
}

/// A vertex on the picture: x and y in fixed point, and a key that is linear over a triangle's picture and grows
/// toward the camera (1/depth in perspective, −depth otherwise).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ScreenVertex {
    pub(crate) x: i32,
    pub(crate) y: i32,
    pub(crate) key: f32,
}

/// Sides of the view volume beyond which a point lies.
mod outside {
    pub(crate) const LEFT: u8 = 1;
    pub(crate) const RIGHT: u8 = 2;
    pub(crate) const TOP: u8 = 4;
    pub(crate) const BOTTOM: u8 = 8;
    pub(crate) const NEAR: u8 = 16;
    /// Not representable in fixed point; such triangles are clipped.
    pub(crate) const LIMIT: u8 = 32;
}

/// A mesh on the picture.
#[derive(Debug)]
pub(crate) struct Layer {
    pub(crate) mesh: Mesh,
    pub(crate) screen: Vec<ScreenVertex>,
    /// Triangles made by clipping, which follow the mesh's own primitives.
    pub(crate) clipped: Vec<[u32; 3]>,
    /// The primitive of which each of these is a part, and the index of its triangle.
    clipped_from: Vec<(u32, u32)>,
    /// Number of the mesh's own primitives.
    pub(crate) primitives: usize,
}

/// Bin and number of a primitive.
pub(crate) type Binned = (u32, u32);

/// Clips and projects meshes.
struct MeshProjector<'a> {
    projector: &'a Projector,
    raster: Raster,
    bins: [i64; 2],
}

/// A vertex of a clipped polygon: weights of the triangle's three corners, and its position in view space.
#[derive(Clone, Copy)]
struct ClippedVertex {
    position: [f64; 3],
    weights: [f64; 3],
}

impl Layer {
    /// Projects a mesh and sorts its primitives into bins. `first` is the number of its first primitive; `out`
    /// receives lists of pairs of bin and number.
    pub(crate) fn new(
        mesh: Mesh,
        projector: &Projector,
        bins: [i64; 2],
        first: u32,
        out: &mut Vec<Vec<Binned>>,
    ) -> Self {
        let stage = MeshProjector { projector, raster: Raster::new(projector), bins };
        let (screen, codes) = stage.vertices(&mesh.positions);
        let primitives = mesh.primitives();
        let mut layer = Self { mesh, screen, clipped: Vec::new(), clipped_from: Vec::new(), primitives };
        let tasks: Vec<(Vec<Binned>, Vec<ClippedTriangle>)> = (0..primitives.div_ceil(TASK))
            .into_par_iter()
            .map(|task| {
                let (mut binned, mut clipped) = (Vec::new(), Vec::new());
                let task = task * TASK..((task + 1) * TASK).min(primitives);
                match &layer.mesh.topology {
                    Topology::Triangles(triangles) => {
                        for (primitive, triangle) in task.clone().zip(&triangles[task]) {
                            layer.sort(&stage, primitive, [*triangle], &codes, first, &mut binned, &mut clipped);
                        }
                    }
                    Topology::Grid { columns, .. } => {
                        let mut row = task.start / (columns - 1);
                        for primitive in task {
                            if primitive == (row + 1) * (columns - 1) {
                                row += 1;
                            }
                            // A row has one more vertex than it has cells.
                            let corners = cell_corners((primitive + row) as u32, *columns as u32);
                            layer.sort(&stage, primitive, corners, &codes, first, &mut binned, &mut clipped);
                        }
                    }
                }
                (binned, clipped)
            })
            .collect();
        for (binned, clipped) in tasks {
            out.push(binned);
            let mut binned = Vec::new();
            for polygon in clipped {
                layer.append(&stage, &polygon, first, &mut binned);
            }
            out.push(binned);
        }
        layer
    }

    /// Puts a primitive into bins if it may be seen, or clips it.
    #[expect(clippy::too_many_arguments, reason = "two results")]
    #[inline(always)]
    fn sort<const N: usize>(
        &self,
        stage: &MeshProjector<'_>,
        primitive: usize,
        triangles: [[u32; 3]; N],
        codes: &[u8],
        first: u32,
        binned: &mut Vec<Binned>,
        clipped: &mut Vec<ClippedTriangle>,
    ) {
        let corners = || triangles.as_flattened().iter().map(|&vertex| vertex as usize);
        let fold = corners().map(|vertex| codes[vertex]);
        let (all, any) = fold.fold((u8::MAX, 0), |(all, any), code| (all & code, any | code));
        if all & !outside::LIMIT != 0 {
            return;
        }
        if any & (outside::NEAR | outside::LIMIT) == 0 {
            stage.bin(corners().map(|vertex| self.screen[vertex]), first + primitive as u32, binned);
        } else {
            for (part, triangle) in triangles.iter().enumerate() {
                stage.clip(&self.mesh, *triangle, (primitive as u32, part as u32), clipped);
            }
        }
    }

    /// Returns the triangles of a primitive.
    #[inline]
    pub(crate) fn triangles(&self, primitive: usize) -> Triangles {
        if primitive >= self.primitives {
            return Triangles::one(self.clipped[primitive - self.primitives]);
        }
        match &self.mesh.topology {
            Topology::Triangles(triangles) => Triangles::one(triangles[primitive]),
            Topology::Grid { columns, .. } => {
                // There are fewer than 2³², and divisions of half the width take half the time.
                let (primitive, columns) = (primitive as u32, *columns as u32);
                let (row, column) = (primitive / (columns - 1), primitive % (columns - 1));
                let a = row * columns + column;
                Triangles { list: cell_corners(a, columns), len: 2 }
            }
        }
    }

    /// Returns the mesh's own primitive of which a clipped one is a part, and the index of its triangle.
    #[inline]
    pub(crate) fn origin(&self, clipped: usize) -> (u32, u32) {
        self.clipped_from[clipped - self.primitives]
    }

    /// Adds a clipped polygon's vertices, with interpolated attributes, and its fan of triangles.
    fn append(&mut self, stage: &MeshProjector<'_>, polygon: &ClippedTriangle, first: u32, out: &mut Vec<Binned>) {
        let start = self.mesh.positions.len() as u32;
        for corner in &polygon.corners {
            self.screen.push(stage.vertex(corner.position).0);
            let vertices = polygon.triangle.map(|vertex| vertex as usize);
            let blend = |values: [f32; 3]| {
                values.iter().zip(corner.weights).map(|(&value, weight)| f64::from(value) * weight).sum::<f64>() as f32
            };
            let Mesh { positions, normals, rests, rest_heights, uvs, slope_variances, trails, .. } = &mut self.mesh;
            positions.push(std::array::from_fn(|axis| blend(vertices.map(|vertex| positions[vertex][axis]))));
            if !normals.is_empty() {
                normals.push(std::array::from_fn(|axis| blend(vertices.map(|vertex| normals[vertex][axis]))));
            }
            if !rests.is_empty() {
                rests.push(std::array::from_fn(|axis| blend(vertices.map(|vertex| rests[vertex][axis]))));
            }
            if !rest_heights.is_empty() {
                rest_heights.push(blend(vertices.map(|vertex| rest_heights[vertex])));
            }
            if !uvs.is_empty() {
                uvs.push(std::array::from_fn(|axis| blend(vertices.map(|vertex| uvs[vertex][axis]))));
            }
            if !slope_variances.is_empty() {
                slope_variances.push(blend(vertices.map(|vertex| slope_variances[vertex])));
            }
            for values in trails.iter_mut().filter(|values| !values.is_empty()) {
                values.push(blend(vertices.map(|vertex| values[vertex])));
            }
        }
        for next in 1..polygon.corners.len() as u32 - 1 {
            let triangle = [start, start + next, start + next + 1];
            let primitive = first + (self.primitives + self.clipped.len()) as u32;
            self.clipped.push(triangle);
            self.clipped_from.push(polygon.from);
            stage.bin(triangle.into_iter().map(|vertex| self.screen[vertex as usize]), primitive, out);
        }
    }
}

/// Returns the vertices of both triangles of a grid's cell, given its upper left vertex.
#[inline(always)]
pub(crate) fn cell_corners(a: u32, columns: u32) -> [[u32; 3]; 2] {
    let (b, c) = (a + 1, a + columns);
    [[a, b, c], [b, c + 1, c]]
}

/// One or two triangles.
#[derive(Clone, Copy)]
pub(crate) struct Triangles {
    list: [[u32; 3]; 2],
    len: usize,
}

impl Triangles {
    fn one(triangle: [u32; 3]) -> Self {
        Self { list: [triangle, [0; 3]], len: 1 }
    }
}

impl std::ops::Deref for Triangles {
    type Target = [[u32; 3]];

    #[inline]
    fn deref(&self) -> &Self::Target {
        &self.list[..self.len]
    }
}

impl<'a> IntoIterator for &'a Triangles {
    type Item = &'a [u32; 3];
    type IntoIter = std::slice::Iter<'a, [u32; 3]>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// The part of a triangle inside of the view volume.
struct ClippedTriangle {
    triangle: [u32; 3],
    /// Its primitive, and its index there.
    from: (u32, u32),
    corners: Vec<ClippedVertex>,
}

/// Number of sides of a picture.
pub(crate) const SIDES: usize = 4;

/// A part of a picture, and what of a grid may be seen in it.
pub(crate) struct PictureOfPart<'a> {
    stage: MeshProjector<'a>,
    /// First and last coordinates in fixed point.
    low: [i64; 2],
    high: [i64; 2],
    /// Functions n·p + d that are negative beyond each side, for a point p relative to the camera that is not behind it.
    sides: [(DVec3, f64); SIDES],
}

impl<'a> PictureOfPart<'a> {
    pub(crate) fn new(projector: &'a Projector, part: Window) -> Self {
        let stage = MeshProjector { projector, raster: Raster::new(projector), bins: [0, 0] };
        let raster = stage.raster;
        let fix = |pixels: i64| raster.fix(pixels as f64);
        // Primitives are found by bins, of which some reach into the part.
        let (low, high) = ([part.x0 - BIN[0], part.y0 - BIN[1]], [part.x1 + BIN[0], part.y1 + BIN[1]]);
        let Projector { right, up, forward, scale, size, .. } = *projector;
        // Position on the picture, from its center: scale · across/depth.
        let side = |across: DVec3, at: f64| match projector.orthographic {
            true => (across * scale, -at),
            false => (across * scale - forward * at, 0.0),
        };
        let [left, bottom] = [low[0] as f64 - size[0] / 2.0, size[1] / 2.0 - high[1] as f64];
        let [last, top] = [high[0] as f64 - size[0] / 2.0, size[1] / 2.0 - low[1] as f64];
        let sides = [side(right, left), side(-right, -last), side(up, bottom), side(-up, -top)];
        Self { stage, low: low.map(fix), high: high.map(fix), sides }
    }

    /// Returns, by side, the part of a line between two points relative to the camera that has points within `spread` of it
    /// that are not beyond the side, from 0 at the first end to 1 at the second; `None` if there is none.
    pub(crate) fn parts(&self, ends: [DVec3; 2], spread: DVec3) -> [Option<[f64; 2]>; SIDES] {
        self.sides.map(|(normal, at)| {
            let more = normal.abs().dot(spread) + at;
            let [first, last] = ends.map(|end| normal.dot(end) + more);
            let change = first / (first - last);
            match (first >= 0.0, last >= 0.0) {
                (true, true) => Some([0.0, 1.0]),
                (true, false) => Some([0.0, change]),
                (false, true) => Some([change, 1.0]),
                (false, false) => None,
            }
        })
    }

    /// Projects a row of vertices.
    pub(crate) fn row(&self, positions: &[[f32; 3]]) -> Vec<(ScreenVertex, u8)> {
        positions.iter().map(|&position| self.stage.vertex(self.stage.view(position))).collect()
    }

    /// Returns whether a cell between two rows may be seen in the part.
    pub(crate) fn sees(&self, above: &[(ScreenVertex, u8)], below: &[(ScreenVertex, u8)]) -> bool {
        above.windows(2).zip(below.windows(2)).any(|(above, below)| {
            let corners = [above[0], above[1], below[0], below[1]];
            let all = corners.iter().fold(u8::MAX, |all, (_, code)| all & code);
            let any = corners.iter().fold(0, |any, (_, code)| any | code);
            if all & !outside::LIMIT != 0 {
                return false;
            }
            let range = |of: fn(&ScreenVertex) -> i32| {
                let values = corners.iter().map(|(vertex, _)| i64::from(of(vertex)));
                (values.clone().min().unwrap_or(0), values.max().unwrap_or(0))
            };
            let ((x0, x1), (y0, y1)) = (range(|vertex| vertex.x), range(|vertex| vertex.y));
            let touches = x1 >= self.low[0] && x0 <= self.high[0] && y1 >= self.low[1] && y0 <= self.high[1];
            // What is clipped may be seen anywhere.
            touches || any & (outside::NEAR | outside::LIMIT) != 0
        })
    }
}

impl MeshProjector<'_> {
    /// Converts a point relative to the camera to view space: right, up, depth.
    #[inline(always)]
    fn view(&self, position: [f32; 3]) -> [f64; 3] {
        let offset = glam::Vec3::from(position).as_dvec3();
        let p = self.projector;
        [offset.dot(p.right), offset.dot(p.up), offset.dot(p.forward)]
    }

    /// Returns signed distances, up to positive factors, to the planes of the view volume, which lie at `reach`
    /// pixels from the picture's center.
    #[inline(always)]
    fn planes(&self, [x, y, depth]: [f64; 3], reach: [f64; 2]) -> [f64; 5] {
        let (scale, near, depth_or_1) = if self.projector.orthographic {
            (self.projector.scale, depth, 1.0)
        } else {
            (self.projector.scale, depth - NEAR_M, depth)
        };
        let (x, y) = (x * scale, y * scale);
        let (right, top) = (reach[0] * depth_or_1, reach[1] * depth_or_1);
        [near, x + right, right - x, top - y, y + top]
    }

    /// Returns the distance of the clipping planes from the picture's center, in pixels.
    fn clip_reach(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.raster.limit - self.projector.size[axis] / 2.0 - 1.0)
    }

    /// Projects vertices, and returns the sides of the view volume beyond which each lies.
    fn vertices(&self, positions: &[[f32; 3]]) -> (Vec<ScreenVertex>, Vec<u8>) {
        let mut screen = vec![ScreenVertex::default(); positions.len()];
        let mut codes = vec![0; positions.len()];
        let tasks = positions.par_chunks(TASK).zip(screen.par_chunks_mut(TASK)).zip(codes.par_chunks_mut(TASK));
        tasks.for_each(|((positions, screen), codes)| {
            dispatch!(Level::new(), simd => simd.vectorize(
                #[inline(always)]
                || {
                    for ((position, screen), code) in positions.iter().zip(screen).zip(codes) {
                        (*screen, *code) = self.vertex(self.view(*position));
                    }
                }
            ));
        });
        (screen, codes)
    }

    #[inline(always)]
    fn vertex(&self, view: [f64; 3]) -> (ScreenVertex, u8) {
        let p = self.projector;
        let half = [p.size[0] / 2.0, p.size[1] / 2.0];
        let [near, left, right, top, bottom] = self.planes(view, half);
        let mut code = 0;
        for (distance, bit) in [
            (near, outside::NEAR),
            (left, outside::LEFT),
            (right, outside::RIGHT),
            (top, outside::TOP),
            (bottom, outside::BOTTOM),
        ] {
            code |= if distance < 0.0 { bit } else { 0 };
        }
        let (scale, key) = if p.orthographic {
            (p.scale, -view[2])
        } else {
            (p.scale / view[2].max(NEAR_M), 1.0 / view[2].max(NEAR_M))
        };
        let (x, y) = (half[0] + view[0] * scale, half[1] - view[1] * scale);
        if x.abs() >= self.raster.limit || y.abs() >= self.raster.limit {
            code |= outside::LIMIT;
        }
        // Values past the limit saturate; only clipped triangles would read them.
        let fix = |pixels: f64| self.raster.whole(pixels) as i32;
        (ScreenVertex { x: fix(x), y: fix(y), key: key as f32 }, code)
    }

    /// Clips by Sutherland–Hodgman against the near plane, then against the limits of fixed point.
    ///
    /// The intersection of an edge with a plane is computed from its ends in an order that depends only on the ends,
    /// so both triangles at an edge get the same point.
    fn clip(&self, mesh: &Mesh, triangle: [u32; 3], from: (u32, u32), out: &mut Vec<ClippedTriangle>) {
        let reach = self.clip_reach();
        let mut polygon: Vec<ClippedVertex> = (0..3)
            .map(|index| ClippedVertex {
                position: self.view(mesh.positions[triangle[index] as usize]),
                weights: std::array::from_fn(|corner| if corner == index { 1.0 } else { 0.0 }),
            })
            .collect();
        for plane in 0..5 {
            let distance = |corner: &ClippedVertex| self.planes(corner.position, reach)[plane];
            let mut kept = Vec::with_capacity(polygon.len() + 1);
            for (index, a) in polygon.iter().enumerate() {
                let b = &polygon[(index + 1) % polygon.len()];
                let (at_a, at_b) = (distance(a), distance(b));
                if at_a >= 0.0 {
                    kept.push(*a);
                }
                if (at_a >= 0.0) != (at_b >= 0.0) {
                    kept.push(if precedes(a, b) { cross(a, b, at_a, at_b) } else { cross(b, a, at_b, at_a) });
                }
            }
            polygon = kept;
            if polygon.len() < 3 {
                return;
            }
        }
        out.push(ClippedTriangle { triangle, from, corners: polygon });
    }

    /// Puts a primitive into all bins that its bounding box touches.
    fn bin(&self, corners: impl Iterator<Item = ScreenVertex>, primitive: u32, out: &mut Vec<Binned>) {
        let (mut low, mut high) = ([i32::MAX; 2], [i32::MIN; 2]);
        for corner in corners {
            for (axis, value) in [corner.x, corner.y].into_iter().enumerate() {
                low[axis] = low[axis].min(value);
                high[axis] = high[axis].max(value);
            }
        }
        let range = |axis: usize| {
            let bin = |value: i32| (i64::from(value) >> self.raster.bits).div_euclid(BIN[axis]);
            (bin(low[axis]).max(0), bin(high[axis]).min(self.bins[axis] - 1))
        };
        let ((x0, x1), (y0, y1)) = (range(0), range(1));
        for y in y0..=y1 {
            for x in x0..=x1 {
                out.push(((y * self.bins[0] + x) as u32, primitive));
            }
        }
    }
}

fn precedes(a: &ClippedVertex, b: &ClippedVertex) -> bool {
    let order = a.position.iter().zip(&b.position).map(|(a, b)| a.total_cmp(b));
    order.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then).is_lt()
}

/// Returns the point between a and b where the distance to a plane is 0.
fn cross(a: &ClippedVertex, b: &ClippedVertex, at_a: f64, at_b: f64) -> ClippedVertex {
    let t = at_a / (at_a - at_b);
    let mix = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|index| a[index] + (b[index] - a[index]) * t);
    ClippedVertex { position: mix(a.position, b.position), weights: mix(a.weights, b.weights) }
}
