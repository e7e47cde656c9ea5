//! The editor without a screen: laid out and tessellated as it would be for the graphics driver.

use egui::{Context, Event, RawInput, Rect, pos2, vec2};
use std::time::{Duration, Instant};
use trochoid_editor::document::Session;
use trochoid_editor::editor::Editor;

pub(crate) struct Window {
    pub(crate) context: Context,
    pub(crate) editor: Editor,
}

impl Window {
    pub(crate) fn new(session: Session) -> std::io::Result<Self> {
        let context = Context::default();
        let editor = Editor::new(&context, session, None)?;
        Ok(Self { context, editor })
    }

    /// Draws once, and says how long that took.
    pub(crate) fn draw(&mut self, events: Vec<Event>) -> Duration {
        let screen_rect = Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(1920.0, 1080.0)));
        let input = RawInput { screen_rect, events, ..RawInput::default() };
        let started = Instant::now();
        let mut output = self.context.run_ui(input, |ui| self.editor.ui(ui));
        output.textures_delta.clear();
        let shapes = self.context.tessellate(output.shapes, output.pixels_per_point);
        std::hint::black_box(shapes.len());
        started.elapsed()
    }

    /// Draws as a window does, whenever a frame is asked for, until something holds.
    pub(crate) fn until(&mut self, holds: impl Fn(&Editor) -> bool) -> Duration {
        let started = Instant::now();
        while !holds(&self.editor) {
            if self.context.has_requested_repaint() {
                self.draw(Vec::new());
            }
            std::thread::sleep(Duration::from_micros(200));
        }
        started.elapsed()
    }

    /// Draws for a while: what comes after a picture, such as small ones of the nodes, is over then.
    pub(crate) fn rest(&mut self) {
        let started = Instant::now();
        self.until(|_| started.elapsed() > Duration::from_secs(1));
    }

    pub(crate) fn finished(&mut self) -> Duration {
        self.until(|editor| editor.state().evaluated.progress.is_none() && editor.state().evaluated.result.is_some())
    }
}
