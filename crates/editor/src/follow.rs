//! Links by dragging: a knob that is held by its name, and what may follow it. The panel where it is dropped makes the link.

use crate::document::change::style;
use crate::document::{Edit, Op, Path, Step, spoken};
use egui::{Area, Context, DragAndDrop, Frame, Id, Order, Response, RichText, Sense, vec2};
use std::sync::Arc;
use trochoid::{Item, KnobType};

/// A knob that is held by its name.
#[derive(Clone, Debug)]
pub(crate) struct HeldKnob {
    /// Its place.
    pub(crate) path: Path,
    /// The link that follows it, such as `= hull.x`.
    pub(crate) link: String,
    item: Item,
}

/// What the values of a knob or of a constant are, as far as links care.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sort {
    Number,
    Bool,
    Word,
    Color,
    Vector(usize),
    Numbers,
    Texts,
    None,
}

fn sort(item: &Item) -> Sort {
    match item {
        Item::Knob(knob) => match knob.takes {
            KnobType::Number { .. } | KnobType::Integer { .. } => Sort::Number,
            KnobType::Bool => Sort::Bool,
            KnobType::Choice(_) | KnobType::Text | KnobType::Path => Sort::Word,
            KnobType::Color => Sort::Color,
            KnobType::Vector(count) => Sort::Vector(count),
            KnobType::Numbers { .. } => Sort::Numbers,
            KnobType::Texts { .. } => Sort::Texts,
        },
        Item::Port(port) if port.accepts.takes_color() => Sort::Color,
        Item::Port(port) if port.accepts.takes_number() => Sort::Number,
        Item::Port(_) | Item::List(_) => Sort::None,
    }
}

impl HeldKnob {
    /// Returns a knob at a place of the sheet; `None` if links have no name for it, as for those in lists.
    pub(crate) fn of(path: &Path, item: &Item) -> Option<Self> {
        let link = match path.0.as_slice() {
            [Step::Key(nodes), Step::Key(node), Step::Key(knob)] if nodes == "nodes" => format!("= {node}.{knob}"),
            [Step::Key(groups), _, Step::Key(knobs), Step::Key(knob), ..] if groups == "groups" && knobs == "knobs" => {
                format!("= knobs.{knob}")
            }
            _ => return None,
        };
        Some(Self { path: path.clone(), link, item: *item })
    }

    /// Returns the knob that the pointer holds, also in the frame in which it lets go.
    pub(crate) fn held(context: &Context) -> Option<Arc<Self>> {
        DragAndDrop::payload(context)
    }

    /// Returns whether a knob or a constant can follow this one, judged by the sort of value alone.
    pub(crate) fn fits(&self, item: &Item) -> bool {
        match (sort(&self.item), sort(item)) {
            (Sort::None, _) | (_, Sort::None) => false,
            // A number in the place of a color is its gray.
            (Sort::Number, Sort::Color) => matches!(item, Item::Port(port) if port.accepts.takes_number()),
            (own, other) => own == other,
        }
    }

    /// Returns whether the components of a knob can follow this one.
    pub(crate) fn fits_components(&self, item: &Item) -> bool {
        sort(&self.item) == Sort::Number && matches!(sort(item), Sort::Vector(_))
    }

    /// Returns the edit with which values follow this knob.
    pub(crate) fn followed_by<'p>(&self, places: impl IntoIterator<Item = &'p Path>) -> Edit {
        let link = style(&self.link.clone().into());
        let ops: Vec<Op> = places.into_iter().map(|place| Op::Set(place.clone(), link.clone())).collect();
        let what = ops.first().map_or_else(String::new, |op| spoken(op.path()));
        Edit::new(format!("Link {what}"), ops)
    }
}

/// Lets a name be dragged as its knob.
pub(crate) fn source_ui(name: &Response, path: &Path, item: &Item) {
    // Names take no focus: Tab goes from value to value.
    let name = name.interact(Sense::CLICK | Sense::DRAG);
    if name.drag_started_by(egui::PointerButton::Primary)
        && let Some(held) = HeldKnob::of(path, item)
    {
        name.dnd_set_drag_payload(held);
    }
}

/// Shows what is held beside the pointer.
pub(crate) fn held_ui(context: &Context) {
    let Some((held, at)) = HeldKnob::held(context).zip(context.pointer_latest_pos()) else { return };
    let area = Area::new(Id::new("held knob")).order(Order::Tooltip).interactable(false);
    area.fixed_pos(at + vec2(14.0, 10.0)).show(context, |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.label(RichText::new(&held.link).monospace());
            ui.weak("Drop it on a knob, or on a node of the graph");
        });
    });
}
