//! The world in the picture: the camera by mouse, and handles of what stands in the scene.

mod draw;
mod eye;
mod gizmo;
mod grips;
mod pivot;
mod rig;
#[cfg(test)]
mod tests;
mod water;

use crate::actions::Action;
use crate::evaluate::{Lens, Result};
use crate::state::State;
use egui::{Color32, Rect, Response, Stroke, StrokeKind, Ui};
pub(super) use eye::{Eye, Pose};
use glam::DVec3;
use std::sync::Arc;
use trochoid::{CheckedGraph, NodeId, Role, Source};

/// Color of the frame around a picture whose camera the mouse moves.
const FRAME: Color32 = Color32::from_rgb(0xe8, 0xb0, 0x4a);

/// What the mouse does in this mode, for the bar below the picture.
pub(super) const HELP: &str = "Drag to orbit, with Shift to pan, with Ctrl or by the wheel to dolly. Esc leaves.";

/// The camera through which a picture is seen.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    /// Its name in the expanded document.
    name: String,
    pose: Pose,
    eye: Eye,
    /// Width of the picture divided by its height.
    aspect: f64,
    /// Height of the sea at rest, if there is one.
    level: Option<f64>,
    /// Where surfaces stand, as far as knobs place them.
    things: Vec<DVec3>,
}

impl Seen {
    /// Finds the camera of a picture.
    fn of(result: &Result) -> Option<Self> {
        let (graph, frame) = (&result.lens.graph, result.frame);
        let shown = graph.outputs().first()?.node;
        let reached = graph.dependencies([shown], frame);
        let all = || (0..reached.len()).filter(|index| reached[*index]).map(NodeId);
        let views = [Role::Render, Role::Passes].into_iter().flat_map(|role| all().map(move |view| (view, role)));
        let (view, camera) = views.filter(|(view, role)| has_role(graph, *view, *role)).find_map(|(view, _)| {
            let settled = graph.settle(view, frame);
            let camera = settled.sources().into_iter().find_map(|source| match source {
                Source::Output { node, .. } if has_role(graph, *node, Role::Camera) => Some(*node),
                _ => None,
            })?;
            Some((view, camera))
        })?;
        let format = graph.format();
        let aspect = f64::from(format.width()) / f64::from(format.height());
        let pose = Pose::of(graph, camera, frame);
        Some(Self {
            name: graph.node(camera).name.clone(),
            pose,
            eye: Eye::new(&pose, aspect),
            aspect,
            level: water::level(graph, view, frame),
            things: pivot::things(graph, view, frame),
        })
    }

    /// Returns the point in the middle of the picture, as far away as the target.
    fn focus(&self) -> DVec3 {
        self.pose.position + self.pose.forward() * self.pose.position.distance(self.pose.target).max(1e-3)
    }
}

fn has_role(graph: &CheckedGraph, node: NodeId, role: Role) -> bool {
    graph.node(node).ty.declaration().role == Some(role)
}

/// The state of what is done to the world in the picture.
#[derive(Default)]
pub(super) struct Scene {
    rig: rig::Rig,
    drag: Option<grips::Drag>,
    water: water::Water,
    /// The camera of the last picture, with the graph and the frame that it is of.
    seen: Option<(Arc<Lens>, i64, Option<Seen>)>,
}

impl Scene {
    /// Ends what is going on, before another document.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Whether drags in the picture move the camera.
    pub(super) fn steers(&self) -> bool {
        self.rig.on
    }

    /// Lets drags in the picture move the camera, or no longer.
    pub(super) fn steer_by(&mut self, on: bool) {
        self.rig.on = on;
        self.rig.forget();
    }

    /// Returns the camera of a picture.
    fn seen(&mut self, result: &Result) -> Option<&Seen> {
        let is_known = |(lens, frame, _): &(Arc<Lens>, i64, Option<Seen>)| {
            Arc::ptr_eq(lens, &result.lens) && *frame == result.frame
        };
        if !self.seen.as_ref().is_some_and(is_known) {
            self.seen = Some((result.lens.clone(), result.frame, Seen::of(result)));
        }
        self.seen.as_ref().and_then(|(.., seen)| seen.as_ref())
    }

    /// Lets the mouse move the camera of the picture.
    pub(super) fn steer(
        &mut self,
        ui: &mut Ui,
        (area, rect): (Rect, Rect),
        response: &Response,
        state: &State,
        result: &Result,
        actions: &mut Vec<Action>,
    ) {
        let Some(seen) = self.seen(result).cloned() else {
            self.rig.on = false;
            let why = "What is viewed has no camera: view a picture of a scene, then choose Orbit";
            actions.push(Action::Notice(why.into()));
            return;
        };
        self.rig.ui(ui, rect, response, state, &seen, actions);
        let painter = ui.painter().with_clip_rect(area);
        painter.rect_stroke(area.intersect(rect.expand(2.0)), 0.0, Stroke::new(2.0, FRAME), StrokeKind::Inside);
    }

    /// Draws the handles of the selected nodes.
    pub(super) fn handles_ui(
        &mut self,
        ui: &mut Ui,
        areas: (Rect, Rect),
        state: &State,
        result: &Result,
        actions: &mut Vec<Action>,
    ) {
        let Some(graph) = state.session.meaning().graph.clone().filter(|_| !state.selection.is_empty()) else {
            self.drag = None;
            return;
        };
        let Some(seen) = self.seen(result).cloned() else { return };
        let all = gizmo::gizmos(state, &graph, &mut self.water);
        grips::grips_ui((&mut self.drag, self.rig.on), ui, areas, state, (&seen, &graph, &all), actions);
    }
}
