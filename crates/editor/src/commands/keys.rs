//! How the keys of commands are written.

use super::Command;
use egui::{Context, Key, KeyboardShortcut};

impl Command {
    /// Returns the keys of the command as they stand on a keyboard; empty if it has none.
    pub fn written_keys(&self, context: &Context) -> String {
        self.keys.map_or(String::new(), |keys| written(context, &keys))
    }

    /// Returns what the command does, and where its keys count.
    pub fn whole_help(&self) -> String {
        match self.over_viewer {
            true => format!("{} Its key counts while the pointer is over the viewer.", self.help),
            false => self.help.into(),
        }
    }
}

/// Returns keys with the sign of the last one, such as ] instead of its name.
fn written(context: &Context, keys: &KeyboardShortcut) -> String {
    let (text, key) = (context.format_shortcut(keys), keys.logical_key);
    let sign = match key {
        // The triangles of the interface's font mean playback in the timeline.
        Key::ArrowLeft => "←",
        Key::ArrowRight => "→",
        key => key.symbol_or_name(),
    };
    match text.strip_suffix(key.name()) {
        Some(modifiers) => format!("{modifiers}{sign}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::commands;

    #[test]
    fn keys_are_written_as_on_a_keyboard() {
        let context = Context::default();
        context.set_os(egui::os::OperatingSystem::Nix);
        let of = |name: &str| commands().find(|command| command.name == name).unwrap().written_keys(&context);
        assert_eq!(of("Next key"), "]");
        assert_eq!(of("Dot"), ".");
        assert_eq!(of("Keys"), "?");
        assert_eq!(of("Next frame"), "→");
        assert_eq!(of("Group"), "Ctrl+G");
        assert_eq!(of("Hull"), "H");
        assert_eq!(of("Extract"), "");
        // Every other key is a letter, or called as it is on keyboards.
        let named = ["Delete", "Tab", "Space", "Home", "End", "Enter", "F1"];
        for command in commands() {
            let keys = command.written_keys(&context);
            let last = keys.rsplit('+').next().unwrap_or_default();
            assert!(last.chars().count() <= 1 || named.contains(&last), "{}: {keys}", command.name);
        }
    }
}
