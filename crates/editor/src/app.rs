//! The native window that hosts the editor.

use crate::document::Session;
use crate::editor::Editor;
use std::path::{Path, PathBuf};

/// Reason why the editor cannot start.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The document cannot be read.
    #[error(transparent)]
    Document(trochoid::io::Error),
    /// No window can be opened: there is no display or no usable graphics driver.
    #[error(
        "no window can be opened: {0}\n  remedy: the editor needs a display and a graphics driver (Mesa will do); on a machine \
         without them, use `trochoid render`, or a virtual display such as Xvfb"
    )]
    Window(#[source] WindowError),
}

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// Nothing says where the display is.
    #[error("neither DISPLAY nor WAYLAND_DISPLAY is set")]
    NoDisplay,
    /// The display, or its driver, refused.
    #[error(transparent)]
    Refused(eframe::Error),
}

/// Storage key of the panel layout. eframe itself uses `window`.
const KEY: &str = "panels";
/// Storage key of what the viewer makes of light.
const TRANSFORM: &str = "transform";

struct App {
    editor: Editor,
    /// Title last sent to the system: it is sent only on a change, because every viewport command requests another
    /// frame.
    title: String,
    context: egui::Context,
}

impl App {
    /// Creates the app around an editor and restores the stored panel layout.
    fn new(mut editor: Editor, context: egui::Context, storage: Option<&dyn eframe::Storage>) -> Self {
        if let Some(kept) = storage.and_then(|storage| storage.get_string(KEY)) {
            editor.restore(&kept, &context);
        }
        if let Some(kept) = storage.and_then(|storage| storage.get_string(TRANSFORM)) {
            editor.restore_transform(&kept);
        }
        Self { editor, title: String::new(), context }
    }
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

    /// Keeps egui's own memory out of storage: it grows with every widget ever shown and holds nothing worth keeping.
    /// The panel layout is stored under [`KEY`].
    fn persist_egui_memory(&self) -> bool {
        false
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        storage.remove_string("egui");
        storage.set_string(KEY, self.editor.kept_window(&self.context));
        storage.set_string(TRANSFORM, self.editor.kept_transform());
    }
}

/// Opens a window on a document, or on a new one, and returns when it is closed. Documents may access the files and
/// folders in `allow` in addition to their own folder.
///
/// # Errors
/// Fails if the document cannot be read or there is no display. A document with errors in its graph still opens.
pub fn open(document: Option<&Path>, allow: &[PathBuf]) -> Result<(), OpenError> {
    let session = match document {
        Some(file) => Session::open(file).map_err(OpenError::Document)?,
        None => Session::new(crate::document::session::NEW.into(), None),
    };
    if cfg!(target_os = "linux") && !has_display() {
        return Err(OpenError::Window(WindowError::NoDisplay));
    }
    trochoid::Heap::return_large();
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("trochoid")
            .with_inner_size([1440.0, 900.0])
            .with_min_inner_size([800.0, 500.0]),
        ..eframe::NativeOptions::default()
    };
    let is_new = document.is_none();
    let (data, allow) = (eframe::storage_dir("trochoid"), allow.to_vec());
    let create = move |creation: &eframe::CreationContext<'_>| {
        let mut editor = Editor::new(&creation.egui_ctx, session, data.as_deref())?;
        editor.allow_all(&allow);
        editor.state.graphics.start();
        if is_new {
            editor.welcome();
        }
        let app: Box<dyn eframe::App> = Box::new(App::new(editor, creation.egui_ctx.clone(), creation.storage));
        Ok(app)
    };
    eframe::run_native("trochoid", options, Box::new(create))
        .map_err(|error| OpenError::Window(WindowError::Refused(error)))
}

fn has_display() -> bool {
    ["DISPLAY", "WAYLAND_DISPLAY"].into_iter().any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actions::Pane;
    use crate::layout;
    use eframe::{App as _, Storage};
    use std::collections::HashMap;

    /// In-memory storage.
    #[derive(Default)]
    struct Memory(HashMap<String, String>);

    impl Storage for Memory {
        fn get_string(&self, key: &str) -> Option<String> {
            self.0.get(key).cloned()
        }

        fn set_string(&mut self, key: &str, value: String) {
            self.0.insert(key.into(), value);
        }

        fn remove_string(&mut self, key: &str) {
            self.0.remove(key);
        }

        fn flush(&mut self) {}
    }

    fn app(storage: Option<&dyn Storage>) -> App {
        let context = egui::Context::default();
        let session = Session::new(crate::document::session::NEW.into(), None);
        let editor = Editor::new(&context, session, None).unwrap();
        App::new(editor, context, storage)
    }

    #[test]
    fn panels_and_theme_are_as_they_were_left() {
        let mut storage = Memory::default();
        let mut first = app(Some(&storage));
        assert!(first.editor.tree == layout::first(), "nothing was kept yet");
        layout::bring(&mut first.editor.tree, Pane::Report);
        assert!(first.editor.tree != layout::first());
        let context = first.context.clone();
        context.set_theme(egui::Theme::Light);
        // The zoom factor takes effect from the next frame on.
        context.set_zoom_factor(1.25);
        context.run_ui(egui::RawInput::default(), |_| {}).textures_delta.clear();
        storage.set_string("egui", "of an older run".into());
        first.save(&mut storage);
        assert!(storage.get_string("egui").is_none() && !first.persist_egui_memory());
        let mut second = app(Some(&storage));
        second.context.run_ui(egui::RawInput::default(), |_| {}).textures_delta.clear();
        assert_eq!(second.context.zoom_factor(), 1.25);
        assert!(second.editor.tree == first.editor.tree);
        assert_eq!(second.context.options(|options| options.theme_preference), egui::ThemePreference::Light);
        let context = second.context.clone();
        second.editor.act(crate::actions::Action::Layout(crate::actions::Layout::First), &context);
        second.save(&mut storage);
        assert!(app(Some(&storage)).editor.tree == layout::first(), "what was reset stays so");
    }

    #[test]
    fn a_layout_that_is_damaged_or_of_another_version_is_replaced_by_the_default() {
        let mut tree = layout::first();
        layout::bring(&mut tree, Pane::Text);
        let whole = layout::written(&tree, (egui::ThemePreference::Dark, 1.0));
        assert!(layout::read(&whole).is_some_and(|(read, _)| read == tree));
        let without = |pane: Pane| {
            let mut tree = layout::first();
            let tile = tree.tiles.find_pane(&pane).unwrap();
            tree.remove_recursively(tile);
            layout::written(&tree, (egui::ThemePreference::Dark, 1.0))
        };
        let doubled = {
            let mut tree = layout::first();
            let tile = tree.tiles.find_pane(&Pane::Text).unwrap();
            tree.tiles.insert(tile, egui_tiles::Tile::Pane(Pane::Waves));
            layout::written(&tree, (egui::ThemePreference::Dark, 1.0))
        };
        let looped = {
            let mut tree = layout::first();
            let root = tree.root.unwrap();
            if let Some(egui_tiles::Tile::Container(container)) = tree.tiles.get_mut(root) {
                container.add_child(root);
            }
            layout::written(&tree, (egui::ThemePreference::Dark, 1.0))
        };
        // What is only older gets the panels that are new.
        let older = layout::read(&without(Pane::Report)).map(|(tree, _)| tree).unwrap();
        assert!(older != layout::first() && older.tiles.find_pane(&Pane::Report).is_some());
        let damaged = [
            String::new(),
            "{}".into(),
            whole[..whole.len() / 2].into(),
            whole.replace("\"version\":1", "\"version\":0"),
            whole.replace("Report", "Ledger"),
            whole.replace("1.44", "-1.44"),
            without(Pane::Properties),
            doubled,
            looped,
        ];
        for text in damaged {
            assert!(text != whole, "nothing was damaged");
            let mut storage = Memory::default();
            storage.set_string(KEY, text.clone());
            assert!(app(Some(&storage)).editor.tree == layout::first(), "{text}");
        }
    }
}
