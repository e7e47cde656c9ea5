//! Turns meshes into triangles on the picture: fixed-point projection, clipping and binning.

mod clip;
mod layer;
mod part;

use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;

use crate::Projector;
pub(crate) use layer::{Binned, Layer};
pub(crate) use part::{PictureOfPart, SIDES};

/// Nearest depth that a perspective camera sees, in meters.
const NEAR_M: f64 = 1e-4;
/// Size of a bin, in pixels: wide and low, like the far sea.
pub(crate) const BIN: [i64; 2] = [64, 16];
/// Number of primitives that one task projects.
const TASK: usize = 1 << 14;
/// Number of vertices that are projected side by side, in vectors.
const WIDE: usize = 8;

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

/// Clips and projects meshes.
struct MeshProjector<'a> {
    projector: &'a Projector,
    raster: Raster,
    bins: [i64; 2],
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
                || self.project(positions, screen, codes)
            ));
        });
        (screen, codes)
    }

    #[inline(always)]
    fn project(&self, positions: &[[f32; 3]], screen: &mut [ScreenVertex], codes: &mut [u8]) {
        let groups = positions.chunks(WIDE).zip(screen.chunks_mut(WIDE)).zip(codes.chunks_mut(WIDE));
        for ((positions, screen), codes) in groups {
            let mut group = [[0.0; 3]; WIDE];
            group[..positions.len()].copy_from_slice(positions);
            let (group, sides) = self.side_by_side(group);
            screen.copy_from_slice(&group[..positions.len()]);
            codes.copy_from_slice(&sides[..positions.len()]);
        }
    }

    /// Does the same for a group of vertices. Each step is a loop over copies of numbers, which becomes vectors.
    #[inline(always)]
    fn side_by_side(&self, positions: [[f32; 3]; WIDE]) -> ([ScreenVertex; WIDE], [u8; WIDE]) {
        let mut at = [[0.0; WIDE]; 3];
        for (lane, position) in positions.iter().enumerate() {
            [at[0][lane], at[1][lane], at[2][lane]] = *position;
        }
        let (mut x, mut y, mut key, mut code) = ([0; WIDE], [0; WIDE], [0.0; WIDE], [0; WIDE]);
        for lane in 0..WIDE {
            let (vertex, sides) = self.vertex(self.view([at[0][lane], at[1][lane], at[2][lane]]));
            (x[lane], y[lane], key[lane], code[lane]) = (vertex.x, vertex.y, vertex.key, sides);
        }
        let vertex = |lane: usize| ScreenVertex { x: x[lane], y: y[lane], key: key[lane] };
        (std::array::from_fn(vertex), code.map(|code| code as u8))
    }

    #[inline(always)]
    fn vertex(&self, view: [f64; 3]) -> (ScreenVertex, u64) {
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
            code |= if distance < 0.0 { u64::from(bit) } else { 0 };
        }
        let (scale, key) = if p.orthographic {
            (p.scale, -view[2])
        } else {
            (p.scale / view[2].max(NEAR_M), 1.0 / view[2].max(NEAR_M))
        };
        let (x, y) = (half[0] + view[0] * scale, half[1] - view[1] * scale);
        let is_beyond = (x.abs() >= self.raster.limit) | (y.abs() >= self.raster.limit);
        code |= if is_beyond { u64::from(outside::LIMIT) } else { 0 };
        // Values past the limit saturate; only clipped triangles would read them.
        let fix = |pixels: f64| self.raster.whole(pixels) as i32;
        (ScreenVertex { x: fix(x), y: fix(y), key: key as f32 }, code)
    }
}
