//! Knobs that are dropped on a node: a list of the node's knobs that can follow them.

use super::Canvas;
use super::connect::{NoWire, Refusal};
use super::menu::MenuTarget;
use super::plan::Plan;
use crate::actions::Action;
use crate::document::color::is_color;
use crate::document::link::is_link;
use crate::document::{Edit, Node, Path, Sheet, spoken};
use crate::follow::HeldKnob;
use crate::state::State;
use egui::{DragAndDrop, Stroke, StrokeKind, Ui};
use serde_json::Value;
use std::sync::Arc;
use trochoid::{Arity, Item};

/// A knob that was dropped on a node, and the values of the node that can follow it.
#[derive(Clone, Debug)]
pub(super) struct Dropped {
    held: Arc<HeldKnob>,
    node: String,
    targets: Vec<Path>,
}

impl Canvas {
    /// Marks the node under a held knob; when it is dropped there, opens the list of what can follow it.
    pub(super) fn follow_ui(&mut self, plan: &Plan, ui: &Ui, state: &State) {
        let Some(held) = HeldKnob::held(ui.ctx()) else { return };
        let at = ui.input(|input| input.pointer.latest_pos()).filter(|_| ui.rect_contains_pointer(self.view.rect));
        let Some(at) = at.map(|at| self.view.canvas(at)) else { return };
        let Some(index) = plan.boxes.iter().rposition(|own| own.contains(at)) else { return };
        let node = &plan.sheet.nodes[index];
        let targets = targets(state.sheet(), node, &held);
        let color = match targets.is_empty() {
            true => crate::theme::error(ui.visuals()),
            false => ui.visuals().selection.stroke.color,
        };
        let area = self.view.area(plan.boxes[index]).expand(3.0);
        ui.painter().rect_stroke(area, 6.0, Stroke::new(2.0, color), StrokeKind::Outside);
        if ui.input(|input| input.pointer.any_released()) {
            DragAndDrop::clear_payload(ui.ctx());
            self.open_menu(ui, MenuTarget::Follow(Dropped { held, node: node.name.clone(), targets }));
        }
    }

    /// Draws the list of what can follow a dropped knob.
    pub(super) fn follow_menu(&mut self, ui: &mut Ui, state: &State, dropped: &Dropped, actions: &mut Vec<Action>) {
        let Dropped { held, node, targets } = dropped;
        ui.weak(format!("{node} follows {}", held.link.trim_start_matches(['=', ' '])));
        ui.separator();
        if targets.is_empty() {
            ui.label("None of its knobs takes such a value.");
        }
        for target in targets {
            let whole = spoken(target);
            let name = whole.strip_prefix(node.as_str()).map_or(whole.as_str(), |name| name.trim_start_matches('.'));
            if !ui.button(name.replace('_', " ")).clicked() {
                continue;
            }
            let edit = held.followed_by([target]);
            match fault(state, &edit) {
                None => actions.extend([Action::Seal, Action::Edit(edit), Action::Seal]),
                Some(why) => {
                    let title = format!("{whole} cannot follow {}", held.link.trim_start_matches(['=', ' ']));
                    let at = ui.input(|input| input.pointer.latest_pos()).unwrap_or(self.view.rect.center());
                    self.refusal = Some((Refusal { title, why, bridge: None }, at));
                }
            }
        }
    }
}

/// Returns the fault that a link would add, anywhere: a circle of links is told where it is met first.
fn fault(state: &State, link: &Edit) -> Option<NoWire> {
    let after = match state.after(link) {
        Ok((after, _)) => after,
        Err(error) => return Some(error.into()),
    };
    let known: Vec<_> = state.session.meaning().errors().map(|old| (&old.node, &old.port, &old.found)).collect();
    let new = after.errors().find(|error| !known.contains(&(&error.node, &error.port, &error.found)));
    new.cloned().map(NoWire::Fault)
}

/// Returns the places of a node that can follow a knob, judged by the sort of value: knobs, their components, and constants
/// in the place of connections.
fn targets(sheet: &Sheet, node: &Node, held: &HeldKnob) -> Vec<Path> {
    let own = Path::node(&node.name);
    let mut found = Vec::new();
    for item in node.declaration.map_or(&[][..], |known| known.items) {
        let place = own.to(item.name());
        let written = sheet.get(&place);
        let is_free = match item {
            Item::Port(port) => {
                // What is connected stays so, and lists of connections have no constant as a whole.
                let is_wire = |value: &Value| value.as_str().is_some_and(|text| !is_color(text) && !is_link(text));
                !matches!(port.arity, Arity::Many { .. }) && !written.is_some_and(is_wire)
            }
            Item::Knob(_) => true,
            Item::List(_) => false,
        };
        if place == held.path || !is_free {
            continue;
        }
        if held.fits(item) {
            found.push(place);
        } else if let Some(Value::Array(components)) = written.filter(|_| held.fits_components(item)) {
            found.extend((0..components.len()).map(|index| place.to(index)));
        }
    }
    found
}
