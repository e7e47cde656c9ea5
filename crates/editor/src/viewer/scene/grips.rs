//! Handles of things in the world: where they are in the picture, and what dragging them changes.

use super::eye::Eye;
use super::gizmo::{Gizmo, Slot};
use super::{Seen, draw};
use crate::actions::Action;
use crate::document::Edit;
use crate::document::group::{Written, rewritten};
use crate::field::Gesture;
use crate::state::State;
use crate::viewer::picture::{place, share};
use egui::{CursorIcon, Id, Key, Pos2, Rect, Response, Sense, Ui, Vec2, WidgetInfo, WidgetType, pos2, vec2};
use glam::DVec3;
use trochoid::CheckedGraph;

/// Distance of outer handles from the middle, in points.
pub(super) const REACH: f32 = 56.0;
/// Handles nearer than this cannot be told apart.
const APART: f32 = 12.0;
/// Place of the handle for the scale, from the middle.
const CORNER: Vec2 = vec2(40.0, 30.0);
/// A circle on the ground is too narrow to follow if its width is this share of its length.
const NARROW: f64 = 0.15;
/// Smallest scale factor, because 0 is none.
const SMALLEST: f64 = 1e-3;

/// What a handle changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Part {
    Move,
    Height,
    Turn,
    Scale,
    Direction,
}

impl Part {
    pub(super) const ALL: [Self; 5] = [Self::Turn, Self::Scale, Self::Height, Self::Move, Self::Direction];

    /// Returns its name in labels.
    fn word(self) -> &'static str {
        match self {
            Self::Move => "move",
            Self::Height => "height",
            Self::Turn => "turn",
            Self::Scale => "scale",
            Self::Direction => "direction",
        }
    }

    /// Returns what undo calls the drag.
    fn verb(self) -> &'static str {
        match self {
            Self::Move => "Move",
            Self::Height => "Raise",
            Self::Turn => "Turn",
            Self::Scale => "Scale",
            Self::Direction => "Aim",
        }
    }

    /// Returns the numbers that it changes.
    fn slots(self, gizmo: &Gizmo) -> Vec<&Slot> {
        match self {
            Self::Move => [0, 2].into_iter().filter_map(|axis| gizmo.axes[axis].as_ref()).collect(),
            Self::Height => gizmo.axes[1].iter().collect(),
            Self::Turn => gizmo.turn.iter().map(|(turn, _)| turn).collect(),
            Self::Scale => gizmo.scale.iter().collect(),
            Self::Direction => gizmo.direction.iter().collect(),
        }
    }

    /// Writes the numbers as they are shown beside the handle.
    fn told(self, gizmo: &Gizmo) -> String {
        let number = |slot: &Slot| format!("{:.2}", slot.value).replace('-', "−");
        let each: Vec<String> = self.slots(gizmo).into_iter().map(number).collect();
        match self {
            Self::Move => {
                let named = ["x", "z"].iter().zip([0, 2]);
                let named =
                    named.filter_map(|(name, axis)| Some(format!("{name} {} m", number(gizmo.axes[axis].as_ref()?))));
                named.collect::<Vec<_>>().join(", ")
            }
            Self::Height => format!("height {} m", each.join(", ")),
            Self::Turn => format!("{}°", each.join(", ")),
            Self::Scale => format!("scale {}", each.join(", ")),
            Self::Direction => each.join(", "),
        }
    }
}

/// Rounds to a step of 1, 0.1, 0.01, …, not larger than a size.
pub(super) fn neat(value: f64, size: f64) -> f64 {
    let scale = 10f64.powf((-size.max(1e-9).log10()).ceil().clamp(0.0, 9.0));
    let rounded = (value * scale).round() / scale;
    // Not -0, which documents would show.
    if rounded.is_finite() { rounded + 0.0 } else { value }
}

/// The picture on the screen, and the camera that it shows the world through.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) eye: Eye,
    pub(super) rect: Rect,
    /// What is in the middle of the picture.
    pub(super) focus: DVec3,
}

impl Window {
    /// Returns the place of a point on the screen.
    pub(super) fn spot(&self, point: DVec3) -> Option<Pos2> {
        self.eye.project(point).map(|share| place(self.rect, share))
    }

    /// Returns a length in meters that is one point long on the screen.
    pub(super) fn length(&self, point: DVec3) -> f64 {
        self.eye.width_at(point) / f64::from(self.rect.width())
    }

    /// Returns the unit vector from the camera to a point.
    fn sight(&self, point: DVec3) -> DVec3 {
        let toward = (point - self.eye.position).try_normalize().filter(|_| !self.eye.orthographic);
        toward.unwrap_or(self.eye.forward)
    }

    /// Returns the place of something infinitely far away, if it is in the picture.
    pub(super) fn far(&self, direction: DVec3) -> Option<Pos2> {
        self.eye.toward(direction).map(|share| place(self.rect, share)).filter(|spot| self.rect.contains(*spot))
    }

    /// Returns the length of arrows, in meters.
    fn arrow(&self) -> f64 {
        self.length(self.focus) * f64::from(2.0 * REACH)
    }

    /// Returns the tip of an arrow that points in a direction.
    pub(super) fn tip(&self, direction: DVec3) -> DVec3 {
        self.focus + direction.normalize_or_zero() * self.arrow()
    }
}

impl Gizmo {
    /// Returns the direction on the ground in which the handle for the rotation stands.
    fn heading(&self) -> DVec3 {
        let (turn, is_heading) = self.turn.as_ref().map_or((0.0, true), |(turn, is_heading)| (turn.value, *is_heading));
        let (sin, cos) = turn.to_radians().sin_cos();
        DVec3::new(cos, 0.0, if is_heading { sin } else { -sin })
    }

    /// Returns the place of a handle on the screen; `None` if it has none.
    pub(super) fn spot(&self, part: Part, window: &Window) -> Option<Pos2> {
        if part.slots(self).is_empty() {
            return None;
        }
        if let Some(direction) = self.toward() {
            return window.far(direction).or_else(|| window.spot(window.tip(direction)));
        }
        let middle = window.spot(self.at)?;
        let reach = window.length(self.at) * f64::from(REACH);
        let outer = |toward: DVec3| window.spot(self.at + toward * reach).filter(|spot| spot.distance(middle) >= APART);
        match part {
            Part::Move => Some(middle),
            Part::Height => outer(DVec3::Y),
            Part::Turn => outer(self.heading()),
            Part::Scale => Some(middle + CORNER),
            Part::Direction => None,
        }
    }
}

/// A handle that is being dragged.
pub(super) struct Drag {
    id: Id,
    part: Part,
    /// The thing as it was.
    gizmo: Gizmo,
    /// The camera when the drag began; the picture shows others while a camera is dragged.
    window: Window,
    /// Where the handle was, and where it is dragged to.
    spots: [Pos2; 2],
    /// Where the pointer was last.
    pointer: Pos2,
    /// The angle by which it was turned last, in degrees.
    turned: f64,
    /// The frame whose keys change.
    frame: i64,
    /// Whether the document was changed.
    writes: bool,
}

impl Drag {
    /// Returns the numbers for the present place of the handle; `None` if they cannot be found from there.
    fn values(&mut self) -> Option<Vec<f64>> {
        let Self { gizmo, window, spots: [from, to], part, .. } = &*self;
        let slots = part.slots(gizmo);
        let old = slots.iter().map(|slot| slot.value);
        let (at, to) = (share(window.rect, *to), *to);
        // As precise as the nearer of both places needs.
        let moved = |slot: &Slot, by: f64, there: DVec3| {
            neat(slot.value + by, 0.25 * window.length(gizmo.at).min(window.length(there)))
        };
        let sight = window.sight(gizmo.at);
        Some(match part {
            Part::Move => {
                let there = window.eye.on_level(at, gizmo.at.y)?;
                let by = there - gizmo.at;
                let axes = [(&gizmo.axes[0], by.x), (&gizmo.axes[2], by.z)];
                axes.into_iter().filter_map(|(slot, by)| Some(moved(slot.as_ref()?, by, there))).collect()
            }
            Part::Height => {
                // The thing itself moves as the pointer does.
                let at = share(window.rect, window.spot(gizmo.at)? + (to - *from));
                let across = sight.with_y(0.0).try_normalize()?;
                let there = window.eye.on_plane(at, (gizmo.at, across))?;
                slots.iter().map(|slot| moved(slot, there.y - gizmo.at.y, there)).collect()
            }
            Part::Turn => {
                let heading = gizmo.heading();
                let by = if sight.y.abs() < NARROW {
                    let right = f64::from((to.x - from.x) / REACH).to_degrees();
                    if sight.dot(heading) < 0.0 { -right } else { right }
                } else {
                    let now = window.eye.on_level(at, gizmo.at.y)? - gizmo.at;
                    (now.z.atan2(now.x) - heading.z.atan2(heading.x)).to_degrees()
                };
                // Goes on over a half turn.
                let by = self.turned + (by - self.turned + 180.0).rem_euclid(360.0) - 180.0;
                let is_heading = gizmo.turn.as_ref().is_some_and(|(_, is_heading)| *is_heading);
                let values =
                    slots.iter().map(|slot| neat(slot.value + if is_heading { by } else { -by }, 0.1)).collect();
                self.turned = by;
                values
            }
            Part::Scale => {
                let middle = window.spot(gizmo.at)?;
                let factor = f64::from(to.distance(middle) / from.distance(middle));
                let scaled = |old: f64| {
                    let new = neat(old * factor, old.abs() * 1e-3);
                    if new.abs() < SMALLEST { SMALLEST.copysign(old) } else { new }
                };
                old.map(scaled).collect()
            }
            Part::Direction => {
                let old = gizmo.toward()?;
                let size = if old == DVec3::ZERO { 1.0 } else { old.length() };
                let new = match window.far(old) {
                    Some(_) => window.eye.ray(at).1,
                    None => window.aimed(at, old),
                };
                (new * size).to_array().map(|part| neat(part, 1e-5 * size)).into()
            }
        })
    }

    /// Changes the document as the handle was dragged, or says why it cannot be; returns whether the drag goes on. `gizmo`
    /// is the thing as it is now.
    fn write(&mut self, gesture: Gesture, gizmo: &Gizmo, actions: &mut Vec<Action>) -> bool {
        let slots = self.part.slots(gizmo);
        // What follows a formula stays, and the rest moves.
        let is_held = slots.iter().all(|slot| slot.place.is_err());
        let follows = slots.iter().find_map(|slot| slot.place.as_ref().err());
        if let Some(why) = follows.filter(|_| is_held) {
            actions.push(Action::Notice(why.to_string()));
            return false;
        }
        if self.spots[0] == self.spots[1] {
            self.take_back(actions);
            return true;
        }
        let Some(values) = self.values() else { return true };
        let places: Vec<(&Written, f64)> = slots
            .iter()
            .zip(values)
            .filter_map(|(slot, value)| slot.place.as_ref().ok().map(|place| (place, place.limited(value))))
            .collect();
        if !std::mem::replace(&mut self.writes, true) {
            // A step of undo of its own.
            actions.push(Action::Seal);
            actions.extend(follows.map(|why| Action::Notice(why.to_string())));
        }
        let label = format!("{} {}", self.part.verb(), gizmo.title);
        let edit = Edit::new(&label, rewritten(&places, self.frame)).merging(label);
        gesture.whole(edit, actions);
        true
    }

    /// Puts back what the drag has changed.
    fn take_back(&mut self, actions: &mut Vec<Action>) {
        if std::mem::take(&mut self.writes) {
            actions.push(Action::TakeBack);
        }
    }
}

impl Window {
    /// Returns the unit direction of an arrow whose tip is dragged to a place, on the same side as before.
    fn aimed(&self, at: Pos2, old: DVec3) -> DVec3 {
        let (origin, direction) = self.eye.ray(at);
        let nearest = (self.focus - origin).dot(direction);
        let aside = origin + direction * nearest - self.focus;
        let depth = (self.arrow().powi(2) - aside.length_squared()).max(0.0).sqrt();
        let side = if old.dot(direction) < 0.0 { -depth } else { depth };
        (aside + direction * side).normalize_or(DVec3::Y)
    }
}

/// Draws the handles of the selected nodes over the picture. A dragged handle changes the document, unless drags move the
/// camera.
pub(super) fn grips_ui(
    (drag, steers): (&mut Option<Drag>, bool),
    ui: &mut Ui,
    (area, rect): (Rect, Rect),
    state: &State,
    (seen, graph, all): (&Seen, &CheckedGraph, &[Gizmo]),
    actions: &mut Vec<Action>,
) {
    let window = Window { eye: seen.eye, rect, focus: seen.focus() };
    let painter = ui.painter().with_clip_rect(area);
    draw::cameras(&painter, state, graph, seen, &window);
    for gizmo in all {
        draw::gizmo(&painter, gizmo, &window);
    }
    let mut is_there = false;
    for gizmo in all {
        // The camera itself is in the middle of its picture at most.
        if gizmo.toward().is_none() && gizmo.at.distance(seen.eye.position) < 1e-6 {
            continue;
        }
        for part in Part::ALL {
            let id = ui.id().with(("gizmo", &gizmo.title, part));
            let is_held = drag.as_ref().is_some_and(|drag| drag.id == id);
            is_there |= is_held;
            let spot = gizmo.spot(part, &window).filter(|spot| is_held || area.contains(*spot));
            // What is dragged out of sight is still held.
            let Some(spot) = spot.or_else(|| drag.as_ref().filter(|_| is_held).map(|drag| drag.spots[1])) else {
                continue;
            };
            let sense = if steers { Sense::hover() } else { Sense::drag() };
            let grip = ui.interact(Rect::from_center_size(spot, vec2(14.0, 14.0)), id, sense);
            let label = format!("{}: {}", gizmo.title, part.word());
            grip.widget_info(|| WidgetInfo::labeled(WidgetType::Slider, true, &label));
            let grip = if steers { grip } else { grip.on_hover_cursor(CursorIcon::Grab) };
            if grip.drag_started() {
                *drag = Some(Drag {
                    id,
                    part,
                    gizmo: gizmo.clone(),
                    window,
                    spots: [spot; 2],
                    pointer: ui.input(|input| input.pointer.press_origin()).unwrap_or(spot),
                    turned: 0.0,
                    frame: state.frame,
                    writes: false,
                });
            }
            held(drag, ui, (&grip, gizmo), state.frame, actions);
            let strong = grip.hovered() || grip.dragged();
            draw::grip(&painter, part, spot, strong);
            if strong {
                let linked = if part.slots(gizmo).iter().any(|slot| slot.is_linked()) { " (linked)" } else { "" };
                draw::told(&painter, spot, &format!("{}: {}{linked}", gizmo.title, part.told(gizmo)));
            }
        }
    }
    if !is_there {
        drop(drag.take_if(|_| !ui.input(|input| input.pointer.any_down())));
    }
}

/// Follows the drag of a handle.
fn held(drag: &mut Option<Drag>, ui: &Ui, (grip, gizmo): (&Response, &Gizmo), frame: i64, actions: &mut Vec<Action>) {
    let Some(now) = drag.as_mut().filter(|drag| drag.id == grip.id) else { return };
    if ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, Key::Escape)) {
        now.take_back(actions);
        *drag = None;
        return;
    }
    // A drag changes the keys of one frame.
    let is_another = frame != now.frame;
    let ends = grip.drag_stopped() || is_another;
    // The pointer may have moved in the frame in which it was pressed or let go.
    let at = grip.interact_pointer_pos().filter(|at| *at != now.pointer && !is_another);
    if let Some((gesture, at)) = Gesture::dragged(grip).zip(at) {
        let fine = ui.input(|input| input.modifiers.shift);
        now.spots[1] += (at - now.pointer) * if fine { 0.1 } else { 1.0 };
        now.pointer = at;
        if !now.write(gesture, gizmo, actions) {
            *drag = None;
            return;
        }
    }
    if ends {
        if now.writes {
            actions.push(Action::Seal);
        }
        *drag = None;
    }
}

/// Returns the corners of the picture, in fractions.
pub(super) const CORNERS: [Pos2; 4] = [pos2(0.0, 0.0), pos2(1.0, 0.0), pos2(1.0, 1.0), pos2(0.0, 1.0)];

#[cfg(test)]
mod tests {
    use super::super::eye::tests::{ASPECT, cameras};
    use super::*;
    use crate::document::group::NotWritten;
    use rand::RngExt;

    fn slot(value: f64) -> Slot {
        Slot { value, place: Err(NotWritten::Faulty) }
    }

    fn thing(at: DVec3) -> Gizmo {
        Gizmo {
            title: "thing".into(),
            at,
            of: None,
            axes: at.to_array().map(|value| Some(slot(value))),
            turn: Some((slot(20.0), false)),
            scale: vec![slot(1.0)],
            direction: Vec::new(),
        }
    }

    /// Returns what a handle becomes that is dragged to a place.
    fn dragged(gizmo: &Gizmo, window: &Window, part: Part, to: Pos2) -> Option<Gizmo> {
        let spots = [gizmo.spot(part, window)?, to];
        let id = Id::new("handle");
        let mut drag = Drag {
            id,
            part,
            gizmo: gizmo.clone(),
            window: *window,
            spots,
            pointer: to,
            turned: 0.0,
            frame: 1,
            writes: false,
        };
        let values = drag.values()?;
        let mut new = gizmo.clone();
        match part {
            Part::Move => new.at = DVec3::new(values[0], gizmo.at.y, values[1]),
            Part::Height => new.at.y = values[0],
            Part::Turn => new.turn = Some((slot(values[0]), false)),
            Part::Scale => new.scale = values.into_iter().map(slot).collect(),
            Part::Direction => new.direction = values.into_iter().map(slot).collect(),
        }
        Some(new)
    }

    /// Pictures of random cameras, 1600 points wide, each with a thing on a plane that it sees, and a place.
    fn windows() -> impl Iterator<Item = (Window, Gizmo, Pos2)> {
        let rect = Rect::from_min_size(pos2(30.0, 50.0), vec2(1600.0, 1600.0 / ASPECT as f32));
        cameras().filter_map(move |(pose, mut random)| {
            let eye = Eye::new(&pose, ASPECT);
            let mut share = || pos2(random.random_range(0.05..0.95), random.random_range(0.05..0.95));
            let at = eye.on_level(share(), 1.25).filter(|at| at.distance(pose.position) < 500.0)?;
            Some((Window { eye, rect, focus: pose.target }, thing(at), place(rect, share())))
        })
    }

    #[test]
    fn what_is_dragged_comes_under_the_pointer() {
        let (mut moved, mut raised, mut turned, mut aimed) = (0, 0, 0, 0);
        for (window, mut gizmo, to) in windows() {
            if let Some(new) = dragged(&gizmo, &window, Part::Move, to) {
                let off = window.spot(new.at).unwrap() - to;
                assert!(off.length() < 1.0, "{off:?}");
                moved += 1;
            }
            let middle = window.spot(gizmo.at).unwrap();
            // By a little, straight along its vertical as the picture shows it.
            if let Some(top) = gizmo.spot(Part::Height, &window) {
                let by = (top - middle).normalized() * 20.0;
                if let Some(new) = dragged(&gizmo, &window, Part::Height, top + by) {
                    let off = window.spot(new.at).unwrap() - middle - by;
                    assert!(off.length() < 1.0, "{off:?} {by:?} {window:?} {gizmo:?}");
                    raised += 1;
                }
            }
            let flat = window.sight(gizmo.at).y.abs() < NARROW;
            if let Some(new) = dragged(&gizmo, &window, Part::Turn, to).filter(|_| !flat) {
                let heading = window.spot(gizmo.at + new.heading() * 1e-3 * gizmo.at.distance(window.eye.position));
                let [now, wanted] = [heading.unwrap() - middle, to - middle].map(Vec2::normalized);
                assert!((now - wanted).length() < 0.05, "{now:?} {wanted:?}");
                turned += 1;
            }
            let direction = window.eye.ray(share(window.rect, middle)).1 * 3.0;
            gizmo.direction = direction.to_array().map(slot).into();
            if let Some(new) = dragged(&gizmo, &window, Part::Direction, to).filter(|_| !window.eye.orthographic) {
                let off = window.far(new.toward().unwrap()).unwrap() - to;
                assert!(off.length() < 1.0, "{off:?}");
                aimed += 1;
            }
        }
        assert!([moved, raised, turned, aimed].iter().all(|count| *count > 40), "{moved} {raised} {turned} {aimed}");
    }

    #[test]
    fn numbers_have_no_more_digits_than_they_need() {
        assert_eq!(neat(1.23456, 0.004), 1.235);
        assert_eq!(neat(-0.0001, 0.01).to_string(), "0");
        assert_eq!(neat(1234.5678, 20.0), 1235.0);
    }
}
