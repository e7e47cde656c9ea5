//! The camera by mouse: turning, moving, and coming nearer to what is seen.

use super::Seen;
use super::eye::{Eye, Lens, Pose};
use super::grips::neat;
use super::water::Water;
use super::{gizmo, pivot};
use crate::actions::Action;
use crate::document::Edit;
use crate::document::group::{NotWritten, Written, rewritten};
use crate::field::Gesture;
use crate::state::State;
use crate::viewer::picture::share;
use egui::{CursorIcon, Key, PointerButton, Pos2, Rect, Response, Ui, pos2};
use glam::DVec3;
use trochoid::{CheckedGraph, Item, Knob, NodeId};

/// What dragging does to the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
enum How {
    Orbit,
    Pan,
    Dolly,
}

impl How {
    fn label(self) -> &'static str {
        match self {
            Self::Orbit => "Orbit",
            Self::Pan => "Pan",
            Self::Dolly => "Dolly",
        }
    }
}

/// Seconds without the wheel after which the next turn of it is a step of undo of its own.
const PAUSE: f64 = 0.6;
/// Share of the distance by which a notch of the wheel comes nearer.
const NOTCH: f32 = 0.1;

/// The knobs of a camera, and the numbers that they have.
struct Held {
    pose: Pose,
    position: [Written; 3],
    target: [Written; 3],
    /// The height of the picture, if rays are parallel.
    height: Option<Written>,
}

impl Held {
    /// Finds where a camera is written.
    fn find(state: &State, graph: &CheckedGraph, id: NodeId) -> Result<Self, NotWritten> {
        let (root, node) = (state.session.sheet(), graph.node(id));
        let pose = Pose::of(graph, id, state.frame);
        let missing = || NotWritten::Missing(node.name.clone());
        let knob = |name: &str| {
            let found = node.ty.declaration().items.iter().find(|item| item.name() == name);
            found.and_then(|item| if let Item::Knob(knob) = item { Some(knob) } else { None }).ok_or_else(missing)
        };
        let vector = |name: &str, present: DVec3| -> Result<[Written; 3], NotWritten> {
            let find = |knob: &Knob, component: usize| {
                Written::find(root, &node.name, &[], knob, Some(component), &present.to_array())
            };
            let knob = knob(name)?;
            Ok([find(knob, 0)?, find(knob, 1)?, find(knob, 2)?])
        };
        let height = match pose.lens {
            Lens::Orthographic(height) => Some(Written::find(root, &node.name, &[], knob("height")?, None, &[height])?),
            Lens::Perspective(_) => None,
        };
        let (position, target) = (vector("position", pose.position)?, vector("target", pose.target)?);
        Ok(Self { pose, position, target, height })
    }

    /// Returns the edit that gives the camera another pose than it had. Numbers are as precise as the distance to a point
    /// needs.
    fn edit(&self, how: How, (before, pose): (&Pose, &Pose), distance: f64, frame: i64) -> Edit {
        let size = 1e-4 * distance.min(pose.position.distance(pose.target));
        let mut numbers: Vec<(&Written, f64)> = Vec::new();
        let vectors = [(&self.position, before.position, pose.position), (&self.target, before.target, pose.target)];
        for (places, old, new) in vectors {
            for (place, (old, new)) in places.iter().zip(old.to_array().into_iter().zip(new.to_array())) {
                // What does not move keeps all of its digits.
                let number = if (new - old).abs() < 0.5 * size { old } else { neat(new, size) };
                numbers.push((place, place.limited(number)));
            }
        }
        if let (Some(place), Lens::Orthographic(height)) = (&self.height, pose.lens) {
            let height = if before.lens == pose.lens { height } else { neat(height, 1e-4 * height) };
            numbers.push((place, place.limited(height)));
        }
        let label = format!("{} camera", how.label());
        Edit::new(&label, rewritten(&numbers, frame)).merging(label)
    }
}

/// A camera that is being dragged.
struct Move {
    how: How,
    /// The camera as it was.
    pose: Pose,
    seen: Seen,
    /// The point about which it moves.
    pivot: DVec3,
    /// Where the drag began on the screen, and where it has come to.
    from: Pos2,
    to: Pos2,
    frame: i64,
    writes: bool,
}

impl Move {
    /// Puts back what the drag has changed.
    fn take_back(&mut self, actions: &mut Vec<Action>) {
        if std::mem::take(&mut self.writes) {
            actions.push(Action::TakeBack);
        }
    }

    /// Returns the pose for a place of the pointer.
    fn pose(&self, rect: Rect, at: Pos2) -> Pose {
        let pose = &self.pose;
        // The width of the picture is a half turn, or about a tenth of the distance.
        let by = (at - self.from) / rect.width();
        match self.how {
            How::Orbit => pose.orbited(self.pivot, by),
            How::Dolly => pose.dollied(self.pivot, f64::from(2.5 * (by.y - by.x)).exp()),
            How::Pan => {
                let eye = Eye::new(pose, self.seen.aspect);
                let [from, to] = [self.from, at].map(|at| eye.beside(share(rect, at), self.pivot));
                from.zip(to).map_or(*pose, |(from, to)| pose.panned(from - to))
            }
        }
    }
}

/// The wheel, while it turns.
struct Sweep {
    pivot: DVec3,
    /// When it last turned.
    last: f64,
}

/// The camera by mouse.
#[derive(Default)]
pub(super) struct Rig {
    /// Whether drags in the picture move the camera.
    pub(super) on: bool,
    drag: Option<Move>,
    sweep: Option<Sweep>,
}

impl Rig {
    /// Ends what is going on.
    pub(super) fn forget(&mut self) {
        (self.drag, self.sweep) = (None, None);
    }

    /// Moves the camera by drags and the wheel.
    pub(super) fn ui(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        state: &State,
        seen: &Seen,
        actions: &mut Vec<Action>,
    ) {
        if response.hovered() && self.drag.is_none() {
            ui.ctx().set_cursor_icon(CursorIcon::Move);
        }
        if let Some((how, from)) = started(ui, response) {
            match held(state, seen) {
                Ok(held) => {
                    let pivot = match how {
                        How::Orbit => chosen(state, seen).unwrap_or_else(|| pivot::at(seen, &held.pose, MIDDLE)),
                        How::Pan | How::Dolly => pivot::at(seen, &held.pose, share(rect, from)),
                    };
                    let (pose, frame, seen) = (held.pose, state.frame, seen.clone());
                    self.drag = Some(Move { how, pose, seen, pivot, from, to: from, frame, writes: false });
                }
                Err(why) => actions.push(Action::Notice(why.to_string())),
            }
        }
        self.follow(ui, rect, response, state, actions);
        self.wheel(ui, rect, response, state, seen, actions);
    }

    fn follow(&mut self, ui: &Ui, rect: Rect, response: &Response, state: &State, actions: &mut Vec<Action>) {
        let Some(now) = &mut self.drag else { return };
        if ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, Key::Escape)) {
            now.take_back(actions);
            self.drag = None;
            return;
        }
        // A drag changes the keys of one frame.
        let is_another = state.frame != now.frame;
        let ends = response.drag_stopped() || !response.dragged() || is_another;
        // The pointer may have moved in the frame in which it was pressed or let go.
        let at = response.interact_pointer_pos().filter(|at| *at != now.to && !is_another);
        if let Some((gesture, at)) = Gesture::dragged(response).zip(at) {
            now.to = at;
            match held(state, &now.seen) {
                Ok(_) if at == now.from => now.take_back(actions),
                Ok(held) => {
                    let pose = now.pose(rect, at);
                    if !std::mem::replace(&mut now.writes, true) {
                        actions.push(Action::Seal);
                    }
                    let distance = pose.position.distance(now.pivot);
                    gesture.whole(held.edit(now.how, (&now.pose, &pose), distance, now.frame), actions);
                }
                // The document has changed meanwhile.
                Err(_) => {}
            }
        }
        if ends {
            if now.writes {
                actions.push(Action::Seal);
            }
            self.drag = None;
        }
    }

    fn wheel(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        state: &State,
        seen: &Seen,
        actions: &mut Vec<Action>,
    ) {
        let (scroll, pinch, now) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta(), input.time));
        let notches = scroll / ui.ctx().options(|options| options.input_options.line_scroll_speed);
        let factor = f64::from((1.0 - NOTCH).powf(notches) / pinch);
        let turned = Gesture::wheel(response, factor != 1.0).filter(|_| self.drag.is_none());
        if let (Some(gesture), Some(at)) = (turned, response.hover_pos()) {
            match held(state, seen) {
                Ok(held) => {
                    let sweep = self.sweep.get_or_insert_with(|| {
                        actions.push(Action::Seal);
                        Sweep { pivot: pivot::at(seen, &held.pose, share(rect, at)), last: now }
                    });
                    sweep.last = now;
                    let pose = held.pose.dollied(sweep.pivot, factor);
                    let distance = pose.position.distance(sweep.pivot);
                    gesture.whole(held.edit(How::Dolly, (&held.pose, &pose), distance, state.frame), actions);
                }
                Err(why) if self.sweep.is_none() => {
                    self.sweep = Some(Sweep { pivot: DVec3::ZERO, last: now });
                    actions.push(Action::Notice(why.to_string()));
                }
                Err(_) => {}
            }
        }
        if let Some(sweep) = &self.sweep {
            if now - sweep.last >= PAUSE {
                self.sweep = None;
                actions.push(Action::Seal);
            } else {
                ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(PAUSE));
            }
        }
    }
}

/// Returns what a drag that begins now does, and where it began.
fn started(ui: &Ui, response: &Response) -> Option<(How, Pos2)> {
    let modifiers = ui.input(|input| input.modifiers);
    let how = if response.drag_started_by(PointerButton::Middle) {
        How::Pan
    } else if response.drag_started_by(PointerButton::Secondary) {
        How::Dolly
    } else if !response.drag_started_by(PointerButton::Primary) {
        return None;
    } else if modifiers.shift {
        How::Pan
    } else if modifiers.command {
        How::Dolly
    } else {
        How::Orbit
    };
    let origin = ui.input(|input| input.pointer.press_origin());
    Some((how, origin.or(response.interact_pointer_pos())?))
}

/// Finds the camera of the picture in the document.
fn held(state: &State, seen: &Seen) -> Result<Held, NotWritten> {
    let graph = state.session.meaning().graph.as_deref().ok_or(NotWritten::Faulty)?;
    // The viewer may have one of its own, to show a surface.
    let id = graph.find(&seen.name).ok_or_else(|| NotWritten::Missing("a camera for this picture".into()))?;
    Held::find(state, graph, id)
}

/// The middle of the picture, about which the camera turns.
const MIDDLE: Pos2 = pos2(0.5, 0.5);

/// Returns the middle of the selected things, if it is in front of the camera.
fn chosen(state: &State, seen: &Seen) -> Option<DVec3> {
    let graph = state.session.meaning().graph.as_ref()?;
    let all = gizmo::gizmos(state, graph, &mut Water::default());
    // The camera cannot turn about itself.
    let things = all.iter().filter(|thing| thing.toward().is_none() && thing.at.distance(seen.eye.position) > 1e-6);
    let places: Vec<DVec3> = things.map(|thing| thing.at).collect();
    let middle = places.iter().sum::<DVec3>() / places.len() as f64;
    (!places.is_empty()).then_some(middle).filter(|middle| seen.eye.project(*middle).is_some())
}
