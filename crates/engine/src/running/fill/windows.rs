//! Decides over which windows stages are filled.

use super::Fills;
use super::extent::clamped;
use crate::planning::plan::Feed;
use crate::planning::schedule::read_before;
use crate::planning::shading::{SHARING_CHANNELS, sharing_slot};
use crate::running::keep::PlaneKeeper;
use crate::running::steps::Whole;
use trochoid_graph::Slot;
use trochoid_image::Window;

impl Fills<'_> {
    /// Decides every stage's window, from the program backwards; for a later sample, only what it cannot share.
    pub(super) fn place_windows(&mut self, tile: Window, sample: usize) {
        let format = self.plan.graph.format();
        self.tile = tile;
        let is_last = self.keeper.is_none_or(PlaneKeeper::is_last_step);
        for (index, state) in self.fills.iter_mut().enumerate() {
            let is_whole = self.keeper.is_some_and(|keeper| keeper.wants(Whole::Fill(index)));
            state.need = if (state.fill.read && is_last) || is_whole { tile } else { Window::default() };
            state.tap_window = Window::default();
        }
        for index in (0..self.fills.len()).rev() {
            let (before, rest) = self.fills.split_at_mut(index);
            let Some(state) = rest.first_mut() else { continue };
            let is_shared = sample > 0 && state.fill.shared.is_some();
            let is_idle = self.keeper.is_some_and(|keeper| keeper.is_idle(index));
            if state.need.is_empty() && sample == 0 && !is_idle {
                // Filled although nothing reads it, where demand is switched off.
                state.need = tile;
            }
            if !is_shared {
                state.window = state.need;
            }
            let is_everywhere = state.fill.shared.as_ref().is_some_and(Vec::is_empty);
            let asks =
                |whole: Whole| self.keeper.map(|keeper| (keeper.wants(whole), keeper.known(whole, sample).is_some()));
            let (_, is_known) = asks(Whole::Fill(index)).unwrap_or_default();
            let (holds_taps, knows_taps) = asks(Whole::Taps(index)).unwrap_or_default();
            if holds_taps {
                state.tap_window = tile;
                for slot in read_before(state.fill) {
                    if let Some(other) = self.by_slot.get(&slot).and_then(|&index| before.get_mut(index)) {
                        other.need = other.need.union(tile);
                    }
                }
            }
            if state.need.is_empty() || is_known || (is_shared && is_everywhere) {
                continue;
            }
            let Some(stage) = state.stage else { continue };
            let own = state.own_window(state.need);
            let mut need = |slot: &Slot, window: Window| {
                if let Some(other) = self.by_slot.get(slot).and_then(|&index| before.get_mut(index)) {
                    other.need = other.need.union(window);
                }
            };
            for view in state.fill.shared.iter().flatten() {
                SHARING_CHANNELS.iter().for_each(|channel| need(&sharing_slot(*view, *channel), state.need));
            }
            for ((port, connections), images) in state.fill.inputs.iter().zip(&mut state.images) {
                let asked = if sample == 0 || !self.sharing {
                    stage.regions_of_interest(*port, own, format)
                } else {
                    stage.regions_after_find(*port, own, format)
                };
                for (feeds, image) in connections.iter().zip(images) {
                    image.region = clamped(asked, image.extent);
                    for feed in feeds {
                        match feed {
                            Feed::Slot(slot) => need(slot, image.region),
                            Feed::Tap(..) => state.tap_window = state.tap_window.union(image.region),
                            Feed::Nothing | Feed::Constant(_) => {}
                        }
                    }
                }
            }
            for slot in read_before(state.fill).filter(|_| !knows_taps) {
                need(&slot, state.tap_window);
            }
        }
    }
}
