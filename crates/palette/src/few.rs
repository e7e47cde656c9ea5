//! Palettes of one to three colors, whose hulls have no volume, near all pixels.
//!
//! A sequence of linear programs: for each color p at a distance d from its nearest point Σ wᵢCᵢ of the hull, in the
//! direction n, moving the corners by δᵢ changes d by −Σ wᵢ n·δᵢ. Minimized is the largest distance.

use crate::Cloud;
use crate::found::{Enclosing, Palette};
use crate::order::order;
use crate::simplex::nearest;
use crate::vector::{Point, add, dot, length, mean, scale, sub};
use microlp::{ComparisonOp, OptimizationDirection, Problem, SolveOutcome};

/// Nearest points of a hull.
struct Near {
    points: Vec<Point>,
    /// For each color, the weights of the nearest point, and what leads from there to the color.
    feet: Vec<(Vec<f64>, Point)>,
    largest: f64,
}

impl Near {
    fn of(points: Vec<Point>, colors: &[Point]) -> Self {
        let foot = |color: &Point| {
            let weights = nearest(&points, *color);
            let at = points.iter().zip(&weights).fold([0.0; 3], |sum, (point, w)| add(sum, scale(*point, *w)));
            (weights, sub(*color, at))
        };
        let feet: Vec<(Vec<f64>, Point)> = colors.iter().map(foot).collect();
        let largest = feet.iter().map(|(_, rest)| length(*rest)).fold(0.0, f64::max);
        Self { points, feet, largest }
    }

    /// Returns the points moved by at most a radius, so that the largest distance falls most.
    fn moved(&self, radius: f64) -> Option<Vec<Point>> {
        let mut problem = Problem::new(OptimizationDirection::Minimize);
        let range = |v: f64| ((-v).max(-radius), (255.0 - v).min(radius));
        let moves: Vec<_> = self.points.iter().map(|point| point.map(|v| problem.add_var(0.0, range(v)))).collect();
        let largest = problem.add_var(1.0, (0.0, f64::INFINITY));
        for (weights, rest) in self.feet.iter().filter(|(_, rest)| length(*rest) > 1e-9) {
            let distance = length(*rest);
            let mut terms = vec![(largest, -1.0)];
            for (by, weight) in moves.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
                (0..3).for_each(|c| terms.push((by[c], -weight * rest[c] / distance)));
            }
            problem.add_constraint(terms, ComparisonOp::Le, -distance);
        }
        let SolveOutcome::Solution(solution) = problem.solve().ok()? else { return None };
        let moved = |(point, by): (&Point, &[microlp::Variable; 3])| {
            [0, 1, 2].map(|c| (point[c] + solution[by[c]]).clamp(0.0, 255.0))
        };
        Some(self.points.iter().zip(&moves).map(moved).collect())
    }
}

/// Finds the palettes of one, two and three colors from which no pixel is farther than some steps of 8 bits, given the
/// corners of the pixels' hull.
pub(crate) fn few(corners: &[Point], extremes: &[Point], cloud: &Cloud, within: f64) -> Vec<Enclosing> {
    let mut found = Vec::new();
    if within <= 0.0 {
        return found;
    }
    // Each number of colors starts from the best of one less, and the color farthest from these.
    let mut points = vec![mean(corners)];
    for _ in 0..3 {
        let mut near = Near::of(points, corners);
        let mut radius = 32.0;
        for _ in 0..60 {
            match near.moved(radius).map(|moved| Near::of(moved, corners)) {
                Some(moved) if moved.largest < near.largest - 1e-9 => near = moved,
                _ => radius /= 2.0,
            }
            if radius < 1e-3 {
                break;
            }
        }
        found.extend([1, 16, 256].into_iter().find_map(|units| rounded(&near.points, units, cloud, extremes, within)));
        points = near.points;
        let rest = near.feet.iter().map(|(_, rest)| dot(*rest, *rest));
        let Some((farthest, _)) = rest.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        points.push(corners[farthest]);
    }
    found
}

/// Rounds points to a grid, if no color is then too far from them.
fn rounded(points: &[Point], units: u32, cloud: &Cloud, extremes: &[Point], within: f64) -> Option<Enclosing> {
    let parts = f64::from(units);
    let colors: Vec<[f64; 3]> = points.iter().map(|point| point.map(|v| (v * parts).round() / parts / 255.0)).collect();
    let palette = Palette::named(order(&colors).into_iter().map(|index| colors[index]).collect(), units);
    palette.is_near(extremes, within).then(|| {
        let outside = palette.outside(cloud);
        Enclosing::new(palette, 0.0, extremes, outside)
    })
}
