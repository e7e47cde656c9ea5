//! Commands of the help.

use super::{Command, NONE, always, command, keys};
use crate::actions::{Action, HelpPage};
use egui::Key;

/// These commands, in menu order.
pub(super) static HELP: &[Command] = &[
    command(
        "Help",
        "Help on the node",
        keys(NONE, Key::F1),
        "Explain the type of the selected node; without one, show all pages.",
        |state| {
            let node = state.chosen().and_then(|name| state.sheet().node(name)).filter(|node| node.side.is_none());
            Action::Help(node.map_or(HelpPage::Contents, |node| HelpPage::Node(node.ty.clone())))
        },
        always,
    ),
    command("Help", "Contents", None, "Show all pages of the help.", |_| Action::Help(HelpPage::Contents), always),
    command(
        "Help",
        "Keys",
        keys(NONE, Key::Questionmark),
        "Show all keys and commands.",
        |_| Action::Help(HelpPage::Keys),
        always,
    ),
];
