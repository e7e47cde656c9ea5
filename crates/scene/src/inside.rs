//! What the tests of this crate see beside its interface. They stand outside, in `tests/scene`, so that the crate is not
//! compiled a second time for them. Nothing of it is part of the interface.

pub use crate::first_hit::inside as first_hit;
pub use crate::patches::point_of;

use crate::bezier::stitch::Cut;
use crate::edges::{Edges, Whole};
use crate::extent::{Bounds, Sector};
use crate::grid_ranges::{Range, Ranges, SIZES};
use crate::project::ScreenVertex;
use crate::raster::{NOTHING, SeenTriangle};
use crate::shading::power;
use crate::{
    ChannelSet, DVec3, GivenUp, GridSurface, HeightField, Mesh, Obstacles, Patches, Projector, Ray, SeaSurface,
    Segment, Visible,
};
use trochoid_image::Window;
use trochoid_sea::Sample;

/// Returns the origin of the corners of obstacles, and the corners of their triangles.
pub fn triangles(obstacles: &Obstacles) -> (DVec3, Vec<[[f32; 3]; 3]>) {
    obstacles.triangles()
}

/// Returns the distance to the first point along each ray and whether there is any, with the slowest instructions.
pub fn slowly(obstacles: &Obstacles, segments: &[Segment]) -> Vec<(Option<f64>, bool)> {
    obstacles.slowly(segments)
}

/// Joins meshes of files.
///
/// # Errors
/// There are too many vertices or triangles.
#[cfg(feature = "files")]
pub fn joined(parts: Vec<crate::Triangles>) -> Result<crate::Triangles, crate::files::MeshFault> {
    crate::files::joined(parts)
}

/// Cuts the edges of a patch, and its inside along u and v. Returns the number of vertices, (u, v) of the inner ones, and
/// the triangles.
pub fn cut(edges: [usize; 4], inner: [usize; 2]) -> (usize, Vec<[f64; 2]>, Vec<[u32; 3]>) {
    let cut = Cut { edges, inner };
    (cut.vertices(), cut.inner_points().collect(), cut.triangles())
}

/// Returns log(1 + x) for x in [−1, 0].
pub fn log1p(x: f32) -> f32 {
    power::log1p(x)
}

/// Returns e to the power y ≤ 0, or NaN.
pub fn exp(y: f32) -> f32 {
    power::exp(y)
}

/// Edge functions of a triangle at one position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeValues {
    /// The functions.
    pub functions: [i64; 3],
    /// Whether the position belongs to the triangle.
    pub inside: bool,
    /// Bits of the key there.
    pub key: u64,
}

/// Returns the edge functions of a triangle of corners with keys, from a starting position and by a displacement, by
/// whole numbers of 64 bits and by f64; `None` for a triangle without area.
pub fn edge_values(corners: [([i32; 2], f32); 3], from: [i64; 2], by: [i64; 2]) -> [Option<EdgeValues>; 2] {
    [
        edge_values_by(corners, from, by, |value: i64| value),
        edge_values_by(corners, from, by, |value: f64| value as i64),
    ]
}

/// Does the same by whole numbers of 32 bits, for small triangles.
pub fn narrow_edge_values(corners: [([i32; 2], f32); 3], from: [i64; 2], by: [i64; 2]) -> Option<EdgeValues> {
    edge_values_by(corners, from, by, |value: i32| i64::from(value))
}

fn edge_values_by<I: Whole>(
    corners: [([i32; 2], f32); 3],
    from: [i64; 2],
    by: [i64; 2],
    to: fn(I) -> i64,
) -> Option<EdgeValues> {
    let corners = corners.map(|([x, y], key)| ScreenVertex { x, y, key });
    let edges = Edges::<I>::new(corners, from)?;
    let change = edges.change(I::of(by[0]), I::of(by[1]));
    let at = [0, 1, 2].map(|edge| edges.first[edge] + change[edge]);
    let inside = Edges::inside(at) >= I::of(0);
    Some(EdgeValues { functions: at.map(to), inside, key: edges.key(at).to_bits() })
}

/// Returns the slope variance of the waves of a sea that a footprint filters out, and how far it may be off.
pub fn roughness(sea: &SeaSurface, footprint: f64) -> Option<(f64, f64)> {
    sea.limits().roughness(footprint)
}

/// Part of a sea's plane that a camera may see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenSector {
    /// Whether it is a full circle.
    pub closed: bool,
    /// Its angle, in radians.
    pub width: f64,
    /// Its least and greatest distance.
    pub radii: [f64; 2],
}

/// Returns the sector of a sea at a level whose points rise and move by so much; `None` if it is out of sight.
pub fn sector(projector: &Projector, level: f64, rise: f64, reach: f64) -> Option<SeenSector> {
    let sector = Sector::new(projector, level, Bounds { rise, reach, usual: rise })?;
    Some(SeenSector { closed: sector.closed(), width: sector.width, radii: sector.radii })
}

/// Distance beyond which no sea is seen, in meters.
pub const HORIZON_M: f64 = crate::extent::HORIZON_M;

/// Returns the distance where a ray first crosses a height field, at most so far into its slab.
pub fn first_of_grid(grid: &GridSurface, ray: &Ray, most: f64) -> Option<f64> {
    let [start, end] = grid.within_slab(ray)?;
    crate::grid_ray::first_of_grid(grid, ray, [start, end.min(most)]).map(|crossing| crossing.distance)
}

/// Ranges of a height field over its cells and blocks of cells.
pub struct GridRanges(Ranges);

impl GridRanges {
    /// Finds them.
    pub fn new(grid: &GridSurface) -> Self {
        Self(Ranges::new(grid))
    }

    /// Returns least and greatest height over a cell.
    pub fn cell(&self, cell: [usize; 2]) -> [f64; 2] {
        let Range { low, high } = self.0.cell(cell);
        [low, high]
    }

    /// Returns those over the blocks that contain a cell, from the largest block.
    pub fn blocks(&self, cell: [usize; 2]) -> [[f64; 2]; SIZES.len()] {
        std::array::from_fn(|level| {
            let Range { low, high } = self.0.block(level, cell);
            [low, high]
        })
    }
}

/// Returns the first point of a sea on a ray between two distances, found for this ray alone: its distance, and the rest
/// point x, z.
///
/// # Errors
/// The sea is too rough to search.
pub fn first_point(
    sea: &SeaSurface,
    projector: &Projector,
    ray: &Ray,
    stretch: [f64; 2],
) -> Result<Option<(f64, [f64; 2])>, GivenUp> {
    crate::first_point::first_point(sea, projector, ray, stretch)
}

/// Returns a lower bound of every footprint at a level, over a range of distances ahead of the camera.
pub fn least_footprint(projector: &Projector, level: f64, ahead: [f64; 2]) -> f64 {
    crate::footprint::least_footprint(projector, level, ahead)
}

/// Returns how far a sea reaches above and below its level, in meters.
pub fn summit(sea: &SeaSurface) -> f64 {
    sea.summit
}

/// Returns the horizontal unit vector x, z along which a camera looks.
pub fn heading(projector: &Projector) -> [f64; 2] {
    projector.heading()
}

/// Returns the vectors across and upward from the middle of the picture to a place in it, at depth 1 or, if rays are
/// parallel, at any.
pub fn plane(projector: &Projector, [x, y]: [f64; 2]) -> (DVec3, DVec3) {
    projector.plane(x, y)
}

/// Returns a field of heights with all channels.
pub fn heights(grid: &GridSurface) -> HeightField {
    HeightField::new(grid, ChannelSet::ALL)
}

/// Returns the footprint at a rest point of a sea.
pub fn footprint_of(sea: &SeaSurface, projector: &Projector, rest: DVec3) -> f64 {
    sea.footprint(projector, rest)
}

/// Returns where the waves carry a rest point x, z, and the sea there.
pub fn carried(sea: &SeaSurface, projector: &Projector, rest: [f64; 2]) -> (DVec3, Sample) {
    let there = sea.carried(projector, rest);
    (there.point, there.precise.sample)
}

/// Makes patches from positions and first derivatives, row by row.
pub fn patches(
    columns: usize,
    positions: &[[f32; 3]],
    tangents: Vec<[[f32; 3]; 2]>,
    steps: Vec<f32>,
    closed: bool,
) -> Patches {
    Patches::new(columns, positions, tangents, steps, closed)
}

/// Returns the triangles that a sample of each pixel of a window sees, row by row, each by its primitive and index there;
/// `None` for nothing.
pub fn look(visible: &Visible, window: Window, offset: [f64; 2]) -> Vec<Option<[u32; 2]>> {
    let mut triangles = Vec::new();
    visible.look(window, offset, |seen| {
        let numbers = pixels(window).map(|[x, y]| seen.triangle(x, y));
        triangles.extend(numbers.map(|number| {
            let SeenTriangle { primitive, part, .. } = SeenTriangle::unpack(number);
            (number != NOTHING).then_some([primitive, part])
        }));
    });
    triangles
}

/// Does the same one triangle after the other, by edge functions in i64.
pub fn nearest(visible: &Visible, window: Window, offset: [f64; 2]) -> Vec<Option<[u32; 2]>> {
    let sheets = visible.nearest_sheets(window, offset);
    let first = |pixel| sheets.at(pixel)[0].map(|sheet| [sheet.primitive(), sheet.part() as u32]);
    pixels(window).map(first).collect()
}

fn pixels(window: Window) -> impl Iterator<Item = [i64; 2]> {
    (window.y0..window.y1).flat_map(move |y| (window.x0..window.x1).map(move |x| [x, y]))
}

/// Returns a triangle of a primitive: its surface, the mesh of this surface as it was cut, and its vertices.
pub fn triangle(visible: &Visible, [primitive, part]: [u32; 2]) -> (usize, &Mesh, [u32; 3]) {
    let surface = visible.layer(primitive);
    let layer = &visible.layers[surface];
    let triangles = layer.triangles((primitive - visible.firsts[surface]) as usize);
    (surface, &layer.mesh, triangles[part as usize])
}

/// Returns an offset within a pixel as it is rounded for edge functions.
pub fn rounded(visible: &Visible, offset: f64) -> f64 {
    visible.raster.fix(offset) as f64 / f64::from(1_u32 << visible.raster.bits)
}
