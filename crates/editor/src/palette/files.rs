//! Palette files: loading one into the document, comparing with some, and saving the document's.

use super::Palette;
use crate::actions::{Action, OtherPalette};
use crate::document::{palette_file, swatches};
use crate::state::State;
use egui::Ui;
use egui_file_dialog::{DialogState, FileDialog, Filter};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trochoid::Access;

/// An open file dialog, and what the file is for.
pub(super) struct Dialog {
    dialog: FileDialog,
    purpose: Purpose,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Load,
    Compare,
    Save,
}

impl Dialog {
    fn new(purpose: Purpose, state: &State, last: Option<&Path>) -> Self {
        let palettes = Filter::new(|path: &Path| {
            path.extension().is_some_and(|end| ["json", "gpl"].iter().any(|known| end.eq_ignore_ascii_case(known)))
        });
        let mut dialog = crate::dialogs::dialog()
            .add_file_filter("Palettes", palettes)
            .default_file_filter("Palettes")
            .add_save_extension("Palette", "json")
            .add_save_extension("GIMP palette", "gpl")
            .default_save_extension("Palette");
        let folder = state.session.folder();
        let own = folder.join("palettes");
        let usual = if own.is_dir() { own } else { folder };
        dialog.config_mut().initial_directory = last.filter(|last| last.is_dir()).map_or(usual, Path::to_path_buf);
        match purpose {
            Purpose::Load => dialog.pick_file(),
            Purpose::Compare => dialog.pick_multiple(),
            Purpose::Save => {
                dialog.config_mut().default_file_name = "palette.json".into();
                dialog.save_file();
            }
        }
        Self { dialog, purpose }
    }
}

/// Returns the palettes that lie beside a document for it: in the folder `palettes`, with names that begin like its own,
/// and not like a longer one of a document beside it.
fn beside(document: Option<&Path>) -> Vec<PathBuf> {
    let Some((folder, stem)) = document.and_then(|file| Some((file.parent()?, file.file_stem()?.to_str()?))) else {
        return Vec::new();
    };
    let files = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let stems = files(folder).filter_map(|file| Some(file.file_stem()?.to_str()?.to_owned()));
    let longer: Vec<String> = stems.filter(|other| other.len() > stem.len() && other.starts_with(stem)).collect();
    let is_own = |path: &PathBuf| {
        path.file_name()
            .and_then(|name| name.to_str())
            .is_some_and(|name| name.starts_with(stem) && !longer.iter().any(|other| name.starts_with(other.as_str())))
    };
    let mut palettes: Vec<PathBuf> = files(&folder.join("palettes")).filter(is_own).collect();
    palettes.sort();
    palettes
}

/// Draws the entries of the menu that concern files.
pub(super) fn menu_ui(panel: &mut Palette, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    for file in beside(state.session.file()) {
        let entry = ui.button(format!("Compare {}", called(&file)));
        if entry.on_hover_text("Show the picture in the colors of this file, without changing the document").clicked() {
            actions.extend(compare(panel, state, &file));
            ui.close();
        }
    }
    for (purpose, text, help) in [
        (Purpose::Load, "Load palette …", "Replace colors by those of the same names in a file, JSON or .gpl"),
        (
            Purpose::Compare,
            "Compare palettes …",
            "Show the picture in the colors of files, without changing the document",
        ),
        (Purpose::Save, "Save palette …", "Write the named colors to a file, JSON or .gpl"),
    ] {
        if ui.button(text).on_hover_text(help).clicked() {
            panel.dialog = Some(Dialog::new(purpose, state, panel.folder.as_deref()));
            ui.close();
        }
    }
}

/// Draws the open file dialog, and uses the files that it gives.
pub(super) fn dialog_ui(panel: &mut Palette, ui: &Ui, state: &State, actions: &mut Vec<Action>) {
    let Some(Dialog { dialog, purpose }) = &mut panel.dialog else { return };
    let purpose = *purpose;
    crate::dialogs::show(dialog, ui.ctx());
    let one = dialog.take_picked();
    let many = dialog.take_picked_multiple();
    if one.is_none() && many.is_none() {
        if !matches!(dialog.state(), DialogState::Open) {
            panel.dialog = None;
        }
        return;
    }
    panel.dialog = None;
    for file in one.into_iter().chain(many.into_iter().flatten()) {
        panel.folder = file.parent().map(Path::to_path_buf);
        match purpose {
            Purpose::Load => actions.push(load(state, &file)),
            Purpose::Compare => actions.extend(compare(panel, state, &file)),
            Purpose::Save => actions.push(save(state, &file)),
        }
    }
}

fn called(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Returns the action that takes the colors of a file into the document.
pub(super) fn load(state: &State, file: &Path) -> Action {
    // The user chose the file, which the document does not name.
    match palette_file::read(file, swatches::space(state.sheet()), &Access::everything()) {
        Ok(entries) => Action::TakePalette(entries, called(file)),
        Err(why) => Action::Notice(why.to_string()),
    }
}

/// Adds a palette to compare with, and returns the action that shows the picture in it.
pub(super) fn compare(panel: &mut Palette, state: &State, file: &Path) -> Option<Action> {
    let space = swatches::space(state.sheet());
    let entries = match palette_file::read(file, space, &Access::everything()) {
        Ok(entries) => entries,
        Err(why) => return Some(Action::Notice(why.to_string())),
    };
    let own = state.swatches();
    let known: Vec<&str> = crate::document::palette::names(&own).collect();
    if !entries.iter().any(|(name, _)| known.contains(&name.as_str())) {
        let text = format!("{}: found none of the document's names; name colors as the document does", called(file));
        return Some(Action::Notice(text));
    }
    let other = OtherPalette { name: called(file), entries };
    let known = panel.others.iter().find(|known| ***known == other).cloned();
    let other = known.unwrap_or_else(|| {
        let other = Arc::new(other);
        panel.others.push(other.clone());
        other
    });
    Some(Action::ComparePalette(Some(other)))
}

/// Writes the named colors to a file.
pub(super) fn save(state: &State, file: &Path) -> Action {
    let text = palette_file::text(file, &state.swatches(), swatches::space(state.sheet()));
    Action::Notice(match trochoid::write_whole(file, text.as_bytes()) {
        Ok(()) => format!("Saved the palette to {}", file.display()),
        Err(why) => why.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Session;
    use crate::testing::{act, editor, finished, until, window};

    const PAINTED: &str = r##"{
  "trochoid": 1, "format": { "width": 32, "height": 18 }, "working_space": "srgb",
  "palette": { "night": "#101a33", "foam": "#f2ead2" },
  "nodes": {
    "across": { "type": "ScreenX" },
    "sea": { "type": "Mix", "a": "palette.night", "b": "palette.foam", "weight": "across" }
  },
  "outputs": { "beauty": { "color": "sea" } }
}"##;

    fn file(folder: &Path, name: &str, text: &str) -> PathBuf {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    #[test]
    fn a_palette_lies_beside_the_document_whose_name_is_nearest_to_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let palettes = folder.path().join("palettes");
        std::fs::create_dir(&palettes).unwrap();
        let [pot, plain] = ["pot.json", "pot_plain.json"].map(|name| file(folder.path(), name, PAINTED));
        let [copper, delft] = ["pot_copper.gpl", "pot_plain_delft.json"].map(|name| file(&palettes, name, ""));
        file(&palettes, "other.json", "");
        assert_eq!(beside(Some(&pot)), [copper]);
        assert_eq!(beside(Some(&plain)), [delft]);
        assert!(beside(None).is_empty());
    }

    #[test]
    fn palettes_are_loaded_by_name_and_saved_as_they_are_loaded() {
        let folder = tempfile::tempdir().unwrap();
        let mut window = window(Session::new(PAINTED.into(), None), None);
        for (name, written) in [
            ("warm.json", r##"{ "foam": "#ffe0c0" }"##),
            ("warm.gpl", "GIMP Palette\n255 224 192\tfoam\n"),
            ("whole.json", r##"{ "trochoid_palette": 1, "palette": { "foam": "#ffe0c0" } }"##),
        ] {
            let path = file(folder.path(), name, written);
            let action = load(editor(&window).state(), &path);
            act(&mut window, action);
            let state = editor(&window).state();
            assert_eq!(state.session.text(), PAINTED.replace("#f2ead2", "#ffe0c0"), "{name}");
            for saved in ["saved.json", "saved.gpl"] {
                let saved = folder.path().join(saved);
                save(state, &saved);
                let space = swatches::space(state.sheet());
                let back = palette_file::read(&saved, space, &Access::everything()).unwrap();
                assert_eq!(back, [("night".into(), "#101a33".into()), ("foam".into(), "#ffe0c0".into())]);
            }
            act(&mut window, Action::Undo);
            assert_eq!(editor(&window).state().session.text(), PAINTED);
        }
        // Colors of other names are not taken, and the user is told.
        let partly = file(folder.path(), "partly.json", r##"{ "foam": "#ffe0c0", "gone": "#000000" }"##);
        let action = load(editor(&window).state(), &partly);
        act(&mut window, action);
        assert_eq!(editor(&window).state().session.text(), PAINTED.replace("#f2ead2", "#ffe0c0"));
        use egui_kittest::kittest::Queryable;
        assert!(window.query_all_by_label_contains("not those of gone").next().is_some());
        act(&mut window, Action::Undo);
        let strange = file(folder.path(), "strange.json", r##"{ "faom": "#ffe0c0" }"##);
        let action = load(editor(&window).state(), &strange);
        act(&mut window, action);
        assert_eq!(editor(&window).state().session.text(), PAINTED);
        let broken = load(editor(&window).state(), &file(folder.path(), "broken.json", "{"));
        assert!(matches!(broken, Action::Notice(_)), "{broken:?}");
    }

    #[test]
    fn a_compared_palette_is_shown_without_changing_the_document_until_it_is_used() {
        let folder = tempfile::tempdir().unwrap();
        let mut window = window(Session::new(PAINTED.into(), None), None);
        act(&mut window, Action::Panel(crate::actions::Pane::Palette));
        finished(&mut window);
        until(&mut window, "the recipe", |editor| editor.state().evaluated.mixture.is_some());
        let path = file(folder.path(), "red.json", r##"{ "night": "#ff0000" }"##);
        let mut panel = Palette::default();
        let action = compare(&mut panel, editor(&window).state(), &path).unwrap();
        window.state_mut().as_mut().unwrap().panels.palette.others = panel.others;
        act(&mut window, action);
        until(&mut window, "the painting", |editor| editor.state().evaluated.painted.is_some());
        let painted = editor(&window).state().evaluated.painted.clone().unwrap();
        assert_eq!(painted.screen.pixels[0], 255, "the left is red");
        assert_eq!(editor(&window).state().session.text(), PAINTED);
        use egui_kittest::kittest::Queryable;
        window.run_steps(2);
        window.get_by_label("Use this palette").click();
        window.run_steps(3);
        finished(&mut window);
        assert_eq!(editor(&window).state().session.text(), PAINTED.replace("#101a33", "#ff0000"));
        let result = editor(&window).state().evaluated.result.clone().unwrap();
        let pixels = result.screen.pixels.iter().zip(&painted.screen.pixels);
        assert!(pixels.into_iter().all(|(a, b)| a.abs_diff(*b) <= 1));
        act(&mut window, Action::Undo);
        assert_eq!(editor(&window).state().session.text(), PAINTED);
    }
}
