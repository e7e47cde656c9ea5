//! The graph panel: nodes, wires, and direct manipulation of them.
//!
//! The drawing depends only on the document (`plan`) and the viewport (`view`). The pointer performs one gesture at a
//! time (`drag`); the document changes only when a gesture ends.

mod backdrop;
mod connect;
mod curve;
mod drag;
mod follow;
mod mark;
mod menu;
mod minimap;
mod node;
mod path;
mod picture;
mod pin;
mod place;
mod plan;
mod popup;
mod presets;
mod route;
mod search;
#[cfg(test)]
mod tests;
mod view;
mod wire;

use crate::actions::{Action, Line};
use crate::document::{Edit, Point, Sheet, edit};
use crate::presets::Presets;
use crate::state::State;
use drag::Gesture;
use egui::{Align2, Color32, Event, FontId, Key, Modifiers, MouseWheelUnit, PointerButton, Rect, Response, Sense};
use egui::{Stroke, StrokeKind, Ui, UiBuilder, WidgetInfo, WidgetType, pos2, vec2};
use plan::Plan;
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// State of the graph panel that no other panel shares.
#[derive(Default)]
pub struct Canvas {
    view: view::View,
    plan: Option<Plan>,
    laid: place::GraphLayout,
    pictures: picture::Pictures,
    gesture: Gesture,
    /// The pin that was clicked, unless the click ended a gesture.
    clicked: Option<plan::End>,
    has_plugged: bool,
    /// Whether there was no gesture and nothing was open when the frame began.
    was_idle: bool,
    search: Option<search::Search>,
    /// Reason why the last wire was refused, and where it would have gone.
    refusal: Option<(connect::Refusal, egui::Pos2)>,
    menu: Option<menu::Menu>,
    writing: Option<backdrop::TextDraft>,
    wants_frame: bool,
    /// Backdrop to frame on the next draw.
    wants_backdrop: Option<String>,
    wants_search: bool,
    wants_replacement: bool,
    presets: Arc<Presets>,
    /// Type of a node to add on the next draw.
    wants_type: Option<String>,
    /// Whether the next paste was requested from a menu, so it applies wherever the pointer is.
    wants_paste: bool,
    /// Screen area of each output's mark.
    marks: Vec<(String, Rect)>,
    /// Number of menus opened so far; part of each menu's id, so that each gets a size of its own.
    menus: u64,
    /// Views of the document and of uses that were left, by the path of the use.
    views: HashMap<String, view::View>,
    /// Whether scrolling pans (touchpad) instead of zooming (mouse wheel).
    wheel_moves: bool,
}

impl Canvas {
    /// Cancels everything that refers to items under the pointer, because those may be gone.
    pub fn forget_cursor(&mut self) {
        self.gesture = Gesture::Idle;
        self.menu = None;
        self.refusal = None;
        self.clicked = None;
    }

    /// Frames the selected nodes, or all nodes, on the next draw.
    pub fn frame(&mut self) {
        self.wants_frame = true;
    }

    /// Frames a backdrop on the next draw.
    pub fn frame_backdrop(&mut self, name: String) {
        self.wants_backdrop = Some(name);
    }

    /// Opens the search for a node to add on the next draw.
    pub fn search(&mut self) {
        self.wants_search = true;
    }

    /// Offers presets with the types of nodes, and in the menus of nodes.
    pub(crate) fn offer_presets(&mut self, presets: Arc<Presets>) {
        self.presets = presets;
    }

    /// Adds a node of a type on the next draw, connected to the selected one.
    pub fn add_type(&mut self, name: String) {
        self.wants_type = Some(name);
    }

    /// Opens the search for a replacement of the selected node on the next draw.
    pub fn replace(&mut self) {
        self.wants_replacement = true;
    }

    /// Accepts the next paste, wherever the pointer is.
    pub fn await_paste(&mut self) {
        self.wants_paste = true;
    }

    /// Closes the node search, because another prompt opens.
    pub fn close_search(&mut self) {
        self.search = None;
    }

    /// Starts editing the text of a new backdrop.
    pub fn write_on(&mut self, name: String, text: &str) {
        self.write(backdrop::Subject::Backdrop(name), text, true);
    }

    /// Adds a note in the middle of the viewport; returns the edit, its name, and its initial text.
    pub fn note(&self, sheet: &Sheet) -> (Edit, String, &'static str) {
        let (edit, name) = backdrop::note(sheet, self.view.canvas(self.view.rect.center()));
        (edit, name, backdrop::NOTE)
    }

    /// Returns a free place for a new node near a place on the screen; if that is not in the panel, in its middle.
    pub fn free_place(&self, sheet: &Sheet, at: Option<egui::Pos2>) -> Point {
        let at = at.filter(|at| self.view.rect.contains(*at)).unwrap_or(self.view.rect.center());
        let size = vec2(place::WIDTH, place::HEAD + place::PICTURE);
        let own = Rect::from_center_size(self.view.canvas(at), size);
        place::nearest(own, &place::boxes(sheet, &mut place::GraphLayout::default())).min.into()
    }

    /// Adds a dot in the middle of a node's first outgoing wire, or otherwise its first incoming wire.
    pub fn dotted(&self, name: &str) -> Option<Edit> {
        let plan = self.plan.as_ref()?;
        let node = plan.sheet.find(name)?;
        let mut wires = plan.sheet.wires.iter();
        let below = wires.position(|wire| wire.from.0 == node);
        let wire = below.or_else(|| plan.sheet.wires.iter().position(|wire| wire.to.0 == node))?;
        let (_, dots) = drag::with_dot(plan, wire, plan.curves[wire].middle());
        let dots: Vec<Point> = dots.into_iter().map(Into::into).collect();
        Some(crate::document::decor::dotted(&plan.sheet, plan.sheet.wires[wire].to, &dots))
    }

    /// Returns whether tooltips are shown: no popup is open and no gesture is in progress.
    fn explains(&self) -> bool {
        let speaks = self.search.is_some() || self.refusal.is_some() || self.menu.is_some();
        !speaks && matches!(self.gesture, Gesture::Idle)
    }

    /// Updates the viewport and the plan, and opens what was requested for this frame.
    fn prepare(&mut self, ui: &Ui, state: &State, rect: Rect) -> Plan {
        let old = self.plan.take();
        let mut plan = match old {
            Some(plan) if Arc::ptr_eq(&plan.sheet, state.sheet()) => plan,
            old => {
                let plan = Plan::new(state, &mut self.laid);
                if let Some(old) = &old {
                    self.turn(&old.sheet.prefix(), &plan.sheet.prefix());
                }
                let names =
                    |plan: &Plan| plan.sheet.nodes.iter().map(|node| node.name.clone()).collect::<Vec<String>>();
                // A moved node may lose its wires during the drag and must stay grabbed.
                let same = old.is_some_and(|old| names(&old) == names(&plan));
                if !(same && matches!(self.gesture, Gesture::Move(_) | Gesture::Pan(_))) {
                    self.forget_cursor();
                }
                plan
            }
        };
        plan.hear(state);
        self.pictures.tidy(state);
        // As long as nobody has moved the view, the graph is fitted into a panel that gets another size.
        let fits_again = self.view.rect != rect && rect.is_positive() && self.view.is_untouched();
        self.view.set_rect(rect);
        if let Some(area) = plan.area(&BTreeSet::new()).filter(|_| fits_again) {
            let looked = state.look.node.as_ref().and_then(|(name, _)| plan.sheet.find(state.own_name(name)?));
            self.view.open(area, looked.map_or(area.center(), |node| plan.boxes[node].center()));
        }
        let framed = std::mem::take(&mut self.wants_frame).then(|| plan.area(&state.selection)).flatten();
        let backdrop = self.wants_backdrop.take().and_then(|name| plan.sheet.backdrops.get(&name).map(backdrop::area));
        if let Some(area) = backdrop.or(framed) {
            self.view.show(area, 0.0);
            if self.map_place(&plan).is_some_and(|map| map.intersects(self.view.area(area))) {
                self.view.show(area, minimap::STRIP);
            }
        }
        if std::mem::take(&mut self.wants_search) {
            let at = ui.input(|input| input.pointer.hover_pos()).filter(|at| rect.contains(*at));
            self.open_search(at.unwrap_or(rect.center()), connect::NewNodeLink::Nothing);
        }
        let replaced = std::mem::take(&mut self.wants_replacement).then(|| state.chosen()).flatten();
        if let Some(node) = replaced.and_then(|name| plan.sheet.find(name)) {
            let at = self.view.area(plan.boxes[node]).left_bottom();
            self.search = Some(search::Search::replacing(&plan.sheet.nodes[node].name, at));
        }
        plan
    }

    /// Keeps the view of the sheet that is left, and takes that of the other one if it was shown before.
    fn turn(&mut self, from: &str, to: &str) {
        if from == to {
            return;
        }
        self.forget_cursor();
        (self.search, self.writing) = (None, None);
        // With the area that it had: the panel of a group is lower, and the view must not creep at each change.
        self.views.insert(from.into(), self.view);
        self.view = self.views.get(to).copied().unwrap_or_default();
    }

    /// Pans and zooms the view.
    fn navigate(&mut self, ui: &Ui, background: &Response) {
        if !ui.rect_contains_pointer(self.view.rect) {
            return;
        }
        let moves = ui.input(|input| {
            input.events.iter().find_map(|event| match event {
                Event::MouseWheel { unit, .. } => Some(*unit == MouseWheelUnit::Point),
                _ => None,
            })
        });
        self.wheel_moves = moves.unwrap_or(self.wheel_moves);
        let (at, scroll, zoom, alt) = ui.input(|input| {
            (input.pointer.latest_pos(), input.smooth_scroll_delta(), input.zoom_delta(), input.modifiers.alt)
        });
        let held = crate::commands::moves_view(ui.ctx());
        if held {
            ui.ctx().set_cursor_icon(egui::CursorIcon::Grab);
        }
        let at = at.unwrap_or(background.rect.center());
        if zoom != 1.0 {
            self.view.zoom_at(at, zoom);
        }
        if self.wheel_moves {
            self.view.pan += scroll;
        } else if scroll.y != 0.0 {
            self.view.zoom_at(at, (scroll.y * 0.004).exp());
        }
        let pressed = ui.input(|input| {
            let by = |button| input.pointer.button_pressed(button);
            let middle = by(PointerButton::Middle).then_some(PointerButton::Middle);
            middle.or(((alt || held) && by(PointerButton::Primary)).then_some(PointerButton::Primary))
        });
        if let Some(button) = pressed.filter(|_| matches!(self.gesture, Gesture::Idle)) {
            self.gesture = Gesture::Pan(button);
        }
    }

    /// Handles input on the empty canvas and on wires.
    fn background(&mut self, plan: &Plan, ui: &Ui, state: &State, response: &Response, actions: &mut Vec<Action>) {
        let wire = self.wire_hovered(plan, ui, response.hovered());
        self.wires_ui(plan, ui, state, wire);
        let idle = matches!(self.gesture, Gesture::Idle);
        if idle && response.drag_started_by(PointerButton::Primary) {
            let origin = ui.input(|input| input.pointer.press_origin());
            let reach = wire::REACH / self.view.zoom;
            let pressed = origin.and_then(|at| plan.nearest_wire(self.view.canvas(at), reach));
            self.begin(plan, ui, state, pressed);
        }
        if idle && response.clicked() {
            let modifiers = ui.input(|input| input.modifiers);
            match (wire, response.interact_pointer_pos()) {
                (Some(wire), Some(at)) if modifiers.command => {
                    let (_, dots) = drag::with_dot(plan, wire, self.view.canvas(at));
                    let dots: Vec<Point> = dots.into_iter().map(Into::into).collect();
                    let to = plan.sheet.wires[wire].to;
                    actions.push(Action::Edit(crate::document::decor::dotted(&plan.sheet, to, &dots)));
                    actions.push(Action::Seal);
                }
                _ if !(modifiers.shift || modifiers.command || state.selection.is_empty()) => {
                    actions.push(Action::Select(BTreeSet::new()));
                }
                _ => {}
            }
        }
        if response.secondary_clicked() {
            self.open_menu(ui, menu::MenuTarget::Empty);
        }
    }

    /// Handles keyboard input and pasted text.
    fn keys(&mut self, plan: &Plan, ui: &Ui, state: &State, actions: &mut Vec<Action>) {
        if ui.ctx().text_edit_focused() {
            return;
        }
        let (up, down) = ui.input_mut(|input| {
            (input.consume_key(Modifiers::ALT, Key::ArrowUp), input.consume_key(Modifiers::ALT, Key::ArrowDown))
        });
        if let Some(node) = state.chosen().and_then(|name| plan.sheet.find(name)).filter(|_| up || down) {
            let mut wires = plan.sheet.wires.iter();
            let next = match up {
                true => wires.find(|wire| wire.to.0 == node).map(|wire| wire.from.0),
                false => wires.find(|wire| wire.from.0 == node).map(|wire| wire.to.0),
            };
            if let Some(next) = next {
                actions.push(Action::Select([plan.sheet.nodes[next].name.clone()].into()));
                if !self.view.seen().contains_rect(plan.boxes[next]) {
                    self.view.center(plan.boxes[next].center());
                }
            }
        }
        // Esc first ends what is being done.
        let is_covered = egui::Popup::is_any_open(ui.ctx()) || ui.memory(|memory| memory.top_modal_layer().is_some());
        let is_idle = self.was_idle && state.dropper.is_none() && !is_covered;
        if is_idle && !state.scope.is_empty() && ui.input(|input| input.key_pressed(Key::Escape)) {
            actions.push(Action::Enter(state.scope[..state.scope.len() - 1].to_vec()));
        }
        let over = ui.rect_contains_pointer(self.view.rect);
        if over || self.wants_paste {
            let (pasted, at) = ui.input(|input| {
                let text = input.events.iter().find_map(|event| match event {
                    Event::Paste(text) => Some(text.clone()),
                    _ => None,
                });
                (text, input.pointer.latest_pos())
            });
            if let Some(text) = pasted {
                self.wants_paste = false;
                let at = self.view.canvas(at.filter(|_| over).unwrap_or(self.view.rect.center()));
                actions.push(Action::Paste(text, at.into()));
            }
        }
    }

    /// Draws guide lines, the selection rectangle, and other overlays of the gesture.
    fn overlay(&self, plan: &Plan, ui: &Ui) {
        self.pull_ui(plan, ui);
        match &self.gesture {
            Gesture::Area(from, _) => {
                if let Some(at) = ui.input(|input| input.pointer.latest_pos()) {
                    let area = Rect::from_two_pos(self.view.screen(*from), at);
                    let color = ui.visuals().selection.bg_fill;
                    ui.painter().rect_filled(area, 0.0, color.gamma_multiply(0.25));
                    let line = Stroke::new(1.0, color.lerp_to_gamma(Color32::WHITE, 0.3));
                    ui.painter().rect_stroke(area, 0.0, line, StrokeKind::Inside);
                }
            }
            Gesture::Move(held) => {
                for ends in &held.guides {
                    let ends = ends.map(|at| self.view.screen(at));
                    ui.painter().line_segment(ends, Stroke::new(1.0, Color32::from_rgb(0xe0, 0x7a, 0xb8)));
                }
            }
            Gesture::Output(name) => self.led_ui(plan, ui, name),
            _ => {}
        }
        if plan.sheet.nodes.is_empty() {
            let text = "Press Tab to add a node";
            let color = ui.visuals().weak_text_color();
            ui.painter().text(self.view.rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(15.0), color);
        }
    }

    /// Draws the background with a regular grid of dots, which makes panning visible.
    fn ground(&self, ui: &Ui) {
        let dark = ui.visuals().dark_mode;
        ui.painter().rect_filled(self.view.rect, 0.0, ui.visuals().panel_fill);
        let step = 60.0 * self.view.zoom;
        if step < 22.0 {
            return;
        }
        let color = if dark { Color32::from_gray(0x36) } else { Color32::from_gray(0xd6) };
        let first = self.view.screen(egui::Pos2::ZERO) - self.view.rect.min;
        let start = vec2(first.x.rem_euclid(step), first.y.rem_euclid(step));
        let mut y = self.view.rect.top() + start.y;
        while y < self.view.rect.bottom() {
            let mut x = self.view.rect.left() + start.x;
            while x < self.view.rect.right() {
                ui.painter().rect_filled(Rect::from_center_size(pos2(x, y), vec2(1.5, 1.5)), 0.0, color);
                x += step;
            }
            y += step;
        }
    }
}

/// Returns positions from a layered layout of the selected nodes, or of all nodes if fewer than two are selected.
pub fn arrange(sheet: &Sheet, chosen: &BTreeSet<String>) -> Vec<(String, Point)> {
    place::arrange(sheet, chosen)
}

/// Returns the document with a place for every node: the place where it is drawn.
pub fn placed(sheet: &Arc<Sheet>) -> Arc<Sheet> {
    let has_all = sheet.nodes.iter().all(|node| node.placed);
    if has_all { sheet.clone() } else { Arc::new(place::placed(sheet)) }
}

/// Returns an edit that keeps nodes where they are drawn: it first writes all places, if the document does not have
/// them.
pub fn freezing(sheet: &Sheet, then: Edit) -> Edit {
    place::freezing(sheet, &place::boxes(sheet, &mut place::GraphLayout::default()), then)
}

/// Deletes nodes; the others keep the places where they are drawn.
pub fn deleting(sheet: &Sheet, names: &[String]) -> Edit {
    let mut boxes = place::boxes(sheet, &mut place::GraphLayout::default());
    let mut rest = sheet.clone();
    let stays = |node: &crate::document::Node| node.placed || !names.contains(&node.name);
    let mut kept = sheet.nodes.iter().map(stays);
    boxes.retain(|_| kept.next().unwrap_or(true));
    rest.nodes.retain(stays);
    place::freezing(&rest, &boxes, edit::deleted(sheet, names))
}

/// Aligns or distributes the selected nodes.
pub fn lined_up(sheet: &Sheet, chosen: &BTreeSet<String>, line: Line) -> Edit {
    let boxes = place::boxes(sheet, &mut place::GraphLayout::default());
    let nodes: Vec<usize> = chosen.iter().filter_map(|name| sheet.find(name)).collect();
    let own: Vec<Rect> = nodes.iter().map(|node| boxes[*node]).collect();
    let names = nodes.iter().map(|node| sheet.nodes[*node].name.clone());
    let places: Vec<(String, Point)> = names.zip(menu::lined_up(&own, line)).collect();
    place::freezing(sheet, &boxes, Edit { label: line.name().into(), ..edit::moved(&places) })
}

/// Adds a backdrop behind the selected nodes; returns the edit, its name, and its initial text, or `None` if no node is
/// selected.
pub fn backdrop(sheet: &Sheet, chosen: &BTreeSet<String>) -> Option<(Edit, String, &'static str)> {
    let boxes = place::boxes(sheet, &mut place::GraphLayout::default());
    let some = chosen.iter().filter_map(|name| Some(boxes[sheet.find(name)?]));
    let (edit, name) = backdrop::behind(sheet, some.reduce(Rect::union)?);
    Some((edit, name, backdrop::BACKDROP))
}

/// Returns the backdrop that the selection refers to: the smallest one behind all selected nodes, or else the only one.
pub fn backdrop_of<'s>(sheet: &'s Sheet, chosen: &BTreeSet<String>) -> Option<&'s String> {
    let boxes = place::boxes(sheet, &mut place::GraphLayout::default());
    let nodes = chosen.iter().filter_map(|name| Some(boxes[sheet.find(name)?])).reduce(Rect::union);
    let behind = |own: Rect| nodes.is_some_and(|nodes| own.contains_rect(nodes));
    let all = sheet.backdrops.iter().map(|(name, body)| (name, backdrop::area(body)));
    let mut only = all.clone();
    let fitting = all.filter(|(_, own)| behind(*own)).min_by(|a, b| a.1.area().total_cmp(&b.1.area()));
    fitting.or_else(|| only.next().filter(|_| sheet.backdrops.len() == 1)).map(|(name, _)| name)
}

/// Draws the graph.
pub fn canvas_ui(canvas: &mut Canvas, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let area = ui.available_rect_before_wrap();
    ui.allocate_rect(area, Sense::hover());
    let rect = path::path_ui(ui, area, state, actions);
    let mut ui = ui.new_child(UiBuilder::new().id_salt("canvas").max_rect(rect));
    ui.shrink_clip_rect(rect);
    let ui = &mut ui;
    canvas.was_idle = canvas.explains() && canvas.writing.is_none();
    let mut plan = canvas.prepare(ui, state, rect);
    let background = ui.interact(rect, ui.id().with("background"), Sense::click_and_drag());
    background.widget_info(|| WidgetInfo::labeled(WidgetType::Other, true, "Graph"));
    canvas.navigate(ui, &background);
    canvas.add_wanted(&plan, state, actions);
    canvas.advance(&mut plan, ui, state, actions);
    canvas.ground(ui);
    canvas.backdrops_ui(&plan, ui);
    canvas.background(&plan, ui, state, &background, actions);
    canvas.dots_ui(&plan, ui, actions);
    canvas.nodes_ui(&plan, ui, state, actions);
    canvas.follow_ui(&plan, ui, state);
    canvas.click_pin(&plan, ui, state, actions);
    canvas.overlay(&plan, ui);
    canvas.writing_ui(&plan, ui, actions);
    canvas.minimap_ui(&plan, ui);
    canvas.keys(&plan, ui, state, actions);
    canvas.refusal_ui(&plan, ui, actions);
    canvas.menu_ui(&plan, ui, state, actions);
    canvas.search_ui(&plan, ui, state, actions);
    canvas.plan = Some(plan);
}
