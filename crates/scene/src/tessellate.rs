//! Meshes of a displaced sea, adapted to one camera.

use glam::DVec3;
use rayon::prelude::*;
use trochoid_sea::{Fields, Points, Wanted};

use crate::extent::{Sector, Strip};
use crate::spacing::Spacing;
use crate::surface::{Mesh, Topology};
use crate::{Channel, ChannelSet, Projector, SeaSurface, footprint, reference};

/// Most vertices of one sea for each pixel of the picture; beyond it vertices move apart.
///
/// Near crests the spacing that errors ask for is finer than a picture can show: with 1.5 vertices a pixel the mean
/// difference to a mesh without this limit is 0.16 of an 8-bit step in a stormy sea at 1920 × 1080, at half the time.
const VERTICES_PER_PIXEL: f64 = 1.5;
/// The limit is never below and never above these, 48 bytes a vertex.
const LEAST_LIMIT: f64 = 1e6;
const GREATEST_LIMIT: f64 = 8e6;

/// Most vertices of one sea in a picture.
fn limit(projector: &Projector) -> f64 {
    (VERTICES_PER_PIXEL * projector.size[0] * projector.size[1]).clamp(LEAST_LIMIT, GREATEST_LIMIT)
}
/// Fewest cells across a view: a flat sea needs no more.
const MIN_COLUMNS: f64 = 8.0;
/// Greatest step of radius, relative to the distance from the camera.
const GROWTH: f64 = 0.25;
/// Most rows of an orthographic view.
const MAX_ROWS: f64 = 8192.0;

/// Rows of vertices at given rest points.
struct Rows<'a, F> {
    sea: &'a SeaSurface,
    projector: &'a Projector,
    columns: usize,
    rows: usize,
    /// Whether the last column is the first one again, bit by bit.
    closed: bool,
    /// Rest point of (row, column).
    rest: F,
}

/// A polar grid from the apex of the sector to the horizon.
pub(crate) fn sector(
    sea: &SeaSurface,
    spacing: &Spacing,
    projector: &Projector,
    sector: &Sector,
    wanted: ChannelSet,
) -> Mesh {
    let mut spacing = spacing.clone();
    let (mut radii, mut columns) = polar(sea, &spacing, projector, sector);
    let vertices = radii.len() as f64 * columns as f64;
    if vertices > limit(projector) {
        spacing.coarseness = libm::sqrt(vertices / limit(projector));
        (radii, columns) = polar(sea, &spacing, projector, sector);
    }
    let directions: Vec<(f64, f64)> = (0..=columns)
        .map(|column| {
            let part = if sector.closed() && column == columns { 0.0 } else { column as f64 / columns as f64 };
            libm::sincos(sector.start + sector.width * part)
        })
        .collect();
    let rest = |row: usize, column: usize| {
        let (sin, cos) = directions[column];
        [sector.apex[0] + radii[row] * cos, sector.apex[1] + radii[row] * sin]
    };
    Rows { sea, projector, columns: columns + 1, rows: radii.len(), closed: sector.closed(), rest }.mesh(wanted)
}

/// Radii of the rings, and the number of cells in each.
fn polar(sea: &SeaSurface, spacing: &Spacing, projector: &Projector, sector: &Sector) -> (Vec<f64>, usize) {
    let height = (projector.position.y - sea.level).abs();
    // The surface may be nearer than its rest level: below a camera among the crests it is the wave that counts.
    let clearance = (height - sea.bounds.rise).max(0.25 * height).max(0.02 * sea.bounds.rise).max(1e-3);
    let foot = DVec3::new(projector.position.x, sea.level, projector.position.z);
    let [first, last] = sector.radii;
    let mut radii = vec![first];
    let mut angle = sector.width / MIN_COLUMNS;
    let mut radius = first;
    while radius < last {
        // On the wedge's axis a ring is nearest to the camera.
        let away = (radius - sector.setback).abs();
        let distance = libm::sqrt(away * away + clearance * clearance);
        let print = footprint(projector, foot + DVec3::X * away);
        let step = spacing.at(print, projector.pixel_size(distance));
        angle = angle.min(step / radius.max(sector.setback).max(clearance));
        radius += step.min(GROWTH * distance);
        radii.push(radius.min(last));
    }
    (radii, (sector.width / angle).ceil() as usize)
}

/// How deep an orthographic view reaches at most, in meters.
pub(crate) fn strip_depth(sea: &SeaSurface, spacing: &Spacing, projector: &Projector) -> f64 {
    let print = footprint(projector, DVec3::new(0.0, sea.level, 0.0));
    MAX_ROWS * spacing.at(print, projector.pixel_size(1.0)).min(1e6)
}

/// A regular grid under an orthographic camera.
pub(crate) fn strip(
    sea: &SeaSurface,
    spacing: &Spacing,
    projector: &Projector,
    strip: &Strip,
    wanted: ChannelSet,
) -> Mesh {
    let print = footprint(projector, DVec3::new(0.0, sea.level, 0.0));
    let mut step = spacing.at(print, projector.pixel_size(1.0));
    let (width, depth) = (strip.u[1] - strip.u[0], strip.v[1] - strip.v[0]);
    let count = |length: f64, step: f64| (length / step).ceil().max(MIN_COLUMNS);
    let vertices = count(width, step) * count(depth, step);
    if vertices > limit(projector) {
        step *= libm::sqrt(vertices / limit(projector));
    }
    let (columns, rows) = (count(width, step), count(depth, step));
    let rest = |row: usize, column: usize| {
        let u = strip.u[0] + width * column as f64 / columns;
        let v = strip.v[0] + depth * row as f64 / rows;
        [strip.across[0] * u + strip.along[0] * v, strip.across[1] * u + strip.along[1] * v]
    };
    Rows { sea, projector, columns: columns as usize + 1, rows: rows as usize + 1, closed: false, rest }.mesh(wanted)
}

/// Buffers of one thread.
#[derive(Default)]
struct Scratch {
    x: Vec<f64>,
    z: Vec<f64>,
    footprint: Vec<f64>,
    fields: Fields,
}

impl<F: Fn(usize, usize) -> [f64; 2] + Sync> Rows<'_, F> {
    fn mesh(&self, wanted: ChannelSet) -> Mesh {
        let len = self.columns * self.rows;
        let size = |channels: ChannelSet| if wanted.intersects(channels) { len } else { 0 };
        let mut mesh = Mesh {
            positions: vec![[0.0; 3]; len],
            normals: vec![[0.0; 3]; size(ChannelSet::NORMALS)],
            rests: vec![[0.0; 2]; size(ChannelSet::RESTS)],
            slope_variances: vec![0.0; size(ChannelSet::of(&[Channel::SlopeVariance]))],
            level: self.sea.level,
            displaced: true,
            inside: reference::submerged(self.sea, self.projector),
            topology: Topology::Grid { columns: self.columns, rows: self.rows },
        };
        // One row for each task; channels that nobody wants have empty rows.
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
        rows.into_par_iter().enumerate().for_each_init(Scratch::default, |scratch, (index, row)| {
            self.row(index, row, scratch);
        });
        mesh
    }

    fn row(&self, index: usize, row: Row<'_>, scratch: &mut Scratch) {
        let eye = self.projector.position;
        let Scratch { x, z, footprint: prints, fields } = scratch;
        x.clear();
        z.clear();
        prints.clear();
        for column in 0..self.columns {
            let rest = (self.rest)(index, column);
            x.push(rest[0]);
            z.push(rest[1]);
            prints.push(footprint(self.projector, DVec3::new(rest[0], self.sea.level, rest[1])));
        }
        let wanted = Wanted {
            displacement: true,
            derivatives: !row.normals.is_empty(),
            slope_variance: !row.slope_variances.is_empty(),
            ..Wanted::default()
        };
        self.sea.frame.direct(Points { x, z, footprint: prints }, wanted, fields);
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
        if self.closed {
            close(row.positions);
            close(row.normals);
            close(row.rests);
            close(row.slope_variances);
        }
    }
}

/// Repeats the first vertex as the last: rounding may differ between the two evaluations of the same point.
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
