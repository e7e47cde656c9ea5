//! Commands on groups.

use super::{COMMAND, Command, NONE, SHIFTED, chosen, command, keys};
use crate::actions::Action;
use egui::Key;

/// These commands, in menu order.
pub(super) static GROUPS: &[Command] = &[
    command(
        "Graph",
        "Group",
        keys(COMMAND, Key::G),
        "Make a group of the selected nodes, and a use of it in their place.",
        |_| Action::Group,
        chosen,
    )
    .begins(),
    command(
        "Graph",
        "Unpack",
        keys(SHIFTED, Key::G),
        "Put the nodes of the selected use of a group in its place.",
        |_| Action::Unpack,
        |state| state.chosen_use().is_some(),
    ),
    command(
        "Graph",
        "Enter group",
        keys(NONE, Key::Enter),
        "Show the inside of the selected use of a group (same as double-clicking it).",
        |state| Action::Enter(state.scope.iter().cloned().chain(state.chosen_use().map(String::from)).collect()),
        |state| state.chosen_use().is_some(),
    ),
    command(
        "Graph",
        "Leave group",
        None,
        "Show what is around the group that is entered (Esc).",
        |state| Action::Enter(state.scope[..state.scope.len().saturating_sub(1)].to_vec()),
        |state| !state.scope.is_empty(),
    ),
    command(
        "Graph",
        "Make local",
        None,
        "Copy the group of an included file into the document, to change it here.",
        |_| Action::MakeLocal,
        |state| state.foreign().is_some(),
    ),
];
