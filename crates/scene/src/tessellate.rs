//! Meshes of a displaced sea, adapted to one camera.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;
use trochoid_sea::{FieldSet, Fields, Line, LineScratch, Lines, Points};

use crate::channel::{NORMALS, RESTS};
use crate::extent::{Sector, Strip};
use crate::spacing::Spacing;
use crate::surface::{Mesh, Topology};
use crate::{Channel, ChannelSet, Projector, SeaSurface};

/// Most vertices of one sea per pixel of the picture; beyond this limit the spacing is increased.
///
/// Near crests the spacing that the error limits require is finer than a picture can show: with 1.5 vertices per
/// pixel the mean difference from a mesh without this limit is 0.16 of an 8-bit step in a stormy sea at 1920 × 1080,
/// in half the time.
const VERTICES_PER_PIXEL: f64 = 1.5;
/// Bounds of the limit, at 48 bytes per vertex.
const LEAST_LIMIT: f64 = 1e6;
const GREATEST_LIMIT: f64 = 8e6;

/// Returns the most vertices of a sea in a picture.
fn limit(sea: &SeaSurface, projector: &Projector) -> f64 {
    let pixels = projector.size[0] * projector.size[1] * sea.detail * sea.detail;
    let finer = projector.fineness * projector.fineness;
    (VERTICES_PER_PIXEL * pixels * finer).clamp(LEAST_LIMIT * finer.min(1.0), GREATEST_LIMIT)
}

/// Returns the distance between vertices at a distance in meters, under this footprint in meters.
fn spaced(spacing: &Spacing, projector: &Projector, footprint: f64, distance: f64) -> f64 {
    spacing.at(footprint, projector.pixel_size(distance)) / projector.fineness
}
/// Fewest cells across a view: a flat sea needs no more.
const MIN_COLUMNS: f64 = 8.0;
/// Largest step of radius, relative to the distance from the camera.
const GROWTH: f64 = 0.25;
/// Most rows of an orthographic view.
const MAX_ROWS: f64 = 8192.0;

/// Rows of vertices.
struct Rows<'a, L> {
    sea: &'a SeaSurface,
    projector: &'a Projector,
    columns: usize,
    rows: usize,
    layout: L,
}

/// Rest positions of the vertices of a row, and the state of the sea there.
trait Layout: Sync {
    /// Whether the last column repeats the first one, bit by bit.
    const CLOSED: bool;

    /// Computes the rest points of a row, and the wanted quantities there.
    fn row(&self, row: usize, wanted: FieldSet, scratch: &mut Scratch);
}

/// Returns a grid over the sector, to the horizon; `None` soon after `stop` says so.
pub(crate) fn sector(
    sea: &SeaSurface,
    spacing: &Spacing,
    projector: &Projector,
    sector: &Sector,
    wanted: ChannelSet,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Mesh> {
    let (radii, columns) = limited_rings(sea, spacing, projector, sector);
    let rows = radii.len();
    if sector.closed() {
        let turn = |column: usize| TAU * if column == columns { 0.0 } else { column as f64 / columns as f64 };
        let directions = (0..=columns).map(|column| libm::sincos(turn(column))).collect();
        let layout = Disc { sea, projector, center: sector.apex, radii, directions };
        Rows { sea, projector, columns: columns + 1, rows, layout }.mesh(wanted, stop)
    } else {
        let [x, z] = sector.heading;
        let slope = libm::tan(sector.width / 2.0);
        let line = move |row: usize| {
            let (along, across) = (radii[row], radii[row] * slope);
            let step = 2.0 * across / columns as f64;
            Line {
                origin: [sector.apex[0] + x * along + z * across, sector.apex[1] + z * along - x * across],
                step: [-z * step, x * step],
                footprint: ahead(sea, projector, along - sector.setback),
            }
        };
        let layout = StraightRows { lines: Lines::new(&sea.frame, columns + 1), columns: columns + 1, line };
        Rows { sea, projector, columns: columns + 1, rows, layout }.mesh(wanted, stop)
    }
}

/// Returns the [`rings`], with a larger spacing if there would be too many vertices.
fn limited_rings(sea: &SeaSurface, spacing: &Spacing, projector: &Projector, sector: &Sector) -> (Vec<f64>, usize) {
    let (radii, columns) = rings(sea, spacing, projector, sector);
    let vertices = radii.len() as f64 * columns as f64;
    if vertices <= limit(sea, projector) {
        return (radii, columns);
    }
    let mut spacing = spacing.clone();
    spacing.coarseness = libm::sqrt(vertices / limit(sea, projector));
    rings(sea, &spacing, projector, sector)
}

/// Returns how many waves the footprint leaves at the vertices of a sector's grid: one number for each straight row,
/// or for each vertex of a disc.
pub(crate) fn resolved(sea: &SeaSurface, spacing: &Spacing, projector: &Projector, sector: &Sector) -> Vec<usize> {
    let (radii, columns) = limited_rings(sea, spacing, projector, sector);
    if !sector.closed() {
        return radii.iter().map(|radius| sea.frame.resolved(ahead(sea, projector, radius - sector.setback))).collect();
    }
    let directions: Vec<(f64, f64)> =
        (0..columns).map(|column| libm::sincos(TAU * column as f64 / columns as f64)).collect();
    let ring = |radius: &f64| {
        let [x, z] = sector.apex;
        let rest = |(sin, cos): &(f64, f64)| DVec3::new(x + radius * cos, sea.level, z + radius * sin);
        directions.iter().map(|at| sea.frame.resolved(sea.footprint(projector, rest(at)))).collect::<Vec<_>>()
    };
    radii.iter().flat_map(ring).collect()
}

/// Returns the footprint on the line across the view at a distance ahead of the camera's foot.
fn ahead(sea: &SeaSurface, projector: &Projector, along: f64) -> f64 {
    let [x, z] = projector.heading();
    let eye = projector.position;
    sea.footprint(projector, DVec3::new(eye.x + x * along, sea.level, eye.z + z * along))
}

/// Returns the distances of the rows from the apex, and the number of cells in each row.
fn rings(sea: &SeaSurface, spacing: &Spacing, projector: &Projector, sector: &Sector) -> (Vec<f64>, usize) {
    let height = (projector.position.y - sea.level).abs();
    // The surface may be nearer than its rest level: for a camera below the crests, the distance to the waves counts.
    let clearance = (height - sea.bounds.rise).max(0.25 * height).max(0.02 * sea.bounds.rise).max(1e-3);
    let [first, last] = sector.radii;
    // A straight row meets the first ring with its ends.
    let (first, breadth) = if sector.closed() {
        (first, TAU)
    } else {
        (first * libm::cos(sector.width / 2.0), 2.0 * libm::tan(sector.width / 2.0))
    };
    let mut radii = vec![first];
    let mut cell = breadth / MIN_COLUMNS;
    let mut radius = first;
    while radius < last {
        let away = radius - sector.setback;
        let distance = libm::sqrt(away * away + clearance * clearance);
        // A disc is measured in the direction in which the camera looks, where it sees most of it.
        let print = ahead(sea, projector, away);
        let step = spaced(spacing, projector, print, distance);
        cell = cell.min(step / radius.max(sector.setback).max(clearance));
        radius += step.min(GROWTH * distance);
        radii.push(radius.min(last));
    }
    (radii, (breadth / cell).ceil() as usize)
}

/// Returns the largest depth of an orthographic view, in meters.
pub(crate) fn strip_depth(sea: &SeaSurface, spacing: &Spacing, projector: &Projector) -> f64 {
    let print = sea.footprint(projector, DVec3::new(0.0, sea.level, 0.0));
    MAX_ROWS * spacing.at(print, projector.pixel_size(1.0)).min(1e6)
}

/// Returns a regular grid under an orthographic camera; `None` soon after `stop` says so.
pub(crate) fn strip(
    sea: &SeaSurface,
    spacing: &Spacing,
    projector: &Projector,
    strip: &Strip,
    wanted: ChannelSet,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Mesh> {
    let print = sea.footprint(projector, DVec3::new(0.0, sea.level, 0.0));
    let mut step = spaced(spacing, projector, print, 1.0);
    let (width, depth) = (strip.u[1] - strip.u[0], strip.v[1] - strip.v[0]);
    let count = |length: f64, step: f64| (length / step).ceil().max(MIN_COLUMNS);
    let vertices = count(width, step) * count(depth, step);
    if vertices > limit(sea, projector) {
        step *= libm::sqrt(vertices / limit(sea, projector));
    }
    let (columns, rows) = (count(width, step), count(depth, step));
    let line = |row: usize| {
        let v = strip.v[0] + depth * row as f64 / rows;
        Line {
            origin: [0, 1].map(|axis| strip.across[axis] * strip.u[0] + strip.along[axis] * v),
            step: strip.across.map(|part| part * width / columns),
            footprint: print,
        }
    };
    let columns = columns as usize + 1;
    let layout = StraightRows { lines: Lines::new(&sea.frame, columns), columns, line };
    Rows { sea, projector, columns, rows: rows as usize + 1, layout }.mesh(wanted, stop)
}

/// Scratch buffers of one thread.
#[derive(Default)]
struct Scratch {
    x: Vec<f64>,
    z: Vec<f64>,
    footprint: Vec<f64>,
    line: LineScratch,
    fields: Fields,
}

/// Straight rows across the view.
struct StraightRows<'a, F> {
    lines: Lines<'a>,
    columns: usize,
    line: F,
}

impl<F: Fn(usize) -> Line + Sync> Layout for StraightRows<'_, F> {
    const CLOSED: bool = false;

    fn row(&self, row: usize, wanted: FieldSet, scratch: &mut Scratch) {
        let line = (self.line)(row);
        let Scratch { x, z, line: buffers, fields, .. } = scratch;
        for (axis, values) in [x, z].into_iter().enumerate() {
            values.clear();
            values.extend((0..self.columns).map(|column| line.origin[axis] + column as f64 * line.step[axis]));
        }
        self.lines.evaluate(&line, wanted, buffers, fields);
    }
}

/// Rings around the camera's foot.
struct Disc<'a> {
    sea: &'a SeaSurface,
    projector: &'a Projector,
    center: [f64; 2],
    radii: Vec<f64>,
    /// Sine and cosine of each column's azimuth.
    directions: Vec<(f64, f64)>,
}

impl Layout for Disc<'_> {
    const CLOSED: bool = true;

    fn row(&self, row: usize, wanted: FieldSet, scratch: &mut Scratch) {
        let Scratch { x, z, footprint: prints, fields, .. } = scratch;
        x.clear();
        z.clear();
        prints.clear();
        for (sin, cos) in &self.directions {
            let rest = [self.center[0] + self.radii[row] * cos, self.center[1] + self.radii[row] * sin];
            x.push(rest[0]);
            z.push(rest[1]);
            prints.push(self.sea.footprint(self.projector, DVec3::new(rest[0], self.sea.level, rest[1])));
        }
        self.sea.frame.direct(Points { x, z, footprint: prints }, wanted, fields);
    }
}

impl<L: Layout> Rows<'_, L> {
    fn mesh(&self, wanted: ChannelSet, stop: &(dyn Fn() -> bool + Sync)) -> Option<Mesh> {
        let len = self.columns * self.rows;
        let size = |channels: ChannelSet| if wanted.intersects(channels) { len } else { 0 };
        let mut mesh = Mesh {
            positions: vec![[0.0; 3]; len],
            normals: vec![[0.0; 3]; size(NORMALS)],
            rests: vec![[0.0; 2]; size(RESTS.union(ChannelSet::UV))],
            rest_heights: Vec::new(),
            uvs: Vec::new(),
            slope_variances: vec![0.0; size(ChannelSet::of(&[Channel::SlopeVariance]))],
            trails: Default::default(),
            level: self.sea.level,
            displaced: true,
            inside: self.sea.submerges(self.projector),
            tolerance: None,
            topology: Topology::Grid { columns: self.columns, rows: self.rows },
        };
        // One row per task; channels that are not wanted have empty rows.
        let mut rows: Vec<Row<'_>> = Vec::with_capacity(self.rows);
        let mut normals = mesh.normals.chunks_mut(self.columns);
        let mut rests = mesh.rests.chunks_mut(self.columns);
        let mut slope_variances = mesh.slope_variances.chunks_mut(self.columns);
        for positions in mesh.positions.chunks_mut(self.columns) {
            rows.push(Row {
                positions,
                normals: normals.next().unwrap_or_default(),
                rests: rests.next().unwrap_or_default(),
                slope_variances: slope_variances.next().unwrap_or_default(),
            });
        }
        let filled = rows.into_par_iter().enumerate().try_for_each_init(Scratch::default, |scratch, (index, row)| {
            if stop() {
                return None;
            }
            self.row(index, row, scratch);
            Some(())
        });
        filled.map(|()| mesh)
    }

    fn row(&self, index: usize, row: Row<'_>, scratch: &mut Scratch) {
        let eye = self.projector.position;
        let wanted = FieldSet {
            displacement: true,
            derivatives: !row.normals.is_empty(),
            slope_variance: !row.slope_variances.is_empty(),
            ..FieldSet::default()
        };
        self.layout.row(index, wanted, scratch);
        let Scratch { x, z, fields, .. } = scratch;
        let [dx, dy, dz] = &fields.displacement;
        for (column, position) in row.positions.iter_mut().enumerate() {
            *position = [
                (x[column] - eye.x + f64::from(dx[column])) as f32,
                (self.sea.level - eye.y + f64::from(dy[column])) as f32,
                (z[column] - eye.z + f64::from(dz[column])) as f32,
            ];
        }
        let ([yx, yz], [xx, xz, zz]) = (&fields.slope, &fields.strain);
        for (c, normal) in row.normals.iter_mut().enumerate() {
            // ∂P/∂z × ∂P/∂x, as in `trochoid_sea::Sample::normal`.
            let (ax, az) = (1.0 + xx[c], 1.0 + zz[c]);
            *normal = [yz[c] * xz[c] - az * yx[c], ax * az - xz[c] * xz[c], xz[c] * yx[c] - yz[c] * ax];
        }
        for (c, rest) in row.rests.iter_mut().enumerate() {
            *rest = [(x[c] - eye.x) as f32, (z[c] - eye.z) as f32];
        }
        row.slope_variances.copy_from_slice(&fields.slope_variance);
        if L::CLOSED {
            close(row.positions);
            close(row.normals);
            close(row.rests);
            close(row.slope_variances);
        }
    }
}

/// Copies the first vertex to the last: rounding may differ between the two evaluations of the same point.
fn close<T: Copy>(row: &mut [T]) {
    if let [first, .., last] = row {
        *last = *first;
    }
}

/// One row of every channel of the mesh.
struct Row<'a> {
    positions: &'a mut [[f32; 3]],
    normals: &'a mut [[f32; 3]],
    rests: &'a mut [[f32; 2]],
    slope_variances: &'a mut [f32],
}
