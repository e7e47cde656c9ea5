//! What panels and commands ask for, and the plain words that it takes to say it. The editor does it, so that no panel knows
//! another; nothing here knows a panel.

mod after;
mod grant;
mod line;
mod pane;

pub use after::After;
pub use grant::Grant;
pub use line::Line;
pub use pane::Pane;

use crate::document::{Edit, Path, Point};
use crate::evaluate::Display;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Something to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Change the document.
    Edit(Edit),
    /// Change a value of the document, unless it does not bear it: then this field says why.
    Give(Edit, egui::Id),
    /// The gesture is over: the next change is a step of undo for itself.
    Seal,
    /// Replace the document's text.
    Rewrite(String),
    /// Take back the last change.
    Undo,
    /// Make it again.
    Redo,
    /// Change the document's wires; nodes stay where they are seen.
    Rewire(Edit),
    /// Choose these nodes and no others.
    Select(BTreeSet<String>),
    /// Choose this node and no other, and show it in the graph.
    Visit(String),
    /// Show an output of a node.
    Look(String, usize),
    /// Show what is under a key from 1 to 9; with a node chosen, put that there first.
    Slot(usize),
    /// Show values in this way.
    Display(Display),
    /// Make pictures so many times smaller.
    Proxy(u32),
    /// Evaluate just this part, in shares of the picture.
    Region(Option<[f32; 4]>),
    /// Inspect this pixel, in shares of the picture.
    Pick(Option<[f32; 2]>),
    /// Let the color that is clicked next in the picture go to this place of the document.
    Dropper(Option<Path>),
    /// Go to a frame.
    Frame(i64),
    /// Play, or stop.
    Play(bool),
    /// Play and render these frames.
    Range(i64, i64),
    /// A new document.
    New,
    /// Ask for a document to open.
    Open,
    /// Open this document.
    OpenFile(PathBuf),
    /// Save.
    Save,
    /// Ask where to save.
    SaveAs,
    /// Take what is in the file now.
    Reload,
    /// Copy the chosen nodes as text.
    Copy,
    /// Copy them and delete them.
    Cut,
    /// Add what was copied, at a point of the canvas.
    Paste(String, Point),
    /// Ask the system for what was copied, to be added in the middle of the graph.
    AskPaste,
    /// Copy the chosen nodes beside themselves.
    Duplicate,
    /// Delete the chosen nodes.
    Delete,
    /// Lead past the chosen nodes, or evaluate them again.
    Disable,
    /// Choose all nodes.
    SelectAll,
    /// Lay all nodes out anew, or the chosen ones.
    Arrange,
    /// Line the chosen nodes up.
    Line(Line),
    /// Ask for another type for the chosen node.
    Replace,
    /// Lead wires past the chosen nodes, which stay unconnected.
    Extract,
    /// Put a dot on a wire of the chosen node.
    Dot,
    /// Render what the chosen node makes.
    MakeOutput,
    /// Choose this output, or none.
    Output(Option<String>),
    /// Put a backdrop behind the chosen nodes.
    Backdrop,
    /// Write on the backdrop behind the chosen nodes, or on the only one.
    WriteBackdrop,
    /// Put a note into the graph.
    Note,
    /// Show all nodes, or the chosen ones.
    Frames,
    /// Ask for a node to add.
    AddNode,
    /// Write the outputs of the range to their files.
    Render,
    /// Stop that.
    CancelRender,
    /// Let this document read or write in a folder, with all beneath it.
    Allow(Grant),
    /// Show which folders documents were allowed.
    ShowAllowed,
    /// Take back what a document was allowed; the one that is open where none is named.
    Forbid(Option<PathBuf>, Grant),
    /// Open the command palette.
    Palette,
    /// Show a panel, or bring it to the front.
    Panel(Pane),
    /// Change what the viewer shows beside the picture.
    Viewer(Switch),
    /// Arrange panels as at first.
    ResetPanels,
    /// Dark, or light.
    Theme,
    /// Tell the user something.
    Notice(String),
    /// Close the window.
    Quit,
}

impl Action {
    /// Whether all that is typed must count before it is done.
    pub(crate) fn needs_all(&self) -> bool {
        matches!(self, Self::Save | Self::SaveAs | Self::Render) || self.hides()
    }

    /// Whether fields go with it, with all that is said of them.
    pub(crate) fn hides(&self) -> bool {
        matches!(
            self,
            Self::Select(_)
                | Self::Output(_)
                | Self::Visit(_)
                | Self::New
                | Self::Open
                | Self::OpenFile(_)
                | Self::Quit
        )
    }
}

/// What a command changes in the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switch {
    /// Hold the present picture, to compare others with it.
    Hold,
    /// Let go of it.
    LetGo,
    /// Compare by a line that is moved over the picture.
    Wipe,
    /// Show by how much the present picture differs.
    Difference,
    /// Frame a part of the picture by the next drag.
    Region,
    /// Show the colors within their hull, or the picture again.
    Hull,
    /// Mark pixels near the hull's faces, or no longer.
    Near,
}
