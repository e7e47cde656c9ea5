//! Simplices of a palette: segments, triangles or tetrahedra, as many dimensions as its colors span.

use crate::vector::{Point, add, dot, length, scale, sub, unit};

/// Smallest distance from what other colors span, in display values, that counts as another dimension.
const FLAT: f64 = 1e-9;

/// Coordinates in the space that some colors span.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    origin: Point,
    /// Those beyond the dimension are 0.
    axes: [Point; 3],
    dimension: usize,
}

impl Frame {
    /// Returns the frame of some colors. Its axes are orthogonal and have length 1.
    pub(crate) fn new(colors: &[Point]) -> Self {
        let origin = colors.first().copied().unwrap_or_default();
        let mut frame = Self { origin, axes: [[0.0; 3]; 3], dimension: 0 };
        while frame.dimension < 3 {
            let rest = colors.iter().map(|color| frame.rest(*color));
            let farthest = rest.max_by(|a, b| dot(*a, *a).total_cmp(&dot(*b, *b)));
            match farthest.filter(|rest| length(*rest) > FLAT).and_then(unit) {
                Some(axis) => frame.axes[frame.dimension] = axis,
                None => break,
            }
            frame.dimension += 1;
        }
        frame
    }

    /// Returns the number of dimensions.
    pub(crate) fn dimension(&self) -> usize {
        self.dimension
    }

    /// Returns what the axes leave of a color.
    fn rest(&self, color: Point) -> Point {
        let from = sub(color, self.origin);
        self.axes.iter().fold(from, |rest, axis| sub(rest, scale(*axis, dot(from, *axis))))
    }

    /// Returns the coordinates of a color; those beyond the dimension are 0.
    #[inline(always)]
    pub(crate) fn of(&self, color: Point) -> Point {
        let from = sub(color, self.origin);
        [dot(from, self.axes[0]), dot(from, self.axes[1]), dot(from, self.axes[2])]
    }
}

/// Solves a square system of at most four equations by elimination; `None` if it has no single solution.
pub(crate) fn solve(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let count = rows.len();
    for at in 0..count {
        let pivot = (at..count).max_by(|a, b| rows[*a][at].abs().total_cmp(&rows[*b][at].abs()))?;
        rows.swap(at, pivot);
        if rows[at][at].abs() < 1e-13 {
            return None;
        }
        let (above, below) = rows.split_at_mut(at + 1);
        let chosen = &above[at];
        for row in below {
            let factor = row[at] / chosen[at];
            row.iter_mut().zip(chosen).skip(at).for_each(|(entry, by)| *entry -= factor * by);
        }
    }
    let mut solution = vec![0.0; count];
    for at in (0..count).rev() {
        let known: f64 = (at + 1..count).map(|column| rows[at][column] * solution[column]).sum();
        solution[at] = (rows[at][count] - known) / rows[at][at];
    }
    Some(solution)
}

/// A simplex: its corners by index, in ascending order, and the affine functions that are their barycentric coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Simplex {
    pub(crate) corners: Vec<usize>,
    /// For each corner, the factors of the coordinates, and the constant; 0 for corners that a simplex of fewer dimensions
    /// lacks.
    forms: [[f64; 4]; 4],
}

impl Simplex {
    /// Makes a simplex of some points; `None` if these span less.
    fn new(corners: &[usize], points: &[Point], dimension: usize) -> Option<Self> {
        let form = |own: usize| {
            let row = |index: usize| {
                let point = points[corners[index]];
                let mut row: Vec<f64> = point[..dimension].to_vec();
                row.extend([1.0, if index == own { 1.0 } else { 0.0 }]);
                row
            };
            let solution = solve((0..corners.len()).map(row).collect())?;
            let mut form = [0.0; 4];
            form[..dimension].copy_from_slice(&solution[..dimension]);
            form[3] = solution[dimension];
            Some(form)
        };
        let mut forms = [[0.0; 4]; 4];
        for (own, place) in forms.iter_mut().enumerate().take(corners.len()) {
            *place = form(own)?;
        }
        Some(Self { corners: corners.to_vec(), forms })
    }

    /// Returns the barycentric coordinates of a point; 0 for corners that a simplex of fewer dimensions lacks.
    pub(crate) fn coordinates(&self, point: Point) -> [f64; 4] {
        [self.coordinate(0, point), self.coordinate(1, point), self.coordinate(2, point), self.coordinate(3, point)]
    }

    /// Returns one of them.
    #[inline(always)]
    pub(crate) fn coordinate(&self, corner: usize, point: Point) -> f64 {
        let form = &self.forms[corner];
        form[0] * point[0] + form[1] * point[1] + form[2] * point[2] + form[3]
    }

    /// Returns the least of a point's barycentric coordinates.
    pub(crate) fn least_of(&self, coordinates: &[f64; 4]) -> f64 {
        coordinates[..self.corners.len()].iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// Calls `visit` with every set of `size` of `count` indices, in ascending order.
pub(crate) fn subsets(count: usize, size: usize, visit: &mut impl FnMut(&[usize])) {
    fn extend(from: usize, count: usize, size: usize, chosen: &mut Vec<usize>, visit: &mut impl FnMut(&[usize])) {
        if chosen.len() == size {
            visit(chosen);
            return;
        }
        for next in from..count {
            chosen.push(next);
            extend(next + 1, count, size, chosen, visit);
            chosen.pop();
        }
    }
    extend(0, count, size, &mut Vec::with_capacity(size), visit);
}

fn primes() -> impl Iterator<Item = u32> {
    (2_u32..).filter(|number| (2..*number).take_while(|by| by * by <= *number).all(|by| number % by != 0))
}

/// Returns the simplices of a triangulation of points, the Delaunay triangulation if the heights are the squared distances
/// from any point: those above which no other point's height lies below the plane through their own.
pub(crate) fn triangulate(points: &[Point], heights: &[f64], dimension: usize) -> Vec<Simplex> {
    // Points on a sphere have several triangulations; small differences choose one. They must have no ratios in whole
    // numbers, or opposite corners of a box tie again: roots of primes have none.
    let lifted: Vec<f64> =
        heights.iter().zip(primes()).map(|(height, prime)| height + 1e-9 * libm::sqrt(f64::from(prime))).collect();
    let mut simplices = Vec::new();
    subsets(points.len(), dimension + 1, &mut |corners| {
        let Some(simplex) = Simplex::new(corners, points, dimension) else { return };
        let is_below = |index: usize| {
            let plane: f64 = simplex
                .coordinates(points[index])
                .iter()
                .zip(&simplex.corners)
                .map(|(part, corner)| part * lifted[*corner])
                .sum();
            lifted[index] < plane
        };
        if !(0..points.len()).any(|index| !corners.contains(&index) && is_below(index)) {
            simplices.push(simplex);
        }
    });
    simplices
}

/// Returns the weights of the nearest point of a triangle, given by its corners; the last two or all of them may be the
/// same (Ericson, *Real-time collision detection*, 2005, 5.1.5).
pub(crate) fn nearest_of_triangle([a, b, c]: [Point; 3], to: Point) -> [f64; 3] {
    let (ab, ac) = (sub(b, a), sub(c, a));
    let along = |from: Point| (dot(ab, sub(to, from)), dot(ac, sub(to, from)));
    let ((ab_a, ac_a), (ab_b, ac_b), (ab_c, ac_c)) = (along(a), along(b), along(c));
    if ab_a <= 0.0 && ac_a <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if ab_b >= 0.0 && ac_b <= ab_b {
        return [0.0, 1.0, 0.0];
    }
    let part_c = ab_a * ac_b - ab_b * ac_a;
    if part_c <= 0.0 && ab_a >= 0.0 && ab_b <= 0.0 {
        let share = ab_a / (ab_a - ab_b);
        return [1.0 - share, share, 0.0];
    }
    if ac_c >= 0.0 && ab_c <= ac_c {
        return [0.0, 0.0, 1.0];
    }
    let part_b = ab_c * ac_a - ab_a * ac_c;
    if part_b <= 0.0 && ac_a >= 0.0 && ac_c <= 0.0 {
        let share = ac_a / (ac_a - ac_c);
        return [1.0 - share, 0.0, share];
    }
    let part_a = ab_b * ac_c - ab_c * ac_b;
    let (beyond_b, beyond_c) = (ac_b - ab_b, ab_c - ac_c);
    if part_a <= 0.0 && beyond_b >= 0.0 && beyond_c >= 0.0 {
        let share = beyond_b / (beyond_b + beyond_c);
        return [0.0, 1.0 - share, share];
    }
    let all = part_a + part_b + part_c;
    [1.0 - part_b / all - part_c / all, part_b / all, part_c / all]
}

/// Returns the weights of the nearest point of the hull of points, found among all their corners, edges and triangles.
pub(crate) fn nearest(points: &[Point], to: Point) -> Vec<f64> {
    let mut best = (f64::INFINITY, Vec::new());
    for size in 1..=3.min(points.len()) {
        subsets(points.len(), size, &mut |corners| {
            let first = points[corners[0]];
            let sides: Vec<Point> = corners[1..].iter().map(|corner| sub(points[*corner], first)).collect();
            let from = sub(to, first);
            // The foot on what the corners span.
            let row = |side: &Point| {
                let mut row: Vec<f64> = sides.iter().map(|other| dot(*side, *other)).collect();
                row.push(dot(*side, from));
                row
            };
            let Some(parts) = solve(sides.iter().map(row).collect()) else { return };
            let rest = 1.0 - parts.iter().sum::<f64>();
            if rest < 0.0 || parts.iter().any(|part| *part < 0.0) {
                return;
            }
            let foot = sides.iter().zip(&parts).fold(first, |foot, (side, part)| add(foot, scale(*side, *part)));
            let distance = length(sub(foot, to));
            if distance < best.0 {
                let mut weights = vec![0.0; points.len()];
                weights[corners[0]] = rest;
                corners[1..].iter().zip(&parts).for_each(|(corner, part)| weights[*corner] = *part);
                best = (distance, weights);
            }
        });
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_have_the_dimension_of_their_colors() {
        let of = |colors: &[Point]| Frame::new(colors).dimension();
        assert_eq!((of(&[]), of(&[[0.5; 3]]), of(&[[0.1; 3], [0.9; 3], [0.4; 3]])), (0, 0, 1));
        assert_eq!(of(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.3, 0.0]]), 2);
        assert_eq!(of(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.3, 0.1]]), 3);
    }

    #[test]
    fn triangulations_fill_the_hull_once() {
        // The corners of the cube lie on a sphere.
        let cube = |order: [u8; 8]| order.map(|i| [0, 1, 2].map(|c| f64::from(i >> c & 1)));
        let mut orders = vec![[0, 1, 2, 4, 3, 6, 5, 7]];
        for turn in 0..8_u8 {
            orders.extend([1, 3, 5, 7].map(|step| std::array::from_fn(|i| (turn + step * i as u8) % 8)));
        }
        for cube in orders.into_iter().map(cube) {
            let heights = cube.map(|p| dot(sub(p, [0.5; 3]), sub(p, [0.5; 3])));
            let simplices = triangulate(&cube, &heights, 3);
            let volume = |simplex: &Simplex| {
                let [a, b, c, d] = [0, 1, 2, 3].map(|i| cube[simplex.corners[i]]);
                dot(crate::vector::cross(sub(b, a), sub(c, a)), sub(d, a)).abs() / 6.0
            };
            assert!((simplices.iter().map(volume).sum::<f64>() - 1.0).abs() < 1e-12, "{cube:?}: {simplices:?}");
        }
    }

    #[test]
    fn the_nearest_point_is_on_a_corner_an_edge_or_a_face() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let near = |to: Point| nearest(&points, to).iter().map(|w| (w * 100.0).round() / 100.0).collect::<Vec<_>>();
        assert_eq!(near([-1.0, -1.0, -1.0]), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(near([0.25, -1.0, -1.0]), [0.75, 0.25, 0.0, 0.0]);
        assert_eq!(near([0.25, 0.5, -1.0]), [0.25, 0.25, 0.5, 0.0]);
    }

    #[test]
    fn triangles_have_the_nearest_points_that_a_search_finds() {
        let mut state = 5_u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let at = |points: &[Point], weights: &[f64]| {
            points.iter().zip(weights).fold([0.0; 3], |sum, (point, weight)| add(sum, scale(*point, *weight)))
        };
        for kind in 0..3 {
            for _ in 0..2000 {
                let mut points = [(); 3].map(|()| [(); 3].map(|()| draw()));
                // Triangles, segments and points.
                (0..kind).for_each(|same| points[2 - same] = points[2 - kind]);
                let to = [(); 3].map(|()| 4.0 * draw() - 1.5);
                let weights = nearest_of_triangle(points, to);
                assert!(weights.iter().all(|weight| *weight >= 0.0), "{weights:?}");
                let (found, searched) = (at(&points, &weights), at(&points, &nearest(&points, to)));
                assert!(length(sub(found, searched)) < 1e-7, "{points:?} to {to:?}: {found:?}, {searched:?}");
            }
        }
    }
}
