//! The button beside the name of a file that chooses one.

use super::context::{Properties, WidgetContext};
use crate::actions::Action;
use crate::document::json::quoted;
use crate::document::relocate::{self, NoText};
use crate::document::{Edit, Op, Path};
use crate::field::Gesture;
use crate::state::State;
use egui::{Context, Ui, WidgetInfo, WidgetType};
use egui_file_dialog::{DialogState, FileDialog, Filter};

/// An open dialog, and the knobs that get the chosen file.
pub(super) struct Choosing {
    dialog: FileDialog,
    gesture: Gesture,
    places: Vec<Path>,
    /// The sheet that has the knobs: its place in the expanded document.
    prefix: String,
}

/// Draws the button.
pub(super) fn button_ui(panel: &mut Properties, ui: &mut Ui, name: &str, place: &WidgetContext<'_>) {
    let button = ui.small_button("…").on_hover_text("Choose a file");
    button.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Choose {name}")));
    let Some(gesture) = Gesture::click(&button) else { return };
    let mut dialog = crate::dialogs::dialog();
    if let Some(files) = place.state.chosen().and_then(|name| place.state.sheet().node(name)?.declaration?.reads) {
        let fits = Filter::new(move |path: &std::path::Path| files.include(&path.to_string_lossy()));
        dialog = dialog.add_file_filter(files.what, fits).default_file_filter(files.what);
    }
    let folder = place.state.session.folder();
    let named = place.value.and_then(|value| value.as_str()).filter(|file| !file.is_empty());
    let now = named.map(|file| folder.join(file));
    let beside = now.as_deref().and_then(std::path::Path::parent).filter(|folder| folder.is_dir());
    dialog.config_mut().initial_directory = beside.map_or(folder.clone(), std::path::Path::to_path_buf);
    dialog.pick_file();
    let (places, prefix) = (place.places().cloned().collect(), place.state.sheet().prefix());
    panel.choosing = Some(Choosing { dialog, gesture, places, prefix });
}

/// Draws the open dialog, and sets the file that it gives.
pub(super) fn dialog_ui(panel: &mut Properties, context: &Context, state: &State, actions: &mut Vec<Action>) {
    let Some(choosing) = &mut panel.choosing else { return };
    crate::dialogs::show(&mut choosing.dialog, context);
    let picked = choosing.dialog.take_picked();
    if picked.is_none() && matches!(choosing.dialog.state(), DialogState::Open) {
        return;
    }
    let Some(Choosing { gesture, places, prefix, .. }) = panel.choosing.take() else { return };
    // The graph may have changed meanwhile.
    let stays = |path: &Path| path.0.get(..2).is_some_and(|node| state.sheet().get(&Path(node.to_vec())).is_some());
    if let Some(file) = picked.filter(|_| prefix == state.sheet().prefix() && places.iter().all(stays)) {
        match chosen(state, &places, &file) {
            Ok((edit, told)) => {
                gesture.edit(edit, actions);
                actions.extend(told.map(Action::Notice));
            }
            Err(why) => actions.push(Action::Notice(why.to_string())),
        }
    }
}

/// Returns the edit that names a file in some knobs, and what else the user should know.
fn chosen(state: &State, places: &[Path], file: &std::path::Path) -> Result<(Edit, Option<String>), NoText> {
    let path = relocate::relative(file, &state.session.folder())?;
    let ops = places.iter().map(|place| Op::Set(place.clone(), quoted(&path))).collect();
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let is_outside = state.session.access().check(file).is_err();
    let told = is_outside.then(|| {
        format!(
            "{} is outside of the folders that the document may read: view the node, and allow it there",
            file.display()
        )
    });
    Ok((Edit::new(format!("Choose {name}"), ops), told))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Session;

    #[test]
    fn a_chosen_file_is_named_from_the_folder_of_the_document() {
        let folder = tempfile::tempdir().unwrap();
        let text = r#"{ "trochoid": 1, "format": { "width": 4, "height": 4 }, "nodes": { "plate": { "type": "Read", "file": "" } } }"#;
        let file = folder.path().join("shot.json");
        trochoid::write_whole(&file, text.as_bytes()).unwrap();
        let state = State::new(Session::open(&file).unwrap(), crate::evaluate::Graphics::default());
        let places = [Path::node("plate").to("file")];
        let (edit, told) = chosen(&state, &places, &folder.path().join("plates/a.0001.png")).unwrap();
        assert_eq!(told, None);
        assert_eq!(edit.ops, [Op::Set(places[0].clone(), r#""plates/a.0001.png""#.into())]);
        // What the document may not read is told.
        let elsewhere = folder.path().parent().unwrap().join("other.png");
        let told = chosen(&state, &places, &elsewhere).unwrap().1.unwrap();
        assert!(told.contains("other.png") && told.contains("allow it"), "{told}");
    }
}
