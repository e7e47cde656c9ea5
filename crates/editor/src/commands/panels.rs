//! Commands that show panels, and the theme of all of them.

use super::{Command, always, command};
use crate::actions::{Action, Pane};

/// These commands, in menu order.
pub(super) static PANELS: &[Command] = &[
    command("Window", "Show viewer", None, "Show the picture.", |_| Action::Panel(Pane::Viewer), always),
    command(
        "Window",
        "Show viewer 2",
        None,
        "Show another picture beside the first one.",
        |_| Action::Panel(Pane::Second),
        always,
    ),
    command("Window", "Show graph", None, "Show the graph.", |_| Action::Panel(Pane::Canvas), always),
    command(
        "Window",
        "Show properties",
        None,
        "Show knobs and connections.",
        |_| Action::Panel(Pane::Properties),
        always,
    ),
    command(
        "Window",
        "Show palette",
        None,
        "Show the colors of the document.",
        |_| Action::Panel(Pane::Palette),
        always,
    ),
    command(
        "Window",
        "Show curves",
        None,
        "Show keyed knobs as curves, or as a dope sheet.",
        |_| Action::Panel(Pane::Curves),
        always,
    ),
    command(
        "Window",
        "Show waves",
        None,
        "Show the waves of the selected sea.",
        |_| Action::Panel(Pane::Waves),
        always,
    ),
    command(
        "Window",
        "Show report",
        None,
        "Show timings, and which nodes are left out.",
        |_| Action::Panel(Pane::Report),
        always,
    ),
    command("Window", "Show text", None, "Show the document's text.", |_| Action::Panel(Pane::Text), always),
    command("Window", "Show help", None, "Show the manual.", |_| Action::Panel(Pane::Help), always),
    command("Window", "Switch theme", None, "Switch between the dark and the light theme.", |_| Action::Theme, always)
        .begins(),
];
