//! The triangles that block rays, their boxes, and the parts that a tree is made of.

use super::bounds::Bounds;
use crate::surface::{Mesh, Topology};
use crate::{ChannelSet, Projector, Surface};
use glam::Vec3;
use rayon::prelude::*;

/// Width by which the box of a triangle is larger on each side, relative to the triangle's longest side: enough for
/// points that a ray may meet beyond an edge, and for the rounding error of their distance.
const MARGIN: f32 = 2e-5;
/// Number of cells along each side of the parts of a grid, a power of two.
const CELLS: usize = 16;
/// The cells of such a part, so that any eighth of them, and any eighth of that, are neighbors (Morton order).
const IN_ORDER: [[usize; 2]; CELLS * CELLS] = in_order();

/// Triangles by their corners.
#[derive(Debug, Default)]
pub(super) struct Facets {
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Neighboring triangles that follow one another in the list. Those next to each other in the list are also neighbors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) bounds: Bounds,
    pub(super) first: u32,
    pub(super) count: u32,
}

impl Facets {
    /// Tessellates surfaces for a camera, and returns the triangles, and parts with all of them except those that reach
    /// beyond the range of f32.
    ///
    /// # Panics
    /// The surfaces have 2³² vertices, or 2³⁰ triangles, or more in total.
    pub(super) fn of(projector: &Projector, surfaces: &[&dyn Surface]) -> (Self, Vec<Part>) {
        let (mut facets, mut parts) = (Self::default(), Vec::new());
        for surface in surfaces {
            let mesh = surface.tessellate(projector, ChannelSet::EMPTY);
            let vertex = u32::try_from(facets.positions.len()).expect("fewer than 2³² vertices");
            facets.positions.extend(mesh.positions.iter().copied().map(Vec3::from));
            assert!(u32::try_from(facets.positions.len()).is_ok(), "fewer than 2³² vertices");
            let first = facets.triangles.len();
            facets.add(&mesh, vertex);
            assert!(facets.triangles.len() < 1 << 30, "fewer than 2³⁰ triangles");
            parts.par_extend(
                runs(&mesh.topology).flat_map_iter(|[start, count]| facets.parts((first + start) as u32, count as u32)),
            );
        }
        (facets, parts)
    }

    /// Returns a triangle's corners.
    #[inline(always)]
    pub(super) fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize])
    }

    /// Returns a triangle's box.
    pub(super) fn bounds(&self, triangle: u32) -> Bounds {
        let Bounds { low, high } = Bounds::of(self.corners(triangle));
        let margin = MARGIN * (high - low).max_element();
        Bounds { low: low - margin, high: high + margin }
    }

    /// Adds the triangles of a mesh whose first vertex has this number: those of a grid block by block.
    fn add(&mut self, mesh: &Mesh, vertex: u32) {
        match &mesh.topology {
            Topology::Grid { columns, rows } => {
                let [across, along] = cells(*columns, *rows);
                let corner = |at: [usize; 2]| vertex + (at[1] * columns + at[0]) as u32;
                let blocks = (0..along.div_ceil(CELLS)).into_par_iter().flat_map_iter(|block| {
                    (0..across).step_by(CELLS).flat_map(move |column| {
                        let cells = IN_ORDER.iter().map(move |[x, y]| [column + x, block * CELLS + y]);
                        cells.filter(move |[x, y]| *x < across && *y < along)
                    })
                });
                self.triangles.par_extend(blocks.flat_map_iter(|[x, y]| {
                    let [a, b, c, d] = [[x, y], [x, y + 1], [x + 1, y], [x + 1, y + 1]].map(corner);
                    [[a, b, c], [c, b, d]]
                }));
            }
            Topology::Triangles(triangles) => {
                self.triangles.extend(triangles.iter().map(|triangle| triangle.map(|corner| corner + vertex)));
            }
        }
    }

    fn part(&self, first: u32, count: u32) -> Part {
        let bounds = (first..first + count).map(|triangle| self.bounds(triangle)).fold(Bounds::NOTHING, Bounds::union);
        Part { bounds, first, count }
    }

    /// Returns one part of a run of triangles, or one of each within the range of f32 if others are beyond it.
    fn parts(&self, first: u32, count: u32) -> impl Iterator<Item = Part> + '_ {
        let all = self.part(first, count);
        let alone = if all.bounds.is_finite() { 0 } else { count };
        let singles = (first..first + alone).map(|triangle| self.part(triangle, 1));
        std::iter::once(all).chain(singles).filter(|part| part.bounds.is_finite())
    }
}

const fn in_order() -> [[usize; 2]; CELLS * CELLS] {
    let mut places = [[0; 2]; CELLS * CELLS];
    let mut index = 0;
    while index < places.len() {
        let mut bit = 0;
        while 1 << bit < CELLS {
            places[index][0] |= (index >> (2 * bit) & 1) << bit;
            places[index][1] |= (index >> (2 * bit + 1) & 1) << bit;
            bit += 1;
        }
        index += 1;
    }
    places
}

/// Returns the numbers of cells of a grid across and along.
fn cells(columns: usize, rows: usize) -> [usize; 2] {
    [columns, rows].map(|vertices| vertices.saturating_sub(1))
}

/// Returns the runs of triangles of a mesh that make parts, each by its start and its length.
fn runs(topology: &Topology) -> impl IndexedParallelIterator<Item = [usize; 2]> + '_ {
    let count = match topology {
        Topology::Grid { columns, rows } => {
            let [across, along] = cells(*columns, *rows).map(|cells| cells.div_ceil(CELLS));
            across * along
        }
        Topology::Triangles(triangles) => triangles.len(),
    };
    (0..count).into_par_iter().map(move |index| match topology {
        Topology::Grid { columns, rows } => {
            let [across, along] = cells(*columns, *rows);
            let blocks = across.div_ceil(CELLS);
            let [column, row] = [index % blocks * CELLS, index / blocks * CELLS];
            let [width, height] = [CELLS.min(across - column), CELLS.min(along - row)];
            [2 * (row * across + column * height), 2 * width * height]
        }
        Topology::Triangles(_) => [index, 1],
    })
}
