//! Meshes of a displaced sea, adapted to one camera.

mod part;

use std::f64::consts::TAU;
use std::ops::Range;

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;
use rayon::prelude::*;
use trochoid_image::Window;
use trochoid_sea::{FieldSet, Fields, Line, LineScratch, Lines, Points};

use crate::channel::{CURVED, RESTS};
use crate::extent::{Sector, Strip};
use crate::patches::Patches;
use crate::spacing::{Facets, Spacing};
use crate::surface::{Between, Mesh, Topology};
use crate::{Channel, ChannelSet, Projector, SeaSurface};

/// Bounds of the limit, at 80 bytes per vertex; small pictures need no more with patches between vertices.
const LEAST_FLAT: f64 = 1e6;
const LEAST_CURVED: f64 = 3e5;
const GREATEST_LIMIT: f64 = 8e6;

/// Returns the most vertices of a sea in a picture.
fn limit(sea: &SeaSurface, facets: Facets, projector: &Projector) -> f64 {
    let least = if facets == Facets::Flat { LEAST_FLAT } else { LEAST_CURVED };
    let pixels = projector.size[0] * projector.size[1] * sea.detail * sea.detail;
    let finer = projector.fineness * projector.fineness;
    (SeaSurface::VERTICES_PER_PIXEL * pixels * finer).clamp(least * finer.min(1.0), GREATEST_LIMIT)
}

/// Returns the distance between vertices at a distance in meters, under this footprint in meters.
fn spaced(spacing: &Spacing, facets: Facets, projector: &Projector, footprint: f64, distance: f64) -> f64 {
    spacing.at(facets, footprint, projector.pixel_size(distance)) / projector.fineness
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
    /// Part of the picture that is wanted; all of it for `None`.
    part: Option<Window>,
}

/// Rest positions of the vertices of a row, and the state of the sea there.
trait Layout: Sync {
    /// Whether the last column repeats the first one, bit by bit.
    const CLOSED: bool;

    /// Computes the rest points of a row, and the wanted quantities there.
    fn row(&self, row: usize, wanted: FieldSet, scratch: &mut Scratch);

    /// Returns the derivatives of a row's rest points, by column: by s, which grows by 1 from column to column, and by t.
    fn ways(&self, row: usize) -> impl Fn(usize) -> [[f64; 2]; 2];

    /// Returns the value of t in a row.
    fn place(&self, row: usize) -> f64;

    /// Returns the ends of a row at rest, if it is straight.
    fn ends(&self, _row: usize) -> Option<[[f64; 2]; 2]> {
        None
    }
}

/// Returns a grid over the sector, to the horizon; `None` soon after `stop` says so.
pub(crate) fn sector(
    sea: &SeaSurface,
    spacing: &Spacing,
    projector: &Projector,
    sector: &Sector,
    wanted: ChannelSet,
    part: Option<Window>,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Mesh> {
    let (radii, columns) = limited_rings(sea, spacing, Facets::of(wanted), projector, sector);
    let rows = radii.len();
    if sector.closed() {
        let turn = |column: usize| TAU * if column == columns { 0.0 } else { column as f64 / columns as f64 };
        let directions = (0..=columns).map(|column| libm::sincos(turn(column))).collect();
        let layout = Disc { sea, projector, center: sector.apex, radii, directions };
        Rows { sea, projector, columns: columns + 1, rows, layout, part }.mesh(wanted, stop)
    } else {
        let [x, z] = sector.heading;
        let slope = libm::tan(sector.width / 2.0);
        let line = |row: usize| {
            let (along, across) = (radii[row], radii[row] * slope);
            let step = 2.0 * across / columns as f64;
            Line {
                origin: [sector.apex[0] + x * along + z * across, sector.apex[1] + z * along - x * across],
                step: [-z * step, x * step],
                footprint: ahead(sea, projector, along - sector.setback),
            }
        };
        let (lines, heading, place) = (Lines::new(&sea.frame, columns + 1), sector.heading, |row: usize| radii[row]);
        let layout = StraightRows { lines, columns: columns + 1, heading, slope, line, place };
        Rows { sea, projector, columns: columns + 1, rows, layout, part }.mesh(wanted, stop)
    }
}

/// Returns the [`rings`], with a larger spacing if there would be too many vertices.
fn limited_rings(
    sea: &SeaSurface,
    spacing: &Spacing,
    facets: Facets,
    projector: &Projector,
    sector: &Sector,
) -> (Vec<f64>, usize) {
    let (radii, columns) = rings(sea, spacing, facets, projector, sector);
    let vertices = radii.len() as f64 * columns as f64;
    if vertices <= limit(sea, facets, projector) {
        return (radii, columns);
    }
    let mut spacing = spacing.clone();
    spacing.coarseness = libm::sqrt(vertices / limit(sea, facets, projector));
    rings(sea, &spacing, facets, projector, sector)
}

/// Returns how many waves the footprint leaves at the vertices of a sector's grid: one number for each straight row,
/// or for each vertex of a disc.
pub(crate) fn resolved(sea: &SeaSurface, spacing: &Spacing, projector: &Projector, sector: &Sector) -> Vec<usize> {
    let (radii, columns) = limited_rings(sea, spacing, Facets::Curved, projector, sector);
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
fn rings(
    sea: &SeaSurface,
    spacing: &Spacing,
    facets: Facets,
    projector: &Projector,
    sector: &Sector,
) -> (Vec<f64>, usize) {
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
        // Points that rest nearer than any in the picture are in it only where waves carry them farther away, or where rare
        // crests rise before the camera: both are drawn as finely as the nearest others.
        let distance = libm::sqrt(away * away + clearance * clearance).max(sector.nearest);
        // A disc is measured in the direction in which the camera looks, where it sees most of it.
        let print = ahead(sea, projector, away);
        let step = spaced(spacing, facets, projector, print, distance);
        cell = cell.min(step / radius.max(sector.setback).max(clearance));
        radius += step.min(GROWTH * distance);
        radii.push(radius.min(last));
    }
    (radii, (breadth / cell).ceil() as usize)
}

/// Returns the largest depth of an orthographic view, in meters.
pub(crate) fn strip_depth(sea: &SeaSurface, spacing: &Spacing, projector: &Projector) -> f64 {
    let print = sea.footprint(projector, DVec3::new(0.0, sea.level, 0.0));
    MAX_ROWS * spacing.at(Facets::Flat, print, projector.pixel_size(1.0)).min(1e6)
}

/// Returns a regular grid under an orthographic camera; `None` soon after `stop` says so.
pub(crate) fn strip(
    sea: &SeaSurface,
    spacing: &Spacing,
    projector: &Projector,
    strip: &Strip,
    wanted: ChannelSet,
    part: Option<Window>,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Mesh> {
    let print = sea.footprint(projector, DVec3::new(0.0, sea.level, 0.0));
    let facets = Facets::of(wanted);
    let mut step = spaced(spacing, facets, projector, print, 1.0);
    let (width, depth) = (strip.u[1] - strip.u[0], strip.v[1] - strip.v[0]);
    let count = |length: f64, step: f64| (length / step).ceil().max(MIN_COLUMNS);
    let vertices = count(width, step) * count(depth, step);
    if vertices > limit(sea, facets, projector) {
        step *= libm::sqrt(vertices / limit(sea, facets, projector));
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
    let (lines, heading) = (Lines::new(&sea.frame, columns), strip.along);
    let place = |row: usize| strip.v[0] + depth * row as f64 / rows;
    let layout = StraightRows { lines, columns, heading, slope: 0.0, line, place };
    Rows { sea, projector, columns, rows: rows as usize + 1, layout, part }.mesh(wanted, stop)
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
struct StraightRows<'a, F, P> {
    lines: Lines<'a>,
    columns: usize,
    /// Unit vector from row to row in the middle, and by how much the ends of rows lead aside from it.
    heading: [f64; 2],
    slope: f64,
    line: F,
    /// Value of t by row.
    place: P,
}

impl<F, P> Layout for StraightRows<'_, F, P>
where
    F: Fn(usize) -> Line + Sync,
    P: Fn(usize) -> f64 + Sync,
{
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

    fn ways(&self, row: usize) -> impl Fn(usize) -> [[f64; 2]; 2] {
        let (step, [x, z], slope) = ((self.line)(row).step, self.heading, self.slope);
        let part = 2.0 / (self.columns - 1) as f64;
        move |column| {
            let aside = slope * (part * column as f64 - 1.0);
            [step, [x - z * aside, z + x * aside]]
        }
    }

    fn place(&self, row: usize) -> f64 {
        (self.place)(row)
    }

    fn ends(&self, row: usize) -> Option<[[f64; 2]; 2]> {
        let Line { origin, step, .. } = (self.line)(row);
        let last = (self.columns - 1) as f64;
        Some([origin, [origin[0] + last * step[0], origin[1] + last * step[1]]])
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

    fn ways(&self, row: usize) -> impl Fn(usize) -> [[f64; 2]; 2] {
        let turn = TAU / (self.directions.len() - 1) as f64 * self.radii[row];
        move |column| {
            let (sin, cos) = self.directions[column];
            [[-sin * turn, cos * turn], [cos, sin]]
        }
    }

    fn place(&self, row: usize) -> f64 {
        self.radii[row]
    }
}

/// Most rows of a task: near rows take longer than far ones, so that threads with many of them would wait for each other.
const TASK: usize = 8;

impl<L: Layout> Rows<'_, L> {
    fn mesh(&self, wanted: ChannelSet, stop: &(dyn Fn() -> bool + Sync)) -> Option<Mesh> {
        let [rows, columns] = match self.part {
            Some(part) => self.seen_in(part, stop)?,
            None => [0..self.rows, 0..self.columns],
        };
        if rows.is_empty() || columns.is_empty() {
            return Some(Mesh { inside: self.sea.submerges(self.projector), ..Mesh::empty(self.sea.level) });
        }
        let width = columns.len();
        let len = width * rows.len();
        let size = |wanted: bool| if wanted { len } else { 0 };
        let curved = wanted.intersects(CURVED);
        // The area of a cell at rest, by which the Jacobian is measured, follows from rest points.
        let rests = RESTS.union(ChannelSet::UV).union(Channel::Jacobian.into());
        let mut mesh = Mesh {
            positions: vec![[0.0; 3]; len],
            rests: vec![[0.0; 2]; size(wanted.intersects(rests))],
            slope_variances: vec![0.0; size(wanted.contains(Channel::SlopeVariance))],
            inside: self.sea.submerges(self.projector),
            topology: Topology::Grid { columns: width, rows: rows.len() },
            ..Mesh::empty(self.sea.level)
        };
        let mut tangents = vec![[[0.0; 3]; 2]; size(curved)];
        // Channels that are not wanted have empty rows.
        let mut targets: Vec<Row<'_>> = Vec::with_capacity(rows.len());
        let mut tangent_rows = tangents.chunks_mut(width);
        let mut rests = mesh.rests.chunks_mut(width);
        let mut slope_variances = mesh.slope_variances.chunks_mut(width);
        for positions in mesh.positions.chunks_mut(width) {
            targets.push(Row {
                positions,
                tangents: tangent_rows.next().unwrap_or_default(),
                rests: rests.next().unwrap_or_default(),
                slope_variances: slope_variances.next().unwrap_or_default(),
            });
        }
        let tasks = targets.into_par_iter().with_max_len(TASK).enumerate();
        let filled = tasks.try_for_each_init(Scratch::default, |scratch, (index, row)| {
            if stop() {
                return None;
            }
            self.row(rows.start + index, columns.clone(), row, scratch);
            Some(())
        });
        filled?;
        if curved {
            let place = |row: usize| self.layout.place(row);
            let steps = (rows.start + 1..rows.end).map(|row| (place(row) - place(row - 1)) as f32).collect();
            mesh.between = Between::Patches(Patches::new(width, &mesh.positions, tangents, steps, L::CLOSED));
        }
        Some(mesh)
    }

    /// Returns the positions of a row.
    fn positions(&self, row: usize, scratch: &mut Scratch) -> Vec<[f32; 3]> {
        self.layout.row(row, FieldSet { displacement: true, ..FieldSet::default() }, scratch);
        let Scratch { x, z, fields, .. } = &*scratch;
        let displaced = |c: usize| fields.displacement.each_ref().map(|values| values[c]);
        (0..self.columns).map(|c| self.position([x[c], z[c]], displaced(c))).collect()
    }

    /// Returns the position of a vertex from its rest point and its displacement.
    #[inline(always)]
    fn position(&self, [x, z]: [f64; 2], [dx, dy, dz]: [f32; 3]) -> [f32; 3] {
        let eye = self.projector.position;
        [
            (x - eye.x + f64::from(dx)) as f32,
            (self.sea.level - eye.y + f64::from(dy)) as f32,
            (z - eye.z + f64::from(dz)) as f32,
        ]
    }

    /// Fills some columns of a row.
    fn row(&self, index: usize, columns: Range<usize>, row: Row<'_>, scratch: &mut Scratch) {
        let eye = self.projector.position;
        let wanted = FieldSet {
            displacement: true,
            derivatives: !row.tangents.is_empty(),
            slope_variance: !row.slope_variances.is_empty(),
            ..FieldSet::default()
        };
        self.layout.row(index, wanted, scratch);
        let Scratch { x, z, fields, .. } = &*scratch;
        let (x, z) = (&x[columns.clone()], &z[columns.clone()]);
        let ways = self.layout.ways(index);
        // Slices of one length and plain loops, which become vectors.
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            let [dx, dy, dz] = fields.displacement.each_ref().map(|values| &values[columns.clone()]);
            let points = x.iter().zip(z).zip(dx.iter().zip(dy).zip(dz));
            for (position, ((x, z), ((dx, dy), dz))) in row.positions.iter_mut().zip(points) {
                *position = self.position([*x, *z], [*dx, *dy, *dz]);
            }
            for (rest, (x, z)) in row.rests.iter_mut().zip(x.iter().zip(z)) {
                *rest = [(x - eye.x) as f32, (z - eye.z) as f32];
            }
            if wanted.derivatives {
                let [yx, yz] = fields.slope.each_ref().map(|values| &values[columns.clone()]);
                let [xx, xz, zz] = fields.strain.each_ref().map(|values| &values[columns.clone()]);
                for (c, tangents) in row.tangents.iter_mut().enumerate().take(yx.len()) {
                    let by_x = [f64::from(1.0 + xx[c]), f64::from(yx[c]), f64::from(xz[c])];
                    let by_z = [f64::from(xz[c]), f64::from(yz[c]), f64::from(1.0 + zz[c])];
                    let along = |[x, z]: [f64; 2], axis: usize| (x * by_x[axis] + z * by_z[axis]) as f32;
                    let [s, t] = ways(columns.start + c);
                    *tangents = [[along(s, 0), along(s, 1), along(s, 2)], [along(t, 0), along(t, 1), along(t, 2)]];
                }
            }
        }));
        if !row.slope_variances.is_empty() {
            row.slope_variances.copy_from_slice(&fields.slope_variance[columns]);
        }
        if L::CLOSED {
            close(row.positions);
            close(row.tangents);
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
    tangents: &'a mut [[[f32; 3]; 2]],
    rests: &'a mut [[f32; 2]],
    slope_variances: &'a mut [f32],
}
