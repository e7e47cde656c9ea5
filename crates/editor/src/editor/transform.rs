//! What the viewers make of light is remembered from run to run, and from document to document.

use super::Editor;
use crate::evaluate::Display;
use crate::transform::{KeptTransform, Transform};

impl Editor {
    /// Returns what the first viewer makes of light, for storage.
    pub fn kept_transform(&self) -> String {
        serde_json::to_string(&self.state.look.display.transform.kept()).unwrap_or_default()
    }

    /// Restores what is made of light; an unreadable text is ignored.
    pub fn restore_transform(&mut self, kept: &str) {
        let Ok(kept) = serde_json::from_str::<KeptTransform>(kept) else { return };
        match kept.restored() {
            Ok(transform) => self.show_through(&transform),
            Err(why) => self.notices.warning(format!("The viewer shows colors as sRGB: {}: {why}", kept.name())),
        }
    }

    /// Shows both viewers' pictures through a transform.
    pub(super) fn show_through(&mut self, transform: &Transform) {
        let state = &mut self.state;
        for look in [&mut state.look, &mut state.second.look] {
            look.display = Display { transform: transform.clone(), ..look.display.clone() };
        }
    }
}
