//! All corners of a palette's hull moved at once.
//!
//! A sequence of linear programs: for each facet f with unit normal n and each color p near it, at a distance d (positive
//! outside), moving the corners by δᵢ changes d by −Σ αᵢ n·δᵢ, with the barycentric coordinates α of p's foot on the
//! facet. Minimized is V/V₀ + M·s, the volume relative to that of the colors' hull and a slack s ≥ d that all share, with
//! |δ| at most a trust radius, and corners within the cube. Where colors stay outside, they may have a row more, with
//! their distance from the nearest point of the hull, which may be on an edge.

use crate::corner::Data;
use crate::mesh::Mesh;
use crate::simplex::nearest;
use crate::vector::{Point, add, cross, dot, length, scale, sub, unit};
use microlp::{ComparisonOp, OptimizationDirection, Problem, Solution, SolveOutcome};

/// Cost of a slack of one step of 8 bits. It exceeds what any volume could save.
const SLACK: f64 = 4000.0 / 255.0;

/// Hull of a palette, and how far the colors reach beyond it.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub(crate) mesh: Mesh,
    /// Largest distance of a color outside; 0 if all are enclosed.
    pub(crate) outside: f64,
}

impl Fit {
    fn of(points: &[Point], data: &Data) -> Option<Self> {
        let mesh = data.hull(points)?;
        let facets = facets(&mesh);
        let farthest = |color: &Point| facets.iter().map(|facet| facet.excess(*color)).fold(0.0, f64::max);
        let distance = |color: &Point| match farthest(color) {
            // Beside an edge or a corner, a color is farther from the hull than from any facet's plane.
            excess if excess > 0.0 && data.is_nearest => Row::near(&mesh, *color).map_or(0.0, |row| row.excess),
            excess => excess,
        };
        let outside = data.corners.iter().map(distance).fold(0.0, f64::max);
        Some(Self { mesh, outside })
    }

    /// What is minimized, given the volume of the colors' hull.
    fn cost(&self, volume: f64) -> f64 {
        self.mesh.volume / volume + SLACK * self.outside
    }

    /// Whether all colors are enclosed, up to rounding.
    pub(crate) fn encloses(&self) -> bool {
        self.outside < 1e-6
    }
}

/// A triangle of a hull with its plane.
struct Facet {
    corners: [usize; 3],
    at: [Point; 3],
    normal: Point,
}

fn facets(mesh: &Mesh) -> Vec<Facet> {
    let facet = |corners: &[usize; 3]| {
        let at = corners.map(|corner| mesh.corners[corner]);
        let area = cross(sub(at[1], at[0]), sub(at[2], at[0]));
        // Triangles without area have no plane; their neighbors hold the colors.
        (length(area) > 1e-6).then(|| Facet { corners: *corners, at, normal: scale(area, 1.0 / length(area)) })
    };
    mesh.triangles.iter().filter_map(facet).collect()
}

impl Facet {
    /// Returns the distance of a point, positive outside.
    fn excess(&self, point: Point) -> f64 {
        dot(self.normal, sub(point, self.at[0]))
    }

    /// Returns the barycentric coordinates of a point's foot.
    fn coordinates(&self, point: Point) -> [f64; 3] {
        let (u, v, w) = (sub(self.at[1], self.at[0]), sub(self.at[2], self.at[0]), sub(point, self.at[0]));
        let (uu, uv, vv, wu, wv) = (dot(u, u), dot(u, v), dot(v, v), dot(w, u), dot(w, v));
        let determinant = uu * vv - uv * uv;
        let (b, c) = ((wu * vv - wv * uv) / determinant, (wv * uu - wu * uv) / determinant);
        [1.0 - b - c, b, c]
    }
}

/// Returns the best moves of the corners within a radius.
fn moves(fit: &Fit, data: &Data, volume: f64, radius: f64) -> Option<Vec<Point>> {
    let corners = &fit.mesh.corners;
    let mut gradient = vec![[0.0; 3]; corners.len()];
    let facets = facets(&fit.mesh);
    for triangle in &fit.mesh.triangles {
        for i in 0..3 {
            let [a, b] = [triangle[(i + 1) % 3], triangle[(i + 2) % 3]].map(|corner| sub(corners[corner], data.inside));
            let area = cross(a, b);
            let own = &mut gradient[triangle[i]];
            (0..3).for_each(|c| own[c] += area[c] / 6.0);
        }
    }
    let mut problem = Problem::new(OptimizationDirection::Minimize);
    let variables: Vec<[microlp::Variable; 3]> = corners
        .iter()
        .zip(&gradient)
        .zip(&fit.mesh.is_own)
        .map(|((corner, gradient), is_own)| {
            let radius = if *is_own { radius } else { 0.0 };
            [0, 1, 2].map(|c| {
                let range = ((-corner[c]).max(-radius), (255.0 - corner[c]).min(radius));
                problem.add_var(gradient[c] / volume, range)
            })
        })
        .collect();
    let slack = problem.add_var(SLACK, (0.0, f64::INFINITY));
    let rows: Vec<Row> = facets.iter().flat_map(|facet| Row::of(facet, data, radius)).collect();
    let is_outside = |color: &&Point| facets.iter().any(|facet| facet.excess(**color) > 0.0);
    let near = data.corners.iter().filter(|_| data.is_nearest).filter(is_outside);
    let near: Vec<Row> = near.filter_map(|color| Row::near(&fit.mesh, *color)).collect();
    let expression = |row: &Row| {
        let mut terms: Vec<(microlp::Variable, f64)> = Vec::with_capacity(10);
        // A row of a point on an edge or a corner has no more corners than these.
        for (corner, by) in row.corners.iter().zip(row.by).filter(|(_, by)| *by != [0.0; 3]) {
            (0..3).for_each(|c| terms.push((variables[*corner][c], by[c])));
        }
        terms.push((slack, -1.0));
        terms
    };
    for row in &near {
        problem.add_constraint(expression(row), ComparisonOp::Le, -row.excess);
    }
    // Few of the colors hold a facet, so rows are added as they are broken: at first the nearest color of each facet.
    let mut is_held = vec![false; rows.len()];
    for facet in &facets {
        let own = rows.iter().enumerate().filter(|(_, row)| row.corners == facet.corners);
        if let Some((nearest, row)) = own.max_by(|a, b| a.1.excess.total_cmp(&b.1.excess)) {
            is_held[nearest] = true;
            problem.add_constraint(expression(row), ComparisonOp::Le, -row.excess);
        }
    }
    let mut solution = solved(problem.solve())?;
    for _ in 0..ROUNDS {
        let moved: Vec<Point> = variables.iter().map(|corner| corner.map(|variable| solution[variable])).collect();
        let allowed = solution[slack] + 1e-9;
        let mut broken: Vec<(usize, f64)> = Vec::new();
        for facet in &facets {
            let own = rows.iter().enumerate().filter(|(index, row)| !is_held[*index] && row.corners == facet.corners);
            let worst = own.map(|(index, row)| (index, row.after(&moved))).max_by(|a, b| a.1.total_cmp(&b.1));
            broken.extend(worst.filter(|(_, excess)| *excess > allowed));
        }
        if broken.is_empty() {
            return Some(moved);
        }
        for (index, _) in broken {
            is_held[index] = true;
            let row = &rows[index];
            solution = solved(solution.add_constraint(expression(row), ComparisonOp::Le, -row.excess))?;
        }
    }
    None
}

/// Returns the solution, if there is one.
fn solved(outcome: Result<SolveOutcome, microlp::Error>) -> Option<Solution> {
    match outcome.ok()? {
        SolveOutcome::Solution(solution) => Some(solution),
        SolveOutcome::Interrupted(_) => None,
    }
}

/// Most rounds in which rows are added.
const ROUNDS: usize = 40;

/// How a color's distance from a facet changes with the moves of the facet's corners.
struct Row {
    corners: [usize; 3],
    by: [Point; 3],
    /// Distance before, positive outside.
    excess: f64,
}

impl Row {
    /// Returns the rows of the colors that moves within a radius may bring to a facet.
    fn of(facet: &Facet, data: &Data, radius: f64) -> Vec<Self> {
        let row = |color: &Point| {
            let excess = facet.excess(*color);
            let by = facet.coordinates(*color).map(|weight| scale(facet.normal, -weight));
            (excess >= -2.5 * radius).then_some(Self { corners: facet.corners, by, excess })
        };
        data.corners.iter().filter_map(row).collect()
    }

    /// Returns the row of a color outside and its nearest point of the hull; `None` if that is the color itself.
    fn near(mesh: &Mesh, color: Point) -> Option<Self> {
        let weights = nearest(&mesh.corners, color);
        let foot = mesh.corners.iter().zip(&weights).fold([0.0; 3], |sum, (at, weight)| add(sum, scale(*at, *weight)));
        let rest = sub(color, foot);
        let (excess, direction) = (length(rest), unit(rest)?);
        let mut row = Self { corners: [0; 3], by: [[0.0; 3]; 3], excess };
        let used = weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0).take(3);
        for (at, (corner, weight)) in used.enumerate() {
            (row.corners[at], row.by[at]) = (corner, scale(direction, -weight));
        }
        Some(row)
    }

    /// Returns the distance after moves.
    fn after(&self, moves: &[Point]) -> f64 {
        self.excess + self.corners.iter().zip(self.by).map(|(corner, by)| dot(by, moves[*corner])).sum::<f64>()
    }
}

/// Moves all corners at once, as long as that pays; `None` if the points are no corners of a hull.
pub(crate) fn together(points: &[Point], data: &Data, volume: f64, steps: usize, radius: f64) -> Option<Fit> {
    let mut fit = Fit::of(points, data).filter(|fit| fit.mesh.count() == points.len())?;
    let mut radius = radius;
    for _ in 0..steps {
        let moved = moves(&fit, data, volume, radius).and_then(|moves| {
            let own = fit.mesh.corners.iter().zip(moves).zip(&fit.mesh.is_own).filter(|(_, is_own)| **is_own);
            let moved = own.map(|((corner, by), _)| [0, 1, 2].map(|c| (corner[c] + by[c]).clamp(0.0, 255.0)));
            Fit::of(&moved.collect::<Vec<_>>(), data)
        });
        match moved {
            Some(moved) if moved.mesh.count() == points.len() && moved.cost(volume) < fit.cost(volume) - 1e-6 => {
                fit = moved;
                radius = (1.5 * radius).min(60.0);
            }
            _ => radius /= 3.0,
        }
        if radius < 0.05 {
            break;
        }
    }
    Some(fit)
}

/// Finds a hull of one corner less: each edge merged and each corner left out, a few steps each, the best three to the
/// end. Returns one that encloses all colors, or else the one that they exceed least.
pub(crate) fn fewer(mesh: &Mesh, data: &Data, volume: f64) -> Option<Fit> {
    use rayon::prelude::*;
    let mut starts: Vec<Vec<Point>> = Vec::new();
    let is_own = |corner: &usize| mesh.is_own[*corner];
    for [a, b] in mesh.edges().into_iter().filter(|edge| edge.iter().all(is_own)) {
        let middle = [0, 1, 2].map(|c| 0.5 * (mesh.corners[a][c] + mesh.corners[b][c]));
        let mut points = mesh.without(&[a, b]);
        points.push(middle);
        starts.push(points);
    }
    starts.extend((0..mesh.corners.len()).filter(is_own).map(|corner| mesh.without(&[corner])));
    let mut begun: Vec<Fit> =
        starts.into_par_iter().filter_map(|points| together(&points, data, volume, 8, 24.0)).collect();
    begun.sort_by(|a, b| {
        let cost = |fit: &Fit| fit.mesh.volume / volume + 0.1 * SLACK * fit.outside;
        cost(a).total_cmp(&cost(b))
    });
    begun.truncate(3);
    let ended: Vec<Fit> = begun.par_iter().filter_map(|fit| together(&fit.mesh.own(), data, volume, 40, 6.0)).collect();
    let enclosing = ended.iter().filter(|fit| fit.encloses()).min_by(|a, b| a.mesh.volume.total_cmp(&b.mesh.volume));
    enclosing.or_else(|| ended.iter().min_by(|a, b| a.outside.total_cmp(&b.outside))).cloned()
}
