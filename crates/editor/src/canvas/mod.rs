//! The graph: nodes, wires, and what is done to them by hand.

use crate::actions::Action;
use crate::document::{Edit, Point, Sheet};
use crate::state::State;
use egui::Ui;
use std::collections::BTreeSet;

/// What the canvas holds besides what all see.
#[derive(Default)]
pub struct Canvas {}

impl Canvas {
    /// Forgets what is under the pointer: it may be gone.
    pub fn forget_cursor(&mut self) {}

    /// Shows the chosen nodes, or all, when it is drawn next.
    pub fn frame(&mut self) {}

    /// Asks for a node to add, when it is drawn next.
    pub fn search(&mut self) {}
}

/// Places for nodes, laid out in layers: of the chosen ones, or of all where fewer than two are chosen.
pub fn arrange(_sheet: &Sheet, _chosen: &BTreeSet<String>) -> Vec<(String, Point)> {
    Vec::new()
}

/// A backdrop behind the chosen nodes; `None` where none is chosen.
pub fn backdrop(_sheet: &Sheet, _chosen: &BTreeSet<String>) -> Option<Edit> {
    None
}

/// Draws the graph.
pub fn canvas_ui(_canvas: &mut Canvas, ui: &mut Ui, state: &State, _actions: &mut Vec<Action>) {
    for node in &state.sheet().nodes {
        ui.label(&node.name);
    }
}
