//! Tests that viewing changes nothing: the text stays the same byte for byte, whatever is selected, opened, or shown.

use crate::actions::{Action, Pane};
use crate::document::Session;
use crate::editor::Editor;
use crate::testing::{Window, act, ask, editor, unseen};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Returns every document in a folder of the repository.
fn documents(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_document =
        |path: &PathBuf| path.to_string_lossy().ends_with(".json") && !path.to_string_lossy().ends_with(".expect.json");
    let mut files: Vec<PathBuf> = files.filter(is_document).collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

/// Returns a description of a change to the document, if any.
fn change(editor: &Editor, text: &str, revision: u64) -> Option<String> {
    let session = &editor.state().session;
    let done = session.history().undoes().map(String::from);
    done.or_else(|| (session.text() != text || session.revision() != revision).then(|| "the text".into()))
}

/// Performs an action, and draws what it shows: for the first time, and again when everything has its size. A change
/// that the second time causes is found after the next action at the latest.
fn show(window: &mut Window, action: Action) {
    ask(window, action);
    window.run_steps(2);
}

/// Selects every output and a node of each type of a document, and shows every panel; returns the changes made by that.
fn look_at(session: Session) -> Vec<String> {
    let text = session.text().to_string();
    let mut window = unseen(session);
    // Opens all lists, records and menus.
    window.ctx.memory_mut(|memory| memory.set_everything_is_visible(true));
    let revision = editor(&window).state().session.revision();
    let sheet = editor(&window).state().sheet().clone();
    let mut changes = Vec::new();
    let mut check = |window: &mut Window, what: &str| {
        if let Some(change) = change(editor(window), &text, revision) {
            changes.push(format!("{what}: {change}"));
            act(window, Action::Undo);
        }
    };
    for pane in Pane::ALL {
        show(&mut window, Action::Panel(pane));
        check(&mut window, pane.title());
    }
    for output in &sheet.outputs {
        show(&mut window, Action::Output(Some(output.name.clone())));
        check(&mut window, &output.name);
    }
    show(&mut window, Action::Panel(Pane::Properties));
    let mut types = HashSet::new();
    for node in sheet.nodes.iter().filter(|node| types.insert(&node.ty)) {
        show(&mut window, Action::Select([node.name.clone()].into()));
        check(&mut window, &node.name);
    }
    show(&mut window, Action::Panel(Pane::Waves));
    for node in sheet.nodes.iter().filter(|node| node.ty.ends_with("Sea")) {
        show(&mut window, Action::Select([node.name.clone()].into()));
        check(&mut window, &node.name);
    }
    window.step();
    check(&mut window, "the end");
    changes
}

#[test]
fn nothing_is_written_by_looking_at_nodes_of_every_type_in_every_document() {
    let files: Vec<PathBuf> = ["graphs", "tests/nodes", "tests/extremes"].into_iter().flat_map(documents).collect();
    let look = |file: &PathBuf| {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let changes = look_at(Session::open(file).unwrap());
        changes.into_iter().map(move |change| format!("{name}: {change}"))
    };
    // One thread per processor.
    let next = std::sync::atomic::AtomicUsize::new(0);
    let take = || files.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed));
    let work = || std::iter::from_fn(&take).flat_map(&look).collect::<Vec<String>>();
    let count = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let changes: Vec<String> = std::thread::scope(|scope| {
        let hands: Vec<_> = (0..count).map(|_| scope.spawn(work)).collect();
        hands.into_iter().flat_map(|hand| hand.join().unwrap()).collect()
    });
    assert!(changes.is_empty(), "{} places: {changes:#?}", changes.len());
}
