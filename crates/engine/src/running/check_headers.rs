//! Finds faults of input files before anything is prepared.

use crate::{EvalError, Plan};
use trochoid_graph::{NodeId, Stage};

impl Plan<'_> {
    /// Returns what is wrong with the files that the plan reads, as far as their headers show: the errors with which
    /// an evaluation would fail, for all nodes at once. Decodes no pixels.
    ///
    /// Skips files that do not exist, since they may still be made, and files that the document may not reach.
    pub fn check_headers(&self) -> Vec<EvalError> {
        let fault = |(id, wanted): &(_, Vec<Vec<bool>>)| {
            let stage = self.readable(*id)?;
            let error = stage.check_headers(&self.context, wanted).err()?;
            Some(EvalError::of(self.graph, *id, error))
        };
        self.prepares.iter().filter_map(fault).collect()
    }

    /// Returns remarks about the files that the plan reads, as sentences; skips the same files.
    pub fn file_notes(&self) -> Vec<(NodeId, Vec<String>)> {
        let notes = |(id, _): &(NodeId, _)| Some((*id, self.readable(*id)?.file_notes(&self.context)));
        self.prepares.iter().filter_map(notes).filter(|(_, notes)| !notes.is_empty()).collect()
    }

    /// Returns a stage whose files exist and may be read.
    fn readable(&self, id: NodeId) -> Option<&dyn Stage> {
        let stage = self.stage(id)?;
        let is_there = stage.files(&self.context).iter().all(|file| file.exists());
        (is_there && self.graph.refused(id, &self.context).is_none()).then_some(stage)
    }
}
