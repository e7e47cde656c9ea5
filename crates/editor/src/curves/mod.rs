//! The curves panel: keyed values of the selected nodes as curves with handles, or as a dope sheet.

mod change;
mod drag;
mod graph;
mod keys;
mod list;
mod sheet;
mod tools;
mod view;

use crate::actions::Action;
use crate::document::curve::{Key, Pick};
use crate::document::keyed::{Channel, channels};
use crate::document::{Path, swatches};
use crate::refusal::refusal_ui;
use crate::state::State;
use change::Change;
use drag::Drag;
use egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Ui, pos2, vec2};
use keys::Order;
use std::collections::HashSet;
use trochoid::{Animated, WorkingSpace};
use view::{RULER, Screen, View};

/// State of the panel that no other panel shares.
#[derive(Default)]
pub(crate) struct Curves {
    /// Keyed values that are not shown, and, where there are too many to show all at first, those that are.
    hidden: HashSet<Path>,
    chosen: HashSet<Path>,
    is_crowded: bool,
    /// Whether the dope sheet is shown, and how far its rows are scrolled.
    is_sheet: bool,
    scrolled: f32,
    view: Option<View>,
    /// Keyed values for which the view was chosen.
    known: Vec<Path>,
    picks: Vec<Picked>,
    /// Keys whose handles are moved one by one, though they lie on one line so far.
    corners: Vec<(Path, f64)>,
    drag: Option<Drag>,
    /// Number of drags so far: each is a step of undo.
    drags: u64,
    /// What keys asked for since the panel was drawn.
    orders: Vec<Order>,
    /// Where the panel was drawn last, and in which pass.
    area: Option<(Rect, u64)>,
}

/// A picked key of a keyed value.
#[derive(Clone, Debug, PartialEq)]
struct Picked {
    path: Path,
    pick: Pick,
}

/// A mark on the screen that stands for keys.
struct Spot {
    picks: Vec<Picked>,
    place: Pos2,
    /// Whether it stands for the keys of several values.
    is_sum: bool,
}

/// Colors of curves, in turn.
const COLORS: [Color32; 8] = [
    Color32::from_rgb(0xe0, 0x6a, 0x6a),
    Color32::from_rgb(0x5f, 0xb8, 0x72),
    Color32::from_rgb(0x6a, 0x9c, 0xe0),
    Color32::from_rgb(0xd0, 0xa0, 0x50),
    Color32::from_rgb(0xb0, 0x86, 0xd8),
    Color32::from_rgb(0x3f, 0xb5, 0xb0),
    Color32::from_rgb(0xd8, 0x78, 0xb0),
    Color32::from_rgb(0x9a, 0xa8, 0x4a),
];

/// Color of keys.
const KEY: Color32 = Color32::from_rgb(0xe8, 0xb0, 0x4a);
/// Width of the list of keyed values, in points.
const LIST: f32 = 210.0;
/// Most curves that are shown without being chosen, if no node is selected.
const MOST: usize = 24;
/// Height of the line of typed values, in points.
const TYPED: f32 = 26.0;

/// Returns whether a keyed value is drawn as curves: its values are numbers, or colors without names.
fn is_drawn(channel: &Channel) -> bool {
    channel.curve.keys.iter().all(|key| !key.numbers().is_empty())
}

/// Returns whether a keyed value is a color that is written as text. Its keys move in time only.
fn is_color(channel: &Channel) -> bool {
    channel.curve.keys.iter().any(|key| key.value.is_string())
}

/// Returns the number of curves of a keyed value.
fn components(channel: &Channel) -> usize {
    channel.curve.keys.first().filter(|_| is_drawn(channel)).map_or(0, |key| key.numbers().len())
}

/// Returns the curves of a keyed value; those of a color are red, green and blue in the working space.
fn animated(channel: &Channel, space: WorkingSpace) -> Option<Animated> {
    match is_color(channel) {
        true => channel.curve.animated_by(|key| Some(swatches::working(&key.value, space, key.frame)?.to_vec())),
        false => channel.curve.animated(),
    }
}

/// Returns all components of the keys of a channel at a frame.
fn whole(channel: &Channel, frame: f64) -> Vec<Picked> {
    let count = channel.curve.find(frame).map_or(0, |index| channel.curve.keys[index].numbers().len().max(1));
    let pick = |component| Picked { path: channel.path.clone(), pick: Pick { frame, component } };
    (0..count).map(pick).collect()
}

impl Curves {
    /// Returns the shown ones of some channels: all in the dope sheet, else those that are ticked and drawn.
    fn shown<'c>(&self, channels: &'c [Channel]) -> Vec<&'c Channel> {
        let is_seen = |channel: &Channel| self.is_ticked(channel) && is_drawn(channel);
        channels.iter().filter(|channel| self.is_sheet || is_seen(channel)).collect()
    }

    /// Returns whether a channel is ticked in the list.
    fn is_ticked(&self, channel: &Channel) -> bool {
        if self.is_crowded { self.chosen.contains(&channel.path) } else { !self.hidden.contains(&channel.path) }
    }

    /// Ticks a channel, or no longer.
    fn tick(&mut self, channel: &Channel, on: bool) {
        let listed = if self.is_crowded { &mut self.chosen } else { &mut self.hidden };
        if on == self.is_crowded {
            listed.insert(channel.path.clone());
        } else {
            listed.remove(&channel.path);
        }
        if !on {
            self.picks.retain(|picked| picked.path != channel.path);
        }
        if self.is_crowded {
            // What is chosen comes into view.
            self.view = None;
        }
    }

    /// Returns whether a key of a channel is picked.
    fn is_picked(&self, picked: &Picked) -> bool {
        self.picks.contains(picked)
    }

    /// Returns the channels with picked keys, and the frames of these.
    fn picked<'c>(&self, channels: &'c [Channel]) -> Vec<(&'c Channel, Vec<Pick>)> {
        let of = |channel: &Channel| -> Vec<Pick> {
            self.picks.iter().filter(|picked| picked.path == channel.path).map(|picked| picked.pick).collect()
        };
        let all = channels.iter().map(|channel| (channel, of(channel)));
        all.filter(|(_, picks)| !picks.is_empty()).collect()
    }

    /// Returns whether the handles of a key are moved one by one.
    fn is_corner(&self, channel: &Channel, key: &Key) -> bool {
        let is_meant = |(path, frame): &(Path, f64)| *path == channel.path && *frame == key.frame;
        !key.is_smooth() || self.corners.iter().any(is_meant)
    }

    /// Forgets picked keys that are gone. While they are dragged, a refused place is no loss.
    fn refresh(&mut self, channels: &[Channel], is_whole: bool) {
        self.is_crowded = is_whole && channels.iter().map(components).sum::<usize>() > MOST;
        let is_there = |picked: &Picked| {
            let mut all = channels.iter().filter(|channel| channel.path == picked.path);
            all.any(|channel| channel.curve.find(picked.pick.frame).is_some())
        };
        match &mut self.drag {
            Some(drag) if self.picks.iter().all(is_there) => drag.seen.clone_from(&self.picks),
            Some(drag) => self.picks.clone_from(&drag.seen),
            None => {}
        }
        self.picks.retain(is_there);
        let paths: Vec<Path> = channels.iter().map(|channel| channel.path.clone()).collect();
        if paths != self.known {
            (self.known, self.view) = (paths, None);
        }
    }
}

/// Draws the panel.
pub(crate) fn curves_ui(panel: &mut Curves, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let area = ui.available_rect_before_wrap();
    panel.area = Some((area, ui.ctx().cumulative_pass_nr()));
    let channels = channels(state.sheet(), &state.selection);
    panel.refresh(&channels, state.selection.is_empty());
    let field = ui.id().with("curves plot");
    let space = swatches::space(state.sheet());
    let mut change = Change { channels: &channels, space, frame: state.frame, field, actions };
    tools::tools_ui(panel, ui, &mut change);
    if channels.is_empty() {
        let whose = if state.selection.is_empty() { "Nothing here" } else { "Nothing of what is selected" };
        ui.weak(format!("{whose} has keys. The diamond beside a knob in Properties sets one."));
        panel.orders.clear();
        return;
    }
    let rest = ui.available_rect_before_wrap();
    let body = Rect::from_min_max(rest.min, pos2(rest.right(), (rest.bottom() - TYPED).max(rest.top() + 40.0)));
    let list = LIST.min(0.4 * body.width());
    let plot = Rect::from_min_max(pos2(body.left() + list, body.top() + RULER), body.max);
    if !panel.is_sheet {
        let left = Rect::from_min_max(body.min, pos2(plot.left() - 6.0, body.bottom()));
        ui.scope_builder(egui::UiBuilder::new().max_rect(left), |ui| list::list_ui(panel, ui, &channels));
    }
    plot_ui(panel, ui, state, (body, plot), &mut change);
    let typed = Rect::from_min_max(pos2(body.left(), body.bottom() + 4.0), rest.max);
    ui.scope_builder(egui::UiBuilder::new().max_rect(typed), |ui| {
        tools::typed_ui(panel, ui, &channels, actions);
    });
    ui.allocate_rect(rest, Sense::hover());
}

/// Returns the name of a keyed value, or of its component.
fn named(panel: &Curves, channels: &[Channel], picked: &Picked) -> String {
    let Some(channel) = channels.iter().find(|channel| channel.path == picked.path) else { return String::new() };
    let is_list = channel.curve.keys.first().is_some_and(|key| key.value.is_array());
    let is_list = is_list || (is_color(channel) && !panel.is_sheet);
    let component = if is_list { format!("[{}]", picked.pick.component) } else { String::new() };
    format!("{}.{}{component}", channel.owner, channel.name)
}

/// Tells tools for accessibility of a mark in the plot.
fn mark_ui(ui: &Ui, at: Pos2, name: &str, is_picked: bool) {
    let mark = ui.interact(Rect::from_center_size(at, vec2(9.0, 9.0)), ui.id().with(name), Sense::hover());
    mark.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Other, true, is_picked, name));
}

/// Draws the plot or the dope sheet, and handles its input.
fn plot_ui(panel: &mut Curves, ui: &mut Ui, state: &State, (body, rect): (Rect, Rect), change: &mut Change<'_>) {
    let channels = change.channels;
    let whole = Rect::from_min_max(rect.min - vec2(0.0, RULER), rect.max);
    let response = ui.interact(whole, change.field, Sense::click_and_drag());
    let name = if panel.is_sheet { "Dope sheet of keys" } else { "Curves of keys" };
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Other, true, name));
    let shown = panel.shown(channels);
    let (frames, space) = (state.range, change.space);
    let view = *panel.view.get_or_insert_with(|| View::around(&shown, frames, space));
    let screen = Screen { view, rect };
    let painter = ui.painter_at(body);
    painter.rect_filled(whole, 2.0, ui.visuals().extreme_bg_color);
    let plot = painter.with_clip_rect(whole);
    let is_empty = shown.is_empty();
    screen.ruler_ui(ui, &plot);
    screen.playhead_ui(ui, &plot, state.frame);
    let spots = if panel.is_sheet {
        sheet::sheet_ui(panel, ui, &painter, &screen, body, channels)
    } else {
        graph::graph_ui(panel, ui, &plot, &screen, channels, space)
    };
    if is_empty {
        let hint = "Tick curves in the list to see them.";
        let (font, ink) = (FontId::proportional(13.0), ui.visuals().weak_text_color());
        plot.text(rect.center(), Align2::CENTER_CENTER, hint, font, ink);
    }
    panel.keys_ui(ui, change);
    panel.menu_ui(&response, change);
    panel.gestures_ui(ui, &response, &screen, &spots, change);
    // Keys lie over all else.
    let keys = painter.with_clip_rect(rect);
    for spot in &spots {
        graph::key_ui(ui, &keys, spot.place, spot.picks.iter().all(|picked| panel.is_picked(picked)));
    }
    if !panel.is_sheet {
        for grip in graph::grips(panel, channels) {
            let side = if grip.side == 0 { "before" } else { "after" };
            let name =
                format!("Handle {side} key {} of {}", grip.picked.pick.frame, named(panel, channels, &grip.picked));
            mark_ui(ui, screen.place(grip.to[0], grip.to[1]), &name, true);
        }
    }
    for spot in spots.iter().filter(|spot| !spot.is_sum) {
        let Some(first) = spot.picks.first() else { continue };
        let name = format!("Key {} of {}", first.pick.frame, named(panel, channels, first));
        mark_ui(ui, spot.place, &name, panel.is_picked(first));
    }
    refusal_ui(ui, &response);
}
