//! Commands that arrange the panels; in the menus, the list of layouts stands for them.

use super::{Command, always, command};
use crate::actions::{Action, Layout};

/// These commands, in menu order.
pub(super) static LAYOUTS: &[Command] = &[
    command(
        "Window",
        "Default layout",
        None,
        "Arrange the panels as in the beginning.",
        |_| Action::Layout(Layout::First),
        always,
    ),
    command(
        "Window",
        "Painting layout",
        None,
        "Arrange the panels for colors: a large picture, and the palette beside it.",
        |_| Action::Layout(Layout::Painting),
        always,
    ),
    command(
        "Window",
        "Animation layout",
        None,
        "Arrange the panels for movement: picture and graph side by side, above wide panels.",
        |_| Action::Layout(Layout::Animation),
        always,
    ),
    command(
        "Window",
        "Save layout …",
        None,
        "Keep the arrangement of the panels under a name.",
        |_| Action::NameLayout,
        always,
    ),
];
