use std::sync::{Arc, OnceLock};

use glam::DVec3;
use rayon::prelude::*;

use crate::channel::CURVED;
use crate::grid_ranges::Ranges;
use crate::grid_ray::{Crossing, first_of_grid};
use crate::grid_values::{GridDoubt, Number, Trails, Weights, second, square, weights};
use crate::meet_near::meet_grid;
use crate::on_heights::HeightField;
use crate::points::MeshHit;
use crate::shading::unit_or_up;
use crate::surface::{Anchor, Asked, Between, Exact, GivenUp, Hit, Mesh, Met, OneSheet, Sight, Surface, Topology};
use crate::{ChannelSet, Projector, Ray, Resting};

/// Largest chord error of a cell, in pixels, at its nearest point and at a crest three times as sharp as the root
/// mean square.
const CHORD_PX: f64 = 0.2;
/// The same for views, which meet the surface itself wherever its contours do not decide what is seen.
const CONTOUR_PX: f64 = 0.1;
const CREST: f64 = 3.0;
/// Most vertices that cuts may make, per pixel of the picture, and the least value of this limit.
const VERTICES_PER_PIXEL: f64 = 1.5;
const LEAST_LIMIT: f64 = 1e6;
/// Most parts of a cell's side.
const MAX_PARTS: f64 = 8.0;

/// A finite height field on a regular grid, smooth between its cells.
///
/// Heights between cells are bicubic Catmull–Rom interpolations, with the cells of the edge repeated beyond it;
/// slopes are those of the interpolation. There is no surface outside of the grid.
#[derive(Clone)]
pub struct GridSurface<T: Number = f32> {
    heights: Vec<T>,
    columns: usize,
    rows: usize,
    spacing: f64,
    origin: [f64; 2],
    level: f64,
    /// Least and greatest height that the interpolation can have.
    bounds: [f64; 2],
    /// Root mean square of second differences, in meters.
    bend: f64,
    trails: Trails<T>,
    /// How far rounding may have carried the cells from their definition.
    doubt: GridDoubt,
    /// With a doubt: largest turn of the slopes, per meter.
    turn: f64,
    exact: Option<MakeExact>,
    /// Ranges of heights, made for the first ray.
    ranges: Arc<OnceLock<Ranges>>,
}

/// Makes the surface that references see; `None` if it was stopped.
type MakeExact = Arc<dyn Fn(ChannelSet, &(dyn Fn() -> bool + Sync)) -> Option<Arc<GridSurface<f64>>> + Send + Sync>;

impl<T: Number> GridSurface<T> {
    /// Makes a surface of heights in meters over world y = `level`, row by row: cell (i, j) is at x = `origin[0]` +
    /// i·`spacing`, z = `origin[1]` + j·`spacing`.
    ///
    /// # Panics
    /// There are fewer than 2 × 2 heights, or a row does not have `columns` heights.
    pub fn new(heights: Vec<T>, columns: usize, spacing: f64, origin: [f64; 2], level: f64) -> Self {
        let rows = heights.len().checked_div(columns).unwrap_or(0);
        assert!(columns >= 2 && rows >= 2 && rows * columns == heights.len(), "a grid of 2 × 2 cells or more");
        let (low, high) = heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &height| {
            let height: f64 = height.into();
            (low.min(height), high.max(height))
        });
        // Catmull–Rom weights sum to 1 with at most ⅛ below 0 along each axis, so heights exceed their range by at
        // most 9/16 of it. A flat field needs some room for a ray to pass through.
        let beyond = 0.5625 * (high - low) + 1e-3 * spacing;
        let mut squares = 0.0;
        for row in heights.chunks_exact(columns) {
            squares += row.windows(3).map(|h| square(second(h[0], h[1], h[2]))).sum::<f64>();
        }
        for cell in columns..heights.len() - columns {
            squares += square(second(heights[cell - columns], heights[cell], heights[cell + columns]));
        }
        let bend = libm::sqrt(squares / (2.0 * heights.len() as f64));
        let bounds = [low - beyond, high + beyond];
        Self {
            heights,
            columns,
            rows,
            spacing,
            origin,
            level,
            bounds,
            bend,
            trails: Trails::new(Vec::new, Default::default),
            ranges: Arc::default(),
            doubt: GridDoubt::default(),
            turn: 0.0,
            exact: None,
        }
    }

    /// Adds [`Channel::TRAILS`](crate::Channel::TRAILS): the rift and the other five, each computed when first
    /// needed, with one value per cell. An empty vector counts as 0.
    #[must_use]
    pub fn with_trails(
        self,
        rift: impl FnOnce() -> Vec<T> + Send + 'static,
        drift: impl FnOnce() -> [Vec<T>; 5] + Send + 'static,
    ) -> Self {
        let cells = self.heights.len();
        let fits = move |values: &Vec<T>| assert!(values.is_empty() || values.len() == cells, "a value for each cell");
        let rift = move || {
            let rift = rift();
            fits(&rift);
            rift
        };
        let drift = move || {
            let drift = drift();
            drift.iter().for_each(fits);
            drift
        };
        Self { trails: Trails::new(rift, drift), ..self }
    }

    /// Sets how far rounding may have carried the cells from their definition.
    #[must_use]
    pub fn with_doubt(self, doubt: GridDoubt) -> Self {
        let (columns, heights) = (self.columns, &self.heights);
        let (mut bend, mut twist) = (0.0_f64, 0.0_f64);
        for row in heights.chunks_exact(columns) {
            bend = row.windows(3).fold(bend, |bend, h| bend.max(second(h[0], h[1], h[2]).abs()));
            bend = bend
                .max(second(row[0], row[0], row[1]).abs())
                .max(second(row[columns - 2], row[columns - 1], row[columns - 1]).abs());
        }
        for cell in 0..heights.len() {
            let [above, below] = [cell.checked_sub(columns).unwrap_or(cell), cell + columns];
            let below = if below < heights.len() { below } else { cell };
            bend = bend.max(second(heights[above], heights[cell], heights[below]).abs());
            if below != cell && (cell + 1) % columns != 0 {
                let across = |cell: usize| heights[cell + 1].into() - heights[cell].into();
                twist = twist.max((across(below) - across(cell)).abs());
            }
        }
        // Second derivatives of the interpolation are sums of two second differences, with weights of at most 3 along
        // the axis and 1.25 across it, or of nine mixed ones, with weights of at most 1.5 along each.
        let turn = (3.0 * 1.25 * bend + 1.5 * 1.5 * twist) / (self.spacing * self.spacing);
        Self { doubt, turn, ..self }
    }

    /// Returns the traces of bursts at a position on the grid.
    #[allow(clippy::needless_range_loop, reason = "loops over several arrays")]
    fn trails(&self, x: f64, z: f64) -> [f64; 6] {
        let (u, v) = ((x - self.origin[0]) / self.spacing, (z - self.origin[1]) / self.spacing);
        let (i, j) = ((u as usize).min(self.columns - 2), (v as usize).min(self.rows - 2));
        let (wx, _) = weights(u - i as f64);
        let (wz, _) = weights(v - j as f64);
        let columns: [usize; 4] = std::array::from_fn(|m| (i + m).saturating_sub(1).min(self.columns - 1));
        let rows: [usize; 4] = std::array::from_fn(|n| (j + n).saturating_sub(1).min(self.rows - 1) * self.columns);
        let mut trails = [0.0; 6];
        for (index, trail) in trails.iter_mut().enumerate() {
            let values = self.trails.values(index);
            if values.is_empty() {
                continue;
            }
            for n in 0..4 {
                let mut sum = 0.0;
                for m in 0..4 {
                    sum += wx[m] * values[rows[n] + columns[m]].into();
                }
                *trail += wz[n] * sum;
            }
        }
        trails
    }

    /// Returns the numbers of columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    /// Returns the distance between cells, in meters.
    pub(crate) fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Returns world x and z of the first cell.
    pub(crate) fn origin(&self) -> [f64; 2] {
        self.origin
    }

    /// Returns the least and greatest height that the interpolation can have, over the level.
    pub(crate) fn bounds(&self) -> [f64; 2] {
        self.bounds
    }

    /// Returns the heights, row by row along x.
    pub(crate) fn heights(&self) -> &[T] {
        &self.heights
    }

    /// Returns the values of a trail, cell by cell; empty if it is 0.
    pub(crate) fn trail(&self, index: usize) -> &[T] {
        self.trails.values(index)
    }

    /// Returns the heights around a cell, row by row: those that its interpolation depends on.
    pub(crate) fn neighbors(&self, [i, j]: [usize; 2]) -> [[f64; 4]; 4] {
        std::array::from_fn(|n| {
            let row = (j + n).saturating_sub(1).min(self.rows - 1) * self.columns;
            std::array::from_fn(|m| self.heights[row + (i + m).saturating_sub(1).min(self.columns - 1)].into())
        })
    }

    /// Returns the ranges of heights.
    pub(crate) fn ranges(&self) -> &Ranges {
        self.ranges.get_or_init(|| Ranges::new(self))
    }

    /// Returns world y of the rest level, in meters.
    pub fn level(&self) -> f64 {
        self.level
    }

    /// Returns the height over the level and its slopes along x and z at a world position; `None` outside of the
    /// grid.
    pub fn height(&self, x: f64, z: f64) -> Option<[f64; 3]> {
        let (u, v) = ((x - self.origin[0]) / self.spacing, (z - self.origin[1]) / self.spacing);
        let inside = |place: f64, count: usize| place >= 0.0 && place <= (count - 1) as f64;
        if !inside(u, self.columns) || !inside(v, self.rows) {
            return None;
        }
        Some(self.within(u, v))
    }

    /// Does the same at a position in cells within the grid.
    fn within(&self, u: f64, v: f64) -> [f64; 3] {
        let (i, j) = ((u as usize).min(self.columns - 2), (v as usize).min(self.rows - 2));
        self.blend([i, j], weights(u - i as f64), weights(v - j as f64))
    }

    /// Returns the interpolation in a cell, and its slopes.
    fn blend(&self, [i, j]: [usize; 2], (wx, dx): Weights, (wz, dz): Weights) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for (n, (wz, dz)) in wz.into_iter().zip(dz).enumerate() {
            let row = (j + n).saturating_sub(1).min(self.rows - 1) * self.columns;
            let (mut value, mut slope) = (0.0, 0.0);
            for (m, (wx, dx)) in wx.into_iter().zip(dx).enumerate() {
                let h: f64 = self.heights[row + (i + m).saturating_sub(1).min(self.columns - 1)].into();
                value += wx * h;
                slope += dx * h;
            }
            sums[0] += wz * value;
            sums[1] += wz * slope;
            sums[2] += dz * value;
        }
        [sums[0], sums[1] / self.spacing, sums[2] / self.spacing]
    }

    /// Blends a field from the four columns around a cell into a profile along z; the edges are repeated twice.
    fn profile(&self, field: &[T], cell: usize, weights: [f64; 4], out: &mut Vec<f64>) {
        let columns: [usize; 4] = std::array::from_fn(|m| (cell + m).saturating_sub(1).min(self.columns - 1));
        let blend = |row: &[T]| {
            let mut sum = 0.0;
            for (weight, column) in weights.into_iter().zip(columns) {
                sum += weight * row[column].into();
            }
            sum
        };
        out.clear();
        out.push(0.0);
        out.extend(field.chunks_exact(self.columns).map(blend));
        out[0] = out[1];
        out.push(out[self.rows]);
    }

    /// Returns the nearest position x, z on the grid.
    pub(crate) fn within_reach(&self, place: [f64; 2]) -> [f64; 2] {
        let end = self.end();
        [0, 1].map(|axis| place[axis].clamp(self.origin[axis], end[axis]))
    }

    /// Returns world x and z of the far corner.
    fn end(&self) -> [f64; 2] {
        let reach = |count: usize| (count - 1) as f64 * self.spacing;
        [self.origin[0] + reach(self.columns), self.origin[1] + reach(self.rows)]
    }

    /// Returns whether a camera is under water; outside of the grid, whether it is below its level.
    fn submerged(&self, eye: DVec3) -> bool {
        eye.y - self.level < self.height(eye.x, eye.z).map_or(0.0, |[height, ..]| height)
    }

    /// Returns the positions of vertices along an axis: each cell is cut into equal parts, as many as its nearest
    /// point requires, divided by `coarseness`.
    fn lines(&self, projector: &Projector, axis: usize, chord: f64, coarseness: f64) -> Vec<Line> {
        let cells = [self.columns, self.rows][axis] - 1;
        let eye = projector.position.to_array();
        let [low, high] = self.bounds.map(|height| self.level + height);
        let (start, end) = ([self.origin[0], low, self.origin[1]], [self.end()[0], high, self.end()[1]]);
        let away = |axis: usize, low: f64, high: f64| eye[axis].clamp(low, high) - eye[axis];
        // Distances across the axis are those of the whole grid.
        let other = 2 - 2 * axis;
        let beside = libm::hypot(away(1, start[1], end[1]), away(other, start[other], end[other]));
        let line = |cell: usize, part: f64| Line {
            cell,
            weights: weights(part).0,
            place: self.origin[axis] + (cell as f64 + part) * self.spacing,
        };
        let mut lines = Vec::with_capacity(2 * cells);
        for cell in 0..cells {
            let from = self.origin[axis] + cell as f64 * self.spacing;
            let near = libm::hypot(beside, away(2 * axis, from, from + self.spacing)).max(self.spacing);
            let wanted = libm::sqrt(CREST * self.bend / (8.0 * chord * projector.pixel_size(near)));
            let parts = (wanted / coarseness).ceil().clamp(1.0, MAX_PARTS);
            lines.extend((0..parts as usize).map(|part| line(cell, part as f64 / parts)));
        }
        lines.push(line(cells - 1, 1.0));
        lines
    }
}

/// A line of vertices.
struct Line {
    /// Cell that contains it.
    cell: usize,
    /// Weights of the cell's neighbors.
    weights: [f64; 4],
    /// World coordinate.
    place: f64,
}

impl Line {
    /// Blends a profile at this line.
    #[inline]
    fn blend(&self, profile: &[f64]) -> f64 {
        let (values, weights) = (&profile[self.cell..self.cell + 4], self.weights);
        weights[0] * values[0] + weights[1] * values[1] + weights[2] * values[2] + weights[3] * values[3]
    }
}

impl GridSurface {
    /// Sets what makes the surface that references see ([`Surface::exact`]), with at least the given trails.
    #[must_use]
    pub fn with_exact(
        self,
        exact: impl Fn(ChannelSet, &(dyn Fn() -> bool + Sync)) -> Option<Arc<GridSurface<f64>>> + Send + Sync + 'static,
    ) -> Self {
        Self { exact: Some(Arc::new(exact)), ..self }
    }
}

impl<T: Number> Surface for GridSurface<T> {
    /// Rows of vertices run along z, one behind the other along x.
    fn tessellate(&self, projector: &Projector, wanted: ChannelSet) -> Mesh {
        let fineness = projector.fineness;
        // Rays of other cameras meet the triangles themselves; views only see them at contours.
        let chord = if wanted == ChannelSet::EMPTY { CHORD_PX } else { CONTOUR_PX };
        let limit = (VERTICES_PER_PIXEL * projector.size[0] * projector.size[1]).max(LEAST_LIMIT) * fineness * fineness;
        let lines = |coarseness: f64| [0, 1].map(|axis| self.lines(projector, axis, chord, coarseness));
        let mut cut = lines(1.0 / fineness);
        let vertices = cut[0].len() as f64 * cut[1].len() as f64;
        if vertices > limit {
            cut = lines(libm::sqrt(vertices / limit) / fineness);
        }
        let [along_x, along_z] = cut;
        let (rows, columns) = (along_x.len(), along_z.len());
        let eye = projector.position;
        let mut mesh = Mesh {
            positions: vec![[0.0; 3]; rows * columns],
            inside: self.submerged(eye),
            topology: Topology::Grid { columns, rows },
            ..Mesh::empty(self.level)
        };
        if wanted.intersects(CURVED) {
            mesh.between = Between::Heights(HeightField::new(self, wanted));
        }
        let rows = mesh.positions.par_chunks_mut(columns).zip(&along_x);
        rows.for_each_init(Vec::new, |profile, (positions, at_x)| {
            self.profile(&self.heights, at_x.cell, at_x.weights, profile);
            for (position, at_z) in positions.iter_mut().zip(&along_z) {
                let height = at_z.blend(profile);
                *position =
                    [(at_x.place - eye.x) as f32, (self.level + height - eye.y) as f32, (at_z.place - eye.z) as f32];
            }
        });
        mesh
    }

    fn first(&self, projector: &Projector, ray: &Ray, end: f64, _asked: Asked) -> Sight {
        let point = self.before(projector, ray, end).map(|(hit, crossing)| Met {
            sheet: crossing.only.map(|cell| self.sheet(cell)),
            hit,
            off: 0.0,
            deep: 0.0,
        });
        point.map_or(Sight::Nothing, Sight::Point)
    }

    fn meet_near(&self, projector: &Projector, ray: &Ray, near: &MeshHit) -> Option<Hit> {
        meet_grid(self, projector, ray, near)
    }

    fn trace(&self, projector: &Projector, ray: &Ray, end: f64) -> Result<Option<Hit>, GivenUp> {
        Ok(self.before(projector, ray, end).map(|(hit, _)| hit))
    }

    /// Beyond the grid, the heights of its edge continue. A grid holds no detail finer than its cells.
    fn height_at(&self, place: [f64; 2], _footprint: f64) -> Option<f64> {
        let counts = [self.columns, self.rows];
        let [u, v] =
            [0, 1].map(|axis| ((place[axis] - self.origin[axis]) / self.spacing).clamp(0.0, (counts[axis] - 1) as f64));
        Some(self.level + self.within(u, v)[0])
    }

    fn anchors(&self, [x, z]: [f64; 2]) -> Vec<Anchor> {
        let anchor = |[height, dx, dz]: [f64; 3]| Anchor {
            point: DVec3::new(x, self.level + height, z),
            along_u: DVec3::new(1.0, dx, 0.0),
            along_v: DVec3::new(0.0, dz, 1.0),
        };
        self.height(x, z).map(anchor).into_iter().collect()
    }

    fn resting(&self) -> Option<&dyn Resting> {
        Some(self)
    }

    fn exact(&self, wanted: ChannelSet, stop: &(dyn Fn() -> bool + Sync)) -> Exact {
        match &self.exact {
            None => Exact::Itself,
            Some(make) => make(wanted, stop).map_or(Exact::Stopped, |exact| Exact::Other(exact)),
        }
    }

    fn doubt(&self, facing: f64) -> f64 {
        let GridDoubt { height, trails, largest_trail } = self.doubt;
        // The absolute weights of the interpolation sum to at most 1.25 along each axis, those of its slope to 3.
        let shift = 1.25 * 1.25 * height / facing;
        let turn = 3.0 * 1.25 * height / self.spacing + self.turn * shift;
        let steep = 2.0 * 3.0 * 1.25 * largest_trail / self.spacing;
        shift.max(turn).max(1.25 * 1.25 * trails + steep * shift)
    }
}

impl<T: Number> GridSurface<T> {
    /// Returns the first point on a ray before a distance.
    fn before(&self, projector: &Projector, ray: &Ray, end: f64) -> Option<(Hit, Crossing)> {
        let [start, last] = self.within_slab(ray)?;
        let crossing = first_of_grid(self, ray, [start, last.min(end)])?;
        let distance = crossing.distance;
        let inside = self.submerged(projector.position);
        Some((self.hit(projector, ray, distance, self.place_of(ray.at(distance)), inside), crossing))
    }

    /// Returns a cell as a sheet, for a ray that meets it only once.
    fn sheet(&self, cell: [usize; 2]) -> OneSheet {
        // A little smaller than the cell, since a sheet holds what is beyond it by no more than rounding.
        let half = 0.5 * self.spacing * (1.0 - 1e-6);
        let middle = [0, 1].map(|axis| self.origin[axis] + (cell[axis] as f64 + 0.5) * self.spacing);
        OneSheet { middle, heading: [1.0, 0.0], half: [half; 2] }
    }

    pub(crate) fn hit(&self, projector: &Projector, ray: &Ray, distance: f64, [x, z]: [f64; 2], inside: bool) -> Hit {
        let position = ray.at(distance);
        let [_, dx, dz] = self.height(x, z).unwrap_or_default();
        let normal = unit_or_up(DVec3::new(-dx, 1.0, -dz));
        let normal = if (normal.dot(ray.direction) > 0.0) == inside { normal } else { -normal };
        let rest = DVec3::new(x, self.level, z);
        Hit {
            surface: 0,
            distance,
            depth: (position - projector.position).dot(projector.forward),
            position,
            normal,
            rest,
            height: position.y - self.level,
            rest_distance: (position - rest).length(),
            slope_variance: 0.0,
            jacobian: 1.0,
            uv: [x, z],
            trails: self.trails(x, z),
        }
    }
}
