//! Tests of patches between the vertices of grids.

use trochoid_image::Format;
use trochoid_scene::inside::{self, point_of};
use trochoid_scene::{Camera, DVec3, Patches, Projection, Projector};

/// Columns and rows of the grids.
const SIDE: usize = 9;

/// Numbers from 0 to 1, one after the other.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A wave that displaces the points of a plane by cos(k·p + phase) along a vector.
struct Wave {
    by: DVec3,
    k: [f64; 2],
    phase: f64,
}

impl Wave {
    /// Returns the displacement at (s, t), and its derivatives by s and by t.
    fn at(&self, s: f64, t: f64) -> [DVec3; 3] {
        let (sin, cos) = (self.k[0] * s + self.k[1] * t + self.phase).sin_cos();
        [self.by * cos, self.by * (-sin * self.k[0]), self.by * (-sin * self.k[1])]
    }
}

/// Returns the positions and patches of a plane under a wave, with rows at these values of t.
fn grid(wave: &Wave, rows: &[f64], closed: bool) -> (Vec<[f32; 3]>, Patches) {
    let (mut positions, mut tangents) = (Vec::new(), Vec::new());
    for t in rows {
        for s in 0..SIDE {
            let s = if closed && s == SIDE - 1 { 0.0 } else { s as f64 };
            let [p, by_s, by_t] = wave.at(s, *t);
            let plane = if closed { DVec3::ZERO } else { DVec3::X };
            positions.push((p + plane * s + DVec3::Z * *t).as_vec3().to_array());
            tangents.push([by_s + plane, by_t + DVec3::Z].map(|way| way.as_vec3().to_array()));
        }
    }
    let steps = rows.windows(2).map(|rows| (rows[1] - rows[0]) as f32).collect();
    let patches = inside::patches(SIDE, &positions, tangents, steps, closed);
    (positions, patches)
}

/// A point of a patch, and its derivatives by place in the cell.
struct PatchPoint {
    position: DVec3,
    by_u: DVec3,
    by_v: DVec3,
}

/// One cell of a grid.
struct Cell<'a> {
    positions: &'a [[f32; 3]],
    patches: &'a Patches,
    place: [usize; 2],
    eye: Projector,
}

impl Cell<'_> {
    /// Returns a point of the cell.
    fn point(&self, u: f64, v: f64) -> PatchPoint {
        let [position, by_u, by_v] = point_of(self.patches, self.positions, SIDE, self.place, [u, v], &self.eye);
        PatchPoint { position, by_u, by_v }
    }
}

fn cell<'a>(positions: &'a [[f32; 3]], patches: &'a Patches, row: usize, column: usize) -> Cell<'a> {
    let (position, target) = (DVec3::ZERO, DVec3::NEG_Z);
    let camera = Camera { position, target, roll: 0.0, projection: Projection::Perspective { fov: 1.0 } };
    Cell { positions, patches, place: [row, column], eye: camera.projector(Format::new(8, 8, 1).unwrap()) }
}

/// Patches between evenly spaced vertices miss a wave by no more than the theory of Hermite interpolation says, and
/// its slope as well.
#[test]
fn patches_are_within_the_bound_of_their_waves() {
    let mut random = Random(7);
    let rows: Vec<f64> = (0..SIDE).map(|row| row as f64).collect();
    let mut closest = [0.0_f64; 2];
    for case in 0..400 {
        let longest = [0.3, 1.0, 2.5][case % 3];
        let k = [0, 1].map(|_| longest * (2.0 * random.next() - 1.0));
        let wave = Wave { by: DVec3::new(0.2, 1.0, -0.4), k, phase: 6.3 * random.next() };
        let (positions, patches) = grid(&wave, &rows, false);
        let (row, column) = (1 + case % (SIDE - 3), 1 + case / 7 % (SIDE - 3));
        let cell = cell(&positions, &patches, row, column);
        let (ks, kt, a) = (k[0].abs(), k[1].abs(), wave.by.length());
        // The patch of exact mixed derivatives, the error of these by central differences, and rounding of f32.
        let mixed = (ks * kt).powi(3) / 36.0;
        let height = a * ((ks.powi(4) + kt.powi(4) * (1.0 + ks / 4.0)) / 384.0 + mixed / 16.0) + 2e-6;
        let way = |ks: f64, kt: f64| {
            a * (ks.powi(3) * (3.0_f64.sqrt() / 216.0) * ks.max(1.0) + 2.5 * kt.powi(4) * ks / 384.0 + mixed / 4.0)
                + 1e-5
        };
        for _ in 0..40 {
            let (u, v) = (random.next(), random.next());
            let found = cell.point(u, v);
            let [p, by_s, by_t] = wave.at(column as f64 + u, row as f64 + v);
            let truth = p + DVec3::new(column as f64 + u, 0.0, row as f64 + v);
            let error = (found.position - truth).length();
            assert!(error <= height, "{k:?}: {error:e} > {height:e}");
            let slopes = [(found.by_u - by_s - DVec3::X).length(), (found.by_v - by_t - DVec3::Z).length()];
            let bounds = [way(ks, kt), way(kt, ks)];
            assert!(slopes[0] <= bounds[0] && slopes[1] <= bounds[1], "{k:?}: {slopes:?} > {bounds:?}");
            if longest > 0.5 {
                closest = [closest[0].max(error / height), closest[1].max(slopes[0] / bounds[0])];
            }
        }
    }
    assert!(closest[0] > 0.3 && closest[1] > 0.2, "the bounds are of the right order: {closest:?}");
}

/// Neighbors have the same points and the same tangent planes along their edge, whatever the steps of rows.
#[test]
fn patches_meet_without_cracks_or_creases() {
    let mut random = Random(3);
    let mut rows = vec![0.0];
    for _ in 1..SIDE {
        rows.push(rows[rows.len() - 1] + 0.3 + random.next());
    }
    let wave = Wave { by: DVec3::new(0.5, 0.8, 0.3), k: [1.1, -0.9], phase: 0.4 };
    let (positions, patches) = grid(&wave, &rows, false);
    for (row, column) in [(0, 0), (3, 4), (6, 6), (2, 0)] {
        let here = cell(&positions, &patches, row, column);
        let right = cell(&positions, &patches, row, column + 1);
        let below = cell(&positions, &patches, row + 1, column);
        let scale = f64::from(patches.steps[row]) / f64::from(patches.steps[row + 1]);
        for step in 0..=8 {
            let at = f64::from(step) / 8.0;
            let (a, b) = (here.point(1.0, at), right.point(0.0, at));
            let (c, d) = (here.point(at, 1.0), below.point(at, 0.0));
            let near = |a: DVec3, b: DVec3| (a - b).length() < 2e-6;
            assert!(near(a.position, b.position) && near(a.by_u, b.by_u) && near(a.by_v, b.by_v));
            assert!(near(c.position, d.position) && near(c.by_u, d.by_u) && near(c.by_v, d.by_v * scale));
        }
    }
}

/// Mixed derivatives are near those of the wave also at the grid's edges, between uneven rows, and where the last
/// column is the first one.
#[test]
fn mixed_derivatives_follow_from_the_neighbors() {
    let rows: Vec<f64> = (0..SIDE).map(|row| 0.4 * row as f64 + 0.01 * (row * row) as f64).collect();
    let around = std::f64::consts::TAU / (SIDE - 1) as f64;
    for closed in [false, true] {
        let wave = Wave { by: DVec3::Y, k: [around, 0.6], phase: 0.9 };
        let (_, patches) = grid(&wave, &rows, closed);
        for (row, t) in rows.iter().enumerate() {
            for column in 0..SIDE {
                let s = column as f64;
                let truth = -(wave.k[0] * s + wave.k[1] * t + wave.phase).cos() * wave.k[0] * wave.k[1];
                let inside = row > 0 && row < SIDE - 1 && (closed || column > 0 && column < SIDE - 1);
                let error = (f64::from(patches.twists[row * SIDE + column][1]) - truth).abs();
                assert!(error < if inside { 0.005 } else { 0.08 }, "({row}, {column}): {error}");
            }
        }
    }
}
