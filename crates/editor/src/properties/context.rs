//! Context shared by the widgets of the properties panel.

use crate::actions::Action;
use crate::document::change::style;
use crate::document::{Edit, Op, Path, edit};
use crate::evaluate::Screen;
use crate::field::Gesture;
use crate::prose::explained;
use crate::state::State;
use egui::{Align, Response, RichText, Stroke, StrokeKind, Ui};
use serde_json::Value;
use std::collections::HashSet;

/// State of the panel that no other panel shares.
#[derive(Default)]
pub(crate) struct Properties {
    /// Paths whose curves are shown.
    pub(super) curves: HashSet<Path>,
    /// Reference painting to pick colors from.
    pub(crate) reference: Option<(String, Screen)>,
    pub(super) texture: Option<egui::TextureHandle>,
    pub(super) dialog: Option<egui_file_dialog::FileDialog>,
    /// The open dialog that chooses the file of a knob.
    pub(super) choosing: Option<super::file::Choosing>,
    /// Value that is being linked, before it has a link.
    pub(super) linking: Option<Linking>,
    /// Declarations of the document's knobs, at a revision.
    pub(super) document_knobs: Option<(u64, &'static [trochoid::Item])>,
    sought: Option<Sought>,
}

/// A value for which a link is being typed.
pub(super) struct Linking {
    pub(super) path: Path,
    /// What was typed before its field was there.
    pub(super) typed: Option<String>,
}

/// A value that was gone to: it is brought into view, and marked for a while.
struct Sought {
    path: Path,
    /// Time at which the panel was first drawn since.
    since: Option<f64>,
}

/// Seconds for which lists open and the panel scrolls to the sought value, and for which it is marked.
const SCROLLS: f64 = 0.4;
const MARKED: f64 = 2.5;

impl Properties {
    /// Brings a value into view when the panel is drawn.
    pub(crate) fn seek(&mut self, path: Path) {
        self.sought = Some(Sought { path, since: None });
    }

    /// Returns whether a link is being typed for a value.
    pub(super) fn links(&self, path: &Path) -> bool {
        self.linking.as_ref().is_some_and(|linking| linking.path == *path)
    }

    /// Starts the time of the sought value, and ends it.
    pub(super) fn pass(&mut self, ui: &Ui) {
        let now = ui.input(|input| input.time);
        if let Some(sought) = &mut self.sought {
            let since = *sought.since.get_or_insert(now);
            ui.ctx().request_repaint();
            if now - since > MARKED {
                self.sought = None;
            }
        }
    }

    /// Returns whether a list must be open: the sought value is in it.
    pub(super) fn opens(&self, ui: &Ui, list: &Path) -> Option<bool> {
        let sought = self.sought.as_ref().filter(|sought| sought.path.0.starts_with(&list.0))?;
        let age = ui.input(|input| input.time) - sought.since?;
        (age <= SCROLLS).then_some(true)
    }

    /// Marks the label of a value if it is sought.
    pub(super) fn mark(&self, ui: &Ui, path: &Path, label: &Response) {
        let Some(sought) = self.sought.as_ref().filter(|sought| sought.path == *path) else { return };
        let Some(since) = sought.since else { return };
        if ui.input(|input| input.time) - since <= SCROLLS {
            label.scroll_to_me(Some(Align::Center));
        }
        let stroke = Stroke::new(1.5, ui.visuals().warn_fg_color);
        ui.painter().rect_stroke(label.rect.expand2(egui::vec2(3.0, 1.0)), 3.0, stroke, StrokeKind::Outside);
    }
}

/// Path and value that a widget edits.
pub(super) struct WidgetContext<'p> {
    pub(super) state: &'p State,
    pub(super) path: Path,
    /// Value in the document.
    pub(super) value: Option<&'p Value>,
    /// The same knob of other selected nodes, which is changed together with this one.
    pub(super) also: Vec<Path>,
}

impl<'p> WidgetContext<'p> {
    /// Returns the context of a value.
    pub(super) fn new(state: &'p State, path: Path, value: Option<&'p Value>) -> Self {
        Self { state, path, value, also: Vec::new() }
    }

    /// Returns all places that are changed together.
    pub(super) fn places(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(&self.path).chain(&self.also)
    }

    /// Creates an edit that sets the value; edits during one gesture merge into one undo step.
    pub(super) fn set(&self, value: &Value) -> Edit {
        self.set_each(|_| value.clone())
    }

    /// Creates an edit that sets each place to a value of its own.
    pub(super) fn set_each(&self, value: impl Fn(&Path) -> Value) -> Edit {
        let ops = self.places().map(|path| Op::Set(path.clone(), style(&value(path)))).collect();
        Edit::new(self.label("Set"), ops).merging(self.path.to_string())
    }

    /// Requests a reset to the default.
    pub(super) fn reset(&self, gesture: Gesture, actions: &mut Vec<Action>) {
        let set = self.places().filter(|path| self.state.sheet().get(path).is_some());
        let ops: Vec<Op> = set.map(|path| Op::Remove(path.clone())).collect();
        if !ops.is_empty() {
            gesture.edit(Edit::new(self.label("Reset"), ops), actions);
        }
    }

    /// Returns the label of an edit: `Set storm.height`, `Set height of 3 nodes`.
    fn label(&self, what: &str) -> String {
        match (self.also.len(), self.path.0.last()) {
            (1.., Some(crate::document::Step::Key(knob))) => {
                format!("{what} {knob} of {}", edit::count(self.also.len() + 1, "node"))
            }
            _ => format!("{what} {}", crate::document::spoken(&self.path)),
        }
    }
}

/// Draws a label with a tooltip.
pub(super) fn label_ui(ui: &mut Ui, name: &str, help: &str, set: bool) -> egui::Response {
    let text = name.replace('_', " ");
    let text = if set { RichText::new(text).strong() } else { RichText::new(text) };
    // In a narrow panel, the value gets more of the width.
    let width = (0.4 * ui.available_size_before_wrap().x).clamp(56.0, 96.0);
    let size = egui::vec2(width, ui.spacing().interact_size.y);
    let label = ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
        ui.set_min_width(width);
        // A drag of the name holds the knob, and selects no text. Tab goes from value to value.
        ui.add(egui::Label::new(text).truncate().selectable(false).sense(egui::Sense::CLICK))
    });
    explained(label.inner, help)
}
