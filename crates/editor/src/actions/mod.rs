//! Actions that panels and commands request, and the plain types they carry. The editor performs them, so no panel
//! depends on another; nothing in this module depends on a panel.

mod after;
mod color;
mod grant;
mod help;
mod layout;
mod line;
mod pane;

pub use after::After;
pub use color::{OtherPalette, Tint};
pub use grant::Grant;
pub use help::HelpPage;
pub use layout::Layout;
pub use line::Line;
pub use pane::Pane;

use crate::document::find::Target;
use crate::document::swatches::SwatchKey;
use crate::document::{Edit, Path, Point};
use crate::evaluate::Display;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

/// Request to the editor.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Change the document; inside of a group, its nodes.
    Edit(Edit),
    /// Change the document as a whole, whatever group is entered.
    Whole(Edit),
    /// Change a value of the document; if the document rejects the value, this field shows the reason.
    Give(Edit, egui::Id),
    /// End the gesture: the next change becomes an undo step of its own.
    Seal,
    /// Take back what the present gesture has changed.
    TakeBack,
    /// Replace the document's text.
    Rewrite(String),
    /// Undo the last change.
    Undo,
    /// Redo the last undone change.
    Redo,
    /// Change the document's wires; nodes keep the places where they are drawn.
    Rewire(Edit),
    /// Select exactly these nodes.
    Select(BTreeSet<String>),
    /// Select only the node of this name in the expanded document, and bring it into view in the graph.
    Visit(String),
    /// Ask what to find in the document.
    Find,
    /// Go to a place in the document: select it, bring it into view, and show its properties.
    GoTo(Target),
    /// Show the inside of a use of a group: names of uses from the outermost one; none of them is the document itself.
    Enter(Vec<String>),
    /// Make a group of the selected nodes.
    Group,
    /// Put the nodes of the selected use in its place.
    Unpack,
    /// Copy the group that is entered, or that the selected node uses, from an included file into the document.
    MakeLocal,
    /// Make the value at this place a knob of the group that is entered, or else of the document.
    Promote(Path),
    /// View an output of the node of this name in the expanded document.
    Look(String, usize),
    /// View the node assigned to a number key (slot 0 is key 1, slot 8 is key 9); if a node is selected, assign it to
    /// the key first.
    Slot(usize),
    /// Change how the viewer displays values.
    Display(Display),
    /// Divide the viewer's resolution by this factor.
    Proxy(u32),
    /// Evaluate only this region, in fractions of the picture; `None` means the whole picture.
    Region(Option<[f32; 4]>),
    /// Inspect the pixel here, in fractions of the picture.
    Pick(Option<[f32; 2]>),
    /// The pointer is over this pixel, in fractions of the picture.
    Hover(Option<[f32; 2]>),
    /// Send the next color clicked in the picture to this place in the document.
    Dropper(Option<Path>),
    /// Keep the recipe of the viewed picture at hand: colors are being looked at.
    Weigh,
    /// Select a color of the document, or none.
    Swatch(Option<SwatchKey>),
    /// Show a color that is being dragged; `None` cancels the drag.
    Tint(Option<Tint>),
    /// End the drag of a color by this edit.
    SettleTint(Edit),
    /// Show where the selected color is in the picture.
    Spot(bool),
    /// Show the picture in another palette, or in the document's.
    ComparePalette(Option<Arc<OtherPalette>>),
    /// Add a gray to the palette.
    AddColor,
    /// Replace colors of the palette by those of the same names in a file of this name.
    TakePalette(Vec<(String, serde_json::Value)>, String),
    /// Take all colors of a file into the palette.
    JoinPalette(Vec<(String, serde_json::Value)>),
    /// Give all colors of the document names.
    NameColors,
    /// Write the palette that the document reads from a file into the document.
    BringPalette,
    /// Go to a frame.
    Frame(i64),
    /// Start or stop playback.
    Play(bool),
    /// Mix the frames beside the current one over it, or not.
    Onion(bool),
    /// Set the first and last frame to play and render.
    Range(i64, i64),
    /// Start a new document.
    New,
    /// Start a new document from the template of this name.
    Template(&'static str),
    /// Show templates and recent documents.
    Welcome,
    /// Remove a document from the list of recent ones.
    ForgetRecent(PathBuf),
    /// Ask which document to open.
    Open,
    /// Open this document.
    OpenFile(PathBuf),
    /// Save the document.
    Save,
    /// Ask where to save.
    SaveAs,
    /// Reload the document from its file.
    Reload,
    /// Copy the selected nodes to the clipboard as text.
    Copy,
    /// Copy the selected nodes, then delete them.
    Cut,
    /// Paste this text at a point of the canvas.
    Paste(String, Point),
    /// Request the clipboard's text from the system and paste it in the middle of the graph.
    AskPaste,
    /// Duplicate the selected nodes next to the originals.
    Duplicate,
    /// Delete the selected nodes.
    Delete,
    /// Disable or enable the selected nodes.
    Disable,
    /// Select all nodes.
    SelectAll,
    /// Lay out the selected nodes, or all nodes.
    Arrange,
    /// Align or distribute the selected nodes.
    Line(Line),
    /// Ask for another type for the selected node.
    Replace,
    /// Connect wires past the selected nodes and leave the nodes unconnected.
    Extract,
    /// Add a dot to a wire of the selected node.
    Dot,
    /// Add an output that renders the selected node.
    MakeOutput,
    /// Select this output, or none.
    Output(Option<String>),
    /// Add a backdrop behind the selected nodes.
    Backdrop,
    /// Edit the text of the backdrop behind the selected nodes, or of the only backdrop.
    WriteBackdrop,
    /// Add a note to the graph.
    Note,
    /// Frame the selected nodes, or all nodes.
    Frames,
    /// Ask which node to add.
    AddNode,
    /// Add a node of this type, connected to the selected one.
    AddType(String),
    /// Show a page of the help.
    Help(HelpPage),
    /// Render the outputs of all frames in the range to their files.
    Render,
    /// Stop rendering.
    CancelRender,
    /// Allow this document to read or write in a folder and everything below it.
    Allow(Grant),
    /// Show the folders that documents may access.
    ShowAllowed,
    /// Revoke a permission of the named document, or of the open document if none is named.
    Forbid(Option<PathBuf>, Grant),
    /// Open the command palette.
    Palette,
    /// Show a panel, or bring it to the front.
    Panel(Pane),
    /// Switch something in the viewer.
    Viewer(Switch),
    /// Do this in the second viewer.
    Second(Box<Self>),
    /// Arrange the panels.
    Layout(Layout),
    /// Arrange the panels as the user kept them under a name.
    OwnLayout(String),
    /// Ask for a name under which the layout is kept.
    NameLayout,
    /// Keep the layout under a name.
    KeepLayout(String),
    /// Delete a layout that the user kept.
    ForgetLayout(String),
    /// Ask for a name under which the knobs of the selected node are kept.
    NamePreset,
    /// Keep the knobs of the selected node under a name.
    KeepPreset(String),
    /// Give the selected nodes the knobs of a preset of their type.
    Preset(String),
    /// Delete a preset of a type.
    ForgetPreset(String, String),
    /// Switch between the dark and the light theme.
    Theme,
    /// Show the user a notice.
    Notice(String),
    /// Close the window.
    Quit,
}

impl Action {
    /// Returns whether pending text in fields must be committed before this action.
    pub(crate) fn needs_all(&self) -> bool {
        matches!(self, Self::Save | Self::SaveAs | Self::Render | Self::Preset(_)) || self.hides()
    }

    /// Returns whether this action is about what a viewer shows.
    pub(crate) fn is_of_viewer(&self) -> bool {
        matches!(
            self,
            Self::Look(..)
                | Self::Slot(_)
                | Self::Display(_)
                | Self::Proxy(_)
                | Self::Region(_)
                | Self::Pick(_)
                | Self::Onion(_)
                | Self::Viewer(_)
        )
    }

    /// Returns whether this action removes fields from the screen, together with any refusals shown for them.
    pub(crate) fn hides(&self) -> bool {
        matches!(
            self,
            Self::Select(_)
                | Self::Enter(_)
                | Self::Output(_)
                | Self::Visit(_)
                | Self::GoTo(_)
                | Self::New
                | Self::Template(_)
                | Self::Open
                | Self::OpenFile(_)
                | Self::Quit
        )
    }
}

/// Viewer setting that a command switches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switch {
    /// Hold the current picture as A, to compare others with it.
    Hold,
    /// Release A.
    LetGo,
    /// Compare with A across a movable wipe line.
    Wipe,
    /// Show the difference from A.
    Difference,
    /// Draw a region of interest with the next drag in the picture.
    Region,
    /// Switch between the picture and its colors inside the convex hull of the controls.
    Hull,
    /// Toggle the overlay that marks pixels near the hull's faces.
    Near,
    /// Let the mouse move the camera of the picture, or the picture.
    Orbit,
    /// Toggle histogram, waveform and vectorscope.
    Scopes,
}
