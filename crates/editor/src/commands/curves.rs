//! Commands of keyed values.

use super::{Command, NONE, command, keys};
use crate::actions::Action;
use egui::Key;

/// Commands of keyed values, in menu order.
pub(super) static CURVES: &[Command] = &[
    command(
        "Viewer",
        "Next key",
        keys(NONE, Key::CloseBracket),
        "Go to the next frame with a key of the selected nodes, or of any.",
        |state| Action::Frame(state.next_key(true).unwrap_or(state.frame)),
        |state| state.next_key(true).is_some(),
    )
    .begins(),
    command(
        "Viewer",
        "Previous key",
        keys(NONE, Key::OpenBracket),
        "Go to the previous frame with a key of the selected nodes, or of any.",
        |state| Action::Frame(state.next_key(false).unwrap_or(state.frame)),
        |state| state.next_key(false).is_some(),
    ),
];
