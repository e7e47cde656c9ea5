//! Files that are dropped on the window.

use super::Editor;
use crate::actions::After;
use crate::document::dropped::{Dropped, added, kind};
use crate::document::palette;
use egui::{Context, Pos2};
use serde_json::Value;
use std::path::{Path, PathBuf};

impl Editor {
    /// Uses the files that were dropped in this frame.
    pub(super) fn take_dropped(&mut self, context: &Context) {
        let (files, at) = context.input(|input| {
            let files: Vec<PathBuf> = input.raw.dropped_files.iter().map(|file| file.path().to_path_buf()).collect();
            (files, input.pointer.latest_pos())
        });
        if files.is_empty() {
            return;
        }
        if self.prompts.is_open() {
            self.notices.warning("Answer the open question first, then drop the file again");
            return;
        }
        if !self.settle("Nothing was dropped") {
            return;
        }
        let mut names = Vec::new();
        for (index, file) in files.iter().enumerate() {
            names.extend(self.take_file(file, at.map(|at| at + egui::vec2(20.0, 20.0) * index as f32), context));
            // The question about the first one comes before all others.
            if self.prompts.is_open() && index + 1 < files.len() {
                self.notices.warning("Only the first file was taken: drop the others one by one");
                break;
            }
        }
        if !names.is_empty() {
            self.state.session.seal();
            self.state.selection = names.into_iter().collect();
            self.state.output = None;
        }
    }

    /// Uses a file that was dropped at a place on the screen; returns the name of the node that was added.
    fn take_file(&mut self, file: &Path, at: Option<Pos2>, context: &Context) -> Option<String> {
        let is_editable = self.state.session.meaning().readable;
        match kind(file, self.state.sheet()) {
            Ok(Dropped::Document) => self.leave(After::Open(file.into()), context),
            Ok(_) if !is_editable => self.notices.error("The text is not JSON: correct it in the Text panel first"),
            Ok(Dropped::Palette(colors)) => {
                let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                self.prompts.take_palette(name, colors);
            }
            Ok(Dropped::Read(declaration)) => {
                let session = &self.state.session;
                let place = self.panels.canvas.free_place(self.state.sheet(), at);
                let outside = session.access().check(file).is_err();
                match added(self.state.sheet(), declaration, file, &session.folder(), place) {
                    Ok((edit, name)) => {
                        self.rewire(edit);
                        self.state.session.seal();
                        if outside {
                            let text = format!(
                                "{} is outside of the folders that the document may read: view {name}, and allow it there",
                                file.display()
                            );
                            self.notices.info(text);
                        }
                        return Some(name);
                    }
                    Err(why) => self.notices.error(why),
                }
            }
            Err(why) => self.notices.error(why),
        }
        None
    }

    /// Takes all colors of a palette into the document's, those of the same names and the others.
    pub(super) fn join_palette(&mut self, entries: &[(String, Value)]) {
        match palette::joined(self.state.sheet(), entries) {
            Ok(edit) => {
                self.edit(edit);
                self.state.session.seal();
                self.leave_painting();
            }
            Err(why) => self.notices.warning(format!("A palette needs {why}")),
        }
    }
}
