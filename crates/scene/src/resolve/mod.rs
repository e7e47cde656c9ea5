//! Interpolates the attributes of visible triangles at the samples that see them.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

mod blend;
mod block;
mod hits;

use std::cell::RefCell;

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;

use crate::channel::{CURVED, NORMALS, RESTS, TRAILS};
use crate::on_heights::{self, HeightField, HeightView};
use crate::patches::{Cells, Met, PatchView, Starts};
use crate::raster::Row;
use crate::surface::{Between, Topology};
use crate::{Channel, ChannelSet, Targets, Visible};
use blend::{Blend, gather};
use block::Block;
use hits::{Hits, Sorter};

/// Number of hits that are processed side by side, in vectors.
pub(crate) const BLOCK: usize = 64;

/// Channels that are blended from vertices, besides points and normals.
const BLENDED: ChannelSet =
    RESTS.union(ChannelSet::UV).union(ChannelSet::of(&[Channel::Jacobian, Channel::SlopeVariance]));

/// A value at each hit of a block; values beyond the last hit are never read.
pub(crate) type Lanes = [f64; BLOCK];

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

impl Visible {
    /// Interpolates the attributes of the visible triangles; writes the background where there is none.
    pub(crate) fn resolve<'s>(
        &self,
        rows: impl Iterator<Item = Row<'s>>,
        offset: [f64; 2],
        wanted: ChannelSet,
        out: &mut Targets<'_>,
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
        out: &mut Targets<'_>,
    ) {
        let Scratch { waiting, work } = scratch;
        let waiting = &mut waiting[..self.layers.len()];
        // A panic may have left some behind.
        waiting.iter_mut().for_each(|hits| hits.count = 0);
        let mut sorter = Sorter::new(self, rows, offset);
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
        out: &mut Targets<'_>,
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
        out: &mut Targets<'_>,
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
        out: &mut Targets<'_>,
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
        out: &mut Targets<'_>,
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
    fn put_points(&self, block: &Block<'_>, points: &[Lanes; 3], wanted: ChannelSet, out: &mut Targets<'_>) -> Lanes {
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
        out: &mut Targets<'_>,
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
