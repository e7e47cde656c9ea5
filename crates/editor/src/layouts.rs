//! Layouts of the panels that the user keeps under names.

use crate::actions::Pane;
use crate::layout;
use egui::ThemePreference;
use egui_tiles::Tree;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Maximum size of the stored list, in bytes.
const MOST_BYTES: u64 = 4 << 20;

/// The kept layouts by their names, each as it is stored for the window.
#[derive(Debug, Default)]
pub(crate) struct Layouts {
    all: BTreeMap<String, String>,
    file: Option<PathBuf>,
}

/// Why a layout cannot be shown or kept.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoLayout {
    #[error("The layout “{0}” is of another version of the editor, with other panels: delete it, and save a new one")]
    Old(String),
    #[error("The layout cannot be kept: {0}")]
    Unwritten(#[from] trochoid::OutputError),
    #[error("The layout cannot be kept: there is no folder for the editor's data")]
    NoFolder,
}

impl Layouts {
    /// Reads the layouts in the folder for the program's data.
    pub(crate) fn read(data: &Path) -> Self {
        let file = data.join("layouts.json");
        let text = trochoid::io::read_text(&file, MOST_BYTES).unwrap_or_default();
        Self { all: serde_json::from_str(&text).unwrap_or_default(), file: Some(file) }
    }

    /// Returns the names of all layouts.
    pub(crate) fn names(&self) -> Vec<String> {
        self.all.keys().cloned().collect()
    }

    /// Returns the panels of a layout.
    ///
    /// # Errors
    /// It has other panels than this version of the editor.
    pub(crate) fn panels(&self, name: &str) -> Result<Tree<Pane>, NoLayout> {
        let read = self.all.get(name).and_then(|text| layout::read(text));
        read.map(|(panels, _)| panels).ok_or_else(|| NoLayout::Old(name.into()))
    }

    /// Keeps a layout, in the place of another one with this name.
    ///
    /// # Errors
    /// The list cannot be written.
    pub(crate) fn keep(&mut self, name: String, panels: &Tree<Pane>) -> Result<(), NoLayout> {
        self.all.insert(name, layout::written(panels, (ThemePreference::System, 1.0)));
        self.write()
    }

    /// Deletes a layout.
    ///
    /// # Errors
    /// The list cannot be written.
    pub(crate) fn forget(&mut self, name: &str) -> Result<(), NoLayout> {
        self.all.remove(name);
        self.write()
    }

    fn write(&self) -> Result<(), NoLayout> {
        let file = self.file.as_deref().ok_or(NoLayout::NoFolder)?;
        let text = serde_json::to_string_pretty(&self.all).unwrap_or_default();
        Ok(trochoid::write_whole(file, text.as_bytes())?)
    }
}
