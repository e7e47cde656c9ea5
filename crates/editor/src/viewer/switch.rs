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
            Switch::Camera => Some(self.scene.steers()),
            Switch::Scopes => Some(self.scopes.shown),
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
