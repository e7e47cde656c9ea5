//! Table of all commands; menus, shortcuts, and the command palette are built from it.

mod curves;
mod groups;
mod help;
mod keys;
mod layouts;
mod panels;
mod scene;
mod space;

use crate::actions::{Action, Line, Switch};
use crate::state::State;
use egui::{Key, KeyboardShortcut, Modifiers};
use space::PLAY;
pub use space::{Space, moves_view};

/// A command: menu entry, shortcut, and action.
#[derive(Clone, Copy)]
pub struct Command {
    /// Menu that contains the command.
    pub menu: &'static str,
    /// Name in menus and the command palette.
    pub name: &'static str,
    /// Tooltip: one sentence.
    pub help: &'static str,
    /// Keyboard shortcut.
    pub keys: Option<KeyboardShortcut>,
    /// Whether the viewer reads the keys, while the pointer is over it.
    pub over_viewer: bool,
    /// Whether a line separates it from the command before it in the menu.
    pub begins: bool,
    /// Returns the action to perform.
    pub action: fn(&State) -> Action,
    /// Returns whether the command is available.
    pub enabled: fn(&State) -> bool,
}

const NONE: Modifiers = Modifiers::NONE;
const COMMAND: Modifiers = Modifiers::COMMAND;
const SHIFTED: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

const fn keys(modifiers: Modifiers, key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(modifiers, key))
}

const fn command(
    menu: &'static str,
    name: &'static str,
    keys: Option<KeyboardShortcut>,
    help: &'static str,
    action: fn(&State) -> Action,
    enabled: fn(&State) -> bool,
) -> Command {
    Command { menu, name, help, keys, over_viewer: false, begins: false, action, enabled }
}

impl Command {
    /// Lets the command begin a part of its menu.
    const fn begins(self) -> Self {
        Self { begins: true, ..self }
    }

    /// Shows a key that the viewer reads, while the pointer is over it.
    const fn over_viewer(self, key: Key) -> Self {
        Self { keys: keys(NONE, key), over_viewer: true, ..self }
    }
}

fn always(_: &State) -> bool {
    true
}

fn seen(state: &State) -> bool {
    state.evaluated.result.is_some()
}

fn chosen(state: &State) -> bool {
    !state.selection.is_empty()
}

fn one(state: &State) -> bool {
    state.chosen().is_some()
}

fn several(state: &State) -> bool {
    state.selection.len() > 1
}

/// The menus, from left to right.
pub const MENUS: [&str; 6] = ["File", "Edit", "Graph", "Viewer", "Window", "Help"];

/// Returns every command; those of a menu are in its order.
pub fn commands() -> impl Iterator<Item = &'static Command> {
    COMMANDS
        .iter()
        .chain(groups::GROUPS)
        .chain(scene::SCENE)
        .chain(panels::PANELS)
        .chain(layouts::LAYOUTS)
        .chain(curves::CURVES)
        .chain(help::HELP)
}

/// The other commands, in menu order.
pub static COMMANDS: &[Command] = &[
    command("File", "New", keys(COMMAND, Key::N), "Start a new document.", |_| Action::New, always),
    command(
        "File",
        "Welcome",
        None,
        "Show the scenes that are templates, and recent documents.",
        |_| Action::Welcome,
        always,
    ),
    command("File", "Open …", keys(COMMAND, Key::O), "Open a document.", |_| Action::Open, always),
    command("File", "Save", keys(COMMAND, Key::S), "Save the document.", |_| Action::Save, always).begins(),
    command("File", "Save as …", keys(SHIFTED, Key::S), "Save to another file.", |_| Action::SaveAs, always),
    command(
        "File",
        "Reload",
        None,
        "Reload the document from its file (can be undone).",
        |_| Action::Reload,
        |state| state.session.file().is_some(),
    ),
    command(
        "File",
        "Render range",
        keys(COMMAND, Key::R),
        "Render the outputs of all frames in the range to their files.",
        |_| Action::Render,
        |state| state.render.is_none() && state.session.meaning().graph.is_some(),
    )
    .begins(),
    command(
        "File",
        "Stop rendering",
        None,
        "Stop rendering after the current frame.",
        |_| Action::CancelRender,
        |state| state.render.is_some(),
    ),
    command(
        "File",
        "Allowed folders …",
        None,
        "Show the folders that documents may access besides their own, and revoke access.",
        |_| Action::ShowAllowed,
        always,
    )
    .begins(),
    command("File", "Quit", keys(COMMAND, Key::Q), "Close the window.", |_| Action::Quit, always).begins(),
    command(
        "Edit",
        "Undo",
        keys(COMMAND, Key::Z),
        "Undo the last change.",
        |_| Action::Undo,
        |state| state.session.history().undoes().is_some(),
    ),
    command(
        "Edit",
        "Redo",
        keys(SHIFTED, Key::Z),
        "Redo the last undone change.",
        |_| Action::Redo,
        |state| state.session.history().redoes().is_some(),
    ),
    command(
        "Edit",
        "Cut",
        keys(COMMAND, Key::X),
        "Copy the selected nodes, then delete them.",
        |_| Action::Cut,
        chosen,
    )
    .begins(),
    command("Edit", "Copy", keys(COMMAND, Key::C), "Copy the selected nodes as text.", |_| Action::Copy, chosen),
    command("Edit", "Paste", keys(COMMAND, Key::V), "Paste nodes from the clipboard.", |_| Action::AskPaste, always),
    command("Edit", "Duplicate", keys(COMMAND, Key::D), "Duplicate the selected nodes.", |_| Action::Duplicate, chosen),
    command(
        "Edit",
        "Delete",
        keys(NONE, Key::Delete),
        "Delete the selected nodes and connect wires past them.",
        |_| Action::Delete,
        chosen,
    ),
    command(
        "Edit",
        "Find …",
        keys(COMMAND, Key::F),
        "Find nodes, knobs, colors and notes of the document by name or value.",
        |_| Action::Find,
        always,
    )
    .begins(),
    command("Edit", "Select all", keys(COMMAND, Key::A), "Select all nodes.", |_| Action::SelectAll, always),
    command(
        "Edit",
        "Command palette",
        keys(SHIFTED, Key::P),
        "Find and run a command by name.",
        |_| Action::Palette,
        always,
    )
    .begins(),
    command(
        "Graph",
        "Add node",
        keys(NONE, Key::Tab),
        "Find a node type by name and add a node.",
        |_| Action::AddNode,
        always,
    ),
    command(
        "Graph",
        "Make output",
        None,
        "Add an output that renders the selected node to a file.",
        |_| Action::MakeOutput,
        one,
    ),
    command(
        "Graph",
        "Replace with …",
        None,
        "Change the type of the selected node and keep its connections.",
        |_| Action::Replace,
        one,
    ),
    command(
        "Graph",
        "Extract",
        None,
        "Connect wires past the selected nodes and leave the nodes unconnected.",
        |_| Action::Extract,
        chosen,
    )
    .begins(),
    command(
        "Graph",
        "Dot",
        keys(NONE, Key::Period),
        "Add a dot to a wire of the selected node, to route the wire by hand.",
        |_| Action::Dot,
        one,
    ),
    command(
        "Graph",
        "Disable",
        keys(NONE, Key::D),
        "Disable the selected nodes, so that their inputs pass through, or enable them again.",
        |_| Action::Disable,
        chosen,
    ),
    command(
        "Graph",
        "Arrange",
        keys(NONE, Key::L),
        "Lay out the selected nodes, or all nodes.",
        |_| Action::Arrange,
        always,
    )
    .begins(),
    command("Graph", "Align left", None, "Align left edges.", |_| Action::Line(Line::Left), several),
    command("Graph", "Align centers", None, "Align centers in a column.", |_| Action::Line(Line::Centers), several),
    command("Graph", "Align top", None, "Align top edges.", |_| Action::Line(Line::Top), several),
    command(
        "Graph",
        "Distribute",
        None,
        "Make the gaps between the selected nodes equal, along the longer side.",
        |_| Action::Line(Line::Distances),
        several,
    ),
    command(
        "Graph",
        "Backdrop",
        keys(Modifiers::SHIFT, Key::B),
        "Add a titled area behind the selected nodes.",
        |_| Action::Backdrop,
        always,
    )
    .begins(),
    command(
        "Graph",
        "Name backdrop",
        None,
        "Edit the text of the backdrop behind the selected nodes, or of the only backdrop.",
        |_| Action::WriteBackdrop,
        |state| !state.sheet().backdrops.is_empty(),
    ),
    command("Graph", "Note", None, "Add a note to the graph.", |_| Action::Note, always),
    command(
        "Graph",
        "Name all colors",
        None,
        "Give every color without a name one in the palette, after the place that uses it.",
        |_| Action::NameColors,
        always,
    )
    .begins(),
    command(
        "Graph",
        "Bring palette into document",
        None,
        "Write the colors that the document reads from a palette file into the document.",
        |_| Action::BringPalette,
        |state| crate::document::swatches::file(state.sheet()).is_some(),
    ),
    command(
        "Graph",
        "Frame",
        keys(NONE, Key::F),
        "Frame the selected nodes, or all nodes.",
        |_| Action::Frames,
        always,
    )
    .begins(),
    command(
        "Viewer",
        "View node",
        None,
        "Show the selected node in the viewer (same as double-clicking it).",
        |state| match state.chosen() {
            Some(name) => Action::Look(state.whole_name(name), 0),
            None => Action::Output(state.output.clone()),
        },
        one,
    ),
    command(
        "Viewer",
        "Play",
        Some(PLAY),
        "Play the range in real time, or stop.",
        |state| Action::Play(!state.playing),
        always,
    )
    .begins(),
    command(
        "Viewer",
        "Next frame",
        keys(NONE, Key::ArrowRight),
        "Go to the next frame.",
        |state| Action::Frame(state.frame + 1),
        always,
    ),
    command(
        "Viewer",
        "Previous frame",
        keys(NONE, Key::ArrowLeft),
        "Go to the previous frame.",
        |state| Action::Frame(state.frame - 1),
        always,
    ),
    command(
        "Viewer",
        "First frame",
        keys(NONE, Key::Home),
        "Go to the first frame of the range.",
        |state| Action::Frame(state.range.0),
        always,
    ),
    command(
        "Viewer",
        "Last frame",
        keys(NONE, Key::End),
        "Go to the last frame of the range.",
        |state| Action::Frame(state.range.1),
        always,
    ),
    command(
        "Viewer",
        "Set range start",
        keys(NONE, Key::I),
        "Start the range at the current frame.",
        |state| Action::Range(state.frame, state.range.1.max(state.frame)),
        always,
    )
    .begins(),
    command(
        "Viewer",
        "Set range end",
        keys(NONE, Key::O),
        "End the range at the current frame.",
        |state| Action::Range(state.range.0.min(state.frame), state.frame),
        always,
    ),
    command(
        "Viewer",
        "Onion skin",
        keys(Modifiers::SHIFT, Key::O),
        "Mix the frames before and after over the picture, as far as they are ready.",
        |state| Action::Onion(!state.look.onion),
        always,
    ),
    command("Viewer", "Full size", None, "Evaluate every pixel.", |_| Action::Proxy(1), always).begins(),
    command("Viewer", "Half size", None, "Evaluate a quarter of the pixels.", |_| Action::Proxy(2), always),
    command("Viewer", "Quarter size", None, "Evaluate a sixteenth of the pixels.", |_| Action::Proxy(4), always),
    command(
        "Viewer",
        "Hold A",
        None,
        "Hold the current picture as A, to compare others with it.",
        |_| Action::Viewer(Switch::Hold),
        seen,
    )
    .begins(),
    command("Viewer", "Release A", None, "Stop comparing with A.", |_| Action::Viewer(Switch::LetGo), seen),
    command(
        "Viewer",
        "Wipe",
        None,
        "Show A to the left of a line and the current picture to its right.",
        |_| Action::Viewer(Switch::Wipe),
        seen,
    ),
    command(
        "Viewer",
        "Difference",
        None,
        "Show the difference between the current picture and A.",
        |_| Action::Viewer(Switch::Difference),
        seen,
    ),
    command(
        "Viewer",
        "Region",
        None,
        "Evaluate only a region; drag in the picture to draw it.",
        |_| Action::Viewer(Switch::Region),
        seen,
    )
    .begins(),
    command(
        "Viewer",
        "Whole picture",
        keys(Modifiers::SHIFT, Key::W),
        "Evaluate the whole picture instead of a region.",
        |_| Action::Region(None),
        |state| state.look.region.is_some(),
    ),
    command(
        "Viewer",
        "Hull",
        None,
        "Switch between the picture and its colors inside the convex hull of the controls.",
        |_| Action::Viewer(Switch::Hull),
        seen,
    )
    .begins()
    .over_viewer(Key::H),
    command(
        "Viewer",
        "Near",
        None,
        "Toggle marks on pixels near the hull's faces.",
        |_| Action::Viewer(Switch::Near),
        seen,
    )
    .over_viewer(Key::N),
    command(
        "Viewer",
        "Scopes",
        None,
        "Toggle histogram, waveform and vectorscope of the picture.",
        |_| Action::Viewer(Switch::Scopes),
        always,
    )
    .over_viewer(Key::S),
];

/// Adds the actions of pressed shortcuts. Those without Ctrl are ignored while text is being typed.
pub fn pressed(context: &egui::Context, state: &State, actions: &mut Vec<Action>) {
    let typing = context.egui_wants_keyboard_input();
    let mut commands: Vec<&Command> = commands().collect();
    // Shortcuts with Shift come first: egui also matches a shortcut without Shift when Shift is held.
    commands.sort_by_key(|command| command.keys.is_some_and(|keys| !keys.modifiers.shift));
    for command in commands {
        let Some(keys) = command.keys.filter(|_| !command.over_viewer) else { continue };
        // Copy and cut arrive as events of their own.
        let clipboard = keys.modifiers == COMMAND && matches!(keys.logical_key, Key::C | Key::X | Key::V);
        if clipboard || keys == PLAY || (typing && !keys.modifiers.command) {
            continue;
        }
        if typing && matches!(keys.logical_key, Key::A | Key::Z | Key::D) {
            continue;
        }
        if context.input_mut(|input| input.consume_shortcut(&keys)) && (command.enabled)(state) {
            actions.push((command.action)(state));
        }
    }
    if typing {
        return;
    }
    let number = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];
    for (slot, key) in number.into_iter().enumerate() {
        if context.input_mut(|input| input.consume_key(NONE, key)) {
            actions.push(Action::Slot(slot));
        }
    }
    context.input(|input| {
        for event in &input.events {
            match event {
                egui::Event::Copy if chosen(state) => actions.push(Action::Copy),
                egui::Event::Cut if chosen(state) => actions.push(Action::Cut),
                _ => {}
            }
        }
    });
}
