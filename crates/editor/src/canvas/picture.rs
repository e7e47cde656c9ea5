//! Textures of the nodes' thumbnails.

use crate::evaluate::Screen;
use crate::state::State;
use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use std::collections::HashMap;
use std::sync::Arc;

/// Uploaded thumbnails, by node.
#[derive(Default)]
pub(super) struct Pictures {
    known: HashMap<String, (Arc<Screen>, TextureHandle)>,
}

impl Pictures {
    /// Returns the thumbnail of a node, uploading it when it is first drawn.
    pub(super) fn of(&mut self, context: &Context, state: &State, name: &str) -> Option<&TextureHandle> {
        let screen = state.evaluated.thumbnails.get(name)?;
        let fresh = self.known.get(name).is_some_and(|(known, _)| Arc::ptr_eq(known, screen));
        if !fresh {
            let [width, height] = screen.size;
            if width * height == 0 || screen.pixels.len() != 4 * width * height {
                return None;
            }
            let image = ColorImage::from_rgba_unmultiplied(screen.size, &screen.pixels);
            let texture = context.load_texture(format!("picture of {name}"), image, TextureOptions::LINEAR);
            self.known.insert(name.into(), (screen.clone(), texture));
        }
        Some(&self.known.get(name)?.1)
    }

    /// Drops thumbnails of nodes that no longer exist.
    pub(super) fn tidy(&mut self, state: &State) {
        if self.known.len() > state.evaluated.thumbnails.len() {
            self.known.retain(|name, _| state.evaluated.thumbnails.contains_key(name));
        }
    }
}
