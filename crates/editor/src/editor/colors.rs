//! Actions that change the palette of the document.

use super::Editor;
use crate::document::swatches::SwatchKey;
use crate::document::{palette, palette_file, swatches};
use serde_json::Value;

impl Editor {
    /// Adds a gray to the palette, and selects it.
    pub(super) fn add_color(&mut self) {
        let (sheet, all) = (self.state.sheet().clone(), self.state.swatches());
        match palette::within(&sheet) {
            Ok(()) => {
                let (edit, name) = palette::added(&sheet, [0.5; 3], &all);
                self.edit(edit);
                self.state.session.seal();
                self.state.colors.chosen = Some(SwatchKey::Named(name));
            }
            Err(why) => self.notices.warning(format!("A new color needs {why}")),
        }
    }

    /// Replaces colors of the palette by those of a file.
    pub(super) fn take_palette(&mut self, entries: &[(String, Value)], file: &str) {
        match palette::replaced(self.state.sheet(), &self.state.swatches(), entries) {
            Ok((edit, strange)) => {
                let is_same = edit.ops.is_empty();
                if !is_same {
                    self.edit(edit);
                    self.state.session.seal();
                    self.leave_painting();
                }
                match strange {
                    Some(names) => self
                        .notices
                        .warning(format!("{file}: took the colors whose names the document has, not those of {names}")),
                    None if is_same => self.notices.plain(format!("{file} has the document's own colors")),
                    None => {}
                }
            }
            Err(why) => self.notices.warning(format!("{file}: expected {why}")),
        }
    }

    /// Gives all colors of the document names.
    pub(super) fn name_colors(&mut self) {
        let (sheet, all) = (self.state.sheet().clone(), self.state.swatches());
        match palette::within(&sheet) {
            Ok(()) => match palette::named_all(&sheet, &all) {
                Some(edit) => {
                    self.edit(edit);
                    self.state.session.seal();
                }
                None => self.notices.warning("All colors have names"),
            },
            Err(why) => self.notices.warning(format!("Names need {why}")),
        }
    }

    /// Writes the palette that the document reads from a file into the document.
    pub(super) fn bring_palette(&mut self) {
        let session = &self.state.session;
        let Some(file) = swatches::file(session.sheet()) else {
            self.notices.warning("The document reads no palette from a file");
            return;
        };
        let path = session.folder().join(file);
        match palette_file::read(&path, swatches::space(session.sheet()), session.access()) {
            Ok(colors) => {
                self.edit(palette::brought(&colors));
                self.state.session.seal();
            }
            Err(why) => {
                self.notices.error(why);
            }
        }
    }
}
