//! Gestures in the plot: keys, handles and the edges of what is picked are dragged, areas pick, the ruler scrubs.

use super::change::{Change, NewCurves, frames_of, key_count};
use super::graph::{self, Grip};
use super::view::Screen;
use super::{Curves, Picked, Spot};
use crate::actions::Action;
use crate::document::curve::{Curve, Pick, Shift};
use crate::document::keyed::Channel;
use crate::document::{Path, edit};
use egui::{Event, Modifiers, PointerButton, Pos2, Rect, Response, Stroke, StrokeKind, Ui};

/// Distance within which something is hit, in points.
const NEAR: f32 = 8.0;
/// Distance of the frame around picked keys, in points.
const AROUND: f32 = 11.0;
/// Least factor by which keys are scaled.
const LEAST: f64 = 0.01;

/// What a drag moves.
#[derive(Clone, Debug)]
enum Grab {
    /// The picked keys.
    Keys,
    /// An edge of the frame around the picked keys: of frames (axis 0) or of values, at the low or the high end.
    Edge { axis: usize, is_high: bool },
    /// The end of a handle.
    Handle(Grip),
    /// A corner of an area that picks.
    Area,
    /// The current frame.
    Frame,
    /// Nothing any more: the drag was cancelled.
    Nothing,
}

/// A drag.
#[derive(Clone, Debug)]
pub(super) struct Drag {
    grab: Grab,
    /// Where it began.
    start: Pos2,
    /// Frame and value there.
    from: [f64; 2],
    /// Curves and picks as they were.
    base: Vec<(Path, Curve)>,
    picks: Vec<Picked>,
    /// Picks that the document has had since.
    pub(super) seen: Vec<Picked>,
    /// What is picked by a click, if it becomes none.
    clicked: Option<Vec<Picked>>,
    is_moved: bool,
}

impl Curves {
    /// Handles the pointer in the plot.
    pub(super) fn gestures_ui(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        spots: &[Spot],
        change: &mut Change<'_>,
    ) {
        self.look_around(ui, response, screen);
        self.frame_ui(ui, spots);
        // What is pressed and let go counts where it happens, also if both come between two drawings, and the pointer is
        // elsewhere by then.
        let (buttons, down, latest, modifiers) = ui.input(|input| {
            let button = |event: &Event| match event {
                Event::PointerButton { pos, button: PointerButton::Primary, pressed, .. } => Some((*pos, *pressed)),
                _ => None,
            };
            let buttons: Vec<(Pos2, bool)> = input.events.iter().filter_map(button).collect();
            (buttons, input.pointer.primary_down(), input.pointer.latest_pos(), input.modifiers)
        });
        let is_here =
            |at: Pos2| response.rect.contains(at) && ui.ctx().layer_id_at(at).is_none_or(|id| id == response.layer_id);
        for (at, is_pressed) in buttons {
            if !is_pressed {
                self.drag_to(ui, response, (at, modifiers), screen, spots, change);
                self.let_go(change);
            } else if self.drag.is_none() && is_here(at) {
                self.press(at, modifiers.shift || modifiers.command, screen, spots, change);
            }
        }
        let Some(at) = latest else { return };
        self.drag_to(ui, response, (at, modifiers), screen, spots, change);
        if !down {
            self.let_go(change);
        }
        if response.double_clicked() && screen.rect.contains(at) {
            self.insert_at(at, screen, spots, change);
        }
    }

    /// Moves what is dragged to where the pointer is.
    fn drag_to(
        &mut self,
        ui: &Ui,
        response: &Response,
        (at, modifiers): (Pos2, Modifiers),
        screen: &Screen,
        spots: &[Spot],
        change: &mut Change<'_>,
    ) {
        let Some(mut drag) = self.drag.take() else { return };
        drag.is_moved |= drag.start.distance(at) > 3.0;
        if drag.is_moved || matches!(drag.grab, Grab::Frame) {
            self.pull(&mut drag, at, modifiers, screen, change);
        }
        if let (Grab::Area, true) = (&drag.grab, drag.is_moved) {
            let area = Rect::from_two_pos(drag.start, at);
            let color = ui.visuals().selection.bg_fill;
            let painter = ui.painter_at(response.rect);
            painter.rect_filled(area, 0.0, color.gamma_multiply(0.25));
            painter.rect_stroke(area, 0.0, Stroke::new(1.0, color), StrokeKind::Inside);
            let inside = spots.iter().filter(|spot| area.contains(spot.place)).flat_map(|spot| &spot.picks);
            self.picks.clone_from(&drag.picks);
            for picked in inside {
                if !self.picks.contains(picked) {
                    self.picks.push(picked.clone());
                }
            }
        }
        self.drag = Some(drag);
    }

    /// Ends a drag.
    fn let_go(&mut self, change: &mut Change<'_>) {
        let Some(drag) = self.drag.take() else { return };
        if let Some(clicked) = drag.clicked.filter(|_| !drag.is_moved) {
            self.picks = clicked;
        }
        change.actions.push(Action::Seal);
    }

    /// Pans with the middle button, and zooms with the wheel.
    fn look_around(&mut self, ui: &Ui, response: &Response, screen: &Screen) {
        if !response.contains_pointer() {
            return;
        }
        let (delta, middle, scroll, zoom, at, shift) = ui.input(|input| {
            let (pointer, scroll) = (&input.pointer, input.smooth_scroll_delta());
            (
                pointer.delta(),
                pointer.middle_down(),
                scroll,
                input.zoom_delta(),
                pointer.latest_pos(),
                input.modifiers.shift,
            )
        });
        if middle && delta != egui::Vec2::ZERO {
            self.view = Some(screen.panned(delta));
        }
        // With Shift, the system may turn the wheel sideways.
        let wheel = if scroll.y == 0.0 { scroll.x } else { scroll.y };
        let factor = f64::from((wheel * 0.004).exp() * zoom);
        if let Some(at) = at.filter(|_| factor != 1.0) {
            let values = if shift || self.is_sheet { 1.0 } else { factor };
            self.view = Some(screen.zoomed(at, [factor, values]));
        }
    }

    /// Begins a drag.
    fn press(&mut self, start: Pos2, adds: bool, screen: &Screen, spots: &[Spot], change: &mut Change<'_>) {
        let channels = change.channels;
        let mut clicked = None;
        let near = |spot: &&Spot| spot.place.distance(start);
        let hit = spots.iter().min_by(|a, b| near(a).total_cmp(&near(b))).filter(|spot| near(spot) < NEAR);
        let grab = if start.y < screen.rect.top() {
            Grab::Frame
        } else if let Some(spot) = hit {
            let is_picked = spot.picks.iter().all(|picked| self.is_picked(picked));
            match (is_picked, adds) {
                (true, true) => {
                    let rest = self.picks.iter().filter(|picked| !spot.picks.contains(picked));
                    clicked = Some(rest.cloned().collect());
                }
                (true, false) => clicked = Some(spot.picks.clone()),
                (false, true) => self.picks.extend(spot.picks.iter().cloned()),
                (false, false) => self.picks.clone_from(&spot.picks),
            }
            Grab::Keys
        } else if let Some(grip) = self.grip_at(start, screen, channels) {
            Grab::Handle(grip)
        } else if let Some((axis, is_high)) = self.edge_at(start, spots) {
            Grab::Edge { axis, is_high }
        } else {
            if !adds {
                self.picks.clear();
            }
            Grab::Area
        };
        self.drags += 1;
        let base = self.picked(channels).into_iter().map(|(channel, _)| (channel.path.clone(), channel.curve.clone()));
        let base = base.collect();
        let (picks, seen) = (self.picks.clone(), self.picks.clone());
        let from = screen.at(start);
        self.drag = Some(Drag { grab, start, from, base, picks, seen, clicked, is_moved: false });
        change.actions.push(Action::Seal);
    }

    /// Returns the handle whose end is at a place.
    fn grip_at(&self, at: Pos2, screen: &Screen, channels: &[Channel]) -> Option<Grip> {
        let grips = if self.is_sheet { Vec::new() } else { graph::grips(self, channels) };
        let near = |grip: &Grip| screen.place(grip.to[0], grip.to[1]).distance(at);
        grips.into_iter().filter(|grip| near(grip) < NEAR).min_by(|a, b| near(a).total_cmp(&near(b)))
    }

    /// Returns the frame around the picked keys, if they are at several frames.
    fn around(&self, spots: &[Spot]) -> Option<Rect> {
        let picked = spots.iter().filter(|spot| !spot.is_sum && spot.picks.iter().all(|picked| self.is_picked(picked)));
        let places: Vec<Pos2> = picked.map(|spot| spot.place).collect();
        let frames = frames_of(&self.picks.iter().map(|picked| picked.pick).collect::<Vec<_>>());
        (frames.len() > 1 && places.len() > 1).then(|| Rect::from_points(&places).expand(AROUND))
    }

    fn edge_at(&self, at: Pos2, spots: &[Spot]) -> Option<(usize, bool)> {
        let around = self.around(spots)?;
        if !around.expand(4.0).contains(at) {
            return None;
        }
        let is_near = |place: f32, edge: f32| (place - edge).abs() < 5.0;
        match () {
            () if is_near(at.x, around.left()) => Some((0, false)),
            () if is_near(at.x, around.right()) => Some((0, true)),
            () if self.is_sheet => None,
            () if is_near(at.y, around.bottom()) => Some((1, false)),
            () if is_near(at.y, around.top()) => Some((1, true)),
            () => None,
        }
    }

    /// Draws the frame around the picked keys, and says by the cursor what can be dragged.
    fn frame_ui(&self, ui: &Ui, spots: &[Spot]) {
        let Some(around) = self.around(spots) else { return };
        let stroke = Stroke::new(1.0, ui.visuals().strong_text_color().gamma_multiply(0.5));
        ui.painter().rect_stroke(around, 2.0, stroke, StrokeKind::Middle);
        let over = ui.input(|input| input.pointer.hover_pos()).filter(|_| self.drag.is_none());
        match over.and_then(|at| self.edge_at(at, spots)) {
            Some((0, _)) => ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal),
            Some(_) => ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeVertical),
            None => {}
        }
    }

    /// Moves what is dragged to a place.
    fn pull(
        &mut self,
        drag: &mut Drag,
        at: Pos2,
        modifiers: egui::Modifiers,
        screen: &Screen,
        change: &mut Change<'_>,
    ) {
        let to = screen.at(at);
        let mut by = [to[0] - drag.from[0], to[1] - drag.from[1]];
        let count = edit::count(key_count(&drag.picks), "key");
        let (label, curves) = match &drag.grab {
            Grab::Area | Grab::Nothing => return,
            Grab::Frame => {
                let frame = to[0].round() as i64;
                if frame != change.frame {
                    change.actions.push(Action::Frame(frame));
                }
                return;
            }
            Grab::Keys => {
                if modifiers.shift {
                    let moved = at - drag.start;
                    by[usize::from(moved.x.abs() >= moved.y.abs())] = 0.0;
                }
                let value = if self.is_sheet { 0.0 } else { by[1] };
                let Some((shift, curves)) = settled(drag, by[0], |frames| Some(Shift::by(frames, value))) else {
                    return;
                };
                self.follow(drag, &shift);
                (format!("Move {count}"), curves)
            }
            Grab::Edge { axis, is_high } => {
                let Some([low, high]) = extent(drag, *axis) else { return };
                let (edge, fixed) = if *is_high { (high, low) } else { (low, high) };
                let scaled = |by: f64| {
                    let mut shift = Shift::by(0.0, 0.0);
                    shift.about[*axis] = fixed;
                    shift.scale[*axis] = ((edge + by - fixed) / (edge - fixed)).max(LEAST);
                    shift.scale[*axis].is_finite().then_some(shift)
                };
                let settled = match axis {
                    0 => settled(drag, by[0], scaled),
                    _ => scaled(by[1]).and_then(|shift| Some((shift, moved(drag, &shift)?))),
                };
                let Some((shift, curves)) = settled else { return };
                self.follow(drag, &shift);
                (format!("Scale {count}"), curves)
            }
            Grab::Handle(grip) => {
                let Some((path, curve)) = drag.base.iter().find(|(path, _)| *path == grip.picked.path) else { return };
                let pick = grip.picked.pick;
                let mut end = [to[0] - pick.frame, to[1] - grip.from[1]];
                if modifiers.shift {
                    end[1] = 0.0;
                }
                let turned = curve.turned(pick, grip.side, end, modifiers.alt || grip.is_alone);
                ("Turn a handle".into(), vec![(path.clone(), Some(turned))])
            }
        };
        if let Some(edit) = change.edit(label, &curves) {
            change.actions.push(Action::Give(edit.merging(format!("curves {}", self.drags)), change.field));
        }
    }

    /// Lets the picks follow their keys.
    fn follow(&mut self, drag: &Drag, shift: &Shift) {
        let moved = |picked: &Picked| {
            let pick = Pick { frame: shift.frame(picked.pick.frame), ..picked.pick };
            Picked { pick, ..picked.clone() }
        };
        self.picks = drag.picks.iter().map(moved).collect();
    }

    /// Ends the drag, and puts back what it changed.
    pub(super) fn cancel(&mut self, change: &mut Change<'_>) {
        let Some(drag) = &mut self.drag else { return };
        let is_changed = drag.base.iter().any(|(path, curve)| {
            change.channels.iter().find(|channel| channel.path == *path).is_some_and(|channel| channel.curve != *curve)
        });
        if is_changed {
            change.actions.extend([Action::Undo, Action::Seal]);
        }
        self.picks.clone_from(&drag.picks);
        (drag.grab, drag.clicked) = (Grab::Nothing, None);
        drag.seen.clone_from(&drag.picks);
    }
}

/// Returns the curves of a drag after a shift of its picked keys.
fn moved(drag: &Drag, shift: &Shift) -> Option<NewCurves> {
    let one = |(path, curve): &(Path, Curve)| {
        let picks = drag.picks.iter().filter(|picked| picked.path == *path).map(|picked| picked.pick);
        Some((path.clone(), Some(curve.moved(&picks.collect::<Vec<_>>(), shift)?)))
    };
    drag.base.iter().map(one).collect()
}

/// Returns the shift over the most whole frames up to those asked for at which no key comes to lie on another.
fn settled(drag: &Drag, frames: f64, shift: impl Fn(f64) -> Option<Shift>) -> Option<(Shift, NewCurves)> {
    let whole = frames.round().clamp(-1e6, 1e6);
    (0..=whole.abs() as i64).rev().find_map(|most| {
        let shift = shift((most as f64).copysign(whole))?;
        Some((shift, moved(drag, &shift)?))
    })
}

/// Returns the least and the greatest frame or value of the picked keys.
fn extent(drag: &Drag, axis: usize) -> Option<[f64; 2]> {
    let number = |picked: &Picked| {
        let (_, curve) = drag.base.iter().find(|(path, _)| *path == picked.path)?;
        match axis {
            0 => Some(picked.pick.frame),
            _ => curve.keys[curve.find(picked.pick.frame)?].numbers().get(picked.pick.component).copied(),
        }
    };
    let numbers = drag.picks.iter().filter_map(number).map(|number| [number; 2]);
    numbers.reduce(|[low, high], [number, _]| [low.min(number), high.max(number)])
}
