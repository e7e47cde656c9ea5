//! Contours of smooth surfaces over a resting plane that are tessellated as grids.

use super::{ContourBox, Search};
use crate::bezier::Bicubic;
use crate::surface::{Mesh, Topology};
use glam::DVec3;
use rayon::prelude::*;

/// A point of a surface by its rest point, relative to the camera, with its derivatives by the rest point's x and z.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceCorner {
    pub(crate) rest: [f64; 2],
    pub(crate) point: DVec3,
    pub(crate) by: [DVec3; 2],
    /// ∂²/∂x², ∂²/∂x∂z, ∂²/∂z².
    pub(crate) second: [DVec3; 3],
}

/// Limits of the sizes of derivatives in any direction within a cell.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DerivativeLimits {
    pub(crate) fourth: f64,
    pub(crate) fifth: f64,
    /// Largest difference of second derivatives from those of corners.
    pub(crate) twist: f64,
}

/// A surface that is smooth in its rest point.
pub(crate) trait SmoothSurface: Sync {
    fn corner(&self, rest: [f64; 2]) -> SurfaceCorner;

    /// Returns the limits between four rest points.
    fn derivative_limits(&self, corners: &[[f64; 2]; 4]) -> DerivativeLimits;
}

/// Size in pixels to which patches are cut, and most cuts.
const FINE: f64 = 1.0 / 16.0;
const CUTS: f64 = 8.0;
/// Distance in pixels within which patches may replace the surface, and most refinements. Where the surface may lie
/// further away, or is not known well enough to decide which side faces the camera, it is evaluated at more points.
const NEAR: f64 = 1.0 / 32.0;
const REFINED: u32 = 4;

/// A cell of the mesh: its corners are at (s, t) = (0, 0), (1, 0), (0, 1) and (1, 1).
struct Cell<'a, S> {
    smooth: &'a S,
    search: &'a Search<'a>,
    rests: [[f64; 2]; 4],
    /// Vertices of the mesh, relative to the camera.
    facet: [DVec3; 4],
    /// Edges of its triangles along s and t.
    edges: [[DVec3; 2]; 2],
    most: DerivativeLimits,
    /// Rounding error of the vertices, in meters.
    slack: f64,
}

/// A part of a cell whose corners are known: the bicubic patch through them.
#[derive(Clone, Copy)]
struct KnownPart {
    corners: [SurfaceCorner; 4],
    part: PatchPart,
    /// Largest distance of the surface from the patch, and largest differences of their derivatives by s and by t.
    off: f64,
    turned: [f64; 2],
}

/// Which sides of a part face the camera.
#[derive(Clone, Copy, PartialEq)]
enum Facing {
    OneWay,
    /// Both sides may face it.
    BothWays,
    /// The surface is not known well enough; a smaller part would not help.
    Unknown,
}

/// A part of a patch.
#[derive(Clone, Copy)]
struct PatchPart {
    patch: Bicubic,
    s: [f64; 2],
    t: [f64; 2],
}

/// Marks every contour of a surface and of the grid that replaces it, given the rest points of the grid.
pub(crate) fn contours_of_grid<S: SmoothSurface>(smooth: &S, search: &Search<'_>, mesh: &Mesh) -> bool {
    let Topology::Grid { columns, rows } = mesh.topology else { return mesh.positions.is_empty() };
    let eye = search.projector.position;
    let rest = |vertex: usize| {
        let [x, z] = mesh.rests[vertex].map(f64::from);
        [eye.x + x, eye.z + z]
    };
    // The last column of a disc is its first.
    let closed = (0..rows).all(|row| mesh.positions[row * columns] == mesh.positions[(row + 1) * columns - 1]);
    let row_of = |row: usize| -> Vec<SurfaceCorner> {
        (0..columns).map(|column| smooth.corner(rest(row * columns + column))).collect()
    };
    const TOGETHER: usize = 8;
    (0..rows - 1).into_par_iter().step_by(TOGETHER).for_each(|first| {
        if search.is_stopped() {
            return;
        }
        let mut above = row_of(first);
        for row in first..(first + TOGETHER).min(rows - 1) {
            let below = row_of(row + 1);
            for column in 0..columns - 1 {
                let corners = [above[column], above[column + 1], below[column], below[column + 1]];
                let vertex = row * columns + column;
                let vertices = [vertex, vertex + 1, vertex + columns, vertex + columns + 1];
                let facet = vertices.map(|vertex| DVec3::from(mesh.positions[vertex].map(f64::from)));
                let cell = Cell::new(smooth, search, corners, facet);
                let known = cell.known(corners, [0.0, 1.0], [0.0, 1.0]);
                cell.refine(&known, REFINED);
                let (first_row, last_row) = (row == 0, row + 2 == rows);
                let (first_column, last_column) = (!closed && column == 0, !closed && column + 2 == columns);
                for (ends, is_end) in
                    [([0, 1], first_row), ([2, 3], last_row), ([0, 2], first_column), ([1, 3], last_column)]
                {
                    if is_end {
                        cell.end(ends, &known, REFINED);
                    }
                }
            }
            above = below;
        }
    });
    true
}

impl<'a, S: SmoothSurface> Cell<'a, S> {
    fn new(smooth: &'a S, search: &'a Search<'a>, corners: [SurfaceCorner; 4], facet: [DVec3; 4]) -> Self {
        let rests = corners.map(|corner| corner.rest);
        let edges = [[facet[1] - facet[0], facet[3] - facet[2]], [facet[2] - facet[0], facet[3] - facet[1]]];
        let reach = facet.iter().map(|point| point.length()).fold(0.0, f64::max);
        let slack = 4.0 * f64::from(f32::EPSILON) * reach;
        Self { smooth, search, rests, facet, edges, most: smooth.derivative_limits(&rests), slack }
    }

    /// Returns the derivatives of the rest point by s at t, by t at s, and by both.
    fn ways(&self, s: f64, t: f64) -> [[f64; 2]; 3] {
        let [a, b, c, d] = self.rests;
        let along = [0, 1].map(|axis| (b[axis] - a[axis]) * (1.0 - t) + (d[axis] - c[axis]) * t);
        let across = [0, 1].map(|axis| (c[axis] - a[axis]) * (1.0 - s) + (d[axis] - b[axis]) * s);
        [along, across, [0, 1].map(|axis| d[axis] - c[axis] - b[axis] + a[axis])]
    }

    /// Returns the Hermite patch through four corners, in Bézier form, and how far the surface may lie from it.
    ///
    /// Along one side of length h, cubic Hermite interpolation misses a function by at most h⁴/384 times its fourth
    /// derivative, and its slope by at most √3·h³/216 times that. Across, these errors of values and slopes are
    /// interpolated in turn: values with weights that sum to 1, slopes with weights of at most h/4; the slopes of the
    /// result are at most 5/2 times the largest of them.
    fn known(&self, corners: [SurfaceCorner; 4], s: [f64; 2], t: [f64; 2]) -> KnownPart {
        let (ds, dt) = (s[1] - s[0], t[1] - t[0]);
        let mut points = [DVec3::ZERO; 16];
        let mut lengths = [0.0_f64; 3];
        for (index, corner) in corners.iter().enumerate() {
            let (i, j) = (index % 2, index / 2);
            let [along, across, both] = self.ways(s[i], t[j]);
            for (length, way) in lengths.iter_mut().zip([along, across, both]) {
                *length = length.max(libm::hypot(way[0], way[1]));
            }
            let [xx, xz, zz] = corner.second;
            let by = |way: [f64; 2]| corner.by[0] * way[0] + corner.by[1] * way[1];
            let bend = xx * (along[0] * across[0])
                + xz * (along[0] * across[1] + along[1] * across[0])
                + zz * (along[1] * across[1]);
            // Steps toward the middle of the patch.
            let (u, v) = (ds * (1.0 - 2.0 * i as f64) / 3.0, dt * (1.0 - 2.0 * j as f64) / 3.0);
            let (by_s, by_t, by_both) = (by(along) * u, by(across) * v, (bend + by(both)) * (u * v));
            let place = |k: usize, l: usize| if j == 0 { 4 * l } else { 4 * (3 - l) } + if i == 0 { k } else { 3 - k };
            points[place(0, 0)] = corner.point;
            points[place(1, 0)] = corner.point + by_s;
            points[place(0, 1)] = corner.point + by_t;
            points[place(1, 1)] = corner.point + by_s + by_t + by_both;
        }
        let [a, b, skew] = [lengths[0] * ds, lengths[1] * dt, lengths[2] * ds * dt];
        let DerivativeLimits { fourth, fifth, twist } = self.most;
        let fourths = [fourth * a * a * a * a, fourth * b * b * b * b];
        // Fourth derivatives along one side, differentiated by the other one.
        let fifths = [
            fifth * a * a * a * a * b + 4.0 * fourth * a * a * a * skew,
            fifth * a * b * b * b * b + 4.0 * fourth * b * b * b * skew,
        ];
        let twist = twist * a * b;
        let off = (fourths[0] + fourths[1]) / 384.0 + fifths[0].max(fifths[1]) / 1536.0 + twist / 16.0 + self.slack;
        let root = 3.0_f64.sqrt() / 216.0;
        let turn = |fourth: f64, fifth: f64| root * fourth + 2.5 / 384.0 * fifth + twist / 4.0;
        let turned = [turn(fourths[0], fifths[1]) / ds + self.slack, turn(fourths[1], fifths[0]) / dt + self.slack];
        KnownPart { corners, part: PatchPart { patch: Bicubic { points }, s, t }, off, turned }
    }

    /// Marks all positions that may have a contour in a part whose corners are known.
    fn refine(&self, known: &KnownPart, times: u32) {
        let Some(contour) = self.around(known, &known.part) else { return };
        // Orthographic cameras see only what lies in front of them.
        if self.search.projector.orthographic && contour.is_cut() {
            return self.search.mark(&contour);
        }
        let facing = self.facing(known, &known.part);
        // Precision lost to rounding cannot be regained by refining.
        let coarse = known.off > 2.0 * self.slack
            && (facing == Facing::Unknown || contour.pixels(self.search.projector, known.off) > NEAR);
        match facing {
            Facing::OneWay => {}
            Facing::Unknown | Facing::BothWays if times > 0 && coarse => {
                for part in self.refined(known) {
                    self.refine(&part, times - 1);
                }
            }
            Facing::Unknown | Facing::BothWays => {
                // The size of the patch itself shrinks with each cut; its distance from the mesh does not.
                let own = ContourBox::around(self.search.projector, &known.part.patch.points, 0.0, 0.0);
                let cuts = own.map_or(0.0, |own| libm::log2(own.size() / FINE).ceil());
                self.cut(known, &known.part, facing, contour, cuts.clamp(0.0, CUTS) as u32);
            }
        }
    }

    /// Marks the contours of a part of the patch that may have one, by dividing it into smaller parts.
    fn cut(&self, known: &KnownPart, part: &PatchPart, facing: Facing, contour: ContourBox, cuts: u32) {
        if cuts == 0 || facing == Facing::Unknown {
            self.search.mark(&contour);
            return;
        }
        let half = |[from, to]: [f64; 2], upper: bool| {
            let middle = 0.5 * (from + to);
            if upper { [middle, to] } else { [from, middle] }
        };
        for (index, patch) in part.patch.quarters().into_iter().enumerate() {
            let quarter = PatchPart { patch, s: half(part.s, index % 2 == 1), t: half(part.t, index / 2 == 1) };
            let Some(contour) = self.around(known, &quarter) else { continue };
            let facing = self.facing(known, &quarter);
            if facing != Facing::OneWay {
                self.cut(known, &quarter, facing, contour, cuts - 1);
            }
        }
    }

    /// Returns the box around a part of the surface, of the mesh and of everything between them, unless it is hidden.
    fn around(&self, known: &KnownPart, part: &PatchPart) -> Option<ContourBox> {
        let contour = ContourBox::around(self.search.projector, &self.points(part), known.off, self.search.step)?;
        (!self.search.hides(&contour)).then_some(contour)
    }

    /// Returns points whose convex hull contains the patch and the mesh.
    fn points(&self, part: &PatchPart) -> [DVec3; 20] {
        let mut points = [DVec3::ZERO; 20];
        points[..16].copy_from_slice(&part.patch.points);
        for index in 0..4 {
            points[16 + index] = self.on_facet(part.s[index % 2], part.t[index / 2]);
        }
        points
    }

    /// Marks an edge between two corners of the mesh, where the surface ends, if it is an edge of this part.
    fn end(&self, ends: [usize; 2], known: &KnownPart, times: u32) {
        let edge = |i: usize| match ends {
            [0, 1] => i,
            [2, 3] => 12 + i,
            [0, 2] => 4 * i,
            _ => 4 * i + 3,
        };
        let part = &known.part;
        let mut points = [DVec3::ZERO; 6];
        for (index, point) in points[..4].iter_mut().enumerate() {
            *point = part.patch.points[edge(index)];
        }
        points[4..].copy_from_slice(&ends.map(|end| self.on_facet(part.s[end % 2], part.t[end / 2])));
        let projector = self.search.projector;
        let Some(contour) = ContourBox::around(projector, &points, known.off, self.search.step) else { return };
        if times > 0 && known.off > 2.0 * self.slack && contour.pixels(projector, known.off) > NEAR {
            let parts = self.refined(known);
            ends.iter().for_each(|end| self.end(ends, &parts[*end], times - 1));
        } else {
            self.search.mark(&contour);
        }
    }

    /// Returns which sides the surface, the mesh and everything between them turn to the camera in a part.
    ///
    /// ∂P/∂s and ∂P/∂t lie in the convex hulls of the differences of a patch's control points and of the edges of
    /// triangles, so their cross product N lies in the hull of all products, and P in that of points. N·P is bounded
    /// by its value in the middle of both, and by the largest differences from it: in a nearly flat part N hardly
    /// turns, while P differs across it.
    fn facing(&self, known: &KnownPart, part: &PatchPart) -> Facing {
        let (ds, dt) = (part.s[1] - part.s[0], part.t[1] - part.t[0]);
        let p = &part.patch.points;
        let [mut along, mut across] = [[DVec3::ZERO; 14]; 2];
        for index in 0..12 {
            let from = index / 3 * 4 + index % 3;
            along[index] = (p[from + 1] - p[from]) * (3.0 / ds);
            across[index] = (p[index + 4] - p[index]) * (3.0 / dt);
        }
        along[12..].copy_from_slice(&self.edges[0]);
        across[12..].copy_from_slice(&self.edges[1]);
        let corners = [(0, 0, 0), (3, 2, 3), (12, 9, 8), (15, 11, 11)].map(|(point, a, b)| {
            let ray = if self.search.projector.orthographic { self.search.projector.forward } else { p[point] };
            along[a].cross(across[b]).dot(ray) > 0.0
        });
        if corners.iter().any(|side| *side != corners[0]) {
            return Facing::BothWays;
        }
        let (points, forward) = (self.points(part), [self.search.projector.forward]);
        let (rays, off): (&[DVec3], f64) =
            if self.search.projector.orthographic { (&forward, 0.0) } else { (&points, known.off) };
        let middle = |vectors: &[DVec3]| vectors.iter().sum::<DVec3>() / vectors.len() as f64;
        let [a, b, ray] = [middle(&along), middle(&across), middle(rays)];
        let normal = a.cross(b);
        let center = normal.dot(ray);
        // Bound on the unknown part of N·P.
        let longest = |vectors: &[DVec3], from: DVec3| {
            vectors.iter().map(|vector| (*vector - from).length_squared()).fold(0.0, f64::max).sqrt()
        };
        let [most_a, most_b, most_ray] = [&along[..], &across, rays].map(|vectors| longest(vectors, DVec3::ZERO));
        let [turned_a, turned_b] = known.turned;
        let unknown = (turned_a * (most_b + turned_b) + turned_b * most_a) * (most_ray + off)
            + most_a * most_b * off
            + 1e-13 * most_a * most_b * most_ray;
        // In most cases it suffices to vary each of the three factors by itself.
        let away = |vectors: &[DVec3], from: DVec3, by: DVec3| {
            vectors.iter().map(|vector| (*vector - from).dot(by).abs()).fold(0.0, f64::max)
        };
        let [more_a, more_b, more_ray] = [longest(&along, a), longest(&across, b), longest(rays, ray)];
        let one = away(&along, a, b.cross(ray)) + away(&across, b, ray.cross(a)) + away(rays, ray, normal);
        let several = more_a * more_b * most_ray + (more_a * most_b + most_a * more_b) * more_ray;
        if center.abs() > one + several + unknown {
            return Facing::OneWay;
        }
        // Small parts are flat enough for this bound.
        if part.s != known.part.s {
            return if unknown > one + several { Facing::Unknown } else { Facing::BothWays };
        }
        let unit = normal.normalize_or_zero();
        // Differences of products and points from the middle ones: along the middle normal, and across it.
        let (mut by_normal, mut by_ray) = ([0.0_f64; 2], [0.0_f64; 2]);
        let (mut off_normal, mut off_ray) = ([0.0_f64; 2], [0.0_f64; 2]);
        let take = |vector: DVec3, by: DVec3, range: &mut [f64; 2], off: &mut [f64; 2]| {
            let (side, up) = (vector.dot(by), vector.dot(unit));
            *range = [range[0].min(side), range[1].max(side)];
            *off = [off[0].max(up.abs()), off[1].max((vector - unit * up).length_squared())];
        };
        for a in &along {
            for b in &across {
                take(a.cross(*b) - normal, ray, &mut by_normal, &mut off_normal);
            }
        }
        for point in rays {
            take(*point - ray, normal, &mut by_ray, &mut off_ray);
        }
        let several = off_normal[0] * off_ray[0] + (off_normal[1] * off_ray[1]).sqrt();
        let (ranges, slack) = ([by_normal, by_ray], several + unknown);
        let [low, high] = [0, 1].map(|end| ranges.iter().map(|range| range[end]).sum::<f64>());
        if center + low > slack || center + high < -slack {
            Facing::OneWay
        } else if unknown > several + high - low {
            Facing::Unknown
        } else {
            Facing::BothWays
        }
    }

    fn on_facet(&self, s: f64, t: f64) -> DVec3 {
        let [a, b, c, d] = self.facet;
        if s + t <= 1.0 { a + (b - a) * s + (c - a) * t } else { d + (c - d) * (1.0 - s) + (b - d) * (1.0 - t) }
    }

    /// Returns the quarters of a part, with the surface evaluated at their corners.
    fn refined(&self, known: &KnownPart) -> [KnownPart; 4] {
        let middle = |[from, to]: [f64; 2]| [from, 0.5 * (from + to), to];
        let (s, t) = (middle(known.part.s), middle(known.part.t));
        let at = |s: f64, t: f64| {
            let [a, b, c, d] = self.rests;
            let rest = [0, 1]
                .map(|axis| (a[axis] * (1.0 - s) + b[axis] * s) * (1.0 - t) + (c[axis] * (1.0 - s) + d[axis] * s) * t);
            self.smooth.corner(rest)
        };
        let [a, b, c, d] = known.corners;
        let (ab, ac, bd, cd) = (at(s[1], t[0]), at(s[0], t[1]), at(s[2], t[1]), at(s[1], t[2]));
        let center = at(s[1], t[1]);
        [
            self.known([a, ab, ac, center], [s[0], s[1]], [t[0], t[1]]),
            self.known([ab, b, center, bd], [s[1], s[2]], [t[0], t[1]]),
            self.known([ac, center, c, cd], [s[0], s[1]], [t[1], t[2]]),
            self.known([center, bd, cd, d], [s[1], s[2]], [t[1], t[2]]),
        ]
    }
}
