//! The polylines that wires are drawn as.

use super::view::View;
use egui::{Pos2, Rect, Vec2, vec2};

/// Maximum distance between the drawn polyline and the curve, in screen points.
const TOLERANCE: f32 = 0.2;

/// Way in which a wire passes the points between its ends.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum WireShape {
    /// Vertically, as along a route of the automatic layout.
    Down,
    /// By the shortest way, as through dots.
    Dots,
}

/// A wire as a polyline.
#[derive(Clone)]
pub(super) struct Curve {
    /// Points, from the output to the pin.
    pub(super) line: Vec<Pos2>,
    /// Bounding box.
    pub(super) bounds: Rect,
}

impl Curve {
    /// Creates a smooth curve that leaves its first point and reaches its last one vertically.
    pub(super) fn new(points: &[Pos2], through: WireShape) -> Self {
        let mut line = Vec::new();
        for (index, ends) in points.windows(2).enumerate() {
            let [from, to] = [ends[0], ends[1]];
            let (first, last) = (index == 0, index + 2 == points.len());
            let out = if first || through == WireShape::Down {
                vertical(from, to)
            } else {
                toward(points[index - 1], to, from.distance(to))
            };
            let back = if last || through == WireShape::Down {
                vertical(from, to)
            } else {
                toward(from, points[index + 2], from.distance(to))
            };
            cubic(&mut line, [from, from + out, to - back, to], first);
        }
        let bounds = Rect::from_points(&line);
        Self { line, bounds }
    }

    /// Returns the visible pieces in screen points, with no more points than can be told apart.
    pub(super) fn seen(&self, view: &View) -> Vec<Vec<Pos2>> {
        let room = view.rect.expand(8.0);
        let mut pieces = Vec::new();
        let mut piece: Vec<Pos2> = Vec::new();
        // Points skipped since the last one that was kept.
        let mut left_out: Vec<Pos2> = Vec::new();
        let mut last = None;
        for (index, at) in self.line.iter().map(|at| view.screen(*at)).enumerate() {
            let Some(before) = last.replace(at) else { continue };
            if !room.intersects(Rect::from_two_pos(before, at)) {
                if piece.len() > 1 {
                    pieces.push(std::mem::take(&mut piece));
                }
                piece.clear();
                left_out.clear();
                continue;
            }
            if piece.is_empty() {
                piece.push(before);
            }
            let next = self.line.get(index + 1).map(|next| view.screen(*next));
            left_out.push(at);
            let bends = |next: Pos2| {
                let far = |kept: &Pos2| left_out.iter().any(|at| to_segment(*at, *kept, next) > TOLERANCE);
                piece.last().is_none_or(far)
            };
            if next.is_none_or(bends) || !room.contains(at) {
                piece.push(at);
                left_out.clear();
            }
        }
        if piece.len() > 1 {
            pieces.push(piece);
        }
        pieces
    }

    /// Returns the distance from a place to the curve.
    pub(super) fn distance(&self, at: Pos2) -> f32 {
        self.line.windows(2).map(|ends| to_segment(at, ends[0], ends[1])).fold(f32::INFINITY, f32::min)
    }

    /// Returns the point halfway along the list of points.
    pub(super) fn middle(&self) -> Pos2 {
        self.line.get(self.line.len() / 2).copied().unwrap_or_default()
    }
}

/// Returns the vertical offset of the control points of a curve between two points.
fn vertical(from: Pos2, to: Pos2) -> Vec2 {
    let [dx, dy] = [(to.x - from.x).abs(), to.y - from.y];
    let pull = if dy > 0.0 { (0.5 * dy).max((0.5 * dx).min(24.0)) } else { 50.0_f32.min(24.0 + 0.5 * (dx - dy)) };
    vec2(0.0, pull)
}

/// Returns the tangent at a point that lies between two others.
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
    let pieces = (a.distance(d) / 6.0).clamp(16.0, 40.0) as usize;
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

/// Returns the distance from a place to a line segment.
pub(super) fn to_segment(at: Pos2, from: Pos2, to: Pos2) -> f32 {
    let along = to - from;
    let share = (at - from).dot(along) / along.length_sq().max(1e-6);
    at.distance(from + along * share.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    fn view(zoom: f32) -> View {
        View { rect: Rect::from_min_size(Pos2::ZERO, vec2(400.0, 300.0)), zoom, ..View::default() }
    }

    #[test]
    fn a_curve_is_drawn_where_it_runs_with_few_points() {
        let curve = Curve::new(&[pos2(20.0, 10.0), pos2(300.0, 250.0)], WireShape::Down);
        for zoom in [0.1, 0.5, 1.0] {
            let pieces = curve.seen(&view(zoom));
            assert_eq!(pieces.len(), 1);
            let [line] = &pieces[..] else { unreachable!() };
            assert!(line.len() < curve.line.len());
            for at in &curve.line {
                let at = *at * zoom;
                let far = line.windows(2).map(|ends| to_segment(at, ends[0], ends[1])).fold(f32::INFINITY, f32::min);
                assert!(far < 1.2 * TOLERANCE, "{far} at {zoom}");
            }
        }
    }

    #[test]
    fn what_is_out_of_view_is_not_drawn() {
        let out = Curve::new(&[pos2(20.0, 310.0), pos2(300.0, 450.0)], WireShape::Down);
        assert!(out.seen(&view(1.0)).is_empty());
        let through = Curve::new(&[pos2(-50.0, -200.0), pos2(100.0, 900.0)], WireShape::Down);
        let pieces = through.seen(&view(1.0));
        assert!(!pieces.is_empty() && pieces.concat().iter().all(|at| at.y > -60.0 && at.y < 360.0));
    }
}
