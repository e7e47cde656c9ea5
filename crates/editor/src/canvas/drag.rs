//! Pointer gestures on the canvas, from press to release.

use super::Canvas;
use super::connect::{self, NewNodeLink};
use super::plan::{End, Plan};
use crate::actions::Action;
use crate::document::{Edit, Point, Wire, decor, edit};
use crate::state::State;
use egui::{Key, PointerButton, Pos2, Rect, Ui, Vec2, pos2, vec2};
use std::collections::{BTreeSet, HashSet};

/// The gesture in progress.
#[derive(Default)]
pub(super) enum Gesture {
    /// No gesture.
    #[default]
    Idle,
    /// The view is being panned with this button.
    Pan(PointerButton),
    /// A selection rectangle is being drawn from this corner; nodes in it are added to the given names.
    Area(Pos2, BTreeSet<String>),
    /// Nodes are being moved.
    Move(Move),
    /// A wire is being connected.
    Pull(Pull),
    /// A dot is being moved: the wire, the index of the dot, and the places of all its dots.
    Dot(usize, usize, Vec<Pos2>),
    /// A backdrop is being moved or resized.
    Backdrop(Hold),
    /// An output's mark is being dragged to another node.
    Output(String),
}

/// Nodes being moved.
pub(super) struct Move {
    /// The moved nodes.
    nodes: BTreeSet<usize>,
    /// The node under the pointer.
    grabbed: usize,
    /// Place on the canvas where the drag began.
    start: Pos2,
    by: Vec2,
    shake: Shake,
    /// The wire into which the node is inserted if it is released here.
    pub(super) into: Option<usize>,
    /// Guide lines along which the node is aligned with others.
    pub(super) guides: Vec<[Pos2; 2]>,
}

impl Move {
    pub(super) fn new(nodes: BTreeSet<usize>, grabbed: usize, start: Pos2) -> Self {
        let shake = Shake::default();
        Self { nodes, grabbed, start, by: Vec2::ZERO, shake, into: None, guides: Vec::new() }
    }
}

/// Detector of a shake: quick reversals of the pointer's direction.
#[derive(Default)]
struct Shake {
    turned: Option<Pos2>,
    direction: f32,
    turns: Vec<f64>,
}

impl Shake {
    /// Returns whether the pointer reversed its direction three times within 0.9 seconds.
    fn feel(&mut self, at: Pos2, now: f64, least: f32) -> bool {
        let went = at.x - self.turned.get_or_insert(at).x;
        if went * self.direction >= 0.0 {
            // Still moving in the same direction.
            if went != 0.0 && self.direction == 0.0 {
                self.direction = went.signum();
            }
            self.turned = Some(at);
        } else if went.abs() > least {
            self.direction = -self.direction;
            self.turned = Some(at);
            self.turns.push(now);
        }
        self.turns.retain(|then| now - then < 0.9);
        let shaken = self.turns.len() >= 3;
        if shaken {
            self.turns.clear();
        }
        shaken
    }
}

/// A wire being connected.
pub(super) struct Pull {
    /// The fixed end.
    pub(super) held: End,
    /// The pin from which the wire was taken.
    pub(super) old: Option<(usize, usize)>,
    /// Nodes to which the wire would close a cycle.
    pub(super) barred: HashSet<usize>,
    /// The end to which the wire would connect.
    pub(super) target: Option<End>,
    /// The output whose mark would take the wire.
    pub(super) mark: Option<String>,
    /// Whether the wire follows the pointer without a pressed button, until the next click.
    pub(super) sticky: bool,
    /// Place on the screen where the gesture began.
    began: Pos2,
}

/// A backdrop being moved or resized.
pub(super) struct Hold {
    /// Its name.
    pub(super) name: String,
    /// Whether it is resized by its corner.
    pub(super) corner: bool,
    /// Place on the canvas where the drag began.
    pub(super) start: Pos2,
    pub(super) by: Vec2,
    /// Nodes that move along.
    pub(super) nodes: BTreeSet<usize>,
}

/// State of the pointer in this frame.
struct Pointer {
    /// Position on the screen.
    at: Pos2,
    down: bool,
    clicked: bool,
    ctrl: bool,
    now: f64,
}

impl Canvas {
    /// Starts a wire at one of its ends; a wire that is already connected to a pin is taken off it.
    pub(super) fn pull(&mut self, plan: &Plan, at: End, began: Pos2, sticky: bool) {
        let wire = match at {
            End::Pin(node, pin) => plan.wire_at((node, pin)).map(|wire| plan.sheet.wires[wire]),
            End::Output(..) => None,
        };
        match wire {
            Some(Wire { from, to }) => self.hold(plan, End::Output(from.0, from.1), Some(to), began),
            None => self.hold(plan, at, None, began),
        }
        if let Gesture::Pull(pull) = &mut self.gesture {
            pull.sticky = sticky;
        }
    }

    fn hold(&mut self, plan: &Plan, held: End, old: Option<(usize, usize)>, began: Pos2) {
        let barred = connect::barred(&plan.sheet, held);
        self.gesture = Gesture::Pull(Pull { held, old, barred, target: None, mark: None, sticky: false, began });
    }

    /// Starts the gesture for a press on the empty canvas or on a wire.
    pub(super) fn begin(&mut self, plan: &Plan, ui: &Ui, state: &State, wire: Option<usize>) {
        let (origin, modifiers) = ui.input(|input| (input.pointer.press_origin(), input.modifiers));
        let Some(origin) = origin else { return };
        let at = self.view.canvas(origin);
        self.gesture = match wire {
            Some(wire) if modifiers.command => {
                let (index, dots) = with_dot(plan, wire, at);
                Gesture::Dot(wire, index, dots)
            }
            Some(wire) => {
                let Wire { from, to } = plan.sheet.wires[wire];
                let ends = [End::Output(from.0, from.1), End::Pin(to.0, to.1)];
                let upper = plan.end(ends[0]).distance(at) < plan.end(ends[1]).distance(at);
                // The end farther from the press stays.
                return self.hold(plan, ends[usize::from(upper)], Some(to), origin);
            }
            None => {
                let keeps = modifiers.shift || modifiers.command;
                Gesture::Area(at, if keeps { state.selection.clone() } else { BTreeSet::new() })
            }
        };
    }

    /// Continues the gesture, and ends it on release.
    pub(super) fn advance(&mut self, plan: &mut Plan, ui: &Ui, state: &State, actions: &mut Vec<Action>) {
        let pointer = ui.input(|input| {
            Some(Pointer {
                at: input.pointer.latest_pos()?,
                down: input.pointer.any_down(),
                clicked: input.pointer.primary_clicked(),
                ctrl: input.modifiers.command,
                now: input.time,
            })
        });
        let escape = ui.input(|input| input.key_pressed(Key::Escape));
        // A wire that waits for a click needs no pointer: pins can also be clicked by keyboard and screen reader.
        let waits = matches!(&self.gesture, Gesture::Pull(pull) if pull.sticky);
        self.has_plugged = false;
        let Some(pointer) = pointer.filter(|_| !escape) else {
            if escape || !waits {
                self.drop_gesture(plan);
            }
            return;
        };
        let at = self.view.canvas(pointer.at);
        match std::mem::take(&mut self.gesture) {
            Gesture::Idle => {
                // Undoes the displayed shift: the document may have rejected the move.
                plan.shift(&BTreeSet::new(), Vec2::ZERO);
            }
            Gesture::Pan(button) => {
                self.view.pan += ui.input(|input| input.pointer.delta());
                if ui.input(|input| input.pointer.button_down(button)) {
                    self.gesture = Gesture::Pan(button);
                }
            }
            Gesture::Area(from, base) => {
                if pointer.down {
                    self.gesture = Gesture::Area(from, base);
                } else {
                    let area = Rect::from_two_pos(from, at);
                    let inside = plan.boxes.iter().enumerate().filter(|(_, own)| area.intersects(**own));
                    let names = inside.map(|(node, _)| plan.sheet.nodes[node].name.clone());
                    actions.push(Action::Select(base.into_iter().chain(names).collect()));
                }
            }
            Gesture::Move(held) => self.move_on(plan, held, &pointer, at, actions),
            Gesture::Pull(pull) => self.pull_on(plan, pull, &pointer, state, actions),
            Gesture::Dot(wire, index, mut dots) => {
                if let Some(dot) = dots.get_mut(index) {
                    *dot = at;
                }
                plan.bend(wire, &dots);
                if pointer.down {
                    self.gesture = Gesture::Dot(wire, index, dots);
                } else {
                    let dots: Vec<Point> = dots.into_iter().map(Into::into).collect();
                    actions.push(Action::Edit(decor::dotted(&plan.sheet, plan.sheet.wires[wire].to, &dots)));
                    actions.push(Action::Seal);
                }
            }
            Gesture::Output(name) => {
                if pointer.down {
                    self.gesture = Gesture::Output(name);
                } else if let Some(from) = self.source_at(plan, pointer.at) {
                    Self::redirect(plan, &name, from, actions);
                }
            }
            Gesture::Backdrop(mut hold) => {
                hold.by = at - hold.start;
                if !hold.corner {
                    plan.shift(&hold.nodes, hold.by);
                }
                if pointer.down {
                    self.gesture = Gesture::Backdrop(hold);
                } else {
                    actions.extend(put_down(plan, &hold));
                }
            }
        }
    }

    /// Cancels the gesture and restores what is displayed.
    pub(super) fn drop_gesture(&mut self, plan: &mut Plan) {
        if let Gesture::Dot(wire, ..) = self.gesture {
            let to = plan.sheet.wires[wire].to;
            let dots: Vec<Pos2> = decor::dots(&plan.sheet, to).into_iter().map(|[x, y]| pos2(x, y)).collect();
            plan.bend(wire, &dots);
        }
        self.gesture = Gesture::Idle;
        plan.shift(&BTreeSet::new(), Vec2::ZERO);
    }

    fn move_on(&mut self, plan: &mut Plan, mut held: Move, pointer: &Pointer, at: Pos2, actions: &mut Vec<Action>) {
        held.by = at - held.start;
        plan.shift(&held.nodes, held.by);
        held.guides.clear();
        if !pointer.ctrl {
            let by = held.by + snap(plan, &held, 5.0 / self.view.zoom, &mut Vec::new());
            plan.shift(&held.nodes, by);
            held.by = by;
            let mut guides = Vec::new();
            snap(plan, &held, 0.01, &mut guides);
            held.guides = guides;
        }
        held.into = wire_under(plan, &held);
        if pointer.down && held.shake.feel(pointer.at, pointer.now, 10.0) {
            let names: Vec<String> = held.nodes.iter().map(|node| plan.sheet.nodes[*node].name.clone()).collect();
            let edit = edit::extracted(&plan.sheet, &names);
            if !edit.ops.is_empty() {
                // Merges with the move that follows into one undo step.
                actions.push(Action::Edit(plan.freezing(edit).merging("shake")));
                held.shake = Shake::default();
            }
        }
        if pointer.down {
            self.gesture = Gesture::Move(held);
            return;
        }
        if held.by.length() * self.view.zoom > 0.5 {
            let places: Vec<(String, Point)> =
                held.nodes.iter().map(|node| (plan.sheet.nodes[*node].name.clone(), plan.corner(*node))).collect();
            let mut edit = edit::moved(&places);
            if let Some(into) =
                held.into.and_then(|wire| edit::inserted(&plan.sheet, held.grabbed, &plan.sheet.wires[wire]))
            {
                edit = Edit { label: into.label.clone(), ..edit.then(into) };
            }
            actions.push(Action::Edit(plan.freezing(edit).merging("shake")));
        }
        actions.push(Action::Seal);
    }

    fn pull_on(&mut self, plan: &Plan, mut pull: Pull, pointer: &Pointer, state: &State, actions: &mut Vec<Action>) {
        let at = self.view.canvas(pointer.at);
        let near = plan.end_at(at, 11.0 / self.view.zoom.min(1.5));
        let marked = matches!(pull.held, End::Output(..)) && !matches!(near, Some(End::Pin(..)));
        pull.mark = self.mark_at(pointer.at).filter(|_| marked).cloned();
        pull.target = self.target(plan, &pull, at).filter(|_| pull.mark.is_none());
        let over = if pull.sticky { pointer.clicked } else { !pointer.down };
        if !over {
            self.gesture = Gesture::Pull(pull);
            return;
        }
        self.has_plugged = pull.sticky;
        if let (Some(name), End::Output(node, output)) = (&pull.mark, pull.held) {
            return Self::redirect(plan, name, (node, output), actions);
        }
        match (pull.target, pull.old) {
            (Some(target), old) => self.plug(plan, state, pull.held, target, old, pointer.at, actions),
            (None, Some(old)) => {
                actions.push(Action::Edit(plan.freezing(edit::disconnected(&plan.sheet, old))));
                actions.push(Action::Seal);
            }
            (None, None) if pull.began.distance(pointer.at) > 20.0 => {
                let node = plan.sheet.nodes[pull.held.node()].name.clone();
                let wanted = match pull.held {
                    End::Output(_, output) => NewNodeLink::Takes(node, output),
                    End::Pin(_, pin) => NewNodeLink::Feeds(node, pin),
                };
                self.open_search(pointer.at, wanted);
            }
            (None, None) => {}
        }
    }

    /// Returns the end to which the wire would connect.
    fn target(&self, plan: &Plan, pull: &Pull, at: Pos2) -> Option<End> {
        let other =
            |end: &End| matches!((pull.held, end), (End::Output(..), End::Pin(..)) | (End::Pin(..), End::Output(..)));
        let near = plan.end_at(at, 11.0 / self.view.zoom.min(1.5)).filter(other);
        near.or_else(|| {
            let node = plan.node_at(at).filter(|node| *node != pull.held.node())?;
            connect::best_end(&plan.sheet, pull.held, node, &pull.barred)
        })
    }

    /// Connects two ends, or shows why that is not possible.
    #[expect(clippy::too_many_arguments, reason = "both ends and their context are needed")]
    pub(super) fn plug(
        &mut self,
        plan: &Plan,
        state: &State,
        held: End,
        target: End,
        old: Option<(usize, usize)>,
        at: Pos2,
        actions: &mut Vec<Action>,
    ) {
        let (from, to) = match (held, target) {
            (End::Output(node, output), End::Pin(below, pin)) | (End::Pin(below, pin), End::Output(node, output)) => {
                ((node, output), (below, pin))
            }
            _ => return,
        };
        if plan.sheet.wires.contains(&Wire { from, to }) {
            return;
        }
        let ends = [plan.end(End::Output(from.0, from.1)), plan.end(End::Pin(to.0, to.1))];
        let middle = ends[0].lerp(ends[1], 0.5) - vec2(60.0, 45.0);
        match connect::connect(state, from, to, old, middle.into()) {
            Ok(edit) => actions.extend([Action::Edit(plan.freezing(edit)), Action::Seal]),
            Err(refusal) => self.refusal = Some((*refusal, at)),
        }
    }
}

/// Adds a dot to those of a wire; returns its index and all dots.
pub(super) fn with_dot(plan: &Plan, wire: usize, at: Pos2) -> (usize, Vec<Pos2>) {
    let mut dots = plan.dots[wire].clone();
    let Wire { from, to } = plan.sheet.wires[wire];
    let ends = [plan.end(End::Output(from.0, from.1)), plan.end(End::Pin(to.0, to.1))];
    let points: Vec<Pos2> = std::iter::once(ends[0]).chain(dots.iter().copied()).chain([ends[1]]).collect();
    let detour = |two: &[Pos2]| two[0].distance(at) + at.distance(two[1]) - two[0].distance(two[1]);
    let nearest = points.windows(2).enumerate().min_by(|a, b| detour(a.1).total_cmp(&detour(b.1)));
    let index = nearest.map_or(0, |(index, _)| index);
    dots.insert(index, at);
    (index, dots)
}

/// Returns the offset that aligns the grabbed node with a nearby one, and adds the guide lines.
fn snap(plan: &Plan, held: &Move, reach: f32, guides: &mut Vec<[Pos2; 2]>) -> Vec2 {
    let own = plan.boxes[held.grabbed];
    let mut best = [None::<(f32, usize)>; 2];
    for (node, other) in plan.boxes.iter().enumerate().filter(|(node, _)| !held.nodes.contains(node)) {
        let off = other.center() - own.center();
        // Nodes in a row share their top edge.
        let off = [off.x, other.top() - own.top()];
        let far = [(other.center().y - own.center().y).abs(), off[0].abs()];
        for axis in 0..2 {
            let nearer = best[axis].is_none_or(|(least, _)| off[axis].abs() < least.abs());
            if off[axis].abs() <= reach && far[axis] < 700.0 && nearer {
                best[axis] = Some((off[axis], node));
            }
        }
    }
    if let Some((_, node)) = best[0] {
        let both = own.union(plan.boxes[node]);
        guides.push([pos2(own.center().x, both.top()), pos2(own.center().x, both.bottom())]);
    }
    if let Some((_, node)) = best[1] {
        let both = own.union(plan.boxes[node]);
        guides.push([pos2(both.left(), own.top()), pos2(both.right(), own.top())]);
    }
    vec2(best[0].map_or(0.0, |(off, _)| off), best[1].map_or(0.0, |(off, _)| off))
}

/// Returns the wire into which an unconnected node would be inserted.
fn wire_under(plan: &Plan, held: &Move) -> Option<usize> {
    let node = held.grabbed;
    let joined = |wire: &Wire| wire.from.0 == node || wire.to.0 == node;
    if held.nodes.len() != 1 || plan.sheet.wires.iter().any(joined) {
        return None;
    }
    let area = plan.boxes[node];
    let wire = plan.nearest_wire(area.center(), area.size().min_elem() / 2.0)?;
    edit::inserted(&plan.sheet, node, &plan.sheet.wires[wire])?;
    Some(wire)
}

/// Returns the actions for a released backdrop.
fn put_down(plan: &Plan, hold: &Hold) -> Vec<Action> {
    let Some(body) = plan.sheet.backdrops.get(&hold.name).filter(|_| hold.by != vec2(0.0, 0.0)) else {
        return Vec::new();
    };
    let body = super::backdrop::held(body, hold);
    let label = if hold.corner { "Resize a backdrop" } else { "Move a backdrop" };
    let mut edit = decor::reframed(label, &plan.sheet, &hold.name, &body);
    if !hold.corner && !hold.nodes.is_empty() {
        let places: Vec<(String, Point)> =
            hold.nodes.iter().map(|node| (plan.sheet.nodes[*node].name.clone(), plan.corner(*node))).collect();
        edit = plan.freezing(edit.then(edit::moved(&places)));
    }
    vec![Action::Edit(edit), Action::Seal]
}
