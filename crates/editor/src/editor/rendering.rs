//! Rendering of the range to files, from the editor's side.

use super::Editor;
use crate::actions::After;
use crate::render::{Obstacle, Renderer};
use egui::Context;
use std::time::Duration;

impl Editor {
    pub(super) fn render(&mut self, context: &Context) {
        if !self.settle("Nothing was rendered") {
            return;
        }
        let Some(graph) = self.state.session.meaning().graph.clone() else {
            self.notices.warning("The document has errors: correct them before rendering");
            return;
        };
        if self.state.session.file().is_none() {
            self.notices.info("Save the document first: the names of its outputs are relative to its folder");
            return self.prompts.ask_save(&self.state.session, Some(After::Render));
        }
        match Renderer::start(graph, self.state.range, context.clone()) {
            Ok(renderer) => {
                self.state.render = Some(renderer.progress());
                self.renderer = Some(renderer);
            }
            Err(Obstacle::Refused(refused)) => self.prompts.reach(refused),
            Err(Obstacle::Because(why)) => {
                self.notices.error(why);
            }
        }
    }

    /// Ends the rendering in progress as soon as its thread notices.
    pub(crate) fn end_render(&mut self) {
        (self.renderer, self.state.render) = (None, None);
    }

    pub(super) fn hear_render(&mut self, context: &Context) {
        let Some(renderer) = &mut self.renderer else { return };
        self.state.render = Some(renderer.progress());
        let Some(outcome) = renderer.outcome() else {
            return context.request_repaint_after(Duration::from_millis(200));
        };
        self.renderer = None;
        self.state.render = None;
        match outcome {
            Ok(ended) => {
                self.notices.success(ended.to_string());
            }
            Err(error) => {
                self.notices.error(error);
            }
        }
    }

    pub(super) fn cancel_render(&self) {
        if let Some(renderer) = &self.renderer {
            renderer.cancel();
        }
    }
}
