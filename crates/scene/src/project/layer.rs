//! A mesh on the picture, and the bins of its primitives.

use rayon::prelude::*;

use super::clip::ClippedTriangle;
use super::{BIN, MeshProjector, Raster, ScreenVertex, TASK, outside};
use crate::Projector;
use crate::surface::{Mesh, Topology};

/// A mesh on the picture.
#[derive(Debug)]
pub(crate) struct Layer {
    pub(crate) mesh: Mesh,
    pub(crate) screen: Vec<ScreenVertex>,
    /// Triangles made by clipping, which follow the mesh's own primitives.
    pub(crate) clipped: Vec<[u32; 3]>,
    /// The primitive of which each of these is a part, and the index of its triangle.
    pub(super) clipped_from: Vec<(u32, u32)>,
    /// Number of the mesh's own primitives.
    pub(crate) primitives: usize,
}

/// Bin and number of a primitive.
pub(crate) type Binned = (u32, u32);

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
            .with_max_len(1)
            .map(|task| {
                let (mut binned, mut clipped) = (Vec::new(), Vec::new());
                let task = task * TASK..((task + 1) * TASK).min(primitives);
                match &layer.mesh.topology {
                    Topology::Triangles(triangles) => {
                        for (primitive, triangle) in task.clone().zip(&triangles[task]) {
                            layer.sort(
                                &stage,
                                primitive,
                                *triangle,
                                [*triangle],
                                &codes,
                                first,
                                &mut binned,
                                &mut clipped,
                            );
                        }
                    }
                    Topology::Grid { columns, .. } => {
                        let mut row = task.start / (columns - 1);
                        for primitive in task {
                            if primitive == (row + 1) * (columns - 1) {
                                row += 1;
                            }
                            // A row has one more vertex than it has cells.
                            let triangles = cell_corners((primitive + row) as u32, *columns as u32);
                            let [[a, b, c], [_, d, _]] = triangles;
                            let corners = [a, b, c, d];
                            layer.sort(&stage, primitive, corners, triangles, &codes, first, &mut binned, &mut clipped);
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
    fn sort<const N: usize, const CORNERS: usize>(
        &self,
        stage: &MeshProjector<'_>,
        primitive: usize,
        corners: [u32; CORNERS],
        triangles: [[u32; 3]; N],
        codes: &[u8],
        first: u32,
        binned: &mut Vec<Binned>,
        clipped: &mut Vec<ClippedTriangle>,
    ) {
        let codes = corners.iter().map(|vertex| codes[*vertex as usize]);
        let (all, any) = codes.fold((u8::MAX, 0), |(all, any), code| (all & code, any | code));
        if all & !outside::LIMIT != 0 {
            return;
        }
        if any & (outside::NEAR | outside::LIMIT) == 0 {
            let corners = corners.into_iter().map(|vertex| self.screen[vertex as usize]);
            stage.bin(corners, first + primitive as u32, binned);
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
}

impl MeshProjector<'_> {
    /// Puts a primitive into all bins that its bounding box touches.
    #[inline(always)]
    pub(super) fn bin(&self, corners: impl Iterator<Item = ScreenVertex>, primitive: u32, out: &mut Vec<Binned>) {
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

/// Returns the vertices of both triangles of a grid's cell, given its upper left vertex.
#[inline(always)]
fn cell_corners(a: u32, columns: u32) -> [[u32; 3]; 2] {
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
