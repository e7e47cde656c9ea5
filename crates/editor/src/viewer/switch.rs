//! Viewer commands; the viewer's toolbar offers the same functions.

use super::Viewer;
use super::compare::Mode;
use crate::actions::Switch;
use crate::state::State;
use egui::{Context, Key, Modifiers};

impl Viewer {
    /// Performs a viewer command.
    pub(crate) fn switch(&mut self, switch: Switch, state: &State) {
        match switch {
            Switch::Hold => self.hold(state),
            Switch::LetGo => self.compare.held = None,
            Switch::Wipe => self.compare_by(Mode::Wipe, state),
            Switch::Difference => self.compare_by(Mode::Difference, state),
            Switch::Region => self.frames_region = true,
            Switch::Hull => self.show_space(!self.space.shown),
            Switch::Near => self.near.toggle(),
            Switch::Orbit => self.orbit(!self.scene.steers()),
            Switch::Scopes => self.scopes.shown = !self.scopes.shown,
        }
    }

    /// Returns whether what a command switches is on; `None` if it only does something.
    pub(crate) fn is_on(&self, switch: Switch, state: &State) -> Option<bool> {
        let compares = |mode: Mode| self.compare.held.as_ref().is_some_and(|held| held.mode == mode);
        match switch {
            Switch::Hold | Switch::LetGo => None,
            Switch::Wipe => Some(compares(Mode::Wipe)),
            Switch::Difference => Some(compares(Mode::Difference)),
            Switch::Region => Some(self.frames_region || state.look.region.is_some()),
            Switch::Hull => Some(self.space.shown),
            Switch::Near => Some(self.near.shown),
            Switch::Orbit => Some(self.scene.steers()),
            Switch::Scopes => Some(self.scopes.shown),
        }
    }

    /// Shows the picture's colors within their hull, or the picture.
    pub(super) fn show_space(&mut self, shown: bool) {
        self.space.shown = shown;
        if shown {
            self.scene.steer_by(false);
        }
    }

    /// Lets drags in the picture move the camera, or no longer.
    pub(super) fn orbit(&mut self, on: bool) {
        self.scene.steer_by(on);
        if on {
            self.space.shown = false;
        }
    }

    /// Takes Esc, wherever the pointer is, to leave the mode in which drags move the camera. Whatever is being done ends
    /// first.
    pub(crate) fn take_escape(&mut self, context: &Context, state: &State) {
        let is_covered =
            egui::Popup::is_any_open(context) || context.memory(|memory| memory.top_modal_layer().is_some());
        let is_idle = state.dropper.is_none() && !is_covered && !context.text_edit_focused();
        if is_idle
            && self.scene.steers()
            && !context.input(|input| input.pointer.any_down())
            && context.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape))
        {
            self.orbit(false);
        }
    }

    /// Holds the current picture, if there is one.
    pub(super) fn hold(&mut self, state: &State) {
        if let Some(result) = &state.evaluated.result {
            let name = state.look.node.as_ref().map_or("picture", |(name, _)| name.as_str());
            self.compare.hold(name, result);
        }
    }

    /// Sets the comparison mode; if no picture is held, holds the current one.
    fn compare_by(&mut self, mode: Mode, state: &State) {
        if self.compare.held.is_none() {
            self.hold(state);
        }
        if let Some(held) = &mut self.compare.held {
            held.mode = mode;
        }
    }
}
