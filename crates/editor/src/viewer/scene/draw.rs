//! How things in the world are drawn over the picture.

use super::Seen;
use super::eye::{Eye, Pose};
use super::gizmo::Gizmo;
use super::grips::{CORNERS, Part, REACH, Window};
use crate::state::State;
use crate::viewer::picture::place;
use egui::{Align2, Color32, FontId, Painter, Pos2, Shape, Stroke, vec2};
use glam::DVec3;
use std::f64::consts::TAU;
use trochoid::{CheckedGraph, Role};

/// Color of what is moved on the ground, as that of paths.
const GROUND: Color32 = Color32::from_rgb(0x3f, 0xb5, 0xb0);
/// Color of heights.
const HEIGHT: Color32 = Color32::from_rgb(0x8c, 0xd0, 0x6a);
/// Color of rotations.
const TURN: Color32 = Color32::from_rgb(0x6a, 0x9c, 0xe0);
/// Color of scale factors.
const SCALE: Color32 = Color32::from_rgb(0xd9, 0x8c, 0xd6);
/// Color of lights.
const LIGHT: Color32 = Color32::from_rgb(0xf4, 0xc9, 0x5d);
/// Color of cameras.
const CAMERA: Color32 = Color32::from_rgb(0xe8, 0xe4, 0xd8);
/// Number of lines of a circle.
const PIECES: u32 = 64;
/// Number of rays around the sun.
const RAYS: u32 = 8;

/// Draws a line over any picture: with a dark rim.
fn line(painter: &Painter, points: Vec<Pos2>, color: Color32) {
    for (width, color) in [(3.4, Color32::from_black_alpha(110)), (1.5, color)] {
        painter.add(Shape::line(points.clone(), Stroke::new(width, color)));
    }
}

/// Draws a line between points of the world, as far as both are in front of the camera.
fn segment(painter: &Painter, window: &Window, ends: [DVec3; 2], color: Color32) {
    if let [Some(a), Some(b)] = ends.map(|end| window.spot(end)) {
        line(painter, vec![a, b], color);
    }
}

/// Draws what joins the handles of a thing.
pub(super) fn gizmo(painter: &Painter, gizmo: &Gizmo, window: &Window) {
    let part = |part: Part| gizmo.spot(part, window);
    if let Some(direction) = gizmo.toward() {
        match window.far(direction) {
            Some(spot) => {
                for ray in 0..RAYS {
                    let angle = TAU as f32 * ray as f32 / RAYS as f32;
                    let toward = vec2(angle.cos(), angle.sin());
                    line(painter, vec![spot + toward * 11.0, spot + toward * 17.0], LIGHT);
                }
            }
            None => segment(painter, window, [window.focus, window.tip(direction)], LIGHT),
        }
        return;
    }
    if let Some(of) = gizmo.of {
        segment(painter, window, [of, gizmo.at], LIGHT);
    }
    let Some(middle) = part(Part::Move) else { return };
    if part(Part::Turn).is_some() {
        let reach = window.length(gizmo.at) * f64::from(REACH);
        let around = |piece: u32| {
            let (sin, cos) = (TAU * f64::from(piece) / f64::from(PIECES)).sin_cos();
            window.spot(gizmo.at + DVec3::new(cos, 0.0, sin) * reach)
        };
        if let Some(circle) = (0..=PIECES).map(around).collect() {
            line(painter, circle, TURN);
        }
    }
    for (outer, color) in [(Part::Turn, TURN), (Part::Scale, SCALE), (Part::Height, HEIGHT)] {
        if let Some(spot) = part(outer) {
            line(painter, vec![middle, spot], color);
        }
    }
}

/// Draws a handle.
pub(super) fn grip(painter: &Painter, part: Part, spot: Pos2, strong: bool) {
    let rim = Stroke::new(1.5, Color32::from_black_alpha(200));
    let color = match part {
        Part::Move => GROUND,
        Part::Height => HEIGHT,
        Part::Turn => TURN,
        Part::Scale => SCALE,
        Part::Direction => LIGHT,
    };
    let fill = if strong { Color32::WHITE } else { color };
    let radius = if strong { 6.5 } else { 5.0 };
    match part {
        Part::Move | Part::Turn => drop(painter.circle(spot, radius, fill, rim)),
        Part::Direction => drop(painter.circle(spot, radius + 2.0, fill, rim)),
        Part::Height => {
            let corners = [vec2(0.0, -1.3), vec2(1.1, 0.8), vec2(-1.1, 0.8)].map(|to| spot + to * radius);
            painter.add(Shape::convex_polygon(corners.to_vec(), fill, rim));
        }
        Part::Scale => {
            let corners = [vec2(-0.9, -0.9), vec2(0.9, -0.9), vec2(0.9, 0.9), vec2(-0.9, 0.9)];
            painter.add(Shape::convex_polygon(corners.map(|to| spot + to * radius).to_vec(), fill, rim));
        }
    }
}

/// Draws values beside a handle.
pub(super) fn told(painter: &Painter, spot: Pos2, text: &str) {
    let galley = painter.layout_no_wrap(text.into(), FontId::proportional(12.0), Color32::WHITE);
    let size = galley.size();
    let back = Align2::LEFT_BOTTOM.anchor_size(spot + vec2(12.0, -12.0), size).expand2(vec2(4.0, 2.0));
    // Within the picture's panel, on the other side of the handle if need be.
    let room = painter.clip_rect();
    let aside = if back.right() > room.right() { -size.x - 24.0 } else { 0.0 };
    let down = if back.top() < room.top() { size.y + 24.0 } else { 0.0 };
    let back = back.translate(vec2(aside, down));
    painter.rect_filled(back, 3.0, Color32::from_black_alpha(180));
    painter.galley(back.min + vec2(4.0, 2.0), galley, Color32::WHITE);
}

/// Draws the selected cameras: the picture of one that is seen from outside, or the horizon of the one that shows it.
pub(super) fn cameras(painter: &Painter, state: &State, graph: &CheckedGraph, seen: &Seen, window: &Window) {
    for name in &state.selection {
        let whole = state.whole_name(name);
        let Some(id) = graph.find(&whole) else { continue };
        if graph.node(id).ty.declaration().role != Some(Role::Camera) {
            continue;
        }
        if whole == seen.name {
            horizon(painter, window);
            continue;
        }
        let pose = Pose::of(graph, id, state.frame);
        let eye = Eye::new(&pose, seen.aspect);
        let corners = CORNERS.map(|corner| eye.beside(corner, pose.target).unwrap_or(pose.target));
        for (index, corner) in corners.iter().enumerate() {
            let start = if eye.orthographic { eye.ray(CORNERS[index]).0 } else { pose.position };
            segment(painter, window, [start, *corner], CAMERA);
            segment(painter, window, [*corner, corners[(index + 1) % corners.len()]], CAMERA);
        }
    }
}

/// Draws the horizon of the camera.
fn horizon(painter: &Painter, window: &Window) {
    let ahead = window.eye.forward.with_y(0.0).normalize_or_zero();
    let aside = ahead.cross(DVec3::Y);
    let ends = [ahead - aside, ahead + aside].map(|toward| window.eye.toward(toward));
    if let [Some(a), Some(b)] = ends.map(|end| end.map(|share| place(window.rect, share))) {
        // Both ends are beyond the edges of a picture of any angle.
        let further = (b - a) * 4.0;
        let painter = painter.with_clip_rect(painter.clip_rect().intersect(window.rect));
        painter.extend(Shape::dashed_line(&[a - further, b + further], Stroke::new(1.2, CAMERA), 6.0, 5.0));
    }
}
