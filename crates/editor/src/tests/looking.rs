//! Tests that viewing changes nothing: the text stays the same byte for byte, whatever is selected, opened, or shown.

use crate::actions::{Action, Pane};
use crate::document::Session;
use crate::editor::Editor;
use egui::{Context, Memory, RawInput, Rect, vec2};
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

/// A screen that shows an editor, without the tree of widgets by which other tests find them: only the text counts here.
struct Screen<'c> {
    context: &'c Context,
    editor: Editor,
}

impl<'c> Screen<'c> {
    /// Opens a document in an editor whose viewer shows nothing, so that nothing is evaluated, on a context that keeps
    /// only its fonts from earlier documents.
    fn open(context: &'c Context, session: Session) -> Self {
        context.memory_mut(|memory| *memory = Memory::default());
        let mut editor = Editor::new(context, session, None).unwrap();
        editor.state.look.node = None;
        // Opens all lists, records and menus.
        context.memory_mut(|memory| memory.set_everything_is_visible(true));
        let mut screen = Self { context, editor };
        screen.draw();
        screen
    }

    fn draw(&mut self) {
        let screen_rect = Some(Rect::from_min_size(Default::default(), vec2(1280.0, 800.0)));
        let input = RawInput { screen_rect, predicted_dt: 0.02, ..Default::default() };
        let mut output = self.context.run_ui(input, |ui| self.editor.ui(ui));
        // Nothing is painted.
        output.textures_delta.clear();
    }

    /// Performs an action, and draws what it shows: for the first time, and again when everything has its size. A change
    /// that the second time causes is found after the next action at the latest.
    fn show(&mut self, action: Action) {
        self.editor.act(action, self.context);
        self.draw();
        self.draw();
    }
}

/// Selects every output and a node of each type of a document, and shows every panel; returns the changes made by that.
fn look_at(context: &Context, session: Session) -> Vec<String> {
    let text = session.text().to_string();
    let mut screen = Screen::open(context, session);
    let revision = screen.editor.state().session.revision();
    let sheet = screen.editor.state().sheet().clone();
    let mut changes = Vec::new();
    let mut check = |screen: &mut Screen<'_>, what: &str| {
        if let Some(change) = change(&screen.editor, &text, revision) {
            changes.push(format!("{what}: {change}"));
            screen.show(Action::Undo);
        }
    };
    for pane in Pane::ALL {
        screen.show(Action::Panel(pane));
        check(&mut screen, pane.title());
    }
    for output in &sheet.outputs {
        screen.show(Action::Output(Some(output.name.clone())));
        check(&mut screen, &output.name);
    }
    screen.show(Action::Panel(Pane::Properties));
    let mut types = HashSet::new();
    for node in sheet.nodes.iter().filter(|node| types.insert(&node.ty)) {
        screen.show(Action::Select([node.name.clone()].into()));
        check(&mut screen, &node.name);
    }
    screen.show(Action::Panel(Pane::Waves));
    for node in sheet.nodes.iter().filter(|node| node.ty.ends_with("Sea")) {
        screen.show(Action::Select([node.name.clone()].into()));
        check(&mut screen, &node.name);
    }
    screen.show(Action::Panel(Pane::Properties));
    let mut open: Vec<Vec<String>> = uses(&screen).into_iter().map(|name| vec![name]).collect();
    let mut groups = HashSet::new();
    while let Some(path) = open.pop() {
        screen.show(Action::Enter(path.clone()));
        check(&mut screen, &path.join("/"));
        let sheet = screen.editor.state().sheet().clone();
        // Other uses of a group have the same inside.
        if !groups.insert(sheet.within.as_ref().map(|within| within.group().to_string())) {
            continue;
        }
        for node in &sheet.nodes {
            screen.show(Action::Select([node.name.clone()].into()));
            check(&mut screen, &format!("{}/{}", path.join("/"), node.name));
        }
        screen.show(Action::Select(Default::default()));
        check(&mut screen, &format!("the group of {}", path.join("/")));
        open.extend(uses(&screen).into_iter().map(|name| [path.clone(), vec![name]].concat()));
    }
    screen.show(Action::Enter(Vec::new()));
    screen.draw();
    check(&mut screen, "the end");
    changes
}

/// Returns the uses of groups that are shown.
fn uses(screen: &Screen<'_>) -> Vec<String> {
    let nodes = screen.editor.state().sheet().nodes.iter();
    nodes.filter(|node| node.is_use).map(|node| node.name.clone()).collect()
}

#[test]
fn nothing_is_written_by_looking_at_nodes_of_every_type_in_every_document() {
    let files: Vec<PathBuf> = ["graphs", "tests/nodes", "tests/extremes"].into_iter().flat_map(documents).collect();
    let look = |context: &Context, file: &PathBuf| {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let changes = look_at(context, Session::open(file).unwrap());
        changes.into_iter().map(move |change| format!("{name}: {change}"))
    };
    // One thread per processor.
    let next = std::sync::atomic::AtomicUsize::new(0);
    let take = || files.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed));
    let work = || {
        let context = Context::default();
        std::iter::from_fn(&take).flat_map(|file| look(&context, file)).collect::<Vec<String>>()
    };
    let count = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let changes: Vec<String> = std::thread::scope(|scope| {
        let hands: Vec<_> = (0..count).map(|_| scope.spawn(work)).collect();
        hands.into_iter().flat_map(|hand| hand.join().unwrap()).collect()
    });
    assert!(changes.is_empty(), "{} places: {changes:#?}", changes.len());
}

/// Links are texts in the place of values of any type. All groups are entered, and left.
#[test]
fn links_and_groups_stay_what_they_are() {
    let text = r##"{ "trochoid": 1, "format": { "width": 16, "height": 9 }, "frames": { "first": 1, "last": 9 },
      "knobs": { "wind": { "value": 1, "min": 0, "max": 2 }, "ink": "#102030", "word": "disc", "plate": "a.exr" },
      "groups": { "Pair": { "inputs": { "in": "Color", "by": { "kind": "Mask", "default": 1 } }, "knobs": { "how": 0.5 },
        "nodes": { "m": { "type": "Mix", "a": "in", "b": "= knobs.how * 0 + 1", "weight": "by" } }, "outputs": { "out": "in" } } },
      "nodes": {
        "x": { "type": "ScreenX" },
        "soft": { "type": "Clamp", "field": "x", "min": "= 0.1 * knobs.wind", "max": "= soft.min + 0.5" },
        "dot": { "type": "Shape", "shapes": [{ "form": "= knobs.word", "center": ["= soft.min", 0.5], "radius": "= time / 9" }] },
        "noise": { "type": "Noise", "octaves": "= 2 + 1", "offset": "= [frame, 0, 0]" },
        "camera": { "type": "Camera", "position": "= [0, 5 + knobs.wind, 30]", "fov": "= 40 + frame" },
        "mix": { "type": "Mix", "a": "= knobs.ink", "b": "#fff", "weight": "soft" },
        "pair": { "type": "Pair", "in": "mix", "how": "= knobs.wind / 4" },
        "use": { "type": "Mix", "a": "pair", "b": "#f00", "weight": "dot" } },
      "outputs": { "beauty": { "color": "use" } } }"##;
    for text in [text, crate::document::tests::groups::LINKED] {
        let changes = look_at(&Context::default(), Session::new(text.into(), None));
        assert!(changes.is_empty(), "{changes:#?}");
    }
}
