//! Finds faults of input files before anything is prepared.

use crate::{EvalError, Plan};
use trochoid_graph::{Handle, NodeId, Pool, Prepare, Stage};

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
        let (pool, cancelled) = (Pool::new(), || false);
        let handles = |id: NodeId| self.handle_alone(id);
        let notes = |(id, wanted): &(NodeId, Vec<Vec<bool>>)| {
            let kinds = &self.graph.node(*id).kinds;
            let prepare = Prepare::new(&self.context, kinds, wanted, &handles, &cancelled, &pool);
            Some((*id, self.readable(*id)?.file_notes(&prepare)))
        };
        self.prepares.iter().filter_map(notes).filter(|(_, notes)| !notes.is_empty()).collect()
    }

    /// Returns the handle of a node that needs neither files nor other nodes.
    fn handle_alone(&self, id: NodeId) -> Option<Handle> {
        let stage = self.readable(id)?;
        let mut needed = Vec::new();
        self.graph.node(id).record.each_node(|node| needed.push(node));
        if !needed.is_empty() || !stage.files(&self.context).is_empty() {
            return None;
        }
        let kinds = &self.graph.node(id).kinds;
        let (pool, cancelled, none) = (Pool::new(), || false, |_: NodeId| None);
        let prepare = Prepare::new(&self.context, kinds, &[], &none, &cancelled, &pool);
        stage.prepare(&prepare).ok()?.handle()
    }

    /// Returns a stage whose files exist and may be read.
    fn readable(&self, id: NodeId) -> Option<&dyn Stage> {
        let stage = self.stage(id)?;
        let is_there = stage.files(&self.context).iter().all(|file| file.exists());
        (is_there && self.graph.refused(id, &self.context).is_none()).then_some(stage)
    }
}
