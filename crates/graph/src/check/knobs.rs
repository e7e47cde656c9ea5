//! Finds the ports that take the values of a document's knobs.

use super::{Checker, FaultLocation};
use crate::expand::LinkedKnob;
use crate::{DocumentKnob, DocumentPlace, NodeId};
use std::collections::HashMap;

/// Port that takes the value of a knob as it is.
pub(super) struct KnobUse {
    node: String,
    item: String,
}

/// The knobs whose value stands at an offset, and what takes it.
#[derive(Default)]
pub(super) struct KnobValue {
    knobs: usize,
    uses: Vec<KnobUse>,
}

/// Returns the places of the values of knobs.
pub(super) fn values(knobs: &[LinkedKnob]) -> HashMap<usize, KnobValue> {
    let mut values: HashMap<usize, KnobValue> = HashMap::new();
    knobs.iter().for_each(|knob| values.entry(knob.offset).or_default().knobs += 1);
    values
}

impl Checker<'_> {
    /// Records a port's value that links have brought there from a knob of the document.
    pub(super) fn linked_port(&mut self, offset: usize, place: FaultLocation<'_>) {
        if !self.knob_values.contains_key(&offset) {
            return;
        }
        let used = self.item_at(place).map(|(node, item)| KnobUse { node, item });
        if let Some(value) = self.knob_values.get_mut(&offset) {
            value.uses.extend(used);
        }
    }

    /// Returns the document's knobs with the ports that take them.
    pub(super) fn document_knobs(&self, find: &dyn Fn(&str) -> Option<NodeId>) -> Vec<DocumentKnob> {
        let knob = |knob: &LinkedKnob| {
            let value = &self.knob_values[&knob.offset];
            let ports = value.uses.iter().filter_map(|used| Some((find(&used.node)?, used.item.clone()))).collect();
            let origin = self.document.origin(knob.offset);
            DocumentKnob {
                name: knob.name.clone(),
                place: DocumentPlace { document: origin.file, line: origin.line, column: origin.column },
                ports,
                is_used: knob.taken > 0,
                is_whole: value.knobs == 1 && value.uses.len() == knob.taken,
            }
        };
        self.expanded.knobs.iter().map(knob).collect()
    }
}
