//! Commands on the scene in the viewer.

use super::{Command, command, seen};
use crate::actions::{Action, Switch};

/// These commands, in menu order.
pub(super) static SCENE: &[Command] = &[command(
    "Viewer",
    "Move the camera",
    None,
    "Orbit, pan and dolly the camera of the picture by dragging in it (C).",
    |_| Action::Viewer(Switch::Camera),
    seen,
)];
