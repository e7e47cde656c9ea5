//! Commands on the scene in the viewer.

use super::{Command, command, seen};
use crate::actions::{Action, Switch};
use egui::Key;

/// These commands, in menu order.
pub(super) static SCENE: &[Command] = &[command(
    "Viewer",
    "Orbit",
    None,
    "Orbit, pan and dolly the camera of the picture by dragging in it.",
    |_| Action::Viewer(Switch::Orbit),
    seen,
)
.over_viewer(Key::C)];
