//! Finds the ports that take the values of a document's knobs.

use super::{Checker, FaultLocation};
use crate::{DocumentKnob, NodeId};

/// Port that takes the value of a knob as it is.
pub(super) struct KnobUse {
    /// Offset of the knob's value.
    offset: usize,
    node: String,
    item: String,
}

impl Checker<'_> {
    /// Records a port's value that links have brought there from a knob of the document.
    pub(super) fn linked_port(&mut self, offset: usize, place: FaultLocation<'_>) {
        if self.expanded.knobs.iter().any(|knob| knob.offset == offset)
            && let Some((node, item)) = self.item_at(place)
        {
            self.knob_uses.push(KnobUse { offset, node, item });
        }
    }

    /// Returns the document's knobs with the ports that take them.
    pub(super) fn document_knobs(&mut self, find: &dyn Fn(&str) -> Option<NodeId>) -> Vec<DocumentKnob> {
        let uses = std::mem::take(&mut self.knob_uses);
        let all = &self.expanded.knobs;
        let knob = |knob: &crate::expand::LinkedKnob| {
            let is_only = all.iter().filter(|other| other.offset == knob.offset).count() == 1;
            let taking: Vec<&KnobUse> = uses.iter().filter(|used| used.offset == knob.offset).collect();
            let ports = taking.iter().filter_map(|used| Some((find(&used.node)?, used.item.clone()))).collect();
            DocumentKnob { name: knob.name.clone(), ports, is_whole: is_only && taking.len() == knob.taken }
        };
        all.iter().map(knob).collect()
    }
}
