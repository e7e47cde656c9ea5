//! What keys of the keyboard do while the pointer is over the panel.

use super::change::{Change, NewCurves, frames_of, key_count};
use super::view::Screen;
use super::{Curves, Picked, Spot, whole};
use crate::actions::Action;
use crate::document::change::style;
use crate::document::color::hex;
use crate::document::curve::{Curve, Key as CurveKey};
use crate::document::keyed::Channel;
use crate::document::{edit, swatches};
use egui::{Context, Event, Key, Modifiers, Pos2, Ui};
use serde_json::Value;

/// What a key of the keyboard asks for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Order {
    Delete,
    Fit,
    Insert,
    Corner,
    All,
    Copy,
    Cut,
    Paste(String),
    Cancel,
}

impl Curves {
    /// Takes the keys that mean something here before commands do, if the pointer is over the panel.
    pub(crate) fn take_keys(&mut self, context: &Context) {
        let pass = context.cumulative_pass_nr();
        let drawn = self.area.filter(|(_, drawn)| drawn + 2 >= pass).map(|(rect, _)| rect);
        let at = context.input(|input| input.pointer.latest_pos());
        let is_over = drawn.zip(at).is_some_and(|(rect, at)| rect.contains(at));
        let is_covered =
            egui::Popup::is_any_open(context) || context.memory(|memory| memory.top_modal_layer().is_some());
        if self.drag.is_some() && context.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape)) {
            self.orders.push(Order::Cancel);
        }
        if !is_over || is_covered || context.text_edit_focused() {
            return;
        }
        let orders = &mut self.orders;
        context.input_mut(|input| {
            let plain = [
                (Key::Delete, Order::Delete),
                (Key::Backspace, Order::Delete),
                (Key::F, Order::Fit),
                (Key::K, Order::Insert),
                (Key::V, Order::Corner),
            ];
            for (key, order) in plain {
                if input.modifiers.is_none() && input.consume_key(Modifiers::NONE, key) {
                    orders.push(order);
                }
            }
            if input.consume_key(Modifiers::COMMAND, Key::A) {
                orders.push(Order::All);
            }
            input.events.retain(|event| {
                let order = match event {
                    Event::Copy => Order::Copy,
                    Event::Cut => Order::Cut,
                    Event::Paste(text) => Order::Paste(text.clone()),
                    _ => return true,
                };
                orders.push(order);
                false
            });
        });
    }

    /// Does what keys asked for.
    pub(super) fn keys_ui(&mut self, ui: &Ui, change: &mut Change<'_>) {
        for order in std::mem::take(&mut self.orders) {
            match order {
                Order::Delete => self.delete(change),
                Order::Fit => self.view = None,
                Order::Insert => self.insert(change),
                Order::Corner => self.turn_corners(change),
                Order::All => {
                    let of = |channel: &Channel| -> Vec<Picked> {
                        channel.curve.keys.iter().flat_map(|key| whole(channel, key.frame)).collect()
                    };
                    self.picks = self.shown(change.channels).into_iter().flat_map(of).collect();
                }
                Order::Copy | Order::Cut => {
                    if let Some(text) = self.copied(change.channels) {
                        ui.ctx().copy_text(text);
                        if order == Order::Cut {
                            self.delete(change);
                        }
                    }
                }
                Order::Paste(text) => self.paste(&text, change),
                Order::Cancel => self.cancel(change),
            }
        }
    }

    /// Deletes the picked keys.
    pub(super) fn delete(&mut self, change: &mut Change<'_>) {
        let picked = self.picked(change.channels);
        let left =
            picked.iter().map(|(channel, picks)| (channel.path.clone(), channel.curve.without(&frames_of(picks))));
        let left: NewCurves = left.collect();
        change.make(format!("Delete {}", edit::count(key_count(&self.picks), "key")), &left);
    }

    /// Lets the handles of picked keys be moved one by one, or, if those of one already are, turns them onto one line.
    fn turn_corners(&mut self, change: &mut Change<'_>) {
        let mut keys = Vec::new();
        for (channel, picks) in self.picked(change.channels) {
            let frames = frames_of(&picks);
            keys.extend(channel.curve.keys.iter().filter(|key| frames.contains(&key.frame)).map(|key| (channel, key)));
        }
        if keys.iter().any(|(channel, key)| self.is_corner(channel, key)) {
            self.corners.clear();
            change.each(self, "Smooth handles of", |curve, frames| Some(curve.smoothed(frames, false)));
        } else {
            self.corners.extend(keys.iter().map(|(channel, key)| (channel.path.clone(), key.frame)));
        }
    }

    /// Sets a key at the current frame in the values with picked keys, or in all that are shown, without a change of their
    /// shapes.
    pub(super) fn insert(&mut self, change: &mut Change<'_>) {
        let frame = change.frame as f64;
        let channels: Vec<&Channel> = self.targets(change.channels);
        self.insert_into(&channels, frame, change);
    }

    fn insert_into(&self, channels: &[&Channel], frame: f64, change: &mut Change<'_>) {
        let inserted = |curve: &Curve| {
            // Of colors, only the one at the frame is known, and none if keys name others.
            let is_color = curve.keys.iter().any(|key| key.value.is_string());
            let color = if is_color { swatches::shown(&curve.write(), change.space, frame).map(hex) } else { None };
            match color {
                Some(color) if curve.find(frame).is_none() => curve.with(frame, &color.into()),
                None if !is_color => curve.inserted(frame),
                _ => curve.clone(),
            }
        };
        let new: NewCurves =
            channels.iter().map(|channel| (channel.path.clone(), Some(inserted(&channel.curve)))).collect();
        change.make(format!("Set a key at frame {frame}"), &new);
    }

    /// Sets a key where the pointer is: in the row there, or in the nearest curve.
    pub(super) fn insert_at(&self, at: Pos2, screen: &Screen, spots: &[Spot], change: &mut Change<'_>) {
        if spots.iter().any(|spot| spot.place.distance(at) < 8.0) {
            return;
        }
        let frame = screen.at(at)[0].round();
        let channels: Vec<&Channel> = match self.is_sheet {
            true => self.row_at(change.channels, screen, at.y).iter().collect(),
            false => self.nearest(change.channels, screen, at, change.space).into_iter().collect(),
        };
        self.insert_into(&channels, frame, change);
    }

    /// Returns the values with picked keys, or all that are shown.
    fn targets<'c>(&self, channels: &'c [Channel]) -> Vec<&'c Channel> {
        let picked: Vec<&Channel> = self.picked(channels).into_iter().map(|(channel, _)| channel).collect();
        if picked.is_empty() { self.shown(channels) } else { picked }
    }

    /// Returns the picked keys as JSON: one keyed value, or a list of some.
    fn copied(&self, channels: &[Channel]) -> Option<String> {
        let of = |(channel, picks): (&Channel, Vec<_>)| {
            let frames = frames_of(&picks);
            let keys: Vec<CurveKey> =
                channel.curve.keys.iter().filter(|key| frames.contains(&key.frame)).cloned().collect();
            Curve { keys, interpolation: channel.curve.interpolation }.write()
        };
        let curves: Vec<Value> = self.picked(channels).into_iter().map(of).collect();
        match curves.as_slice() {
            [] => None,
            [one] => Some(style(one)),
            several => Some(style(&several.into())),
        }
    }

    /// Pastes keys, the first of them at the current frame.
    fn paste(&mut self, text: &str, change: &mut Change<'_>) {
        let value = serde_json::from_str::<Value>(text).unwrap_or_default();
        let written =
            if let Value::Array(several) = &value { several.as_slice() } else { std::slice::from_ref(&value) };
        let curves: Vec<Curve> = written.iter().filter_map(Curve::read).collect();
        let first = curves.iter().flat_map(|curve| &curve.keys).map(|key| key.frame).reduce(f64::min);
        let Some(first) = first.filter(|_| curves.len() == written.len()) else {
            let text = "The clipboard contains no keys: copy keys here, or write { \"keys\": [[frame, value], …] }";
            change.actions.push(Action::Notice(text.into()));
            return;
        };
        let by = change.frame as f64 - first;
        let targets = self.targets(change.channels);
        // One curve goes to all values; several go to as many, in order.
        let new = targets.iter().enumerate().filter_map(|(index, channel)| {
            let pasted = if let [one] = curves.as_slice() { one } else { curves.get(index)? };
            Some((channel.path.clone(), Some(channel.curve.joined(pasted, by))))
        });
        let new: NewCurves = new.collect();
        let count = curves.iter().map(|curve| curve.keys.len()).sum();
        change.make(format!("Paste {}", edit::count(count, "key")), &new);
    }
}
