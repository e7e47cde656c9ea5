//! Every command once: menus, shortcuts and the palette derive from this table.

use crate::actions::{Action, Line, Pane, Switch};
use crate::state::State;
use egui::{Key, KeyboardShortcut, Modifiers};

/// A command.
#[derive(Clone, Copy)]
pub struct Command {
    /// The menu in which it stands.
    pub menu: &'static str,
    /// What it is called.
    pub name: &'static str,
    /// What it does, in a sentence.
    pub help: &'static str,
    /// The keys for it.
    pub keys: Option<KeyboardShortcut>,
    /// What is done.
    pub action: fn(&State) -> Action,
    /// Whether there is anything to be done.
    pub enabled: fn(&State) -> bool,
}

const NONE: Modifiers = Modifiers::NONE;
const COMMAND: Modifiers = Modifiers::COMMAND;
const SHIFTED: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// What plays is also what is held to move the view, so it counts when it is let go, see [`Space`].
const PLAY: KeyboardShortcut = KeyboardShortcut::new(NONE, Key::Space);

/// The space bar: while it is held, a drag moves the view; let go without one, it plays.
#[derive(Debug, Default)]
pub struct Space {
    held: bool,
    dragged: bool,
}

impl Space {
    /// Takes what happened since it was asked last; whether the bar was let go and nothing was dragged meanwhile.
    pub fn plays(&mut self, context: &egui::Context) -> bool {
        let typing = context.egui_wants_keyboard_input();
        context.input_mut(|input| {
            if input.key_pressed(PLAY.logical_key) && !typing && input.modifiers.is_none() && !self.held {
                *self = Self { held: true, dragged: false };
            }
            if !self.held {
                return false;
            }
            // It does nothing else, such as pressing a button.
            input.consume_key(NONE, PLAY.logical_key);
            self.dragged |= input.pointer.any_down();
            let released = input.key_released(PLAY.logical_key);
            // Where the window loses the keyboard, nothing says that the bar is let go.
            self.held = !released && input.key_down(PLAY.logical_key);
            released && !self.dragged
        })
    }
}

/// Whether a drag that begins now moves the view: the space bar is held.
pub fn moves_view(context: &egui::Context) -> bool {
    !context.egui_wants_keyboard_input() && context.input(|input| input.key_down(PLAY.logical_key))
}

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
    Command { menu, name, help, keys, action, enabled }
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

/// The menus, in order.
pub const MENUS: [&str; 5] = ["File", "Edit", "Graph", "Viewer", "Window"];

/// Every command, in the order of the menus.
pub static COMMANDS: &[Command] = &[
    command("File", "New", keys(COMMAND, Key::N), "Starts a document.", |_| Action::New, always),
    command("File", "Open …", keys(COMMAND, Key::O), "Opens a document.", |_| Action::Open, always),
    command("File", "Save", keys(COMMAND, Key::S), "Writes the document.", |_| Action::Save, always),
    command("File", "Save as …", keys(SHIFTED, Key::S), "Writes it to another file.", |_| Action::SaveAs, always),
    command(
        "File",
        "Reload",
        None,
        "Reads the file again; undo takes that back.",
        |_| Action::Reload,
        |state| state.session.file().is_some(),
    ),
    command(
        "File",
        "Render range",
        keys(COMMAND, Key::R),
        "Writes the outputs of all frames in the range to their files.",
        |_| Action::Render,
        |state| state.render.is_none() && state.session.meaning().graph.is_some(),
    ),
    command(
        "File",
        "Stop rendering",
        None,
        "Stops after the present frame.",
        |_| Action::CancelRender,
        |state| state.render.is_some(),
    ),
    command(
        "File",
        "Allowed folders …",
        None,
        "Shows which folders documents were allowed besides their own, to take them back.",
        |_| Action::ShowAllowed,
        always,
    ),
    command("File", "Quit", keys(COMMAND, Key::Q), "Closes the window.", |_| Action::Quit, always),
    command(
        "Edit",
        "Undo",
        keys(COMMAND, Key::Z),
        "Takes back the last change.",
        |_| Action::Undo,
        |state| state.session.history().undoes().is_some(),
    ),
    command(
        "Edit",
        "Redo",
        keys(SHIFTED, Key::Z),
        "Makes it again.",
        |_| Action::Redo,
        |state| state.session.history().redoes().is_some(),
    ),
    command("Edit", "Cut", keys(COMMAND, Key::X), "Copies the chosen nodes and deletes them.", |_| Action::Cut, chosen),
    command("Edit", "Copy", keys(COMMAND, Key::C), "Copies the chosen nodes as text.", |_| Action::Copy, chosen),
    command("Edit", "Paste", keys(COMMAND, Key::V), "Adds the nodes that were copied.", |_| Action::AskPaste, always),
    command(
        "Edit",
        "Duplicate",
        keys(COMMAND, Key::D),
        "Copies the chosen nodes beside themselves.",
        |_| Action::Duplicate,
        chosen,
    ),
    command(
        "Edit",
        "Delete",
        keys(NONE, Key::Delete),
        "Deletes the chosen nodes; wires are led past them.",
        |_| Action::Delete,
        chosen,
    ),
    command("Edit", "Select all", keys(COMMAND, Key::A), "Chooses all nodes.", |_| Action::SelectAll, always),
    command(
        "Edit",
        "Command palette",
        keys(SHIFTED, Key::P),
        "Finds a command by its name.",
        |_| Action::Palette,
        always,
    ),
    command(
        "Graph",
        "Add node",
        keys(NONE, Key::Tab),
        "Finds a node by its name and adds it.",
        |_| Action::AddNode,
        always,
    ),
    command(
        "Graph",
        "Make output",
        None,
        "Renders what the chosen node makes, to a file.",
        |_| Action::MakeOutput,
        one,
    ),
    command(
        "Graph",
        "Replace with …",
        None,
        "Makes the chosen node one of another type, with the same connections.",
        |_| Action::Replace,
        one,
    ),
    command(
        "Graph",
        "Extract",
        None,
        "Leads wires past the chosen nodes, and leaves these unconnected.",
        |_| Action::Extract,
        chosen,
    ),
    command(
        "Graph",
        "Dot",
        keys(NONE, Key::Period),
        "Puts a dot on a wire of the chosen node, by which it can be led.",
        |_| Action::Dot,
        one,
    ),
    command(
        "Graph",
        "Disable",
        keys(NONE, Key::D),
        "Leads past the chosen nodes, or evaluates them again.",
        |_| Action::Disable,
        chosen,
    ),
    command(
        "Graph",
        "Arrange",
        keys(NONE, Key::L),
        "Lays the chosen nodes out anew, or all.",
        |_| Action::Arrange,
        always,
    ),
    command("Graph", "Align left", None, "Stands left edges in a column.", |_| Action::Line(Line::Left), several),
    command("Graph", "Align centers", None, "Stands centers in a column.", |_| Action::Line(Line::Centers), several),
    command("Graph", "Align top", None, "Stands upper edges in a row.", |_| Action::Line(Line::Top), several),
    command(
        "Graph",
        "Distribute",
        None,
        "Sets the chosen nodes at equal distances, along the longer side.",
        |_| Action::Line(Line::Distances),
        several,
    ),
    command(
        "Graph",
        "Backdrop",
        keys(Modifiers::SHIFT, Key::B),
        "Puts a titled area behind the chosen nodes.",
        |_| Action::Backdrop,
        always,
    ),
    command(
        "Graph",
        "Name backdrop",
        None,
        "Writes on the backdrop behind the chosen nodes, or on the only one.",
        |_| Action::WriteBackdrop,
        |state| !state.sheet().backdrops.is_empty(),
    ),
    command("Graph", "Note", None, "Puts a note into the graph.", |_| Action::Note, always),
    command("Graph", "Frame", keys(NONE, Key::F), "Shows the chosen nodes, or all.", |_| Action::Frames, always),
    command(
        "Viewer",
        "Look at node",
        None,
        "Shows the chosen node, as a double-click on it does.",
        |state| match state.chosen() {
            Some(name) => Action::Look(name.into(), 0),
            None => Action::Output(state.output.clone()),
        },
        one,
    ),
    command(
        "Viewer",
        "Play",
        Some(PLAY),
        "Plays the range in real time, or stops.",
        |state| Action::Play(!state.playing),
        always,
    ),
    command(
        "Viewer",
        "Next frame",
        keys(NONE, Key::ArrowRight),
        "Goes to the next frame.",
        |state| Action::Frame(state.frame + 1),
        always,
    ),
    command(
        "Viewer",
        "Previous frame",
        keys(NONE, Key::ArrowLeft),
        "Goes to the frame before.",
        |state| Action::Frame(state.frame - 1),
        always,
    ),
    command(
        "Viewer",
        "First frame",
        keys(NONE, Key::Home),
        "Goes to the range's first frame.",
        |state| Action::Frame(state.range.0),
        always,
    ),
    command(
        "Viewer",
        "Last frame",
        keys(NONE, Key::End),
        "Goes to the range's last frame.",
        |state| Action::Frame(state.range.1),
        always,
    ),
    command(
        "Viewer",
        "Range from here",
        keys(NONE, Key::I),
        "Lets the range begin at this frame.",
        |state| Action::Range(state.frame, state.range.1.max(state.frame)),
        always,
    ),
    command(
        "Viewer",
        "Range to here",
        keys(NONE, Key::O),
        "Lets the range end at this frame.",
        |state| Action::Range(state.range.0.min(state.frame), state.frame),
        always,
    ),
    command("Viewer", "Full size", None, "Evaluates every pixel.", |_| Action::Proxy(1), always),
    command("Viewer", "Half size", None, "Evaluates a quarter of the pixels.", |_| Action::Proxy(2), always),
    command("Viewer", "Quarter size", None, "Evaluates a sixteenth of the pixels.", |_| Action::Proxy(4), always),
    command(
        "Viewer",
        "Hold A",
        None,
        "Holds the present picture, to compare others with it.",
        |_| Action::Viewer(Switch::Hold),
        seen,
    ),
    command("Viewer", "Let go of A", None, "Compares with nothing any more.", |_| Action::Viewer(Switch::LetGo), seen),
    command(
        "Viewer",
        "Wipe",
        None,
        "Shows A at the left of a line, the present picture at its right.",
        |_| Action::Viewer(Switch::Wipe),
        seen,
    ),
    command(
        "Viewer",
        "Difference",
        None,
        "Shows by how much the present picture differs from A.",
        |_| Action::Viewer(Switch::Difference),
        seen,
    ),
    command(
        "Viewer",
        "Region",
        None,
        "Evaluates a part only, which the next drag in the picture frames.",
        |_| Action::Viewer(Switch::Region),
        seen,
    ),
    command(
        "Viewer",
        "Hull",
        None,
        "Shows the picture's colors within the hull of its control colors, or the picture again (H).",
        |_| Action::Viewer(Switch::Hull),
        seen,
    ),
    command(
        "Viewer",
        "Near",
        None,
        "Marks pixels near the hull's faces, or no longer (N).",
        |_| Action::Viewer(Switch::Near),
        seen,
    ),
    command(
        "Viewer",
        "Whole picture",
        keys(Modifiers::SHIFT, Key::W),
        "Evaluates all of it, not just a part.",
        |_| Action::Region(None),
        |state| state.look.region.is_some(),
    ),
    command("Window", "Show viewer", None, "Shows the picture.", |_| Action::Panel(Pane::Viewer), always),
    command("Window", "Show graph", None, "Shows the graph.", |_| Action::Panel(Pane::Canvas), always),
    command(
        "Window",
        "Show properties",
        None,
        "Shows knobs and connections.",
        |_| Action::Panel(Pane::Properties),
        always,
    ),
    command("Window", "Show waves", None, "Shows the chosen sea as waves.", |_| Action::Panel(Pane::Waves), always),
    command(
        "Window",
        "Show report",
        None,
        "Shows times, and what is left out.",
        |_| Action::Panel(Pane::Report),
        always,
    ),
    command("Window", "Show text", None, "Shows the document's text.", |_| Action::Panel(Pane::Text), always),
    command("Window", "Reset panels", None, "Arranges the panels as at first.", |_| Action::ResetPanels, always),
    command("Window", "Dark or light", None, "Changes the colors of the interface.", |_| Action::Theme, always),
];

/// What was asked for by keys. Those without Ctrl count only where nothing is being typed.
pub fn pressed(context: &egui::Context, state: &State, actions: &mut Vec<Action>) {
    let typing = context.egui_wants_keyboard_input();
    let mut commands: Vec<&Command> = COMMANDS.iter().collect();
    // Those with Shift first: without it, a shortcut is taken to match with it as well.
    commands.sort_by_key(|command| command.keys.is_some_and(|keys| !keys.modifiers.shift));
    for command in commands {
        let Some(keys) = command.keys else { continue };
        // Copying and cutting arrive as events of their own.
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
