//! The second viewer: what the first one does, for another picture, and after it.

use super::Editor;
use super::pictures::LastRequest;
use crate::evaluate::Lane;
use crate::state::Evaluated;

/// State of the second viewer that the first one has, too.
pub(super) struct Second {
    asked: LastRequest,
    /// The viewed result, if it was deleted.
    lost: Option<(String, usize)>,
}

impl Default for Second {
    fn default() -> Self {
        let asked = LastRequest { generation: Lane::SECOND, ..LastRequest::default() };
        Self { asked, lost: None }
    }
}

impl Editor {
    /// Does something with the second viewer in the place of the first one.
    pub(super) fn on_second(&mut self, act: impl FnOnce(&mut Self)) {
        self.turn();
        act(self);
        self.turn();
    }

    fn turn(&mut self) {
        self.state.turn();
        std::mem::swap(&mut self.asked, &mut self.second.asked);
        std::mem::swap(&mut self.lost, &mut self.second.lost);
        std::mem::swap(&mut self.panels.viewer, &mut self.panels.second.viewer);
    }

    /// Requests whatever the second viewer lacks, if it is seen. During playback it keeps its picture: all time is for the
    /// frames of the first one.
    pub(super) fn ask_second(&mut self) {
        if !std::mem::take(&mut self.panels.second.is_seen) {
            self.forget_second();
        } else if !self.state.playing {
            if self.state.second.look.node.is_none() && self.state.look.node.is_some() {
                self.state.second.look.node.clone_from(&self.state.look.node);
                self.state.read_insides();
            }
            self.on_second(|editor| {
                editor.ask();
                editor.ask_held();
                editor.ask_blame();
            });
        }
    }

    /// Stops evaluating for the second viewer, and frees its pictures.
    pub(super) fn forget_second(&mut self) {
        let seen = &mut self.state.second.evaluated;
        if self.second.asked.what.take().is_some() || seen.result.is_some() || seen.last.is_some() {
            *seen = Evaluated::default();
            self.worker.stop(Lane::Second);
            // Pictures that are still on their way are not shown.
            self.second.asked.generation += 1;
        }
    }
}
