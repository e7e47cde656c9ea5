//! Viewer commands; the viewer's toolbar offers the same functions.

use super::Viewer;
use super::compare::Mode;
use crate::actions::Switch;
use crate::state::State;

impl Viewer {
    /// Performs a viewer command.
    pub(crate) fn switch(&mut self, switch: Switch, state: &State) {
        match switch {
            Switch::Hold => self.hold(state),
            Switch::LetGo => self.compare.held = None,
            Switch::Wipe => self.compare_by(Mode::Wipe, state),
            Switch::Difference => self.compare_by(Mode::Difference, state),
            Switch::Region => self.frames_region = true,
            Switch::Hull => self.space.shown = !self.space.shown,
            Switch::Near => self.near.toggle(),
            Switch::Camera => self.scene.switch(),
            Switch::Scopes => self.scopes.shown = !self.scopes.shown,
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
