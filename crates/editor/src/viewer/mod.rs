//! The viewer: display of the picture, inspection of pixels, and handles in the picture.

mod compare;
mod handles;
mod hull;
mod inspector;
mod message;
mod near;
mod onion;
mod origin;
mod overlay;
mod picture;
mod scene;
mod scopes;
mod second;
mod switch;
#[cfg(test)]
pub(crate) mod tests;
mod toolbar;
mod transform;

use crate::actions::Action;
use crate::document::Edit;
use crate::evaluate::{Channel, Display, Result, Screen};
use crate::field::Gesture;
use crate::state::State;
use compare::{Compare, Mode};
use egui::{
    Align, Color32, CursorIcon, Key, Layout, Modifiers, PointerButton, Pos2, Rect, Response, RichText, Sense, Stroke,
    StrokeKind, Ui, UiBuilder, WidgetInfo, WidgetType, pos2, vec2,
};
use hull::Space;
use message::{clay, message_ui, note};
use near::Near;
use onion::Onion;
use overlay::Overlay;
use picture::{Image, Stage, View, part, place, share};
use scene::Scene;
use scopes::Scopes;
pub(crate) use second::{SecondViewer, second_ui};
use serde_json::json;
use std::collections::HashMap;
use std::sync::Arc;
use trochoid::{Kind, Picture, WorkingSpace};

/// State of the viewer that no other panel shares.
#[derive(Default)]
pub(crate) struct Viewer {
    view: View,
    image: Image,
    compare: Compare,
    space: Space,
    near: Near,
    scopes: Scopes,
    scene: Scene,
    onion: Onion,
    opening: transform::Opening,
    /// Whether handles are hidden.
    no_handles: bool,
    /// Whether it is the second viewer.
    is_second: bool,
    /// Whether it pans and zooms together with the first one.
    is_locked: bool,
    /// Whether the next drag in the picture draws the region.
    frames_region: bool,
    drag: Option<Drag>,
    /// Widths of the toolbar's groups when last drawn.
    widths: HashMap<(toolbar::Group, u8), f32>,
    /// The inspected pixel before the last click, restored if that click turns out to begin a double-click.
    before: Option<[f32; 2]>,
    /// Where the inspector lies over the picture.
    inspected: Overlay,
    /// Whether the scopes are.
    has_scopes: bool,
}

impl Viewer {
    /// Returns the request for the held picture, if it needs other display settings.
    pub(crate) fn held_wanted(&mut self, result: &Result) -> Option<(u64, Arc<Picture>, WorkingSpace, Display)> {
        self.compare.wanted(result)
    }

    /// Clears everything that belongs to the document being left.
    pub(crate) fn forget(&mut self) {
        self.compare.held = None;
        (self.before, self.drag, self.frames_region) = (None, None, false);
        self.view.fit();
        self.scene.forget();
    }

    /// Receives the requested held picture.
    pub(crate) fn take_held(&mut self, number: u64, display: Display, screen: Arc<Screen>) {
        self.compare.take(number, display, screen);
    }
}

/// Effect of a drag in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Drag {
    Pan,
    /// Draws a region from this corner, in fractions of the picture.
    Region(Pos2),
    Pick,
}

/// Height of the status bar below the picture.
const BAR: f32 = 20.0;
/// Minimum width of the picture beside the scopes.
const NARROW: f32 = 300.0;

/// Draws a viewer.
pub(crate) fn viewer_ui(viewer: &mut Viewer, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let whole = ui.available_rect_before_wrap();
    toolbar::toolbar_ui(viewer, ui, state, actions);
    viewer.opening.ui(ui.ctx(), state, actions);
    let mut area = ui.available_rect_before_wrap();
    let mut bar = area;
    area.max.y = (area.max.y - BAR).max(area.min.y + 1.0);
    bar.min.y = area.max.y;
    let result = state.evaluated.shown().map(|result| &**result);
    let size = match result.or(state.evaluated.last.as_deref()).map(|result| result.lens.graph.format()) {
        Some(format) => [format.width(), format.height()],
        None => state.sheet().format,
    };
    let size = vec2(size[0] as f32, size[1] as f32).max(vec2(1.0, 1.0));
    let stage = Stage { area, size, density: ui.ctx().pixels_per_point() };
    let scopes = viewer.scopes_strip(ui, &stage);
    if let Some(strip) = scopes {
        area.min.x = strip.max.x;
    }
    let stage = Stage { area, ..stage };
    let hover = match result {
        Some(result) if viewer.space.shown => {
            viewer.space.ui(ui, area, result);
            None
        }
        result => picture_ui(viewer, ui, &stage, state, result, actions),
    };
    let within = |at: &Pos2| result.is_some_and(|result| inspector::pixel(result, *at).is_some());
    let hovered = hover.filter(within).map(|at| [at.x, at.y]);
    if hovered != state.colors.hover {
        actions.push(Action::Hover(hovered));
    }
    if let (Some(strip), Some(result)) = (scopes, result.or(state.evaluated.last.as_deref())) {
        viewer.scopes.ui(ui, strip, state, &result.screen);
    }
    if let (Some([x, y]), Some(result), false) = (state.look.pick, result, viewer.space.shown) {
        let at = pos2(x, y);
        let spot = place(viewer.view.rect(&stage), at);
        viewer.inspected.ui(ui, area, spot, |ui| inspector::inspector_ui(ui, state, result, at, actions));
    }
    if ui.rect_contains_pointer(whole) && !ui.ctx().egui_wants_keyboard_input() {
        keys(viewer, ui, state, actions);
    }
    ui.scope_builder(UiBuilder::new().max_rect(bar.shrink2(vec2(4.0, 0.0))).id_salt("bar"), |ui| {
        bar_ui(viewer, ui, &stage, state, hover);
    });
}

impl Viewer {
    /// Returns the area of the scopes beside the picture, if they are shown, and adapts the view to the remaining area.
    fn scopes_strip(&mut self, ui: &Ui, stage: &Stage) -> Option<Rect> {
        let area = stage.area;
        let wanted = self.scopes.shown && area.width() > NARROW + scopes::WIDTH;
        let mut rest = *stage;
        rest.area.min.x += scopes::WIDTH;
        if wanted != self.has_scopes && !ui.input(|input| input.pointer.any_down()) {
            self.has_scopes = wanted;
            let (from, to) = if wanted { (stage, &rest) } else { (&rest, stage) };
            self.view.keep(from, to);
        }
        self.has_scopes.then(|| Rect::from_min_max(area.min, rest.area.left_bottom()))
    }
}

/// Handles keys that work while the pointer is over the viewer.
fn keys(viewer: &mut Viewer, ui: &Ui, state: &State, actions: &mut Vec<Action>) {
    let pressed = |key: Key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    let display = &state.look.display;
    let channels = state.evaluated.result.as_ref().map_or(3, |result| result.picture.planes.len());
    let is_color = state.evaluated.result.as_ref().is_none_or(|result| result.picture.kind == Kind::Color);
    let mut choose = |channel: Channel| {
        let channel = if display.channel == channel { Channel::All } else { channel };
        actions.push(Action::Display(Display { channel, ..display.clone() }));
    };
    for (index, key) in [Key::R, Key::G, Key::B].into_iter().enumerate() {
        if pressed(key) && index < channels {
            choose(Channel::One(index));
        }
    }
    if pressed(Key::Y) && is_color {
        choose(Channel::Luminance);
    }
    if pressed(Key::H) {
        viewer.show_space(!viewer.space.shown);
    }
    if pressed(Key::N) {
        viewer.near.toggle();
    }
    if pressed(Key::S) {
        viewer.scopes.shown = !viewer.scopes.shown;
    }
    if pressed(Key::Q) {
        viewer.no_handles = !viewer.no_handles;
    }
    if pressed(Key::C) {
        viewer.orbit(!viewer.scene.steers());
    }
    if (state.dropper.is_some() || state.look.pick.is_some() || viewer.frames_region) && pressed(Key::Escape) {
        if viewer.frames_region {
            viewer.frames_region = false;
        } else if state.dropper.is_some() {
            actions.push(Action::Dropper(None));
        } else {
            actions.push(Action::Pick(None));
        }
    }
    // F frames the graph if the pointer is over the graph panel.
    let count = actions.len();
    actions.retain(|action| *action != Action::Frames);
    if actions.len() < count || pressed(Key::F) {
        viewer.view.fit();
    }
}

/// Draws the picture and its overlays; returns the pointer's place in fractions of the picture.
fn picture_ui(
    viewer: &mut Viewer,
    ui: &mut Ui,
    stage: &Stage,
    state: &State,
    result: Option<&Result>,
    actions: &mut Vec<Action>,
) -> Option<Pos2> {
    let response = ui.allocate_rect(stage.area, Sense::click_and_drag());
    response.widget_info(|| {
        WidgetInfo::labeled(WidgetType::Image, true, if viewer.is_second { "Picture 2" } else { "Picture" })
    });
    let painter = ui.painter().with_clip_rect(stage.area);
    painter.rect_filled(stage.area, 0.0, picture::SURROUND);
    let Some(result) = result else {
        if let Some(last) = &state.evaluated.last {
            last_ui(viewer, ui, stage, &response, last);
        }
        message_ui(ui, stage.area, state, actions);
        return None;
    };
    let steers = viewer.scene.steers() && state.dropper.is_none() && !crate::commands::moves_view(ui.ctx());
    if !steers {
        move_view(viewer, ui, stage, &response);
    }
    let rect = viewer.view.rect(stage);
    let zoom = viewer.view.zoom(stage);
    let own = part(result);
    let shown = viewer.compare.shown(result);
    let scale = zoom * own.width() * stage.size.x / shown.size[0].max(1) as f32;
    viewer.image.upload(ui.ctx(), &shown, scale);
    viewer.image.paint(&painter, Rect::from_min_max(place(rect, own.min), place(rect, own.max)));
    let onion = state.look.onion && viewer.onion.paint(ui.ctx(), &painter, rect, scale, state, result);
    if viewer.compare.held.as_ref().is_none_or(|held| held.mode == Mode::Wipe) {
        viewer.near.paint(ui.ctx(), &painter, rect, result);
    }
    if steers {
        viewer.scene.steer(ui, (stage.area, rect), &response, state, result, actions);
    } else {
        point(viewer, ui, rect, &response, state, result, actions);
    }
    marks(viewer, ui, stage, rect, state);
    viewer.compare.wipe_ui(ui, stage, rect, zoom);
    if !viewer.no_handles && state.dropper.is_none() {
        handles::handles_ui(ui, stage.area, rect, state, result, actions);
        viewer.scene.handles_ui(ui, (stage.area, rect), state, result, actions);
    }
    if result.lens.clay {
        note(ui, stage.area, &clay(state));
    } else if viewer.near.shown
        && let Some(text) = near::objection(result)
    {
        note(ui, stage.area, text);
    } else if viewer.near.shown {
        viewer.near.legend_ui(ui, stage.area);
    } else if state.look.onion && !onion {
        note(ui, stage.area, onion::NONE);
    }
    response.hover_pos().map(|at| share(rect, at))
}

/// Draws the last picture, darkened, together with the comparison.
fn last_ui(viewer: &mut Viewer, ui: &mut Ui, stage: &Stage, response: &Response, last: &Result) {
    move_view(viewer, ui, stage, response);
    let (rect, zoom) = (viewer.view.rect(stage), viewer.view.zoom(stage));
    let (own, shown) = (part(last), viewer.compare.shown(last));
    viewer.image.upload(ui.ctx(), &shown, zoom * own.width() * stage.size.x / shown.size[0].max(1) as f32);
    let painter = ui.painter().with_clip_rect(stage.area);
    viewer.image.paint(&painter, Rect::from_min_max(place(rect, own.min), place(rect, own.max)));
    viewer.compare.wipe_ui(ui, stage, rect, zoom);
    painter.rect_filled(stage.area, 0.0, Color32::from_black_alpha(140));
    let corner = stage.area.left_bottom() - vec2(0.0, 36.0);
    note(ui, Rect::from_min_max(corner, stage.area.max), "Old picture");
}

/// Zooms and pans the picture.
fn move_view(viewer: &mut Viewer, ui: &Ui, stage: &Stage, response: &Response) {
    if let Some(at) = response.hover_pos() {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = (scroll * 0.005).exp() * pinch;
        if factor != 1.0 {
            viewer.view.zoom_at(stage, at, factor);
        }
    }
    if response.dragged_by(PointerButton::Middle) || (response.dragged() && viewer.drag == Some(Drag::Pan)) {
        viewer.view.pan(stage, response.drag_delta());
    }
    if response.double_clicked() {
        viewer.view.fit();
    }
}

/// Handles clicks and drags in the picture.
fn point(
    viewer: &mut Viewer,
    ui: &Ui,
    rect: Rect,
    response: &Response,
    state: &State,
    result: &Result,
    actions: &mut Vec<Action>,
) {
    let at = response.interact_pointer_pos().map(|at| share(rect, at));
    let within = |at: Pos2| at.clamp(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let modifiers = ui.input(|input| input.modifiers);
    if let Some(place) = &state.dropper {
        if response.hovered() {
            ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
        }
        let color = at.and_then(|at| inspector::pixel(result, at)).and_then(|pixel| inspector::picked(result, pixel));
        if let Some((color, gesture)) = color.zip(Gesture::click(response)) {
            let [r, g, b, _] = color.to_array();
            let text = format!("#{r:02x}{g:02x}{b:02x}");
            gesture.edit(Edit::set(place.clone(), &json!(text)), actions);
            actions.push(Action::Dropper(None));
        }
        return;
    }
    if response.drag_started_by(PointerButton::Primary) {
        let origin = ui.input(|input| input.pointer.press_origin()).map(|at| share(rect, at));
        viewer.drag = match origin.or(at) {
            _ if modifiers.alt || crate::commands::moves_view(ui.ctx()) => Some(Drag::Pan),
            Some(at) if modifiers.shift || viewer.frames_region => Some(Drag::Region(within(at))),
            _ => Some(Drag::Pick),
        };
    }
    let picked = at.filter(|at| inspector::pixel(result, *at).is_some()).map(|at| [at.x, at.y]);
    if viewer.drag == Some(Drag::Pick) && response.dragged_by(PointerButton::Primary) && picked.is_some() {
        actions.push(Action::Pick(picked));
    }
    if response.drag_stopped() {
        if let (Some(Drag::Region(from)), Some(to)) = (viewer.drag, at) {
            let framed = Rect::from_two_pos(from, within(to));
            let [w, h] = [framed.width() * rect.width(), framed.height() * rect.height()];
            // Smaller rectangles do not count as a drag.
            if w > 3.0 && h > 3.0 {
                actions.push(Action::Region(Some([framed.min.x, framed.min.y, framed.max.x, framed.max.y])));
                viewer.frames_region = false;
            }
        }
        viewer.drag = None;
    }
    if response.double_clicked() {
        actions.push(Action::Pick(viewer.before));
    } else if response.clicked() && !modifiers.alt && !modifiers.shift {
        viewer.before = state.look.pick;
        if picked.is_some() {
            actions.push(Action::Pick(picked));
        }
    }
}

/// Draws the marks of the inspected pixel and of the region.
fn marks(viewer: &Viewer, ui: &Ui, stage: &Stage, rect: Rect, state: &State) {
    let painter = ui.painter().with_clip_rect(stage.area);
    let frame = |framed: Rect| {
        let framed = Rect::from_min_max(place(rect, framed.min), place(rect, framed.max));
        painter.rect_stroke(framed, 0.0, Stroke::new(3.0, Color32::from_black_alpha(120)), StrokeKind::Outside);
        painter.rect_stroke(framed, 0.0, Stroke::new(1.0, Color32::from_white_alpha(220)), StrokeKind::Outside);
    };
    if let Some([x0, y0, x1, y1]) = state.look.region {
        frame(Rect::from_min_max(pos2(x0, y0), pos2(x1, y1)));
    }
    if let (Some(Drag::Region(from)), Some(pointer)) = (viewer.drag, ui.ctx().pointer_latest_pos()) {
        frame(Rect::from_two_pos(from, share(rect, pointer).clamp(pos2(0.0, 0.0), pos2(1.0, 1.0))));
    }
    if let Some([x, y]) = state.look.pick {
        let at = place(rect, pos2(x, y));
        for (width, color) in [(3.0, Color32::from_black_alpha(150)), (1.2, Color32::WHITE)] {
            let stroke = Stroke::new(width, color);
            painter.circle_stroke(at, 5.0, stroke);
            for toward in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
                painter.line_segment([at + toward * 5.0, at + toward * 10.0], stroke);
            }
        }
    }
}

/// Draws the status bar: values under the pointer, and the size of the picture.
fn bar_ui(viewer: &mut Viewer, ui: &mut Ui, stage: &Stage, state: &State, hover: Option<Pos2>) {
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        let result = state.evaluated.shown().map(|result| &**result);
        if let Some(result) = result {
            let format = &result.format;
            ui.weak(format!("{} × {}", format.width(), format.height()));
            if !result.finished {
                ui.weak(format!("coarse 1/{}", result.shrunk));
            }
        }
        if !viewer.space.shown {
            ui.weak(format!("{:.0} %", 100.0 * viewer.view.zoom(stage)));
            if ui.small_button("1:1").on_hover_text("Show one pixel of the document per screen pixel").clicked() {
                viewer.view.one_to_one(stage);
            }
            if ui.small_button("Fit").on_hover_text("Fit the picture to the panel (F, or double-click)").clicked() {
                viewer.view.fit();
            }
        }
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            if let Some(place) = &state.dropper {
                let text = format!("Click a color for {}", crate::document::spoken(place));
                ui.add(egui::Label::new(RichText::new(text).strong()).truncate());
            } else if viewer.space.shown {
                ui.add(egui::Label::new(RichText::new("Drag to rotate, scroll to zoom").weak()).truncate());
            } else if viewer.scene.steers() {
                ui.add(egui::Label::new(RichText::new(scene::HELP).strong()).truncate()).on_hover_text(scene::HELP);
            } else if let (Some(at), Some(result)) = (hover, result)
                && let Some(pixel) = inspector::pixel(result, at)
            {
                if let Some(color) = inspector::displayed(result, pixel) {
                    inspector::swatch_ui(ui, color, 12.0);
                }
                let values = inspector::written(&inspector::values(result, pixel), 6);
                let [x, y] = inspector::named(result, at);
                let text = format!("{x}, {y}   {values}");
                ui.add(egui::Label::new(RichText::new(text).monospace().size(11.0)).truncate());
            }
        });
    });
}
