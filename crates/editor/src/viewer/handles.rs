//! Handles in the picture for the Bézier paths of a sea: bursts, guides, and bodies.

use super::picture::{place, share};
use crate::actions::Action;
use crate::document::{Edit, Path};
use crate::evaluate::Result;
use crate::field::Gesture;
use crate::state::State;
use egui::{
    Align2, Color32, CursorIcon, FontId, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, WidgetInfo, WidgetType, pos2,
    vec2,
};
use serde_json::{Value, json};
use trochoid::{CheckedNode, Dynamics, NodeId, Paths, Role, Source};

/// Maximum number of paths drawn per list.
const PATHS: usize = 64;
/// Number of segments of a drawn curve.
const PIECES: usize = 48;

type Vector = [f64; 3];

/// Projection of a camera onto a picture of width and height 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eye {
    position: Vector,
    right: Vector,
    up: Vector,
    forward: Vector,
    orthographic: bool,
    /// Picture widths per unit tangent, or per meter if orthographic.
    scale: f64,
    /// Aspect ratio: width divided by height.
    aspect: f64,
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn sum(a: Vector, by: f64, b: Vector) -> Vector {
    [0, 1, 2].map(|axis| a[axis] + by * b[axis])
}

fn unit(a: Vector) -> Option<Vector> {
    let length = dot(a, a).sqrt();
    (length > 1e-6).then(|| a.map(|part| part / length))
}

impl Eye {
    /// Creates the projection of a camera from its knobs at the frame.
    pub(super) fn new(result: &Result, camera: NodeId) -> Self {
        let graph = &result.lens.graph;
        let knobs = graph.settle(camera, result.frame);
        let format = graph.format();
        let aspect = f64::from(format.width()) / f64::from(format.height());
        let (position, target) = (knobs.vector3("position"), knobs.vector3("target"));
        let forward = unit(sum(target, -1.0, position)).unwrap_or([0.0, 0.0, -1.0]);
        let right = unit(cross(forward, [0.0, 1.0, 0.0])).unwrap_or([1.0, 0.0, 0.0]);
        let up = cross(right, forward);
        let (sin, cos) = knobs.number("roll").to_radians().sin_cos();
        let orthographic = knobs.text("projection") == "orthographic";
        let scale = if orthographic {
            1.0 / (knobs.number("height") * aspect)
        } else {
            0.5 / (0.5 * knobs.number("fov").to_radians()).tan()
        };
        let turned = |a: Vector, by: f64, b: Vector| sum(a.map(|part| part * cos), by * sin, b);
        Self {
            position,
            right: turned(right, -1.0, up),
            up: turned(up, 1.0, right),
            forward,
            orthographic,
            scale,
            aspect,
        }
    }

    /// Projects a world-space point, in fractions of the picture; `None` behind the camera.
    pub(super) fn project(&self, point: Vector) -> Option<Pos2> {
        let offset = sum(point, -1.0, self.position);
        let depth = dot(offset, self.forward);
        let scale = match self.orthographic {
            true => self.scale,
            false if depth > 1e-3 => self.scale / depth,
            false => return None,
        };
        let (x, y) = (dot(offset, self.right) * scale, dot(offset, self.up) * scale * self.aspect);
        Some(pos2(0.5 + x as f32, 0.5 - y as f32))
    }

    /// Returns the point of a horizontal plane seen at a place in the picture; `None` above the horizon.
    pub(super) fn on_level(&self, at: Pos2, level: f64) -> Option<Vector> {
        let across = (f64::from(at.x) - 0.5) / self.scale;
        let upward = (0.5 - f64::from(at.y)) / (self.scale * self.aspect);
        let aside = sum(self.right.map(|part| part * across), upward, self.up);
        let (origin, direction) = match self.orthographic {
            true => (sum(self.position, 1.0, aside), self.forward),
            false => (self.position, sum(self.forward, 1.0, aside)),
        };
        let distance = (level - origin[1]) / direction[1];
        (distance.is_finite() && distance > 0.0 && distance < 1e6).then(|| sum(origin, distance, direction))
    }
}

fn has_role(node: &CheckedNode, role: Role) -> bool {
    node.ty.declaration().role == Some(role)
}

/// Returns the camera that a picture shows a sea through.
fn camera(result: &Result, sea: NodeId) -> Option<NodeId> {
    let graph = &result.lens.graph;
    graph.nodes().iter().enumerate().find_map(|(index, node)| {
        let is_render = has_role(node, Role::Render) && graph.dependencies([NodeId(index)], result.frame)[sea.0];
        let settled = is_render.then(|| graph.settle(NodeId(index), result.frame))?;
        settled.sources().into_iter().find_map(|source| match source {
            Source::Output { node, .. } if has_role(graph.node(*node), Role::Camera) => Some(*node),
            _ => None,
        })
    })
}

/// A path: its place in the document, and its control points as x, z pairs relative to the sea's origin.
struct SeaPath {
    name: String,
    path: Path,
    points: [f64; 8],
}

fn ways(state: &State, sea: &str, paths: &Paths) -> Vec<SeaPath> {
    let body = Path::node(sea);
    let mut ways = Vec::new();
    for list in paths.lists.iter().map(|list| list.as_str()) {
        let records = state.sheet().get(&body.to(list)).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        for (index, record) in records.iter().enumerate().take(PATHS) {
            let numbers = record.get(paths.knob.as_str()).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
            let numbers: Vec<f64> = numbers.iter().filter_map(Value::as_f64).collect();
            if let Ok(points) = <[f64; 8]>::try_from(numbers) {
                let name = format!("{list}[{index}]");
                ways.push(SeaPath { name, path: body.to(list).to(index).to(paths.knob.as_str()), points });
            }
        }
    }
    ways
}

/// Draws the paths of the selected sea over its picture; control points can be dragged in the plane of the sea at rest.
pub(super) fn handles_ui(
    ui: &mut Ui,
    area: Rect,
    rect: Rect,
    state: &State,
    result: &Result,
    actions: &mut Vec<Action>,
) {
    let Some(name) = state.chosen() else { return };
    let graph = &result.lens.graph;
    let Some(sea) = graph.find(&state.whole_name(name)) else { return };
    let settled = graph.settle(sea, result.frame);
    let Some(paths) = settled.node().dynamics().and_then(Dynamics::paths) else { return };
    let Some(eye) = camera(result, sea).map(|camera| Eye::new(result, camera)) else { return };
    let [x, level, z] = paths.origin;
    let at = |point: [f64; 2]| eye.project([x + point[0], level, z + point[1]]).map(|share| place(rect, share));
    let painter = ui.painter().with_clip_rect(area);
    for way in ways(state, name, &paths) {
        let points: [[f64; 2]; 4] = std::array::from_fn(|index| [way.points[2 * index], way.points[2 * index + 1]]);
        curve(&painter, points, &at);
        for (index, point) in points.into_iter().enumerate() {
            let Some(spot) = at(point).filter(|spot| area.contains(*spot)) else { continue };
            let id = ui.id().with((way.path.to_string(), index));
            let grip = ui.interact(Rect::from_center_size(spot, vec2(13.0, 13.0)), id, Sense::drag());
            grip.widget_info(|| {
                WidgetInfo::labeled(WidgetType::Slider, true, format!("{}, point {}", way.name, index + 1))
            });
            let grip = grip.on_hover_cursor(CursorIcon::Grab);
            let moved = Gesture::drag(&grip).zip(grip.interact_pointer_pos());
            if let Some((gesture, at)) = moved
                && let Some(world) = eye.on_level(share(rect, at), level)
            {
                let mut points = way.points;
                for (number, world) in points[2 * index..2 * index + 2].iter_mut().zip([world[0] - x, world[2] - z]) {
                    *number = (world * 100.0).round() / 100.0;
                }
                let key = format!("handle {} {index}", way.path);
                gesture.edit(Edit::set(way.path.clone(), &json!(points)).merging(key), actions);
            }
            if grip.drag_stopped() {
                actions.push(Action::Seal);
            }
            let strong = grip.hovered() || grip.dragged();
            let rim = Stroke::new(1.5, Color32::from_black_alpha(200));
            let fill = if index == 0 || index == 3 { Color32::WHITE } else { Color32::from_rgb(0x3f, 0xb5, 0xb0) };
            painter.circle(spot, if strong { 6.0 } else { 4.5 }, fill, rim);
            if strong {
                let text = format!("{}: {:.2}, {:.2}", way.name, point[0], point[1]);
                let place = spot + vec2(10.0, -10.0);
                let galley = painter.layout_no_wrap(text, FontId::proportional(12.0), Color32::WHITE);
                let back = Align2::LEFT_BOTTOM.anchor_size(place, galley.size()).expand2(vec2(4.0, 2.0));
                painter.rect_filled(back, 3.0, Color32::from_black_alpha(170));
                painter.galley(back.min + vec2(4.0, 2.0), galley, Color32::WHITE);
            }
        }
    }
}

/// Draws a path's curve, and lines to its inner control points.
fn curve(painter: &Painter, points: [[f64; 2]; 4], at: &dyn Fn([f64; 2]) -> Option<Pos2>) {
    let along = |t: f64| {
        let s = 1.0 - t;
        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        [0, 1].map(|axis| points.iter().zip(weights).map(|(point, weight)| point[axis] * weight).sum())
    };
    let spots: Vec<Option<Pos2>> = (0..=PIECES).map(|piece| at(along(piece as f64 / PIECES as f64))).collect();
    for (width, color) in [(4.0, Color32::from_black_alpha(110)), (1.8, Color32::from_rgb(0x3f, 0xb5, 0xb0))] {
        for seen in spots.split(Option::is_none).filter(|seen| seen.len() > 1) {
            painter.add(Shape::line(seen.iter().copied().flatten().collect(), Stroke::new(width, color)));
        }
    }
    for [a, b] in [[0, 1], [3, 2]] {
        if let (Some(from), Some(to)) = (at(points[a]), at(points[b])) {
            painter.line_segment([from, to], Stroke::new(1.0, Color32::from_white_alpha(110)));
        }
    }
}
