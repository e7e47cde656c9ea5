//! The buttons of the panel, its menu, and the typed values of the picked key.

use super::change::{Change, frames_of, key_count};
use super::keys::Order;
use super::{Curves, is_color};
use crate::actions::Action;
use crate::document::curve::{Curve, Shift};
use crate::document::keyed::Channel;
use crate::document::{Edit, edit};
use crate::field::Number;
use crate::refusal;
use egui::{Button, Response, Ui};
use trochoid::Interpolation;

/// What can be done with the handles of keys.
#[derive(Clone, Copy)]
enum Handles {
    Smooth,
    Level,
    None,
}

impl Handles {
    const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Smooth, "Smooth handles", "Write the handles, turned onto one line"),
        (Self::Level, "Level handles", "Write the handles, turned level: the value turns at the key"),
        (Self::None, "No handles", "Remove the handles: the interpolation alone makes the curve"),
    ];

    fn of(self, curve: &Curve, frames: &[f64]) -> Curve {
        match self {
            Self::Smooth => curve.smoothed(frames, false),
            Self::Level => curve.smoothed(frames, true),
            Self::None => curve.bare(frames),
        }
    }
}

/// Draws the buttons.
pub(super) fn tools_ui(panel: &mut Curves, ui: &mut Ui, change: &mut Change<'_>) {
    ui.horizontal_wrapped(|ui| {
        for (is_sheet, name) in [(false, "Curves"), (true, "Dope sheet")] {
            if ui.selectable_label(panel.is_sheet == is_sheet, name).clicked() && panel.is_sheet != is_sheet {
                panel.is_sheet = is_sheet;
                panel.picks.clear();
            }
        }
        ui.separator();
        ui.add_enabled_ui(!change.channels.is_empty(), |ui| {
            ui.menu_button("Interpolation", |ui| interpolations_ui(panel, ui, change))
                .response
                .on_hover_text("Of the picked keys to the next ones, or of all shown");
            ui.menu_button("Handles", |ui| handles_ui(panel, ui, change))
                .response
                .on_hover_text("Of the picked keys, or of all shown");
            let key = ui.button("Set key").on_hover_text("Set a key at this frame; the curves keep their shapes (K)");
            if key.clicked() {
                panel.orders.push(Order::Insert);
            }
            let delete = ui.add_enabled(!panel.picks.is_empty(), Button::new("Delete keys"));
            if delete.on_hover_text("Delete the picked keys (Delete)").clicked() {
                panel.orders.push(Order::Delete);
            }
            if ui.button("Fit").on_hover_text("Show all keys (F)").clicked() {
                panel.orders.push(Order::Fit);
            }
        });
    });
}

fn interpolations_ui(panel: &Curves, ui: &mut Ui, change: &mut Change<'_>) {
    let picked = panel.picked(change.channels);
    let words = picked.iter().flat_map(|(channel, picks)| {
        let keys = channel.curve.keys.iter().filter(|key| picks.iter().any(|pick| pick.frame == key.frame));
        keys.map(|key| key.interpolation.unwrap_or(channel.curve.interpolation))
    });
    let words: Vec<Interpolation> = words.collect();
    for name in Interpolation::NAMES {
        let word = Interpolation::from_name(name).unwrap_or_default();
        let is_present = !words.is_empty() && words.iter().all(|known| *known == word);
        if ui.selectable_label(is_present, name).clicked() {
            change.each(panel, &format!("Set \"{name}\" at"), |curve, frames| Some(curve.interpolated(frames, word)));
            ui.close();
        }
    }
}

fn handles_ui(panel: &Curves, ui: &mut Ui, change: &mut Change<'_>) {
    for (handles, name, help) in Handles::ALL {
        if ui.button(name).on_hover_text(help).clicked() {
            change.each(panel, &format!("{name} of"), |curve, frames| Some(handles.of(curve, frames)));
            ui.close();
        }
    }
}

impl Curves {
    /// Draws the menu of a right-click in the plot.
    pub(super) fn menu_ui(&mut self, response: &Response, change: &mut Change<'_>) {
        response.context_menu(|ui| {
            ui.menu_button("Interpolation", |ui| interpolations_ui(self, ui, change));
            handles_ui(self, ui, change);
            ui.separator();
            for (name, order) in [("Set key", Order::Insert), ("Delete keys", Order::Delete), ("Fit", Order::Fit)] {
                if ui.button(name).clicked() {
                    self.orders.push(order);
                    ui.close();
                }
            }
        });
    }
}

/// Draws frame and value of the picked key, to be typed.
pub(super) fn typed_ui(panel: &mut Curves, ui: &mut Ui, channels: &[Channel], actions: &mut Vec<Action>) {
    let picked = panel.picked(channels);
    let one = match picked.as_slice() {
        [(channel, picks)] if frames_of(picks).len() == 1 => Some((*channel, picks.clone())),
        _ => None,
    };
    ui.horizontal(|ui| {
        let Some((channel, picks)) = one else {
            match key_count(&panel.picks) {
                0 => ui.weak("Click a key, or drag around some. Double-click sets one."),
                count => ui.weak(format!("{} picked", edit::count(count, "key"))),
            };
            return;
        };
        let frame = picks[0].frame;
        ui.label("Frame");
        let told = Number::new(frame).whole().range(-1e7, 1e7).ui(ui);
        let field = told.response.clone();
        field.clone().on_hover_text("Frame of the key");
        if let Some((to, gesture)) = told.given {
            match channel.curve.moved(&picks, &Shift::by(to - frame, 0.0)) {
                Some(curve) => {
                    let edit = Edit::set(channel.path.clone(), &curve.write()).merging("frame of a key");
                    gesture.tried(&field).edit(edit, actions);
                    for picked in &mut panel.picks {
                        picked.pick.frame = to;
                    }
                }
                None => {
                    let found = format_args!("found {to}; expected a frame without another key");
                    refusal::refuse(ui.ctx(), field.id, &found);
                }
            }
        }
        refusal::refusal_ui(ui, &field);
        let mut ends = field.drag_stopped() || field.lost_focus();
        let key = channel.curve.find(frame).map(|index| &channel.curve.keys[index]);
        for pick in picks.iter().filter(|_| !is_color(channel)) {
            let Some(value) = key.and_then(|key| key.numbers().get(pick.component).copied()) else { continue };
            ui.label(if picks.len() > 1 { format!("Value {}", pick.component + 1) } else { "Value".into() });
            let told = Number::new(value).ui(ui);
            let field = told.response.clone();
            field.clone().on_hover_text("Value of the key");
            if let Some((to, gesture)) = told.given {
                let mut curve = channel.curve.clone();
                if let Some(index) = curve.find(frame) {
                    curve.keys[index].set(pick.component, to);
                }
                let edit = Edit::set(channel.path.clone(), &curve.write());
                gesture.tried(&field).edit(edit.merging(format!("value {} of a key", pick.component)), actions);
            }
            refusal::refusal_ui(ui, &field);
            ends |= field.drag_stopped() || field.lost_focus();
        }
        ui.weak(format!("{}.{}", channel.owner, channel.name));
        if ends {
            actions.push(Action::Seal);
        }
    });
}
