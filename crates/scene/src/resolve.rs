//! Interpolates the attributes of visible triangles at the samples that see them.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;

use crate::channel::{NORMALS, RESTS, TRAILS};
use crate::raster::{NOTHING, Row};
use crate::shading::unit_or_up;
use crate::surface::Mesh;
use crate::{Channel, ChannelSet, Projector, Samples, Visible};

/// Number of hits that are processed side by side, in vectors.
const BLOCK: usize = 32;

/// A value at each hit of a block; values beyond the last hit are never read.
type Lanes = [f64; BLOCK];

/// A sample that sees a triangle.
struct SampleHit {
    /// Index of the sample within its row.
    column: usize,
    surface: usize,
    triangle: [u32; 3],
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
                let local = (primitive - self.firsts[surface]) as usize;
                let triangle = self.layers[surface].triangles(local)[(number % 2) as usize];
                hits.push(SampleHit { column, surface, triangle });
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
        let (mesh, projector) = (block.mesh, &self.projector);
        block.put_all(Channel::Coverage, 1.0, out);
        block.put_all(Channel::Surface, block.hits[0].surface as f32, out);
        let positions = block.gather(&mesh.positions);
        let (weights, sides) = block.weights(&positions, projector);
        let offset = blend(&positions, &weights);
        let [x, y, z] = &offset;
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
                    value[lane] = eye[axis] + offset[axis][lane];
                }
                block.put(channel, &value, out);
            }
        }
        let mut height = [0.0; BLOCK];
        for lane in 0..BLOCK {
            height[lane] = projector.position.y + y[lane] - mesh.level;
        }
        block.put(Channel::Height, &height, out);
        if wanted.intersects(NORMALS) {
            self.answer_normals(block, &weights, &sides, out);
        }
        if wanted.intersects(RESTS.union(ChannelSet::UV)) {
            self.answer_rests(block, &weights, &offset, &height, out);
        }
        let attribute = |channel: Channel, values: &[f32], out: &mut Samples| {
            if !wanted.contains(channel) {
                return;
            }
            if values.is_empty() {
                block.put_all(channel, channel.background(), out);
            } else {
                let [value] = blend(&block.gather(values.as_chunks::<1>().0), &weights);
                block.put(channel, &value, out);
            }
        };
        attribute(Channel::SlopeVariance, &mesh.slope_variances, out);
        if wanted.intersects(TRAILS) {
            for (values, channel) in mesh.trails.iter().zip(Channel::TRAILS) {
                attribute(channel, values, out);
            }
        }
    }

    #[inline(always)]
    fn answer_normals(&self, block: &Block<'_>, weights: &[Lanes; 3], sides: &Lanes, out: &mut Samples) {
        let mesh = block.mesh;
        if mesh.normals.is_empty() {
            for channel in NORMALS.iter() {
                block.put_all(channel, channel.background(), out);
            }
            return;
        }
        let [mut x, mut y, mut z] = blend(&block.gather(&mesh.normals), weights);
        if mesh.displaced {
            block.put(Channel::Jacobian, &y, out);
        } else {
            block.put_all(Channel::Jacobian, 1.0, out);
        }
        // The normal is flipped on a side that faces away, as in a fold.
        let own = if mesh.inside { 1.0 } else { -1.0 };
        for lane in 0..BLOCK {
            let normal = unit_or_up(DVec3::new(x[lane], y[lane], z[lane])) * (own * sides[lane]);
            (x[lane], y[lane], z[lane]) = (normal.x, normal.y, normal.z);
        }
        block.put(Channel::NormalX, &x, out);
        block.put(Channel::NormalY, &y, out);
        block.put(Channel::NormalZ, &z, out);
    }

    #[inline(always)]
    fn answer_rests(
        &self,
        block: &Block<'_>,
        weights: &[Lanes; 3],
        offset: &[Lanes; 3],
        height: &Lanes,
        out: &mut Samples,
    ) {
        let (mesh, eye) = (block.mesh, self.projector.position);
        // A surface without rest points rests at its position.
        let [rest_x, rest_z] =
            if mesh.rests.is_empty() { [offset[0], offset[2]] } else { blend(&block.gather(&mesh.rests), weights) };
        // Height of the rest point above the level, for models.
        let mut risen = [0.0; BLOCK];
        if !mesh.rest_heights.is_empty() {
            let [heights] = blend(&block.gather(mesh.rest_heights.as_chunks::<1>().0), weights);
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
            moved[lane] = DVec3::new(offset[0][lane] - rest_x[lane], up, offset[2][lane] - rest_z[lane]).length();
        }
        block.put(Channel::RestX, &x, out);
        block.put(Channel::RestY, &y, out);
        block.put(Channel::RestZ, &z, out);
        block.put(Channel::RestDistance, &moved, out);
        let [u, v] = if mesh.uvs.is_empty() { [x, z] } else { blend(&block.gather(&mesh.uvs), weights) };
        block.put(Channel::U, &u, out);
        block.put(Channel::V, &v, out);
    }
}

impl Block<'_> {
    /// Gathers the attributes of the corners of each triangle, by corner and component.
    #[inline(always)]
    fn gather<const N: usize>(&self, values: &[[f32; N]]) -> [[Lanes; N]; 3] {
        let mut gathered = [[[0.0; BLOCK]; N]; 3];
        for (lane, hit) in self.hits.iter().enumerate() {
            for corner in 0..3 {
                let value = values[hit.triangle[corner] as usize];
                for component in 0..N {
                    gathered[corner][component][lane] = f64::from(value[component]);
                }
            }
        }
        gathered
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

/// Returns Σ wᵢvᵢ over the corners, by component.
#[inline(always)]
fn blend<const N: usize>(values: &[[Lanes; N]; 3], weights: &[Lanes; 3]) -> [Lanes; N] {
    let mut blended = [[0.0; BLOCK]; N];
    for component in 0..N {
        for lane in 0..BLOCK {
            blended[component][lane] = values[0][component][lane] * weights[0][lane]
                + values[1][component][lane] * weights[1][lane]
                + values[2][component][lane] * weights[2][lane];
        }
    }
    blended
}

#[cfg(test)]
#[path = "resolve_tests.rs"]
mod tests;
