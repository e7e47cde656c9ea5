//! The lines that wires are drawn as.

use egui::{Pos2, Rect, Vec2, vec2};

/// How a wire runs through the points between its ends.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Through {
    /// Straight down, as where a layout leads it.
    Down,
    /// The shortest way, as through dots.
    Dots,
}

/// A wire as a line of short pieces.
#[derive(Clone)]
pub(super) struct Curve {
    /// From the top down.
    pub(super) line: Vec<Pos2>,
    /// What it covers.
    pub(super) bounds: Rect,
}

impl Curve {
    /// A smooth line that leaves its first point and meets its last one vertically.
    pub(super) fn new(points: &[Pos2], through: Through) -> Self {
        let mut line = Vec::new();
        for (index, ends) in points.windows(2).enumerate() {
            let [from, to] = [ends[0], ends[1]];
            let (first, last) = (index == 0, index + 2 == points.len());
            let out = if first || through == Through::Down {
                vertical(from, to)
            } else {
                toward(points[index - 1], to, from.distance(to))
            };
            let back = if last || through == Through::Down {
                vertical(from, to)
            } else {
                toward(from, points[index + 2], from.distance(to))
            };
            cubic(&mut line, [from, from + out, to - back, to], first);
        }
        let bounds = Rect::from_points(&line);
        Self { line, bounds }
    }

    /// How far a place is from it.
    pub(super) fn distance(&self, at: Pos2) -> f32 {
        self.line.windows(2).map(|ends| to_segment(at, ends[0], ends[1])).fold(f32::INFINITY, f32::min)
    }

    /// The place in the middle of its points.
    pub(super) fn middle(&self) -> Pos2 {
        self.line.get(self.line.len() / 2).copied().unwrap_or_default()
    }
}

/// How far along the vertical a curve between two points is pulled.
fn vertical(from: Pos2, to: Pos2) -> Vec2 {
    let [dx, dy] = [(to.x - from.x).abs(), to.y - from.y];
    let pull = if dy > 0.0 { (0.5 * dy).max((0.5 * dx).min(24.0)) } else { 50.0_f32.min(24.0 + 0.5 * (dx - dy)) };
    vec2(0.0, pull)
}

/// How a curve passes a point between two others.
fn toward(before: Pos2, after: Pos2, length: f32) -> Vec2 {
    (after - before).normalized() * (length / 3.0)
}

fn cubic(line: &mut Vec<Pos2>, [a, b, c, d]: [Pos2; 4], first: bool) {
    if first {
        line.push(a);
    }
    if a.x == b.x && b.x == c.x && c.x == d.x && a.y <= b.y && c.y <= d.y {
        line.push(d);
        return;
    }
    let pieces = (a.distance(d) / 9.0).clamp(8.0, 36.0) as usize;
    for piece in 1..=pieces {
        let t = piece as f32 / pieces as f32;
        let s = 1.0 - t;
        let sum = a.to_vec2() * (s * s * s)
            + b.to_vec2() * (3.0 * s * s * t)
            + c.to_vec2() * (3.0 * s * t * t)
            + d.to_vec2() * (t * t * t);
        line.push(sum.to_pos2());
    }
}

/// How far a place is from a straight piece.
pub(super) fn to_segment(at: Pos2, from: Pos2, to: Pos2) -> f32 {
    let along = to - from;
    let share = (at - from).dot(along) / along.length_sq().max(1e-6);
    at.distance(from + along * share.clamp(0.0, 1.0))
}
