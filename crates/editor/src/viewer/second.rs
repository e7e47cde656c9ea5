//! The second viewer: a viewer with a subject and a display of its own, beside the first one.

use super::{Viewer, viewer_ui};
use crate::actions::Action;
use crate::evaluate::Lane;
use crate::state::State;
use egui::Ui;

/// State of the second viewer.
pub(crate) struct SecondViewer {
    pub(crate) viewer: Viewer,
    /// Whether it was drawn since it was last asked; what is not drawn is not evaluated.
    pub(crate) is_seen: bool,
}

impl Default for SecondViewer {
    fn default() -> Self {
        let mut viewer = Viewer { is_second: true, ..Viewer::default() };
        viewer.compare.count_from(Lane::SECOND);
        Self { viewer, is_seen: false }
    }
}

/// Draws the second viewer.
pub(crate) fn second_ui(
    first: &mut Viewer,
    second: &mut SecondViewer,
    ui: &mut Ui,
    state: &mut State,
    actions: &mut Vec<Action>,
) {
    second.is_seen = true;
    // Keys that were pressed over it are for it.
    let mut own = Vec::new();
    if ui.rect_contains_pointer(ui.available_rect_before_wrap()) {
        own.extend(actions.extract_if(.., |action| matches!(action, Action::Slot(_) | Action::Frames)));
    }
    if second.viewer.is_locked {
        second.viewer.view = first.view;
    }
    let before = second.viewer.view;
    ui.push_id("second", |ui| {
        state.turn();
        viewer_ui(&mut second.viewer, ui, state, &mut own);
        state.turn();
    });
    if second.viewer.is_locked && second.viewer.view != before {
        first.view = second.viewer.view;
        // The first one may have been drawn already.
        ui.ctx().request_repaint();
    }
    actions.extend(own.into_iter().filter_map(|action| match action {
        // The palette marks what the first one shows.
        Action::Hover(_) => None,
        action if action.is_of_viewer() => Some(Action::Second(action.into())),
        action => Some(action),
    }));
}
