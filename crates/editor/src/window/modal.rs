//! Parts shared by the prompts.

use egui::{RichText, Ui};

/// Starts a prompt with a title.
pub(super) fn titled(ui: &mut Ui, title: &str) {
    // A constant width, so that nothing moves under the pointer.
    ui.set_width(460.0);
    ui.label(RichText::new(title).heading());
    ui.add_space(4.0);
}

/// Draws a row of buttons; returns the label of the one that was clicked.
pub(super) fn answer_ui<'w>(ui: &mut Ui, words: &[&'w str]) -> Option<&'w str> {
    let clicked = |ui: &mut Ui| words.iter().copied().filter(|word| ui.button(*word).clicked()).last();
    ui.horizontal(clicked).inner
}
