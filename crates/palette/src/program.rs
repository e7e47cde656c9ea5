//! Linear programs in three unknowns, solved by their corners.

use crate::vector::{Point, cross, dot, scale};

/// A half-space: normal·x ≤ offset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Half {
    pub(crate) normal: Point,
    pub(crate) offset: f64,
}

/// How far rounding may carry a corner out of a half-space.
const ROUNDING: f64 = 1e-7;

/// Returns the point of some half-spaces with the least cost·x; `None` if they have no point in common. Their
/// intersection must be bounded. Few half-spaces are expected: every corner is tried.
pub(crate) fn least(cost: Point, halves: &[Half]) -> Option<Point> {
    let mut best: Option<(f64, Point)> = None;
    for (i, first) in halves.iter().enumerate() {
        for (j, second) in halves.iter().enumerate().skip(i + 1) {
            let along = cross(first.normal, second.normal);
            if dot(along, along) < 1e-12 {
                continue;
            }
            for third in &halves[j + 1..] {
                let determinant = dot(along, third.normal);
                if determinant.abs() < 1e-7 {
                    continue;
                }
                let terms = [
                    scale(along, third.offset),
                    scale(cross(second.normal, third.normal), first.offset),
                    scale(cross(third.normal, first.normal), second.offset),
                ];
                let point = [0, 1, 2].map(|c| (terms[0][c] + terms[1][c] + terms[2][c]) / determinant);
                let value = dot(cost, point);
                if best.is_some_and(|(known, _)| value >= known) {
                    continue;
                }
                if halves.iter().all(|half| dot(half.normal, point) <= half.offset + ROUNDING) {
                    best = Some((value, point));
                }
            }
        }
    }
    best.map(|(_, point)| point)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_corner_of_a_cut_cube() {
        let half = |normal: Point, offset: f64| Half { normal, offset };
        let mut halves: Vec<Half> = Vec::new();
        for c in 0..3 {
            let mut normal = [0.0; 3];
            normal[c] = 1.0;
            halves.push(half(normal, 1.0));
            halves.push(half(normal.map(|v: f64| -v), 0.0));
        }
        assert_eq!(least([-1.0, -2.0, -3.0], &halves), Some([1.0, 1.0, 1.0]));
        halves.push(half([1.0, 1.0, 1.0], 2.5));
        let cut = least([-1.0, -2.0, -3.0], &halves).expect("not empty");
        assert!((0..3).all(|c| (cut[c] - [0.5, 1.0, 1.0][c]).abs() < 1e-12), "{cut:?}");
        halves.push(half([-1.0, -1.0, -1.0], -2.6));
        assert_eq!(least([-1.0, -2.0, -3.0], &halves), None);
    }
}
