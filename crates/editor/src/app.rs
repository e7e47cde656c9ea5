//! The window of the system around the editor.

use crate::document::Session;
use crate::editor::Editor;
use std::path::Path;

/// Why the editor cannot run.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The document cannot be read.
    #[error("{0}")]
    Document(String),
    /// There is no display, or no way to draw on it.
    #[error(
        "no window can be opened: {0}\n  remedy: the editor needs a display and a graphics driver (Mesa will do); on a machine \
         without, use `trochoid render`, or a virtual display such as Xvfb"
    )]
    Window(String),
}

struct App {
    editor: Editor,
    /// As the system was told last: it may not tell, and every command asks for another frame.
    title: String,
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        let asks_to_close = context.input(|input| input.viewport().close_requested());
        if asks_to_close && !self.editor.is_closing() {
            context.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.editor.close(&context);
        }
        self.editor.ui(ui);
        let title = self.editor.title();
        if self.title != title {
            context.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

/// Opens a window on a document, or on a new one, and returns when it is closed.
///
/// # Errors
/// The document cannot be read, or there is no display. A document with faults opens.
pub fn open(document: Option<&Path>) -> Result<(), OpenError> {
    let session = match document {
        Some(file) => Session::open(file).map_err(OpenError::Document)?,
        None => Session::new(crate::document::session::NEW.into(), None),
    };
    if cfg!(target_os = "linux") && !has_display() {
        return Err(OpenError::Window("neither DISPLAY nor WAYLAND_DISPLAY is set".into()));
    }
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("trochoid")
            .with_inner_size([1440.0, 900.0])
            .with_min_inner_size([800.0, 500.0]),
        ..eframe::NativeOptions::default()
    };
    let data = eframe::storage_dir("trochoid");
    let create = move |creation: &eframe::CreationContext<'_>| {
        let editor = Editor::new(&creation.egui_ctx, session, data.as_deref())?;
        let app: Box<dyn eframe::App> = Box::new(App { editor, title: String::new() });
        Ok(app)
    };
    eframe::run_native("trochoid", options, Box::new(create)).map_err(|error| OpenError::Window(error.to_string()))
}

fn has_display() -> bool {
    ["DISPLAY", "WAYLAND_DISPLAY"].into_iter().any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()))
}
