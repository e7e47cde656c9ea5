//! What questions share.

use egui::{RichText, Ui};

/// Begins a question.
pub(super) fn titled(ui: &mut Ui, title: &str) {
    // As wide whatever stands in it: nothing moves under the hand.
    ui.set_width(460.0);
    ui.label(RichText::new(title).heading());
    ui.add_space(4.0);
}

/// Buttons with these words side by side; the one that was clicked.
pub(super) fn answer_ui<'w>(ui: &mut Ui, words: &[&'w str]) -> Option<&'w str> {
    let clicked = |ui: &mut Ui| words.iter().copied().filter(|word| ui.button(*word).clicked()).last();
    ui.horizontal(clicked).inner
}
