//! The space bar, which plays, or pans while it is held.

use egui::{Key, KeyboardShortcut, Modifiers};

/// The play shortcut. Holding the same key pans, so the key acts on release, see [`Space`].
pub(super) const PLAY: KeyboardShortcut = KeyboardShortcut::new(Modifiers::NONE, Key::Space);

/// State of the space bar: dragging while it is held pans; releasing it without a drag starts or stops playback.
#[derive(Debug, Default)]
pub struct Space {
    held: bool,
    dragged: bool,
}

impl Space {
    /// Processes the input since the last call; returns whether the bar was released without a drag in between.
    pub fn plays(&mut self, context: &egui::Context) -> bool {
        let typing = context.egui_wants_keyboard_input();
        context.input_mut(|input| {
            if input.key_pressed(PLAY.logical_key) && !typing && input.modifiers.is_none() && !self.held {
                *self = Self { held: true, dragged: false };
            }
            if !self.held {
                return false;
            }
            // Consumed, so that the key does not also press a focused button.
            input.consume_key(Modifiers::NONE, PLAY.logical_key);
            self.dragged |= input.pointer.any_down();
            let released = input.key_released(PLAY.logical_key);
            // If the window loses the keyboard focus, no release event arrives.
            self.held = !released && input.key_down(PLAY.logical_key);
            released && !self.dragged
        })
    }
}

/// Returns whether a drag that begins now pans: the space bar is held.
pub fn moves_view(context: &egui::Context) -> bool {
    !context.egui_wants_keyboard_input() && context.input(|input| input.key_down(PLAY.logical_key))
}
