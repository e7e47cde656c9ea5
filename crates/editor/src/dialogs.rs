//! Dialogs that choose files, alike in all panels.

use egui::{Align2, Context, Id, Vec2};
use egui_file_dialog::FileDialog;

/// Returns a dialog to set up. It has no search field, whose ground is black in the light theme too.
pub(crate) fn dialog() -> FileDialog {
    FileDialog::new().show_search(false).anchor(Align2::CENTER_CENTER, Vec2::ZERO)
}

/// Draws an open dialog. While it is open, keys are its own.
pub(crate) fn show(dialog: &mut FileDialog, context: &Context) {
    dialog.update(context);
    let frame = context.cumulative_frame_nr();
    context.data_mut(|data| data.insert_temp(id(), frame));
}

/// Returns whether a dialog was drawn in this frame or the last one.
pub(crate) fn is_shown(context: &Context) -> bool {
    let last = context.data(|data| data.get_temp::<u64>(id()));
    last.is_some_and(|last| last + 1 >= context.cumulative_frame_nr())
}

fn id() -> Id {
    Id::new("file dialog")
}
