//! Models made of patches, placed in the world.

use std::sync::Arc;

use glam::DVec3;

use super::ball::Ball;
use super::{Bicubic, Bilinear};
use crate::boxes::Tree;

/// Most patches of one model.
pub const MAX_PATCHES: usize = 1 << 16;
/// Most straight pieces of a patch's edge.
pub const MAX_SEGMENTS: usize = 256;

/// A patch with its texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Control points.
    pub shape: Bicubic,
    /// Texture coordinates at (u, v) = (0, 0) and (1, 1).
    pub uv: [[f64; 2]; 2],
}

impl Patch {
    /// Makes a patch whose texture coordinates are its u and v.
    pub fn new(shape: Bicubic) -> Self {
        Self { shape, uv: [[0.0; 2], [1.0; 2]] }
    }

    /// The patch of 4 control points, bilinear, or of 16.
    ///
    /// # Errors
    /// There are so many instead.
    pub fn of(points: &[DVec3]) -> Result<Self, usize> {
        if let Ok(points) = points.try_into() {
            return Ok(Self::new(Bilinear { points }.elevate()));
        }
        let points = points.try_into().map_err(|_| points.len())?;
        Ok(Self::new(Bicubic { points }))
    }
}

/// Placement of a model: it is scaled, then rotated about x, then y, then z, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Scale factors along the model's own axes.
    pub scale: DVec3,
    /// Angles about x, y and z, in radians, applied in this order.
    pub rotate: DVec3,
    /// Position of the model's origin, in meters.
    pub translate: DVec3,
}

impl Default for Placement {
    fn default() -> Self {
        Self { scale: DVec3::ONE, rotate: DVec3::ZERO, translate: DVec3::ZERO }
    }
}

impl Placement {
    /// Returns the world position of a point of the model.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        let point = point * self.scale;
        let turn = |a: f64, b: f64, angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            (a * cos - b * sin, a * sin + b * cos)
        };
        let (y, z) = turn(point.y, point.z, self.rotate.x);
        let (z, x) = turn(z, point.x, self.rotate.y);
        let (x, y) = turn(x, y, self.rotate.z);
        // −0 and 0 are the same position, so that edges which neighbors share have the same bits.
        DVec3::new(x, y, z) + self.translate + DVec3::ZERO
    }

    /// Returns whether it mirrors shapes.
    pub fn mirrors(&self) -> bool {
        self.scale.x * self.scale.y * self.scale.z < 0.0
    }
}

/// How patches become triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tessellation {
    /// As many as the picture needs: facets are at most `tolerance` pixels off the surface; more than 0.
    Adaptive {
        /// Largest distance, in pixels.
        tolerance: f64,
    },
    /// The same number on every edge, up to [`MAX_SEGMENTS`].
    Uniform {
        /// Number of pieces of each edge.
        segments: u32,
    },
}

/// A patch in the world.
#[derive(Clone, Debug)]
pub(super) struct PlacedPatch {
    pub(super) shape: Bicubic,
    /// Patch from which normals are computed.
    pub(super) for_normals: Bicubic,
    /// The patch in the model's own space.
    pub(super) rest: Bicubic,
    uv: [[f64; 2]; 2],
    pub(super) ball: Ball,
}

impl PlacedPatch {
    /// Returns the texture coordinates at (u, v).
    pub(super) fn uv(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.uv[0][axis] + (self.uv[1][axis] - self.uv[0][axis]) * place[axis])
    }

    /// Returns (u, v) of the patch at texture coordinates, if it contains them. An edge between patches belongs to
    /// the patch that begins there, and the last edge, at 1, to the patch that ends there.
    pub(super) fn place(&self, uv: [f64; 2]) -> Option<[f64; 2]> {
        let share = |axis: usize| {
            let [from, to] = [self.uv[0][axis], self.uv[1][axis]];
            let inside = uv[axis] >= from && (uv[axis] < to || (uv[axis] == to && to == 1.0));
            inside.then(|| (uv[axis] - from) / (to - from))
        };
        Some([share(0)?, share(1)?])
    }
}

/// A surface of Bézier patches.
///
/// Rest points are in the model's own space, before it is placed, so that textures stay on it. Patches are visible
/// from both sides; the outer side is that of ∂P/∂u × ∂P/∂v in the model, even if the placement mirrors it.
#[derive(Clone, Debug)]
pub struct PatchModel {
    pub(super) placed: Vec<PlacedPatch>,
    /// Boxes around the patches; `None` if there are none.
    pub(super) boxes: Option<Arc<Tree>>,
    pub(super) ball: Ball,
    pub(super) tessellation: Tessellation,
    /// Whether the normal of the placed control points points to the inner side.
    pub(super) turned: bool,
    pub(super) level: f64,
}

impl PatchModel {
    /// Places patches; with `flip` the outer side is swapped. Heights are measured from world y = 0.
    pub fn new(patches: &[Patch], placement: Placement, flip: bool, tessellation: Tessellation) -> Self {
        let placed = patches
            .iter()
            .map(|patch| {
                let shape = patch.shape.map(|point| placement.apply(point));
                let (low, high) = shape.bounds();
                let ball = Ball::around(low, high);
                PlacedPatch { shape, for_normals: shape.for_normals(), rest: patch.shape, uv: patch.uv, ball }
            })
            .collect::<Vec<_>>();
        let bounds: Vec<[DVec3; 2]> = placed.iter().map(|placed| placed.shape.bounds().into()).collect();
        let all = bounds.iter().copied().reduce(|[low, high], [a, b]| [low.min(a), high.max(b)]);
        let [low, high] = all.unwrap_or_default();
        let (ball, boxes) = (Ball::around(low, high), Tree::new(&bounds).map(Arc::new));
        Self { placed, boxes, ball, tessellation, turned: placement.mirrors() != flip, level: 0.0 }
    }

    /// Returns the patches in the world.
    pub fn shapes(&self) -> impl Iterator<Item = &Bicubic> {
        self.placed.iter().map(|placed| &placed.shape)
    }
}
