//! Questions: which file, what of unsaved work, which command.

mod leave;

use crate::actions::Action;
use crate::commands::{COMMANDS, Command};
use crate::document::Session;
use crate::document::keep::{Kept, discard};
use crate::editor::{After, Editor};
use egui::{Context, Key, Modal, RichText, ScrollArea, Ui};
use egui_file_dialog::{FileDialog, Filter};
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use trochoid::Refused;

/// What is being asked.
pub(crate) struct Prompts {
    data: Option<PathBuf>,
    open: Option<Prompt>,
    dialog: FileDialog,
    /// What the file is for that the dialog asks for.
    asking: Option<Asking>,
}

#[derive(Clone, Debug)]
enum Asking {
    Open,
    /// And what comes after it is saved.
    Save(Option<After>),
}

enum Prompt {
    Unsaved(After),
    /// Whether to write over a document of a newer version, and what comes after it.
    Newer(Option<After>),
    /// Which text counts: the file's, or the one here; whether that is to be saved, and what comes after it.
    External(Option<Option<After>>),
    /// Whether to end a run, and what comes after it.
    Rendering(After),
    /// Whether the document may reach further, so that it can be rendered.
    Reach(Vec<Refused>),
    Recover(Vec<Kept>),
    /// Whether to write over this file, and what comes after it.
    Replace(PathBuf, Option<After>),
    /// What documents were allowed.
    Allowed,
    Palette {
        text: String,
        chosen: usize,
    },
}

impl Prompts {
    /// No question; `data` is where the program keeps its own data.
    pub(crate) fn new(data: Option<&Path>) -> Self {
        let json = Filter::new(|path: &Path| path.extension().is_some_and(|end| end == "json"));
        let dialog = FileDialog::new()
            .add_file_filter("Documents", json)
            .default_file_filter("Documents")
            .add_save_extension("Document", "json")
            .default_save_extension("Document");
        Self { data: data.map(Path::to_path_buf), open: None, dialog, asking: None }
    }

    /// Where the program keeps its own data.
    pub(crate) fn data(&self) -> Option<&Path> {
        self.data.as_deref()
    }

    /// Whether an answer is needed before anything else.
    pub(crate) fn is_open(&self) -> bool {
        self.open.is_some() || self.asking.is_some()
    }

    /// Asks what is to become of unsaved work before something else.
    pub(crate) fn unsaved(&mut self, after: After) {
        self.open = Some(Prompt::Unsaved(after));
    }

    /// Asks whether to write over a document of a version that is not known here.
    pub(crate) fn newer(&mut self, after: Option<After>) {
        self.open = Some(Prompt::Newer(after));
    }

    /// Asks what counts: what is here, or what another program wrote. Where what is here was to be saved, `saving` says what
    /// was to come after that.
    pub(crate) fn external(&mut self, saving: Option<Option<After>>) {
        if self.open.is_none() || saving.is_some() {
            self.open = Some(Prompt::External(saving));
        }
    }

    /// Asks whether to end a run before something else.
    pub(crate) fn rendering(&mut self, after: After) {
        self.open = Some(Prompt::Rendering(after));
    }

    /// Asks whether the document may reach files that it needs to be rendered.
    pub(crate) fn reach(&mut self, refused: Vec<Refused>) {
        self.open = Some(Prompt::Reach(refused));
    }

    /// Offers work that was kept of editors that ended unexpectedly.
    pub(crate) fn recover(&mut self, kept: Vec<Kept>) {
        self.open = Some(Prompt::Recover(kept));
    }

    /// Shows which folders documents were allowed, to take them back.
    pub(crate) fn allowed(&mut self) {
        self.open = Some(Prompt::Allowed);
    }

    /// Asks for a command.
    pub(crate) fn palette(&mut self) {
        self.open = Some(Prompt::Palette { text: String::new(), chosen: 0 });
    }

    /// Asks for a document to open.
    pub(crate) fn ask_open(&mut self, session: &Session) {
        self.dialog.config_mut().initial_directory = session.folder();
        self.dialog.pick_file();
        self.asking = Some(Asking::Open);
    }

    /// Asks where to save.
    pub(crate) fn ask_save(&mut self, session: &Session, after: Option<After>) {
        let config = self.dialog.config_mut();
        config.initial_directory = session.folder();
        config.default_file_name = match session.file() {
            Some(_) => session.title(),
            None => "untitled.json".into(),
        };
        self.dialog.save_file();
        self.asking = Some(Asking::Save(after));
    }
}

/// Asks what there is to ask, and does what is answered.
pub(crate) fn prompts_ui(editor: &mut Editor, context: &Context, actions: &mut Vec<Action>) {
    files_ui(editor, context);
    let Some(prompt) = editor.prompts.open.take() else { return };
    let next = match prompt {
        Prompt::Unsaved(after) => leave::unsaved_ui(editor, context, after),
        Prompt::Newer(after) => leave::newer_ui(editor, context, after),
        Prompt::External(saving) => leave::external_ui(editor, context, saving),
        Prompt::Rendering(after) => leave::rendering_ui(editor, context, after),
        Prompt::Reach(refused) => reach_ui(editor, context, refused),
        Prompt::Recover(kept) => recover_ui(editor, context, kept),
        Prompt::Replace(file, after) => replace_ui(editor, context, file, after),
        Prompt::Allowed => crate::reach::allowed_ui(editor, context).then_some(Prompt::Allowed),
        Prompt::Palette { text, chosen } => palette_ui(editor, context, text, chosen, actions),
    };
    // An answer may have led to another question.
    editor.prompts.open = next.or(editor.prompts.open.take());
}

fn files_ui(editor: &mut Editor, context: &Context) {
    let Some(asking) = editor.prompts.asking.clone() else { return };
    editor.prompts.dialog.update(context);
    if let Some(file) = editor.prompts.dialog.take_picked() {
        editor.prompts.asking = None;
        match asking {
            Asking::Open => editor.go(After::Open(file), context),
            Asking::Save(after) => {
                let whole = meant(&file, editor.prompts.dialog.selected_entry().map(|entry| entry.to_path_buf()));
                // The dialog has asked about the file that it named, and about no other.
                if whole != file && whole.exists() {
                    editor.prompts.open = Some(Prompt::Replace(whole, after));
                } else {
                    editor.save(&whole, after, context);
                }
            }
        }
    } else if !matches!(editor.prompts.dialog.state(), egui_file_dialog::DialogState::Open) {
        editor.prompts.asking = None;
    }
}

/// The file that is meant by one that the dialog names: in the folder that is highlighted there, and with the ending that
/// the dialog shows.
fn meant(file: &Path, highlighted: Option<PathBuf>) -> PathBuf {
    let folder = highlighted.filter(|entry| entry.is_dir() && entry.parent() == file.parent());
    let name = file.file_name().unwrap_or_default();
    let mut whole = folder.map_or_else(|| file.as_os_str().to_owned(), |folder| folder.join(name).into_os_string());
    if file.extension().is_none_or(|end| end != "json") {
        whole.push(".json");
    }
    whole.into()
}

fn replace_ui(editor: &mut Editor, context: &Context, file: PathBuf, after: Option<After>) -> Option<Prompt> {
    let (mut replace, mut cancel) = (false, false);
    let modal = Modal::new("replace".into()).show(context, |ui| {
        titled(ui, "Replace the file?");
        let text = format!("{} is there already.", file.display());
        ui.add(egui::Label::new(&text).truncate()).on_hover_text(&text);
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            replace = ui.button("Replace").clicked();
            cancel = ui.button("Cancel").clicked();
        });
    });
    if replace {
        editor.save(&file, after, context);
        return None;
    }
    (!cancel && !modal.should_close()).then_some(Prompt::Replace(file, after))
}

pub(crate) fn titled(ui: &mut Ui, title: &str) {
    // As wide whatever stands in it: nothing moves under the hand.
    ui.set_width(460.0);
    ui.label(RichText::new(title).heading());
    ui.add_space(4.0);
}

fn reach_ui(editor: &mut Editor, context: &Context, refused: Vec<Refused>) -> Option<Prompt> {
    let (mut allowed, mut cancel) = (None, false);
    let modal = Modal::new("reach".into()).show(context, |ui| {
        titled(ui, "Let the document reach further?");
        ui.label("It cannot be rendered without files outside of what it may reach:");
        ui.add_space(4.0);
        ScrollArea::vertical().max_height(240.0).show(ui, |ui| {
            for refused in &refused {
                ui.label(crate::prose::here(&refused.diagnostic().to_string()));
            }
        });
        ui.add_space(8.0);
        allowed = crate::reach::buttons_ui(ui, &refused, editor.state().session.file().is_some());
        cancel = ui.button("Cancel").clicked();
    });
    if let Some(grant) = allowed {
        editor.act(Action::Allow(grant), context);
        editor.act(Action::Render, context);
        return None;
    }
    (!cancel && !modal.should_close()).then_some(Prompt::Reach(refused))
}

fn recover_ui(editor: &mut Editor, context: &Context, mut kept: Vec<Kept>) -> Option<Prompt> {
    let (mut chosen, mut dropped, mut later) = (None, None, false);
    Modal::new("recover".into()).show(context, |ui| {
        titled(ui, "Recover unsaved work?");
        ui.label("The editor ended unexpectedly. These changes were kept:");
        ui.add_space(4.0);
        ScrollArea::vertical().max_height(240.0).show(ui, |ui| {
            for (index, kept) in kept.iter().enumerate() {
                ui.horizontal(|ui| {
                    let name = kept
                        .file
                        .as_ref()
                        .and_then(|file| file.file_name())
                        .map_or_else(|| "untitled".into(), |name| name.to_string_lossy().into_owned());
                    let label = ui.label(RichText::new(name).strong());
                    if let Some(file) = &kept.file {
                        label.on_hover_text(file.display().to_string());
                    }
                    ui.label(ago(kept.when));
                    if kept.overtaken {
                        let help =
                            "Another program has changed it since. Recovering does not touch the file; saving asks.";
                        let text = RichText::new("the file is newer").color(ui.visuals().warn_fg_color);
                        ui.label(text).on_hover_text(help);
                    }
                    if ui.button("Recover").clicked() {
                        chosen = Some(index);
                    }
                    if ui.button("Discard").on_hover_text("For good: this cannot be undone.").clicked() {
                        dropped = Some(index);
                    }
                });
            }
        });
        ui.add_space(8.0);
        let again = if kept.iter().all(|kept| kept.file.is_none()) { "editor starts" } else { "document is opened" };
        later = ui.button("Later").on_hover_text(format!("Asks again when the {again} next.")).clicked();
    });
    if let Some(index) = dropped {
        discard(&kept.remove(index));
    }
    if let Some(index) = chosen {
        let kept = kept.swap_remove(index);
        editor.recover(&kept, context);
        return None;
    }
    (!later && !kept.is_empty()).then_some(Prompt::Recover(kept))
}

fn ago(when: SystemTime) -> String {
    let seconds = when.elapsed().map_or(0, |time| time.as_secs());
    match seconds {
        0..60 => "just now".into(),
        60..3600 => format!("{} ago", crate::document::edit::count(seconds as usize / 60, "minute")),
        3600..86_400 => format!("{} ago", crate::document::edit::count(seconds as usize / 3600, "hour")),
        _ => format!("{} ago", crate::document::edit::count(seconds as usize / 86_400, "day")),
    }
}

/// Whether the letters of `wanted` stand in `name` in that order, and how far apart: less is better.
pub(crate) fn fuzzy(wanted: &str, name: &str) -> Option<usize> {
    let name: Vec<char> = name.to_lowercase().chars().collect();
    let mut at = 0;
    let mut cost = 0;
    for c in wanted.to_lowercase().chars().filter(|c| !c.is_whitespace()) {
        let next = name[at..].iter().position(|known| *known == c)?;
        // The first letter counts where it stands; a letter that begins a word is no gap.
        let begins = at + next == 0 || !name[at + next - 1].is_alphanumeric();
        cost += if begins { 0 } else { next + usize::from(at == 0) };
        at += next + 1;
    }
    Some(4 * cost + name.len())
}

/// The best matches of a text among names.
pub(crate) fn matches<'n>(wanted: &str, names: impl Iterator<Item = (usize, &'n str)>) -> Vec<usize> {
    let mut found: Vec<(usize, usize)> =
        names.filter_map(|(index, name)| Some((fuzzy(wanted, name)?, index))).collect();
    if !wanted.trim().is_empty() {
        found.sort_unstable();
    }
    found.into_iter().map(|(_, index)| index).collect()
}

fn palette_ui(
    editor: &mut Editor,
    context: &Context,
    mut text: String,
    mut chosen: usize,
    actions: &mut Vec<Action>,
) -> Option<Prompt> {
    let state = editor.state();
    let mut run: Option<&Command> = None;
    let modal = Modal::new("palette".into()).show(context, |ui| {
        ui.set_width(420.0);
        let field = ui.add(egui::TextEdit::singleline(&mut text).hint_text("Command …").desired_width(f32::INFINITY));
        field.request_focus();
        if field.changed() {
            chosen = 0;
        }
        let found = matches(&text, COMMANDS.iter().enumerate().map(|(index, command)| (index, command.name)));
        let found: Vec<&Command> =
            found.into_iter().map(|index| &COMMANDS[index]).filter(|command| (command.enabled)(state)).collect();
        chosen = moved(ui, chosen, found.len());
        ScrollArea::vertical().max_height(320.0).auto_shrink([false, true]).show(ui, |ui| {
            for (index, command) in found.iter().enumerate() {
                let keys = command.keys.map(|keys| ui.ctx().format_shortcut(&keys)).unwrap_or_default();
                let button = egui::Button::selectable(index == chosen, command.name)
                    .shortcut_text(keys)
                    .min_size(egui::vec2(ui.available_width(), 0.0));
                let row = ui.add(button).on_hover_text(command.help);
                if index == chosen {
                    row.scroll_to_me(None);
                }
                if row.clicked() {
                    run = Some(command);
                }
            }
            if found.is_empty() {
                ui.weak("No command has this name.");
            }
        });
        if ui.input(|input| input.key_pressed(Key::Enter)) {
            run = found.get(chosen).copied();
        }
    });
    if let Some(command) = run {
        actions.push((command.action)(editor.state()));
        return None;
    }
    (!modal.should_close()).then_some(Prompt::Palette { text, chosen })
}

/// Moves a choice in a list by the arrow keys.
pub(crate) fn moved(ui: &Ui, chosen: usize, count: usize) -> usize {
    let step = ui.input(|input| input.num_presses(Key::ArrowDown) as i64 - input.num_presses(Key::ArrowUp) as i64);
    (chosen as i64 + step).clamp(0, count.saturating_sub(1) as i64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_saved_in_the_folder_that_is_highlighted_as_json() {
        let folder = tempfile::tempdir().unwrap();
        let new = folder.path().join("new");
        std::fs::create_dir(&new).unwrap();
        let at = |name: &str| folder.path().join(name);
        assert_eq!(meant(&at("untitled"), None), at("untitled.json"));
        assert_eq!(meant(&at("shot.v2"), None), at("shot.v2.json"));
        assert_eq!(meant(&at("dusk.json"), None), at("dusk.json"));
        assert_eq!(meant(&at("dusk.json"), Some(new.clone())), new.join("dusk.json"));
        std::fs::write(at("dusk.json"), "").unwrap();
        assert_eq!(meant(&at("dusk.json"), Some(at("dusk.json"))), at("dusk.json"), "a file is no folder");
    }
}
