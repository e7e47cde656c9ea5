//! Interpolates the attributes of visible triangles at the samples that see them.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use std::cell::RefCell;
use std::ops::Range;

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;

use crate::channel::{CURVED, NORMALS, RESTS, TRAILS};
use crate::on_heights::{self, HeightField, HeightView};
use crate::patches::{Cells, Met, PatchView, Starts};
use crate::project::Layer;
use crate::raster::{NOTHING, Row, SeenTriangle};
use crate::shading::unit_or_up;
use crate::surface::{Between, Mesh, Topology};
use crate::{Channel, ChannelSet, Projector, Samples, Visible};

/// Number of hits that are processed side by side, in vectors.
pub(crate) const BLOCK: usize = 64;

/// Channels that are blended from vertices, besides points and normals.
const BLENDED: ChannelSet =
    RESTS.union(ChannelSet::UV).union(ChannelSet::of(&[Channel::Jacobian, Channel::SlopeVariance]));

/// A value at each hit of a block; values beyond the last hit are never read.
pub(crate) type Lanes = [f64; BLOCK];

/// Samples that see triangles of one surface.
struct Hits {
    count: usize,
    /// Indices of the samples in the planes, in ascending order.
    places: [u32; BLOCK],
    /// Vertices of the triangles, by corner.
    corners: [[u32; BLOCK]; 3],
    /// Cells of a grid, and which of their triangles are seen, also if they were clipped.
    rows: [u32; BLOCK],
    columns: [u32; BLOCK],
    parts: [u32; BLOCK],
    /// Positions within the picture.
    x: Lanes,
    y: Lanes,
}

impl Default for Hits {
    fn default() -> Self {
        let (none, nowhere) = ([0; BLOCK], [0.0; BLOCK]);
        Self {
            count: 0,
            places: none,
            corners: [none; 3],
            rows: none,
            columns: none,
            parts: none,
            x: nowhere,
            y: nowhere,
        }
    }
}

/// What is computed for a block. It is kept from block to block: to clear it takes as long as to fill it.
struct Work {
    /// Positions of the triangles' corners, the weights of these, and the sides that are seen: −1 for the outer one,
    /// else 1.
    corners: [[Lanes; 3]; 3],
    weights: [Lanes; 3],
    sides: Lanes,
    /// Points of triangles, then those of patches.
    met: Met,
    cells: Cells,
}

impl Default for Work {
    fn default() -> Self {
        let none = [0.0; BLOCK];
        let (met, cells) = (Met::default(), Cells::default());
        Self { corners: [[none; 3]; 3], weights: [none; 3], sides: none, met, cells }
    }
}

/// What a thread keeps from window to window.
#[derive(Default)]
struct Scratch {
    /// By surface, the hits that wait until there are enough for a block.
    waiting: Vec<Hits>,
    work: Work,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Sorts samples by the surfaces that they see.
struct Sorter<'a, 's, R> {
    visible: &'a Visible,
    rows: R,
    offset: [f64; 2],
    /// The row that is being sorted, and its next sample.
    row: Option<Row<'s>>,
    column: usize,
    /// The surface that the last sample saw, and its primitives.
    surface: usize,
    primitives: Range<u32>,
}

/// Hits of one mesh.
struct Block<'a> {
    hits: &'a Hits,
    mesh: &'a Mesh,
    /// Places across and upward from the middle of the picture, as of [`Projector::place`].
    places: [Lanes; 2],
}

/// Points at which the vertices' attributes are interpolated: the same number of vertices for each hit.
struct Blend<'a, const CORNERS: usize> {
    vertices: &'a [[u32; BLOCK]; CORNERS],
    weights: &'a [Lanes; CORNERS],
}

impl Visible {
    /// Interpolates the attributes of the visible triangles; writes the background where there is none.
    pub(crate) fn resolve<'s>(
        &self,
        rows: impl Iterator<Item = Row<'s>>,
        offset: [f64; 2],
        wanted: ChannelSet,
        out: &mut Samples,
    ) {
        // Use the offset to which the raster rounded, so that the ray meets the triangle that was found.
        let unit = f64::from(1_u32 << self.raster.bits);
        let offset = offset.map(|part| self.raster.fix(part) as f64 / unit);
        SCRATCH.with_borrow_mut(|scratch| {
            if scratch.waiting.len() < self.layers.len() {
                scratch.waiting.resize_with(self.layers.len(), Hits::default);
            }
            dispatch!(Level::new(), simd => simd.vectorize(
                #[inline(always)]
                || self.resolve_rows(simd, rows, offset, wanted, scratch, out)
            ));
        });
    }

    #[inline(always)]
    fn resolve_rows<'s, S: Simd>(
        &self,
        simd: S,
        rows: impl Iterator<Item = Row<'s>>,
        offset: [f64; 2],
        wanted: ChannelSet,
        scratch: &mut Scratch,
        out: &mut Samples,
    ) {
        let Scratch { waiting, work } = scratch;
        let waiting = &mut waiting[..self.layers.len()];
        // A panic may have left some behind.
        waiting.iter_mut().for_each(|hits| hits.count = 0);
        let mut sorter = Sorter { visible: self, rows, offset, row: None, column: 0, surface: 0, primitives: 0..0 };
        while let Some(surface) = sorter.next(waiting, wanted, out) {
            let hits = &mut waiting[surface];
            let mut block = Block { hits, mesh: &self.layers[surface].mesh, places: [[0.0; BLOCK]; 2] };
            for lane in 0..BLOCK {
                [block.places[0][lane], block.places[1][lane]] = self.projector.place(hits.x[lane], hits.y[lane]);
            }
            self.answer(simd, &block, surface, work, wanted, out);
            hits.count = 0;
        }
    }

    #[inline(always)]
    fn answer<S: Simd>(
        &self,
        simd: S,
        block: &Block<'_>,
        surface: usize,
        work: &mut Work,
        wanted: ChannelSet,
        out: &mut Samples,
    ) {
        block.put_all(Channel::Coverage, 1.0, out);
        block.put_all(Channel::Surface, surface as f32, out);
        if !wanted.intersects(CURVED) {
            return;
        }
        let Work { corners, weights, sides, met, cells } = work;
        gather(&block.hits.corners, block.hits.count, &block.mesh.positions, corners);
        match self.projector.orthographic {
            true => block.weights::<true>(corners, &self.projector, weights, sides),
            false => block.weights::<false>(corners, &self.projector, weights, sides),
        }
        let triangles = Blend { vertices: &block.hits.corners, weights };
        triangles.mean(corners, &mut met.positions);
        match &block.mesh.between {
            Between::Triangles => self.answer_triangles(block, &triangles, &met.positions, sides, wanted, out),
            Between::Patches(_) => self.answer_patches(simd, block, weights, sides, met, cells, wanted, out),
            Between::Heights(field) => self.answer_heights(simd, block, field, &met.positions, sides, wanted, out),
        }
    }

    #[inline(always)]
    fn answer_triangles(
        &self,
        block: &Block<'_>,
        at: &Blend<'_, 3>,
        points: &[Lanes; 3],
        sides: &Lanes,
        wanted: ChannelSet,
        out: &mut Samples,
    ) {
        let height = self.put_points(block, points, wanted, out);
        if wanted.intersects(NORMALS) {
            if block.mesh.normals.is_empty() {
                for channel in NORMALS.iter() {
                    block.put_all(channel, channel.background(), out);
                }
            } else {
                block.put_all(Channel::Jacobian, 1.0, out);
                block.put_normals(&at.of(block, &block.mesh.normals), sides, out);
            }
        }
        self.put_attributes(block, at, points, &height, wanted, out);
        for (values, channel) in block.mesh.trails.iter().zip(Channel::TRAILS) {
            at.put(block, channel, values, wanted, out);
        }
    }

    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "values of a block")]
    fn answer_patches<S: Simd>(
        &self,
        simd: S,
        block: &Block<'_>,
        triangles: &[Lanes; 3],
        sides: &Lanes,
        met: &mut Met,
        cells: &mut Cells,
        wanted: ChannelSet,
        out: &mut Samples,
    ) {
        let (Between::Patches(patches), &Topology::Grid { columns, rows }) =
            (&block.mesh.between, &block.mesh.topology)
        else {
            return;
        };
        let hits = block.hits;
        for lane in 0..BLOCK {
            // The corners of the first triangle are at (0, 0), (1, 0) and (0, 1), those of the second at (1, 0),
            // (1, 1) and (0, 1).
            let [a, b, c] = [triangles[0][lane], triangles[1][lane], triangles[2][lane]];
            let (first, second) = ([b, c], [a + b, b + c]);
            [met.u[lane], met.v[lane]] = if hits.parts[lane] == 0 { first } else { second };
        }
        let (count, places) = (hits.count, &block.places);
        let starts = Starts { count, rows: &hits.rows, columns: &hits.columns, places, sides };
        let view = PatchView { patches, positions: &block.mesh.positions, columns, rows, projector: &self.projector };
        view.meet(simd, &starts, cells, met);
        let height = self.put_points(block, &met.positions, wanted, out);
        if wanted.intersects(ChannelSet::NORMAL) {
            block.put_normals(&met.normals, sides, out);
        }
        for channel in Channel::TRAILS {
            block.put_all(channel, channel.background(), out);
        }
        if !wanted.intersects(BLENDED) {
            return;
        }
        let (mut vertices, mut weights) = ([[0; BLOCK]; 4], [[0.0; BLOCK]; 4]);
        let next = [0, 1, columns as u32, columns as u32 + 1];
        for lane in 0..BLOCK {
            for corner in 0..4 {
                vertices[corner][lane] = met.vertices[lane] + next[corner];
            }
            let (u, v) = (met.u[lane], met.v[lane]);
            weights[0][lane] = (1.0 - u) * (1.0 - v);
            weights[1][lane] = u * (1.0 - v);
            weights[2][lane] = (1.0 - u) * v;
            weights[3][lane] = u * v;
        }
        let at = Blend { vertices: &vertices, weights: &weights };
        if wanted.contains(Channel::Jacobian) {
            let [x, z] = at.slopes(block, &block.mesh.rests, &met.u, &met.v);
            let mut value = [0.0; BLOCK];
            for lane in 0..BLOCK {
                let area = x[1][lane] * z[0][lane] - x[0][lane] * z[1][lane];
                // The innermost vertices of a disc are one point.
                value[lane] = if area == 0.0 { 1.0 } else { met.normals[1][lane] / area };
            }
            block.put(Channel::Jacobian, &value, out);
        }
        self.put_attributes(block, &at, &met.positions, &height, wanted, out);
    }

    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "values of a block")]
    fn answer_heights<S: Simd>(
        &self,
        simd: S,
        block: &Block<'_>,
        field: &HeightField,
        points: &[Lanes; 3],
        sides: &Lanes,
        wanted: ChannelSet,
        out: &mut Samples,
    ) {
        let view = HeightView::new(field, &self.projector);
        let starts = on_heights::Starts { count: block.hits.count, places: &block.places, sides, points };
        let met = view.meet(simd, &starts);
        let height = self.put_points(block, &met.points, wanted, out);
        if wanted.intersects(NORMALS) {
            block.put_all(Channel::Jacobian, 1.0, out);
            let mut normals = [[1.0; BLOCK]; 3];
            for lane in 0..BLOCK {
                (normals[0][lane], normals[2][lane]) = (-met.slopes[0][lane], -met.slopes[1][lane]);
            }
            block.put_normals(&normals, sides, out);
        }
        // It rests below its points.
        let at = Blend::<1> { vertices: &[[0; BLOCK]], weights: &[[0.0; BLOCK]] };
        self.put_attributes(block, &at, &met.points, &height, wanted, out);
        if wanted.intersects(TRAILS) {
            let trails = view.trails(block.hits.count, &met.points);
            for (channel, trail) in Channel::TRAILS.into_iter().zip(&trails) {
                block.put(channel, trail, out);
            }
        }
    }

    /// Writes depths, positions and heights of points relative to the camera, and returns the heights over the level.
    #[inline(always)]
    fn put_points(&self, block: &Block<'_>, points: &[Lanes; 3], wanted: ChannelSet, out: &mut Samples) -> Lanes {
        let projector = &self.projector;
        let [x, y, z] = points;
        let mut value = [0.0; BLOCK];
        if wanted.contains(Channel::Depth) {
            for lane in 0..BLOCK {
                value[lane] = DVec3::new(x[lane], y[lane], z[lane]).dot(projector.forward);
            }
            block.put(Channel::Depth, &value, out);
        }
        let eye = projector.position.to_array();
        for (axis, channel) in [Channel::PositionX, Channel::PositionY, Channel::PositionZ].into_iter().enumerate() {
            if wanted.contains(channel) {
                for lane in 0..BLOCK {
                    value[lane] = eye[axis] + points[axis][lane];
                }
                block.put(channel, &value, out);
            }
        }
        for lane in 0..BLOCK {
            value[lane] = projector.position.y + y[lane] - block.mesh.level;
        }
        block.put(Channel::Height, &value, out);
        value
    }

    /// Writes rest points, texture coordinates and slope variances.
    #[inline(always)]
    fn put_attributes<const CORNERS: usize>(
        &self,
        block: &Block<'_>,
        at: &Blend<'_, CORNERS>,
        points: &[Lanes; 3],
        height: &Lanes,
        wanted: ChannelSet,
        out: &mut Samples,
    ) {
        let mesh = block.mesh;
        at.put(block, Channel::SlopeVariance, &mesh.slope_variances, wanted, out);
        if !wanted.intersects(RESTS.union(ChannelSet::UV)) {
            return;
        }
        let eye = self.projector.position;
        // A surface without rest points rests at its position.
        let [rest_x, rest_z] = if mesh.rests.is_empty() { [points[0], points[2]] } else { at.of(block, &mesh.rests) };
        // Height of the rest point above the level, for models.
        let mut risen = [0.0; BLOCK];
        if !mesh.rest_heights.is_empty() {
            let [heights] = at.of(block, mesh.rest_heights.as_chunks::<1>().0);
            for lane in 0..BLOCK {
                risen[lane] = eye.y + heights[lane] - mesh.level;
            }
        }
        let (mut x, mut y, mut z, mut moved) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
        for lane in 0..BLOCK {
            x[lane] = eye.x + rest_x[lane];
            y[lane] = mesh.level + risen[lane];
            z[lane] = eye.z + rest_z[lane];
            let up = height[lane] - risen[lane];
            moved[lane] = DVec3::new(points[0][lane] - rest_x[lane], up, points[2][lane] - rest_z[lane]).length();
        }
        block.put(Channel::RestX, &x, out);
        block.put(Channel::RestY, &y, out);
        block.put(Channel::RestZ, &z, out);
        block.put(Channel::RestDistance, &moved, out);
        let [u, v] = if mesh.uvs.is_empty() { [x, z] } else { at.of(block, &mesh.uvs) };
        block.put(Channel::U, &u, out);
        block.put(Channel::V, &v, out);
    }
}

/// Gathers values of the vertices of some hits, by corner and component.
#[inline(always)]
fn gather<const N: usize, const CORNERS: usize>(
    vertices: &[[u32; BLOCK]; CORNERS],
    count: usize,
    values: &[[f32; N]],
    gathered: &mut [[Lanes; N]; CORNERS],
) {
    let mut single = [[[0.0; BLOCK]; N]; CORNERS];
    for lane in 0..count {
        for corner in 0..CORNERS {
            let value = values[vertices[corner][lane] as usize];
            for component in 0..N {
                single[corner][component][lane] = value[component];
            }
        }
    }
    for corner in 0..CORNERS {
        for component in 0..N {
            for lane in 0..BLOCK {
                gathered[corner][component][lane] = f64::from(single[corner][component][lane]);
            }
        }
    }
}

impl<const CORNERS: usize> Blend<'_, CORNERS> {
    /// Computes Σ wᵢvᵢ over the corners, by component.
    #[inline(always)]
    fn mean<const N: usize>(&self, values: &[[Lanes; N]; CORNERS], mean: &mut [Lanes; N]) {
        for component in 0..N {
            for lane in 0..BLOCK {
                let mut sum = values[0][component][lane] * self.weights[0][lane];
                for corner in 1..CORNERS {
                    sum += values[corner][component][lane] * self.weights[corner][lane];
                }
                mean[component][lane] = sum;
            }
        }
    }

    #[inline(always)]
    fn of<const N: usize>(&self, block: &Block<'_>, values: &[[f32; N]]) -> [Lanes; N] {
        let (mut gathered, mut mean) = ([[[0.0; BLOCK]; N]; CORNERS], [[0.0; BLOCK]; N]);
        gather(self.vertices, block.hits.count, values, &mut gathered);
        self.mean(&gathered, &mut mean);
        mean
    }

    /// Writes an attribute if it was requested; the background if there is none.
    #[inline(always)]
    fn put(&self, block: &Block<'_>, channel: Channel, values: &[f32], wanted: ChannelSet, out: &mut Samples) {
        if !wanted.contains(channel) {
            return;
        }
        if values.is_empty() {
            block.put_all(channel, channel.background(), out);
        } else {
            let [value] = self.of(block, values.as_chunks::<1>().0);
            block.put(channel, &value, out);
        }
    }
}

impl Blend<'_, 4> {
    /// Returns the derivatives by u and v of what is blended over cells, by component.
    #[inline(always)]
    fn slopes<const N: usize>(&self, block: &Block<'_>, values: &[[f32; N]], u: &Lanes, v: &Lanes) -> [[Lanes; 2]; N] {
        let mut gathered = [[[0.0; BLOCK]; N]; 4];
        gather(self.vertices, block.hits.count, values, &mut gathered);
        let mut slopes = [[[0.0; BLOCK]; 2]; N];
        for component in 0..N {
            let [a, b, c, d] = [0, 1, 2, 3].map(|corner| &gathered[corner][component]);
            for lane in 0..BLOCK {
                let (u, v) = (u[lane], v[lane]);
                slopes[component][0][lane] = (b[lane] - a[lane]) * (1.0 - v) + (d[lane] - c[lane]) * v;
                slopes[component][1][lane] = (c[lane] - a[lane]) * (1.0 - u) + (d[lane] - b[lane]) * u;
            }
        }
        slopes
    }
}

impl Block<'_> {
    /// Writes normals of any length, turned over on a side that faces away, as in a fold.
    #[inline(always)]
    fn put_normals(&self, normals: &[Lanes; 3], sides: &Lanes, out: &mut Samples) {
        let own = if self.mesh.inside { 1.0 } else { -1.0 };
        let (mut x, mut y, mut z) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
        for lane in 0..BLOCK {
            let normal = DVec3::new(normals[0][lane], normals[1][lane], normals[2][lane]);
            let normal = unit_or_up(normal) * (own * sides[lane]);
            (x[lane], y[lane], z[lane]) = (normal.x, normal.y, normal.z);
        }
        self.put(Channel::NormalX, &x, out);
        self.put(Channel::NormalY, &y, out);
        self.put(Channel::NormalZ, &z, out);
    }

    /// Computes the barycentric weights of the points where the pixels' rays meet triangles, from the exact positions:
    /// the fixed-point positions only decided which triangles these are.
    ///
    /// For a ray from the origin along r, the point Σ wᵢPᵢ is on it if w₀ : w₁ : w₂ = r·(P₁×P₂) : r·(P₂×P₀) :
    /// r·(P₀×P₁). Also gives −1 if a triangle's outer side is seen, else 1. Rounding may have put the ray slightly
    /// outside of the triangle: negative weights count as 0. Without perspective, all rays are parallel.
    #[inline(always)]
    fn weights<const PARALLEL: bool>(
        &self,
        positions: &[[Lanes; 3]; 3],
        projector: &Projector,
        weights: &mut [Lanes; 3],
        sides: &mut Lanes,
    ) {
        for lane in 0..BLOCK {
            let (across, upward) = (projector.right * self.places[0][lane], projector.up * self.places[1][lane]);
            let corner = |corner: usize| {
                let [x, y, z] = &positions[corner];
                let position = DVec3::new(x[lane], y[lane], z[lane]);
                if PARALLEL { position - across - upward } else { position }
            };
            let (p, q, r) = (corner(0), corner(1), corner(2));
            let ray = if PARALLEL { projector.forward } else { projector.forward + across + upward };
            let (a, b, c) = (ray.dot(q.cross(r)), ray.dot(r.cross(p)), ray.dot(p.cross(q)));
            // The sum is r·((P₁−P₀)×(P₂−P₀)): negative if the outer side is seen.
            let side = if a + b + c < 0.0 { -1.0 } else { 1.0 };
            let kept = |weight: f64| if weight * side > 0.0 { weight * side } else { 0.0 };
            let (a, b, c) = (kept(a), kept(b), kept(c));
            let sum = a + b + c;
            let fair = sum > 0.0 && sum < f64::INFINITY;
            let share = |weight: f64| if fair { weight / sum } else { 1.0 / 3.0 };
            (weights[0][lane], weights[1][lane], weights[2][lane]) = (share(a), share(b), share(c));
            sides[lane] = side;
        }
    }

    /// Writes the value of each hit if the channel was requested.
    #[inline(always)]
    fn put(&self, channel: Channel, values: &Lanes, out: &mut Samples) {
        let samples = out.all(channel);
        if samples.is_empty() {
            return;
        }
        let mut rounded = [0.0; BLOCK];
        for lane in 0..BLOCK {
            rounded[lane] = values[lane] as f32;
        }
        let places = &self.hits.places[..self.hits.count];
        match self.hits.run() {
            Some(run) => samples[run].copy_from_slice(&rounded[..places.len()]),
            None => places.iter().zip(rounded).for_each(|(place, value)| samples[*place as usize] = value),
        }
    }

    /// Writes one value at all hits.
    #[inline(always)]
    fn put_all(&self, channel: Channel, value: f32, out: &mut Samples) {
        let samples = out.all(channel);
        if samples.is_empty() {
            return;
        }
        match self.hits.run() {
            Some(run) => samples[run].fill(value),
            None => self.hits.places[..self.hits.count].iter().for_each(|place| samples[*place as usize] = value),
        }
    }
}

impl Hits {
    /// Returns the samples if they are adjacent.
    #[inline(always)]
    fn run(&self) -> Option<Range<usize>> {
        let (first, last) = (self.places[0] as usize, self.places[self.count - 1] as usize);
        (last - first == self.count - 1).then_some(first..last + 1)
    }

    /// Adds a sample that sees a triangle of a layer.
    #[inline(always)]
    fn push(&mut self, place: usize, pixel: [f64; 2], layer: &Layer, local: usize, seen: SeenTriangle) {
        let lane = self.count;
        self.count += 1;
        self.places[lane] = place as u32;
        [self.x[lane], self.y[lane]] = pixel;
        let is_whole = local < layer.primitives;
        let corners = match &layer.mesh.topology {
            Topology::Triangles(triangles) if is_whole => triangles[local],
            &Topology::Grid { columns, .. } if is_whole || matches!(layer.mesh.between, Between::Patches(_)) => {
                let cells = columns as u32 - 1;
                // A patch is met from the whole triangle: its cell is that of the triangle's corners.
                let (row, column, part) = if is_whole {
                    (seen.row, local as u32 - seen.row * cells, seen.part)
                } else {
                    let (primitive, part) = layer.origin(local);
                    (primitive / cells, primitive % cells, part)
                };
                (self.rows[lane], self.columns[lane], self.parts[lane]) = (row, column, part);
                let (a, columns) = (row * columns as u32 + column, columns as u32);
                // As in `cell_corners`; an index into what was just written would wait for it.
                [a + part, a + 1 + part * columns, a + columns]
            }
            _ => layer.clipped[local - layer.primitives],
        };
        for corner in 0..3 {
            self.corners[corner][lane] = corners[corner];
        }
    }
}

impl<'s, R: Iterator<Item = Row<'s>>> Sorter<'_, 's, R> {
    /// Sorts samples until there are enough hits of one surface for a block, and returns this surface; in the end, any
    /// surface of which some hits are left. Writes the background where there is no triangle.
    #[inline(always)]
    fn next(&mut self, waiting: &mut [Hits], wanted: ChannelSet, out: &mut Samples) -> Option<usize> {
        loop {
            if self.row.as_ref().is_none_or(|row| self.column == row.len) {
                (self.row, self.column) = (self.rows.next(), 0);
            }
            let Some(row) = &self.row else {
                return waiting.iter().position(|hits| hits.count > 0);
            };
            let y = row.y as f64 + self.offset[1];
            while self.column < row.len {
                let (column, number) = (self.column, row.triangle(self.column));
                if number == NOTHING {
                    let end = (column..row.len).find(|column| row.triangle(*column) != NOTHING);
                    self.column = end.unwrap_or(row.len);
                    for channel in wanted.iter() {
                        out.all(channel)[row.first + column..row.first + self.column].fill(channel.background());
                    }
                    continue;
                }
                self.column += 1;
                let seen = SeenTriangle::unpack(number);
                if !self.primitives.contains(&seen.primitive) {
                    self.surface = self.visible.layer(seen.primitive);
                    let firsts = &self.visible.firsts[self.surface..];
                    self.primitives = firsts[0]..firsts.get(1).copied().unwrap_or(u32::MAX);
                }
                let pixel = [row.x(column) as f64 + self.offset[0], y];
                let (hits, layer) = (&mut waiting[self.surface], &self.visible.layers[self.surface]);
                let local = (seen.primitive - self.primitives.start) as usize;
                hits.push(row.first + column, pixel, layer, local, seen);
                if hits.count == BLOCK {
                    return Some(self.surface);
                }
            }
        }
    }
}
