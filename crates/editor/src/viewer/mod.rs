//! The picture.

use crate::actions::Action;
use crate::state::State;
use egui::Ui;

/// What the viewer holds besides what all see.
#[derive(Default)]
pub struct Viewer {}

/// Draws the picture.
pub fn viewer_ui(_viewer: &mut Viewer, ui: &mut Ui, state: &State, _actions: &mut Vec<Action>) {
    match &state.seen.failed {
        Some(why) => ui.label(why),
        None => ui.label(format!("{:?}", state.seen.result.as_ref().map(|result| result.format))),
    };
}
