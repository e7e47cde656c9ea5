//! What commands do in the viewer; its own line above the picture has the same.

use super::Viewer;
use super::compare::Mode;
use crate::actions::Switch;
use crate::state::State;

impl Viewer {
    /// Changes what a command says.
    pub(crate) fn switch(&mut self, switch: Switch, state: &State) {
        match switch {
            Switch::Hold => self.hold(state),
            Switch::LetGo => self.compare.held = None,
            Switch::Wipe => self.compare_by(Mode::Wipe, state),
            Switch::Difference => self.compare_by(Mode::Difference, state),
            Switch::Region => self.frames_region = true,
            Switch::Hull => self.space.shown = !self.space.shown,
            Switch::Near => self.near.toggle(),
        }
    }

    /// Holds the present picture, if there is one.
    pub(super) fn hold(&mut self, state: &State) {
        if let Some(result) = &state.evaluated.result {
            let name = state.look.node.as_ref().map_or("picture", |(name, _)| name.as_str());
            self.compare.hold(name, result);
        }
    }

    /// Compares with what is held, or else with the present picture, which is held from now on.
    fn compare_by(&mut self, mode: Mode, state: &State) {
        if self.compare.held.is_none() {
            self.hold(state);
        }
        if let Some(held) = &mut self.compare.held {
            held.mode = mode;
        }
    }
}
