//! Interpolates the attributes of visible triangles at the samples that see them.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;

use crate::channel::{CURVED, NORMALS, RESTS, TRAILS};
use crate::on_heights::{self, HeightField, HeightView};
use crate::patches::{PatchView, Starts};
use crate::raster::{NOTHING, Row};
use crate::shading::unit_or_up;
use crate::surface::{Between, Mesh, Topology};
use crate::{Channel, ChannelSet, Projector, Samples, Visible};

/// Number of hits that are processed side by side, in vectors.
pub(crate) const BLOCK: usize = 32;

/// A value at each hit of a block; values beyond the last hit are never read.
pub(crate) type Lanes = [f64; BLOCK];

/// A sample that sees a triangle.
struct SampleHit {
    /// Index of the sample within its row.
    column: usize,
    surface: usize,
    triangle: [u32; 3],
    /// Primitive of the mesh, and the index of its triangle.
    origin: (usize, usize),
}

/// Hits of one mesh in one row.
struct Block<'a> {
    hits: &'a [SampleHit],
    mesh: &'a Mesh,
    /// Index of the row's first sample, and positions within the picture.
    start: usize,
    x: Lanes,
    y: f64,
}

/// Points at which the vertices' attributes are interpolated: the same number of vertices for each hit.
struct Blend<const CORNERS: usize> {
    vertices: [[u32; BLOCK]; CORNERS],
    weights: [Lanes; CORNERS],
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
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || self.resolve_rows(rows, offset, wanted, out)
        ));
    }

    #[inline(always)]
    fn resolve_rows<'s>(
        &self,
        rows: impl Iterator<Item = Row<'s>>,
        offset: [f64; 2],
        wanted: ChannelSet,
        out: &mut Samples,
    ) {
        let mut hits: Vec<SampleHit> = Vec::new();
        for row in rows {
            let (start, numbers) = (row.first, &row.triangles);
            let width = numbers.len();
            hits.clear();
            let mut column = 0;
            while column < width {
                let number = numbers[column];
                if number == NOTHING {
                    let rest = &numbers[column..];
                    let run = rest.iter().position(|number| *number != NOTHING).unwrap_or(rest.len());
                    for channel in wanted.iter() {
                        out.from(channel, start + column)[..run].fill(channel.background());
                    }
                    column += run;
                    continue;
                }
                let primitive = (number / 2) as u32;
                let surface = self.layer(primitive);
                let (local, part) = ((primitive - self.firsts[surface]) as usize, (number % 2) as usize);
                let layer = &self.layers[surface];
                let origin = layer.origin(local, part);
                // A patch is met from the whole triangle: its cell is that of the triangle's corners.
                let (local, part) =
                    if matches!(layer.mesh.between, Between::Patches(_)) { origin } else { (local, part) };
                hits.push(SampleHit { column, surface, triangle: layer.triangles(local)[part], origin });
                column += 1;
            }
            let y = row.y as f64 + offset[1];
            for hits in hits.chunk_by(|a, b| a.surface == b.surface).flat_map(|hits| hits.chunks(BLOCK)) {
                let mut x = [0.0; BLOCK];
                for (x, hit) in x.iter_mut().zip(hits) {
                    *x = row.x(hit.column) as f64 + offset[0];
                }
                let mesh = &self.layers[hits[0].surface].mesh;
                self.answer(&Block { hits, mesh, start, x, y }, wanted, out);
            }
        }
    }

    #[inline(always)]
    fn answer(&self, block: &Block<'_>, wanted: ChannelSet, out: &mut Samples) {
        block.put_all(Channel::Coverage, 1.0, out);
        block.put_all(Channel::Surface, block.hits[0].surface as f32, out);
        if !wanted.intersects(CURVED) {
            return;
        }
        let corners = block.corners();
        let triangles = Blend { vertices: corners, weights: [[0.0; BLOCK]; 3] };
        let positions = triangles.gather(block, &block.mesh.positions);
        let (weights, sides) = block.weights(&positions, &self.projector);
        let triangles = Blend { weights, ..triangles };
        let points = triangles.mean(&positions);
        match &block.mesh.between {
            Between::Triangles => self.answer_triangles(block, &triangles, &points, &sides, wanted, out),
            Between::Patches(_) => self.answer_patches(block, &triangles, points, &sides, wanted, out),
            Between::Heights(field) => self.answer_heights(block, field, &points, &sides, wanted, out),
        }
    }

    #[inline(always)]
    fn answer_triangles(
        &self,
        block: &Block<'_>,
        at: &Blend<3>,
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
                block.put_normals(at.of(block, &block.mesh.normals), sides, out);
            }
        }
        self.put_attributes(block, at, points, &height, wanted, out);
        for (values, channel) in block.mesh.trails.iter().zip(Channel::TRAILS) {
            at.put(block, channel, values, wanted, out);
        }
    }

    #[inline(always)]
    fn answer_patches(
        &self,
        block: &Block<'_>,
        triangles: &Blend<3>,
        points: [Lanes; 3],
        sides: &Lanes,
        wanted: ChannelSet,
        out: &mut Samples,
    ) {
        let (Between::Patches(patches), &Topology::Grid { columns, rows }) =
            (&block.mesh.between, &block.mesh.topology)
        else {
            return;
        };
        let mut starts = Starts {
            count: block.hits.len(),
            rows: [0; BLOCK],
            columns: [0; BLOCK],
            u: [0.0; BLOCK],
            v: [0.0; BLOCK],
            x: block.x,
            y: block.y,
            sides: *sides,
        };
        let [a, b, c] = &triangles.weights;
        for (lane, hit) in block.hits.iter().enumerate() {
            let (primitive, part) = hit.origin;
            (starts.rows[lane], starts.columns[lane]) =
                ((primitive / (columns - 1)) as u32, (primitive % (columns - 1)) as u32);
            // The corners of the first triangle are at (0, 0), (1, 0) and (0, 1), those of the second at (1, 0),
            // (1, 1) and (0, 1).
            (starts.u[lane], starts.v[lane]) =
                if part == 0 { (b[lane], c[lane]) } else { (a[lane] + b[lane], b[lane] + c[lane]) };
        }
        let view = PatchView { patches, positions: &block.mesh.positions, columns, rows, projector: &self.projector };
        let met = view.meet(&starts, points);
        let height = self.put_points(block, &met.positions, wanted, out);
        let mut at = Blend { vertices: [[0; BLOCK]; 4], weights: [[0.0; BLOCK]; 4] };
        for lane in 0..block.hits.len() {
            let (first, columns) = (met.vertices[lane], columns as u32);
            for (corner, next) in [0, 1, columns, columns + 1].into_iter().enumerate() {
                at.vertices[corner][lane] = first + next;
            }
        }
        for lane in 0..BLOCK {
            let (u, v) = (met.u[lane], met.v[lane]);
            at.weights[0][lane] = (1.0 - u) * (1.0 - v);
            at.weights[1][lane] = u * (1.0 - v);
            at.weights[2][lane] = (1.0 - u) * v;
            at.weights[3][lane] = u * v;
        }
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
        if wanted.intersects(ChannelSet::NORMAL) {
            block.put_normals(met.normals, sides, out);
        }
        self.put_attributes(block, &at, &met.positions, &height, wanted, out);
        for channel in Channel::TRAILS {
            block.put_all(channel, channel.background(), out);
        }
    }

    #[inline(always)]
    fn answer_heights(
        &self,
        block: &Block<'_>,
        field: &HeightField,
        points: &[Lanes; 3],
        sides: &Lanes,
        wanted: ChannelSet,
        out: &mut Samples,
    ) {
        let view = HeightView::new(field, &self.projector);
        let starts = on_heights::Starts { count: block.hits.len(), x: &block.x, y: block.y, sides, points };
        let met = view.meet(&starts);
        let height = self.put_points(block, &met.points, wanted, out);
        if wanted.intersects(NORMALS) {
            block.put_all(Channel::Jacobian, 1.0, out);
            let [x, z] = met.slopes.map(|slopes| slopes.map(|slope| -slope));
            block.put_normals([x, [1.0; BLOCK], z], sides, out);
        }
        // It rests below its points.
        let at = Blend::<1> { vertices: [[0; BLOCK]], weights: [[0.0; BLOCK]] };
        self.put_attributes(block, &at, &met.points, &height, wanted, out);
        if wanted.intersects(TRAILS) {
            let trails = view.trails(block.hits.len(), &met.points);
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
        at: &Blend<CORNERS>,
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

impl<const CORNERS: usize> Blend<CORNERS> {
    /// Gathers the attributes of the vertices, by corner and component.
    #[inline(always)]
    fn gather<const N: usize>(&self, block: &Block<'_>, values: &[[f32; N]]) -> [[Lanes; N]; CORNERS] {
        let mut gathered = [[[0.0; BLOCK]; N]; CORNERS];
        for lane in 0..block.hits.len() {
            for corner in 0..CORNERS {
                let value = values[self.vertices[corner][lane] as usize];
                for component in 0..N {
                    gathered[corner][component][lane] = f64::from(value[component]);
                }
            }
        }
        gathered
    }

    /// Returns Σ wᵢvᵢ over the corners, by component.
    #[inline(always)]
    fn mean<const N: usize>(&self, values: &[[Lanes; N]; CORNERS]) -> [Lanes; N] {
        let mut mean = [[0.0; BLOCK]; N];
        for component in 0..N {
            for lane in 0..BLOCK {
                mean[component][lane] = values[0][component][lane] * self.weights[0][lane];
                for corner in 1..CORNERS {
                    mean[component][lane] += values[corner][component][lane] * self.weights[corner][lane];
                }
            }
        }
        mean
    }

    #[inline(always)]
    fn of<const N: usize>(&self, block: &Block<'_>, values: &[[f32; N]]) -> [Lanes; N] {
        self.mean(&self.gather(block, values))
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

impl Blend<4> {
    /// Returns the derivatives by u and v of what is blended over cells, by component.
    #[inline(always)]
    fn slopes<const N: usize>(&self, block: &Block<'_>, values: &[[f32; N]], u: &Lanes, v: &Lanes) -> [[Lanes; 2]; N] {
        let values = self.gather(block, values);
        let mut slopes = [[[0.0; BLOCK]; 2]; N];
        for component in 0..N {
            let [a, b, c, d] = [0, 1, 2, 3].map(|corner| &values[corner][component]);
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
    /// Returns the vertices of the triangles, by corner.
    #[inline(always)]
    fn corners(&self) -> [[u32; BLOCK]; 3] {
        let mut corners = [[0; BLOCK]; 3];
        for (lane, hit) in self.hits.iter().enumerate() {
            for corner in 0..3 {
                corners[corner][lane] = hit.triangle[corner];
            }
        }
        corners
    }

    /// Writes normals of any length, turned over on a side that faces away, as in a fold.
    #[inline(always)]
    fn put_normals(&self, [mut x, mut y, mut z]: [Lanes; 3], sides: &Lanes, out: &mut Samples) {
        let own = if self.mesh.inside { 1.0 } else { -1.0 };
        for lane in 0..BLOCK {
            let normal = unit_or_up(DVec3::new(x[lane], y[lane], z[lane])) * (own * sides[lane]);
            (x[lane], y[lane], z[lane]) = (normal.x, normal.y, normal.z);
        }
        self.put(Channel::NormalX, &x, out);
        self.put(Channel::NormalY, &y, out);
        self.put(Channel::NormalZ, &z, out);
    }

    /// Returns the barycentric weights of the points where the pixels' rays meet triangles, from the exact positions:
    /// the fixed-point positions only decided which triangles these are.
    ///
    /// For a ray from the origin along r, the point Σ wᵢPᵢ is on it if w₀ : w₁ : w₂ = r·(P₁×P₂) : r·(P₂×P₀) :
    /// r·(P₀×P₁). Also returns −1 if a triangle's outer side is seen, else 1. Rounding may have put the ray slightly
    /// outside of the triangle: negative weights count as 0.
    #[inline(always)]
    fn weights(&self, positions: &[[Lanes; 3]; 3], projector: &Projector) -> ([Lanes; 3], Lanes) {
        let (mut weights, mut sides) = ([[0.0; BLOCK]; 3], [0.0; BLOCK]);
        for lane in 0..BLOCK {
            let (across, upward) = projector.plane(self.x[lane], self.y);
            let corner = |corner: usize| {
                let [x, y, z] = &positions[corner];
                let position = DVec3::new(x[lane], y[lane], z[lane]);
                if projector.orthographic { position - across - upward } else { position }
            };
            let (p, q, r) = (corner(0), corner(1), corner(2));
            let ray = if projector.orthographic { projector.forward } else { projector.forward + across + upward };
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
        (weights, sides)
    }

    /// Writes the value of each hit if the channel was requested.
    #[inline(always)]
    fn put(&self, channel: Channel, values: &Lanes, out: &mut Samples) {
        let samples = out.from(channel, self.start);
        if samples.is_empty() {
            return;
        }
        let mut rounded = [0.0; BLOCK];
        for lane in 0..BLOCK {
            rounded[lane] = values[lane] as f32;
        }
        let (first, count) = (self.hits[0].column, self.hits.len());
        if self.hits[count - 1].column - first == count - 1 {
            samples[first..first + count].copy_from_slice(&rounded[..count]);
        } else {
            for (hit, value) in self.hits.iter().zip(rounded) {
                samples[hit.column] = value;
            }
        }
    }

    /// Writes one value at all hits.
    #[inline(always)]
    fn put_all(&self, channel: Channel, value: f32, out: &mut Samples) {
        let samples = out.from(channel, self.start);
        if !samples.is_empty() {
            self.hits.iter().for_each(|hit| samples[hit.column] = value);
        }
    }
}
