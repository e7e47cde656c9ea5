//! Handles in the picture for the Bézier paths of a sea: bursts, guides, and bodies.

use super::picture::{place, share};
use super::scene::{Eye, Pose};
use crate::actions::Action;
use crate::document::{Edit, Path};
use crate::evaluate::Result;
use crate::field::Gesture;
use crate::state::State;
use egui::{
    Align2, Color32, CursorIcon, FontId, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, WidgetInfo, WidgetType, vec2,
};
use glam::DVec3;
use serde_json::{Value, json};
use trochoid::{CheckedNode, Dynamics, NodeId, Paths, Role, Source};

/// Maximum number of paths drawn per list.
const PATHS: usize = 64;
/// Number of segments of a drawn curve.
const PIECES: usize = 48;

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
    let format = graph.format();
    let aspect = f64::from(format.width()) / f64::from(format.height());
    let eye = |camera: NodeId| Eye::new(&Pose::of(graph, camera, result.frame), aspect);
    let Some(eye) = camera(result, sea).map(eye) else { return };
    let [x, level, z] = paths.origin;
    let at =
        |point: [f64; 2]| eye.project(DVec3::new(x + point[0], level, z + point[1])).map(|share| place(rect, share));
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
                for (number, world) in points[2 * index..2 * index + 2].iter_mut().zip([world.x - x, world.z - z]) {
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
